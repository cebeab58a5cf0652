//! Drag of the air on the body.

use nalgebra::Vector3;
use struna_kernel::{Bound, ParameterError};

/// Viscous and quadratic drag, on the rotation about and the motion of the centre of mass.
///
/// Torque −(c + c₂|ω|)·ω and force −(b + b₂|v|)·v, the same in all directions: the shape of a body
/// is not described closely enough for more. Room air at rest.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Drag {
    /// Viscous part c of the torque, N·m·s/rad.
    pub rotation_n_m_s_rad: f64,
    /// Quadratic part c₂ of the torque, N·m·s²/rad².
    pub rotation_quadratic_n_m_s2_rad2: f64,
    /// Viscous part b of the force, N·s/m.
    pub translation_n_s_m: f64,
    /// Quadratic part b₂ of the force, N·s²/m².
    pub translation_quadratic_n_s2_m2: f64,
}

impl Drag {
    /// No air.
    pub const NONE: Self = Self {
        rotation_n_m_s_rad: 0.0,
        rotation_quadratic_n_m_s2_rad2: 0.0,
        translation_n_s_m: 0.0,
        translation_quadratic_n_s2_m2: 0.0,
    };

    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        let passive = "air takes energy away, it never adds any";
        for (name, value) in [
            ("drag_rotation_n_m_s_rad", self.rotation_n_m_s_rad),
            ("drag_rotation_quadratic_n_m_s2_rad2", self.rotation_quadratic_n_m_s2_rad2),
            ("drag_translation_n_s_m", self.translation_n_s_m),
            ("drag_translation_quadratic_n_s2_m2", self.translation_quadratic_n_s2_m2),
        ] {
            Bound::AtLeast(0.0).check(name, value, passive)?;
        }
        Ok(())
    }

    /// Torque on a body that turns at `omega_rad_s`, N·m, in the same components.
    #[inline(always)]
    pub(crate) fn torque_n_m(&self, omega_rad_s: &Vector3<f64>) -> Vector3<f64> {
        let quadratic = self.rotation_quadratic_n_m_s2_rad2 * omega_rad_s.norm();
        -(self.rotation_n_m_s_rad + quadratic) * omega_rad_s
    }

    /// Force on a body whose centre of mass moves at `velocity_m_s`, N, in the same components.
    #[inline(always)]
    pub(crate) fn force_n(&self, velocity_m_s: &Vector3<f64>) -> Vector3<f64> {
        let quadratic = self.translation_quadratic_n_s2_m2 * velocity_m_s.norm();
        -(self.translation_n_s_m + quadratic) * velocity_m_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drag_points_against_the_motion_and_grows_as_it_says() {
        let drag = Drag {
            rotation_n_m_s_rad: 1.0,
            rotation_quadratic_n_m_s2_rad2: 2.0,
            translation_n_s_m: 3.0,
            translation_quadratic_n_s2_m2: 4.0,
        };
        // 3-4-5: (1 + 2·5) and (3 + 4·5) times the vector, exact in binary.
        let v = Vector3::new(3.0, 0.0, -4.0);
        assert_eq!(drag.torque_n_m(&v), -11.0 * v);
        assert_eq!(drag.force_n(&v), -23.0 * v);
        assert_eq!(Drag::NONE.torque_n_m(&v), Vector3::zeros());
        assert_eq!(Drag::NONE.force_n(&v), Vector3::zeros());
    }

    #[test]
    fn air_that_would_drive_the_body_is_refused_by_name() {
        type Field = fn(&mut Drag) -> &mut f64;
        let fields: [(&str, Field); 4] = [
            ("drag_rotation_n_m_s_rad", |d| &mut d.rotation_n_m_s_rad),
            ("drag_rotation_quadratic_n_m_s2_rad2", |d| &mut d.rotation_quadratic_n_m_s2_rad2),
            ("drag_translation_n_s_m", |d| &mut d.translation_n_s_m),
            ("drag_translation_quadratic_n_s2_m2", |d| &mut d.translation_quadratic_n_s2_m2),
        ];
        assert!(Drag::NONE.check().is_ok());
        for (name, field) in fields {
            for bad in [-1e-9, f64::NAN, f64::INFINITY] {
                let mut drag = Drag::NONE;
                *field(&mut drag) = bad;
                let refused = drag.check().unwrap_err();
                assert_eq!((refused.name, refused.bound), (name, Bound::AtLeast(0.0)));
            }
        }
    }
}
