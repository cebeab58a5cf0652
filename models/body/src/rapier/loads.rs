//! What a rig does to its body besides hanging it up: thread, air, support, commands, disturbances.

use super::{Load, Loads, Momentum, Synchronous};
use crate::disturbance::Timeline;
use crate::thread::{Memory, ThreadLaw};
use crate::{BodyError, Drag, Rig, Support};
use nalgebra::Vector3;
use struna_kernel::SimTime;

/// The loads of a [`Rig`], each taken at the grid point that its step is centred on.
///
/// The thread's own state lives here: its strains move on once a step with the turn of that step,
/// which is of second order like everything else. Noise is the mean of its path over the step, so
/// a step of any length sees the same path as the other engine.
#[derive(Debug, Clone)]
pub(super) struct RigLoads {
    thread: ThreadLaw,
    memory: Memory,
    neutral_rad: f64,
    drag: Drag,
    support: Support,
    gravity_m_s2: f64,
    timeline: Timeline,
    /// Commanded torque in body components.
    pub(super) torque_b_n_m: Vector3<f64>,
}

impl RigLoads {
    /// The loads of `rig` on a body that starts with `twist_rad`.
    ///
    /// # Errors
    /// [`BodyError`] for an impossible thread or grid of disturbances.
    pub(super) fn new(rig: &Rig, twist_rad: f64) -> Result<Self, BodyError> {
        let turn_rad = twist_rad - rig.support.at(0.0).clamp_rad;
        Ok(Self {
            thread: rig.thread_law()?,
            memory: Memory { turn_rad, ..Memory::default() },
            neutral_rad: 0.0,
            drag: rig.drag,
            support: rig.support.clone(),
            gravity_m_s2: rig.body.params().gravity_m_s2,
            timeline: Timeline::new(&rig.disturbances)?,
            torque_b_n_m: Vector3::zeros(),
        })
    }

    /// Moves strains and neutral angle on to `turn_rad`, a step after the last; none is taken at
    /// the start.
    fn commit(&mut self, turn_rad: f64, step_s: f64) {
        let strain_rad = self.thread.strained(&self.memory, turn_rad);
        let turned = (self.memory.turn_rad, turn_rad);
        self.neutral_rad = self.thread.neutral_after_rad(self.neutral_rad, turned, step_s);
        self.memory = Memory { turn_rad, strain_rad };
    }

    /// Mean noise torque over the step centred on `time_s`; the first begins at the start.
    fn noise_b_n_m(&mut self, time_s: f64, step_s: f64) -> Vector3<f64> {
        let edge = |s: f64| SimTime::from_s(s.max(0.0)).unwrap_or_default();
        let (from, to) = (edge(time_s - 0.5 * step_s), edge(time_s + 0.5 * step_s));
        self.timeline.mean_noise_b_n_m(from, to)
    }
}

impl Loads for RigLoads {
    fn load(&mut self, now: &Synchronous, step_s: f64) -> Load {
        let support = self.support.at(now.time_s);
        let turn_rad = now.twist_rad - support.clamp_rad;
        if now.time_s > 0.0 {
            self.commit(turn_rad, step_s);
        }
        let turn_rate_rad_s = now.twist_rate_rad_s - support.clamp_rate_rad_s;
        let string_n_m =
            self.thread.torque_n_m(turn_rad, turn_rate_rad_s, self.neutral_rad, &self.memory);
        let vertical_b = now.q_wb.inverse_transform_vector(&Vector3::z());
        let bisector = (vertical_b + Vector3::z()) / (1.0 + vertical_b.z);
        let climb = Vector3::z() * support.velocity_w_m_s.z;
        let noise_b_n_m = self.noise_b_n_m(now.time_s, step_s);
        Load {
            torque_b_n_m: bisector * string_n_m
                + self.torque_b_n_m
                + noise_b_n_m
                + self.drag.torque_n_m(&now.omega_wb_b_rad_s),
            force_w_n: self.drag.force_n(&(now.com_velocity_w_m_s + climb)),
            // The joint holds A at the height of the support: in its frame, the support's
            // acceleration is weight.
            gravity_m_s2: self.gravity_m_s2 + support.acceleration_w_m_s2.z,
        }
    }

    fn impulse(&mut self, _from_s: f64, to_s: f64) -> Option<Momentum> {
        let mut sum: Option<Momentum> = None;
        while let Some(change) = self.timeline.next_change().filter(|t| t.as_s() < to_s) {
            for impulse in self.timeline.pass(change) {
                let sum = sum.get_or_insert_default();
                sum.angular_b_n_m_s += Vector3::from(impulse.angular_b_n_m_s);
                sum.linear_w_n_s += Vector3::from(impulse.linear_w_n_s);
            }
        }
        sum
    }
}
