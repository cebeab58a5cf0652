//! Import of co-simulation FMUs, FMI 2.0 and 3.0 behind one trait.
//!
//! [`open`] reads an `.fmu` and gives an [`Importer`]; its [`instantiate`](Importer::instantiate)
//! gives an [`Instance`] to step. What the FMU itself has to say about a failure is part of the
//! error, once [`capture_fmu_messages`] has been called.
//!
//! **Architecture Invariant:** the `fmi` crate, and with it libclang, is met in this crate alone;
//! nothing outside can tell which backend loads the FMU. Instances stay on the thread that made
//! them.

mod archive;
mod description;
mod error;
mod fmi2;
mod fmi3;
mod messages;
mod status;

pub use description::{FmiVersion, FmuDescription, Kind, ValueReference, Variable};
pub use error::ImportError;
pub use messages::capture_fmu_messages;

use std::path::Path;

/// An FMU on disk, unpacked and described, ready to be instantiated any number of times.
pub trait Importer: std::fmt::Debug {
    /// What the model description says.
    fn description(&self) -> &FmuDescription;

    /// Makes a co-simulation instance called `name`, still to be initialised.
    ///
    /// # Errors
    /// [`ImportError::Load`] when the shared library cannot be loaded or lacks a function,
    /// [`ImportError::Refused`] when the FMU refuses to be instantiated.
    fn instantiate(&self, name: &str) -> Result<Box<dyn Instance>, ImportError>;
}

/// One running co-simulation FMU.
///
/// Values travel by [`ValueReference`]: look names up once, through
/// [`FmuDescription::variable`], not in every step.
pub trait Instance: std::fmt::Debug {
    /// Sets Float64 (FMI 2.0: Real) variables.
    ///
    /// # Errors
    /// [`ImportError::Call`] when the FMU refuses.
    fn set_f64(&mut self, references: &[ValueReference], values: &[f64])
    -> Result<(), ImportError>;

    /// Sets one Int32 (FMI 2.0: Integer) variable.
    ///
    /// # Errors
    /// [`ImportError::Call`] when the FMU refuses.
    fn set_i32(&mut self, reference: ValueReference, value: i32) -> Result<(), ImportError>;

    /// Sets one Boolean variable.
    ///
    /// # Errors
    /// [`ImportError::Call`] when the FMU refuses.
    fn set_bool(&mut self, reference: ValueReference, value: bool) -> Result<(), ImportError>;

    /// Reads Float64 (FMI 2.0: Real) variables.
    ///
    /// # Errors
    /// [`ImportError::Call`] when the FMU refuses.
    fn get_f64(
        &mut self,
        references: &[ValueReference],
        values: &mut [f64],
    ) -> Result<(), ImportError>;

    /// Reads one Int32 (FMI 2.0: Integer) variable.
    ///
    /// # Errors
    /// [`ImportError::Call`] when the FMU refuses.
    fn get_i32(&mut self, reference: ValueReference) -> Result<i32, ImportError>;

    /// Enters and leaves initialization mode at `start_s`; parameters must be set before.
    ///
    /// # Errors
    /// [`ImportError::Call`] when the FMU refuses, above all because of a parameter's value.
    fn initialise(&mut self, start_s: f64) -> Result<(), ImportError>;

    /// Carries the FMU from communication point `time_s` over `step_s`, s.
    ///
    /// # Errors
    /// [`ImportError::Call`] when the FMU refuses or stops early.
    fn do_step(&mut self, time_s: f64, step_s: f64) -> Result<(), ImportError>;

    /// Ends the simulation.
    ///
    /// # Errors
    /// [`ImportError::Call`] when the FMU refuses.
    fn terminate(&mut self) -> Result<(), ImportError>;
}

/// Opens an FMU of either version.
///
/// # Errors
/// [`ImportError`] when the file is missing, is no FMU, or holds no co-simulation model.
pub fn open(path: &Path) -> Result<Box<dyn Importer>, ImportError> {
    archive::inspect(path)?;
    let peeked = fmi::import::peek_descr_path(path).map_err(|e| error::not_an_fmu(path, &e))?;
    match peeked.fmi_version.split('.').next() {
        Some("2") => Ok(Box::new(fmi2::Fmi2::open(path)?)),
        Some("3") => Ok(Box::new(fmi3::Fmi3::open(path)?)),
        _ => Err(ImportError::Version { path: path.to_owned(), version: peeked.fmi_version }),
    }
}
