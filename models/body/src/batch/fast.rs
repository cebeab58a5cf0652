//! The fast form of the equations for one body.

use super::block::LaneState;
use super::step::{Coefficients, FAST_STATES, TWIST, norm2, rescale};
use crate::ode::Rhs;
use crate::{Body, BodyError, StartState};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
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
/// γ₃ at the largest tilt, cos 170°.
const LOWEST: f64 = -0.984_807_753_012_208_1;

/// The motion of one body without its quaternion.
///
/// States, in this order: the vertical in body components γ = Rᵀe_z, the rate ω (body components,
/// rad/s), the twist τ (rad), the spin ∫ω_z dt (rad). The motion never needs the attitude, and the
/// attitude follows from γ and τ when it is wanted, since swing and twist make it up. One state
/// and one division fewer than [`crate::BodyEquations`], and to the bit what a [`super::Batch`]
/// computes for each of its bodies when driven by [`crate::ode::Rk4`].
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
        let g = start.attitude().inverse_transform_vector(&Vector3::z());
        let [w1, w2, w3] = start.omega_wb_b_rad_s;
        Ok([g.x, g.y, g.z, w1, w2, w3, start.twist_rad, start.twist_rad])
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

/// The attitude whose vertical is `g` and whose twist is `twist_rad`.
fn attitude(g: [f64; 3], twist_rad: f64) -> UnitQuaternion<f64> {
    // The vertical before the twist turned it away, so the horizontal axis of the swing.
    let (sin, cos) = twist_rad.sin_cos();
    let (h1, h2) = (cos * g[0] - sin * g[1], sin * g[0] + cos * g[1]);
    let half_cos = (0.5 * (1.0 + g[2])).sqrt();
    let (x, y) = (0.5 * h2 / half_cos, -0.5 * h1 / half_cos);
    let (st, ct) = (0.5 * twist_rad).sin_cos();
    let q = Quaternion::new(half_cos * ct, x * ct + y * st, y * ct - x * st, half_cos * st);
    UnitQuaternion::from_quaternion(q)
}

/// Whether the equations hold for a body of a batch, and have held at every step so far: upright
/// enough, and its string taut.
pub(super) fn is_sound(lane: &LaneState) -> bool {
    lane.state.iter().all(|state| state.is_finite())
        && (norm2(&lane.state) - 1.0).abs() < NORM2_SLACK
        && lane.lowest.min(lane.state[2]) >= LOWEST
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
        (norm2(y) - 1.0).abs() < NORM2_SLACK && y[2] >= LOWEST
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

    #[test]
    fn attitude_and_states_describe_each_other() {
        for (tilt_rad, tilt_azimuth_rad, twist_rad) in
            [(0.0, 0.0, 0.0), (0.3, 1.0, 7.0), (2.5, -2.0, -40.0), (1e-9, 3.0, 0.1)]
        {
            let start = StartState { tilt_rad, tilt_azimuth_rad, twist_rad, ..StartState::AT_REST };
            let states = FastEquations::start(&start).unwrap();
            let motion = FastEquations::motion(SimTime::ZERO, &states);
            let off = 2.0 * (motion.q_wb.inverse() * start.attitude()).imag().norm();
            // A dozen roundings, and those of a twist of 40 rad through its sine.
            assert!(off < 1e-14, "tilt {tilt_rad}: {off:e} rad");
        }
    }
}
