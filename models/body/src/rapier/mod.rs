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
mod mechanics;
mod span;
mod string;
mod swing_twist;
#[cfg(test)]
mod tests;
mod walk;

use crate::{Body, BodyError, StartState};
use engine::EngineState;
pub(crate) use engine::RigidBody;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use string::IdealString;
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
pub(crate) struct Impulse {
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

    /// The sum of the impulses in `from_s` to `to_s`, the end left out; called once per step, before
    /// [`Loads::load`]. The
    /// spans begin and end half-way between grid points, where the velocities live, and follow
    /// each other without a gap; the first begins at the start.
    fn impulse(&mut self, from_s: f64, to_s: f64) -> Option<Impulse>;
}

/// A grid point that has been passed.
#[derive(Debug, Clone, Copy)]
struct Node {
    /// Its velocities are those of half a step before.
    state: EngineState,
    twist_rad: f64,
    spin_rad: f64,
    /// Change of the rate by a kick at this very point, in world components.
    kick_w_rad_s: Vector3<f64>,
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

/// The motion of a [`Body`] on an ideal string, computed by the rapier physics engine.
///
/// Of second order in the step: 5e-4 rad after a minute of the reference motion at 1 ms, 2e-5 rad
/// at 0.2 ms. An instant between two grid points is interpolated, so the motion at an instant does
/// not depend on which other instants are asked for.
#[derive(Debug, Clone)]
pub struct RapierMotion {
    walk: Walk<IdealString>,
    reached: SimTime,
}

impl RapierMotion {
    /// A motion of `body` from `start` in steps of `step_s`, without external torque.
    ///
    /// # Errors
    /// [`BodyError::Parameter`] for an impossible start, [`BodyError::Integration`] for a step
    /// outside 1 µs to 0.1 s.
    pub fn new(body: &Body, start: &StartState, step_s: f64) -> Result<Self, BodyError> {
        let params = body.params();
        let rigid = RigidBody {
            mass_kg: params.mass_kg,
            com_b_m: Vector3::new(0.0, 0.0, -params.com_depth_m),
            inertia_b_kg_m2: Matrix3::from_diagonal(&Vector3::from(params.inertia_kg_m2)),
        };
        let walk = Walk::new(rigid, start, step_s, IdealString::new(body))?;
        Ok(Self { walk, reached: SimTime::ZERO })
    }

    /// The motion at `time`, which must not lie before an instant already answered.
    ///
    /// # Errors
    /// [`BodyError::TimeReversal`] for an earlier instant; [`BodyError::Integration`] when the
    /// motion diverges, turns upside down or needs too many steps, with time and states. A failed
    /// call leaves the last answer standing.
    pub fn motion_at(&mut self, time: SimTime) -> Result<BodyMotion, BodyError> {
        if time < self.reached {
            return Err(BodyError::TimeReversal { asked: time, reached: self.reached });
        }
        let motion = self.walk.motion_at(time)?;
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

    /// Gives the body an angular momentum (body components) and a momentum (world components) at
    /// `time`, or in the next step where that step is already taken.
    ///
    /// Of second order for an instant on the step grid, else of first: the kick then acts at the
    /// grid point nearest to it. The rate reported at that very point is that after the kick.
    ///
    /// # Errors
    /// [`BodyError::TimeReversal`] for an instant before the last answer, [`BodyError::Parameter`]
    /// for an impulse that is not finite.
    pub fn kick_at(
        &mut self,
        time: SimTime,
        angular_b_n_m_s: Vector3<f64>,
        linear_w_n_s: Vector3<f64>,
    ) -> Result<(), BodyError> {
        if time < self.reached {
            return Err(BodyError::TimeReversal { asked: time, reached: self.reached });
        }
        for momentum in &angular_b_n_m_s {
            Bound::Finite.check("angular_b_n_m_s", *momentum, "the body cannot follow it")?;
        }
        for momentum in &linear_w_n_s {
            Bound::Finite.check("linear_w_n_s", *momentum, "the body cannot follow it")?;
        }
        let impulse = Impulse { angular_b_n_m_s, linear_w_n_s };
        self.walk.loads_mut().schedule(time.as_s(), impulse);
        Ok(())
    }

    /// Height of the suspension point above where the string holds it, m: what rapier's joint
    /// leaves, at the last grid point computed.
    #[must_use]
    pub fn suspension_height_m(&self) -> f64 {
        self.walk.newest().suspension_w_m.z
    }

    /// Velocity of the centre of mass half a step before the last grid point computed, in world
    /// components, m/s.
    #[must_use]
    pub fn com_velocity_w_m_s(&self) -> Vector3<f64> {
        self.walk.newest().com_velocity_w_m_s
    }
}
