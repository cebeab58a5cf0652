//! The right-hand side of the motion, and its derivatives by states and parameters.

use super::step::{MOTION_TANGENTS, Tangents};
use super::{MOTION_STATES, MotionParameters, SwingMotion};
use crate::EstimatorError;

/// Places of the states among the columns.
const EX: usize = 0;
const EY: usize = 1;
const TWIST: usize = 2;
const P: usize = 3;
const Q: usize = 4;
const R: usize = 5;
/// Places of the parameters among the columns; Ω² and 2ζΩ come before them.
const SCALE_A: usize = 8;
const SCALE_B: usize = 9;
const AIR: usize = 10;

/// The constants of one step: the body with its parameters put in.
#[derive(Debug, Clone, Copy)]
pub(super) struct Coefficients {
    gravity: f64,
    depth: f64,
    /// M·d.
    lever: f64,
    /// Moments A, B, C.
    inertia: [f64; 3],
    inverse: [f64; 3],
    /// Believed A and B: what the moments change by with their scales.
    believed: [f64; 2],
    /// Torque of the string per radian of twist.
    stiffness: f64,
    /// Torque of the string per unit rate of the twist.
    thread: f64,
    /// Torque of the air per unit rate.
    air: f64,
    /// The same at the nominal decay.
    air_nominal: f64,
}

impl Coefficients {
    #[inline(always)]
    pub(super) fn new(motion: &SwingMotion, parameters: &MotionParameters) -> Self {
        let [a, b, c] = motion.inertia_kg_m2;
        let inertia = [a * parameters.scale_a, b * parameters.scale_b, c];
        let air = motion.air_n_m_s_rad * parameters.swing_damping_scale;
        Self {
            gravity: motion.gravity_m_s2,
            depth: motion.com_depth_m,
            lever: motion.mass_kg * motion.com_depth_m,
            inertia,
            inverse: inertia.map(|moment| 1.0 / moment),
            believed: [a, b],
            stiffness: c * parameters.stiffness_1_s2,
            thread: c * parameters.damping_1_s - air,
            air,
            air_nominal: motion.air_n_m_s_rad,
        }
    }

    /// What does not depend on the direction of differentiation, at one state.
    #[inline(always)]
    fn terms(&self, state: &[f64; MOTION_STATES]) -> Result<Terms, EstimatorError> {
        let [x, y, twist, p, q, r] = *state;
        let across = x * x + y * y;
        if across.is_nan() || across >= 1.0 {
            return Err(EstimatorError::TiltTooLarge);
        }
        let [a, b, c] = self.inertia;
        let [ia, ib, _] = self.inverse;
        let z = libm::sqrt(1.0 - across);
        let f = 1.0 / (1.0 + z);
        let v = x * p + y * q;
        let twist_rate = r + f * v;
        let string = self.stiffness * twist + self.thread * twist_rate;
        let torque = [
            (b - c) * q * r - string * f * x - self.air * p,
            (c - a) * r * p - string * f * y - self.air * q,
            (a - b) * p * q - string - self.air * r,
        ];
        let e_rate = [y * r - z * q, z * p - x * r];
        // The string's pull: M·d·(g − d·(h + u·J⁻¹·torque))/(1 + M·d²·u·J⁻¹·u), u = (−y, x, 0).
        let h = e_rate[0] * q - e_rate[1] * p;
        let along = x * torque[1] * ib - y * torque[0] * ia;
        let across_inverse = x * x * ib + y * y * ia;
        let share = self.lever / (1.0 + self.lever * self.depth * across_inverse);
        let pull = share * (self.gravity - self.depth * (h + along));
        Ok(Terms { z, f, v, twist_rate, string, torque, e_rate, share, pull })
    }

    /// Rates of change of the states.
    #[inline(always)]
    pub(super) fn rates(
        &self,
        state: &[f64; MOTION_STATES],
    ) -> Result<[f64; MOTION_STATES], EstimatorError> {
        Ok(self.rates_of(state, &self.terms(state)?))
    }

    #[inline(always)]
    fn rates_of(&self, state: &[f64; MOTION_STATES], t: &Terms) -> [f64; MOTION_STATES] {
        let [x, y, ..] = *state;
        let [ia, ib, ic] = self.inverse;
        [
            t.e_rate[0],
            t.e_rate[1],
            t.twist_rate,
            (t.torque[0] - y * t.pull) * ia,
            (t.torque[1] + x * t.pull) * ib,
            t.torque[2] * ic,
        ]
    }

