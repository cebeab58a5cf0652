//! The same mechanics with twice the coordinates: an independent judge of the finite string.
//!
//! Position and velocity of the centre of mass are states in all three directions, the string is
//! a constraint, and accelerations and tension come from one linear system of seven equations.
//! Nothing is shared with the equations under test. Since such a form lets the string stretch,
//! position and velocity are projected onto the constraint after every step.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use nalgebra::{Matrix3, Quaternion, SMatrix, SVector, Vector3};
use struna_body::{Body, StartState};

/// r_C, v_C, q (w, x, y, z), ω, τ.
pub(crate) type States = SVector<f64, 14>;

/// Displacement, velocity and acceleration of the support.
pub(crate) type Shaking = fn(f64) -> [Vector3<f64>; 3];

pub(crate) struct Redundant {
    mass_kg: f64,
    gravity_m_s2: f64,
    inertia: Matrix3<f64>,
    suspension_b_m: Vector3<f64>,
    stiffness_n_m_rad: f64,
    length_m: f64,
    shaking: Shaking,
}

/// String and lever at one instant.
struct Constraint {
    rotation: Matrix3<f64>,
    /// Unit vector from A to O, and their distance.
    n: Vector3<f64>,
    distance_m: f64,
    /// Velocity of A against O.
    v: Vector3<f64>,
    /// ρ×n in body components.
    lever: Vector3<f64>,
}

fn part(y: &States, from: usize) -> Vector3<f64> {
    y.fixed_rows::<3>(from).into_owned()
}

fn quaternion(y: &States) -> Quaternion<f64> {
    Quaternion::new(y[6], y[7], y[8], y[9])
}

impl Redundant {
    pub(crate) fn new(body: &Body, length_m: f64, shaking: Shaking) -> Self {
        Self {
            mass_kg: body.params().mass_kg,
            gravity_m_s2: body.params().gravity_m_s2,
            inertia: body.inertia_b_kg_m2(),
            suspension_b_m: body.suspension_b_m(),
            stiffness_n_m_rad: body.stiffness_n_m_rad(),
            length_m,
            shaking,
        }
    }

    /// States of a start with the string vertical under a support that may already move.
    pub(crate) fn states(&self, start: &StartState) -> States {
        let [shift, speed, _] = (self.shaking)(0.0);
        let q = start.attitude();
        let omega = Vector3::from(start.omega_wb_b_rad_s);
        let swing = q * omega.cross(&self.suspension_b_m);
        let [vx, vy] = start.com_velocity_w_m_s;
        let mut y = States::zeros();
        y.fixed_rows_mut::<3>(0).copy_from(&(shift - q * self.suspension_b_m));
        y.fixed_rows_mut::<3>(3).copy_from(&Vector3::new(vx, vy, speed.z - swing.z));
        y.fixed_rows_mut::<4>(6).copy_from_slice(&[q.w, q.i, q.j, q.k]);
        y.fixed_rows_mut::<3>(10).copy_from(&omega);
        y[13] = start.twist_rad;
        y
    }

    fn constraint(&self, time_s: f64, y: &States) -> Constraint {
        let [shift, speed, _] = (self.shaking)(time_s);
        let rotation = rotation(&quaternion(y));
        let above = Vector3::z() * self.length_m + shift;
        let reach = above - (part(y, 0) + rotation * self.suspension_b_m);
        let n = reach.normalize();
        let v = part(y, 3) + rotation * part(y, 10).cross(&self.suspension_b_m) - speed;
        let lever = self.suspension_b_m.cross(&rotation.tr_mul(&n));
        Constraint { rotation, n, distance_m: reach.norm(), v, lever }
    }

