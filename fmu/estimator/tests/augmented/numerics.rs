//! Positive covariances, hostile input, gaps, and bytes that hold a running filter.

use crate::rig::{B, PERIOD_S, R_RAD2_S2, Rig, STEP_S, Scenario};
use nalgebra::SMatrix;
use proptest::prelude::*;
use std::f64::consts::TAU;
use struna_estimator::{
    AugmentedConfig, AugmentedFilter, EstimatorError, GyroRange, InnovationTest, RateEstimator,
    RestoreError, StartPrior, Status, TestedFilter,
};
use struna_kernel::RAD_PER_DEG;

fn config() -> AugmentedConfig {
    AugmentedConfig::quiet(StartPrior::released(TAU, PERIOD_S), R_RAD2_S2)
}

fn tested(config: &AugmentedConfig) -> TestedFilter {
    TestedFilter::new(config, &InnovationTest::STANDARD).unwrap()
}

/// Smallest eigenvalue of the correlations, and whether all variances are positive.
fn least_eigenvalue(covariance: [[f64; 5]; 5]) -> f64 {
    let sigma: [f64; 5] = std::array::from_fn(|i| covariance[i][i].sqrt());
    if sigma.iter().any(|sigma| sigma.is_nan() || *sigma <= 0.0) {
        return f64::NEG_INFINITY;
    }
    SMatrix::<f64, 5, 5>::from_fn(|i, j| covariance[i][j] / (sigma[i] * sigma[j]))
        .symmetric_eigenvalues()
        .min()
}

/// Rates of the torsion with rough noise; cheap, for runs of many samples.
fn rate_rad_s(k: u32) -> f64 {
    let noise = (f64::from(k) * 0.618_033_988_749_895).fract() - 0.5;
    -0.08 * (f64::from(k) * 1.3e-4).sin() + 0.15 * RAD_PER_DEG * noise
}

#[test]
fn ten_million_updates_leave_the_covariance_positive_definite() {
    // 28 hours at 100 Hz. With a walk of the bias and torque noise the filter never comes to rest;
    // without, its variances fall for ever.
    for (q, walk) in [(1e-9, 1e-12), (0.0, 0.0)] {
        let config = AugmentedConfig {
            process_noise_rad2_s3: q * RAD_PER_DEG * RAD_PER_DEG,
            bias_walk_rad2_s3: walk * RAD_PER_DEG * RAD_PER_DEG,
            ..config()
        };
        let mut filter = AugmentedFilter::new(&config).unwrap();
        let mut least = f64::INFINITY;
        for k in 1..=5_000_000 {
            filter.step(STEP_S, rate_rad_s(k)).unwrap();
            if k % 10_000 == 0 {
                least = least.min(least_eigenvalue(filter.covariance()));
            }
        }
        assert!(least > 0.0, "q {q}: least eigenvalue of the correlations {least:e}");
    }
}

/// Whether the covariance is positive semidefinite but for rounding after each of these updates,
/// with R, the start's sigmas, q, the bias walk, the period and the span as powers of ten.
///
/// 25 entries of size 1 are rounded, and more is left where an update cuts the variance of the rate
/// down from S to R: what was rounding of the large one is then set against the small one. From
/// S/R = 2e14 on a double holds neither.
///
/// So much is asked where the samples resolve the fastest oscillation that the filter may come to
/// believe in. Beyond that derivatives by the stiffness grow without end and rounding with them;
/// the filter may then refuse a call, which must leave it as it was.
fn stays_semidefinite(log10: [f64; 6], rates: &[f64]) -> Result<(), String> {
    let [r, sigma, q, walk, period_s, span_s] = log10.map(|power| 10_f64.powf(power));
    let start = StartPrior {
        angle_sigma_rad: sigma,
        rate_sigma_rad_s: sigma,
        bias_sigma_rad_s: sigma,
        ..StartPrior::released(TAU, period_s)
    };
    let config = AugmentedConfig {
        process_noise_rad2_s3: q,
        bias_walk_rad2_s3: walk,
        ..AugmentedConfig::quiet(start, r)
    };
    let mut filter = AugmentedFilter::new(&config).unwrap();
    let mut cut = 1.0_f64;
    // Ω stays within a factor of 10 of its start.
    let is_resolved = 10.0 * TAU / period_s * span_s < 1.0;
    for (k, &rate) in rates.iter().enumerate() {
        let untouched = filter.clone();
        let predicted = filter.predict(span_s);
        let last = if predicted.is_ok() { filter.clone() } else { untouched };
        let innovation = match predicted.and_then(|()| filter.update(rate)) {
            Ok(innovation) => innovation,
            Err(reason) => {
                let same = saved(&filter) == saved(&last);
                let allowed = same && !is_resolved;
                return allowed.then_some(()).ok_or(format!("update {k}: {reason}, {same}"));
            }
        };
        cut = cut.max(innovation.variance_rad2_s2 / r);
        let after = filter.covariance();
        let least = least_eigenvalue(after);
        let rounding = 25.0 * f64::EPSILON * cut;
        if is_resolved && rounding < 1.0 && least <= -rounding {
            return Err(format!("update {k}: {least:e}, variance cut to 1/{cut:e}"));
        }
        let belief = filter.belief();
        if !(belief.angle_rad.is_finite() && belief.covariance.angle_rad2 >= 0.0) {
            return Err(format!("update {k}: {belief:?}"));
        }
    }
    Ok(())
}

