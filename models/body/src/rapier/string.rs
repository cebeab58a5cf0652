//! The load of an ideal string: it resists twist, and nothing else acts but what is asked for.

use super::{Impulse, Load, Loads, Synchronous};
use nalgebra::Vector3;

/// −(kτ + cτ′)(γ + e₃)/(1 + γ₃) and a held torque, with impulses at chosen instants.
#[derive(Debug, Clone)]
pub(super) struct IdealString {
    pub stiffness_n_m_rad: f64,
    pub damping_n_m_s_rad: f64,
    pub gravity_m_s2: f64,
    /// Held torque in body components.
    pub torque_b_n_m: Vector3<f64>,
    /// What is still to come, the next one last.
    pending: Vec<(f64, Impulse)>,
}

impl IdealString {
    pub(super) fn new(body: &crate::Body) -> Self {
        Self {
            stiffness_n_m_rad: body.stiffness_n_m_rad(),
            damping_n_m_s_rad: body.damping_n_m_s_rad(),
            gravity_m_s2: body.params().gravity_m_s2,
            torque_b_n_m: Vector3::zeros(),
            pending: Vec::new(),
        }
    }

    pub(super) fn schedule(&mut self, time_s: f64, impulse: Impulse) {
        let later = self.pending.partition_point(|(pending_s, _)| *pending_s > time_s);
        self.pending.insert(later, (time_s, impulse));
    }
}

impl Loads for IdealString {
    fn load(&mut self, now: &Synchronous, _step_s: f64) -> Load {
        let resisting_n_m =
            self.stiffness_n_m_rad * now.twist_rad + self.damping_n_m_s_rad * now.twist_rate_rad_s;
        let vertical_b = now.q_wb.inverse_transform_vector(&Vector3::z());
        let bisector = (vertical_b + Vector3::z()) / (1.0 + vertical_b.z);
        Load {
            torque_b_n_m: self.torque_b_n_m - bisector * resisting_n_m,
            force_w_n: Vector3::zeros(),
            gravity_m_s2: self.gravity_m_s2,
        }
    }

    fn impulse(&mut self, _from_s: f64, to_s: f64) -> Option<Impulse> {
        let mut sum: Option<Impulse> = None;
        // One that came too late for its own step acts in the next one.
        while let Some((_, impulse)) = self.pending.pop_if(|(time_s, _)| *time_s < to_s) {
            let sum = sum.get_or_insert_default();
            sum.angular_b_n_m_s += impulse.angular_b_n_m_s;
            sum.linear_w_n_s += impulse.linear_w_n_s;
        }
        sum
    }
}
