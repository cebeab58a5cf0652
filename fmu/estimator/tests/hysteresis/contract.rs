//! What the bank and its filters promise as every estimator does, and what becomes of a bank whose
//! members fail.

#![expect(clippy::float_cmp, reason = "what was restored or left alone is equal to the bit")]

use crate::rig::{Run, START_DEG, STEP_S, Thread, config};
use struna_estimator::{
    AugmentedConfig, DahlFilter, EstimatorError, GyroRange, HysteresisBank, RateEstimator,
    RestoreError, StartPrior, YieldPrior,
};
use struna_kernel::RAD_PER_DEG;

fn bank() -> HysteresisBank {
    HysteresisBank::new(&config(START_DEG)).unwrap()
}

fn all() -> Vec<(&'static str, Box<dyn RateEstimator>)> {
    let single = DahlFilter::new(&config(START_DEG), &YieldPrior::around(0.4)).unwrap();
    vec![("one filter", Box::new(single)), ("bank", Box::new(bank()))]
}

fn saved(estimator: &dyn RateEstimator) -> Vec<u8> {
    let mut bytes = vec![0; estimator.saved_len()];
    estimator.save(&mut bytes);
    bytes
}

/// A run on a thread that yields, with a kick on the way.
fn drive(estimator: &mut dyn RateEstimator, truth: &mut Run, samples: std::ops::Range<u32>) {
    for k in samples {
        let kick_rad_s = if k > 700 { 0.01 } else { 0.0 };
        estimator.predict(STEP_S).unwrap();
        estimator.update(truth.sample(k + 1).measured_rad_s + kick_rad_s).unwrap();
    }
}

fn truth() -> Run {
    Run::new(Thread::Dahl(25.0), 1)
}

#[test]
fn a_restored_estimator_continues_bit_for_bit() {
    for ((name, mut straight), (_, mut resumed)) in all().into_iter().zip(all()) {
        let mut motion = truth();
        drive(straight.as_mut(), &mut motion, 0..701);
        // Between a prediction and its measurement, the second one beyond the gate.
        straight.predict(0.004).unwrap();
        let bytes = saved(straight.as_ref());
        resumed.restore(&bytes).unwrap();
        assert_eq!(saved(resumed.as_ref()), bytes, "{name}");
        let mut again = truth();
        again.sample(701);
        drive(straight.as_mut(), &mut motion, 701..1500);
        drive(resumed.as_mut(), &mut again, 701..1500);
        assert_eq!(saved(straight.as_ref()), saved(resumed.as_ref()), "{name}");
        assert_eq!(straight.status(), resumed.status(), "{name}");
    }
}

#[test]
fn a_bank_that_starts_afresh_is_a_new_one_bit_for_bit() {
    let other = config(START_DEG + 20.0);
    let mut fresh = HysteresisBank::new(&other).unwrap();
    let mut again = bank();
    // Through an alarm, and with checkpoints behind it.
    drive(&mut again, &mut truth(), 0..1500);
    again.predict(0.004).unwrap();
    assert!(again.alarms() > 0, "the kick raised an alarm");
    again.restart(&other).unwrap();
    assert_eq!(saved(&again), saved(&fresh));
    drive(&mut fresh, &mut truth(), 0..1500);
    drive(&mut again, &mut truth(), 0..1500);
    assert_eq!(saved(&again), saved(&fresh));
    assert_eq!(again.belief(), fresh.belief());
    let bad = AugmentedConfig { measurement_variance_rad2_s2: 0.0, ..other };
    assert!(again.restart(&bad).is_err());
    assert_eq!(saved(&again), saved(&fresh), "a refusal changes nothing");
}

