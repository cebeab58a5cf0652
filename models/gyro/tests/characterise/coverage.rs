//! Intervals that promise 95 % hold 95 %.

use crate::noise::{record, single};
use struna_gyro::characterise::CumulativeAngle;
use struna_gyro::characterise::{
    NoiseModel, Options, Term, Verdict, characterise, degrees_of_freedom, variance_interval,
};

const SEEDS: u64 = 200;
const SAMPLES: usize = 4096;
const CONFIDENCE: f64 = 0.95;
/// The promise, from the noise's own theory.
const PROMISED: std::ops::RangeInclusive<f64> = 0.93..=0.97;
/// Octaves from eight samples, where sampled noise is that of its formula, to a ninth.
const FACTORS: [usize; 6] = [8, 16, 32, 64, 128, 256];

/// Share of all intervals, over seeds and averaging times, that hold the true Allan variance.
fn coverage(term: Term) -> f64 {
    let model = single(term, 1.0);
    let (mut held, mut all) = (0.0, 0.0);
    for seed in 0..SEEDS {
        let record = record(&model, 1.0, SAMPLES, seed);
        let angle = CumulativeAngle::of(record.rates_rad_s(), record.mean_rad_s());
        for factor in FACTORS {
            let variance = angle.allan_variance(factor).expect("long enough");
            let edf = degrees_of_freedom(term, angle.points(), factor);
            let [low, high] = variance_interval(edf, CONFIDENCE).map(|f| f * variance);
            let truth = model.variance(factor as f64);
            held += f64::from(low <= truth && truth <= high);
            all += 1.0;
        }
    }
    held / all
}

#[test]
fn intervals_hold_what_they_promise_for_each_noise() {
    for term in [Term::AngleRandomWalk, Term::BiasInstability, Term::RateRandomWalk] {
        let share = coverage(term);
        println!("{}: {:.1} % of {SEEDS} seeds", term.name(), 100.0 * share);
        assert!(PROMISED.contains(&share), "{term:?}: {share}");
    }
}

#[test]
fn intervals_of_a_whole_characterisation_hold_what_they_promise() {
    // White noise that turns into flicker at some 100 s: degrees of freedom follow the fit.
    let model = NoiseModel::from_coefficients([0.0, 1.0, 0.15, 0.0, 0.0]);
    let (mut held, mut all) = (0.0, 0.0);
    let (mut white_held, mut white_all) = (0.0, 0.0);
    for seed in 0..60 {
        let record = record(&model, 1.0, SAMPLES, seed);
        let found = characterise(&record, &Options::default()).expect("a sound record");
        for point in found.points.iter().filter(|point| point.trusted && point.factor >= 4) {
            let truth = model.variance(point.tau_s).sqrt();
            let [low, high] = point.interval_rad_s;
            held += f64::from(low <= truth && truth <= high);
            all += 1.0;
        }
        if let Verdict::Estimated { interval: [low, high], .. } =
            found.verdict(Term::AngleRandomWalk)
        {
            white_held += f64::from(low <= 1.0 && 1.0 <= high);
            white_all += 1.0;
        }
    }
    let (share, white) = (held / all, white_held / white_all);
    println!("curve {:.1} %, N {:.1} % of {white_all} records", 100.0 * share, 100.0 * white);
    // Sixty records, whose averaging times go together, know a share of 0.95 to some 0.02.
    assert!((share - 0.95).abs() < 0.04, "{share}");
    // Four standard errors of sixty draws are 0.11 below; above there is room for caution.
    assert!(white_all >= 59.0 && white >= 0.84, "{white} of {white_all}");
}
