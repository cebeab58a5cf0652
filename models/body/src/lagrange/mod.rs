//! The Lagrange equations of the rig, in Newton-Euler form, and the engine that integrates them.
//!
//! Two forms of one mechanics: [`BodyEquations`] for the plain rig, fast, and [`FullEquations`]
//! for every other. `docs/truth-model.md` derives both.

mod full;
mod plain;

pub use full::{FULL_STATES, FullEquations};
pub use plain::{BodyEquations, STATES, TILT_MAX_RAD};

use crate::batch::{Work, done_fast};
use crate::disturbance::Timeline;
use crate::error::{Posture, Stop, StopReason};
use crate::ode::{Dop853, OdeError, Rhs, Rk4, Tolerance, dop853_step, rk4_step};
use crate::{BodyError, Impulse, Integrator};
use nalgebra::Vector3;
use struna_kernel::{BodyMotion, Bound, SimTime};

/// Share of a limit within which a motion that stopped is taken to have stopped at it.
const AT_LIMIT: f64 = 1e-3;

/// Searches for the limit within a failing step. The second starts within the error of a stage,
/// some nanoseconds, of the limit, and its own stages then err by nothing.
const LIMIT_SEARCHES: u32 = 2;

/// A form of the equations: right-hand side, and the meaning of its states.
pub(crate) trait Form<const N: usize>: Rhs<N> {
    /// What an error says of the states at the integrator's `time_s`.
    fn posture(&self, time_s: f64, y: &[f64; N]) -> Posture;

    /// Pull of the string, N; negative where it would have to push.
    fn tension_n(&self, time_s: f64, y: &[f64; N]) -> f64;

    /// Weight of the body, N.
    fn weight_n(&self) -> f64;

    /// Longest step that still sees everything that happens to the body, s.
    fn step_max_s(&self) -> f64 {
        f64::INFINITY
    }

    /// How far the string leans, as a share of what the equations allow.
    fn string_lean(&self, _y: &[f64; N]) -> f64 {
        0.0
    }

    /// The motion at these states; `time_s` is the integrator's time.
    fn motion(&self, time: SimTime, time_s: f64, y: &[f64; N]) -> BodyMotion;

    /// Holds a body torque from `origin_s` of the run on, where the integrator's time is zero.
    fn hold(&mut self, origin_s: f64, torque_b_n_m: Vector3<f64>);

    /// Strikes the body.
    fn kick(&self, time_s: f64, y: &mut [f64; N], impulse: &Impulse);
}

#[derive(Debug, Clone)]
enum Stepper<const N: usize> {
    Rk4(Rk4<N>),
    // Boxed: sixteen stages and the dense output are fifty times the size of an RK4 walk.
    Dop853(Box<Dop853<N>>),
}

impl<const N: usize> Stepper<N> {
    fn start(
        integrator: Integrator,
        states: [f64; N],
        step_max_s: f64,
    ) -> Result<Self, OdeError<N>> {
        Ok(match integrator {
            Integrator::Rk4 { step_s } => Self::Rk4(Rk4::new(step_s, states)?),
            Integrator::Dop853 { rtol, atol } => {
                let run = Dop853::new(Tolerance { rtol, atol }, states)?;
                Self::Dop853(Box::new(run.with_step_max(step_max_s)))
            }
        })
    }

    /// The states at `time_s` into `states`, which an error leaves alone.
    #[inline(always)]
    fn carry<R: Rhs<N>>(
        &mut self,
        rhs: &R,
        time_s: f64,
        states: &mut [f64; N],
    ) -> Result<(), OdeError<N>> {
        match self {
            Self::Rk4(walk) => walk.carry_on(rhs, time_s, states),
            Self::Dop853(run) => {
                *states = run.state_at(rhs, time_s)?;
                Ok(())
            }
        }
    }

    /// One bare step of the method in use.
    fn bare_step<R: Rhs<N>>(&self, rhs: &R, from: (f64, &[f64; N]), step_s: f64) -> [f64; N] {
        let mut end = match self {
            Self::Rk4(_) => rk4_step(rhs, from.0, from.1, step_s),
            Self::Dop853(_) => dop853_step(rhs, from.0, from.1, step_s),
        };
        rhs.project(&mut end);
        end
    }
}

