//! The motion of the body on its string in five degrees of freedom, and its exact sensitivities.
//!
//! The motion is carried by one classical Runge-Kutta step at a time; its sensitivities are the
//! exact derivatives of that step, not of the motion that the step stands for.

mod equations;
mod measurement;
mod rough;
mod step;
#[cfg(test)]
mod tests;

pub use measurement::ExpectedRate;
pub use step::{MOTION_TANGENTS, Tangents};

use crate::{EstimatorError, SwingBody};

/// States of the motion: e₁, e₂, twist, and three rates.
pub const MOTION_STATES: usize = 6;
/// Parameters of the motion: Ω², 2ζΩ, scales of A and B, scale of the swing's decay.
pub const MOTION_PARAMETERS: usize = 5;

/// Phase of the fastest swing in one step of integration, rad, at most. The step then mistakes the
/// swing's frequency by 4e-6 of itself, far less than A is known.
const STEP_PHASE_MAX_RAD: f64 = 0.15;

/// Attitude and rate of the body, as far as they decide how it moves on.
///
/// The azimuth of the swing against the room decides nothing and is no state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionState {
    /// The upward vertical in body axes: components along x and y. The third is √(1 − e₁² − e₂²),
    /// positive: the body hangs at less than a right angle.
    pub e: [f64; 2],
    /// Twist of the string from equilibrium, turns included, rad.
    pub twist_rad: f64,
    /// Rate of the body in body axes, rad/s.
    pub omega_rad_s: [f64; 3],
}

/// What a filter may learn of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionParameters {
    /// s = Ω² = k/C of the torsion, 1/s².
    pub stiffness_1_s2: f64,
    /// d = 2ζΩ of the torsion of a body that does not swing, air included, 1/s.
    pub damping_1_s: f64,
    /// The moment A over the believed one.
    pub scale_a: f64,
    /// The moment B over the believed one.
    pub scale_b: f64,
    /// The decay of the swing over the nominal one.
    pub swing_damping_scale: f64,
}

impl MotionState {
    /// (e₁, e₂, twist, three rates).
    #[must_use]
    #[inline(always)]
    pub const fn entries(&self) -> [f64; MOTION_STATES] {
        let ([x, y], [p, q, r]) = (self.e, self.omega_rad_s);
        [x, y, self.twist_rad, p, q, r]
    }

    /// The state with these [`entries`](Self::entries).
    #[must_use]
    #[inline(always)]
    pub const fn from_entries(entries: [f64; MOTION_STATES]) -> Self {
        let [x, y, twist_rad, p, q, r] = entries;
        Self { e: [x, y], twist_rad, omega_rad_s: [p, q, r] }
    }

    /// Component of the vertical along the body's own axis, cos θ; none when the body hangs at a
    /// right angle or beyond.
    #[must_use]
    #[inline(always)]
    pub fn e3(&self) -> Option<f64> {
        let [x, y] = self.e;
        let across = x * x + y * y;
        (across < 1.0).then(|| libm::sqrt(1.0 - across))
    }

    /// Rate of the twist, ω·(e + e₃)/(1 + e₃·e), rad/s, and its derivatives by the six states.
    ///
    /// # Errors
    /// [`EstimatorError::TiltTooLarge`] when the body hangs at a right angle or beyond.
    pub fn twist_rate_rad_s(&self) -> Result<(f64, [f64; MOTION_STATES]), EstimatorError> {
        let e3 = self.e3().ok_or(EstimatorError::TiltTooLarge)?;
        let ([x, y], [p, q, r]) = (self.e, self.omega_rad_s);
        let f = 1.0 / (1.0 + e3);
        let v = x * p + y * q;
        let slope = f * f / e3 * v;
        let by = [f * p + slope * x, f * q + slope * y, 0.0, f * x, f * y, 1.0];
        Ok((r + f * v, by))
    }

    /// Angle θ between the body's axis and the vertical, rad; π/2 when it is that or more.
    #[must_use]
    pub fn tilt_rad(&self) -> f64 {
        libm::asin(libm::hypot(self.e[0], self.e[1]).min(1.0))
    }
}

impl MotionParameters {
    /// A torsion of the given s = Ω² and d = 2ζΩ, and a body exactly as believed.
    #[must_use]
    pub const fn as_believed(stiffness_1_s2: f64, damping_1_s: f64) -> Self {
        Self { stiffness_1_s2, damping_1_s, scale_a: 1.0, scale_b: 1.0, swing_damping_scale: 1.0 }
    }

