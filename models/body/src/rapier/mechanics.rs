//! How a hung rigid body answers to torques and forces, for the instants that rapier cannot do: the
//! start, and a kick.

use super::engine::RigidBody;
use super::{Load, Momentum, Synchronous};
use nalgebra::{UnitQuaternion, Vector3};

/// Changes of the velocities, in world components: per second under a load, at once by a kick.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Response {
    pub omega_w: Vector3<f64>,
    /// Of the centre of mass.
    pub com_w: Vector3<f64>,
}

/// Newton and Euler about the centre of mass, with the tension T of a string that keeps A at its
/// height: with ρ from C to A, γ the vertical and u = ρ×γ, all in body components,
///
/// ```text
/// T  = (a − F_z/M − u·J⁻¹m) / (1/M + u·J⁻¹u)
/// ω′ = J⁻¹(m + u T),  v_C′ = (F + e_z T)/M
/// ```
///
/// for a torque m in body components and a force F in world components at C, where the turning
/// alone makes A fall at the rate `falling` = a.
fn response(
    rigid: &RigidBody,
    q_wb: &UnitQuaternion<f64>,
    (moment_b, force_w): (Vector3<f64>, Vector3<f64>),
    falling: f64,
) -> Response {
    let vertical_b = q_wb.inverse_transform_vector(&Vector3::z());
    let lever = -rigid.com_b_m.cross(&vertical_b);
    let inverse = rigid.inertia_b_kg_m2.try_inverse().unwrap_or_default();
    let free = falling - force_w.z / rigid.mass_kg - lever.dot(&(inverse * moment_b));
    let tension = free / (1.0 / rigid.mass_kg + lever.dot(&(inverse * lever)));
    Response {
        omega_w: q_wb * (inverse * (moment_b + lever * tension)),
        com_w: (force_w + Vector3::z() * tension) / rigid.mass_kg,
    }
}

/// Accelerations under a load, rad/s² and m/s².
pub(super) fn acceleration(rigid: &RigidBody, now: &Synchronous, load: &Load) -> Response {
    let w = now.omega_wb_b_rad_s;
    let vertical_b = now.q_wb.inverse_transform_vector(&Vector3::z());
    let falling = vertical_b.dot(&w.cross(&w.cross(&rigid.com_b_m)));
    let moment_b = load.torque_b_n_m - gyroscopic_torque(rigid, &w);
    let weight = Vector3::z() * (rigid.mass_kg * load.gravity_m_s2);
    response(rigid, &now.q_wb, (moment_b, load.force_w_n - weight), falling)
}

/// Changes of the velocities by an impulse, rad/s and m/s.
pub(super) fn kick(rigid: &RigidBody, q_wb: &UnitQuaternion<f64>, impulse: &Momentum) -> Response {
    response(rigid, q_wb, (impulse.angular_b_n_m_s, impulse.linear_w_n_s), 0.0)
}

/// ω×Jω, the rate at which turning axes alone change the momentum in body components.
pub(super) fn gyroscopic_torque(rigid: &RigidBody, omega_b: &Vector3<f64>) -> Vector3<f64> {
    omega_b.cross(&(rigid.inertia_b_kg_m2 * omega_b))
}
