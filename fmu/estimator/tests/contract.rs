//! What every estimator promises, whatever it assumes about the motion.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

#[path = "shared/config.rs"]
mod shared;

use proptest::prelude::*;
use shared::CONFIG;
use struna_estimator::{
    EstimatorError, Filter, FilterConfig, PlainIntegration, RateEstimator, Reading, Refinement,
    RestoreError,
};

fn config(refinement: Refinement) -> FilterConfig {
    FilterConfig { refinement, ..CONFIG }
}

fn all() -> Vec<(&'static str, Box<dyn RateEstimator>)> {
    let m0 = config(Refinement { samples: 5, reading: Reading::M0 });
    let m1 = config(Refinement { samples: 5, reading: Reading::M1 });
    // M4 with few samples diverges, as it should: see papers.
    let m4 = config(Refinement { samples: 50, reading: Reading::M4 });
    let m6 = config(Refinement { samples: 7, reading: Reading::M6 });
    let off = config(Refinement::OFF);
    vec![
        ("integration", Box::new(PlainIntegration::new(off).unwrap())),
        ("rotation", Box::new(Filter::permanent_rotation(off).unwrap())),
        ("rotation M6", Box::new(Filter::permanent_rotation(m6).unwrap())),
        ("torsion", Box::new(Filter::torsional_oscillation(off, 480.0).unwrap())),
        ("torsion M0", Box::new(Filter::torsional_oscillation(m0, 480.0).unwrap())),
        ("torsion M1", Box::new(Filter::torsional_oscillation(m1, 480.0).unwrap())),
        ("torsion M4", Box::new(Filter::torsional_oscillation(m4, 480.0).unwrap())),
        ("torsion M6", Box::new(Filter::torsional_oscillation(m6, 480.0).unwrap())),
    ]
}

fn saved(estimator: &dyn RateEstimator) -> Vec<u8> {
    let mut bytes = vec![0; estimator.saved_len()];
    estimator.save(&mut bytes);
    bytes
}

fn rate_rad_s(k: u32) -> f64 {
    -0.08 * (f64::from(k) * 1.3e-3).sin() + 1e-3 * (f64::from(k) * 0.7).cos()
}

fn run(estimator: &mut dyn RateEstimator, from: u32, to: u32) {
    for k in from..to {
        estimator.predict(0.01).unwrap();
        estimator.update(rate_rad_s(k)).unwrap();
    }
}

#[test]
fn a_restored_estimator_continues_bit_for_bit() {
    for ((name, mut straight), (_, mut resumed)) in all().into_iter().zip(all()) {
        run(straight.as_mut(), 0, 33);
        let bytes = saved(straight.as_ref());
        run(straight.as_mut(), 33, 200);
        resumed.restore(&bytes).unwrap();
        run(resumed.as_mut(), 33, 200);
        assert_eq!(saved(straight.as_ref()), saved(resumed.as_ref()), "{name}");
    }
}

#[test]
fn a_refused_call_changes_nothing() {
    for (name, mut estimator) in all() {
        run(estimator.as_mut(), 0, 33);
        let before = saved(estimator.as_ref());
        for span_s in [-1e-9, f64::NAN, f64::INFINITY] {
            let refusal = estimator.predict(span_s);
            assert!(matches!(refusal, Err(EstimatorError::BadSpan { .. })), "{name} {span_s}");
        }
        for rate in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let refusal = estimator.update(rate);
            assert!(matches!(refusal, Err(EstimatorError::BadMeasurement { .. })), "{name}");
        }
        assert_eq!(saved(estimator.as_ref()), before, "{name}");
    }
}

#[test]
fn a_belief_that_would_overflow_is_refused() {
    for (name, mut estimator) in all() {
        estimator.predict(1e10).unwrap();
        let before = saved(estimator.as_ref());
        let refusal = estimator.update(f64::MAX);
        assert_eq!(refusal.unwrap_err(), EstimatorError::Overflow, "{name}");
        assert_eq!(saved(estimator.as_ref()), before, "{name}");
    }
}

