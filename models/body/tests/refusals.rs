//! What a run refuses, and that a refusal leaves it standing.

use nalgebra::Vector3;
use struna_body::ode::OdeError;
use struna_body::{
    Body, BodyError, Integrator, StartState, TILT_MAX_RAD, TWIST_MAX_RAD, TruthMotion, reference,
};
use struna_kernel::SimTime;

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
            Err(BodyError::Integration(OdeError::Setting { .. })) => {}
            other => panic!("{integrator:?}: {other:?}"),
        }
    }
}

#[test]
fn a_run_that_swings_over_the_top_ends_with_time_and_state() {
    let over_the_top = StartState { omega_wb_b_rad_s: [30.0, 0.0, 0.0], ..StartState::AT_REST };
    for integrator in [RK4_1MS, RECORD] {
        let mut run = TruthMotion::new(body(), &over_the_top, integrator).unwrap();
        let before = run.motion_at(at_ms(50)).unwrap();
        match run.motion_at(at_ms(2000)) {
            Err(BodyError::Integration(OdeError::OutsideDomain { time_s, state })) => {
                // 170° at rates between 30 rad/s and what the climb leaves of it.
                assert!((0.09..0.2).contains(&time_s), "{integrator:?}: {time_s}");
                assert!(state.iter().all(|v| v.is_finite()));
            }
            other => panic!("{integrator:?}: {other:?}"),
        }
        assert_eq!(run.motion_at(at_ms(50)).unwrap(), before, "{integrator:?}");
        assert!(run.motion_at(at_ms(60)).is_ok(), "{integrator:?}: still short of the failure");
    }
}

#[test]
fn a_step_too_long_for_the_motion_is_an_error_and_never_nan() {
    // Fifty milliseconds at 2000 rad/s is far outside the method's stability.
    let wild = StartState { omega_wb_b_rad_s: [2e3, -1e3, 2e3], ..reference::S3 };
    let mut run = TruthMotion::new(body(), &wild, Integrator::Rk4 { step_s: 0.05 }).unwrap();
    match run.motion_at(at_ms(10_000)) {
        Err(BodyError::Integration(
            OdeError::Diverged { state, .. } | OdeError::OutsideDomain { state, .. },
        )) => assert!(state.iter().all(|v| v.is_finite())),
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
    assert!(matches!(refused, Err(BodyError::Integration(OdeError::TooManySteps { .. }))));
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
