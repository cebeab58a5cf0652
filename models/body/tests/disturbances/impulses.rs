//! Blows: what they change, what they leave, and when.

use crate::{RECORD, RK4_1MS, at_s, damped, difference_rad, limp, run};
use nalgebra::{Matrix3, Vector3};
use struna_body::{
    Body, BodyParams, Disturbances, Impulse, Integrator, PoissonImpulses, Rig, StartState,
    TorqueNoise, reference,
};
use struna_kernel::{BodyMotion, SampleGrid, Seed, SimTime};

const NS_AFTER: i64 = 1;

fn blow(time_s: f64, angular_b_n_m_s: [f64; 3], linear_w_n_s: [f64; 3]) -> Impulse {
    Impulse { time: at_s(time_s), angular_b_n_m_s, linear_w_n_s }
}

fn struck(rig: Rig, impulses: Vec<Impulse>) -> Rig {
    Rig { disturbances: Disturbances { impulses, ..Disturbances::default() }, ..rig }
}

/// The motion a nanosecond after `impulse`, without and with it.
///
/// A nanosecond of the accelerations that a blow changes, under 100 rad/s², is 1e-7 of the jumps
/// below; [`JUMP_REL`] is ten times that.
fn around(rig: &Rig, start: &StartState, impulse: Impulse, by: Integrator) -> [BodyMotion; 2] {
    let after = SimTime::from_ns(impulse.time.as_ns() + NS_AFTER);
    let rigs = [rig.clone(), struck(rig.clone(), vec![impulse])];
    rigs.map(|rig| run(&rig, start, by).motion_at(after).unwrap())
}

const JUMP_REL: f64 = 1e-6;

#[test]
fn a_blow_about_the_axis_of_a_hanging_body_changes_its_rate_by_impulse_over_moment() {
    // Rate and twist as of two free torsions that follow one another.
    let body = damped(20.0, 0.1);
    let rig = struck(Rig::from(body), vec![blow(3.2, [0.0, 0.0, 0.006], [0.0; 3])]);
    for integrator in [RK4_1MS, RECORD] {
        let mut run = run(&rig, &StartState::twisted(1.0, 0.0), integrator);
        let before = struna_body::DampedTorsion::new(&body, 1.0, 0.0);
        let (twist_rad, rate) = (before.twist_rad(3.2), before.twist_rate_rad_s(3.2) + 0.5);
        let after = struna_body::DampedTorsion::new(&body, twist_rad, rate);
        assert!(
            (run.motion_at(at_s(3.0)).unwrap().twist_rad - before.twist_rad(3.0)).abs() < 1e-11
        );
        for time_s in [0.001, 1.0, 30.0] {
            let motion = run.motion_at(at_s(3.2 + time_s)).unwrap();
            // Some 1e5 roundings of 2 rad, or the tolerance on them.
            assert!((motion.twist_rad - after.twist_rad(time_s)).abs() < 1e-10, "{time_s} s");
            let off = motion.twist_rate_rad_s - after.twist_rate_rad_s(time_s);
            assert!(off.abs() < 1e-10, "{time_s} s");
        }
    }
}

#[test]
fn a_blow_turns_the_inertia_that_the_string_leaves_the_body() {
    let body = Body::new(&reference::PARAMS).unwrap();
    let p = body.params();
    for (start, time_s) in [(StartState::AT_REST, 0.5), (reference::S3, 1.7), (reference::S3, 0.0)]
    {
        for angular in [[0.003, 0.0, 0.0], [0.0, -0.002, 0.0], [0.001, 0.002, -0.003]] {
            let [free, hit] =
                around(&Rig::from(body), &start, blow(time_s, angular, [0.0; 3]), RK4_1MS);
            let g = free.q_wb.inverse_transform_vector(&Vector3::z());
            let u = Vector3::new(-g.y, g.x, 0.0);
            let constrained: Matrix3<f64> =
                body.inertia_b_kg_m2() + u * u.transpose() * p.mass_kg * p.com_depth_m.powi(2);
            let expected = constrained.try_inverse().unwrap() * Vector3::from(angular);
            let jump = hit.omega_wb_b_rad_s - free.omega_wb_b_rad_s;
            assert!((jump - expected).norm() < JUMP_REL * expected.norm(), "{jump} {expected}");
            let coasting = (hit.com_velocity_w_m_s - free.com_velocity_w_m_s).xy();
            assert!(coasting.norm() == 0.0, "an infinite string pulls straight up");
        }
    }
}

