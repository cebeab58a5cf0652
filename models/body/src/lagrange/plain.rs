//! The plain equations: principal axes, infinite string, nothing else.

use super::{Form, Lagrange, Posture};
use crate::attitude::{VERTICAL_MIN, attitude, vertical};
use crate::mounting::MotionParts;
use crate::ode::Rhs;
use crate::{Body, Impulse, MountedMotion, Mounting, StartState};
use nalgebra::Vector3;
use struna_kernel::{BodyMotion, SimTime};

/// States of the integration: vertical (x, y, z), rate (x, y, z), twist, spin, and the integrals of
/// the first two rates.
pub const STATES: usize = 10;

/// Largest tilt of the body axis from the vertical, rad: 170°. The twist is undefined upside down
/// and its rate grows without bound on the way there, so a run stops with an error at this tilt.
pub const TILT_MAX_RAD: f64 = 170.0 * struna_kernel::RAD_PER_DEG;

/// Deviation of |γ|² from one after rescaling that only a step far too long can leave: the step
/// itself was then off by more than a tenth.
const NORM2_SLACK: f64 = 0.01;

/// The right-hand side of the motion of an aligned [`Body`] under a constant body torque: the
/// centre of mass on its z axis, its axes principal.
///
/// States, in this order: the vertical `γ_x, γ_y, γ_z` and the rate `ω_x, ω_y, ω_z` (both in body
/// components, rad/s), twist τ (rad), spin ∫ω_z dt, ∫ω_x dt, ∫ω_y dt (rad). The last three are pure
/// quadratures: no derivative depends on them. The attitude is no state, for vertical and twist
/// together are one; nor is the horizontal velocity of the centre of mass, which is constant.
///
/// The form is Newton-Euler about the centre of mass with the string's force eliminated,
///
/// ```text
/// γ = Rᵀe_z,  u = (−γ₂, γ₁, 0),  γ′ = γ×ω,  h = γ₁′ω₂ − γ₂′ω₁
/// (J + M d² u uᵀ) ω′ = −ω×Jω + M d u (g − d h) − (kτ + cτ′)(γ + e₃)/(1+γ₃) + N
/// τ′ = ω·(γ + e₃)/(1+γ₃)
/// ```
///
/// and its rank-one mass matrix is inverted in closed form (Sherman-Morrison). Euler angles would
/// be singular at the hanging equilibrium; this form is regular everywhere but upside down. Where
/// the string would have to push, the derivative is NaN.
#[derive(Debug, Clone, Copy)]
pub struct BodyEquations {
    torque_n_m: [f64; 3],
    /// 1/A, 1/B, 1/C.
    inverse_inertia: [f64; 3],
    /// (C−B)/A, (A−C)/B, (B−A)/C: Euler's equations divided by the moments.
    gyroscopic: [f64; 3],
    /// M d².
    sway_kg_m2: f64,
    /// M g d.
    pendulum_n_m: f64,
    stiffness_n_m_rad: f64,
    damping_n_m_s_rad: f64,
    depth_m: f64,
    gravity_m_s2: f64,
    /// Horizontal motion of the centre of mass: where it starts, and its velocity.
    com_start_w_m: [f64; 2],
    com_velocity_w_m_s: [f64; 2],
    start_twist_rad: f64,
}

impl BodyEquations {
    /// The equations of `body` from `start` on, under `torque_b_n_m`, a torque in body components
    /// besides gravity and string.
    #[must_use]
    pub fn new(body: &Body, start: &StartState, torque_b_n_m: Vector3<f64>) -> Self {
        let [a, b, c] = body.params().inertia_kg_m2;
        let depth_m = body.params().com_depth_m;
        Self {
            torque_n_m: torque_b_n_m.into(),
            inverse_inertia: [1.0 / a, 1.0 / b, 1.0 / c],
            gyroscopic: [(c - b) / a, (a - c) / b, (b - a) / c],
            sway_kg_m2: body.params().mass_kg * depth_m * depth_m,
            pendulum_n_m: body.pendulum_torque_n_m(),
            stiffness_n_m_rad: body.stiffness_n_m_rad(),
            damping_n_m_s_rad: body.damping_n_m_s_rad(),
            depth_m,
            gravity_m_s2: body.params().gravity_m_s2,
            com_start_w_m: start.com_offset_w_m(body),
            com_velocity_w_m_s: start.com_velocity_w_m_s,
            start_twist_rad: start.twist_rad,
        }
    }

