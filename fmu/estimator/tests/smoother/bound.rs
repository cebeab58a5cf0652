//! The least error that any smoother can have: the covariance recursion along the true trajectory,
//! forward and back.

use crate::rig::{A, B, C, PERIOD_S, R_RAD2_S2, Rig, SAMPLES, STEP_S, Scenario};
use nalgebra::{SMatrix, SVector};
use std::sync::LazyLock;
use struna_kernel::RAD_PER_DEG;

type Matrix5 = SMatrix<f64, 5, 5>;

/// Runs over which the bound is averaged; it varies by the few per cent of their periods.
const RUNS: u32 = 4;

/// Bounds in A, B and C of the RMS over the whole run: angle, deg, and rate, deg/s.
pub(crate) static OF_A: LazyLock<(f64, f64)> = LazyLock::new(|| bound(A));
pub(crate) static OF_B: LazyLock<(f64, f64)> = LazyLock::new(|| bound(B));
pub(crate) static OF_C: LazyLock<(f64, f64)> = LazyLock::new(|| bound(C));

fn bound(scenario: Scenario) -> (f64, f64) {
    let sums = (0..RUNS).map(|run| mean_variances(scenario, run));
    let (angle2, rate2) = sums.fold((0.0, 0.0), |sum, run| (sum.0 + run.0, sum.1 + run.1));
    ((angle2 / f64::from(RUNS)).sqrt(), (rate2 / f64::from(RUNS)).sqrt())
}

/// Mean variances of angle and rate over a run, deg² and (deg/s)².
///
/// In the states (φ, φ′, Ω², 2ζΩ, b), degrees, by textbook: P + G·(P′ − P⁻)·Gᵀ.
fn mean_variances(scenario: Scenario, run: u32) -> (f64, f64) {
    let mut rig = Rig::new(scenario, run);
    let (s, d) = rig.parameters();
    let h = SVector::<f64, 5>::new(0.0, 1.0, 0.0, 0.0, 1.0);
    let r = R_RAD2_S2 / (RAD_PER_DEG * RAD_PER_DEG);
    let mut noise = Matrix5::zeros();
    noise[(1, 1)] = scenario.acceleration_density_deg2_s3.max(1e-9) * STEP_S;
    noise[(4, 4)] = 1e-12 * STEP_S;
    let (mut angle, mut rate) = (360.0, 0.0);
    let mut p = prior(scenario);
    let mut steps = Vec::with_capacity(SAMPLES as usize);
    for k in 1..=SAMPLES {
        let mut f = Matrix5::zeros();
        f[(0, 1)] = 1.0;
        f.set_row(1, &SVector::<f64, 5>::new(-s, -d, -angle, -rate, 0.0).transpose());
        // Two terms of the exponential: the third is (Ω·h)³ = 2e-12.
        let f = Matrix5::identity() + f * STEP_S + f * f * (STEP_S * STEP_S / 2.0);
        let later = f * p * f.transpose() + noise;
        steps.push((p, f, later));
        let column = later * h;
        let gain = column / (h.dot(&column) + r);
        p = later - gain * column.transpose();
        p = (p + p.transpose()) * 0.5;
        let truth = rig.sample(k);
        (angle, rate) = (truth.angle_rad / RAD_PER_DEG, truth.rate_rad_s / RAD_PER_DEG);
    }
    let (mut angle2, mut rate2) = (0.0, 0.0);
    let unit = scale();
    let per_unit = unit.map(|x| if x > 0.0 { 1.0 / x } else { 0.0 });
    for (filtered, f, later) in steps.into_iter().rev() {
        angle2 += p[(0, 0)];
        rate2 += p[(1, 1)];
        // Scaled, so that numbers of like size are inverted.
        let inverse = (per_unit * later * per_unit).try_inverse().unwrap();
        let gain = filtered * f.transpose() * per_unit * inverse * per_unit;
        p = filtered + gain * (p - later) * gain.transpose();
        p = (p + p.transpose()) * 0.5;
    }
    (angle2 / f64::from(SAMPLES), rate2 / f64::from(SAMPLES))
}

/// About what is known of each state at the end.
fn scale() -> Matrix5 {
    Matrix5::from_diagonal(&SVector::<f64, 5>::new(0.1, 1e-3, 5e-9, 5e-8, 1e-4))
}

fn prior(scenario: Scenario) -> Matrix5 {
    let omega = std::f64::consts::TAU / PERIOD_S;
    Matrix5::from_diagonal(&SVector::<f64, 5>::new(
        scenario.start_sigma_deg.max(0.1).powi(2),
        1e-4,
        (0.02 * omega * omega).powi(2),
        (0.02 * omega).powi(2),
        scenario.bias_sigma_deg_s.max(1e-3).powi(2),
    ))
}
