//! The turning clamp and the creeping thread: linear systems with closed solutions.

use crate::{RECORD, RK4_1MS, at_s, damped, difference_rad, run};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;
use struna_body::{
    BodyError, ClampSwing, Creep, DampedTorsion, Hysteresis, Impulse, Integrator, Rig, StartState,
    StopReason, Support, Vibration, YieldElement, YieldLaw, reference,
};

#[test]
fn a_clamp_that_turns_steadily_drags_the_twist_after_it() {
    for ratio in [0.0, 0.2] {
        let body = damped(20.0, ratio);
        let (angle_rad, rate_rad_s) = (0.7, 0.3);
        let support =
            Support { clamp_rad: angle_rad, clamp_rate_rad_s: rate_rad_s, ..Support::default() };
        // Against the clamp the body starts turned back by its angle and moving back at its rate.
        let against = DampedTorsion::new(&body, 1.0 - angle_rad, 0.1 - rate_rad_s);
        for integrator in [RK4_1MS, RECORD] {
            let rig = Rig { support: support.clone(), ..Rig::from(body) };
            let mut run = run(&rig, &StartState::twisted(1.0, 0.1), integrator);
            for time_s in [0.0, 0.5, 7.0, 60.0] {
                let motion = run.motion_at(at_s(time_s)).unwrap();
                let twist_rad = angle_rad + rate_rad_s * time_s + against.twist_rad(time_s);
                let twist_rate = rate_rad_s + against.twist_rate_rad_s(time_s);
                // Some 1e5 roundings of 20 rad, or the tolerance on them.
                assert!((motion.twist_rad - twist_rad).abs() < 5e-10, "{integrator:?} {time_s} s");
                assert!((motion.twist_rate_rad_s - twist_rate).abs() < 5e-10, "{time_s} s");
            }
        }
    }
}

/// Steady answer of u″ + 2a·u′ + Ω²u = A·w²·sin(wt + φ), and its rate.
fn driven(body: &struna_body::Body, swing: &ClampSwing, time_s: f64) -> (f64, f64) {
    let w = TAU * swing.frequency_hz;
    let c = body.params().inertia_kg_m2[2];
    let (stiff, damp) = (body.stiffness_n_m_rad() / c - w * w, body.damping_n_m_s_rad() / c * w);
    let (sin, cos) = (w * time_s + swing.phase_rad).sin_cos();
    let gain = swing.amplitude_rad * w * w / (stiff * stiff + damp * damp);
    (gain * (stiff * sin - damp * cos), gain * w * (stiff * cos + damp * sin))
}

#[test]
fn an_oscillating_clamp_drives_the_twist_as_a_driven_oscillator() {
    // Below, near and above the resonance at 0.05 Hz.
    for (frequency_hz, phase_rad) in [(0.02, 0.0), (0.06, 1.1), (0.3, -0.4)] {
        let body = damped(20.0, 0.1);
        let swing = ClampSwing { amplitude_rad: 0.2, frequency_hz, phase_rad };
        let clamp_rad = |time_s: f64| 0.2 * (TAU * frequency_hz * time_s + phase_rad).sin();
        let (steady_rad, steady_rate) = driven(&body, &swing, 0.0);
        let clamp_rate = 0.2 * TAU * frequency_hz * phase_rad.cos();
        let free =
            DampedTorsion::new(&body, 0.5 - clamp_rad(0.0) - steady_rad, -clamp_rate - steady_rate);
        let support = Support { clamp_swings: vec![swing], ..Support::default() };
        let rig = Rig { support, ..Rig::from(body) };
        for integrator in [RK4_1MS, RECORD] {
            let mut run = run(&rig, &StartState::twisted(0.5, 0.0), integrator);
            for time_s in [1.0, 13.0, 60.0] {
                let expected =
                    clamp_rad(time_s) + free.twist_rad(time_s) + driven(&body, &swing, time_s).0;
                let twist_rad = run.motion_at(at_s(time_s)).unwrap().twist_rad;
                // As above; RK4's (w·h)⁴/120 at 2 rad/s is below 1e-12.
                assert!((twist_rad - expected).abs() < 5e-10, "{frequency_hz} Hz, {time_s} s");
            }
        }
    }
}

#[test]
fn a_yielding_thread_feels_the_turn_against_its_clamp_and_nothing_else() {
    let body = damped(20.0, 0.0);
    let elements =
        vec![YieldElement { stiffness_n_m_rad: 3.0 * body.stiffness_n_m_rad(), yield_rad: 0.2 }];
    let hysteresis = Some(Hysteresis { law: YieldLaw::Slip, elements });
    let still = Rig { hysteresis, ..Rig::from(body) };
    let support = Support { clamp_rad: -0.4, clamp_rate_rad_s: 0.25, ..Support::default() };
    let turning = Rig { support, ..still.clone() };
    for integrator in [RK4_1MS, RECORD] {
        let mut plain = run(&still, &StartState::twisted(2.0, 0.1), integrator);
        let mut moved = run(&turning, &StartState::twisted(1.6, 0.35), integrator);
        for k in 1..=60_i32 {
            let time_s = f64::from(k);
            let (a, b) = (plain.motion_at(at_s(time_s)), moved.motion_at(at_s(time_s)));
            let carried_rad = b.unwrap().twist_rad - (0.25 * time_s - 0.4);
            // The same motion in another frame, up to roundings and tolerance.
            assert!((carried_rad - a.unwrap().twist_rad).abs() < 1e-9, "{integrator:?}, {k} s");
        }
    }
}

