//! Every model that Struna exports as an FMU, in one shared library.
//!
//! A model is one file with one variable table; adding one means adding its file and its line in
//! [`MODELS`]. The library built from here serves FMI 2.0 and 3.0 alike; packaging wraps it once
//! per model and version.
//!
//! **Architecture Invariant:** nothing is computed here. The estimators know nothing of FMI, the C
//! layer knows nothing of estimators, and this crate only names the one to the other.

mod filter;
mod permanent_rotation;
mod torsional_oscillation;

use struna_estimator::{PermanentRotation, TorsionalOscillation};
use struna_fmi_export::{ModelType, export_fmi};

/// The exported models.
pub static MODELS: [ModelType; 2] = [
    ModelType::of::<filter::FilterModel<PermanentRotation>>(),
    ModelType::of::<filter::FilterModel<TorsionalOscillation>>(),
];

/// Finds an exported model by its name.
#[must_use]
pub fn model(name: &str) -> Option<&'static ModelType> {
    MODELS.iter().find(|model| model.description().name() == name)
}

export_fmi!(crate::MODELS);