/// A form being integrated between changes of torque.
#[derive(Debug, Clone)]
pub(crate) struct Lagrange<const N: usize, F> {
    form: F,
    integrator: Integrator,
    stepper: Stepper<N>,
    /// Where the stepper's time zero lies: the start, or the last change.
    origin: SimTime,
    /// The last instant reached, and the states then.
    reached: SimTime,
    states: [f64; N],
    timeline: Timeline,
    /// Torque commanded from outside, body components, N·m.
    torque_b_n_m: Vector3<f64>,
}

impl<const N: usize, F: Form<N>> Lagrange<N, F> {
    pub(crate) fn new(
        mut form: F,
        states: [f64; N],
        integrator: Integrator,
        mut timeline: Timeline,
    ) -> Result<Self, BodyError> {
        form.hold(0.0, timeline.held_b_n_m());
        let stepper = Stepper::start(integrator, states, form.step_max_s());
        let stepper = stepper.map_err(|e| unusable(&e))?;
        let (origin, reached) = (SimTime::ZERO, SimTime::ZERO);
        let torque_b_n_m = Vector3::zeros();
        Ok(Self { form, integrator, stepper, origin, reached, states, timeline, torque_b_n_m })
    }

    /// Carries the motion to `time`. What acts at this very instant does not show yet.
    pub(crate) fn carry_to(&mut self, time: SimTime) -> Result<(), BodyError> {
        done_fast(Carry { lagrange: self, time })
    }

    /// One function with the steps, so that the states stay in registers from one cell of the
    /// noise to the next.
    #[inline(always)]
    fn carry_on(&mut self, time: SimTime) -> Result<(), BodyError> {
        while let Some(change) = self.timeline.next_change().filter(|change| *change < time) {
            self.advance(change)?;
            let impulses = self.timeline.pass(change);
            self.restart(&impulses)?;
        }
        self.advance(time)
    }

    /// The motion at the instant reached.
    #[inline]
    pub(crate) fn motion(&self) -> BodyMotion {
        let elapsed_s = self.reached.seconds_since(self.origin);
        self.form.motion(self.reached, elapsed_s, &self.states)
    }

    /// Commands another torque from the instant reached on.
    pub(crate) fn set_torque(&mut self, torque_b_n_m: Vector3<f64>) -> Result<(), BodyError> {
        self.torque_b_n_m = torque_b_n_m;
        self.restart(&[])
    }

    /// Carries the states to `time`, between changes of torque.
    #[inline(always)]
    fn advance(&mut self, time: SimTime) -> Result<(), BodyError> {
        // The states at an instant do not depend on how often it was asked for; and a sample at
        // the very border of two cells asks for it twice, at the price of a shortened step each.
        if time == self.reached {
            return Ok(());
        }
        let elapsed_s = time.seconds_since(self.origin);
        if let Err(error) = self.stepper.carry(&self.form, elapsed_s, &mut self.states) {
            self.states = self.despite(&error, elapsed_s)?;
        }
        self.reached = time;
        Ok(())
    }

    /// The states at an instant that a failing step reaches nevertheless, or what stopped it.
    #[cold]
    fn despite(&self, error: &OdeError<N>, elapsed_s: f64) -> Result<[f64; N], BodyError> {
        self.short_of_limit(error, elapsed_s).ok_or_else(|| self.explained(error))
    }

    /// Strikes the body and holds the torque of the timeline's cell from the instant reached on.
    /// The integration restarts there, so that no step spans the jump.
    #[inline(always)]
    fn restart(&mut self, impulses: &[Impulse]) -> Result<(), BodyError> {
        if !impulses.is_empty() {
            let elapsed_s = self.reached.seconds_since(self.origin);
            for impulse in impulses {
                self.form.kick(elapsed_s, &mut self.states, impulse);
            }
        }
        // The dense output leaves the manifold by its own error; a restart is a completed step.
        self.form.project(&mut self.states);
        self.origin = self.reached;
        let torque_b_n_m = self.torque_b_n_m + self.timeline.held_b_n_m();
        self.form.hold(self.origin.as_s(), torque_b_n_m);
        if let Stepper::Rk4(walk) = &mut self.stepper {
            walk.restart(&self.states);
            return Ok(());
        }
        let stepper = Stepper::start(self.integrator, self.states, self.form.step_max_s());
        self.stepper = stepper.map_err(|e| unusable(&e))?;
        Ok(())
    }