    /// The integrator's states at `start`. The spin starts at the twist, as if the body had been
    /// wound up about the vertical.
    #[must_use]
    pub fn states(start: &StartState) -> [f64; STATES] {
        let [g1, g2, g3] = vertical(&start.attitude());
        let [w1, w2, w3] = start.omega_wb_b_rad_s;
        let twist = start.twist_rad;
        [g1, g2, g3, w1, w2, w3, twist, twist, 0.0, 0.0]
    }

    /// What a gyro in `mounting` has of these states.
    #[inline(always)]
    fn mounted(&self, y: &[f64; STATES], mounting: &Mounting) -> MountedMotion {
        let [g1, g2, g3, w1, w2, w3, twist_rad, spin_rad, angle_1, angle_2] = *y;
        let Rates { acceleration, twist_rate_rad_s, pull_n_m, .. } = self.rates(y);
        let pull_m_s2 = pull_n_m / self.pendulum_n_m * self.gravity_m_s2;
        let omega = Vector3::new(w1, w2, w3);
        mounting.mounted_from(&MotionParts {
            // Nothing but the string, which is vertical, holds the body.
            com_force_b_m_s2: Vector3::new(g1, g2, g3) * pull_m_s2,
            omega_wb_b_rad_s: omega,
            omega_ib_b_rad_s: omega,
            angular_acceleration_b_rad_s2: acceleration.into(),
            angle_b_rad: Vector3::new(angle_1, angle_2, spin_rad - self.start_twist_rad),
            suspension_b_m: Vector3::new(0.0, 0.0, self.depth_m),
            spin_rad,
            twist_rad,
            twist_rate_rad_s,
        })
    }

    /// 1/(1+γ₃) and 1/(1 + M d² u·J⁻¹u), divided early and independently of each other: a division
    /// is the longest wait in the chain of one derivative, and these two overlap.
    #[inline(always)]
    fn inverses(&self, g: [f64; 3]) -> (f64, f64) {
        let [ia, ib, _] = self.inverse_inertia;
        let reaction = 1.0 + self.sway_kg_m2 * (ia * g[1] * g[1] + ib * g[0] * g[0]);
        (1.0 / (1.0 + g[2]), 1.0 / reaction)
    }

    /// What changes at these states, and how fast.
    ///
    /// What waits for a division is multiplied last and by as little as possible: the steps of a
    /// walk follow from each other, so the longest chain of operations is the time they take.
    #[inline(always)]
    fn rates(&self, y: &[f64; STATES]) -> Rates {
        let [g1, g2, g3, w1, w2, w3, twist, ..] = *y;
        let g = [g1, g2, g3];
        let (inverse_upright, inverse_reaction) = self.inverses(g);
        let [ia, ib, ic] = self.inverse_inertia;
        let [n1, n2, n3] = self.torque_n_m;
        let [e1, e2, e3] = self.gyroscopic;

        // Along the bisector of vertical and body axis: equal shares in ψ and φ.
        let swinging = w1 * g[0] + w2 * g[1];
        let steady_n_m = self.stiffness_n_m_rad * twist + self.damping_n_m_s_rad * w3;
        let swinging_n_m = self.damping_n_m_s_rad * swinging;
        let string_n_m = -(steady_n_m + swinging_n_m * inverse_upright) * inverse_upright;
        let twist_rate_rad_s = w3 + swinging * inverse_upright;

        // Fall of the centre of mass that the rates alone cause: h of the equations above.
        let g1_rate = g[1] * w3 - g[2] * w2;
        let g2_rate = g[2] * w1 - g[0] * w3;
        let g3_rate = g[0] * w2 - g[1] * w1;
        let h = g1_rate * w2 - g2_rate * w1;
        let f = self.pendulum_n_m - self.sway_kg_m2 * h;
        // J⁻¹ times everything on the right, as if the string's force did not react.
        let j1 = string_n_m * (ia * g[0]) + (ia * (n1 - g[1] * f) - e1 * w2 * w3);
        let j2 = string_n_m * (ib * g[1]) + (ib * (n2 + g[0] * f) - e2 * w3 * w1);
        let j3 = string_n_m * (ic * (1.0 + g[2])) + (ic * n3 - e3 * w1 * w2);
        // Sherman-Morrison: subtract J⁻¹u · M d² (u·j) / (1 + M d² u·J⁻¹u).
        let reaction = self.sway_kg_m2 * inverse_reaction;
        let s = (g[0] * reaction) * j2 - (g[1] * reaction) * j1;
        Rates {
            vertical: [g1_rate, g2_rate, g3_rate],
            acceleration: [j1 + (g[1] * ia) * s, j2 - (g[0] * ib) * s, j3],
            twist_rate_rad_s,
            pull_n_m: f - s,
        }
    }
}

