//! What was put in comes out.

use crate::noise::{DEG_H, Maker, gyro, record, single};
use struna_gyro::characterise::{
    Characterisation, NoiseModel, Options, RateRecord, Reason, Term, Verdict, characterise,
};
use struna_kernel::RAD_PER_DEG;

const RATE_HZ: f64 = 300.0;
const HOUR: usize = 1_080_000;

fn found(record: &RateRecord) -> Characterisation {
    characterise(record, &Options::default()).expect("a sound record")
}

#[track_caller]
fn estimate(found: &Characterisation, term: Term) -> (f64, [f64; 2]) {
    match found.verdict(term) {
        Verdict::Estimated { value, interval } => (value, interval),
        other => panic!("{term:?}: {other:?}"),
    }
}

#[test]
fn an_hour_gives_back_the_walk_to_a_hundredth_and_the_instability_to_a_third() {
    let truth = gyro();
    let lsb_rad_s = RAD_PER_DEG / 32_768.0;
    let mut held = 0;
    for seed in 0..5 {
        let rates = Maker::new(&truth, RATE_HZ, HOUR, seed).take(HOUR);
        let rounded = rates.into_iter().map(|rate| (rate / lsb_rad_s).round() * lsb_rad_s);
        let found = found(&RateRecord::contiguous(RATE_HZ, rounded).expect("a positive rate"));
        let (n, _) = estimate(&found, Term::AngleRandomWalk);
        let (b, [low, high]) = estimate(&found, Term::BiasInstability);
        let n_ratio = n / truth.coefficient(Term::AngleRandomWalk);
        let b_ratio = b / truth.coefficient(Term::BiasInstability);
        println!(
            "seed {seed}: N {n_ratio:.4}, B {b_ratio:.3}, {:?}",
            found.verdict(Term::RateRandomWalk)
        );
        // What is promised of an hour.
        assert!((n_ratio - 1.0).abs() < 0.01, "seed {seed}: {n_ratio}");
        assert!((b_ratio - 1.0).abs() < 0.30, "seed {seed}: {b_ratio}");
        held += u32::from(low <= DEG_H && DEG_H <= high);
        // An hour does not tell 3 °/h/√h from nothing; what it says must not exclude it.
        match found.verdict(Term::RateRandomWalk) {
            Verdict::AtMost { bound, .. } => assert!(bound > 0.5 * 3.0 * DEG_H / 60.0),
            Verdict::Estimated { interval: [_, high], .. } => assert!(high > 3.0 * DEG_H / 60.0),
            refused @ Verdict::Refused { .. } => panic!("an hour is long enough: {refused:?}"),
        }
        assert!(found.misfit < 3.0, "seed {seed}: misfit {}", found.misfit);
    }
    assert!(held >= 3, "{held} of 5 intervals hold B");
}

#[test]
fn a_minute_supports_the_walk_only_and_says_why() {
    let record = record(&gyro(), RATE_HZ, 18_000, 0);
    let found = found(&record);
    let (n, _) = estimate(&found, Term::AngleRandomWalk);
    // Five times the 0.3 % that 18 000 samples at √60 less than an hour's tenth of a percent give.
    assert!((n / gyro().coefficient(Term::AngleRandomWalk) - 1.0).abs() < 0.02);
    for term in [Term::BiasInstability, Term::RateRandomWalk, Term::RateRamp] {
        let Verdict::Refused { reason } = found.verdict(term) else { panic!("{term:?}") };
        let Reason::TooShort { trusted_s, .. } = reason else { panic!("{reason:?}") };
        assert!((5.0..=6.7).contains(&trusted_s), "a ninth of a minute, not {trusted_s} s");
        assert!(reason.to_string().contains("record"), "{reason}");
    }
}

#[test]
fn a_walk_of_the_rate_that_shows_is_estimated() {
    let truth = NoiseModel::from_coefficients([0.0, 1.0, 0.0, 0.01, 0.0]);
    let mut held = 0;
    for seed in 0..5 {
        let found = found(&record(&truth, 1.0, 100_000, seed));
        let (k, [low, high]) = estimate(&found, Term::RateRandomWalk);
        assert!((k / 0.01 - 1.0).abs() < 0.3, "seed {seed}: {k}");
        held += u32::from(low <= 0.01 && 0.01 <= high);
    }
    assert!(held >= 4, "{held} of 5 intervals hold K");
}

#[test]
fn a_ramp_is_told_from_a_walk_by_the_hadamard_deviation() {
    let ramp = NoiseModel::from_coefficients([0.0, 1.0, 0.0, 0.0, 1e-4]);
    let ramped = found(&record(&ramp, 1.0, 20_000, 0));
    let (r, [low, high]) = estimate(&ramped, Term::RateRamp);
    // A ramp has no scatter of its own, which the fit cannot know: some of it goes to the walk.
    assert!((r / 1e-4 - 1.0).abs() < 0.15 && low < 1e-4 && 1e-4 < high, "{r}: {low} to {high}");
    assert!(ramped.drift_ratio.is_some_and(|ratio| ratio > 2.0), "{:?}", ramped.drift_ratio);
    let walk = NoiseModel::from_coefficients([0.0, 1.0, 0.0, 0.03, 0.0]);
    for seed in 0..5 {
        let walked = found(&record(&walk, 1.0, 20_000, seed));
        let verdict = walked.verdict(Term::RateRamp);
        assert!(matches!(verdict, Verdict::AtMost { .. }), "seed {seed}: {verdict:?}");
    }
}