#[test]
fn a_refused_call_changes_nothing() {
    for (name, mut estimator) in all() {
        drive(estimator.as_mut(), &mut truth(), 0..400);
        let before = saved(estimator.as_ref());
        for span_s in [-1e-9, f64::NAN, f64::INFINITY] {
            let refusal = estimator.predict(span_s);
            assert!(matches!(refusal, Err(EstimatorError::BadSpan { .. })), "{name} {span_s}");
        }
        for rate_rad_s in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let refusal = estimator.update(rate_rad_s);
            assert!(matches!(refusal, Err(EstimatorError::BadMeasurement { .. })), "{name}");
            assert!(estimator.update_over_range(rate_rad_s).is_err(), "{name}");
        }
        // Every member's residual would overflow when squared.
        for rate_rad_s in [f64::MAX, -1e200] {
            assert_eq!(estimator.update(rate_rad_s).unwrap_err(), EstimatorError::Overflow);
        }
        assert_eq!(saved(estimator.as_ref()), before, "{name}");
    }
}

#[test]
fn a_step_is_a_prediction_and_an_update_or_nothing() {
    let mut filter = DahlFilter::new(&config(START_DEG), &YieldPrior::around(0.4)).unwrap();
    let mut parts = filter.clone();
    let mut motion = truth();
    for k in 1..=300 {
        let rate_rad_s = motion.sample(k).measured_rad_s;
        let whole = filter.step(STEP_S, rate_rad_s).unwrap();
        parts.predict(STEP_S).unwrap();
        assert_eq!(whole, parts.update(rate_rad_s).unwrap());
    }
    let mut bank = bank();
    drive(&mut bank, &mut truth(), 0..300);
    let before = saved(&bank);
    for (span_s, rate_rad_s) in [(STEP_S, f64::NAN), (STEP_S, f64::MAX), (-STEP_S, 0.0)] {
        assert!(filter.step(span_s, rate_rad_s).is_err());
        assert!(bank.step(span_s, rate_rad_s).is_err());
    }
    assert_eq!(saved(&filter), saved(&parts));
    assert_eq!(saved(&bank), before);
    bank.step(STEP_S, -0.01).unwrap();
    assert_ne!(saved(&bank), before);
}

#[test]
fn predicting_over_zero_seconds_changes_nothing() {
    for (name, mut estimator) in all() {
        drive(estimator.as_mut(), &mut truth(), 0..400);
        let before = saved(estimator.as_ref());
        estimator.predict(0.0).unwrap();
        assert_eq!(saved(estimator.as_ref()), before, "{name}");
    }
}

#[test]
fn bytes_that_no_estimator_wrote_are_refused_or_survived() {
    for (name, mut estimator) in all() {
        drive(estimator.as_mut(), &mut truth(), 0..400);
        let good = saved(estimator.as_ref());
        let short = estimator.restore(&good[1..]);
        assert!(matches!(short, Err(RestoreError::Length { .. })), "{name}");
        // Every number of the members, then a few of the long memory.
        let members = (0..2600).step_by(12);
        for at in members.chain((2600..good.len()).step_by(1500)).filter(|at| *at < good.len()) {
            for filler in [f64::NAN.to_le_bytes(), 1e300_f64.to_le_bytes(), [0xff; 8], [0; 8]] {
                let mut bytes = good.clone();
                let end = (at + 8).min(good.len());
                bytes[at..end].copy_from_slice(&filler[..end - at]);
                if estimator.restore(&bytes).is_err() {
                    assert_eq!(saved(estimator.as_ref()), good, "{name} {at}");
                    continue;
                }
                // Whatever was restored: no panic, and no number that is none.
                for _ in 0..4 {
                    let _ = estimator.predict(STEP_S);
                    let _ = estimator.update(-0.05);
                    let _ = estimator.status();
                }
                let belief = estimator.belief();
                assert!(!belief.angle_rad.is_nan(), "{name} {at} {filler:?}");
                assert!(!belief.covariance.angle_rad2.is_nan(), "{name} {at} {filler:?}");
                estimator.restore(&good).unwrap();
            }
        }
    }
}

/// Length of the linear member's seat, and of one that yields, in a saved bank.
const LINEAR_SEAT: usize = 16 + 20 * 8;
const YIELDING_SEAT: usize = 16 + 44 * 8;

