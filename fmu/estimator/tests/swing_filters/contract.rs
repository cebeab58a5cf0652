//! What the filters promise whatever the body does: refusals change nothing, bytes hold a running
//! filter, and no input makes a belief that is no number.

use crate::one_axis::near;
use crate::rig::{BODY, STEP_S, Scenario, Truth, axis};
use proptest::prelude::*;
use struna_estimator::{
    Belief, ConfigError, EstimatorError, GyroRange, InnovationTest, InputAxis, RateEstimator,
    RestoreError, SWING_STATES, Status, SwingBelief, SwingConfig, SwingFilter, ThreeAxisFilter,
};
use struna_kernel::RAD_PER_DEG;

fn saved(filter: &SwingFilter) -> Vec<u8> {
    let mut bytes = vec![0; filter.saved_len()];
    filter.save(&mut bytes);
    bytes
}

fn saved_three(filter: &ThreeAxisFilter) -> Vec<u8> {
    let mut bytes = vec![0; filter.saved_len()];
    filter.save(&mut bytes);
    bytes
}

/// Both filters after a second of swinging by 5°, and the truth that they have seen.
fn running() -> (SwingFilter, ThreeAxisFilter, Truth) {
    let mut truth = Truth::new(Scenario::swing(5.0), 1);
    let config = truth.config();
    let mut one = near(&mut truth, &config);
    let mut three = ThreeAxisFilter::new(&config, 10.0 * RAD_PER_DEG).unwrap();
    for k in 1..=100 {
        let sample = truth.sample(k);
        one.step(STEP_S, sample.measured_rad_s).unwrap();
        three.step(STEP_S, sample.rates_rad_s).unwrap();
    }
    (one, three, truth)
}

#[test]
fn a_refused_call_changes_nothing() {
    let (mut one, mut three, _) = running();
    let (before, before_three) = (saved(&one), saved_three(&three));
    for span_s in [-1e-9, f64::NAN, f64::INFINITY, 1e4, f64::MAX] {
        let refused = one.predict(span_s).unwrap_err();
        let expected = if (0.0..=f64::MAX).contains(&span_s) {
            matches!(refused, EstimatorError::SpanTooLong { .. })
        } else {
            matches!(refused, EstimatorError::BadSpan { .. })
        };
        assert!(expected, "{span_s}: {refused}");
        one.step(span_s, 0.0).unwrap_err();
        one.step_over_range(span_s, 0.0).unwrap_err();
        three.predict(span_s).unwrap_err();
        three.step(span_s, [0.0; 3]).unwrap_err();
    }
    for rate in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX] {
        one.update(rate).unwrap_err();
        one.step(STEP_S, rate).unwrap_err();
        one.update_over_range(rate).unwrap_err();
        for axis in 0..3 {
            let mut rates = [0.0; 3];
            rates[axis] = rate;
            three.update(rates).unwrap_err();
            three.step(STEP_S, rates).unwrap_err();
        }
    }
    assert_eq!(saved(&one), before);
    assert_eq!(saved_three(&three), before_three);
}

#[test]
fn predicting_over_zero_seconds_changes_nothing() {
    let (mut one, mut three, _) = running();
    let (before, before_three) = (saved(&one), saved_three(&three));
    one.predict(0.0).unwrap();
    three.predict(0.0).unwrap();
    assert_eq!(saved(&one), before);
    assert_eq!(saved_three(&three), before_three);
}

#[test]
fn a_step_is_a_prediction_and_an_update() {
    let (mut one, mut three, mut truth) = running();
    let (mut one_apart, mut three_apart) = (one.clone(), three);
    for k in 101..=200 {
        let sample = truth.sample(k);
        let at_once = one.step(STEP_S, sample.measured_rad_s).unwrap();
        one_apart.predict(STEP_S).unwrap();
        assert_eq!(one_apart.update(sample.measured_rad_s).unwrap(), at_once);
        let at_once = three.step(STEP_S, sample.rates_rad_s).unwrap();
        three_apart.predict(STEP_S).unwrap();
        assert_eq!(three_apart.update(sample.rates_rad_s).unwrap(), at_once);
    }
    one.step_over_range(STEP_S, 1.0).unwrap();
    one_apart.predict(STEP_S).unwrap();
    one_apart.update_over_range(1.0).unwrap();
    assert_eq!(saved(&one), saved(&one_apart));
    assert_eq!(three, three_apart);
}