    /// Rates of change of the states, and their derivatives by states and parameters.
    // On its own: four copies in a step outgrow the registers and take a tenth longer.
    #[inline(never)]
    pub(super) fn rates_and_jacobian(
        &self,
        state: &[f64; MOTION_STATES],
    ) -> Result<([f64; MOTION_STATES], Jacobian), EstimatorError> {
        let t = self.terms(state)?;
        let rates = self.rates_of(state, &t);
        let kinematic = Kinematics::new(state, &t);
        let spin = self.spin(state, &t, &rates, &kinematic);
        Ok((rates, Jacobian { kinematic, spin }))
    }

    /// Derivatives of the angular acceleration by everything.
    #[inline(always)]
    fn spin(
        &self,
        state: &[f64; MOTION_STATES],
        t: &Terms,
        rates: &[f64; MOTION_STATES],
        k: &Kinematics,
    ) -> [[f64; MOTION_TANGENTS]; 3] {
        let [x, y, ..] = *state;
        let [ia, ib, ic] = self.inverse;
        let torque = self.torque_by(state, t, k);
        let inner = self.pull_by(state, t, k);
        let scale = t.share * self.depth;
        let mut spin = [[0.0; MOTION_TANGENTS]; 3];
        for c in 0..MOTION_TANGENTS {
            let (along_x, along_y) = (torque[0][c] * ia, torque[1][c] * ib);
            let pull = -scale * (inner[c] + x * along_y - y * along_x);
            spin[0][c] = along_x - y * ia * pull;
            spin[1][c] = along_y + x * ib * pull;
            spin[2][c] = torque[2][c] * ic;
        }
        // What the pull acts through, and what it acts on.
        spin[0][EY] -= t.pull * ia;
        spin[1][EX] += t.pull * ib;
        spin[0][SCALE_A] -= rates[P] * self.believed[0] * ia;
        spin[1][SCALE_B] -= rates[Q] * self.believed[1] * ib;
        spin
    }

    /// Derivatives of the torques on the body by everything. Those by the twist rate's r and by
    /// the moments go through the gyroscopic torque as well.
    #[inline(always)]
    fn torque_by(
        &self,
        state: &[f64; MOTION_STATES],
        t: &Terms,
        k: &Kinematics,
    ) -> [[f64; MOTION_TANGENTS]; 3] {
        let [x, y, twist, p, q, r] = *state;
        let [a, b, c] = self.inertia;
        let [a0, b0] = self.believed;
        let string = [
            self.thread * k.twist_by[0],
            self.thread * k.twist_by[1],
            self.stiffness,
            self.thread * k.twist_by[2],
            self.thread * k.twist_by[3],
            self.thread,
            c * twist,
            c * t.twist_rate,
            0.0,
            0.0,
            -self.air_nominal * t.twist_rate,
        ];
        let (fx, fy) = (t.f * x, t.f * y);
        let mut torque = [string.map(|s| -fx * s), string.map(|s| -fy * s), string.map(|s| -s)];
        // The string pulls along (e + e₃)/(1 + e₃·e), which turns with the vertical.
        torque[0][EX] -= t.string * k.fx_by[0];
        torque[0][EY] -= t.string * k.fx_by[1];
        torque[1][EX] -= t.string * k.fx_by[1];
        torque[1][EY] -= t.string * k.fy_by_y;
        for (row, rate) in torque.iter_mut().zip([p, q, r]) {
            row[AIR] -= self.air_nominal * rate;
        }
        torque[0][P] -= self.air;
        torque[0][Q] += (b - c) * r;
        torque[0][R] += (b - c) * q;
        torque[0][SCALE_B] += b0 * q * r;
        torque[1][P] += (c - a) * r;
        torque[1][Q] -= self.air;
        torque[1][R] += (c - a) * p;
        torque[1][SCALE_A] -= a0 * r * p;
        torque[2][P] += (a - b) * q;
        torque[2][Q] += (a - b) * p;
        torque[2][R] -= self.air;
        torque[2][SCALE_A] += a0 * p * q;
        torque[2][SCALE_B] -= b0 * p * q;
        torque
    }

