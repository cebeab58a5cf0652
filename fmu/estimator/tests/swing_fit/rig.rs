//! A body that swings while it turns, and a gyro askew on it: the truth and what is believed of it.

use crate::swinging::{self, DAMPING_RATIO, INERTIA_KG_M2};
use nalgebra::Vector3;
use std::f64::consts::TAU;
use struna_body::{Impulse, Integrator, Rig, TruthMotion};
use struna_estimator::{AcceptedFit, MotionState, StartPrior, SwingConfig, SwingFit};
use struna_kernel::{Channel, RAD_PER_DEG, RandomStream, Seed, SimTime};

/// Sample period, s.
pub(crate) const PERIOD_S: f64 = 0.01;
/// Variance of a sample, rad²/s²: 2e-3 (°/s)².
pub(crate) const NOISE_RAD2_S2: f64 = 2e-3 * RAD_PER_DEG * RAD_PER_DEG;
/// Decay of the swing, 1/s, a part of the torsion's.
const DECAY_1_S: f64 = 1e-3;

/// What a case is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Case {
    pub(crate) swing_deg: f64,
    pub(crate) seed: u64,
    pub(crate) seconds: u32,
    pub(crate) torsion_s: f64,
    /// Time of a kick of 0.5 °/s about each axis, s.
    pub(crate) kick_s: Option<f64>,
    /// Decay of the swing in truth over the believed one.
    pub(crate) decay_scale: f64,
    /// Short over long axis of the swing's ellipse; drawn from −1 to 1 when not given.
    pub(crate) ratio: Option<f64>,
}

impl Case {
    pub(crate) const fn new(swing_deg: f64, seed: u64, seconds: u32) -> Self {
        Self {
            swing_deg,
            seed,
            seconds,
            torsion_s: 120.0,
            kick_s: None,
            decay_scale: 1.0,
            ratio: None,
        }
    }
}

/// Twist and rate of the twist, rad and rad/s.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Truth {
    pub(crate) twist_rad: f64,
    pub(crate) twist_rate_rad_s: f64,
}

/// What a run is made of: truth and measurement at every sample, and what is believed beforehand.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) truth: Vec<Truth>,
    pub(crate) measured_rad_s: Vec<f64>,
    pub(crate) config: SwingConfig,
}

impl Run {
    pub(crate) fn of(case: &Case) -> Self {
        let mut draws = RandomStream::new(Seed(case.seed), Channel::StartError, 0);
        let azimuth = TAU * draws.uniform();
        let axis_azimuth = TAU * draws.uniform();
        let ratio = case.ratio.unwrap_or(2.0 * draws.uniform() - 1.0);
        let normal: [f64; 6] = std::array::from_fn(|_| draws.standard_normal());
        let bias_rad_s = 0.05 * RAD_PER_DEG * normal[0];
        let start = swinging::start(case.swing_deg * RAD_PER_DEG, azimuth, ratio);
        let tilt = RAD_PER_DEG.sin();
        let across = [tilt * axis_azimuth.cos(), tilt * axis_azimuth.sin()];
        let axis = Vector3::new(across[0], across[1], RAD_PER_DEG.cos());
        let mut motion =
            TruthMotion::new(rig(case), &start, Integrator::Rk4 { step_s: 2e-3 }).unwrap();
        let mut noise = RandomStream::new(Seed(case.seed), Channel::GyroAngleRandomWalk, 0);
        let mut run = Self {
            truth: Vec::new(),
            measured_rad_s: Vec::new(),
            config: config(case, across, &normal),
        };
        for k in 0..100 * case.seconds {
            let motion = motion.motion_at(SimTime::from_s(f64::from(k) * PERIOD_S).unwrap());
            let motion = motion.unwrap();
            let white = NOISE_RAD2_S2.sqrt() * noise.standard_normal();
            run.measured_rad_s.push(axis.dot(&motion.omega_wb_b_rad_s) + bias_rad_s + white);
            run.truth.push(Truth {
                twist_rad: motion.twist_rad,
                twist_rate_rad_s: motion.twist_rate_rad_s,
            });
        }
        run
    }

    /// A fit that has been given all samples, and has not begun.
    pub(crate) fn fit(&self) -> SwingFit {
        self.fit_of(&self.measured_rad_s)
    }

    /// The same, given these samples.
    pub(crate) fn fit_of(&self, samples: &[f64]) -> SwingFit {
        let mut fit = SwingFit::new(&self.config, PERIOD_S).unwrap();
        samples.iter().for_each(|rate| fit.push(*rate));
        fit
    }

    /// How far a fit is off at the end of its window.
    pub(crate) fn error(&self, fit: &AcceptedFit) -> Error {
        let truth = self.truth[usize::try_from(fit.samples).unwrap() - 1];
        let state: [f64; 6] = std::array::from_fn(|i| fit.belief.mean[i]);
        let (rate, by) = MotionState::from_entries(state).twist_rate_rad_s().unwrap();
        let variance: f64 = (0..6)
            .flat_map(|i| (0..6).map(move |j| (i, j)))
            .map(|(i, j)| by[i] * fit.belief.covariance[i][j] * by[j])
            .sum();
        Error {
            twist_sigmas: (fit.belief.mean[2] - truth.twist_rad).abs()
                / fit.belief.covariance[2][2].sqrt(),
            rate_sigmas: (rate - truth.twist_rate_rad_s).abs() / variance.sqrt(),
        }
    }
}

/// Errors over what was claimed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Error {
    pub(crate) twist_sigmas: f64,
    pub(crate) rate_sigmas: f64,
}

fn rig(case: &Case) -> Rig {
    let mut rig = swinging::rig(case.torsion_s, DAMPING_RATIO, case.decay_scale * DECAY_1_S);
    let kick = 0.5 * RAD_PER_DEG;
    rig.disturbances.impulses.extend(case.kick_s.map(|time_s| Impulse {
        time: SimTime::from_s(time_s).unwrap(),
        angular_b_n_m_s: INERTIA_KG_M2.map(|moment| moment * kick),
        linear_w_n_s: [0.0; 3],
    }));
    rig
}

/// What is believed: a start within 10°, a bias of 0 ± 0.05 °/s, a misalignment known to 0.1° per
/// axis, moments wrong by 1 % and 0.5 %.
fn config(case: &Case, across: [f64; 2], normal: &[f64; 6]) -> SwingConfig {
    let axis = swinging::believed_axis(across, [normal[1], normal[2]]);
    let body = swinging::believed_body(DECAY_1_S);
    let start = StartPrior {
        angle_rad: TAU + 10.0 * RAD_PER_DEG * normal[3],
        angle_sigma_rad: 10.0 * RAD_PER_DEG,
        period_s: case.torsion_s * (1.0 + 0.01 * normal[4]),
        damping_ratio: DAMPING_RATIO + 0.01 * normal[5],
        ..StartPrior::released(TAU, case.torsion_s)
    };
    SwingConfig::quiet(body, axis, start, NOISE_RAD2_S2)
}
