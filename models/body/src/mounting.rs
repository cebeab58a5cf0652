//! What a gyro feels where it is mounted.

use crate::Body;
use nalgebra::{Unit, Vector3};
use struna_kernel::{BodyMotion, Bound, ParameterError};

/// The motion of a body at one instant, as far as a gyro on it feels it or is judged by it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MountedMotion {
    /// Integral of the inertial rate about the input axis since the start, rad.
    pub input_angle_rad: f64,
    /// Inertial rate about the input axis, rad/s.
    pub input_rate_rad_s: f64,
    /// Specific force at the gyro along [`Mounting::case_axes_b`], m/s².
    pub specific_force_s_m_s2: [f64; 3],
    /// Integral of the body z rate since the twist was zero, rad.
    pub spin_rad: f64,
    /// Rate relative to the room about the body's z axis, rad/s.
    pub rate_rad_s: f64,
    /// Twist of the string, rad.
    pub twist_rad: f64,
    /// Rate of the twist, rad/s.
    pub twist_rate_rad_s: f64,
}

/// What a [`MountedMotion`] is made of, as [`BodyMotion`] has it; body components.
pub(crate) struct MotionParts {
    /// Specific force at the centre of mass.
    pub com_force_b_m_s2: Vector3<f64>,
    pub omega_wb_b_rad_s: Vector3<f64>,
    pub omega_ib_b_rad_s: Vector3<f64>,
    pub angular_acceleration_b_rad_s2: Vector3<f64>,
    /// Integrals of the rates since the start.
    pub angle_b_rad: Vector3<f64>,
    pub suspension_b_m: Vector3<f64>,
    pub spin_rad: f64,
    pub twist_rad: f64,
    pub twist_rate_rad_s: f64,
}

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
    #[inline]
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
    #[inline]
    pub fn rate_rad_s(&self, motion: &BodyMotion) -> f64 {
        self.input_axis_b.dot(&motion.omega_ib_b_rad_s)
    }

    /// Integral of that rate since the start, rad. Its difference over a sample interval, divided
    /// by the interval, is the exact mean rate.
    #[must_use]
    #[inline]
    pub fn angle_rad(&self, motion: &BodyMotion) -> f64 {
        self.input_axis_b.dot(&motion.inertial_angle_b_rad)
    }

    /// Specific force at the gyro's place, body components, m/s²: what its g-sensitivity acts on.
    ///
    /// `suspension_b_m` is [`crate::Body::suspension_b_m`].
    #[must_use]
    #[inline]
    pub fn specific_force_b_m_s2(
        &self,
        motion: &BodyMotion,
        suspension_b_m: &Vector3<f64>,
        gravity_m_s2: f64,
    ) -> Vector3<f64> {
        let weightless = motion.com_acceleration_w_m_s2 + Vector3::z() * gravity_m_s2;
        let turning = [motion.omega_wb_b_rad_s, motion.angular_acceleration_b_rad_s2];
        let of_com = motion.q_wb.inverse_transform_vector(&weightless);
        self.specific_force_from(of_com, turning, suspension_b_m)
    }

    /// The same from the specific force at the centre of mass, rate and angular acceleration, all
    /// in body components.
    #[inline(always)]
    fn specific_force_from(
        &self,
        of_com_m_s2: Vector3<f64>,
        [omega, acceleration]: [Vector3<f64>; 2],
        suspension_b_m: &Vector3<f64>,
    ) -> Vector3<f64> {
        let from_com = suspension_b_m + self.position_b_m;
        of_com_m_s2 + acceleration.cross(&from_com) + omega.cross(&omega.cross(&from_com))
    }

    /// What a gyro in this mounting has of `motion`.
    pub(crate) fn mounted(&self, motion: &BodyMotion, body: &Body) -> MountedMotion {
        let up_m_s2 = Vector3::z() * body.params().gravity_m_s2;
        let com_force_w_m_s2 = motion.com_acceleration_w_m_s2 + up_m_s2;
        let parts = MotionParts {
            com_force_b_m_s2: motion.q_wb.inverse_transform_vector(&com_force_w_m_s2),
            omega_wb_b_rad_s: motion.omega_wb_b_rad_s,
            omega_ib_b_rad_s: motion.omega_ib_b_rad_s,
            angular_acceleration_b_rad_s2: motion.angular_acceleration_b_rad_s2,
            angle_b_rad: motion.inertial_angle_b_rad,
            suspension_b_m: body.suspension_b_m(),
            spin_rad: motion.spin_rad,
            twist_rad: motion.twist_rad,
            twist_rate_rad_s: motion.twist_rate_rad_s,
        };
        self.mounted_from(&parts)
    }

    /// The same without a [`BodyMotion`], which takes longer to make than to use.
    #[inline(always)]
    pub(crate) fn mounted_from(&self, parts: &MotionParts) -> MountedMotion {
        let turning = [parts.omega_wb_b_rad_s, parts.angular_acceleration_b_rad_s2];
        let of_com_m_s2 = parts.com_force_b_m_s2;
        let force_b = self.specific_force_from(of_com_m_s2, turning, &parts.suspension_b_m);
        MountedMotion {
            input_angle_rad: self.input_axis_b.dot(&parts.angle_b_rad),
            input_rate_rad_s: self.input_axis_b.dot(&parts.omega_ib_b_rad_s),
            specific_force_s_m_s2: self.case_axes_b.map(|axis_b| force_b.dot(&axis_b)),
            spin_rad: parts.spin_rad,
            rate_rad_s: parts.omega_wb_b_rad_s.z,
            twist_rad: parts.twist_rad,
            twist_rate_rad_s: parts.twist_rate_rad_s,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Backend, Drag, Integrator, Rig, TruthMotion, reference};
    use nalgebra::Rotation3;
    use std::f64::consts::FRAC_PI_4;
    use struna_kernel::{SampleGrid, SimTime};

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

    /// What a gyro has, by each of the two routes.
    fn both_ways(rig: &Rig, backend: impl Into<Backend> + Copy) -> Vec<[MountedMotion; 2]> {
        let mounting = Mounting::new([0.3, -0.2], [0.02, -0.03, 0.05]).unwrap();
        let truth = || TruthMotion::new(rig.clone(), &reference::S3, backend).unwrap();
        let (mut lean, mut whole) = (truth(), truth());
        let grid = SampleGrid::new(SimTime::ZERO, 1400.0).unwrap();
        let both = |k| {
            let time = grid.time_of(k);
            let motion = whole.motion_at(time).unwrap();
            [lean.mounted_at(time, &mounting).unwrap(), mounting.mounted(&motion, &rig.body)]
        };
        (0..1400).step_by(7).map(both).collect()
    }

    #[test]
    fn a_mounted_gyro_has_of_the_motion_what_the_whole_motion_says() {
        let plain = Rig::from(Body::new(&reference::PARAMS).unwrap());
        let drag = Drag { rotation_n_m_s_rad: 1e-6, ..Drag::NONE };
        let full = Rig { drag, ..plain.clone() };
        let walk = Backend::from(Integrator::Rk4 { step_s: 1.0 / 1400.0 });
        let record = Backend::from(Integrator::Dop853 { rtol: 1e-12, atol: 1e-11 });
        // Forces of 10 m/s² by products of some ten factors; the dense output leaves the unit
        // quaternion, by which only one of the routes divides, by its own error of 1e-11.
        for (rig, backend, error_m_s2) in [
            (&plain, walk, 1e-13),
            (&plain, record, 1e-9),
            (&full, walk, 1e-13),
            (&plain, Backend::Rapier { step_s: 1e-3 }, 1e-13),
        ] {
            for [lean, whole] in both_ways(rig, backend) {
                for axis in 0..3 {
                    let off = lean.specific_force_s_m_s2[axis] - whole.specific_force_s_m_s2[axis];
                    assert!(off.abs() < error_m_s2, "{backend}, axis {axis}: {off:e}");
                }
                let specific_force_s_m_s2 = whole.specific_force_s_m_s2;
                assert_eq!(MountedMotion { specific_force_s_m_s2, ..lean }, whole, "{backend}");
            }
        }
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
