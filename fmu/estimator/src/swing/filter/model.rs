//! All of the one-axis filter that does not evolve: how it predicts, expects and updates.

use super::SwingBelief;
use super::gaussian::{Expectation, GYRO, Gaussian, RATES, Row, SWING_STATES, TWIST, Walks};
use crate::checks::in_range;
use crate::config::ConfigError;
use crate::swing::config::SwingConfig;
use crate::swing::motion::{ExpectedRate, MOTION_STATES, SwingMotion};
use crate::{Belief, Covariance, EstimatorError, Innovation};

/// How far Ω² may be led from what the configuration says, either way, as a factor.
const STIFFNESS_SPAN: f64 = 100.0;
/// How far 2ζΩ may be led, in units of the believed Ω: below zero, and above.
const DAMPING_SPAN: (f64, f64) = (0.5, 20.0);
/// How far the moments may be led: beyond, this is another body.
const SCALE_SPAN: (f64, f64) = (0.8, 1.2);
/// How far the decay of the swing may be led, in units of the nominal one.
const AIR_SPAN: (f64, f64) = (-10.0, 10.0);
/// How far each component of the input axis may be led.
const AXIS_MAX: f64 = 0.7;

/// Least and greatest values of the states that are bounded: those from Ω² on.
pub(crate) type Bounds = [(f64, f64); SWING_STATES - MOTION_STATES];

/// Bounds of the parameters of the motion, and of the three states of the gyros.
pub(crate) fn bounds(config: &SwingConfig, gyro: [f64; 3]) -> Bounds {
    let omega = core::f64::consts::TAU / config.start.period_s;
    let stiffness = omega * omega;
    let [first, second, third] = gyro.map(|most| (-most, most));
    [
        (stiffness / STIFFNESS_SPAN, stiffness * STIFFNESS_SPAN),
        (-DAMPING_SPAN.0 * omega, DAMPING_SPAN.1 * omega),
        SCALE_SPAN,
        SCALE_SPAN,
        AIR_SPAN,
        first,
        second,
        third,
    ]
}

/// Keeps the body one that could be hung: a wild measurement could lead a moment below zero.
#[inline(always)]
pub(crate) fn bounded(mut state: Gaussian, bounds: &Bounds) -> Gaussian {
    for (value, (low, high)) in state.mean[MOTION_STATES..].iter_mut().zip(bounds) {
        *value = value.clamp(*low, *high);
    }
    state
}

/// Whether a parameter has been led to the end of its bounds.
pub(crate) fn is_at_a_bound(state: &Gaussian, bounds: &Bounds) -> bool {
    let mut values = state.mean[MOTION_STATES..].iter().zip(bounds);
    values.any(|(value, (low, high))| value <= low || value >= high)
}

/// Twist and its rate, with what is claimed of them; a scale factor wrong by ε is wrong by ε of
/// both at once.
pub(crate) fn belief(state: &Gaussian, scale_factor_variance: f64) -> Belief {
    let motion = state.motion();
    // A state within the chart has a twist rate; a filter holds no other.
    let (rate_rad_s, by) = motion.twist_rate_rad_s().unwrap_or((0.0, [0.0; MOTION_STATES]));
    let (mut cross, mut rate2) = (0.0, 0.0);
    for (by_i, row) in by.iter().zip(&state.p) {
        cross += by_i * row[TWIST];
        let along: f64 = by.iter().zip(row).map(|(by_j, p)| by_j * p).sum();
        rate2 += by_i * along;
    }
    let (angle_rad, scale) = (motion.twist_rad, scale_factor_variance);
    Belief {
        angle_rad,
        rate_rad_s,
        covariance: Covariance {
            angle_rad2: state.p[TWIST][TWIST] + scale * angle_rad * angle_rad,
            cross_rad2_s: cross + scale * angle_rad * rate_rad_s,
            // Rounding, when the rate is known far better than the tilt that it is a sum over.
            rate_rad2_s2: rate2.max(0.0) + scale * rate_rad_s * rate_rad_s,
        },
    }
}

