//! Integrators for small systems of ordinary differential equations, y′ = f(t, y).
//!
//! [`Rk4`] walks a fixed grid and is what a live run uses; [`Dop853`] chooses its own steps,
//! interpolates between them and is the truth of record; [`Dop853Sampler`] takes the same method's
//! steps at a fixed length and is the cheapest smooth truth on a grid. All work on `[f64; N]`
//! without allocating, and all know the equations as an [`Rhs`] type rather than a closure, so that
//! the compiler inlines the derivative into the step.

mod dop853;
mod dop853_fixed;
mod dop853_tableau;
mod rk4;

pub use dop853::{Dop853, Tolerance, dop853_step};
pub use dop853_fixed::Dop853Sampler;
pub use rk4::{Rk4, rk4_step};

/// Most steps that one call may take; a call that would need more is refused.
///
/// Ten million steps are 2.8 hours of motion at 1 ms: far beyond any sample spacing, and short
/// enough that a wrong step size ends in an error instead of an endless run.
pub const STEPS_MAX: u64 = 10_000_000;

/// The right-hand side of y′ = f(t, y), with what the integrator must know about its states.
pub trait Rhs<const N: usize> {
    /// The derivative of `y` at `time_s`. Write it `#[inline(always)]`: it is the hot path.
    fn derivative(&self, time_s: f64, y: &[f64; N]) -> [f64; N];

    /// Pulls a state back onto its manifold after each completed step, for example a quaternion
    /// to unit length. Must change it by no more than the step's own error.
    fn project(&self, _y: &mut [f64; N]) {}

    /// Which of several smooth pieces of the derivative holds at `y`, by any numbering: an adaptive
    /// step ends where it changes. A change and its return within one step go unseen.
    fn regime(&self, _time_s: f64, _y: &[f64; N]) -> u32 {
        0
    }

    /// Whether the equations hold at `y`; a run that leaves their domain ends with an error. A
    /// derivative of NaN ends it as well.
    fn admissible(&self, _time_s: f64, _y: &[f64; N]) -> bool {
        true
    }
}

/// Why an integration stopped. The integrator stays where the failing call found it.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OdeError<const N: usize> {
    /// A step, a tolerance or an instant is unusable.
    #[error("{name} = {value} is refused: it must lie in {min:e} to {max:e}")]
    Setting {
        /** Which setting. */
        name: &'static str,
        /** The rejected value. */
        value: f64,
        /** Smallest usable value. */
        min: f64,
        /** Largest usable value. */
        max: f64,
    },
    /// The state grew without bound or became NaN.
    #[error("the motion diverged in the step from {time_s} s, state {state:?}")]
    Diverged {
        /** Start of the failing step, s. */
        time_s: f64,
        /** Its length, s. */
        step_s: f64,
        /** The last good state, at its start. */
        state: [f64; N],
    },
    /// The state left the domain on which the equations hold.
    #[error("the motion left the domain of its equations in the step from {time_s} s")]
    OutsideDomain {
        /** Start of the failing step, s. */
        time_s: f64,
        /** Its length, s. */
        step_s: f64,
        /** The last good state, at its start. */
        state: [f64; N],
    },
    /// No step is small enough to meet the tolerance.
    #[error("the step needed at {time_s} s is {step_s:e} s, below rounding; state {state:?}")]
    StepTooSmall {
        /** Where the integration stands, s. */
        time_s: f64,
        /** The step that was still too long, s. */
        step_s: f64,
        /** The last good state. */
        state: [f64; N],
    },
    /// One call needs more than [`STEPS_MAX`] steps.
    #[error("more than {STEPS_MAX} steps are needed in one call at {time_s} s, state {state:?}")]
    TooManySteps {
        /** Where the integration stands, s. */
        time_s: f64,
        /** The last good state. */
        state: [f64; N],
    },
}

/// `value` if it lies in the range, else [`OdeError::Setting`]; NaN lies in no range.
#[inline(always)]
fn within<const N: usize>(
    name: &'static str,
    value: f64,
    (min, max): (f64, f64),
) -> Result<f64, OdeError<N>> {
    if (min..=max).contains(&value) {
        return Ok(value);
    }
    Err(OdeError::Setting { name, value, min, max })
}

/// Whether no component is NaN or infinite; without branches, because it guards every step.
#[inline(always)]
fn all_finite<const N: usize>(y: &[f64; N]) -> bool {
    // A finite number times zero is zero, anything else is NaN.
    y.iter().map(|v| v * 0.0).sum::<f64>() == 0.0
}

/// Judges the state that a step of `step_s` from (`time_s`, `from`) produced.
#[inline(always)]
fn check_step<const N: usize, R: Rhs<N>>(
    rhs: &R,
    (time_s, from): (f64, &[f64; N]),
    (step_s, end): (f64, &[f64; N]),
) -> Result<(), OdeError<N>> {
    if !all_finite(end) {
        return Err(OdeError::Diverged { time_s, step_s, state: *from });
    }
    if !rhs.admissible(time_s + step_s, end) {
        return Err(OdeError::OutsideDomain { time_s, step_s, state: *from });
    }
    Ok(())
}