#[test]
fn an_update_never_grows_a_variance_and_keeps_the_covariance_symmetric() {
    let (mut one, _, mut truth) = running();
    for k in 101..=1000 {
        one.predict(STEP_S).unwrap();
        let before = one.swing_belief().covariance;
        one.update(truth.sample(k).measured_rad_s).unwrap();
        let after = one.swing_belief().covariance;
        for i in 0..SWING_STATES {
            // Rounding of a variance that the sample says nothing of.
            assert!(after[i][i] <= before[i][i] * (1.0 + 1e-14), "sample {k}, state {i}");
            for (j, row) in after.iter().enumerate() {
                assert_eq!(after[i][j].to_bits(), row[i].to_bits(), "sample {k}: {i} {j}");
            }
        }
    }
}

#[test]
fn restored_bytes_go_on_bit_for_bit_through_an_alarm() {
    let kick = Some((500, [0.5, 0.5, 0.5]));
    let mut truth = Truth::new(Scenario { kick, ..Scenario::swing(5.0) }, 2);
    let config = truth.config();
    let mut straight = near(&mut truth, &config);
    let mut resumed = straight.clone();
    // Saved between the kick and the alarm: the roll-back reads samples of before.
    for k in 1..=501 {
        straight.step(STEP_S, truth.sample(k).measured_rad_s).unwrap();
    }
    assert_eq!(straight.alarms(), 0);
    resumed.restore(&saved(&straight)).unwrap();
    for k in 502..=2000 {
        let measured_rad_s = truth.sample(k).measured_rad_s;
        let innovation = straight.step(STEP_S, measured_rad_s).unwrap();
        assert_eq!(resumed.step(STEP_S, measured_rad_s).unwrap(), innovation);
    }
    assert!(straight.alarms() > 0, "the kick was seen");
    assert!(matches!(straight.status(), Status::Disturbed { .. }));
    assert_eq!(saved(&straight), saved(&resumed));
}

#[test]
fn three_axes_restored_go_on_bit_for_bit() {
    let (_, mut straight, mut truth) = running();
    let config = truth.config();
    let mut resumed = ThreeAxisFilter::new(&config, 0.1).unwrap();
    straight.predict(0.004).unwrap();
    resumed.restore(&saved_three(&straight)).unwrap();
    for k in 101..=700 {
        let rates_rad_s = truth.sample(k).rates_rad_s;
        straight.step(STEP_S, rates_rad_s).unwrap();
        resumed.step(STEP_S, rates_rad_s).unwrap();
    }
    assert_eq!(saved_three(&straight), saved_three(&resumed));
}

#[test]
fn bytes_that_are_no_state_are_refused_and_change_nothing() {
    let (mut one, mut three, _) = running();
    let (good, good_three) = (saved(&one), saved_three(&three));
    let short = one.restore(&good[1..]);
    assert!(matches!(short, Err(RestoreError::Length { .. })));
    let mut poisoned = good.clone();
    poisoned[16..24].copy_from_slice(&f64::NAN.to_le_bytes());
    assert!(matches!(one.restore(&poisoned), Err(RestoreError::NotFinite { .. })));
    // The first number is e₁: 2 is the sine of no angle.
    let mut tipped = good.clone();
    tipped[..8].copy_from_slice(&2.0_f64.to_le_bytes());
    assert_eq!(one.restore(&tipped), Err(RestoreError::Impossible));
    tipped.clone_from(&good_three);
    tipped[..8].copy_from_slice(&2.0_f64.to_le_bytes());
    assert_eq!(three.restore(&tipped), Err(RestoreError::Impossible));
    assert!(matches!(three.restore(&good_three[1..]), Err(RestoreError::Length { .. })));
    assert_eq!(saved(&one), good);
    assert_eq!(saved_three(&three), good_three);
}

#[test]
fn a_restart_is_a_fresh_start() {
    let (mut used, _, mut truth) = running();
    let config = truth.config();
    let belief = near(&mut Truth::new(Scenario::swing(5.0), 1), &config).swing_belief();
    let mut fresh = SwingFilter::new(&config, &InnovationTest::STANDARD, &belief).unwrap();
    used.restart(&belief).unwrap();
    for k in 101..=3000 {
        // Whatever the samples are: an alarm and its roll-back included.
        let measured_rad_s = truth.sample(k).measured_rad_s;
        let one = used.step(STEP_S, measured_rad_s);
        assert_eq!(one, fresh.step(STEP_S, measured_rad_s));
    }
    assert_eq!(used.swing_belief(), fresh.swing_belief());
    assert_eq!((used.alarms(), used.status()), (fresh.alarms(), fresh.status()));
    let before = saved(&used);
    let mut tipped = belief;
    tipped.mean[0] = 1.0;
    assert_eq!(used.restart(&tipped).unwrap_err().name, "e1^2 + e2^2");
    assert_eq!(saved(&used), before);
}

