//! Where a string ends to be one: slack, and too near to the horizontal.

#![expect(clippy::panic, reason = "another answer than the one awaited fails the test")]

use super::{
    Integrator, JUDGE, LENGTH_M, RK4_1MS, at_ms, hung, infinite, motion, run, suspension_w_m,
};
use std::f64::consts::TAU;
use struna_body::{
    BodyError, Rig, StartState, Stop, StopReason, Support, TruthMotion, Vibration, reference,
};
use struna_kernel::{Bound, RAD_PER_DEG, SimTime};

const STEPS_S: [f64; 5] = [1e-5, 1e-4, 7e-4, 2e-3, 4e-3];

fn integrators() -> impl Iterator<Item = Integrator> {
    STEPS_S.map(|step_s| Integrator::Rk4 { step_s }).into_iter().chain([JUDGE])
}

/// Vertical shaking with an acceleration of a little more than that of gravity.
fn tossed(rig: Rig, phase_rad: f64) -> Rig {
    let frequency_hz = 3.0;
    let amplitude_m = 1.08 * 9.81 / (TAU * frequency_hz).powi(2);
    let toss = Vibration { amplitude_w_m: [0.0, 0.0, amplitude_m], frequency_hz, phase_rad };
    Rig { support: Support { vibrations: vec![toss], ..Support::default() }, ..rig }
}

fn stop(rig: &Rig, start: &StartState, integrator: Integrator) -> Stop {
    match run(rig, start, integrator).motion_at(at_ms(5000)) {
        Err(BodyError::Stopped(stop)) => stop,
        other => panic!("{integrator:?}: {other:?}"),
    }
}

#[test]
fn a_string_tossed_by_more_than_gravity_goes_slack_when_the_closed_form_says() {
    for phase_rad in [0.0, 2.5] {
        // n·s″ + g = 0 for a body at rest: sin(ωt + φ) = 1/1.08.
        let sine_rad = (1.0_f64 / 1.08).asin();
        let phase_there = if phase_rad < sine_rad { sine_rad } else { TAU + sine_rad };
        let exact_s = (phase_there - phase_rad) / (TAU * 3.0);
        for rig in [tossed(hung(LENGTH_M), phase_rad), tossed(infinite(), phase_rad)] {
            for integrator in integrators() {
                let stop = stop(&rig, &StartState::AT_REST, integrator);
                assert_eq!(stop.reason, StopReason::Slack, "{integrator:?}: {stop}");
                // Demanded: the nanosecond in which simulated time is counted.
                assert!((stop.time_s - exact_s).abs() < 1e-9, "{integrator:?}: {stop}, {exact_s}");
            }
        }
    }
}

#[test]
fn a_swinging_body_goes_slack_at_the_same_instant_for_every_step() {
    let slanted =
        StartState { suspension_w_m: [0.3, -0.2], com_velocity_w_m_s: [0.2, 0.3], ..reference::S3 };
    for rig in [tossed(hung(LENGTH_M), 0.0), tossed(infinite(), 2.5)] {
        let record = stop(&rig, &slanted, JUDGE);
        for integrator in integrators() {
            let stop = stop(&rig, &slanted, integrator);
            let apart_s = stop.time_s - record.time_s;
            println!("slack, {integrator:?}: {apart_s:.1e} s from the record");
            assert_eq!(stop.reason, StopReason::Slack, "{integrator:?}: {stop}");
            // Demanded: the nanosecond in which simulated time is counted.
            assert!(apart_s.abs() < 1e-9, "{integrator:?}: {stop}, {record}");
        }
    }
}

#[test]
fn an_adaptive_step_does_not_leap_over_a_slackening_that_nothing_announces() {
    // Neither a body at rest nor slow torsion makes steps short, and a string tossed by 1.005 g
    // is slack for a thirtieth of each period only.
    let frequency_hz = 20.0;
    let amplitude_m = 1.005 * 9.81 / (TAU * frequency_hz).powi(2);
    let toss = Vibration { amplitude_w_m: [0.0, 0.0, amplitude_m], frequency_hz, phase_rad: 3.0 };
    let support = Support { vibrations: vec![toss], ..Support::default() };
    let exact_s = (TAU + (1.0_f64 / 1.005).asin() - 3.0) / (TAU * frequency_hz);
    for start in [StartState::AT_REST, reference::S1] {
        let rig = Rig { support: support.clone(), ..hung(LENGTH_M) };
        for rtol in [1e-6, 1e-9, 1e-12] {
            let stop = stop(&rig, &start, Integrator::Dop853 { rtol, atol: rtol });
            assert_eq!(stop.reason, StopReason::Slack, "{rtol:e}: {stop}");
            assert!((stop.time_s - exact_s).abs() < 1e-9, "{rtol:e}: {stop}, {exact_s} s");
        }
    }
}

#[test]
fn a_stop_names_the_twist_and_not_the_turn_against_the_clamp() {
    let mut rig = tossed(hung(LENGTH_M), 0.0);
    (rig.support.clamp_rad, rig.support.clamp_rate_rad_s) = (0.5, 0.25);
    let start = StartState::twisted(0.5, 0.25);
    for integrator in integrators() {
        let stop = stop(&rig, &start, integrator);
        assert_eq!(stop.reason, StopReason::Slack);
        // Body and clamp turn together, so the thread stays relaxed: rounding of half a radian.
        let twist_rad = 0.5 + 0.25 * stop.time_s;
        assert!((stop.posture.twist_rad - twist_rad).abs() < 1e-12, "{integrator:?}: {stop}");
    }
}