    /// (Ω², 2ζΩ, scale of A, scale of B, scale of the swing's decay).
    #[must_use]
    #[inline(always)]
    pub const fn entries(&self) -> [f64; MOTION_PARAMETERS] {
        let Self { stiffness_1_s2, damping_1_s, scale_a, scale_b, swing_damping_scale } = *self;
        [stiffness_1_s2, damping_1_s, scale_a, scale_b, swing_damping_scale]
    }

    /// The parameters with these [`entries`](Self::entries).
    #[must_use]
    #[inline(always)]
    pub const fn from_entries(entries: [f64; MOTION_PARAMETERS]) -> Self {
        let [stiffness_1_s2, damping_1_s, scale_a, scale_b, swing_damping_scale] = entries;
        Self { stiffness_1_s2, damping_1_s, scale_a, scale_b, swing_damping_scale }
    }
}

/// The equations of motion of one body.
///
/// With e the vertical in body axes, u = e₃ × e, J = diag(A, B, C) and τ the twist:
///
/// ```text
/// e' = e × ω        τ' = ω·(e + e₃)/(1 + e₃·e)
/// (J + M d² u uᵀ) ω' = −ω × Jω + M d (g − d e₃·((e × ω) × ω)) u + N
/// N = −(k τ + c τ') (e + e₃)/(1 + e₃·e) − c_air ω
/// ```
///
/// k = C·s. The air is isotropic, c_air = scale·λ·(A + B) of the believed moments; the thread
/// damps what of the torsion the air does not, c = C·d − c_air, so that d is the damping of the
/// torsion whatever the air does. This chart carries turns beyond 360°, which a quaternion cannot;
/// it ends where the body hangs at a right angle.
///
/// # Source
/// Ivanov and Ovchinnikov, KIAM preprint, 2008, section 3, in its non-singular form.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SwingMotion {
    mass_kg: f64,
    com_depth_m: f64,
    inertia_kg_m2: [f64; 3],
    gravity_m_s2: f64,
    /// Torque of the air at the nominal decay over the rate, N·m·s/rad.
    air_n_m_s_rad: f64,
    swing_rad_s: f64,
}

impl SwingMotion {
    /// The equations for `body`, which has been [validated](SwingBody::validate).
    #[must_use]
    pub fn new(body: &SwingBody) -> Self {
        let [a, b, _] = body.inertia_kg_m2;
        Self {
            mass_kg: body.mass_kg,
            com_depth_m: body.com_depth_m,
            inertia_kg_m2: body.inertia_kg_m2,
            gravity_m_s2: body.gravity_m_s2,
            air_n_m_s_rad: body.swing_damping_1_s * (a + b),
            swing_rad_s: body.swing_frequency_rad_s(),
        }
    }

    /// The longest step that follows the swing, s. 15 ms for a body that swings at 1.6 Hz.
    #[must_use]
    pub fn step_max_s(&self) -> f64 {
        STEP_PHASE_MAX_RAD / self.swing_rad_s
    }

    /// Largest angle θ of the swing that the body is in, rad, for a small swing: the larger half
    /// axis of the ellipse that its axis goes along.
    #[must_use]
    #[inline]
    pub fn amplitude_rad(&self, state: &MotionState) -> f64 {
        let ([x, y], [p, q, _]) = (state.e, state.omega_rad_s);
        // The vertical leans at the rates (−q, p), a quarter of a swing ahead of itself.
        let (ahead_x, ahead_y) = (-q / self.swing_rad_s, p / self.swing_rad_s);
        let squares = x * x + y * y + ahead_x * ahead_x + ahead_y * ahead_y;
        let area = x * ahead_y - y * ahead_x;
        let spread = (squares * squares - 4.0 * area * area).max(0.0);
        let major2 = 0.5 * (squares + libm::sqrt(spread));
        libm::asin(libm::sqrt(major2).min(1.0))
    }

    /// Steps of equal length, none longer than [`step_max_s`](Self::step_max_s), that `span_s`
    /// takes. The span is a number and not negative; more steps than 2³¹ are counted as that many.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to the range of u32"
    )]
    pub fn steps_in(&self, span_s: f64) -> u32 {
        // A hair more than one step, as 0.01·k − 0.01·(k − 1) may be, is one step.
        let steps = libm::ceil(span_s / self.step_max_s() - 1e-9);
        steps.clamp(1.0, 2_147_483_648.0) as u32
    }
}