/// The bank restored with a belief of the member at `place` that the next prediction carries out of
/// floating-point range.
fn with_failing(bank: &HysteresisBank, places: &[usize]) -> HysteresisBank {
    let mut bytes = saved(bank);
    for &place in places {
        // The variance of the first state, after the means.
        let at = match place {
            0 => 16 + 5 * 8,
            k => LINEAR_SEAT + (k - 1) * YIELDING_SEAT + 16 + 8 * 8,
        };
        // Rounded up, a tenth of this leads a sum of ten out of range; squared terms sooner.
        bytes[at + 8..at + 16].copy_from_slice(&f64::MAX.to_le_bytes());
        bytes[at..at + 8].copy_from_slice(&f64::MAX.to_le_bytes());
    }
    let mut broken = bank.clone();
    broken.restore(&bytes).unwrap();
    broken
}

#[test]
fn a_member_that_fails_is_dropped_and_the_bank_goes_on() {
    let mut motion = truth();
    let mut whole = bank();
    drive(&mut whole, &mut motion, 0..600);
    for place in 0..5 {
        let mut broken = with_failing(&whole, &[place]);
        let mut motion = truth();
        motion.sample(600);
        drive(&mut broken, &mut motion, 600..700);
        let weights = broken.weights();
        assert!(weights[place] == 0.0, "{place}: {weights:?}");
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert_ne!(broken.leader(), place);
        assert_eq!(broken.linear_member().is_none(), place == 0);
        let left = broken.yielding_members().iter().flatten().count();
        assert_eq!(left, if place == 0 { 4 } else { 3 });
        let belief = broken.belief();
        assert!(belief.angle_rad.is_finite() && belief.covariance.is_positive_semidefinite());
        // A dropped member stays dropped, over a save too.
        let mut resumed = bank();
        resumed.restore(&saved(&broken)).unwrap();
        assert_eq!(resumed.weights(), weights);
    }
}

#[test]
fn a_bank_all_of_whose_members_fail_refuses_and_keeps_its_belief() {
    let mut whole = bank();
    drive(&mut whole, &mut truth(), 0..600);
    let mut alone = with_failing(&whole, &[0, 1, 2, 3]);
    alone.predict(STEP_S).unwrap();
    assert_eq!(alone.weights(), [0.0, 0.0, 0.0, 0.0, 1.0]);
    assert_eq!(alone.yield_lead().to_bits(), f64::INFINITY.to_bits());
    let before = saved(&alone);
    assert_eq!(alone.update(1e200).unwrap_err(), EstimatorError::Overflow);
    assert_eq!(saved(&alone), before);
    let mut none = with_failing(&whole, &[0, 1, 2, 3, 4]);
    let before = saved(&none);
    for _ in 0..3 {
        assert_eq!(none.predict(STEP_S).unwrap_err(), EstimatorError::Overflow);
        assert_eq!(saved(&none), before);
    }
    let mut emptied = before;
    for place in 0..5 {
        let at = place.min(1) * LINEAR_SEAT + place.saturating_sub(1) * YIELDING_SEAT;
        emptied[at] = 0;
    }
    assert_eq!(none.restore(&emptied).unwrap_err(), RestoreError::Impossible);
}

