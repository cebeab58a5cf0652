//! The status codes that FMI 2.0 and 3.0 share, and the reasons for a bad one.

use crate::instance::Phase;
use crate::model::ModelError;
use crate::variable::{Kind, ValueReference};
use std::ffi::c_uint;

/// A status code; the same numbers in both versions of the standard.
pub(crate) type Status = c_uint;
/// The call did what was asked.
pub(crate) const OK: Status = 0;
/// The call was refused and changed nothing.
pub(crate) const ERROR: Status = 3;
/// The instance is lost; others are not affected.
pub(crate) const FATAL: Status = 4;

/// A call from C is refused. The instance is left as it was before the call.
///
/// Boxed, so that a result fits a register: reasons are large and rare, and a step is short.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub(crate) struct Refusal(Box<Reason>);

impl<R: Into<Reason>> From<R> for Refusal {
    #[cold]
    fn from(reason: R) -> Self {
        Self(Box::new(reason.into()))
    }
}

/// Why a call is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(crate) enum Reason {
    #[error("not allowed {phase}: {rule}")]
    WrongPhase { phase: Phase, rule: &'static str },
    #[error("{argument} is a null pointer")]
    NullPointer { argument: &'static str },
    #[error("{values} values for {references} value references: all variables are scalars")]
    CountMismatch { references: usize, values: usize },
    #[error("no variable has the value reference {reference}")]
    UnknownVariable { reference: ValueReference },
    #[error("{variable} is of type {is}, not {asked}")]
    WrongType { variable: &'static str, is: Kind, asked: Kind },
    #[error("{variable} = {value} is refused: an {causality} is not set from outside")]
    NotSettable { variable: &'static str, value: String, causality: &'static str },
    #[error("{variable} = {value} is refused: it is {variability} and the model is {phase}")]
    NoLongerSettable {
        variable: &'static str,
        value: String,
        variability: &'static str,
        phase: Phase,
    },
    #[error("{variable} = {value} is refused: it is not finite")]
    NotFinite { variable: &'static str, value: f64 },
    #[error("{variable} = {value} is refused: it must be {bounds}")]
    OutOfBounds { variable: &'static str, value: String, bounds: String },
    #[error("{quantity} {value} is refused: it must be {bound}")]
    BadNumber { quantity: &'static str, value: f64, bound: &'static str },
    #[error("the communication point is {expected} s, not {given} s")]
    WrongCommunicationPoint { given: f64, expected: f64 },
    #[error("a step from {from} s to {to} s would pass the stop time {stop} s")]
    PastStopTime { from: f64, to: f64, stop: f64 },
    #[error("{asked} is not supported: this is a plain co-simulation FMU")]
    UnsupportedRequest { asked: &'static str },
    #[error("not supported: {reason}")]
    Unsupported { reason: &'static str },
    #[error("no log category is called {name:?}")]
    UnknownLogCategory { name: String },
    #[error("the instance name is missing or blank")]
    NoInstanceName,
    #[error("the instantiation token {given:?} is of no model here (expected one of: {known})")]
    UnknownToken { given: String, known: String },
    #[error("this FMU state was not saved by this instance, or has been freed")]
    UnknownState,
    #[error("{given} bytes do not hold the serialized state of {needed} bytes")]
    BufferTooSmall { given: usize, needed: usize },
    #[error("the serialized state is refused: {0}")]
    BadState(#[from] BadState),
    #[error("all {capacity} places for instances are taken")]
    NoVacancy { capacity: usize },
    #[error(transparent)]
    Model(#[from] ModelError),
}

/// Why bytes are not a state of this model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub(crate) enum BadState {
    #[error("it does not begin with the mark of a Struna state, version 1")]
    Mark,
    #[error("it was saved by another model or another version of this one")]
    OtherModel,
    #[error("it is {given} bytes long and says that it has {declared}")]
    Length { given: usize, declared: u64 },
    #[error("its checksum does not match its content")]
    Checksum,
    #[error("its content does not fit the variable table")]
    Content,
}
