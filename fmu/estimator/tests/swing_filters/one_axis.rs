//! One gyro, from a start near the truth on.

use crate::rig::{SAMPLES, STEP_S, Scenario, Truth};
use nalgebra::{SMatrix, SVector};
use struna_estimator::{
    InnovationTest, RateEstimator, SWING_STATES, Status, SwingBelief, SwingConfig, SwingFilter,
};
use struna_kernel::RAD_PER_DEG;

/// What one run comes to. Degrees.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Run {
    pub(crate) rms_deg: f64,
    pub(crate) end_error_deg: f64,
    pub(crate) end_sigma_deg: f64,
    /// Largest error over claimed sigma, from 10 s on.
    pub(crate) worst: f64,
    pub(crate) nees: f64,
    pub(crate) alarms: u64,
}

/// A filter that starts beside the truth of `run`, as far off as it says.
pub(crate) fn near(truth: &mut Truth, config: &SwingConfig) -> SwingFilter {
    let sc: f64 = std::env::var("SC").map_or(1.0, |s| s.parse().unwrap());
    let sample = truth.sample(0);
    let mut mean = truth.states(&sample.motion);
    let omega = mean[6].sqrt();
    let tilt = 0.05 * RAD_PER_DEG;
    let sigmas: [f64; SWING_STATES] = [
        tilt,
        tilt,
        RAD_PER_DEG,
        10.0 * tilt,
        10.0 * tilt,
        0.05 * RAD_PER_DEG,
        0.005 * mean[6],
        0.005 * omega,
        1e-3,
        1e-3,
        0.2,
        0.02 * RAD_PER_DEG,
        0.02 * RAD_PER_DEG,
        0.02 * RAD_PER_DEG,
    ];
    let sigmas = sigmas.map(|s| s * sc);
    for ((mean, sigma), index) in mean.iter_mut().zip(sigmas).zip(30..) {
        *mean += sigma * truth.draw(index);
    }
    let belief = SwingBelief::independent(mean, sigmas);
    SwingFilter::new(config, &InnovationTest::STANDARD, &belief).unwrap()
}

/// Normalised square of the whole error.
fn nees(filter: &SwingFilter, states: &[f64; SWING_STATES]) -> f64 {
    let SwingBelief { mean, covariance } = filter.swing_belief();
    let sigma: [f64; SWING_STATES] = std::array::from_fn(|i| covariance[i][i].sqrt());
    let p = SMatrix::<f64, SWING_STATES, SWING_STATES>::from_fn(|i, j| {
        covariance[i][j] / (sigma[i] * sigma[j])
    });
    let error = SVector::<f64, SWING_STATES>::from_fn(|i, _| (mean[i] - states[i]) / sigma[i]);
    error.dot(&p.cholesky().unwrap().solve(&error))
}

pub(crate) fn run(scenario: Scenario, run: u32, change: impl Fn(&mut SwingConfig)) -> Run {
    let mut truth = Truth::new(scenario, run);
    let mut config = truth.config();
    change(&mut config);
    let mut filter = near(&mut truth, &config);
    let (mut sum, mut worst) = (0.0, 0.0_f64);
    let (mut error, mut sigma) = (0.0, 0.0);
    let mut states = [0.0; SWING_STATES];
    for k in 1..=SAMPLES {
        let sample = truth.sample(k);
        filter.step(STEP_S, sample.measured_rad_s).unwrap();
        let belief = filter.belief();
        error = belief.angle_rad - sample.motion.twist_rad;
        sigma = belief.covariance.angle_rad2.sqrt();
        if k > 1000 {
            worst = worst.max(error.abs() / sigma);
        }
        if k > SAMPLES / 2 {
            sum += error * error;
        }
        states = truth.states(&sample.motion);
    }
    Run {
        rms_deg: (sum / f64::from(SAMPLES / 2)).sqrt() / RAD_PER_DEG,
        end_error_deg: error / RAD_PER_DEG,
        end_sigma_deg: sigma / RAD_PER_DEG,
        worst,
        nees: nees(&filter, &states),
        alarms: filter.alarms(),
    }
}

#[test]
fn a_filter_started_near_the_truth_keeps_to_its_claim() {
    for swing_deg in [5.0, 15.0] {
        for seed in 0..5 {
            let run = run(Scenario::swing(swing_deg), seed, |_| {});
            println!("{swing_deg} {seed} {run:?}");
        }
        for seed in 0..5 {
            let run = run(Scenario::swing(swing_deg), seed, |c| {
                c.swing_walk_s_m3_2 = 0.0;
                c.rate_walk_rad2_s3 = 0.0;
                c.bias_walk_rad2_s3 = 0.0;
            });
            println!("noiseless {swing_deg} {seed} {run:?}");
        }
    }
}
