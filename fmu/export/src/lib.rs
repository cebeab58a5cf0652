//! FMI 2.0 and 3.0 co-simulation export: from a Rust model to a shared library with the C
//! interfaces of both standards, and to the model descriptions that go with it.
//!
//! A model implements [`Model`] and lists its variables once, in a table of [`Variable`]s. The
//! table feeds both model descriptions, every check on a get or set, and the instantiation token,
//! so they cannot disagree. [`export_fmi!`] gives a shared library its symbols; one library holds
//! any number of models, and the token picks one.
//!
//! A call from C passes one door: the handle is checked, the order of calls is checked, a panic
//! ends its instance and not the importer, and whatever is refused changes nothing and leaves a log
//! line that names the function, the variable and the reason.
//!
//! **Architecture Invariant:** no model and no estimator is reachable from here, and no C type
//! reaches a model.

#![expect(unsafe_code, reason = "the C interfaces of FMI; every block states why it is sound")]

mod access;
mod barrier;
mod c_array;
mod calls;
mod description;
mod export;
pub mod fmi2;
pub mod fmi3;
mod instance;
mod log;
mod model;
mod sha256;
mod slots;
mod state;
mod status;
mod unit;
mod values;
mod variable;
mod xml;

#[doc(hidden)]
pub use barrier::refuse;
pub use description::{DefaultExperiment, ModelDescription};
pub use model::{Model, ModelError, ModelType};
pub use unit::Unit;
pub use values::Values;
pub use variable::{Domain, Kind, Role, ValueReference, Variable};

/// A version of the Functional Mock-up Interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum FmiVersion {
    /// FMI 2.0.
    Fmi2,
    /// FMI 3.0.
    Fmi3,
}

impl FmiVersion {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Fmi2, Self::Fmi3];
}

impl std::fmt::Display for FmiVersion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Fmi2 => "FMI 2.0",
            Self::Fmi3 => "FMI 3.0",
        })
    }
}
