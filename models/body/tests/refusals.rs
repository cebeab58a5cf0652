//! What a run refuses, and that a refusal leaves it standing.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a failed unwrap fails the test")]

use nalgebra::Vector3;
use std::f64::consts::FRAC_PI_2;
use struna_body::{
    Body, BodyError, Integrator, StartState, Stop, StopReason, TILT_MAX_RAD, TWIST_MAX_RAD,
    TruthMotion, reference,
};
use struna_kernel::{RAD_PER_DEG, SimTime};

const RK4_1MS: Integrator = Integrator::Rk4 { step_s: 1e-3 };
const RECORD: Integrator = Integrator::Dop853 { rtol: 1e-12, atol: 1e-12 };

fn body() -> Body {
    Body::new(&reference::PARAMS).expect("the reference body is sound")
}

fn at_ms(ms: i64) -> SimTime {
    SimTime::from_ns(ms * 1_000_000)
}

fn name_of_refused(start: StartState) -> Option<&'static str> {
    match TruthMotion::new(body(), &start, RK4_1MS) {
        Err(BodyError::Parameter(refused)) => Some(refused.name),
        _ => None,
    }
}

#[test]
fn starts_that_no_string_defines_are_refused_by_name() {
    let rest = StartState::AT_REST;
    for tilt_rad in [TILT_MAX_RAD + 1e-9, -3.1, std::f64::consts::PI, f64::NAN, f64::INFINITY] {
        assert_eq!(name_of_refused(StartState { tilt_rad, ..rest }), Some("|tilt_rad|"));
    }
    for twist_rad in [TWIST_MAX_RAD * 1.01, -1e300, f64::NAN] {
        assert_eq!(name_of_refused(StartState { twist_rad, ..rest }), Some("|twist_rad|"));
    }
    let tilt_azimuth_rad = f64::INFINITY;
    assert_eq!(name_of_refused(StartState { tilt_azimuth_rad, ..rest }), Some("tilt_azimuth_rad"));
    for axis in 0..3 {
        let mut omega_wb_b_rad_s = [0.0; 3];
        omega_wb_b_rad_s[axis] = f64::NAN;
        assert_eq!(
            name_of_refused(StartState { omega_wb_b_rad_s, ..rest }),
            Some("omega_wb_b_rad_s")
        );
    }
}

#[test]
fn unusable_integrator_settings_are_refused() {
    let unusable = [
        Integrator::Rk4 { step_s: 0.0 },
        Integrator::Rk4 { step_s: f64::NAN },
        Integrator::Dop853 { rtol: 0.0, atol: 1e-12 },
        Integrator::Dop853 { rtol: 1e-12, atol: f64::NAN },
    ];
    for integrator in unusable {
        match TruthMotion::new(body(), &reference::S3, integrator) {
            Err(BodyError::Parameter(refused)) => {
                assert!(["step_s", "rtol", "atol"].contains(&refused.name), "{refused}");
            }
            other => panic!("{integrator:?}: {other:?}"),
        }
    }
}

/// Runs from `start` until it stops; what was answered before stands.
fn stop_of(start: &StartState, integrator: Integrator) -> Stop {
    let mut run = TruthMotion::new(body(), start, integrator).unwrap();
    let before = run.motion_at(at_ms(10)).unwrap();
    let stop = match run.motion_at(at_ms(2000)) {
        Err(BodyError::Stopped(stop)) => stop,
        other => panic!("{integrator:?}: {other:?}"),
    };
    assert_eq!(run.motion_at(at_ms(10)).unwrap(), before, "{integrator:?}");
    assert!(run.motion_at(at_ms(12)).is_ok(), "{integrator:?}: still short of the failure");
    stop
}

#[test]
fn a_body_that_turns_over_ends_its_run_with_time_and_state() {
    let steep = StartState {
        tilt_rad: 165.0 * RAD_PER_DEG,
        omega_wb_b_rad_s: [6.0, 0.0, 0.0],
        ..StartState::AT_REST
    };
    for integrator in [RK4_1MS, RECORD] {
        let stop = stop_of(&steep, integrator);
        assert_eq!(stop.reason, StopReason::Overturned, "{stop}");
        // Five degrees at six rad/s, a little less for the climb.
        assert!((0.0145..0.016).contains(&stop.time_s), "{integrator:?}: {stop}");
        assert!((stop.posture.tilt_rad() - TILT_MAX_RAD).abs() < 1e-9);
    }
}

#[test]
fn a_body_thrown_upwards_slackens_its_string_at_the_same_instant_for_every_integrator() {
    let thrown = StartState { omega_wb_b_rad_s: [30.0, 0.0, 0.0], ..StartState::AT_REST };
    let [fixed, record] = [RK4_1MS, RECORD].map(|integrator| stop_of(&thrown, integrator));
    assert_eq!((fixed.reason, record.reason), (StopReason::Slack, StopReason::Slack));
    // Above the horizontal, where the string would have to push the centre of mass round.
    assert!(record.posture.tilt_rad() > FRAC_PI_2);
    // RK4 errs by 1e-5 of the step's phase at 30 rad/s, of which the time takes 1/30.
    assert!((fixed.time_s - record.time_s).abs() < 1e-7, "{fixed} {record}");
}

#[test]
fn a_step_too_long_for_the_motion_is_an_error_and_never_nan() {
    // Fifty milliseconds at 2000 rad/s is far outside the method's stability.
    let wild = StartState { omega_wb_b_rad_s: [2e3, -1e3, 2e3], ..reference::S3 };
    match TruthMotion::new(body(), &wild, Integrator::Rk4 { step_s: 0.05 }) {
        Err(BodyError::Parameter(refused)) => assert_eq!(refused.name, "step_s", "{refused}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn time_runs_forwards_only() {
    for integrator in [RK4_1MS, RECORD] {
        let mut run = TruthMotion::new(body(), &reference::S3, integrator).unwrap();
        assert!(matches!(run.motion_at(SimTime::from_ns(-1)), Err(BodyError::TimeReversal { .. })));
        let there = run.motion_at(at_ms(1234)).unwrap();
        let expected = BodyError::TimeReversal { asked: at_ms(1233), reached: at_ms(1234) };
        assert_eq!(run.motion_at(at_ms(1233)), Err(expected));
        assert_eq!(run.motion_at(at_ms(1234)).unwrap(), there, "the same instant may be repeated");
    }
}

#[test]
fn a_jump_of_centuries_is_refused_before_it_is_computed() {
    let mut run = TruthMotion::new(body(), &reference::S3, RK4_1MS).unwrap();
    let refused = run.motion_at(SimTime::from_ns(i64::MAX));
    assert!(
        matches!(refused, Err(BodyError::Stopped(stop)) if stop.reason == StopReason::TooManySteps)
    );
    assert!(run.motion_at(at_ms(1)).is_ok(), "the run goes on");
}

#[test]
fn a_torque_that_is_no_number_is_refused_and_changes_nothing() {
    let mut run = TruthMotion::new(body(), &reference::S3, RK4_1MS).unwrap();
    let mut untouched = run.clone();
    for bad in [f64::NAN, f64::INFINITY] {
        let refused = run.set_torque(Vector3::new(0.0, bad, 0.0));
        assert!(
            matches!(refused, Err(BodyError::Parameter(error)) if error.name == "torque_b_n_m")
        );
    }
    assert_eq!(run.motion_at(at_ms(777)).unwrap(), untouched.motion_at(at_ms(777)).unwrap());
}
