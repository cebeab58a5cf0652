//! The full equations: any body, any string, moving support, yielding thread, air.

use super::{Form, Posture};
use crate::ode::Rhs;
use crate::support::{Support, SupportState};
use crate::thread::{Memory, ThreadLaw, YIELD_ELEMENTS_MAX};
use crate::{BodyError, Drag, Impulse, Rig, StartState, TILT_MAX_RAD};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector2, Vector3};
use struna_kernel::{BodyMotion, Bound, SimTime};

/// Twelve states of the mechanics, six of the thread, four integrals.
pub const FULL_STATES: usize = 22;

/// Largest share of a string's length by which its lower end may leave the vertical: sin 80°.
const STRING_LEAN_MAX: f64 = 0.984_807_753_012_208;

/// Largest phase that the fastest motion of the support may turn in one adaptive step, rad. The
/// stages then sample it every hundredth of its period, and no slackening slips between them.
const SUPPORT_PHASE_MAX_RAD: f64 = 0.1 * std::f64::consts::TAU;

/// The right-hand side of the motion of a [`Rig`] under a held body torque.
///
/// With A the point that the string holds, O the support, C the centre of mass, ε = 1/L the
/// curvature of the sphere on which A moves (0 for an infinite string), ρ = A − C in body
/// components and F a force at C, N a torque about it:
///
/// ```text
/// a = (A − O)_xy,  n = (−εa, √(1 − ε²a²)),  n_b = Rᵀn,  u = ρ×n_b
/// v = a′ = v_C + R(ω×ρ) − O′ (horizontal),  v_z = ε(a·v)/n_z,  κ = ε|v|²
/// m = −ω×Jω + N
/// T = [κ + n·O″ + g n_z − n·F/M − u·J⁻¹m − n_b·(ω×(ω×ρ))] / (1/M + u·J⁻¹u)
/// v_C′ = (n T + F)/M (horizontal),  ω′ = J⁻¹(m + u T),  q′ = q∘(0, ω)/2
/// τ′ = ω·(γ + e₃)/(1 + γ₃),  γ = Rᵀe_z
/// ```
///
/// Heights follow from a, so the length of the string cannot drift, and ε = 0 is the infinite
/// string exactly. Where the tension T would be negative the derivative is NaN.
///
/// States: a, v_C (horizontal), q (w, x, y, z), ω, turn of the thread τ − clamp, its neutral
/// angle, its turn and the strains of its yield elements at the last completed step, spin ∫ω_z dt,
/// ∫(ω + Earth) dt.
#[derive(Debug, Clone)]
pub struct FullEquations {
    mass_kg: f64,
    gravity_m_s2: f64,
    inertia: Matrix3<f64>,
    inverse_inertia: Matrix3<f64>,
    suspension_b_m: Vector3<f64>,
    curvature_1_m: f64,
    thread: ThreadLaw,
    drag: Drag,
    support: Support,
    earth_rate_w_rad_s: Vector3<f64>,
    torque_b_n_m: Vector3<f64>,
    /// Time of the run when the integrator's time was zero, s.
    origin_s: f64,
}

/// The states by name.
#[derive(Debug, Clone, Copy)]
struct States {
    a_m: Vector2<f64>,
    com_velocity_w_m_s: Vector2<f64>,
    q: [f64; 4],
    omega: Vector3<f64>,
    turn_rad: f64,
    neutral_rad: f64,
    memory: Memory,
}

impl States {
    #[inline(always)]
    fn of(y: &[f64; FULL_STATES]) -> Self {
        Self {
            a_m: Vector2::new(y[0], y[1]),
            com_velocity_w_m_s: Vector2::new(y[2], y[3]),
            q: [y[4], y[5], y[6], y[7]],
            omega: Vector3::new(y[8], y[9], y[10]),
            turn_rad: y[11],
            neutral_rad: y[12],
            memory: Memory { turn_rad: y[13], strain_rad: [y[14], y[15], y[16], y[17]] },
        }
    }
}

const MEMORY: usize = 13;
const SPIN: usize = 18;
const INERTIAL: usize = 19;
const _: () = assert!(MEMORY + 1 + YIELD_ELEMENTS_MAX == SPIN && INERTIAL + 3 == FULL_STATES);

/// Everything that one derivative computes and one motion reports.
struct Kinetics {
    rotation: Matrix3<f64>,
    support: SupportState,
    /// Vertical share of the string's direction.
    string_up: f64,
    suspension_rate_w_m_s: Vector2<f64>,
    com_velocity_w_m_s: Vector3<f64>,
    com_acceleration_w_m_s2: Vector3<f64>,
    angular_acceleration: Vector3<f64>,
    twist_rate_rad_s: f64,
    tension_n: f64,
}

