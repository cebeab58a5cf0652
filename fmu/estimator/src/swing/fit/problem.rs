//! What is sought, what is believed of it beforehand, and in what units.

use crate::swing::{MotionParameters, MotionState, SwingConfig, SwingMotion};

/// Unknowns of the fit: the states of the filter that takes over, in its order. These are e₁, e₂,
/// twist (rad), p, q, r (rad/s), Ω² (1/s²), 2ζΩ (1/s), scales of A and B, scale of the swing's
/// decay, bias (rad/s), g₁, g₂.
pub(super) use crate::swing::SWING_STATES as UNKNOWNS;

/// One number per unknown.
pub(super) type Unknowns = [f64; UNKNOWNS];

pub(super) const EX: usize = 0;
pub(super) const TWIST: usize = 2;
pub(super) const P: usize = 3;
pub(super) const R: usize = 5;
pub(super) const STIFFNESS: usize = 6;
pub(super) const DAMPING: usize = 7;
pub(super) const SCALE_A: usize = 8;
pub(super) const SCALE_B: usize = 9;
pub(super) const DECAY: usize = 10;
pub(super) const BIAS: usize = 11;
pub(super) const G1: usize = 12;
pub(super) const G2: usize = 13;

/// One degree, rad.
pub(super) const DEG: f64 = core::f64::consts::PI / 180.0;

/// Spread of the rate about the body's axis at the start, rad/s, at least: 1 °/s.
const RATE_SIGMA_MIN_RAD_S: f64 = DEG;
/// Spread of Ω² at least, relative, and of 2ζΩ, of Ω.
const TORSION_SIGMA_MIN: f64 = 0.02;
/// Bounds of the scales of A and B: beyond, the body is another one.
const SCALE: (f64, f64) = (0.8, 1.2);
/// Bounds of Ω² over the believed one.
const STIFFNESS_RATIO: (f64, f64) = (0.25, 4.0);
/// Bounds of the scale of the swing's decay.
const DECAY_SCALE: (f64, f64) = (0.0, 10.0);
/// Largest component of the gyro's axis across the body's: both at once leave a direction.
const ASKEW_MAX: f64 = 0.7;
/// Longest motion that a fit follows with equal steps.
const SUBSTEPS_MAX: u32 = 64;

/// How a window starts, beyond what the configuration says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct WindowStart {
    /// Believed twist and its standard deviation, rad.
    pub(super) twist_rad: (f64, f64),
    /// Believed rate about the body's axis and its standard deviation, rad/s.
    pub(super) rate_rad_s: (f64, f64),
}

/// The least-squares problem of one window: model, noise, priors.
///
/// The unknowns are handled as u = (x − mean)/sigma: numbers of order one, whose prior is the unit
/// matrix.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Problem {
    pub(super) motion: SwingMotion,
    /// Time from the start to the middle of the first averaged sample, s.
    pub(super) first_s: f64,
    /// Step of the model and how many of them make an averaged sample.
    pub(super) step_s: f64,
    pub(super) substeps: u32,
    /// Whether derivatives good enough to tell valleys apart will do.
    pub(super) rough: bool,
    /// 1/√R of an averaged sample.
    pub(super) inverse_noise: f64,
    pub(super) mean: Unknowns,
    pub(super) sigma: Unknowns,
}

impl Problem {
    /// The problem of a window that starts as `start` says, with a swing of about `swing_rad`.
    pub(super) fn new(
        config: &SwingConfig,
        period_s: f64,
        start: &WindowStart,
        swing_rad: f64,
    ) -> Self {
        let (mean, sigma) = prior(config, start, swing_rad);
        let problem = Self {
            motion: SwingMotion::new(&config.body),
            first_s: 0.0,
            step_s: 0.0,
            substeps: 1,
            rough: false,
            inverse_noise: 0.0,
            mean,
            sigma,
        };
        problem.averaging(config, period_s, 1)
    }