fn is_number(belief: &Belief) -> bool {
    let p = belief.covariance;
    [belief.angle_rad, belief.rate_rad_s, p.angle_rad2, p.cross_rad2_s, p.rate_rad2_s2]
        .iter()
        .all(|number| number.is_finite())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn no_rates_make_a_belief_that_is_no_number(
        rates in proptest::collection::vec(
            (prop_oneof![-1.0..1.0_f64, -1e3..1e3_f64, -1e160..1e160_f64], 0.0..0.3_f64), 1..150,
        )
    ) {
        let (mut one, mut three, _) = running();
        for (rate, span_s) in rates {
            // Refused or taken in; either way the belief is one.
            let _ = one.step(span_s, rate);
            let _ = three.step(span_s, [rate, -rate, 0.5 * rate]);
            prop_assert!(is_number(&one.belief()), "{:?}", one.belief());
            prop_assert!(is_number(&three.belief()), "{:?}", three.belief());
            prop_assert!(one.belief().covariance.angle_rad2 >= 0.0);
            let _ = (one.status(), three.status());
        }
    }
}

#[test]
fn a_gap_of_ten_seconds_is_bridged() {
    let (mut one, mut three, mut truth) = running();
    for k in 101..=6000 {
        let sample = truth.sample(k);
        one.step(STEP_S, sample.measured_rad_s).unwrap();
        three.step(STEP_S, sample.rates_rad_s).unwrap();
    }
    one.predict(10.0).unwrap();
    three.predict(10.0).unwrap();
    let after = truth.sample(7000);
    for belief in [one.belief(), three.belief()] {
        let off = (belief.angle_rad - after.motion.twist_rad).abs();
        let sigma = belief.covariance.angle_rad2.sqrt();
        assert!(off < 3.0 * sigma && sigma < RAD_PER_DEG, "{off} against {sigma} rad");
    }
    for k in 7001..=7100 {
        one.step(STEP_S, truth.sample(k).measured_rad_s).unwrap();
    }
    assert_eq!(one.alarms(), 0, "the gap is no kick");
}

#[test]
fn a_clipped_gyro_is_left_out_and_owned_up_to() {
    let mut truth = Truth::new(Scenario::swing(5.0), 1);
    let range = Some(GyroRange { limit_rad_s: 1e-3, margin_rad_s: 9e-4 });
    let config = SwingConfig { range, ..truth.config() };
    let mut clipped = near(&mut truth, &config);
    let mut predicted = clipped.clone();
    for _ in 1..=150 {
        clipped.step(STEP_S, 1e-3).unwrap();
        predicted.predict(STEP_S).unwrap();
    }
    assert_eq!(clipped.swing_belief(), predicted.swing_belief());
    assert_eq!(clipped.status(), Status::NotObservable);
}

