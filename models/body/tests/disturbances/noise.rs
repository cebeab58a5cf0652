//! White torque noise: its size, its path, and how steps converge to that path.

use crate::{at_s, difference_rad, limp, run};
use nalgebra::Vector3;
use struna_body::ode::{Rhs, rk4_step};
use struna_body::{
    Body, BodyEquations, Disturbances, Integrator, Rig, STATES, StartState, TorqueNoise, reference,
};
use struna_kernel::{AddressedRandom, Channel, Seed};

/// √S of S = 1e-14 (N·m)²/Hz.
const DENSITY: f64 = 1e-7;

fn noisy(body: Body, grid_hz: f64, density_b_n_m_sqrt_hz: [f64; 3], run: u64) -> Rig {
    let noise = Some(TorqueNoise { density_b_n_m_sqrt_hz });
    let disturbances =
        Disturbances { seed: Seed(11), run, grid_hz, noise, ..Disturbances::default() };
    Rig { disturbances, ..Rig::from(body) }
}

const PATHS: u64 = 600;
const SPAN_S: f64 = 0.25;

/// Standard deviation over [`PATHS`] runs of the spin rate after [`SPAN_S`], over √(S·t)/C.
fn relative_spread(grid_hz: f64, density: f64) -> f64 {
    let square = |k: u64| {
        let rig = noisy(limp(), grid_hz, [0.0, 0.0, density], k);
        let mut run = run(&rig, &StartState::AT_REST, Integrator::Rk4 { step_s: 0.01 });
        run.motion_at(at_s(SPAN_S)).unwrap().omega_wb_b_rad_s.z.powi(2)
    };
    let variance = (0..PATHS).map(square).sum::<f64>() / PATHS as f64;
    variance.sqrt() / (DENSITY * SPAN_S.sqrt() / 0.012)
}

/// Grids whose periods differ by four and by sixteen.
const GRIDS_HZ: [f64; 3] = [350.0, 1400.0, 5600.0];

/// 600 paths leave √(1/1200) = 3 % of uncertainty.
fn is_right(relative: f64) -> bool {
    (relative - 1.0).abs() < 0.08
}

#[test]
fn the_spread_of_a_free_spin_is_that_of_its_spectral_density_on_every_grid() {
    let spreads = GRIDS_HZ.map(|grid_hz| relative_spread(grid_hz, DENSITY));
    println!("spread over theory at {GRIDS_HZ:?} Hz: {spreads:?}");
    assert!(spreads.into_iter().all(is_right), "{spreads:?}");
}

#[test]
fn a_torque_of_the_same_size_on_every_grid_would_not_pass_for_white() {
    // The classic mistake, put back: the held value no longer grows as 1/√Δ. Chosen right at
    // 1400 Hz, it is wrong by two on grids four times as coarse and as fine.
    let mistaken = |grid_hz: f64| DENSITY * (1400.0 / grid_hz).sqrt();
    let [coarse, _, fine] = GRIDS_HZ.map(|grid_hz| (grid_hz, mistaken(grid_hz)));
    for ((grid_hz, density), expected) in [(coarse, 2.0), (fine, 0.5)] {
        let spread = relative_spread(grid_hz, density);
        assert!(!is_right(spread), "{grid_hz} Hz: {spread}");
        assert!((spread / expected - 1.0).abs() < 0.08, "{grid_hz} Hz: {spread}");
    }
}

/// The noise of a run, cell by cell, from its address alone.
struct Path {
    random: AddressedRandom,
    sigma_n_m: f64,
}

impl Path {
    fn new(grid_hz: f64, run: u64) -> Self {
        let random = AddressedRandom::new(Seed(11), Channel::TorqueNoise, run);
        Self { random, sigma_n_m: DENSITY * grid_hz.sqrt() }
    }

    fn mean_n_m(&mut self, cells: std::ops::Range<u64>) -> Vector3<f64> {
        let count = (cells.end - cells.start) as f64;
        let value = |cell: u64| {
            Vector3::from_fn(|axis, _| {
                self.sigma_n_m * self.random.standard_normal(3 * cell + axis as u64)
            })
        };
        cells.map(value).sum::<Vector3<f64>>() / count
    }
}