#[test]
fn a_hanging_body_is_not_lifted_by_a_blow() {
    let body = Body::new(&reference::PARAMS).unwrap();
    let impulse = blow(1.0, [0.004, 0.003, 0.002], [0.3, -0.2, 0.0]);
    let [free, hit] = around(&Rig::from(body), &StartState::AT_REST, impulse, RK4_1MS);
    // The velocity itself, not the jump: what a nanosecond of swing at 0.5 rad/s lifts.
    assert!((hit.com_velocity_w_m_s.z - free.com_velocity_w_m_s.z).abs() < 1e-9);
}

#[test]
fn a_horizontal_push_through_the_centre_moves_the_centre_and_turns_nothing() {
    let body = Body::new(&reference::PARAMS).unwrap();
    for start in [StartState::AT_REST, reference::S3] {
        let impulse = blow(0.7, [0.0; 3], [0.3, -0.2, 0.0]);
        let [free, hit] = around(&Rig::from(body), &start, impulse, RECORD);
        let jump = hit.com_velocity_w_m_s - free.com_velocity_w_m_s;
        assert!((jump - Vector3::new(0.3, -0.2, 0.0)).norm() < 1e-9, "{jump}");
        assert!((hit.omega_wb_b_rad_s - free.omega_wb_b_rad_s).norm() < 1e-9);
    }
}

/// Velocity of the suspended point, world components, m/s.
fn suspension_velocity_w_m_s(body: &Body, motion: &BodyMotion) -> Vector3<f64> {
    let swing = motion.omega_wb_b_rad_s.cross(&body.suspension_b_m());
    motion.com_velocity_w_m_s + motion.q_wb * swing
}

#[test]
fn any_blow_on_any_string_is_answered_along_the_string_alone() {
    let params = BodyParams {
        com_offset_m: [0.01, -0.02],
        products_kg_m2: [4e-4, -3e-4, 5e-4],
        mass_kg: 1.3,
        ..reference::PARAMS
    };
    let body = Body::new(&params).unwrap();
    let start = StartState { suspension_w_m: [0.3, -0.2], ..reference::S3 };
    for string_length_m in [None, Some(1.5)] {
        let rig = Rig { string_length_m, ..Rig::from(body) };
        let impulse = blow(0.9, [0.004, -0.003, 0.002], [0.2, 0.1, -0.3]);
        let [free, hit] = around(&rig, &start, impulse, RK4_1MS);
        // Where the string points, from the place of the point that it holds.
        let held = free.com_position_w_m + free.q_wb * body.suspension_b_m();
        let string = string_length_m
            .map_or(Vector3::z(), |length_m| (Vector3::z() * length_m - held) / length_m);
        let off = string.norm() - 1.0;
        assert!(off.abs() < 1e-9, "the string keeps its length: {off:e}");
        let jump = suspension_velocity_w_m_s(&body, &hit) - suspension_velocity_w_m_s(&body, &free);
        assert!(jump.norm() > 0.1, "the point must move");
        assert!(jump.dot(&string).abs() < JUMP_REL * jump.norm(), "off the sphere: {jump}");
        // One reaction along the string, the same in both balances.
        let momentum = body.params().mass_kg * (hit.com_velocity_w_m_s - free.com_velocity_w_m_s)
            - Vector3::from(impulse.linear_w_n_s);
        let reaction_n_s = momentum.dot(&string);
        assert!((momentum - string * reaction_n_s).norm() < JUMP_REL, "{momentum}");
        let lever = body.suspension_b_m().cross(&free.q_wb.inverse_transform_vector(&string));
        let angular = body.inertia_b_kg_m2() * (hit.omega_wb_b_rad_s - free.omega_wb_b_rad_s)
            - Vector3::from(impulse.angular_b_n_m_s);
        let off = (angular - lever * reaction_n_s).norm();
        // Moments of 0.01 kg·m² and rates of 1 rad/s.
        assert!(off < JUMP_REL * 0.01, "{off:e}");
    }
}

