//! The motion by rapier, a second implementation that shares no equations with the first.
//!
//! rapier does the mechanics: the joint that keeps the suspension point at its height, gravity,
//! the reaction of the body, translation, and the update of the attitude. Out of the box it is of
//! first order here and off by 0.3 rad after a minute at 1 ms; what makes it one of second order,
//! six hundred times nearer at the same step, is how it is driven:
//!
//! * One velocity and one pose update a step, and no relaxation pass after them. That is the
//!   leap-frog scheme: poses at grid points, velocities half-way between.
//! * A half-kick at the start sets the velocities back by half a step, with the one acceleration
//!   that is computed here.
//! * Torques are taken at the grid point, where rates are extrapolated to by 3/2 and −1/2 of the
//!   last two (Adams-Bashforth), and rapier's own gyroscopic term, explicit and lagged, is off.
//! * Rates are reported at grid points as the mean of the two half a step away, never as rapier
//!   holds them: those lag by half a step.
//!
//! **Architecture Invariant:** rapier is named in `engine.rs` alone, and what acts on the body is
//! known here only as [`Loads`].

mod engine;
mod loads;
mod mechanics;
mod span;
mod swing_twist;
mod walk;

use crate::{BodyError, Rig, StartState, Support};
use engine::EngineState;
pub(crate) use engine::RigidBody;
use loads::RigLoads;
use mechanics::Response;
use nalgebra::{UnitQuaternion, Vector3};
use struna_kernel::{BodyMotion, Bound, SimTime};
pub(crate) use walk::Walk;

/// What acts on the body besides the reaction of its string, at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Load {
    /// In body components.
    pub torque_b_n_m: Vector3<f64>,
    /// At the centre of mass, in world components, besides weight.
    pub force_w_n: Vector3<f64>,
    pub gravity_m_s2: f64,
}

/// A momentum given to the body at once.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Momentum {
    /// In body components.
    pub angular_b_n_m_s: Vector3<f64>,
    /// At the centre of mass, in world components.
    pub linear_w_n_s: Vector3<f64>,
}

/// The motion at a grid point as it is known when its load is asked for: velocities extrapolated
/// from the past, all of one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Synchronous {
    pub time_s: f64,
    pub q_wb: UnitQuaternion<f64>,
    pub omega_wb_b_rad_s: Vector3<f64>,
    pub com_velocity_w_m_s: Vector3<f64>,
    pub twist_rad: f64,
    pub twist_rate_rad_s: f64,
}

/// What acts on the body.
pub(crate) trait Loads: Clone {
    /// The load to hold from half a step before `now` to half a step after. In a step with an
    /// impulse, `now` has the velocities half-way between before and after it.
    ///
    /// Called once per step, in the order of time, so it may commit memory.
    fn load(&mut self, now: &Synchronous, step_s: f64) -> Load;

    /// The sum of the impulses in `from_s` to `to_s`, the end left out; called once per step,
    /// before [`Loads::load`]. The spans begin and end half-way between grid points, where the
    /// velocities live, and follow each other without a gap; the first begins at the start.
    fn impulse(&mut self, from_s: f64, to_s: f64) -> Option<Momentum>;
}

/// Velocities in world components.
#[derive(Debug, Clone, Copy)]
struct Velocities {
    omega_w_rad_s: Vector3<f64>,
    com_w_m_s: Vector3<f64>,
}

impl Velocities {
    fn of(state: &EngineState) -> Self {
        Self { omega_w_rad_s: state.omega_w_rad_s, com_w_m_s: state.com_velocity_w_m_s }
    }

    /// `a` and `b` in these parts.
    fn mixed(&self, a: f64, other: &Self, b: f64) -> Self {
        Self {
            omega_w_rad_s: self.omega_w_rad_s * a + other.omega_w_rad_s * b,
            com_w_m_s: self.com_w_m_s * a + other.com_w_m_s * b,
        }
    }

    /// After `times` a response.
    fn after(&self, times: f64, response: &Response) -> Self {
        Self {
            omega_w_rad_s: self.omega_w_rad_s + response.omega_w * times,
            com_w_m_s: self.com_w_m_s + response.com_w * times,
        }
    }
}

/// A grid point that has been passed.
#[derive(Debug, Clone, Copy)]
struct Node {
    /// Its velocities are those of half a step before.
    state: EngineState,
    twist_rad: f64,
    /// Integral of the rate from the start, body components.
    turned_b_rad: Vector3<f64>,
    /// The same of the Earth's rate.
    earth_b_rad: Vector3<f64>,
    /// Change of the velocities by a kick at this very point.
    kick: Response,
}

