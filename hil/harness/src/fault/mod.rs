//! Faults on purpose: a catalogue, a seeded plan, an injector, and the truth about what it did.
//!
//! A [`FaultPlan`] says what goes wrong and when; an [`Injector`] stands between gyro and line and
//! makes it go wrong in three stages: the gyro's sample ([`struna_gyro::Upset`]), its frame, and
//! bytes and time. Whatever it does leaves a [`FaultRecord`], so that a detector can be judged by
//! what really happened.
//!
//! The injector knows samples, not chunks: how its output is cut into reads changes nothing.

mod baud;
mod injector;
mod kind;
mod packet;
mod plan;
mod record;
mod schedule;

pub use injector::{Dispatch, Injector};
pub use kind::{FaultKind, Stage};
pub use plan::{FAULTS_MAX, Fault, FaultPlan, FaultPlanError, Trigger};
pub use record::{FaultRecord, write_fault_csv};
