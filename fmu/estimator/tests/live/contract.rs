//! What every estimator promises, kept through every state of the switch.

use crate::rig::{Case, Run, STEP_S, name};
use struna_estimator::{
    ConfigError, EstimatorError, LiveConfig, LiveEstimator, RateEstimator, RestoreError, Status,
};

fn saved(estimator: &LiveEstimator) -> Vec<u8> {
    let mut bytes = vec![0; estimator.saved_len()];
    estimator.save(&mut bytes);
    bytes
}

fn run_on(estimator: &mut LiveEstimator, rates_rad_s: &[f64]) {
    for rate_rad_s in rates_rad_s {
        estimator.predict(STEP_S).unwrap();
        estimator.update(*rate_rad_s).unwrap();
    }
}

/// A run through all of the switch: at rest, a blow, fit, swing.
fn eventful() -> Run {
    Run::of(&Case { blow: Some((10.0, [40.0, 10.0, 0.3])), seconds: 100, seed: 8, ..Case::STILL })
}

#[test]
fn restored_at_any_moment_it_continues_bit_for_bit() {
    let run = eventful();
    let shown = run.trace(&mut run.estimator()).status;
    let caught = shown.iter().position(|status| name(status) == "swinging").unwrap();
    let mut straight = run.estimator();
    let mut at = 0;
    let mut seen = Vec::new();
    // Before, in the blow, early and late in the fit, while it catches up, and after.
    for until in [500, 1_050, 1_700, 4_000, caught - 100, caught - 2, caught + 1, 9_900] {
        run_on(&mut straight, &run.measured_rad_s[at..until]);
        at = until;
        seen.push(name(&straight.status()));
        let bytes = saved(&straight);
        // Into one that has been elsewhere.
        let mut resumed = run.estimator();
        run_on(&mut resumed, &run.measured_rad_s[..1_300]);
        resumed.restore(&bytes).unwrap();
        assert_eq!(saved(&resumed), bytes, "at sample {until}");
        let mut other = run.estimator();
        other.restore(&bytes).unwrap();
        let next = &run.measured_rad_s[until..(until + 100).min(10_000)];
        let mut ahead = straight.clone();
        run_on(&mut ahead, next);
        run_on(&mut other, next);
        assert_eq!(ahead.belief(), other.belief(), "after sample {until}");
        assert_eq!(ahead.status(), other.status());
        assert_eq!(saved(&ahead), saved(&other), "after sample {until}");
    }
    for state in ["nominal", "fitting", "swinging"] {
        assert!(seen.contains(&state), "{seen:?}");
    }
}

#[test]
fn a_refused_call_changes_nothing_in_any_state() {
    let run = eventful();
    let mut live = run.estimator();
    let mut at = 0;
    for until in [500, 4_000, 9_900] {
        run_on(&mut live, &run.measured_rad_s[at..until]);
        at = until;
        let before = saved(&live);
        for span_s in [-1e-9, f64::NAN, f64::INFINITY] {
            let refusal = live.predict(span_s);
            assert!(matches!(refusal, Err(EstimatorError::BadSpan { .. })), "{refusal:?}");
        }
        for rate_rad_s in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let refusal = live.update(rate_rad_s);
            assert!(matches!(refusal, Err(EstimatorError::BadMeasurement { .. })), "{refusal:?}");
            assert!(live.update_over_range(rate_rad_s).is_err());
        }
        assert_eq!(live.update(f64::MAX).unwrap_err(), EstimatorError::Overflow);
        live.predict(0.0).unwrap();
        assert!(saved(&live) == before, "at sample {until}");
    }
}

#[test]
fn bytes_that_are_none_of_its_own_are_refused_and_change_nothing() {
    let run = eventful();
    let mut live = run.estimator();
    run_on(&mut live, &run.measured_rad_s[..4_000]);
    let good = saved(&live);
    let short = live.restore(&good[..good.len() - 1]);
    assert!(matches!(short, Err(RestoreError::Length { .. })));
    // NaN wherever a number may stand, every so often; counters may not mind.
    let mut refused = 0;
    for place in (0..good.len() / 8).step_by(1_009) {
        let mut poisoned = good.clone();
        poisoned[8 * place..8 * place + 8].copy_from_slice(&f64::NAN.to_le_bytes());
        if live.restore(&poisoned).is_err() {
            refused += 1;
            assert!(saved(&live) == good, "place {place}");
        }
        live.restore(&good).unwrap();
    }
    assert!(refused > 0);
    run_on(&mut live, &run.measured_rad_s[4_000..4_100]);
}