/// Rate of the body and what follows from it, at an attitude.
struct BodyRates {
    omega_wb_b_rad_s: Vector3<f64>,
    twist_rate_rad_s: f64,
}

impl BodyRates {
    fn new(q_wb: &UnitQuaternion<f64>, omega_w_rad_s: &Vector3<f64>) -> Self {
        let omega_wb_b_rad_s = q_wb.inverse_transform_vector(omega_w_rad_s);
        let twist_rate_rad_s = swing_twist::twist_rate_rad_s(q_wb, &omega_wb_b_rad_s);
        Self { omega_wb_b_rad_s, twist_rate_rad_s }
    }
}

/// The motion of a [`Rig`] on an infinite string, computed by the rapier physics engine.
///
/// Of second order in the step: 5e-4 rad after a minute of the reference motion at 1 ms, 2e-5 rad
/// at 0.2 ms. An instant between two grid points is interpolated, so the motion at an instant does
/// not depend on which other instants are asked for.
///
/// An impulse acts at the grid point nearest to it, of second order when it lies on it; the rate
/// reported at that very point is that after it.
#[derive(Debug, Clone)]
pub struct RapierMotion {
    walk: Walk<RigLoads>,
    support: Support,
    reached: SimTime,
}

impl RapierMotion {
    /// A motion of `rig` from `start` in steps of `step_s`, without commanded torque.
    ///
    /// # Errors
    /// [`BodyError::Unsupported`] for a string of finite length, [`BodyError::Parameter`] for an
    /// impossible rig or start and for a step outside 1 µs to 0.1 s.
    pub fn new(rig: &Rig, start: &StartState, step_s: f64) -> Result<Self, BodyError> {
        if rig.string_length_m.is_some() {
            let what = "a string of finite length";
            return Err(BodyError::Unsupported { backend: "rapier", what });
        }
        rig.check()?;
        start.check()?;
        let rigid = RigidBody {
            mass_kg: rig.body.params().mass_kg,
            com_b_m: -rig.body.suspension_b_m(),
            inertia_b_kg_m2: rig.body.inertia_b_kg_m2(),
            earth_rate_w_rad_s: rig.earth_rate_w_rad_s,
        };
        let walk = Walk::new(rigid, start, step_s, RigLoads::new(rig, start.twist_rad)?)?;
        Ok(Self { walk, support: rig.support.clone(), reached: SimTime::ZERO })
    }

    /// The motion at `time`, which must not lie before an instant already answered.
    ///
    /// # Errors
    /// [`BodyError::TimeReversal`] for an earlier instant; [`BodyError::Stopped`] with time, state
    /// and reason when the motion cannot be carried that far. A failed call leaves the last answer
    /// standing.
    pub fn motion_at(&mut self, time: SimTime) -> Result<BodyMotion, BodyError> {
        if time < self.reached {
            return Err(BodyError::TimeReversal { asked: time, reached: self.reached });
        }
        let mut motion = self.walk.motion_at(time)?;
        // The walk is in the frame of the support, whose acceleration it knows as weight.
        let support = self.support.at(time.as_s());
        motion.com_position_w_m.z += support.position_w_m.z;
        motion.com_velocity_w_m_s.z += support.velocity_w_m_s.z;
        motion.com_acceleration_w_m_s2.z += support.acceleration_w_m_s2.z;
        self.reached = time;
        Ok(motion)
    }

    /// Applies a torque in body components from the next step on, until changed.
    ///
    /// Steps reach from half-way before a grid point to half-way after, and one of them is ahead
    /// of the last answer: the torque begins to act at most one and a half steps after it.
    ///
    /// # Errors
    /// [`BodyError::Parameter`] for a torque that is not finite.
    pub fn set_torque(&mut self, torque_b_n_m: Vector3<f64>) -> Result<(), BodyError> {
        for torque in &torque_b_n_m {
            Bound::Finite.check("torque_b_n_m", *torque, "the body cannot follow it")?;
        }
        self.walk.loads_mut().torque_b_n_m = torque_b_n_m;
        Ok(())
    }

    /// Height of the suspension point above where the string holds it, m: what rapier's joint
    /// leaves, at the last grid point computed.
    #[must_use]
    pub fn suspension_height_m(&self) -> f64 {
        self.walk.newest().suspension_w_m.z
    }
}

#[cfg(test)]
mod tests;