/// What [`BodyEquations::rates`] finds.
struct Rates {
    /// γ′, 1/s.
    vertical: [f64; 3],
    /// ω′, rad/s².
    acceleration: [f64; 3],
    twist_rate_rad_s: f64,
    /// Pull of the string times d.
    pull_n_m: f64,
}

impl Rhs<STATES> for BodyEquations {
    #[inline(always)]
    fn derivative(&self, _time_s: f64, y: &[f64; STATES]) -> [f64; STATES] {
        let Rates { vertical, acceleration, twist_rate_rad_s, pull_n_m } = self.rates(y);
        let ([g1, g2, g3], [a1, a2, a3]) = (vertical, acceleration);
        let [_, _, _, w1, w2, w3, ..] = *y;
        // A string cannot push: the step that would need it ends the run.
        let twist_rate = if pull_n_m >= 0.0 { twist_rate_rad_s } else { f64::NAN };
        [g1, g2, g3, a1, a2, a3, twist_rate, w3, w1, w2]
    }

    /// Rescales the vertical to unit length by one Newton step of the inverse root: exact to the
    /// square of the deviation, which a sound step keeps below 1e-8, and free of root and division.
    #[inline(always)]
    fn project(&self, y: &mut [f64; STATES]) {
        let scale = 1.5 - 0.5 * norm2(y);
        for component in &mut y[..3] {
            *component *= scale;
        }
    }

    /// Upright enough for the twist, and the vertical near unit length: it is not after a step far
    /// too long for the motion.
    #[inline(always)]
    fn admissible(&self, _time_s: f64, y: &[f64; STATES]) -> bool {
        (norm2(y) - 1.0).abs() < NORM2_SLACK && y[2] >= VERTICAL_MIN
    }
}

#[inline(always)]
fn norm2(y: &[f64; STATES]) -> f64 {
    y[0] * y[0] + y[1] * y[1] + y[2] * y[2]
}

impl Form<STATES> for BodyEquations {
    fn posture(&self, _time_s: f64, y: &[f64; STATES]) -> Posture {
        let [g1, g2, g3, w1, w2, w3, twist_rad, ..] = *y;
        let q = attitude([g1, g2, g3], twist_rad);
        Posture { q_wb: [q.w, q.i, q.j, q.k], omega_wb_b_rad_s: [w1, w2, w3], twist_rad }
    }

    fn tension_n(&self, _time_s: f64, y: &[f64; STATES]) -> f64 {
        self.rates(y).pull_n_m / self.depth_m
    }

    fn weight_n(&self) -> f64 {
        self.pendulum_n_m / self.depth_m
    }

    /// An eighth of the time in which torsion changes. Without a swing the error control would take
    /// steps longer than the dense output is good for, which it does not watch.
    fn step_max_s(&self) -> f64 {
        let [.., per_inertia] = self.inverse_inertia;
        let stiffness_1_s2 = self.stiffness_n_m_rad * per_inertia;
        let damping_1_s = self.damping_n_m_s_rad * per_inertia;
        0.125 / (stiffness_1_s2.sqrt() + damping_1_s)
    }

    #[inline]
    fn motion(&self, time: SimTime, _time_s: f64, y: &[f64; STATES]) -> BodyMotion {
        let [g1, g2, g3, w1, w2, w3, twist_rad, spin_rad, angle_1, angle_2] = *y;
        let rates = self.rates(y);
        let Rates { acceleration, twist_rate_rad_s, pull_n_m, .. } = rates;
        let omega = Vector3::new(w1, w2, w3);
        // Only heights of the centre of mass follow from the vertical: R₃₃ = γ₃, and γ′₃.
        let (height_m, climb_m_s) = (-self.depth_m * g3, -self.depth_m * rates.vertical[2]);
        let [x, y] = self.com_start_w_m;
        let [vx, vy] = self.com_velocity_w_m_s;
        let time_s = time.as_s();
        let pull_m_s2 = pull_n_m / self.pendulum_n_m * self.gravity_m_s2;
        BodyMotion {
            time,
            q_wb: attitude([g1, g2, g3], twist_rad),
            omega_wb_b_rad_s: omega,
            twist_rad,
            twist_rate_rad_s,
            spin_rad,
            omega_ib_b_rad_s: omega,
            inertial_angle_b_rad: Vector3::new(angle_1, angle_2, spin_rad - self.start_twist_rad),
            angular_acceleration_b_rad_s2: acceleration.into(),
            com_position_w_m: Vector3::new(x + vx * time_s, y + vy * time_s, height_m),
            com_velocity_w_m_s: Vector3::new(vx, vy, climb_m_s),
            com_acceleration_w_m_s2: Vector3::z() * (pull_m_s2 - self.gravity_m_s2),
        }
    }

