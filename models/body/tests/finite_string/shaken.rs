//! What a moving support does to the body, and what it cannot do.

use super::{
    JUDGE, LENGTH_M, RK4_1MS, apart_rad, at_ms, hung, infinite, motion, pull_w_n, run, shaken,
    shaking,
};
use std::f64::consts::{FRAC_PI_2, TAU};
use struna_body::{Body, BodyParams, Rig, StartState, Support, Vibration, reference};
use struna_kernel::SimTime;

#[test]
fn energy_less_the_work_of_the_support_is_conserved() {
    for rig in [shaken(hung(LENGTH_M)), shaken(infinite())] {
        let (mut run, step_s) = (run(&rig, &reference::S3, RK4_1MS), 1e-3);
        let mut sample = |k| {
            let time = at_ms(k);
            let motion = motion(&mut run, time);
            let [_, speed, _] = shaking(time.as_s());
            (rig.body.energy_j(&motion), pull_w_n(&rig.body, &motion).dot(&speed))
        };
        let (start_j, mut power_w) = sample(0);
        let (mut work_j, mut worst_j, mut exchanged_j) = (0.0_f64, 0.0_f64, 0.0_f64);
        for k in 0..60_000 {
            // Simpson's rule, whose own error per second is h⁴/180 of a fourth derivative of
            // 1e4 N·m/s⁵: 6e-11 J.
            let (_, middle_w) = sample(2 * k + 1);
            let (energy_j, end_w) = sample(2 * k + 2);
            work_j += step_s / 3.0 * (power_w + 4.0 * middle_w + end_w);
            power_w = end_w;
            worst_j = worst_j.max((energy_j - start_j - work_j).abs());
            exchanged_j = exchanged_j.max(work_j.abs());
        }
        println!("energy less work: {:.1e} of {start_j:.3e} J", worst_j / start_j);
        // Demanded of a conserved energy at this step: RK4 loses 1.4e-9 of it here.
        assert!(worst_j < 2e-8 * start_j, "{worst_j:e} J");
        assert!(exchanged_j > 1e-3, "a test of nothing: {exchanged_j} J exchanged");
    }
}

#[test]
fn velocity_and_acceleration_are_the_derivatives_of_the_place_that_is_reported() {
    for rig in [shaken(hung(LENGTH_M)), shaken(infinite()), hung(0.5)] {
        let mut run = run(&rig, &reference::S3, JUDGE);
        let motions: Vec<_> = (0..=2000).map(|k| motion(&mut run, at_ms(2 * k))).collect();
        let h = 2e-3;
        for window in motions.windows(5) {
            let [a, b, middle, c, d] = window else { unreachable!("windows of five") };
            // Five points: h⁴/30 of the fifth derivative, which is 1e5 rad/s⁵ of a swing of 10°
            // at 10 rad/s times 0.1 m.
            let slope = |at: fn(&_) -> _| (at(a) - at(b) * 8.0 + at(c) * 8.0 - at(d)) / (12.0 * h);
            let velocity = slope(|m: &struna_kernel::BodyMotion| m.com_position_w_m);
            let acceleration = slope(|m| m.com_velocity_w_m_s);
            let turn = slope(|m| m.omega_wb_b_rad_s);
            let time = middle.time;
            assert!((velocity - middle.com_velocity_w_m_s).norm() < 1e-8, "{time}");
            assert!((acceleration - middle.com_acceleration_w_m_s2).norm() < 1e-7, "{time}");
            assert!((turn - middle.angular_acceleration_b_rad_s2).norm() < 1e-6, "{time}");
        }
    }
}

#[test]
fn shaking_sideways_moves_a_body_on_a_finite_string_only() {
    let amplitude_w_m = [0.02, -0.01, 0.0];
    let vibrations = vec![Vibration { amplitude_w_m, frequency_hz: 0.3, phase_rad: 0.4 }];
    let sideways = |rig| {
        let support = Support { vibrations: vibrations.clone(), ..Support::default() };
        Rig { support, ..rig }
    };
    let (mut at_rest, mut moving) = (
        run(&infinite(), &reference::S3, RK4_1MS),
        run(&sideways(infinite()), &reference::S3, RK4_1MS),
    );
    for second in 0..=60 {
        let time = at_ms(1000 * second);
        let (a, b) = (motion(&mut at_rest, time), motion(&mut moving, time));
        let same = (a.q_wb, a.twist_rad, a.spin_rad, a.com_acceleration_w_m_s2)
            == (b.q_wb, b.twist_rad, b.spin_rad, b.com_acceleration_w_m_s2);
        assert!(same, "{time}: the pull of an infinite string has no horizontal part");
    }
    let mut finite = run(&hung(LENGTH_M), &reference::S3, RK4_1MS);
    let mut pulled = run(&sideways(hung(LENGTH_M)), &reference::S3, RK4_1MS);
    // Near the slow mode at 0.34 Hz a centimetre swings the string by a degree and more.
    assert!(apart_rad(&mut finite, &mut pulled, 20) > 0.02);
}

