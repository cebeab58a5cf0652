//! Air: spin-down, coasting, and where the energy goes.

use crate::{RECORD, RK4_1MS, at_s, limp, run};
use struna_body::{Drag, Rig, StartState, reference};

const AXIAL_KG_M2: f64 = 0.012;

#[test]
fn viscous_air_stops_a_spin_exponentially() {
    let drag = Drag { rotation_n_m_s_rad: 6e-4, ..Drag::NONE };
    let rig = Rig { drag, ..Rig::from(limp()) };
    let decay_s = 6e-4 / AXIAL_KG_M2;
    for integrator in [RK4_1MS, RECORD] {
        let mut run = run(&rig, &StartState::twisted(0.0, 2.0), integrator);
        for time_s in [1.0, 10.0, 60.0_f64] {
            let motion = run.motion_at(at_s(time_s)).unwrap();
            let left = (-decay_s * time_s).exp();
            // Some 1e5 roundings of 2 rad/s, or the tolerance a few times over.
            assert!((motion.omega_wb_b_rad_s.z - 2.0 * left).abs() < 1e-11, "{time_s} s");
            let turned_rad = 2.0 / decay_s * (1.0 - left);
            assert!((motion.twist_rad - turned_rad).abs() < 1e-9, "{time_s} s");
        }
    }
}

#[test]
fn quadratic_air_stops_a_spin_hyperbolically_either_way() {
    let drag = Drag { rotation_quadratic_n_m_s2_rad2: 6e-4, ..Drag::NONE };
    let rig = Rig { drag, ..Rig::from(limp()) };
    let rate_s = 6e-4 / AXIAL_KG_M2 * 2.0;
    for (integrator, sense) in [(RK4_1MS, 1.0), (RECORD, 1.0), (RK4_1MS, -1.0), (RECORD, -1.0)] {
        let mut run = run(&rig, &StartState::twisted(0.0, 2.0 * sense), integrator);
        for time_s in [1.0, 10.0, 60.0_f64] {
            let motion = run.motion_at(at_s(time_s)).unwrap();
            let expected = sense * 2.0 / (1.0 + rate_s * time_s);
            // As above.
            assert!((motion.omega_wb_b_rad_s.z - expected).abs() < 1e-11, "{time_s} s");
            let turned_rad = sense * 2.0 / rate_s * (rate_s * time_s).ln_1p();
            assert!((motion.twist_rad - turned_rad).abs() < 1e-9, "{time_s} s");
        }
    }
}

#[test]
fn a_body_that_coasts_on_an_infinite_string_is_braked_as_a_point() {
    let viscous = Drag { translation_n_s_m: 0.05, ..Drag::NONE };
    let quadratic = Drag { translation_quadratic_n_s2_m2: 0.2, ..Drag::NONE };
    let start = StartState { com_velocity_w_m_s: [0.3, -0.4], ..StartState::twisted(1.0, 0.0) };
    for integrator in [RK4_1MS, RECORD] {
        for drag in [viscous, quadratic] {
            let mut run = run(&Rig { drag, ..Rig::from(limp()) }, &start, integrator);
            for time_s in [1.0, 20.0_f64] {
                let motion = run.motion_at(at_s(time_s)).unwrap();
                // One kilogram, half a metre in a second.
                let (speed, way) = if drag == viscous {
                    let left = (-0.05 * time_s).exp();
                    (0.5 * left, 0.5 / 0.05 * (1.0 - left))
                } else {
                    (0.5 / (1.0 + 0.1 * time_s), 0.5 / 0.1 * (0.1 * time_s).ln_1p())
                };
                let (v, c) = (motion.com_velocity_w_m_s, motion.com_position_w_m);
                // Roundings of some metres in 2e4 steps, or the tolerance on them.
                assert!((v.x - 0.6 * speed).abs() + (v.y + 0.8 * speed).abs() < 1e-10);
                assert!((c.x - 0.6 * way).abs() + (c.y + 0.8 * way).abs() < 1e-9);
                assert!(v.z == 0.0 && motion.omega_wb_b_rad_s.norm() == 0.0, "no torque");
            }
        }
    }
}

#[test]
fn what_a_swinging_body_loses_is_the_power_of_its_drag() {
    let drag = Drag {
        rotation_n_m_s_rad: 1e-3,
        rotation_quadratic_n_m_s2_rad2: 5e-4,
        translation_n_s_m: 0.2,
        translation_quadratic_n_s2_m2: 0.3,
    };
    for string_length_m in [None, Some(2.0)] {
        let rig = Rig { drag, string_length_m, ..Rig::from(limp()) };
        let start = StartState { com_velocity_w_m_s: [0.1, 0.2], ..reference::S3 };
        let mut run = run(&rig, &start, RK4_1MS);
        let mut last: Option<(f64, f64)> = None;
        let (mut worst_j, mut heat_j, mut start_j) = (0.0_f64, 0.0, 0.0);
        for k in 0..=10_000_i32 {
            let motion = run.motion_at(at_s(1e-3 * f64::from(k))).unwrap();
            let (speed, rate) = (motion.com_velocity_w_m_s.norm(), motion.omega_wb_b_rad_s.norm());
            let power_w = (0.2 + 0.3 * speed) * speed.powi(2) + (1e-3 + 5e-4 * rate) * rate.powi(2);
            let energy_j = rig.body.energy_j(&motion);
            match last {
                None => start_j = energy_j,
                Some((_, before_w)) => heat_j += 0.5e-3 * (before_w + power_w),
            }
            worst_j = worst_j.max((energy_j + heat_j - start_j).abs());
            last = Some((energy_j, power_w));
        }
        println!("string {string_length_m:?}: {worst_j:.1e} J of {heat_j:.1e} J unaccounted for");
        assert!(heat_j > 1e-2, "the air must matter");
        // Trapezia 1 ms wide under a power that changes at some (20 rad/s)²: h²/12·400 = 3e-5.
        assert!(worst_j < 3e-5 * heat_j, "{worst_j:e} of {heat_j:e} J");
    }
}