impl FullEquations {
    /// The equations of `rig`, without held torque.
    ///
    /// # Errors
    /// [`BodyError::Parameter`] when the thread is impossible.
    pub fn new(rig: &Rig) -> Result<Self, BodyError> {
        let inertia = rig.body.inertia_b_kg_m2();
        let singular = "the moments of inertia are too different to be inverted";
        let inverse_inertia = inertia.try_inverse().unwrap_or(Matrix3::repeat(f64::NAN));
        Bound::Finite.check("inertia_kg_m2", inverse_inertia.sum(), singular)?;
        Ok(Self {
            mass_kg: rig.body.params().mass_kg,
            gravity_m_s2: rig.body.params().gravity_m_s2,
            inertia,
            inverse_inertia,
            suspension_b_m: rig.body.suspension_b_m(),
            curvature_1_m: rig.string_length_m.map_or(0.0, f64::recip),
            thread: rig.thread_law()?,
            drag: rig.drag,
            support: rig.support.clone(),
            earth_rate_w_rad_s: rig.earth_rate_w_rad_s,
            torque_b_n_m: Vector3::zeros(),
            origin_s: 0.0,
        })
    }

    /// The integrator's states at `start`: thread relaxed at its neutral angle zero, spin at the
    /// twist.
    ///
    /// # Errors
    /// [`BodyError::Parameter`] when the string would start too near to the horizontal.
    pub fn states(&self, start: &StartState) -> Result<[f64; FULL_STATES], BodyError> {
        let [x, y] = start.suspension_w_m;
        let reason = "it is a share of the string's length, sin 80 deg at most";
        let lean = self.curvature_1_m * x.hypot(y);
        Bound::AtMost(STRING_LEAN_MAX).check("|suspension_w_m|/string_length_m", lean, reason)?;
        let mut states = [0.0; FULL_STATES];
        states[..2].copy_from_slice(&start.suspension_w_m);
        states[2..4].copy_from_slice(&start.com_velocity_w_m_s);
        let q = start.attitude();
        states[4..8].copy_from_slice(&[q.w, q.i, q.j, q.k]);
        states[8..11].copy_from_slice(&start.omega_wb_b_rad_s);
        let turn_rad = start.twist_rad - self.support.at(0.0).clamp_rad;
        (states[11], states[MEMORY]) = (turn_rad, turn_rad);
        states[SPIN] = start.twist_rad;
        Ok(states)
    }

    /// Direction of the string from A to O, world components.
    #[inline(always)]
    fn string_w(&self, a_m: &Vector2<f64>) -> Vector3<f64> {
        let lean = -self.curvature_1_m * a_m;
        Vector3::new(lean.x, lean.y, (1.0 - lean.norm_squared()).sqrt())
    }

    #[inline(always)]
    fn kinetics(&self, time_s: f64, s: &States) -> Kinetics {
        let support = self.support.at(self.origin_s + time_s);
        let r = rotation(s.q);
        let (rho, w) = (&self.suspension_b_m, &s.omega);
        let n = self.string_w(&s.a_m);
        let n_b = r.tr_mul(&n);
        let swing_w = r * w.cross(rho);
        let v = s.com_velocity_w_m_s + swing_w.xy() - support.velocity_w_m_s.xy();
        let v_z = self.curvature_1_m * s.a_m.dot(&v) / n.z;
        let climb = support.velocity_w_m_s.z + v_z - swing_w.z;
        let com_velocity = s.com_velocity_w_m_s.push(climb);

        let bisector = bisector(&r);
        let twist_rate = w.dot(&bisector);
        let turn_rate = twist_rate - support.clamp_rate_rad_s;
        let string =
            self.thread.torque_n_m(s.turn_rad, turn_rate, s.neutral_rad, &s.memory) * bisector;
        let torque = string + self.torque_b_n_m + self.drag.torque_n_m(w);
        let force = self.drag.force_n(&com_velocity);

        let m = torque - w.cross(&(self.inertia * w));
        let u = rho.cross(&n_b);
        let free = self.inverse_inertia * m;
        let lever = self.inverse_inertia * u;
        let pull = self.curvature_1_m * (v.norm_squared() + v_z * v_z)
            + n.dot(&support.acceleration_w_m_s2)
            + self.gravity_m_s2 * n.z
            - n.dot(&force) / self.mass_kg
            - u.dot(&free)
            - n_b.dot(&w.cross(&w.cross(rho)));
        let tension = pull / (self.mass_kg.recip() + u.dot(&lever));
        let weight = Vector3::new(0.0, 0.0, self.gravity_m_s2);
        Kinetics {
            rotation: r,
            support,
            string_up: n.z,
            suspension_rate_w_m_s: v,
            com_velocity_w_m_s: com_velocity,
            com_acceleration_w_m_s2: (n * tension + force) / self.mass_kg - weight,
            angular_acceleration: free + lever * tension,
            twist_rate_rad_s: twist_rate,
            tension_n: tension,
        }
    }

