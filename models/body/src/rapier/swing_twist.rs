//! The twist of the string, from the attitude.

use crate::TILT_MAX_RAD;
use nalgebra::{RealField, UnitQuaternion, Vector3};
use std::f64::consts::TAU;

/// The twist τ = 2 atan2(q_z, q_w), which repeats every turn, nearest to `near_rad`.
pub(super) fn twist_near(q_wb: &UnitQuaternion<f64>, near_rad: f64) -> f64 {
    // Through nalgebra, whose build uses the same arc tangent on every platform.
    let twist_rad = 2.0 * RealField::atan2(q_wb.k, q_wb.w);
    twist_rad + TAU * ((near_rad - twist_rad) / TAU).round()
}

/// Rate of the twist τ′ = ω·(γ + e₃)/(1 + γ₃), from the rate in body components.
pub(super) fn twist_rate_rad_s(q_wb: &UnitQuaternion<f64>, omega_b: &Vector3<f64>) -> f64 {
    let vertical_b = q_wb.inverse_transform_vector(&Vector3::z());
    let along = omega_b.x * vertical_b.x + omega_b.y * vertical_b.y;
    omega_b.z + along / (1.0 + vertical_b.z)
}

/// q_w² + q_z² = cos²(θ/2) at the largest tilt θ.
pub(super) fn upright_min() -> f64 {
    (0.5 * TILT_MAX_RAD).cos().powi(2)
}

/// Whether the tilt is below the largest one.
pub(super) fn is_upright(q_wb: &UnitQuaternion<f64>, upright_min: f64) -> bool {
    q_wb.w * q_wb.w + q_wb.k * q_wb.k >= upright_min
}