    /// Derivatives of h + u·J⁻¹·torque by everything, the torque held, and of the u·J⁻¹·u that
    /// divides the pull, times the pull.
    #[inline(always)]
    fn pull_by(
        &self,
        state: &[f64; MOTION_STATES],
        t: &Terms,
        k: &Kinematics,
    ) -> [f64; MOTION_TANGENTS] {
        let [x, y, _, p, q, _] = *state;
        let [ia, ib, _] = self.inverse;
        let [a0, b0] = self.believed;
        let (along_x, along_y) = (t.torque[0] * ia, t.torque[1] * ib);
        let mut by = [0.0; MOTION_TANGENTS];
        by[EX] = k.e1_by[0] * q - k.e2_by[0] * p + along_y + 2.0 * t.pull * x * ib;
        by[EY] = k.e1_by[1] * q - k.e2_by[1] * p - along_x + 2.0 * t.pull * y * ia;
        by[P] = -t.e_rate[1] - t.z * p;
        by[Q] = t.e_rate[0] - t.z * q;
        by[R] = t.v;
        by[SCALE_A] = (along_x - t.pull * y * ia) * y * ia * a0;
        by[SCALE_B] = -(along_y + t.pull * x * ib) * x * ib * b0;
        by
    }
}

/// Values on the way to the rates of change.
#[derive(Debug, Clone, Copy)]
struct Terms {
    /// cos θ.
    z: f64,
    /// 1/(1 + cos θ).
    f: f64,
    /// e₁p + e₂q.
    v: f64,
    twist_rate: f64,
    /// Torque of the string against the twist.
    string: f64,
    /// All torques but that of the pull, body axes.
    torque: [f64; 3],
    e_rate: [f64; 2],
    /// M·d/(1 + M·d²·u·J⁻¹·u).
    share: f64,
    /// What u is multiplied by to give the torque of the string's pull.
    pull: f64,
}

/// Derivatives of the rates of change of vertical and twist, those that are not zero or one.
#[derive(Debug, Clone, Copy)]
struct Kinematics {
    /// e₁' by e₁, e₂, q, r.
    e1_by: [f64; 4],
    /// e₂' by e₁, e₂, p, r.
    e2_by: [f64; 4],
    /// τ' by e₁, e₂, p, q.
    twist_by: [f64; 4],
    /// f·e₁ by e₁ and e₂; the latter is f·e₂ by e₁.
    fx_by: [f64; 2],
    /// f·e₂ by e₂.
    fy_by_y: f64,
}

impl Kinematics {
    #[inline(always)]
    fn new(state: &[f64; MOTION_STATES], t: &Terms) -> Self {
        let [x, y, _, p, q, r] = *state;
        let inverse = 1.0 / t.z;
        let (zx, zy) = (-x * inverse, -y * inverse);
        let (f_by_x, f_by_y) = (-t.f * t.f * zx, -t.f * t.f * zy);
        Self {
            e1_by: [-zx * q, r - zy * q, -t.z, y],
            e2_by: [zx * p - r, zy * p, t.z, -x],
            twist_by: [t.f * p + f_by_x * t.v, t.f * q + f_by_y * t.v, t.f * x, t.f * y],
            fx_by: [t.f + f_by_x * x, f_by_y * x],
            fy_by_y: t.f + f_by_y * y,
        }
    }
}

/// Derivatives of the rates of change by states and parameters.
#[derive(Debug, Clone, Copy)]
pub(super) struct Jacobian {
    kinematic: Kinematics,
    /// Of the angular acceleration.
    spin: [[f64; MOTION_TANGENTS]; 3],
}

impl Jacobian {
    /// Rates of change of the tangents.
    #[inline(never)]
    pub(super) fn apply(&self, tangents: &Tangents) -> Tangents {
        let [x, y, twist, p, q, r] = &tangents.0;
        let k = &self.kinematic;
        let mut rates = Tangents::ZERO;
        for c in 0..MOTION_TANGENTS {
            let [by_x, by_y, by_q, by_r] = k.e1_by;
            rates.0[EX][c] = (by_x * x[c] + by_y * y[c]) + (by_q * q[c] + by_r * r[c]);
            let [by_x, by_y, by_p, by_r] = k.e2_by;
            rates.0[EY][c] = (by_x * x[c] + by_y * y[c]) + (by_p * p[c] + by_r * r[c]);
            let [by_x, by_y, by_p, by_q] = k.twist_by;
            rates.0[TWIST][c] = (by_x * x[c] + by_y * y[c]) + (by_p * p[c] + by_q * q[c]) + r[c];
        }
        for (row, by) in rates.0[P..].iter_mut().zip(&self.spin) {
            for c in 0..MOTION_TANGENTS {
                let attitude = by[EX] * x[c] + by[EY] * y[c] + by[TWIST] * twist[c];
                row[c] = attitude + (by[P] * p[c] + by[Q] * q[c] + by[R] * r[c]);
            }
            // The parameters do not move: each is its own tangent.
            for c in MOTION_STATES..MOTION_TANGENTS {
                row[c] += by[c];
            }
        }
        rates
    }
}