#[test]
fn a_value_out_of_its_bound_is_refused_by_name() {
    type Spoil = fn(&mut SwingConfig, f64);
    let positive: [(&str, Spoil); 7] = [
        ("mass_kg", |c, v| c.body.mass_kg = v),
        ("com_depth_m", |c, v| c.body.com_depth_m = v),
        ("inertia_a_kg_m2", |c, v| c.body.inertia_kg_m2[0] = v),
        ("inertia_b_kg_m2", |c, v| c.body.inertia_kg_m2[1] = v),
        ("inertia_c_kg_m2", |c, v| c.body.inertia_kg_m2[2] = v),
        ("gravity_m_s2", |c, v| c.body.gravity_m_s2 = v),
        ("measurement_variance_rad2_s2", |c, v| c.measurement_variance_rad2_s2 = v),
    ];
    let not_negative: [(&str, Spoil); 8] = [
        ("swing_damping_1_s", |c, v| c.body.swing_damping_1_s = v),
        ("tilt_sigma_rad", |c, v| c.axis.tilt_sigma_rad = v),
        ("inertia_sigma", |c, v| c.inertia_sigma = v),
        ("swing_damping_sigma", |c, v| c.swing_damping_sigma = v),
        ("swing_walk_s_m3_2", |c, v| c.swing_walk_s_m3_2 = v),
        ("rate_walk_rad2_s3", |c, v| c.rate_walk_rad2_s3 = v),
        ("bias_walk_rad2_s3", |c, v| c.bias_walk_rad2_s3 = v),
        ("scale_factor_sigma", |c, v| c.scale_factor_sigma = v),
    ];
    let good = Truth::new(Scenario::swing(0.0), 0).config();
    let refusal = |spoil: Spoil, value| -> ConfigError {
        let mut config = good;
        spoil(&mut config, value);
        config.validate().unwrap_err()
    };
    assert_eq!(good.validate(), Ok(()));
    for (name, spoil) in positive {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(refusal(spoil, bad).name, name, "{bad}");
        }
    }
    for (name, spoil) in not_negative {
        for bad in [-1e-9, f64::NAN, f64::INFINITY] {
            assert_eq!(refusal(spoil, bad).name, name, "{bad}");
        }
    }
    let sideways = InputAxis { tilt_b_rad: [0.6, -0.6], ..axis() };
    assert_eq!(sideways.validate().unwrap_err().name, "tilt_b_rad[0]");
    let stiff: Spoil = |c, v| c.body.gravity_m_s2 = v;
    assert_eq!(refusal(stiff, 1e300).name, "swing_frequency_rad_s");
    for bad in [0.0, -0.1, 0.8, f64::NAN] {
        let refused = ThreeAxisFilter::new(&good, bad).unwrap_err();
        assert_eq!(refused.name, "swing_sigma_rad");
    }
}

#[test]
fn a_belief_that_is_none_is_refused_by_name() {
    let config = Truth::new(Scenario::swing(0.0), 0).config();
    let mut mean = [0.0; SWING_STATES];
    mean[6] = 2.7e-3;
    let good = SwingBelief::independent(mean, [1e-3; SWING_STATES]);
    let refusal = |spoil: fn(&mut SwingBelief)| {
        let mut belief = good;
        spoil(&mut belief);
        SwingFilter::new(&config, &InnovationTest::STANDARD, &belief).unwrap_err().name
    };
    assert_eq!(refusal(|b| b.mean[4] = f64::NAN), "mean");
    assert_eq!(refusal(|b| b.covariance[5][5] = -1e-20), "variance");
    assert_eq!(refusal(|b| b.covariance[5][2] = f64::INFINITY), "covariance");
    assert_eq!(refusal(|b| b.mean[1] = -1.0), "e1^2 + e2^2");
}

/// A belief of certainty: hanging by `tilt_rad` and else as the configuration says.
fn certain(config: &SwingConfig, tilt_rad: f64) -> SwingBelief {
    let omega = std::f64::consts::TAU / config.start.period_s;
    let mut mean = [0.0; SWING_STATES];
    mean[0] = tilt_rad.sin();
    (mean[6], mean[7]) = (omega * omega, 0.1 * omega);
    (mean[8], mean[9], mean[10]) = (1.0, 1.0, 1.0);
    SwingBelief::independent(mean, [0.0; SWING_STATES])
}

#[test]
fn noise_is_that_of_the_configuration_and_grows_with_the_swing() {
    let config = Truth::new(Scenario::swing(0.0), 0).config();
    for (tilt_rad, amplitude_rad) in [(0.2, 0.2), (0.0, 0.1 * RAD_PER_DEG)] {
        let belief = certain(&config, tilt_rad);
        let mut filter = SwingFilter::new(&config, &InnovationTest::STANDARD, &belief).unwrap();
        filter.predict(STEP_S).unwrap();
        let p = filter.swing_belief().covariance;
        let swing = (config.swing_walk_s_m3_2 * amplitude_rad).powi(2) * STEP_S;
        let rate = (1e-3 * RAD_PER_DEG).powi(2) * STEP_S;
        let bias = (1e-6 * RAD_PER_DEG).powi(2) * STEP_S;
        for (state, expected) in [(3, swing), (4, swing), (5, rate), (11, bias)] {
            // Rounding, and that of the sine and its inverse.
            assert!((p[state][state] / expected - 1.0).abs() < 1e-12, "state {state}");
        }
        for state in [0, 1, 2, 6, 7, 8, 9, 10, 12, 13] {
            assert!(p[state][state].abs() < 1e-300, "state {state}");
        }
    }
}