/// S3 on a path of `grid_hz`, walked by steps of `cells` cells under the mean torque of each.
fn walked(grid_hz: u32, run: u64, cells: u64, end_s: u32) -> [f64; STATES] {
    let body = Body::new(&reference::PARAMS).unwrap();
    let mut path = Path::new(grid_hz.into(), run);
    let mut y = BodyEquations::states(&reference::S3);
    for k in 0..u64::from(end_s * grid_hz) / cells {
        let torque = path.mean_n_m(k * cells..(k + 1) * cells);
        let equations = BodyEquations::new(&body, &reference::S3, torque);
        y = rk4_step(&equations, 0.0, &y, cells as f64 / f64::from(grid_hz));
        equations.project(&mut y);
    }
    y
}

#[test]
fn the_noise_of_a_cell_follows_from_seed_run_cell_and_axis() {
    let body = Body::new(&reference::PARAMS).unwrap();
    let (grid_hz, run_number) = (1000_u32, 3);
    let rig = noisy(body, grid_hz.into(), [DENSITY; 3], run_number);
    let step = Integrator::Rk4 { step_s: 1e-3 };
    let motion = run(&rig, &reference::S3, step).motion_at(at_s(5.0)).unwrap();
    let quiet = run(&Rig::from(body), &reference::S3, step).motion_at(at_s(5.0)).unwrap();
    assert!(difference_rad(&motion, &quiet) > 1e-5, "the noise must act");
    let y = walked(grid_hz, run_number, 1, 5);
    let off = (motion.omega_wb_b_rad_s - Vector3::new(y[3], y[4], y[5])).norm();
    // Two arrangements of the same equations over 5000 steps of rates up to 2 rad/s.
    assert!(off < 1e-10, "{off:e} rad/s");
}

#[test]
fn sub_steps_within_a_cell_follow_the_same_path() {
    let rig = noisy(Body::new(&reference::PARAMS).unwrap(), 1400.0, [DENSITY; 3], 0);
    let end = |sub_steps: f64| {
        let step_s = 1.0 / (1400.0 * sub_steps);
        run(&rig, &reference::S3, Integrator::Rk4 { step_s }).motion_at(at_s(20.0)).unwrap()
    };
    let finest = end(8.0);
    for sub_steps in [1.0, 4.0] {
        let off_rad = difference_rad(&end(sub_steps), &finest);
        println!("{sub_steps} sub-steps a cell against 8: {off_rad:.1e} rad");
        // Demand of cross-validation: the integrator's own error, 4.3e-10 rad where measured.
        assert!(off_rad <= 2e-9, "{sub_steps}: {off_rad:e}");
    }
}

#[test]
fn held_noise_converges_strongly_with_order_one() {
    const FINEST_HZ: u32 = 11_200;
    let (end_s, paths) = (5, 8);
    let mut sums = [(2, 0.0), (4, 0.0), (8, 0.0), (16, 0.0), (32, 0.0_f64)];
    for path in 0..paths {
        let exact = walked(FINEST_HZ, path, 1, end_s);
        for (cells, sum) in &mut sums {
            let y = walked(FINEST_HZ, path, *cells, end_s);
            // The small rotation between the two: of the vertical, and of the twist about it.
            *sum += [0, 1, 2, 6].map(|i: usize| (y[i] - exact[i]).powi(2)).iter().sum::<f64>();
        }
    }
    let errors = sums.map(|(cells, sum)| (cells as f64, (sum / paths as f64).sqrt()));
    println!("rms attitude error by cells a step: {errors:?} rad");
    let n = errors.len() as f64;
    let logs = errors.map(|(h, e)| (h.log2(), e.log2()));
    let (mean_h, mean_e) = logs.iter().fold((0.0, 0.0), |(a, b), (h, e)| (a + h / n, b + e / n));
    let over: f64 = logs.iter().map(|(h, e)| (h - mean_h) * (e - mean_e)).sum();
    let order = over / logs.iter().map(|(h, _)| (h - mean_h).powi(2)).sum::<f64>();
    assert!((0.8..=1.2).contains(&order), "order {order:.2}: {errors:?}");
    // Fresh draws at another step are another path, thousands of times further away.
    let fresh = walked(FINEST_HZ / 8, 0, 1, end_s);
    let same = walked(FINEST_HZ, 0, 1, end_s);
    let apart = 2.0 * (0..4).map(|i| (fresh[i] - same[i]).powi(2)).sum::<f64>().sqrt();
    assert!(apart > 100.0 * errors[2].1, "{apart:e}");
}