#[test]
fn the_sample_at_the_instant_of_a_blow_still_shows_the_motion_before() {
    let body = Body::new(&reference::PARAMS).unwrap();
    for (integrator, time_s) in [(RK4_1MS, 0.0), (RK4_1MS, 0.7), (RECORD, 0.0), (RECORD, 0.7)] {
        let linear = [0.1, 0.0, 0.0];
        let impulses =
            vec![blow(time_s, [0.0, 0.0, 0.006], linear), blow(time_s, [0.0; 3], linear)];
        // Both rigs take the full equations, so both take the same steps.
        let spared = struck(Rig::from(body), vec![blow(99.0, [0.0; 3], [0.0; 3])]);
        let mut hit = run(&struck(Rig::from(body), impulses), &reference::S3, integrator);
        let mut free = run(&spared, &reference::S3, integrator);
        let (at, after) = (at_s(time_s), SimTime::from_ns(at_s(time_s).as_ns() + NS_AFTER));
        assert_eq!(hit.motion_at(at).unwrap(), free.motion_at(at).unwrap(), "{integrator:?}");
        let (hit, free) = (hit.motion_at(after).unwrap(), free.motion_at(after).unwrap());
        let spun = hit.omega_wb_b_rad_s.z - free.omega_wb_b_rad_s.z;
        // A nanosecond under at most 100 rad/s².
        assert!((spun - 0.5).abs() < 1e-6, "{spun}");
        let pushed = hit.com_velocity_w_m_s.x - free.com_velocity_w_m_s.x;
        assert!((pushed - 0.2).abs() < 1e-9, "two blows at once add up: {pushed}");
    }
}

#[test]
fn the_motion_under_disturbances_does_not_depend_on_its_samples() {
    let disturbances = Disturbances {
        seed: Seed(5),
        grid_hz: 70.0,
        noise: Some(TorqueNoise { density_b_n_m_sqrt_hz: [1e-5; 3] }),
        impulses: vec![blow(1.234_567, [0.001; 3], [0.1; 3]), blow(0.5, [0.001; 3], [0.0; 3])],
        poisson: Some(PoissonImpulses { rate_hz: 3.0, angular_sigma_b_n_m_s: [1e-4; 3] }),
        ..Disturbances::default()
    };
    let rig = Rig { disturbances, ..Rig::from(limp()) };
    for integrator in [RK4_1MS, RECORD] {
        let ends = [1.0, 70.0, 300.0].map(|rate_hz| {
            let grid = SampleGrid::new(SimTime::ZERO, rate_hz).unwrap();
            let mut run = run(&rig, &reference::S3, integrator);
            (0..=grid.periods_until(at_s(4.0)))
                .map(|k| run.motion_at(grid.time_of(k)).unwrap())
                .last()
                .unwrap()
        });
        assert_eq!(ends[0], ends[1], "{integrator:?}");
        assert_eq!(ends[0], ends[2], "{integrator:?}");
    }
}

#[test]
fn random_blows_repeat_with_their_seed_and_run_and_with_no_other() {
    let end = |seed: u64, run_number: u64| {
        let disturbances = Disturbances {
            seed: Seed(seed),
            run: run_number,
            poisson: Some(PoissonImpulses { rate_hz: 5.0, angular_sigma_b_n_m_s: [1e-4; 3] }),
            ..Disturbances::default()
        };
        let rig = Rig { disturbances, ..Rig::from(limp()) };
        run(&rig, &StartState::AT_REST, RK4_1MS).motion_at(at_s(2.0)).unwrap()
    };
    assert_eq!(end(1, 7), end(1, 7));
    for other in [end(1, 8), end(2, 7)] {
        assert!((other.omega_wb_b_rad_s - end(1, 7).omega_wb_b_rad_s).norm() > 1e-4);
    }
}

#[test]
fn a_damped_and_kicked_swing_is_followed_alike_by_fixed_and_adaptive_steps() {
    // A minute with a kick off every grid, which no step may span.
    let kick = blow(20.123_456_7, [0.002, -0.001, 0.003], [0.1, 0.0, 0.0]);
    let rig = struck(Rig::from(damped(480.0, 0.1)), vec![kick]);
    let end = |integrator| run(&rig, &reference::S3, integrator).motion_at(at_s(60.0)).unwrap();
    let record = end(RECORD);
    let errors_rad =
        [2e-3, 1e-3].map(|step_s| difference_rad(&end(Integrator::Rk4 { step_s }), &record));
    println!("damped and kicked S3, RK4 2 and 1 ms: {errors_rad:?} rad");
    // Unkicked S3 errs by 7.5e-9 rad at 1 ms; the kick adds half as much swing.
    assert!(errors_rad[1] < 2e-8, "{errors_rad:?}");
    let order = (errors_rad[0] / errors_rad[1]).log2();
    assert!((order - 4.0).abs() < 0.1, "a step across the kick would cost the order: {order}");
}