    /// The same problem for samples of which `averaged` at a time have been averaged.
    pub(super) fn averaging(
        mut self,
        config: &SwingConfig,
        period_s: f64,
        averaged: usize,
    ) -> Self {
        let count = averaged as f64;
        // Averaging is chosen so that one step follows the swing; without it that is asked for.
        let substeps = if averaged > 1 { 1 } else { self.motion.steps_in(period_s) };
        self.substeps = substeps.min(SUBSTEPS_MAX);
        self.rough = averaged > 1;
        self.first_s = 0.5 * (count - 1.0) * period_s;
        self.step_s = count * period_s / f64::from(self.substeps);
        self.inverse_noise = libm::sqrt(count / config.measurement_variance_rad2_s2);
        self
    }

    /// The unknowns themselves.
    pub(super) fn x(&self, u: &Unknowns) -> Unknowns {
        core::array::from_fn(|i| self.mean[i] + self.sigma[i] * u[i])
    }

    /// The scaled unknowns of `x`; zero for what is known for certain.
    pub(super) fn u(&self, x: &Unknowns) -> Unknowns {
        core::array::from_fn(|i| {
            if self.sigma[i] > 0.0 { (x[i] - self.mean[i]) / self.sigma[i] } else { 0.0 }
        })
    }

    /// `u`, with every unknown moved inside its bounds.
    pub(super) fn within_bounds(&self, u: Unknowns) -> Unknowns {
        let mut bounded = u;
        let stiffness = self.mean[STIFFNESS];
        let (least, most) = STIFFNESS_RATIO;
        for (i, low, high) in [
            (STIFFNESS, least * stiffness, most * stiffness),
            (SCALE_A, SCALE.0, SCALE.1),
            (SCALE_B, SCALE.0, SCALE.1),
            (G1, -ASKEW_MAX, ASKEW_MAX),
            (G2, -ASKEW_MAX, ASKEW_MAX),
            (DECAY, DECAY_SCALE.0, DECAY_SCALE.1),
        ] {
            if self.sigma[i] > 0.0 {
                let (low, high) =
                    ((low - self.mean[i]) / self.sigma[i], (high - self.mean[i]) / self.sigma[i]);
                // A prior outside the bounds stays where it is.
                bounded[i] = u[i].max(low.min(0.0)).min(high.max(0.0));
            }
        }
        bounded
    }
}

/// Means and standard deviations before any sample.
fn prior(config: &SwingConfig, start: &WindowStart, swing_rad: f64) -> (Unknowns, Unknowns) {
    let believed = &config.start;
    let omega = core::f64::consts::TAU / believed.period_s;
    let stiffness = omega * omega;
    let swing_rate = swing_rad * config.body.swing_frequency_rad_s();
    let [g1, g2] = config.axis.tilt_b_rad;
    let stiffness_sigma = 2.0 * believed.period_sigma_s / believed.period_s;
    let damping_sigma = 2.0 * omega * believed.damping_ratio_sigma;
    let mut mean = [0.0; UNKNOWNS];
    let mut sigma = [0.0; UNKNOWNS];
    for (i, value, spread) in [
        (EX, 0.0, swing_rad),
        (EX + 1, 0.0, swing_rad),
        (TWIST, start.twist_rad.0, start.twist_rad.1),
        (P, 0.0, swing_rate),
        (P + 1, 0.0, swing_rate),
        (R, start.rate_rad_s.0, start.rate_rad_s.1),
        (STIFFNESS, stiffness, stiffness * stiffness_sigma.max(TORSION_SIGMA_MIN)),
        (
            DAMPING,
            2.0 * believed.damping_ratio * omega,
            damping_sigma.max(TORSION_SIGMA_MIN * omega),
        ),
        (SCALE_A, 1.0, config.inertia_sigma),
        (SCALE_B, 1.0, config.inertia_sigma),
        (BIAS, believed.bias_rad_s, believed.bias_sigma_rad_s),
        (G1, g1, config.axis.tilt_sigma_rad),
        (G2, g2, config.axis.tilt_sigma_rad),
        (DECAY, 1.0, config.swing_damping_sigma),
    ] {
        mean[i] = value;
        sigma[i] = spread;
    }
    (mean, sigma)
}