#[test]
fn the_pull_falls_to_nothing_where_the_string_goes_slack() {
    let rig = tossed(hung(LENGTH_M), 0.0);
    let stop = stop(&rig, &reference::S3, JUDGE);
    let mut run = run(&rig, &reference::S3, JUDGE);
    let before = SimTime::from_s(stop.time_s - 1e-8).unwrap();
    let pull_n = super::pull_w_n(&rig.body, &motion(&mut run, before)).norm();
    // The toss takes 1e2 N away in a second, so 1e-6 N in the ten nanoseconds left.
    assert!((1e-9..5e-6).contains(&pull_n), "{pull_n:e} N");
}

#[test]
fn a_string_that_starts_too_near_to_the_horizontal_is_refused_by_name() {
    let limit_m = LENGTH_M * (80.0 * RAD_PER_DEG).sin();
    for (x, y, refused) in [
        (limit_m * (1.0 + 1e-12), 0.0, true),
        (0.0, -limit_m * (1.0 - 1e-12), false),
        (0.6 * 1.01 * limit_m, 0.8 * 1.01 * limit_m, true),
        (0.6 * 0.99 * limit_m, -0.8 * 0.99 * limit_m, false),
        (3.0, 0.0, true),
    ] {
        let start = StartState { suspension_w_m: [x, y], ..StartState::AT_REST };
        let answer = TruthMotion::new(hung(LENGTH_M), &start, RK4_1MS);
        let name = match answer {
            Err(BodyError::Parameter(error)) => Some(error.name),
            _ => None,
        };
        assert_eq!(name, refused.then_some("|suspension_w_m|/string_length_m"), "{x}, {y}");
        // An infinite string hangs straight wherever it is.
        assert!(TruthMotion::new(infinite(), &start, RK4_1MS).is_ok());
    }
}

#[test]
fn a_string_that_swings_up_to_eighty_degrees_ends_the_run_there() {
    let thrown = StartState { com_velocity_w_m_s: [0.0, 8.0], ..StartState::AT_REST };
    let rig = hung(LENGTH_M);
    let record = stop(&rig, &thrown, JUDGE);
    for integrator in [JUDGE, RK4_1MS, Integrator::Rk4 { step_s: 4e-3 }] {
        let stop = stop(&rig, &thrown, integrator);
        assert_eq!(stop.reason, StopReason::StringTooTilted, "{integrator:?}: {stop}");
        let before = SimTime::from_s(stop.time_s - 1e-9).unwrap();
        let there = motion(&mut run(&rig, &thrown, integrator), before);
        let lean = suspension_w_m(&rig.body, &there).xy().norm() / LENGTH_M;
        // Two nanoseconds at a lean that grows by four in a second.
        assert!((lean - (80.0 * RAD_PER_DEG).sin()).abs() < 1e-8, "{integrator:?}: {lean}");
        println!("80 deg, {integrator:?}: {:.1e} s from the record", stop.time_s - record.time_s);
        // RK4 at 4 ms errs by 1e-6 of the phase of a swing of 20 rad/s in these tenths of a second.
        assert!((stop.time_s - record.time_s).abs() < 1e-6, "{integrator:?}: {stop}, {record}");
    }
}

#[test]
fn a_string_shorter_than_the_body_is_refused_by_name() {
    for length_m in [0.0, -1.0, 0.0999, f64::NAN, f64::INFINITY] {
        match TruthMotion::new(hung(length_m), &StartState::AT_REST, RK4_1MS) {
            Err(BodyError::Parameter(error)) => assert_eq!(error.name, "string_length_m"),
            other => panic!("{length_m}: {other:?}"),
        }
    }
    assert!(TruthMotion::new(hung(0.1), &StartState::AT_REST, RK4_1MS).is_ok());
}

#[test]
fn a_step_too_long_for_string_body_or_support_is_refused_with_the_longest_that_will_do() {
    let limit_s = |rig: &Rig, start: &StartState| match rig.check_step(start, 10.0) {
        Err(BodyError::Parameter(error)) => match error.bound {
            Bound::AtMost(limit_s) => limit_s,
            other => panic!("{other:?}"),
        },
        other => panic!("{other:?}"),
    };
    // M g d and the smallest moment of the reference body, and its string; half a radian each.
    let (pendulum_s2, short) = (0.1 * 9.81 / 0.01, hung(0.2));
    // The squares of both modes of a double pendulum add up to this.
    let string_rad_s = (pendulum_s2 * (1.0 + 0.1 / 0.2) + 9.81 / 0.2_f64).sqrt();
    // Start, rig and fastest rate: the swing, with the string's help, the shaking, and the rate
    // that a body reaches which starts with most of its energy in a fast turn.
    let fast = StartState { omega_wb_b_rad_s: [0.0, 0.0, 30.0], ..StartState::AT_REST };
    let fast_rad_s = (0.012 * 30.0_f64.powi(2) / 0.01).sqrt();
    for (rig, start, fastest_rad_s) in [
        (infinite(), StartState::AT_REST, pendulum_s2.sqrt()),
        (short.clone(), StartState::AT_REST, string_rad_s),
        (tossed(short.clone(), 0.0), StartState::AT_REST, TAU * 3.0),
        (short, fast, fast_rad_s),
    ] {
        let limit_s = limit_s(&rig, &start);
        assert!((limit_s * fastest_rad_s / 0.5 - 1.0).abs() < 1e-14, "{limit_s}");
        assert!(rig.check_step(&start, limit_s).is_ok());
    }
}
