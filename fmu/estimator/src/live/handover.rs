//! One filter's belief as the start of another.

use crate::augmented::State;
use crate::checks::in_range;
use crate::swing::{SWING_STATES, SwingBelief, SwingConfig};
use crate::{EstimatorError, StartPrior};

/// Places of twist, rate about the axis, Ω², 2ζΩ and bias among the states of the swinging body.
const SHARED: [usize; 5] = [2, 5, 6, 7, 11];
/// What is believed of a body that may or may not swing: somewhere to keep a filter ready.
pub(super) fn ready_of(config: &SwingConfig) -> SwingBelief {
    let start = &config.start;
    let omega = core::f64::consts::TAU / start.period_s;
    let [g1, g2] = config.axis.tilt_b_rad;
    let mut mean = [0.0; SWING_STATES];
    mean[2] = start.angle_rad;
    mean[6..].copy_from_slice(&[
        omega * omega,
        2.0 * start.damping_ratio * omega,
        1.0,
        1.0,
        1.0,
        start.bias_rad_s,
        g1,
        g2,
    ]);
    SwingBelief::independent(mean, [0.0; SWING_STATES])
}

/// The belief of a filter of the swinging body about what a filter of pure torsion knows.
///
/// α = −s·φ to first order; the rate about the axis stands for that of the twist, from which it
/// differs by the coning rate.
pub(super) fn torsion_of(belief: &SwingBelief) -> Result<State, EstimatorError> {
    let [twist, rate, s, d, bias] = SHARED.map(|place| belief.mean[place]);
    let covariance = &belief.covariance;
    let shared = SHARED.map(|row| SHARED.map(|column| covariance[row][column]));
    // Rows of the Jacobian of (α, ω, s, d, b): only that of α is not the identity's.
    let with: [f64; 5] =
        core::array::from_fn(|column| -s * shared[0][column] - twist * shared[2][column]);
    let mut rows = shared;
    rows[0] = with;
    rows[0][0] = -s * with[0] - twist * with[2];
    // Without a spring a filter of pure torsion has no angle.
    if s.is_nan() || s <= 0.0 {
        return Err(EstimatorError::Overflow);
    }
    in_range(rows.iter().flatten().sum())?;
    Ok(State::from_rows([-s * twist, rate, s, d, bias], &rows))
}

/// The same belief of readings that have been multiplied by `gain`: their bias is as much larger.
pub(super) fn with_gain(state: State, gain: f64) -> State {
    let mut scaled = state;
    scaled.mean.bias *= gain;
    for cross in [&mut scaled.p.ab, &mut scaled.p.wb, &mut scaled.p.sb, &mut scaled.p.db] {
        *cross *= gain;
    }
    scaled.p.bb *= gain * gain;
    scaled
}

/// The same belief with an angle less certain by `sigma_rad`.
pub(super) fn blurred(state: State, sigma_rad: f64) -> State {
    let mut blurred = state;
    let sigma = sigma_rad * state.mean.s;
    blurred.p.aa += sigma * sigma;
    blurred
}

/// Angle and rate of `now` and the parameters of `learnt` as the start belief of a fit or a bank.
///
/// Correlations are lost. What a filter that knows of no swing learnt before there was one holds
/// still, at twice its deviation: a swing too small to be seen may have bent it.
pub(super) fn prior_of(now: &State, learnt: &State) -> StartPrior {
    const DOUBT: f64 = 2.0;
    let sigma = |variance: f64| libm::sqrt(variance.max(0.0));
    let (mean, p) = (&now.mean, &now.p);
    let angle_rad = -mean.alpha / mean.s;
    let angle2 = p.aa + angle_rad * (2.0 * p.as_ + angle_rad * p.ss);
    let (s, omega) = (learnt.mean.s, libm::sqrt(learnt.mean.s));
    let period_s = core::f64::consts::TAU / omega;
    StartPrior {
        angle_rad,
        angle_sigma_rad: sigma(angle2) / mean.s,
        rate_rad_s: mean.rate,
        rate_sigma_rad_s: sigma(p.ww),
        period_s,
        period_sigma_s: DOUBT * 0.5 * period_s * sigma(learnt.p.ss) / s,
        damping_ratio: (0.5 * learnt.mean.d / omega).max(0.0),
        damping_ratio_sigma: DOUBT * 0.5 * sigma(learnt.p.dd) / omega,
        bias_rad_s: learnt.mean.bias,
        bias_sigma_rad_s: DOUBT * sigma(learnt.p.bb),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twist_and_stiffness_become_alpha_by_the_delta_method() {
        let mut mean = [0.0; 14];
        (mean[2], mean[5], mean[6], mean[7], mean[11]) = (3.0, 0.1, 0.01, 1e-3, 2e-4);
        let mut covariance = [[0.0; 14]; 14];
        for (k, place) in SHARED.into_iter().enumerate() {
            covariance[place][place] = 1e-6 * (k + 1) as f64;
        }
        (covariance[2][6], covariance[6][2]) = (5e-7, 5e-7);
        (covariance[2][11], covariance[11][2]) = (2e-7, 2e-7);
        let state = torsion_of(&SwingBelief { mean, covariance }).unwrap();
        let close = |a: f64, b: f64| (a - b).abs() <= 4.0 * f64::EPSILON * b.abs();
        assert!(close(state.mean.alpha, -0.03));
        // s²·var τ + 2·s·τ·cov + τ²·var s.
        assert!(close(state.p.aa, 1e-4 * 1e-6 + 2.0 * 0.03 * 5e-7 + 9.0 * 3e-6), "{}", state.p.aa);
        assert!(close(state.p.as_, -0.01 * 5e-7 - 3.0 * 3e-6));
        assert!(close(state.p.ab, -0.01 * 2e-7));
        let scaled = with_gain(state, 2.0);
        assert!(close(scaled.p.bb, 2e-5) && close(scaled.p.ab, 2.0 * state.p.ab));
        assert!(close(scaled.mean.bias, 4e-4) && close(scaled.p.aa, state.p.aa));
        assert!(close(state.p.bb, 5e-6) && close(state.p.ww, 2e-6) && close(state.p.dd, 4e-6));
        let prior = prior_of(&state, &state);
        // And back: the angle's deviation is that of the twist.
        assert!((prior.angle_sigma_rad / 1e-3 - 1.0).abs() < 1e-9, "{}", prior.angle_sigma_rad);
        assert!(close(prior.angle_rad, 3.0));
        mean[6] = 0.0;
        assert!(torsion_of(&SwingBelief { mean, covariance }).is_err(), "no spring, no angle");
    }
}
