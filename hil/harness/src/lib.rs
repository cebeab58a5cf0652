//! The bench: drives the chain from motion to estimate and lets observers watch.
//!
//! Left of the line stands the [`Emulator`]: a [`MotionSource`], a gyro, an encoder. Right of it
//! stands the [`Pipeline`]: a decoder, the [`Averager`] and the [`DeviceUnderTest`]s, fed with
//! bytes and with nothing else. [`run`] joins the two through a pseudo-terminal; a real gyro would
//! replace everything on the left and the pipeline could not tell.
//!
//! **Architecture Invariant:** estimators are met only through [`DeviceUnderTest`]; nothing here
//! can name one.
//!
//! For a line that is really there, [`live`] takes the place of the run and of the emulator, and
//! [`clock`] finds from arrival times how fast the gyro's own clock runs.
//!
//! **Architecture Invariant:** truth reaches observers beside the line, never devices. Time is the
//! gyro's sample counter; in a run no arrival time enters a result, and of a live line they enter
//! through [`clock::TimeBase`] alone, as numbers that a replay gives again.

mod averager;
mod axes;
pub mod clock;
mod device;
mod emulator;
pub mod fault;
mod fmu_device;
pub mod live;
pub mod monitor;
mod pipeline;
mod run;
mod source;
mod transmitter;

pub use averager::{Averager, AveragerError, Measured};
pub use axes::cross_rate_fields;
pub use device::{DeviceError, DeviceFault, DeviceUnderTest};
pub use emulator::{Emulator, EmulatorError, EmulatorReport, Pacing};
pub use fmu_device::{FmuDevice, Parameter, ParameterValue};
pub use pipeline::{GyroChannel, Pipeline, PipelineError, PipelineReport};
pub use run::{Observer, RunError, RunReport, run};
pub use source::{BodySource, CrossAxes, MotionSource, Recording, Reference, SourceError};
pub use transmitter::{LineEvent, LinePath, Transmitter};