#[test]
fn predicting_over_zero_seconds_changes_nothing() {
    for (name, mut estimator) in all() {
        run(estimator.as_mut(), 0, 33);
        let before = saved(estimator.as_ref());
        estimator.predict(0.0).unwrap();
        assert_eq!(saved(estimator.as_ref()), before, "{name}");
    }
}

#[test]
fn bytes_of_another_length_or_with_a_nan_are_refused_and_change_nothing() {
    for (name, mut estimator) in all() {
        run(estimator.as_mut(), 0, 33);
        let good = saved(estimator.as_ref());
        let short = estimator.restore(&good[..good.len() - 1]);
        assert!(matches!(short, Err(RestoreError::Length { .. })), "{name}");
        let mut poisoned = good.clone();
        poisoned[16..24].copy_from_slice(&f64::NAN.to_le_bytes());
        let refusal = estimator.restore(&poisoned);
        assert!(matches!(refusal, Err(RestoreError::NotFinite { .. })), "{name}");
        assert_eq!(saved(estimator.as_ref()), good, "{name}");
    }
}

#[test]
fn a_parameter_out_of_its_bound_is_refused_by_name() {
    let good = config(Refinement::OFF);
    let bad = [
        ("angle_start_rad", FilterConfig { angle_start_rad: f64::NAN, ..good }),
        ("angle_variance_start_rad2", FilterConfig { angle_variance_start_rad2: -1.0, ..good }),
        (
            "measurement_variance_rad2_s2",
            FilterConfig { measurement_variance_rad2_s2: 0.0, ..good },
        ),
        ("process_noise_rad2_s3", FilterConfig { process_noise_rad2_s3: f64::INFINITY, ..good }),
    ];
    for (name, config) in bad {
        assert_eq!(Filter::permanent_rotation(config).unwrap_err().name, name);
        assert_eq!(PlainIntegration::new(config).unwrap_err().name, name);
    }
    for period_s in [0.0, -480.0, f64::NAN, f64::INFINITY, 1e-200] {
        let refusal = Filter::torsional_oscillation(good, period_s).unwrap_err();
        assert_eq!(refusal.name, "period_s");
    }
}

#[test]
fn a_gap_widens_the_covariance_and_the_next_sample_narrows_it() {
    // Rotation: under torsion the angle variance itself may fall in a gap, for a rate that is well
    // known lets angle and rate turn into each other.
    let mut filter = Filter::permanent_rotation(config(Refinement::OFF)).unwrap();
    run(&mut filter, 0, 500);
    let settled = filter.belief().covariance;
    filter.predict(2.0).unwrap();
    let after_gap = filter.belief().covariance;
    assert!(after_gap.rate_rad2_s2 > settled.rate_rad2_s2);
    assert!(after_gap.angle_rad2 > settled.angle_rad2);
    filter.update(rate_rad_s(500)).unwrap();
    assert!(filter.belief().covariance.rate_rad2_s2 < after_gap.rate_rad2_s2);
}

#[test]
fn integration_bridges_a_gap_with_the_rate_that_ends_it() {
    let mut sum = PlainIntegration::new(config(Refinement::OFF)).unwrap();
    sum.predict(0.5).unwrap();
    sum.predict(0.25).unwrap();
    sum.update(2.0).unwrap();
    // Exact in binary: 6 + 2·0.75.
    assert_eq!(sum.belief().angle_rad.to_bits(), 7.5_f64.to_bits());
}