    fn turn_rate_rad_s(&self, time_s: f64, s: &States) -> f64 {
        let support = self.support.at(self.origin_s + time_s);
        s.omega.dot(&bisector(&rotation(s.q))) - support.clamp_rate_rad_s
    }

    /// Height of A above its place in equilibrium, without cancellation.
    fn suspension_height_m(&self, a_m: &Vector2<f64>, string_up: f64) -> f64 {
        self.curvature_1_m * a_m.norm_squared() / (1.0 + string_up)
    }
}

/// (γ + e₃)/(1 + γ₃): the direction about which the twist turns, in body components.
#[inline(always)]
fn bisector(rotation: &Matrix3<f64>) -> Vector3<f64> {
    let vertical_b = Vector3::new(rotation.m31, rotation.m32, rotation.m33);
    (vertical_b + Vector3::z()) / (1.0 + vertical_b.z)
}

/// The rotation of a quaternion near unit length: off the unit, the continuation that the plain
/// equations use, so that equal steps err equally.
#[inline(always)]
fn rotation([w, x, y, z]: [f64; 4]) -> Matrix3<f64> {
    let (xy, xz, yz) = (x * y, x * z, y * z);
    let (ww, wx, wy, wz) = (w * w, w * x, w * y, w * z);
    Matrix3::new(
        2.0 * (ww + x * x) - 1.0,
        2.0 * (xy - wz),
        2.0 * (xz + wy),
        2.0 * (xy + wz),
        2.0 * (ww + y * y) - 1.0,
        2.0 * (yz - wx),
        2.0 * (xz - wy),
        2.0 * (yz + wx),
        2.0 * (ww + z * z) - 1.0,
    )
}

impl Rhs<FULL_STATES> for FullEquations {
    #[inline(always)]
    fn derivative(&self, time_s: f64, y: &[f64; FULL_STATES]) -> [f64; FULL_STATES] {
        let s = States::of(y);
        let k = self.kinetics(time_s, &s);
        let [qw, qx, qy, qz] = s.q;
        let (w1, w2, w3) = (s.omega.x, s.omega.y, s.omega.z);
        let inertial = s.omega + k.rotation.tr_mul(&self.earth_rate_w_rad_s);
        let mut rate = [0.0; FULL_STATES];
        (rate[0], rate[1]) = (k.suspension_rate_w_m_s.x, k.suspension_rate_w_m_s.y);
        (rate[2], rate[3]) = (k.com_acceleration_w_m_s2.x, k.com_acceleration_w_m_s2.y);
        rate[4] = -0.5 * (qx * w1 + qy * w2 + qz * w3);
        rate[5] = 0.5 * (qw * w1 + qy * w3 - qz * w2);
        rate[6] = 0.5 * (qw * w2 + qz * w1 - qx * w3);
        rate[7] = 0.5 * (qw * w3 + qx * w2 - qy * w1);
        rate[8..11].copy_from_slice(k.angular_acceleration.as_slice());
        // A string cannot push: the step that would need it ends the run.
        let taut = k.tension_n >= 0.0;
        let turn_rate = k.twist_rate_rad_s - k.support.clamp_rate_rad_s;
        rate[11] = if taut { turn_rate } else { f64::NAN };
        rate[12] = self.thread.neutral_rate_rad_s(s.turn_rad, s.neutral_rad);
        rate[SPIN] = w3;
        rate[INERTIAL..].copy_from_slice(inertial.as_slice());
        rate
    }

    /// Rescales the quaternion as the plain equations do, and commits what the thread remembers.
    #[inline(always)]
    fn project(&self, y: &mut [f64; FULL_STATES]) {
        let scale = 1.5 - 0.5 * norm2(y);
        for component in &mut y[4..8] {
            *component *= scale;
        }
        let s = States::of(y);
        let strain_rad = self.thread.strained(&s.memory, s.turn_rad);
        y[MEMORY] = s.turn_rad;
        y[MEMORY + 1..SPIN].copy_from_slice(&strain_rad);
    }

    /// What a yielding thread does after a reversal depends on how far the turn had come, so a step
    /// must not run over one.
    #[inline(always)]
    fn regime(&self, time_s: f64, y: &[f64; FULL_STATES]) -> u32 {
        if !self.thread.yields() {
            return 0;
        }
        let s = States::of(y);
        self.thread.regime(s.turn_rad, self.turn_rate_rad_s(time_s, &s), &s.memory)
    }

