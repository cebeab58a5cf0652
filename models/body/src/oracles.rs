//! What the motion conserves, for tests and for judging other engines.

use crate::Body;
use nalgebra::Vector3;
use struna_kernel::BodyMotion;

impl Body {
    /// Energy of the motion, J: translation, rotation about the centre of mass, height, and the
    /// linear spring of the string on a clamp at zero. Zero at rest in equilibrium for an aligned
    /// body.
    #[must_use]
    pub fn energy_j(&self, motion: &BodyMotion) -> f64 {
        let p = self.params();
        let translation_j = 0.5 * p.mass_kg * motion.com_velocity_w_m_s.norm_squared();
        let rise_m = motion.com_position_w_m.z + p.com_depth_m;
        translation_j
            + 0.5 * motion.omega_wb_b_rad_s.dot(&self.momentum_b_n_m_s(motion))
            + p.mass_kg * p.gravity_m_s2 * rise_m
            + 0.5 * self.stiffness_n_m_rad() * motion.twist_rad * motion.twist_rad
    }

    /// Angular momentum about the centre of mass, body components, N·m·s.
    fn momentum_b_n_m_s(&self, motion: &BodyMotion) -> Vector3<f64> {
        self.inertia_b_kg_m2() * motion.omega_wb_b_rad_s
    }

    /// Angular momentum about the vertical through the centre of mass, Lz = Jω·γ, N·m·s.
    /// Constant when neither string nor torque acts about the vertical (k = c = 0).
    #[must_use]
    pub fn vertical_momentum_n_m_s(&self, motion: &BodyMotion) -> f64 {
        self.momentum_b_n_m_s(motion).dot(&vertical_of(motion))
    }

    /// Lz − C·ω_z, N·m·s. Constant for A = B whatever the string's stiffness and damping, because
    /// the string's torque has equal shares about the vertical and the body axis.
    #[must_use]
    pub fn momentum_difference_n_m_s(&self, motion: &BodyMotion) -> f64 {
        self.vertical_momentum_n_m_s(motion) - self.momentum_b_n_m_s(motion).z
    }
}

fn vertical_of(motion: &BodyMotion) -> Vector3<f64> {
    motion.q_wb.inverse_transform_vector(&Vector3::z())
}