#[test]
fn a_creeping_thread_relaxes_as_its_closed_form_does() {
    let body = damped(20.0, 0.0);
    let (time_s, share) = (15.0, 0.4);
    let rig = Rig { creep: Some(Creep { time_s, share }), ..Rig::from(body) };
    let omega2 = body.stiffness_n_m_rad() / body.params().inertia_kg_m2[2];
    // Twist, its rate and the neutral angle of a standard linear solid: a linear system.
    let system =
        Matrix3::new(0.0, 1.0, 0.0, -omega2, 0.0, omega2, share / time_s, 0.0, -1.0 / time_s);
    let start = Vector3::new(2.0, 0.3, 0.0);
    for integrator in [RK4_1MS, RECORD] {
        let mut run = run(&rig, &StartState::twisted(start.x, start.y), integrator);
        for time_s in [0.0, 3.0, 20.0, 100.0] {
            let motion = run.motion_at(at_s(time_s)).unwrap();
            let exact = (system * time_s).exp() * start;
            // Some 1e5 roundings of 2 rad, or the tolerance on them.
            assert!((motion.twist_rad - exact.x).abs() < 2e-10, "{integrator:?}, {time_s} s");
            assert!(
                (motion.twist_rate_rad_s - exact.y).abs() < 2e-10,
                "{integrator:?}, {time_s} s"
            );
        }
    }
    // Of the stiffness only the share that does not creep holds in the end.
    let damped = Rig { body: damped(20.0, 0.5), ..rig };
    let held_n_m = body.stiffness_n_m_rad();
    let mut slow = run(&damped, &StartState::AT_REST, RECORD);
    slow.set_torque(Vector3::z() * held_n_m).unwrap();
    let end_rad = slow.motion_at(at_s(1000.0)).unwrap().twist_rad;
    // The slowest decay, at the rate (1 − share)/time or faster, has gone down to e⁻⁴⁰.
    assert!((end_rad - 1.0 / (1.0 - share)).abs() < 1e-9, "{end_rad}");
}

#[test]
fn a_run_that_stops_says_the_twist_and_not_the_turn_against_the_clamp() {
    let support = Support { clamp_rad: 5.0, clamp_rate_rad_s: 1.0, ..Support::default() };
    let rig = Rig { support, ..Rig::from(damped(480.0, 0.0)) };
    let steep = StartState {
        tilt_rad: 165.0_f64.to_radians(),
        omega_wb_b_rad_s: [6.0, 0.0, 0.0],
        ..StartState::AT_REST
    };
    for integrator in [Integrator::Rk4 { step_s: 1e-3 }, RECORD] {
        match run(&rig, &steep, integrator).motion_at(at_s(1.0)) {
            Err(BodyError::Stopped(stop)) => {
                assert_eq!(stop.reason, StopReason::Overturned, "{stop}");
                // In 15 ms a body that turns about a horizontal axis gains hardly any twist.
                assert!(stop.posture.twist_rad.abs() < 0.1, "{stop}");
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn the_support_keeps_its_own_time_when_the_integration_restarts() {
    let body = damped(20.0, 0.05);
    let element = YieldElement { stiffness_n_m_rad: body.stiffness_n_m_rad(), yield_rad: 0.2 };
    let vibration =
        Vibration { amplitude_w_m: [0.02, 0.01, 0.002], frequency_hz: 0.4, phase_rad: 0.3 };
    let swing = ClampSwing { amplitude_rad: 0.3, frequency_hz: 0.11, phase_rad: 1.0 };
    let support = Support {
        vibrations: vec![vibration],
        clamp_rate_rad_s: 0.1,
        clamp_swings: vec![swing],
        ..Support::default()
    };
    let hysteresis = Some(Hysteresis { law: YieldLaw::Slip, elements: vec![element] });
    let through = Rig { string_length_m: Some(2.0), hysteresis, support, ..Rig::from(body) };
    // Blows of nothing: the integration restarts and the motion goes on.
    let nothing =
        |time_s| Impulse { time: at_s(time_s), angular_b_n_m_s: [0.0; 3], linear_w_n_s: [0.0; 3] };
    let mut restarted = through.clone();
    restarted.disturbances.impulses = [1.234_5, 3.0, 7.891].map(nothing).to_vec();
    for (integrator, allowed) in [(RK4_1MS, 5e-8), (RECORD, 1e-9)] {
        let [a, b] = [&through, &restarted]
            .map(|rig| run(rig, &reference::S2, integrator).motion_at(at_s(20.0)).unwrap());
        let off_rad = difference_rad(&a, &b).max((a.twist_rad - b.twist_rad).abs());
        println!("{integrator:?}: restarts move the motion by {off_rad:.1e} rad");
        // RK4 goes on along another grid, so by its own error; else tolerances accumulated.
        assert!(off_rad < allowed, "{integrator:?}: {off_rad:e}");
    }
}
