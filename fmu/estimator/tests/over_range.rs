//! A step over a measurement that the gyro flags as over range: whole, or not at all.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use struna_estimator::{
    AugmentedConfig, AugmentedFilter, EstimatorError, Innovation, InnovationTest, RateEstimator,
    StartPrior, TestedFilter,
};

const STEP_S: f64 = 0.01;

fn config() -> AugmentedConfig {
    AugmentedConfig::quiet(StartPrior::released(6.0, 20.0), 6e-7)
}

fn saved(estimator: &impl RateEstimator) -> Vec<u8> {
    let mut bytes = vec![0; estimator.saved_len()];
    estimator.save(&mut bytes);
    bytes
}

/// Steps `at_once` and predicts and updates `in_two`, every third measurement flagged.
fn run<E: RateEstimator>(
    mut at_once: E,
    mut in_two: E,
    step: impl Fn(&mut E, f64, f64) -> Result<Innovation, EstimatorError>,
    step_over_range: impl Fn(&mut E, f64, f64) -> Result<Innovation, EstimatorError>,
) {
    let mut noted = 0;
    for k in 0..2000_u32 {
        let rate_rad_s = 1.8 * (0.0031 * f64::from(k)).sin();
        if k % 3 == 1 || (500..700).contains(&k) {
            let innovation = step_over_range(&mut at_once, STEP_S, rate_rad_s);
            in_two.predict(STEP_S).unwrap();
            assert_eq!(innovation, in_two.update_over_range(rate_rad_s));
            noted += 1;
        } else {
            let innovation = step(&mut at_once, STEP_S, rate_rad_s);
            in_two.predict(STEP_S).unwrap();
            assert_eq!(innovation, in_two.update(rate_rad_s));
        }
        assert_eq!(at_once.belief(), in_two.belief(), "step {k}");
        assert_eq!(at_once.status().code(), in_two.status().code(), "step {k}");
    }
    assert!(noted > 700);
    assert!(saved(&at_once) == saved(&in_two));
    let before = saved(&at_once);
    for (span_s, rate_rad_s) in [(STEP_S, f64::NAN), (STEP_S, 1e200), (-1.0, 0.1), (f64::NAN, 0.1)]
    {
        assert!(step_over_range(&mut at_once, span_s, rate_rad_s).is_err());
        assert!(saved(&at_once) == before, "{span_s} s, {rate_rad_s} rad/s left a trace");
    }
}

#[test]
fn a_flagged_step_is_a_prediction_and_a_note_to_the_bit() {
    let filter = || AugmentedFilter::new(&config()).unwrap();
    run(filter(), filter(), AugmentedFilter::step, AugmentedFilter::step_over_range);
}

#[test]
fn a_flagged_step_behind_the_test_is_a_prediction_and_a_note_to_the_bit() {
    let filter = || TestedFilter::new(&config(), &InnovationTest::STANDARD).unwrap();
    run(filter(), filter(), TestedFilter::step, TestedFilter::step_over_range);
}