proptest! {
    #[test]
    fn an_update_never_grows_a_variance_and_keeps_the_covariance_positive(
        log10_r in -12.0_f64..0.0,
        log10_p in -9.0_f64..6.0,
        log10_q in -14.0_f64..-2.0,
        period_s in 1.0_f64..1000.0,
        rates in proptest::collection::vec(-4.0_f64..4.0, 1..200),
    ) {
        let config = FilterConfig {
            angle_variance_start_rad2: 10_f64.powf(log10_p),
            rate_variance_start_rad2_s2: 10_f64.powf(log10_p),
            measurement_variance_rad2_s2: 10_f64.powf(log10_r),
            process_noise_rad2_s3: 10_f64.powf(log10_q),
            ..config(Refinement::OFF)
        };
        let mut filter = Filter::torsional_oscillation(config, period_s).unwrap();
        for rate in rates {
            filter.predict(0.01).unwrap();
            let predicted = filter.belief().covariance;
            filter.update(rate).unwrap();
            let updated = filter.belief().covariance;
            // Rounding of three terms as large as the predicted variance.
            let slack = 1.0 + 8.0 * f64::EPSILON;
            prop_assert!(updated.angle_rad2 <= predicted.angle_rad2 * slack);
            prop_assert!(updated.rate_rad2_s2 <= predicted.rate_rad2_s2 * slack);
            prop_assert!(updated.angle_rad2 >= 0.0 && updated.rate_rad2_s2 > 0.0);
            let correlation2 = updated.cross_rad2_s.powi(2)
                / (updated.angle_rad2 * updated.rate_rad2_s2);
            prop_assert!(correlation2 <= 1.0 + 1e-9, "correlation² {correlation2}");
        }
    }
}

#[test]
fn the_covariance_is_replaced_at_every_nth_update() {
    let n = 7;
    let refinement = Refinement { samples: n, reading: Reading::M6 };
    let mut filter = Filter::torsional_oscillation(config(refinement), 480.0).unwrap();
    for k in 1..=3 * n {
        run(&mut filter, k - 1, k);
        // M6 inserts a diagonal covariance; any other update leaves angle and rate correlated.
        let inserted = filter.belief().covariance.cross_rad2_s == 0.0;
        assert_eq!(inserted, k.is_multiple_of(n), "update {k}");
    }
}

#[test]
fn reading_m1_adds_nothing_before_its_first_estimate_and_then_at_every_update() {
    let filter = |samples| {
        let refinement = Refinement { samples, reading: Reading::M1 };
        Filter::torsional_oscillation(config(refinement), 480.0).unwrap()
    };
    let (mut adds, mut plain) = (filter(5), filter(0));
    // The estimate that the fifth update completes is there for the sixth.
    for k in 0..20 {
        run(&mut adds, k, k + 1);
        run(&mut plain, k, k + 1);
        let more = adds.belief().covariance.rate_rad2_s2 > plain.belief().covariance.rate_rad2_s2;
        assert_eq!(more, k >= 5, "update {k}");
    }
    // Three numbers more to save than any other reading.
    assert_eq!((plain.saved_len(), adds.saved_len()), (84, 108));
}

#[test]
fn a_step_is_a_prediction_and_an_update_or_nothing() {
    for reading in Reading::ALL {
        let refinement = Refinement { samples: 7, reading };
        let mut whole = Filter::torsional_oscillation(config(refinement), 480.0).unwrap();
        let mut parts = whole.clone();
        for k in 0..100 {
            let innovation = whole.step(0.01, rate_rad_s(k));
            parts.predict(0.01).unwrap();
            assert_eq!(innovation, parts.update(rate_rad_s(k)));
            assert_eq!(saved(&whole), saved(&parts), "{reading:?}, step {k}");
        }
        // The prediction alone would have gone through; the measurement takes both back.
        for (span_s, rate_rad_s) in [(0.01, f64::NAN), (0.01, 1e200), (-0.01, 0.0), (f64::NAN, 0.1)]
        {
            assert!(whole.step(span_s, rate_rad_s).is_err(), "{span_s} s, {rate_rad_s} rad/s");
            assert_eq!(saved(&whole), saved(&parts), "{span_s} s, {rate_rad_s} rad/s");
        }
    }
}
