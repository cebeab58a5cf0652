//! Why a body, a start or a run is refused.

use crate::STATES;
use crate::ode::OdeError;
use std::fmt;
use struna_kernel::SimTime;

/// The limit that a refused value broke.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Bound {
    /// Any number, but neither infinite nor NaN.
    Finite,
    /// Strictly above.
    Above(f64),
    /// At least.
    AtLeast(f64),
    /// At most.
    AtMost(f64),
}

impl Bound {
    /// Whether `value` is finite and keeps the limit.
    fn holds(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Finite => true,
                Self::Above(limit) => value > limit,
                Self::AtLeast(limit) => value >= limit,
                Self::AtMost(limit) => value <= limit,
            }
    }

    /// `Ok` when `value` keeps the limit.
    ///
    /// # Errors
    /// [`BodyError::Parameter`] otherwise, with the reason given.
    pub(crate) fn check(
        self,
        name: &'static str,
        value: f64,
        reason: &'static str,
    ) -> Result<f64, BodyError> {
        if self.holds(value) {
            return Ok(value);
        }
        Err(BodyError::Parameter { name, value, bound: self, reason })
    }
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Finite => write!(f, "finite"),
            Self::Above(limit) => write!(f, "finite and above {limit}"),
            Self::AtLeast(limit) => write!(f, "finite and at least {limit}"),
            Self::AtMost(limit) => write!(f, "finite and at most {limit}"),
        }
    }
}

/// Why a body, a start or a run is refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BodyError {
    /// A value that no body, string or start can have.
    #[error("{name} = {value} is refused: it must be {bound}, because {reason}")]
    Parameter {
        /** Which value, with its unit. */
        name: &'static str,
        /** What it was. */
        value: f64,
        /** What it must be. */
        bound: Bound,
        /** Why. */
        reason: &'static str,
    },
    /// Asked for an instant before one already answered, or before the start.
    #[error("the motion at {asked} was asked for after the motion at {reached}")]
    TimeReversal {
        /** The instant asked for. */
        asked: SimTime,
        /** The latest instant answered. */
        reached: SimTime,
    },
    /// The integrator stopped. Its states are in the order of [`crate::BodyEquations`], its times
    /// count from the start of the run or the last change of torque.
    #[error(transparent)]
    Integration(#[from] OdeError<STATES>),
}