#[test]
fn a_gap_in_any_state_widens_what_is_claimed_and_is_got_over() {
    let run = eventful();
    for (from, gap) in [(500, 300_u32), (4_000, 300), (9_000, 300), (9_000, 900)] {
        let mut live = run.estimator();
        run_on(&mut live, &run.measured_rad_s[..from]);
        let before = live.belief().covariance;
        // All but the last step of the gap; the last one ends at the sample after it.
        live.predict(f64::from(gap - 1) * STEP_S).unwrap();
        let after = live.belief().covariance;
        assert!(after.rate_rad2_s2 >= before.rate_rad2_s2, "{before:?} {after:?}");
        run_on(&mut live, &run.measured_rad_s[from + gap as usize - 1..]);
        let belief = live.belief();
        let error_rad = belief.angle_rad - run.twist_rad[9_999];
        let sigmas = (error_rad / belief.covariance.angle_rad2.sqrt()).abs();
        assert!(sigmas < 6.0, "{sigmas} sigmas, {}", live.status());
    }
}

#[test]
fn a_gap_too_long_for_the_filter_of_the_swing_brings_the_bound_back() {
    let run = eventful();
    let mut live = run.estimator();
    run_on(&mut live, &run.measured_rad_s[..9_900]);
    assert!(matches!(live.status(), Status::Swinging { .. }), "{}", live.status());
    live.predict(1e5).unwrap();
    assert!(matches!(live.status(), Status::Fitting { .. }), "{}", live.status());
    run_on(&mut live, &run.measured_rad_s[9_900..]);
    assert!(live.belief().angle_rad.is_finite());
}

#[test]
fn a_fit_that_never_ends_goes_on_in_bounded_memory() {
    // One step of work per sample is far too little: the fit starves, is begun again when the tape
    // runs out after 420 s, and can be restored all the same.
    let case = Case { swing_deg: 5.0, ratio: 0.3, seconds: 450, seed: 3, ..Case::STILL };
    let mut run = Run::of(&case);
    run.config.work_per_sample = 1;
    let mut live = run.estimator();
    let collected_s = |live: &LiveEstimator| match live.status() {
        Status::Fitting { collected_s, .. } => collected_s,
        other => panic!("{other}"),
    };
    run_on(&mut live, &run.measured_rad_s[..41_900]);
    assert!(collected_s(&live) > 59.0, "{}", live.status());
    let saved_len = live.saved_len();
    run_on(&mut live, &run.measured_rad_s[41_900..43_000]);
    assert!(collected_s(&live) < 12.0, "begun again: {}", live.status());
    run_on(&mut live, &run.measured_rad_s[43_000..]);
    let bytes = saved(&live);
    assert_eq!(bytes.len(), saved_len);
    let mut resumed = run.estimator();
    resumed.restore(&bytes).unwrap();
    assert!(saved(&resumed) == bytes);
    let (error_rad, belief) = (live.belief().angle_rad - run.twist_rad[44_999], live.belief());
    assert!(error_rad.abs() < 3.0 * belief.covariance.angle_rad2.sqrt(), "the bound holds");
}

#[test]
fn a_parameter_out_of_its_bound_is_refused_by_name() {
    let good = Run::of(&Case { seconds: 1, ..Case::STILL }).config;
    let name = |config: LiveConfig| LiveEstimator::new(&config).map(|_| ()).map_err(named);
    fn named(error: ConfigError) -> &'static str {
        error.name
    }
    assert_eq!(name(good), Ok(()));
    assert_eq!(name(LiveConfig { swing_max_rad: -0.1, ..good }), Err("swing_max_rad"));
    assert_eq!(name(LiveConfig { swing_max_rad: f64::NAN, ..good }), Err("swing_max_rad"));
    assert_eq!(name(LiveConfig { sample_period_s: 0.0, ..good }), Err("sample_period_s"));
    assert_eq!(name(LiveConfig { sample_period_s: 1e-9, ..good }), Err("sample_period_s"));
    assert_eq!(name(LiveConfig { work_per_sample: 0, ..good }), Err("work_per_sample"));
}