/// The innovation, if a gain can be formed of it and a residual be squared.
#[inline(always)]
pub(crate) fn innovation(residual: f64, variance: f64) -> Result<Innovation, EstimatorError> {
    if !(variance > 0.0 && variance <= f64::MAX) {
        return Err(EstimatorError::SingularInnovation { variance_rad2_s2: variance });
    }
    in_range(residual * residual)?;
    Ok(Innovation { residual_rad_s: residual, variance_rad2_s2: variance })
}

/// The one-axis filter's model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Model {
    pub(super) motion: SwingMotion,
    pub(super) r: f64,
    walks: Walks,
    bounds: Bounds,
    scale_factor_variance: f64,
    /// Least expected rate, and least measured rate, that are over range.
    range_edges: (f64, f64),
}

impl Model {
    /// For a configuration that has been validated.
    pub(super) fn new(config: &SwingConfig) -> Self {
        Self {
            motion: SwingMotion::new(&config.body),
            r: config.measurement_variance_rad2_s2,
            walks: Walks::new(config, [config.bias_walk_rad2_s3, 0.0, 0.0]),
            bounds: bounds(config, [f64::MAX, AXIS_MAX, AXIS_MAX]),
            scale_factor_variance: config.scale_factor_sigma * config.scale_factor_sigma,
            range_edges: config
                .range
                .map_or((f64::INFINITY, f64::INFINITY), |range| range.edges_rad_s()),
        }
    }

    /// The state that a belief is, if it can be one.
    pub(super) fn started(&self, belief: &SwingBelief) -> Result<Gaussian, ConfigError> {
        belief.validate()?;
        let state = Gaussian { mean: belief.mean, p: belief.covariance };
        Ok(bounded(state, &self.bounds))
    }

    #[inline(always)]
    pub(super) fn predicted(
        &self,
        from: &Gaussian,
        span_s: f64,
    ) -> Result<Gaussian, EstimatorError> {
        from.predicted(&self.motion, &self.walks, span_s)
    }

    #[inline(always)]
    pub(super) fn expected(
        &self,
        at: &Gaussian,
        rate_rad_s: f64,
    ) -> Result<Expectation, EstimatorError> {
        let [p, q, r] = [at.mean[RATES], at.mean[RATES + 1], at.mean[RATES + 2]];
        let [bias, x, y] = [at.mean[GYRO], at.mean[GYRO + 1], at.mean[GYRO + 2]];
        let ExpectedRate { rate_rad_s: expected, by_omega, by_tilt } =
            ExpectedRate::new([p, q, r], [x, y], bias)?;
        let row = Row { by_omega, by_gyro: [1.0, by_tilt[0], by_tilt[1]] };
        Ok(at.expect(rate_rad_s - expected, &row))
    }

    #[inline(always)]
    pub(super) fn innovation(&self, expected: &Expectation) -> Result<Innovation, EstimatorError> {
        innovation(expected.residual, expected.spread + self.r)
    }

    #[inline(always)]
    pub(super) fn updated(
        &self,
        from: &Gaussian,
        expected: &Expectation,
        r: f64,
    ) -> Result<Gaussian, EstimatorError> {
        bounded(from.updated(expected, r), &self.bounds).judged()
    }

    #[inline(always)]
    pub(super) fn is_over_range(&self, rate_rad_s: f64, residual_rad_s: f64) -> bool {
        let expected_rad_s = rate_rad_s - residual_rad_s;
        (expected_rad_s.abs() >= self.range_edges.0) | (rate_rad_s.abs() >= self.range_edges.1)
    }

    pub(super) fn is_at_a_bound(&self, state: &Gaussian) -> bool {
        is_at_a_bound(state, &self.bounds)
    }

    pub(super) fn bounded(&self, state: Gaussian) -> Gaussian {
        bounded(state, &self.bounds)
    }

    pub(super) fn belief(&self, state: &Gaussian) -> Belief {
        belief(state, self.scale_factor_variance)
    }
}