#[test]
fn the_first_measurement_of_an_unknown_rate_leaves_its_own_noise() {
    // The rate is known 10¹⁰ times worse than it is measured, and K·H is 1 to the last bit: the
    // short form P − K·H·P leaves zero or rounding.
    for r in [1e-12, 3e-12, 7e-12] {
        let told = Truth::new(Scenario::swing(0.0), 0).config();
        let config = SwingConfig { measurement_variance_rad2_s2: r, ..told };
        let mut belief = certain(&config, 0.0);
        belief.covariance[5][5] = 1e8;
        let mut filter = SwingFilter::new(&config, &InnovationTest::STANDARD, &belief).unwrap();
        filter.update(0.5).unwrap();
        let left = filter.swing_belief().covariance[5][5];
        // R/P = 1e-20 of it, and a few roundings.
        assert!((left / r - 1.0).abs() < 1e-12, "{left:e} left of {r:e}");
    }
}

#[test]
fn a_body_that_cannot_be_is_not_believed_in() {
    let config = Truth::new(Scenario::swing(0.0), 0).config();
    let mut belief = certain(&config, 0.05);
    (belief.mean[8], belief.mean[9]) = (1.5, 0.1);
    let filter = SwingFilter::new(&config, &InnovationTest::STANDARD, &belief).unwrap();
    assert_eq!(filter.swing_belief().mean[8..10], [1.2, 0.8]);
    assert_eq!(filter.status(), Status::NotObservable);
}

#[test]
fn an_outlier_hardly_counts() {
    let (mut struck, _, mut truth) = running();
    let mut spared = struck.clone();
    let measured_rad_s = truth.sample(101).measured_rad_s;
    let before = spared.belief().covariance.angle_rad2.sqrt();
    struck.step(STEP_S, measured_rad_s + 20.0 * RAD_PER_DEG).unwrap();
    spared.step(STEP_S, measured_rad_s).unwrap();
    for k in 102..=300 {
        let measured_rad_s = truth.sample(k).measured_rad_s;
        struck.step(STEP_S, measured_rad_s).unwrap();
        spared.step(STEP_S, measured_rad_s).unwrap();
    }
    assert_eq!(struck.alarms(), 0);
    let off = (struck.belief().angle_rad - spared.belief().angle_rad).abs();
    // A sample of 400 sigma at a weight of 1e-6, over the thousands that tell the angle.
    assert!(off < 0.02 * before, "{off} of {before} rad");
}

/// A push that swells: three samples weak enough to pass the gate, and with the fourth, which
/// raises the alarm, the blow: the best that is known of the rate, however large it is.
#[test]
fn the_sample_that_raises_an_alarm_is_believed_and_a_kick_is_doubted_once() {
    let (mut struck, _, _) = running();
    // A sample so many sigmas beyond what is expected, and its residual.
    let step = |filter: &mut SwingFilter, sigmas: f64| {
        let expected = filter.clone().step(STEP_S, 0.0).unwrap();
        let residual_rad_s = sigmas * expected.variance_rad2_s2.sqrt();
        filter.step(STEP_S, residual_rad_s - expected.residual_rad_s).unwrap();
        residual_rad_s
    };
    // The windows are clean of what came before.
    (0..10).for_each(|_| _ = step(&mut struck, 0.0));
    let mut spared = struck.clone();
    let before = struck.swing_belief();
    let residuals_rad_s = [3.5, 3.5, 3.5, 100.0].map(|sigmas| {
        assert_eq!(struck.alarms(), 0);
        step(&mut spared, 0.0);
        step(&mut struck, sigmas)
    });
    assert_eq!(struck.alarms(), 1);
    let change_rad_s = struck.belief().rate_rad_s - spared.belief().rate_rad_s;
    // The rest is left to what was believed before.
    assert!((change_rad_s / residuals_rad_s[3] - 1.0).abs() < 0.1, "{change_rad_s} rad/s");
    // Across the axis, where next to nothing is measured, the doubt is left: twice the mean of the
    // four, squared, in each rate. The swing turns it into tilt and back.
    let kick_rad_s = residuals_rad_s.iter().sum::<f64>() / 4.0;
    let after = struck.swing_belief();
    let doubt = |i: usize| after.covariance[i][i] - before.covariance[i][i];
    let frequency2 = BODY.swing_frequency_rad_s().powi(2);
    let doubt_rad2_s2 = doubt(3) + doubt(4) + frequency2 * (doubt(0) + doubt(1));
    let share = doubt_rad2_s2 / (2.0 * 4.0 * kick_rad_s * kick_rad_s);
    // The leak of a rate across tells a few per cent of it.
    assert!((0.8..1.2).contains(&share), "{share}");
}
