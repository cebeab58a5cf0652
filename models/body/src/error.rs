//! Why a body, a start or a run is refused.

use crate::STATES;
use crate::ode::OdeError;
use struna_kernel::{ParameterError, SimTime};

/// Why a body, a start or a run is refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BodyError {
    /// A value that no body, string or start can have.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
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
