//! The true motion of the body, at any instant.

use crate::ode::{Dop853, Rk4, Tolerance};
use crate::{Body, BodyEquations, BodyError, STATES, StartState};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use struna_kernel::{BodyMotion, Bound, SimTime};

/// How the motion is computed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Integrator {
    /// Fixed steps, for live runs and held torques. 1 ms holds 1e-7 rad over 480 s of the
    /// reference motions.
    Rk4 {
        /** Step, s. */
        step_s: f64,
    },
    /// Adaptive steps with dense output, the truth of record. 1e-12 holds 1e-9 rad over 480 s.
    Dop853 {
        /** Relative tolerance. */
        rtol: f64,
        /** Absolute tolerance, rad and rad/s. */
        atol: f64,
    },
}

#[derive(Debug, Clone)]
enum Engine {
    Rk4(Rk4<STATES>),
    // Boxed: sixteen stages and the dense output are fifty times the size of an RK4 walk.
    Dop853(Box<Dop853<STATES>>),
}

impl Engine {
    fn start(integrator: Integrator, states: [f64; STATES]) -> Result<Self, BodyError> {
        Ok(match integrator {
            Integrator::Rk4 { step_s } => Self::Rk4(Rk4::new(step_s, states)?),
            Integrator::Dop853 { rtol, atol } => {
                Self::Dop853(Box::new(Dop853::new(Tolerance { rtol, atol }, states)?))
            }
        })
    }
}

/// The motion of a body from its start at [`SimTime::ZERO`] on.
///
/// The motion at an instant does not depend on which other instants are asked for: with
/// [`Integrator::Rk4`] instants off the step grid are reached by one shortened step that leaves
/// the grid alone, with [`Integrator::Dop853`] they come from the dense output.
#[derive(Debug, Clone)]
pub struct TruthMotion {
    body: Body,
    integrator: Integrator,
    equations: BodyEquations,
    engine: Engine,
    torque_b_n_m: Vector3<f64>,
    /// Where the engine's time zero lies: the start, or the last change of torque.
    origin: SimTime,
    reached: SimTime,
    /// States at `reached`.
    states: [f64; STATES],
}

impl TruthMotion {
    /// A motion of `body` from `start`, without external torque.
    ///
    /// # Errors
    /// [`BodyError::Parameter`] for an impossible start, [`BodyError::Integration`] for an
    /// unusable step or tolerance.
    pub fn new(body: Body, start: &StartState, integrator: Integrator) -> Result<Self, BodyError> {
        let states = start.to_states()?;
        Ok(Self {
            equations: BodyEquations::new(&body, Vector3::zeros()),
            engine: Engine::start(integrator, states)?,
            body,
            integrator,
            torque_b_n_m: Vector3::zeros(),
            origin: SimTime::ZERO,
            reached: SimTime::ZERO,
            states,
        })
    }

    /// The body that moves.
    #[must_use]
    pub fn body(&self) -> &Body {
        &self.body
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
        let elapsed_s = time.seconds_since(self.origin);
        self.states = match &mut self.engine {
            Engine::Rk4(walk) => walk.state_at(&self.equations, elapsed_s)?,
            Engine::Dop853(run) => run.state_at(&self.equations, elapsed_s)?,
        };
        self.reached = time;
        Ok(motion(time, &self.states))
    }

    /// Applies a torque in body components from the last answered instant on, until changed.
    ///
    /// The integration restarts at that instant, so that no step spans the jump; with
    /// [`Integrator::Rk4`] the step grid then counts from there. Setting the torque that already
    /// acts changes nothing.
    ///
    /// # Errors
    /// [`BodyError::Parameter`] for a torque that is not finite.
    pub fn set_torque(&mut self, torque_b_n_m: Vector3<f64>) -> Result<(), BodyError> {
        for torque in &torque_b_n_m {
            Bound::Finite.check("torque_b_n_m", *torque, "the body cannot follow it")?;
        }
        if torque_b_n_m == self.torque_b_n_m {
            return Ok(());
        }
        self.engine = Engine::start(self.integrator, self.states)?;
        self.equations = BodyEquations::new(&self.body, torque_b_n_m);
        self.torque_b_n_m = torque_b_n_m;
        self.origin = self.reached;
        Ok(())
    }
}

fn motion(time: SimTime, states: &[f64; STATES]) -> BodyMotion {
    let [qw, qx, qy, qz, w1, w2, w3, twist_rad, spin_rad] = *states;
    // The dense output leaves unit length by its own error, so normalise here as well.
    let q_wb = UnitQuaternion::from_quaternion(Quaternion::new(qw, qx, qy, qz));
    let omega = [w1, w2, w3];
    BodyMotion {
        time,
        q_wb,
        omega_wb_b_rad_s: omega.into(),
        twist_rad,
        twist_rate_rad_s: Body::twist_rate_of([q_wb.w, q_wb.i, q_wb.j, q_wb.k], omega),
        spin_rad,
    }
}