#[test]
fn rounding_of_the_angle_is_estimated() {
    let truth = NoiseModel::from_coefficients([1.0, 0.3, 0.0, 0.0, 0.0]);
    let found = found(&record(&truth, 10.0, 50_000, 0));
    let (q, [low, high]) = estimate(&found, Term::Quantisation);
    assert!((q - 1.0).abs() < 0.02 && low < 1.0 && 1.0 < high, "{q} in {low} to {high}");
}

#[test]
fn bounds_are_seldom_below_the_truth() {
    // Flicker that hides below the white noise: 2ln2/π B² = 6e-4 beside 1/450 at the last point.
    let truth = NoiseModel::from_coefficients([0.0, 1.0, 0.037, 0.0, 0.0]);
    let (mut bounds, mut below) = (0, 0);
    for seed in 0..40 {
        let found = found(&record(&truth, 1.0, 4096, seed));
        let limit = match found.verdict(Term::BiasInstability) {
            Verdict::AtMost { bound, .. } => bound,
            Verdict::Estimated { interval: [_, high], .. } => high,
            Verdict::Refused { reason } => panic!("{reason}"),
        };
        bounds += 1;
        below += u32::from(limit < 0.037);
        // A bound that allows everything says nothing.
        assert!(limit < 0.3, "seed {seed}: {limit}");
    }
    println!("{below} of {bounds} bounds lie below the truth");
    // Two of forty at 95 %; six are beyond what chance makes of that in a hundred.
    assert!(below <= 5, "{below} of {bounds}");
}

#[test]
fn losses_leave_the_walk_as_it_is() {
    let rates = Maker::new(&gyro(), RATE_HZ, 300_000, 3).take(300_000);
    let mut record = RateRecord::new(RATE_HZ).expect("a positive rate");
    // A thousandth of the frames, and a minute at once.
    let is_lost = |k: usize| k % 9973 < 10 || (100_000..118_000).contains(&k);
    for (k, rate) in rates.into_iter().enumerate() {
        record.push(if is_lost(k) { f64::NAN } else { rate + f64::from(k > 110_000) });
    }
    assert_eq!(record.lost(), (0..300_000).filter(|k| is_lost(*k)).count() as u64);
    let found = found(&record);
    let (n, _) = estimate(&found, Term::AngleRandomWalk);
    // As over the whole record; the bias that changed in the long gap must not show at all.
    assert!((n / gyro().coefficient(Term::AngleRandomWalk) - 1.0).abs() < 0.01, "{n}");
    assert!(found.points.iter().all(|p| p.factor <= 9963 / 3), "no difference reaches over a gap");
}

#[test]
fn averaging_times_that_the_band_hides_are_left_out_of_the_fit() {
    // White noise through a first-order low pass of 40 Hz at 1400 Hz.
    let pole = (-2.0 * std::f64::consts::PI * 40.0 / 1400.0_f64).exp();
    let mut state = 0.0;
    let white = Maker::new(&single(Term::AngleRandomWalk, 1.0), 1400.0, 400_000, 0).take(400_000);
    let rates = white.into_iter().map(|white| {
        state = pole * state + (1.0 - pole) * white;
        state
    });
    let record = RateRecord::contiguous(1400.0, rates).expect("a positive rate");
    let blind = found(&record);
    let options = Options { bandwidth_hz: Some(40.0), ..Options::default() };
    let told = characterise(&record, &options).expect("a sound record");
    let (n, _) = estimate(&told, Term::AngleRandomWalk);
    println!("told of the band: N {n:.4}");
    // A first-order band takes half as much again as what is given back, 1 % of N; and chance.
    assert!((n - 1.0).abs() < 0.02, "told of the band: {n}");
    let hidden: Vec<_> = told.points.iter().filter(|point| point.filtered).collect();
    assert!(hidden.last().is_some_and(|point| point.tau_s < 0.0478), "12/(2π·40) s");
    assert!(hidden.iter().all(|point| point.adev_rad_s < (1.0 / point.tau_s).sqrt()));
    // Not told, it gives no wrong answer but none.
    let refused = Verdict::Refused { reason: Reason::NoSlopes { misfit: blind.misfit } };
    assert_eq!(blind.verdicts, [refused; 5]);
}

#[test]
fn the_overbound_lies_above_every_interval() {
    let options = Options { overbound: true, ..Options::default() };
    let found = characterise(&record(&gyro(), 30.0, 108_000, 1), &options).expect("sound");
    let bound = found.overbound.expect("asked for");
    for point in found.points.iter().filter(|point| point.is_usable()) {
        let above = bound.variance(point.tau_s).sqrt() >= point.interval_rad_s[1];
        assert!(above, "at {} s", point.tau_s);
    }
    let n = bound.coefficient(Term::AngleRandomWalk);
    let ratio = n / gyro().coefficient(Term::AngleRandomWalk);
    assert!((1.0..1.2).contains(&ratio), "no more than it takes: {ratio}");
}

#[test]
fn one_record_has_one_answer() {
    let record = record(&gyro(), 30.0, 20_000, 2);
    assert_eq!(found(&record), found(&record));
}