    /// Accelerations of C and of the rotation, and the tension, from seven linear equations:
    /// Newton, Euler, and the second derivative of |AO| = L.
    fn accelerations(&self, time_s: f64, y: &States, torque: &Vector3<f64>) -> SVector<f64, 7> {
        let [_, _, acceleration] = (self.shaking)(time_s);
        let c = self.constraint(time_s, y);
        let w = part(y, 10);
        let mut left = SMatrix::<f64, 7, 7>::zeros();
        left.fixed_view_mut::<3, 3>(0, 0).copy_from(&(Matrix3::identity() * self.mass_kg));
        left.fixed_view_mut::<3, 1>(0, 6).copy_from(&-c.n);
        left.fixed_view_mut::<3, 3>(3, 3).copy_from(&self.inertia);
        left.fixed_view_mut::<3, 1>(3, 6).copy_from(&-c.lever);
        left.fixed_view_mut::<1, 3>(6, 0).copy_from(&c.n.transpose());
        left.fixed_view_mut::<1, 3>(6, 3).copy_from(&c.lever.transpose());
        let centripetal = c.rotation * w.cross(&w.cross(&self.suspension_b_m));
        let across = c.v - c.n * c.n.dot(&c.v);
        let mut right = SVector::<f64, 7>::zeros();
        right[2] = -self.mass_kg * self.gravity_m_s2;
        right.fixed_rows_mut::<3>(3).copy_from(&(torque - w.cross(&(self.inertia * w))));
        right[6] = across.norm_squared() / c.distance_m + c.n.dot(&(acceleration - centripetal));
        left.lu().solve(&right).unwrap()
    }

    fn derivative(&self, time_s: f64, y: &States) -> States {
        let (q, w) = (quaternion(y), part(y, 10));
        let vertical = rotation(&q).tr_mul(&Vector3::z());
        let bisector = (vertical + Vector3::z()) / (1.0 + vertical.z);
        let a = self.accelerations(time_s, y, &(-self.stiffness_n_m_rad * y[13] * bisector));
        let turn = (q * Quaternion::from_imag(w)).coords * 0.5;
        let mut rate = States::zeros();
        rate.fixed_rows_mut::<3>(0).copy_from(&part(y, 3));
        rate.fixed_rows_mut::<3>(3).copy_from(&a.fixed_rows::<3>(0));
        rate.fixed_rows_mut::<4>(6).copy_from_slice(&[turn.w, turn.x, turn.y, turn.z]);
        rate.fixed_rows_mut::<3>(10).copy_from(&a.fixed_rows::<3>(3));
        rate[13] = w.dot(&bisector);
        rate
    }

    /// One step of the classical Runge-Kutta method, and the projection.
    pub(crate) fn step(&self, time_s: f64, y: &States, h: f64) -> States {
        let k1 = self.derivative(time_s, y);
        let k2 = self.derivative(time_s + 0.5 * h, &(y + k1 * (0.5 * h)));
        let k3 = self.derivative(time_s + 0.5 * h, &(y + k2 * (0.5 * h)));
        let k4 = self.derivative(time_s + h, &(y + k3 * h));
        self.projected(time_s + h, y + (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0))
    }

    /// Pulls A back onto its sphere and its velocity into the tangent plane, both by the smallest
    /// change in the metric of the masses.
    fn projected(&self, time_s: f64, mut y: States) -> States {
        let c = self.constraint(time_s, &y);
        let inverse = self.inertia.try_inverse().unwrap();
        let mobility = 1.0 / self.mass_kg + c.lever.dot(&(inverse * c.lever));
        let mu = (c.distance_m - self.length_m) / mobility;
        let moved = part(&y, 0) + c.n * (mu / self.mass_kg);
        let turn = Quaternion::from_imag(inverse * c.lever * (0.5 * mu));
        let q = (quaternion(&y) + quaternion(&y) * turn).normalize();
        y.fixed_rows_mut::<3>(0).copy_from(&moved);
        y.fixed_rows_mut::<4>(6).copy_from_slice(&[q.w, q.i, q.j, q.k]);
        let c = self.constraint(time_s, &y);
        let la = -c.n.dot(&c.v) / (1.0 / self.mass_kg + c.lever.dot(&(inverse * c.lever)));
        let velocity = part(&y, 3) + c.n * (la / self.mass_kg);
        let omega = part(&y, 10) + inverse * c.lever * la;
        y.fixed_rows_mut::<3>(3).copy_from(&velocity);
        y.fixed_rows_mut::<3>(10).copy_from(&omega);
        y
    }

    pub(crate) fn attitude(y: &States) -> nalgebra::UnitQuaternion<f64> {
        nalgebra::UnitQuaternion::from_quaternion(quaternion(y))
    }
}

/// R = 1 + 2 (w [v]ₓ + [v]ₓ²): exact for a unit quaternion.
fn rotation(q: &Quaternion<f64>) -> Matrix3<f64> {
    let cross = q.imag().cross_matrix();
    Matrix3::identity() + (cross * q.w + cross * cross) * 2.0
}