#[test]
fn a_variance_cut_down_ten_orders_keeps_its_covariance_but_for_rounding() {
    // Three rates measured 10¹⁵ times better than anything is known give rate, acceleration and
    // stiffness one after the other.
    let log10 = [
        -13.785_393_959_625_89,
        0.557_806_172_871_910_4,
        -13.878_557_108_265_246,
        -14.482_592_591_091_903,
        0.588_590_153_557_541_3,
        -2.457_720_623_109_998_4,
    ];
    let rates = [1.513_939_948_117_791_8, -2.365_237_429_445_121, 0.199_621_049_772_825_1, 0.0];
    stays_semidefinite(log10, &rates).unwrap();
}

proptest! {
    #[test]
    fn extreme_ratios_leave_the_covariance_positive_definite(
        log10_r in -14.0_f64..0.0,
        log10_sigma in -4.0_f64..1.0,
        log10_q in -16.0_f64..-2.0,
        log10_walk in -20.0_f64..-6.0,
        log10_period in 0.0_f64..3.5,
        log10_span in -4.0_f64..0.5,
        rates in proptest::collection::vec(-4.0_f64..4.0, 1..300),
    ) {
        let log10 =
            [log10_r, log10_sigma, log10_q, log10_walk, log10_period, log10_span];
        let kept = stays_semidefinite(log10, &rates);
        prop_assert!(kept.is_ok(), "{kept:?}");
    }

    #[test]
    fn nothing_that_comes_makes_the_belief_something_else_than_numbers(
        events in proptest::collection::vec((0_u8..8, -1e3_f64..1e3, any::<f64>()), 1..400),
    ) {
        let range = Some(GyroRange { limit_rad_s: 900.0, margin_rad_s: 10.0 });
        let mut filter = tested(&AugmentedConfig { range, ..config() });
        for (kind, ordinary, wild) in events {
            // Whatever is refused is refused; what counts is what is left.
            let _ = match kind {
                0 => filter.predict(wild).err(),
                1 => filter.update(wild).err(),
                2 => filter.step(wild, ordinary).err(),
                3 => filter.step(STEP_S, wild).err(),
                4 => filter.update_over_range(wild).err(),
                5 => filter.step(0.0, ordinary).err(),
                _ => filter.step(STEP_S, ordinary * 1e-4).err(),
            };
            let belief = filter.belief();
            prop_assert!(belief.angle_rad.is_finite() && belief.rate_rad_s.is_finite());
            let covariance = belief.covariance;
            prop_assert!(covariance.angle_rad2 >= 0.0 && !covariance.rate_rad2_s2.is_nan());
        }
    }
}

#[test]
fn a_long_gap_is_a_prediction_like_any_other() {
    let mut rig = Rig::new(B, 3);
    let mut filter = B.filter(&rig);
    // Let it learn for 300 s, then nothing for a minute, then a second of samples.
    for k in 1..=30_000 {
        filter.step(STEP_S, rig.sample(k).measured_rad_s).unwrap();
    }
    let before = filter.belief().covariance.angle_rad2.sqrt();
    filter.predict(60.0).unwrap();
    let truth = rig.sample(36_000);
    let belief = filter.belief();
    let sigma = belief.covariance.angle_rad2.sqrt();
    let error = (belief.angle_rad - truth.angle_rad).abs();
    assert!(error < 3.0 * sigma, "{error} rad against a claimed {sigma}");
    assert!(sigma < 10.0 * before, "{sigma} after {before} rad: the model bridges a minute");
    filter.update(truth.measured_rad_s).unwrap();
    for k in 36_001..=36_100 {
        filter.step(STEP_S, rig.sample(k).measured_rad_s).unwrap();
    }
    assert_eq!(filter.alarms(), 0, "the gap is no kick");
}