    /// The error of the integrator, in the words of the rig: what stopped the motion, and when.
    fn explained(&self, error: &OdeError<N>) -> BodyError {
        let (reason, time_s, state) = match *error {
            OdeError::Setting { .. } => return unusable(error),
            OdeError::TooManySteps { time_s, state } => (StopReason::TooManySteps, time_s, state),
            OdeError::StepTooSmall { time_s, state, .. } => {
                let reason = self.limit_at(time_s, &state);
                (reason.unwrap_or(StopReason::StepTooSmall), time_s, state)
            }
            OdeError::Diverged { time_s, step_s, state }
            | OdeError::OutsideDomain { time_s, step_s, state } => {
                let (time_s, state) = self.last_good(time_s, &state, step_s);
                let reason = self.limit_at(time_s, &state);
                (reason.unwrap_or(StopReason::Diverged), time_s, state)
            }
        };
        let posture = self.form.posture(time_s, &state);
        Stop { reason, time_s: self.origin.as_s() + time_s, posture }.into()
    }

    /// The states at an instant within a failing step but before what made it fail: adaptive steps
    /// run ahead of the instants asked for, and must not take them along when they fail.
    fn short_of_limit(&self, error: &OdeError<N>, elapsed_s: f64) -> Option<[f64; N]> {
        let OdeError::OutsideDomain { time_s, step_s, state } = *error else { return None };
        let (good_s, _) = self.last_good(time_s, &state, step_s);
        (time_s <= elapsed_s && elapsed_s <= good_s)
            .then(|| self.stepper.bare_step(&self.form, (time_s, &state), elapsed_s - time_s))
    }

    /// The last instant within a failing step that shorter steps still reach, and the states there.
    ///
    /// The stages of a step are less accurate than its end, and a step fails with its first stage
    /// that does. So the search goes on from where it ends, by ever shorter steps, until the
    /// stages no longer matter.
    fn last_good(&self, time_s: f64, state: &[f64; N], step_s: f64) -> (f64, [f64; N]) {
        let (mut good_s, mut reached) = (0.0, *state);
        for _ in 0..LIMIT_SEARCHES {
            let from = (time_s + good_s, &reached);
            let (step_s, end) = self.longest_good_step(from, step_s - good_s);
            (good_s, reached) = (good_s + step_s, end);
        }
        (time_s + good_s, reached)
    }

    /// The longest part of a failing step that holds, by bisection to the last bit.
    fn longest_good_step(&self, from: (f64, &[f64; N]), step_s: f64) -> (f64, [f64; N]) {
        let (mut good_s, mut bad_s, mut reached) = (0.0, step_s, *from.1);
        for _ in 0..50 {
            let middle_s = 0.5 * (good_s + bad_s);
            let end = self.stepper.bare_step(&self.form, from, middle_s);
            let time_s = from.0 + middle_s;
            let holds = end.iter().all(|v| v.is_finite())
                && self.form.admissible(time_s, &end)
                && self.form.tension_n(time_s, &end) >= 0.0;
            if holds {
                (good_s, reached) = (middle_s, end);
            } else {
                bad_s = middle_s;
            }
        }
        (good_s, reached)
    }

    /// The limit of the equations at which these states stand, if any.
    fn limit_at(&self, time_s: f64, state: &[f64; N]) -> Option<StopReason> {
        let posture = self.form.posture(time_s, state);
        if self.form.tension_n(time_s, state).abs() < AT_LIMIT * self.form.weight_n() {
            return Some(StopReason::Slack);
        }
        if posture.tilt_rad() > TILT_MAX_RAD * (1.0 - AT_LIMIT) {
            return Some(StopReason::Overturned);
        }
        if self.form.string_lean(state) > 1.0 - AT_LIMIT {
            return Some(StopReason::StringTooTilted);
        }
        None
    }
}

/// A call of [`Lagrange::carry_to`].
struct Carry<'a, const N: usize, F> {
    lagrange: &'a mut Lagrange<N, F>,
    time: SimTime,
}

impl<const N: usize, F: Form<N>> Work for Carry<'_, N, F> {
    type Outcome = Result<(), BodyError>;

    #[inline(always)]
    fn done(self) -> Self::Outcome {
        self.lagrange.carry_on(self.time)
    }
}

/// The refusal of a step or tolerance; nothing else of an integrator is reached without one.
fn unusable<const N: usize>(error: &OdeError<N>) -> BodyError {
    let OdeError::Setting { name, value, min, max } = *error else {
        unreachable!("a stepper is only refused for its settings")
    };
    let bound = if value < min { Bound::AtLeast(min) } else { Bound::AtMost(max) };
    let reason = "the integration cannot work with it";
    match bound.check(name, value, reason) {
        Err(refused) => refused.into(),
        Ok(_) => unreachable!("a value in its range is not refused"),
    }
}