/// How the first window starts: as the configuration believes.
///
/// The rate about the body's axis is the twist's plus what the swing cones, up to ω_s·a²/2.
pub(super) fn first_start(config: &SwingConfig, swing_rad: f64) -> WindowStart {
    let believed = &config.start;
    let coning = 0.25 * config.body.swing_frequency_rad_s() * swing_rad * swing_rad;
    let spread = libm::hypot(believed.rate_sigma_rad_s.max(RATE_SIGMA_MIN_RAD_S), coning);
    WindowStart {
        twist_rad: (believed.angle_rad, believed.angle_sigma_rad),
        rate_rad_s: (believed.rate_rad_s, spread),
    }
}

/// State and parameters of the motion among the unknowns.
pub(super) fn motion_of(x: &Unknowns) -> (MotionState, MotionParameters) {
    let [ex, ey, twist, p, q, r, stiffness, damping, scale_a, scale_b, decay, ..] = *x;
    let parameters = [stiffness, damping, scale_a, scale_b, decay];
    let state = MotionState::from_entries([ex, ey, twist, p, q, r]);
    (state, MotionParameters::from_entries(parameters))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::{InputAxis, StartPrior, SwingBody};

    /// A body of equal moments that hangs untwisted, on a gyro one degree askew.
    pub(in crate::swing::fit) fn config() -> SwingConfig {
        let body = SwingBody {
            mass_kg: 1.0,
            com_depth_m: 0.1,
            inertia_kg_m2: [0.01, 0.01, 0.01],
            gravity_m_s2: 9.81,
            swing_damping_1_s: 0.0,
        };
        let axis = InputAxis::towards(DEG, 2.0, 0.1 * DEG);
        SwingConfig::quiet(body, axis, StartPrior::released(0.0, 120.0), 2e-3 * DEG * DEG)
    }

    pub(in crate::swing::fit) fn problem() -> Problem {
        let config = config();
        Problem::new(&config, 0.01, &first_start(&config, 0.1), 0.1)
    }

    #[test]
    fn scaled_unknowns_are_unscaled_again() {
        let problem = problem();
        let u: Unknowns = core::array::from_fn(|i| 0.1 * i as f64 - 0.3);
        let back = problem.u(&problem.x(&u));
        assert!(u.iter().zip(back).all(|(u, back)| (u - back).abs() < 1e-12), "{back:?}");
    }

    #[test]
    fn what_is_certain_is_not_moved() {
        let certain = SwingConfig { swing_damping_sigma: 0.0, ..config() };
        let problem = Problem::new(&certain, 0.01, &first_start(&certain, 0.1), 0.1);
        let x = problem.x(&[3.0; UNKNOWNS]);
        assert!((x[DECAY] - 1.0).abs() < f64::EPSILON);
        assert!(problem.u(&x)[DECAY].abs() < f64::EPSILON);
    }

    #[test]
    fn unknowns_stay_within_their_bounds() {
        let problem = problem();
        for far in [-1e3, 1e3] {
            let x = problem.x(&problem.within_bounds([far; UNKNOWNS]));
            for scale in [x[SCALE_A], x[SCALE_B]] {
                assert!((0.8 - 1e-12..=1.2 + 1e-12).contains(&scale), "{scale}");
            }
            assert!(x[STIFFNESS] > 0.2 * problem.mean[STIFFNESS]);
            assert!((-1e-12..=10.0).contains(&x[DECAY]));
            assert!(x[G1].hypot(x[G2]) < 1.0, "the axis is a direction");
        }
    }

    #[test]
    fn averaged_samples_lie_in_their_middle_and_are_quieter() {
        let config = config();
        let one = problem();
        let two = one.clone().averaging(&config, 0.01, 2);
        assert!((two.first_s - 0.005).abs() < 1e-15 && (two.step_s - 0.02).abs() < 1e-15);
        let quieter = (two.inverse_noise / one.inverse_noise).powi(2);
        assert!((quieter - 2.0).abs() < 1e-12);
        assert_eq!(two.averaging(&config, 0.01, 1), one);
    }
}
