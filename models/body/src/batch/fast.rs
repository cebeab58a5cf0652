//! The fast form of the equations for one body.

use super::block::LaneState;
use super::step::{Coefficients, FAST_STATES, TWIST, norm2, rescale};
use crate::attitude::{VERTICAL_MIN, attitude, vertical};
use crate::ode::Rhs;
use crate::{Body, BodyError, StartState};
use nalgebra::{UnitQuaternion, Vector3};
use struna_kernel::SimTime;

/// The motion as the fast form knows it: no integrals but the spin, no place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FastMotion {
    /// The instant.
    pub time: SimTime,
    /// Attitude: carries body components into world components.
    pub q_wb: UnitQuaternion<f64>,
    /// Rate of body relative to world, in body components, rad/s.
    pub omega_wb_b_rad_s: Vector3<f64>,
    /// Twist of the string, rad.
    pub twist_rad: f64,
    /// Rate of the twist, rad/s.
    pub twist_rate_rad_s: f64,
    /// Integral of the body z rate since the twist was zero, rad.
    pub spin_rad: f64,
}

/// Deviation of |γ|² from one that only a step far too long can leave.
const NORM2_SLACK: f64 = 0.01;

/// The motion of one body, with all that can be had for the least work.
///
/// States, in this order: the vertical in body components γ = Rᵀe_z, the rate ω (body components,
/// rad/s), the twist τ (rad), the spin ∫ω_z dt (rad). Two integrals and one division fewer than
/// [`crate::BodyEquations`], and to the bit what a [`super::Batch`] computes for each of its bodies
/// when driven by [`crate::ode::Rk4`].
#[derive(Debug, Clone, Copy)]
pub struct FastEquations {
    body: Coefficients<f64>,
    torque_n_m: [f64; 3],
}

impl FastEquations {
    /// The equations of `body` under `torque_b_n_m`, a torque in body components besides gravity
    /// and string.
    #[must_use]
    pub fn new(body: &Body, torque_b_n_m: [f64; 3]) -> Self {
        Self { body: Coefficients::of(body), torque_n_m: torque_b_n_m }
    }

    /// The states of a start.
    ///
    /// # Errors
    /// [`BodyError::Parameter`] for a start that [`StartState::check`] refuses.
    pub fn start(start: &StartState) -> Result<[f64; FAST_STATES], BodyError> {
        start.check()?;
        let [g1, g2, g3] = vertical(&start.attitude());
        let [w1, w2, w3] = start.omega_wb_b_rad_s;
        Ok([g1, g2, g3, w1, w2, w3, start.twist_rad, start.twist_rad])
    }

    /// The motion that `states` describe. The attitude cannot disagree with the twist, because it
    /// is made of it: q = swing(γ)·twist(τ).
    #[must_use]
    pub fn motion(time: SimTime, states: &[f64; FAST_STATES]) -> FastMotion {
        let [g1, g2, g3, w1, w2, w3, twist_rad, spin_rad] = *states;
        let twist_rate_rad_s = w3 + (w1 * g1 + w2 * g2) / (1.0 + g3);
        FastMotion {
            time,
            q_wb: attitude([g1, g2, g3], twist_rad),
            omega_wb_b_rad_s: Vector3::new(w1, w2, w3),
            twist_rad,
            twist_rate_rad_s,
            spin_rad,
        }
    }
}

/// Whether the equations hold for a body of a batch, and have held at every step so far: upright
/// enough, and its string taut.
pub(super) fn is_sound(lane: &LaneState) -> bool {
    lane.state.iter().all(|state| state.is_finite())
        && (norm2(&lane.state) - 1.0).abs() < NORM2_SLACK
        && lane.lowest.min(lane.state[2]) >= VERTICAL_MIN
        && lane.least_pull_n_m >= 0.0
}

impl Rhs<FAST_STATES> for FastEquations {
    #[inline(always)]
    fn derivative(&self, _time_s: f64, y: &[f64; FAST_STATES]) -> [f64; FAST_STATES] {
        let (mut rates, pull) = self.body.derivative(y, &self.torque_n_m, 0.0);
        // A string cannot push: the step that would need it ends the run.
        rates[TWIST] = if pull >= 0.0 { rates[TWIST] } else { f64::NAN };
        rates
    }

    #[inline(always)]
    fn project(&self, y: &mut [f64; FAST_STATES]) {
        rescale(y);
    }

    #[inline(always)]
    fn admissible(&self, _time_s: f64, y: &[f64; FAST_STATES]) -> bool {
        (norm2(y) - 1.0).abs() < NORM2_SLACK && y[2] >= VERTICAL_MIN
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{TILT_MAX_RAD, reference};

    #[test]
    fn the_domain_ends_at_the_largest_tilt() {
        let equations = FastEquations::new(&Body::new(&reference::PARAMS).unwrap(), [0.0; 3]);
        for (tilt_rad, inside) in [(TILT_MAX_RAD - 1e-6, true), (TILT_MAX_RAD + 1e-6, false)] {
            let y = [tilt_rad.sin(), 0.0, tilt_rad.cos(), 0.0, 0.0, 0.0, 0.0, 0.0];
            assert_eq!(equations.admissible(0.0, &y), inside, "{tilt_rad}");
            let lane =
                LaneState { state: y, elastic_rad: [0.0; 4], lowest: 1.0, least_pull_n_m: 1.0 };
            assert_eq!(is_sound(&lane), inside, "{tilt_rad}");
            assert!(!is_sound(&LaneState { least_pull_n_m: -1e-9, ..lane }), "a slack string");
        }
    }
}