#[test]
fn a_support_that_accelerates_upwards_makes_gravity_stronger() {
    // The start of an oscillation too slow to leave it: s″ = 2 m/s² to (ωt)²/2 = 8e-11.
    let (frequency_hz, rise_m_s2) = (1e-7, 2.0);
    let amplitude_m = -rise_m_s2 / (TAU * frequency_hz).powi(2);
    let lift =
        Vibration { amplitude_w_m: [0.0, 0.0, amplitude_m], frequency_hz, phase_rad: FRAC_PI_2 };
    let gravity_m_s2 = reference::PARAMS.gravity_m_s2 + rise_m_s2;
    let heavier = Body::new(&BodyParams { gravity_m_s2, ..reference::PARAMS }).unwrap();
    for rig in [hung(LENGTH_M), infinite()] {
        let support = Support { vibrations: vec![lift], ..Support::default() };
        let mut lifted = run(&Rig { support, ..rig.clone() }, &reference::S3, RK4_1MS);
        let mut weighty = run(&Rig { body: heavier, ..rig.clone() }, &reference::S3, RK4_1MS);
        let mut usual = run(&rig, &reference::S3, RK4_1MS);
        // 20 s of swing at 10 rad/s turn a 1e-10 of gravity into 1e-8 of a swing of 0.2 rad.
        assert!(apart_rad(&mut lifted.clone(), &mut weighty, 20) < 1e-8);
        assert!(apart_rad(&mut lifted, &mut usual, 20) > 0.1, "a test of nothing");
    }
}

#[test]
fn horizontal_momentum_is_exactly_constant_on_an_infinite_string() {
    let params =
        BodyParams { com_offset_m: [0.01, -0.02], products_kg_m2: [1e-3; 3], ..reference::PARAMS };
    let rig = Rig { body: Body::new(&params).unwrap(), ..shaken(infinite()) };
    let start = StartState { com_velocity_w_m_s: [0.3, -0.7], ..reference::S3 };
    for integrator in [RK4_1MS, JUDGE] {
        let mut run = run(&rig, &start, integrator);
        for second in 0..=60 {
            let velocity = motion(&mut run, at_ms(1000 * second)).com_velocity_w_m_s;
            // No rounding either: nothing is ever added.
            let bits = [velocity.x, velocity.y].map(f64::to_bits);
            assert_eq!(bits, start.com_velocity_w_m_s.map(f64::to_bits), "{second} s");
        }
    }
}

#[test]
fn a_uniform_velocity_carries_the_body_along_and_changes_nothing_else() {
    let still = reference::S3;
    let velocity = [0.3, -0.7];
    let drifting = StartState { com_velocity_w_m_s: velocity, ..still };
    let plain: Rig = hung(LENGTH_M).body.into();
    for rig in [plain, infinite(), shaken(infinite())] {
        let (mut a, mut b) = (run(&rig, &still, RK4_1MS), run(&rig, &drifting, RK4_1MS));
        for second in 0..=60 {
            let time = at_ms(1000 * second);
            let (a, b) = (motion(&mut a, time), motion(&mut b, time));
            assert_eq!((a.q_wb, a.twist_rad), (b.q_wb, b.twist_rad), "{time}");
            let moved = b.com_position_w_m - a.com_position_w_m;
            for axis in 0..2 {
                // 60 s of it in 60 000 roundings of up to 42 m.
                let gap_m = moved[axis] - velocity[axis] * time.as_s();
                assert!(gap_m.abs() < 1e-9, "{time}: {gap_m:e} m");
            }
        }
    }
}

#[test]
fn a_shaken_support_that_starts_off_its_middle_carries_the_string_with_it() {
    // A phase puts the support somewhere else at time zero: A starts below where it is then.
    let support = Vibration { amplitude_w_m: [0.02, 0.0, 0.01], frequency_hz: 0.5, phase_rad: 1.0 };
    let rig = Rig {
        support: Support { vibrations: vec![support], ..Support::default() },
        ..hung(LENGTH_M)
    };
    let start = motion(&mut run(&rig, &StartState::AT_REST, RK4_1MS), SimTime::ZERO);
    let shift = 1.0_f64.sin();
    // One product.
    assert!((start.com_position_w_m.x - 0.02 * shift).abs() < 1e-17);
    assert!((start.com_position_w_m.z - (0.01 * shift - 0.1)).abs() < 1e-16);
}
