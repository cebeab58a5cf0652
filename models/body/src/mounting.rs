//! What a gyro feels where it is mounted.

use nalgebra::{Unit, Vector3};
use struna_kernel::{BodyMotion, Bound, ParameterError};

/// How a single-axis gyro sits on the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mounting {
    input_axis_b: Unit<Vector3<f64>>,
    /// See [`Self::case_axes_b`]; they do not change, and every sample asks for them.
    case_axes_b: [Vector3<f64>; 3],
    position_b_m: Vector3<f64>,
}

impl Default for Mounting {
    /// On the body's z axis, at the point that the string holds.
    fn default() -> Self {
        Self::along(Vector3::z_axis(), Vector3::zeros())
    }
}

impl Mounting {
    /// A gyro whose input axis is turned from the body's z axis by small rotations about the
    /// body's x and y axes, first about x, at `position_b_m` from the point that the string holds.
    ///
    /// A rotation about x by α and about y by β puts the axis at
    /// (sin β cos α, −sin α, cos β cos α).
    ///
    /// # Errors
    /// [`ParameterError`] for values that are not finite, and for a misalignment of half a right
    /// angle or more: that is another input axis.
    pub fn new(misalignment_rad: [f64; 2], position_b_m: [f64; 3]) -> Result<Self, ParameterError> {
        for angle_rad in misalignment_rad {
            let reason = "a larger one would be another input axis";
            let limit = Bound::AtMost(std::f64::consts::FRAC_PI_4);
            limit.check("|misalignment_rad|", angle_rad.abs(), reason)?;
        }
        for position_m in position_b_m {
            Bound::Finite.check("position_b_m", position_m, "the gyro is in a place")?;
        }
        let (sin_x, cos_x) = misalignment_rad[0].sin_cos();
        let (sin_y, cos_y) = misalignment_rad[1].sin_cos();
        let axis = Vector3::new(sin_y * cos_x, -sin_x, cos_y * cos_x);
        Ok(Self::along(Unit::new_normalize(axis), position_b_m.into()))
    }

    fn along(input_axis_b: Unit<Vector3<f64>>, position_b_m: Vector3<f64>) -> Self {
        let z_b = input_axis_b.into_inner();
        // Turned by at most 45 degrees about each axis, z keeps a part in that plane.
        let x_b = Vector3::new(z_b.z, 0.0, -z_b.x).normalize();
        Self { input_axis_b, case_axes_b: [x_b, z_b.cross(&x_b), z_b], position_b_m }
    }

    /// Axes of the gyro's case, body components: the third is the input axis, the first stays in
    /// the plane of the body's x and z, as the mounting's rotations leave it.
    #[must_use]
    pub fn case_axes_b(&self) -> &[Vector3<f64>; 3] {
        &self.case_axes_b
    }

    /// Direction of positive measured rate, body components.
    #[must_use]
    pub fn input_axis_b(&self) -> Unit<Vector3<f64>> {
        self.input_axis_b
    }

    /// Inertial rate about the input axis at the instant of `motion`, rad/s. The place of a gyro
    /// on a rigid body does not matter to it.
    #[must_use]
    pub fn rate_rad_s(&self, motion: &BodyMotion) -> f64 {
        self.input_axis_b.dot(&motion.omega_ib_b_rad_s)
    }

    /// Integral of that rate since the start, rad. Its difference over a sample interval, divided
    /// by the interval, is the exact mean rate.
    #[must_use]
    pub fn angle_rad(&self, motion: &BodyMotion) -> f64 {
        self.input_axis_b.dot(&motion.inertial_angle_b_rad)
    }

    /// Specific force at the gyro's place, body components, m/s²: what its g-sensitivity acts on.
    ///
    /// `suspension_b_m` is [`crate::Body::suspension_b_m`].
    #[must_use]
    pub fn specific_force_b_m_s2(
        &self,
        motion: &BodyMotion,
        suspension_b_m: &Vector3<f64>,
        gravity_m_s2: f64,
    ) -> Vector3<f64> {
        let from_com = suspension_b_m + self.position_b_m;
        let omega = motion.omega_wb_b_rad_s;
        let weightless = motion.com_acceleration_w_m_s2 + Vector3::z() * gravity_m_s2;
        motion.q_wb.inverse_transform_vector(&weightless)
            + motion.angular_acceleration_b_rad_s2.cross(&from_com)
            + omega.cross(&omega.cross(&from_com))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;
    use std::f64::consts::FRAC_PI_4;

    #[test]
    fn misalignments_turn_the_axis_about_x_and_then_about_y() {
        for [x, y] in [[0.0, 0.0], [0.3, 0.0], [0.0, 0.3], [-0.2, 0.7], [FRAC_PI_4, -FRAC_PI_4]] {
            let axis = Mounting::new([x, y], [0.0; 3]).unwrap().input_axis_b();
            let about_x = Rotation3::from_axis_angle(&Vector3::x_axis(), x);
            let about_y = Rotation3::from_axis_angle(&Vector3::y_axis(), y);
            // Some products of numbers below one.
            assert!((axis.into_inner() - about_y * about_x * Vector3::z()).norm() < 1e-15);
        }
        let exact = Mounting::new([0.0; 2], [0.0; 3]).unwrap();
        assert_eq!(exact, Mounting::default());
    }

    #[test]
    fn mountings_that_are_none_are_refused_by_name() {
        for bad in [FRAC_PI_4 * (1.0 + 1e-15), -1.0, f64::NAN, f64::INFINITY] {
            for turns in [[bad, 0.0], [0.0, bad]] {
                let refused = Mounting::new(turns, [0.0; 3]).unwrap_err();
                assert_eq!(refused.name, "|misalignment_rad|", "{turns:?}");
            }
        }
        for axis in 0..3 {
            let mut place = [0.0; 3];
            place[axis] = f64::NAN;
            assert_eq!(Mounting::new([0.0; 2], place).unwrap_err().name, "position_b_m");
        }
    }
}