    #[inline(always)]
    fn admissible(&self, _time_s: f64, y: &[f64; FULL_STATES]) -> bool {
        let upright_min = (0.5 * TILT_MAX_RAD).cos().powi(2);
        let lean = self.curvature_1_m * y[0].hypot(y[1]);
        (norm2(y) - 1.0).abs() < 0.01
            && y[4] * y[4] + y[7] * y[7] >= upright_min
            && lean <= STRING_LEAN_MAX
    }
}

#[inline(always)]
fn norm2(y: &[f64; FULL_STATES]) -> f64 {
    y[4] * y[4] + y[5] * y[5] + y[6] * y[6] + y[7] * y[7]
}

impl Form<FULL_STATES> for FullEquations {
    fn posture(&self, time_s: f64, y: &[f64; FULL_STATES]) -> Posture {
        let s = States::of(y);
        let twist_rad = s.turn_rad + self.support.at(self.origin_s + time_s).clamp_rad;
        Posture { q_wb: s.q, omega_wb_b_rad_s: s.omega.into(), twist_rad }
    }

    /// A body at rest gives an adaptive step no reason to be short, however its support shakes.
    fn step_max_s(&self) -> f64 {
        SUPPORT_PHASE_MAX_RAD / self.support.frequency_max_rad_s()
    }

    fn tension_n(&self, time_s: f64, y: &[f64; FULL_STATES]) -> f64 {
        self.kinetics(time_s, &States::of(y)).tension_n
    }

    fn weight_n(&self) -> f64 {
        self.mass_kg * self.gravity_m_s2
    }

    fn string_lean(&self, y: &[f64; FULL_STATES]) -> f64 {
        self.curvature_1_m * y[0].hypot(y[1]) / STRING_LEAN_MAX
    }

    fn motion(&self, time: SimTime, time_s: f64, y: &[f64; FULL_STATES]) -> BodyMotion {
        let s = States::of(y);
        let k = self.kinetics(time_s, &s);
        let [qw, qx, qy, qz] = s.q;
        let q_wb = UnitQuaternion::from_quaternion(Quaternion::new(qw, qx, qy, qz));
        let earth_b = q_wb.inverse_transform_vector(&self.earth_rate_w_rad_s);
        let height = self.suspension_height_m(&s.a_m, k.string_up);
        let suspension_w = k.support.position_w_m + s.a_m.push(height);
        BodyMotion {
            time,
            q_wb,
            omega_wb_b_rad_s: s.omega,
            twist_rad: s.turn_rad + k.support.clamp_rad,
            twist_rate_rad_s: k.twist_rate_rad_s,
            spin_rad: y[SPIN],
            omega_ib_b_rad_s: s.omega + earth_b,
            inertial_angle_b_rad: Vector3::new(y[INERTIAL], y[INERTIAL + 1], y[INERTIAL + 2]),
            angular_acceleration_b_rad_s2: k.angular_acceleration,
            com_position_w_m: suspension_w - q_wb * self.suspension_b_m,
            com_velocity_w_m_s: k.com_velocity_w_m_s,
            com_acceleration_w_m_s2: k.com_acceleration_w_m_s2,
        }
    }

    fn hold(&mut self, origin_s: f64, torque_b_n_m: Vector3<f64>) {
        self.origin_s = origin_s;
        self.torque_b_n_m = torque_b_n_m;
    }

    /// A blow P, Q changes rates as a torque would accelerations, with the string's reaction λ so
    /// great that A does not leave its sphere: λ = −[n·Q/M + u·J⁻¹P]/(1/M + u·J⁻¹u).
    fn kick(&self, _time_s: f64, y: &mut [f64; FULL_STATES], impulse: &Impulse) {
        let s = States::of(y);
        let n = self.string_w(&s.a_m);
        let angular = Vector3::from(impulse.angular_b_n_m_s);
        let linear = Vector3::from(impulse.linear_w_n_s) / self.mass_kg;
        let u = self.suspension_b_m.cross(&rotation(s.q).tr_mul(&n));
        let (free, lever) = (self.inverse_inertia * angular, self.inverse_inertia * u);
        let reaction = -(n.dot(&linear) + u.dot(&free)) / (self.mass_kg.recip() + u.dot(&lever));
        let com = s.com_velocity_w_m_s + linear.xy() + n.xy() * (reaction / self.mass_kg);
        let omega = s.omega + free + lever * reaction;
        (y[2], y[3]) = (com.x, com.y);
        y[8..11].copy_from_slice(omega.as_slice());
    }
}