#[test]
fn priors_that_cannot_be_are_refused_by_name() {
    let good = YieldPrior::around(0.4);
    for prior in YieldPrior::BANK {
        prior.validate().unwrap();
    }
    let bad = [
        ("yield_angle_rad", YieldPrior { yield_angle_rad: 0.0, ..good }),
        ("yield_angle_rad", YieldPrior { yield_angle_rad: f64::NAN, ..good }),
        ("yield_angle_log_sigma", YieldPrior { yield_angle_log_sigma: -1.0, ..good }),
        ("stiffness_ratio", YieldPrior { stiffness_ratio: 1e9, ..good }),
        ("stiffness_ratio_log_sigma", YieldPrior { stiffness_ratio_log_sigma: -0.1, ..good }),
        ("preload_sigma", YieldPrior { preload_sigma: f64::INFINITY, ..good }),
    ];
    for (name, prior) in bad {
        assert_eq!(DahlFilter::new(&config(0.0), &prior).unwrap_err().name, name);
        let priors = [good, good, prior, good];
        let refusal = HysteresisBank::with_priors(&config(0.0), &priors).unwrap_err();
        assert_eq!(refusal.name, name);
    }
    let huge = YieldPrior { preload_sigma: 1e200, ..good };
    assert_eq!(DahlFilter::new(&config(0.0), &huge).unwrap_err().name, "yield prior");
    let model = AugmentedConfig { measurement_variance_rad2_s2: 0.0, ..config(0.0) };
    let refusal = HysteresisBank::new(&model).unwrap_err();
    assert_eq!(refusal.name, "measurement_variance_rad2_s2");
}

#[test]
fn samples_over_range_are_judged_and_left_out_by_all_members() {
    let range = Some(GyroRange::with_raw_sigma(0.06, 1e-3));
    let model = AugmentedConfig { range, ..config(START_DEG) };
    let mut bank = HysteresisBank::new(&model).unwrap();
    drive(&mut bank, &mut truth(), 0..300);
    bank.predict(STEP_S).unwrap();
    let before = bank.clone();
    let judged = bank.update(-0.0599).unwrap();
    assert_eq!(judged, bank.update_over_range(-0.0599).unwrap());
    assert_eq!(bank.belief(), before.belief());
    assert_eq!(bank.weights(), before.weights());
    for _ in 0..101 {
        bank.predict(STEP_S).unwrap();
        bank.update(-0.0599).unwrap();
    }
    assert_eq!(bank.status(), struna_estimator::Status::NotObservable);
}

/// A thread four times as fast, watched four times as often, is the same thread.
#[test]
fn nothing_but_the_period_sets_the_scale() {
    let slow = config(START_DEG);
    let fast = AugmentedConfig {
        start: StartPrior {
            period_s: slow.start.period_s / 4.0,
            period_sigma_s: slow.start.period_sigma_s / 4.0,
            rate_sigma_rad_s: slow.start.rate_sigma_rad_s * 4.0,
            bias_sigma_rad_s: slow.start.bias_sigma_rad_s * 4.0,
            ..slow.start
        },
        measurement_variance_rad2_s2: slow.measurement_variance_rad2_s2 * 16.0,
        process_noise_rad2_s3: slow.process_noise_rad2_s3 * 64.0,
        bias_walk_rad2_s3: slow.bias_walk_rad2_s3 * 64.0,
        ..slow
    };
    let mut slow = HysteresisBank::new(&slow).unwrap();
    let mut fast = HysteresisBank::new(&fast).unwrap();
    let mut motion = truth();
    for k in 1..=32_000 {
        let rate_rad_s = motion.sample(k).measured_rad_s;
        slow.step(STEP_S, rate_rad_s).unwrap();
        fast.step(STEP_S / 4.0, rate_rad_s * 4.0).unwrap();
    }
    // Powers of two are exact; logarithms of scaled numbers round differently.
    let near = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-6, "{a} {b}");
    near(fast.belief().angle_rad, slow.belief().angle_rad);
    near(fast.belief().covariance.angle_rad2, slow.belief().covariance.angle_rad2);
    near(fast.belief().rate_rad_s, slow.belief().rate_rad_s * 4.0);
    near(fast.yield_lead(), slow.yield_lead());
    let (angle, sigma) = fast.yield_angle_rad().unwrap();
    let (slow_angle, slow_sigma) = slow.yield_angle_rad().unwrap();
    near(angle, slow_angle);
    near(sigma, slow_sigma);
    assert!(slow.yield_lead() > 1000.0 && angle > 20.0 * RAD_PER_DEG);
}
