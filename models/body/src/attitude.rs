//! Attitude as the equations of the body keep it: the vertical that the body sees, and the twist.

use nalgebra::{Quaternion, UnitQuaternion};

/// cos 170°: the third component of the vertical at [`crate::TILT_MAX_RAD`].
pub(crate) const VERTICAL_MIN: f64 = -0.984_807_753_012_208;

/// The vertical in body components, γ = Rᵀe_z.
pub(crate) fn vertical(q_wb: &UnitQuaternion<f64>) -> [f64; 3] {
    let (w, x, y, z) = (q_wb.w, q_wb.i, q_wb.j, q_wb.k);
    [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 2.0 * (w * w + z * z) - 1.0]
}

/// The attitude of a vertical and a twist: the swing that takes the vertical there, after the
/// twist. Its w and z are in the proportion of cos τ/2 and sin τ/2, and w² + z² = (1 + γ₃)/2; what
/// is left is [`vertical`] solved for x and y.
pub(crate) fn attitude([g1, g2, g3]: [f64; 3], twist_rad: f64) -> UnitQuaternion<f64> {
    let upright = 1.0 + g3;
    let half_tilt_cos = (0.5 * upright).sqrt();
    let (sin, cos) = (0.5 * twist_rad).sin_cos();
    let (w, z) = (half_tilt_cos * cos, half_tilt_cos * sin);
    let (x, y) = ((z * g1 + w * g2) / upright, (z * g2 - w * g1) / upright);
    // An integration leaves |γ| = 1 by its error.
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{StartState, TILT_MAX_RAD};

    #[test]
    fn vertical_and_twist_are_the_attitude() {
        for (tilt_rad, tilt_azimuth_rad, twist_rad) in [
            (0.0, 0.0, 0.0),
            (0.3, 1.0, 7.0),
            (2.5, -2.0, -40.0),
            (1e-9, 3.0, 0.1),
            (-TILT_MAX_RAD, 0.7, 3.0),
        ] {
            let start = StartState { tilt_rad, tilt_azimuth_rad, twist_rad, ..StartState::AT_REST };
            let q_wb = start.attitude();
            // Sign and all: both follow the twist through its whole turns.
            let off = (attitude(vertical(&q_wb), twist_rad).coords - q_wb.coords).norm();
            // Some roundings; near upside down those of 1 + γ₃ grow by 1/cos²(θ/2), at most 132.
            let roundings = 10.0 / (0.5 * tilt_rad).cos().powi(2);
            assert!(off < roundings * f64::EPSILON, "tilt {tilt_rad}: {off:e}");
        }
    }

    #[test]
    fn the_least_vertical_is_that_of_the_largest_tilt() {
        assert!((TILT_MAX_RAD.cos() - VERTICAL_MIN).abs() < 1e-15);
    }
}