#[test]
fn one_long_prediction_is_many_short_ones() {
    let mut at_once = AugmentedFilter::new(&config()).unwrap();
    for k in 1..=1000 {
        at_once.step(STEP_S, rate_rad_s(k)).unwrap();
    }
    let mut in_steps = at_once.clone();
    at_once.predict(40.0).unwrap();
    for _ in 0..4000 {
        in_steps.predict(0.01).unwrap();
    }
    let (one, many) = (at_once.mean(), in_steps.mean());
    for i in 0..5 {
        // The series leaves 4.2e-10 of the amplitude in each of its steps, and 40 s are 64 of them.
        let scale = one[i].abs().max(1e-4);
        assert!((one[i] - many[i]).abs() < 2.7e-8 * scale, "state {i}: {} {}", one[i], many[i]);
    }
    let (one, many) = (at_once.covariance(), in_steps.covariance());
    for i in 0..5 {
        for j in 0..5 {
            // A Jacobian chained from 4000 is that of the whole to the third order of the series.
            let scale = (one[i][i] * one[j][j]).sqrt();
            let off = (one[i][j] - many[i][j]).abs() / scale;
            assert!(off < 1e-3, "entry {i} {j}: off by {off:e} of the sigmas");
        }
    }
}

#[test]
fn a_gap_of_any_length_is_bridged_or_refused() {
    for span_s in [1e3, 1e6, 1e15, 1e200, f64::MAX] {
        let mut filter = tested(&config());
        filter.step(STEP_S, 0.0).unwrap();
        let before = filter.belief();
        match filter.predict(span_s) {
            Ok(()) => assert!(filter.belief().angle_rad.is_finite(), "{span_s}"),
            Err(reason) => {
                assert_eq!(reason, EstimatorError::Overflow, "{span_s}");
                assert_eq!(filter.belief(), before, "{span_s}");
            }
        }
    }
}

fn saved(filter: &impl RateEstimator) -> Vec<u8> {
    let mut bytes = vec![0; filter.saved_len()];
    filter.save(&mut bytes);
    bytes
}

#[test]
fn restored_bytes_go_on_bit_for_bit_through_an_alarm() {
    let scenario = Scenario { kicks: crate::rig::Kicks::Ramp(0.5, 0.0), ..B };
    let mut rig = Rig::new(scenario, 1);
    let kick = rig.first_kick().unwrap();
    let mut straight = scenario.filter(&rig);
    let mut resumed = straight.clone();
    // Saved between the kick and the alarm: the roll-back reads samples of before.
    for k in 1..=kick + 1 {
        straight.step(STEP_S, rig.sample(k).measured_rad_s).unwrap();
    }
    assert_eq!(straight.alarms(), 0);
    resumed.restore(&saved(&straight)).unwrap();
    for k in kick + 2..kick + 3000 {
        let measured_rad_s = rig.sample(k).measured_rad_s;
        let innovation = straight.step(STEP_S, measured_rad_s).unwrap();
        assert_eq!(innovation, resumed.step(STEP_S, measured_rad_s).unwrap());
    }
    assert!(straight.alarms() > 0, "the kick was seen");
    assert_eq!(saved(&straight), saved(&resumed));
}

#[test]
fn bytes_with_impossible_counters_are_refused() {
    let mut filter = tested(&config());
    for k in 1..=101 {
        filter.step(STEP_S, rate_rad_s(k)).unwrap();
    }
    let good = saved(&filter);
    // The three counters stand at the end.
    let counters = good.len() - 24;
    for (place, value) in [(0, 0_u64), (0, u64::MAX), (8, 102), (16, 0), (16, 11)] {
        let mut bad = good.clone();
        bad[counters + place..counters + place + 8].copy_from_slice(&value.to_le_bytes());
        assert_eq!(filter.restore(&bad), Err(RestoreError::Impossible), "{place}: {value}");
    }
    assert_eq!(saved(&filter), good);
}

