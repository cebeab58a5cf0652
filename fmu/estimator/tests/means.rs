//! A measured rate that is the mean over a span: the rate at its middle.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

#[path = "shared/config.rs"]
mod shared;

use shared::CONFIG;
use struna_body::{
    Body, BodyParams, DampedTorsion, Torsion, TorsionDamping, TorsionStiffness, reference,
};
use struna_estimator::{
    AugmentedConfig, AugmentedFilter, Filter, HysteresisBank, Innovation, InnovationTest,
    PlainIntegration, RateEstimator, StartPrior, TestedFilter,
};

const SPAN_S: f64 = 0.1;
const PERIOD_S: f64 = 20.0;
const START_RAD: f64 = std::f64::consts::TAU;
const SPANS: u32 = 1200;

fn motion() -> DampedTorsion {
    let torsion = Torsion {
        stiffness: TorsionStiffness::PeriodS(PERIOD_S),
        damping: TorsionDamping::Ratio(0.01),
    };
    let body = Body::new(&BodyParams { torsion, ..reference::PARAMS }).unwrap();
    DampedTorsion::new(&body, START_RAD, 0.0)
}

fn config() -> AugmentedConfig {
    let start = StartPrior { angle_sigma_rad: 0.1, ..StartPrior::released(START_RAD, PERIOD_S) };
    AugmentedConfig::quiet(start, 1e-8)
}

/// Largest error of the rate over the second half of a run, as a share of the largest rate; the
/// filter takes means without noise by `step`.
fn worst_rate<E: RateEstimator>(
    mut filter: E,
    step: impl Fn(&mut E, f64, f64) -> Innovation,
) -> f64 {
    let motion = motion();
    let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
    for k in 1..=SPANS {
        let (from_s, to_s) = (f64::from(k - 1) * SPAN_S, f64::from(k) * SPAN_S);
        let mean_rad_s = (motion.twist_rad(to_s) - motion.twist_rad(from_s)) / SPAN_S;
        step(&mut filter, SPAN_S, mean_rad_s);
        if k > SPANS / 2 {
            let rate_rad_s = motion.twist_rate_rad_s(to_s);
            worst = worst.max((filter.belief().rate_rad_s - rate_rad_s).abs());
            largest = largest.max(rate_rad_s.abs());
        }
    }
    worst / largest
}

/// Both ways of taking a mean, of each filter that learns.
fn both<E: RateEstimator>(make: impl Fn() -> E) -> (f64, f64) {
    let middle = worst_rate(make(), |e, span_s, rate| e.step_mean(span_s, rate).unwrap());
    let late = worst_rate(make(), |e, span_s, rate| e.step(span_s, rate).unwrap());
    (middle, late)
}

#[test]
fn filters_that_learn_are_not_late() {
    let test = InnovationTest::STANDARD;
    let found = [
        both(|| AugmentedFilter::new(&config()).unwrap()),
        both(|| TestedFilter::new(&config(), &test).unwrap()),
        both(|| HysteresisBank::new(&config()).unwrap()),
    ];
    let omega_h = std::f64::consts::TAU / PERIOD_S * SPAN_S;
    for (which, (middle, late)) in found.into_iter().enumerate() {
        // The mean of a sine over a span is the one in its middle less (Ωh)²/24, and what the
        // filters have not yet learnt is a hundredth of that.
        assert!(middle < 1.02 * omega_h * omega_h / 24.0, "filter {which}: {middle}");
        // And Ωh/2 away from the one at its end; to second order 2 %.
        assert!((late / (0.5 * omega_h) - 1.0).abs() < 0.03, "filter {which}: {late}");
    }
}

#[test]
fn a_mean_is_taken_in_at_its_middle_to_the_bit() {
    let mut whole = TestedFilter::new(&config(), &InnovationTest::STANDARD).unwrap();
    let mut parts = whole.clone();
    for k in 0..500 {
        let rate_rad_s = -1.9 * (0.03 * f64::from(k)).sin();
        let innovation = whole.step_mean(SPAN_S, rate_rad_s).unwrap();
        parts.predict(0.5 * SPAN_S).unwrap();
        assert_eq!(parts.update(rate_rad_s).unwrap(), innovation);
        parts.predict(0.5 * SPAN_S).unwrap();
        assert_eq!(parts.belief(), whole.belief());
    }
}

/// In spans so short that a motion hardly bends, one update does for two predictions.
#[test]
fn short_spans_are_taken_in_at_once_and_end_no_later() {
    let mut at_once = AugmentedFilter::new(&config()).unwrap();
    let mut in_halves = at_once.clone();
    let motion = motion();
    // Ωh = 0.0063.
    let span_s = 0.02;
    let mut worst = 0.0_f64;
    for k in 1..=6000 {
        let (from_s, to_s) = (f64::from(k - 1) * span_s, f64::from(k) * span_s);
        let mean_rad_s = (motion.twist_rad(to_s) - motion.twist_rad(from_s)) / span_s;
        let ours = at_once.step_mean(span_s, mean_rad_s).unwrap().variance_rad2_s2;
        in_halves.predict(0.5 * span_s).unwrap();
        let theirs = in_halves.update(mean_rad_s).unwrap().variance_rad2_s2;
        in_halves.predict(0.5 * span_s).unwrap();
        // What is left out is a thousandth: half a span of damping and of the angle's curve.
        assert!((ours / theirs - 1.0).abs() < 1e-3, "{k}: {ours} {theirs}");
        if k > 3000 {
            worst = worst.max((at_once.belief().rate_rad_s - motion.twist_rate_rad_s(to_s)).abs());
        }
    }
    let (ours, theirs) = (at_once.belief().covariance, in_halves.belief().covariance);
    // The means are the same to second order, and so is all that is learnt from them.
    assert!((ours.angle_rad2 / theirs.angle_rad2 - 1.0).abs() < 0.01, "{ours:?} {theirs:?}");
    assert!((ours.rate_rad2_s2 / theirs.rate_rad2_s2 - 1.0).abs() < 0.01, "{ours:?} {theirs:?}");
    // The next term of a mean about its end, (Ωh)²/6 of the largest rate, 2 rad/s.
    assert!(worst < 2.0 * 0.00628_f64.powi(2) / 6.0 * 1.1, "{worst}");
}

/// As published: the mean counts for the whole step, whose end it is taken for.
#[test]
fn the_filters_of_2008_take_a_mean_as_they_always_did() {
    fn same<E: RateEstimator + Clone>(estimator: E) {
        let (mut mean, mut end) = (estimator.clone(), estimator);
        for k in 0..500 {
            let rate_rad_s = 0.08 * (0.01 * f64::from(k)).sin();
            let innovation = mean.step_mean(0.01, rate_rad_s).unwrap();
            assert_eq!(end.step(0.01, rate_rad_s).unwrap(), innovation);
            assert_eq!(mean.belief(), end.belief());
        }
    }
    same(PlainIntegration::new(CONFIG).unwrap());
    same(Filter::permanent_rotation(CONFIG).unwrap());
    same(Filter::torsional_oscillation(CONFIG, 480.0).unwrap());
}