    #[inline(always)]
    fn hold(&mut self, _origin_s: f64, torque_b_n_m: Vector3<f64>) {
        self.torque_n_m = torque_b_n_m.into();
    }

    /// The plain equations know no impulses: a rig that has some takes the full ones.
    fn kick(&self, _time_s: f64, _y: &mut [f64; STATES], _impulse: &Impulse) {}
}

impl Lagrange<STATES, BodyEquations> {
    /// What a gyro in `mounting` has of the motion at the instant reached.
    #[inline]
    pub(crate) fn mounted(&self, mounting: &Mounting) -> MountedMotion {
        self.form.mounted(&self.states, mounting)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ode::Rk4;
    use crate::reference;

    fn rate_of_states(start: &StartState, torque: Vector3<f64>) -> [f64; STATES] {
        let body = Body::new(&reference::PARAMS).unwrap();
        BodyEquations::new(&body, start, torque).derivative(0.0, &BodyEquations::states(start))
    }

    #[test]
    fn the_closed_inverse_agrees_with_a_full_matrix_solve() {
        let start = StartState { tilt_rad: 1.0, tilt_azimuth_rad: 0.7, ..reference::S3 };
        let torque = Vector3::new(0.01, -0.02, 0.03);
        let fast = rate_of_states(&start, torque);
        let body = Body::new(&reference::PARAMS).unwrap();
        let p = body.params();
        let (w, e3) = (Vector3::from(start.omega_wb_b_rad_s), Vector3::z());
        let g = start.attitude().inverse_transform_vector(&e3);
        let u = Vector3::new(-g.y, g.x, 0.0);
        let g_rate = g.cross(&w);
        let h = g_rate.x * w.y - g_rate.y * w.x;
        let inertia = body.inertia_b_kg_m2();
        let mass = inertia + u * u.transpose() * p.mass_kg * p.com_depth_m.powi(2);
        let string = -(g + e3) * body.stiffness_n_m_rad() * start.twist_rad / (1.0 + g.z);
        let gravity = u * p.mass_kg * p.com_depth_m * (p.gravity_m_s2 - p.com_depth_m * h);
        let right = -w.cross(&(inertia * w)) + gravity + string + torque;
        let slow = mass.lu().solve(&right).unwrap();
        for axis in 0..3 {
            // Two routes through about thirty roundings each, on accelerations up to 100 rad/s².
            assert!((fast[3 + axis] - slow[axis]).abs() < 1e-12, "axis {axis}");
        }
    }

    #[test]
    fn the_vertical_stays_at_unit_length() {
        let body = Body::new(&reference::PARAMS).unwrap();
        let equations = BodyEquations::new(&body, &reference::S3, Vector3::zeros());
        let mut walk = Rk4::new(0.01, BodyEquations::states(&reference::S3)).unwrap();
        for seconds in 1..=60_i32 {
            let y = walk.state_at(&equations, f64::from(seconds)).unwrap();
            // One step stretches |γ|² by some 1e-9 at 10 ms, of which rescaling leaves the square.
            assert!((norm2(&y) - 1.0).abs() < 1e-15, "{:e} at {seconds} s", norm2(&y) - 1.0);
        }
    }

    #[test]
    fn the_domain_ends_at_the_largest_tilt() {
        let body = Body::new(&reference::PARAMS).unwrap();
        let equations = BodyEquations::new(&body, &reference::S3, Vector3::zeros());
        for (tilt_rad, inside) in [(TILT_MAX_RAD - 1e-6, true), (TILT_MAX_RAD + 1e-6, false)] {
            let y = BodyEquations::states(&StartState { tilt_rad, ..StartState::AT_REST });
            assert_eq!(equations.admissible(0.0, &y), inside, "{tilt_rad}");
        }
    }

    #[test]
    fn nothing_moves_at_rest_in_equilibrium() {
        let rate = rate_of_states(&StartState::AT_REST, Vector3::zeros());
        assert!(rate.iter().all(|v| *v == 0.0), "{rate:?}");
    }
}