#[test]
fn a_body_at_rest_claims_no_angle_that_it_cannot_know() {
    let scenario = Scenario { start_sigma_deg: 1.0, ..B };
    let mut filter = tested(&AugmentedConfig {
        start: StartPrior { angle_sigma_rad: TAU, ..StartPrior::released(0.0, PERIOD_S) },
        ..scenario.config(0.0)
    });
    let mut noise = Rig::new(scenario, 0);
    for k in 1..=20_000 {
        let sample = noise.sample(k);
        let noise_rad_s = sample.measured_rad_s - sample.rate_rad_s;
        filter.step(STEP_S, noise_rad_s).unwrap();
    }
    // No motion, a bias: the filter may tell that the body rests at equilibrium, no more.
    let belief = filter.belief();
    let sigma = belief.covariance.angle_rad2.sqrt();
    assert!(belief.angle_rad.abs() < 3.0 * sigma, "{} against {sigma}", belief.angle_rad);
    let learnt = filter.filter().learnt();
    // The period comes from motion alone: 1 % is what the prior said.
    assert!((learnt.period_sigma_s / 4.8 - 1.0).abs() < 0.05, "{}", learnt.period_sigma_s);
}

#[test]
fn nothing_is_learnt_while_every_sample_is_over_range() {
    let range = Some(GyroRange { limit_rad_s: 1.0, margin_rad_s: 0.5 });
    let mut filter = tested(&AugmentedConfig { range, ..config() });
    for k in 1..=1000 {
        filter.step(STEP_S, 1.0 + rate_rad_s(k).abs()).unwrap();
    }
    let mut predicted = AugmentedFilter::new(&config()).unwrap();
    for _ in 0..1000 {
        predicted.predict(STEP_S).unwrap();
    }
    assert_eq!(filter.belief(), predicted.belief());
    assert_eq!(filter.status(), Status::NotObservable);
}

#[test]
fn a_period_wrong_by_a_factor_of_three_is_owned_up_to() {
    for factor in [1.0 / 3.0, 3.0] {
        let mut rig = Rig::new(B, 2);
        let start = StartPrior::released(rig.believed_start_deg * RAD_PER_DEG, PERIOD_S * factor);
        let mut filter = tested(&AugmentedConfig { start, ..B.config(0.0) });
        let mut nominal_and_wrong = 0;
        for k in 1..=48_000 {
            let truth = rig.sample(k);
            filter.step(STEP_S, truth.measured_rad_s).unwrap();
            let belief = filter.belief();
            let wrong = (belief.angle_rad - truth.angle_rad).abs()
                > 6.0 * belief.covariance.angle_rad2.sqrt();
            nominal_and_wrong += u32::from(wrong && filter.status() == Status::Nominal);
        }
        // A prior of 1 % says the period cannot be so; the test of the innovations says it is.
        assert!(filter.alarms() > 10, "{factor}: {} alarms", filter.alarms());
        // Six sigma off and called nominal: in the lulls between alarms, a twentieth of the time.
        assert!(nominal_and_wrong < 2_400, "{factor}: {nominal_and_wrong} samples");
    }
}

#[test]
fn irregular_spans_are_as_good_as_regular_ones() {
    for run in 0..10 {
        let mut rig = Rig::new(B, run);
        let mut filter = B.filter(&rig);
        let (mut last, mut error, mut sigma) = (0, 0.0, 0.0);
        for k in 1..=48_000_u32 {
            let truth = rig.sample(k);
            // One, two or three steps, and a dropout of three seconds in each minute.
            let due = k - last > k.wrapping_mul(0x9E37_79B9) >> 30 && k % 6000 > 300;
            if due {
                filter.step(f64::from(k - last) * STEP_S, truth.measured_rad_s).unwrap();
                let belief = filter.belief();
                error = belief.angle_rad - truth.angle_rad;
                sigma = belief.covariance.angle_rad2.sqrt();
                last = k;
            }
        }
        assert!(error.abs() < 4.0 * sigma, "run {run}: {error} against {sigma}");
        // Half of the samples: √2 of the 0.098° that all of them leave.
        assert!(sigma < 0.2 * RAD_PER_DEG, "run {run}: {sigma}");
    }
}

#[test]
fn the_first_measurement_of_an_unknown_rate_leaves_its_own_noise() {
    // The rate is known 10¹⁰ times worse than it is measured, and K·H is 1 to the last bit: the
    // short form P − K·H·P leaves zero or rounding.
    let start = StartPrior {
        rate_sigma_rad_s: 1e4,
        bias_sigma_rad_s: 0.0,
        ..StartPrior::released(TAU, PERIOD_S)
    };
    for r in [1e-12, 3e-12, 7e-12] {
        let mut filter = AugmentedFilter::new(&AugmentedConfig::quiet(start, r)).unwrap();
        filter.update(0.5).unwrap();
        let left = filter.belief().covariance.rate_rad2_s2;
        // R/P = 1e-20 of it, and a few roundings.
        assert!((left / r - 1.0).abs() < 1e-12, "{left:e} left of {r:e}");
    }
}
