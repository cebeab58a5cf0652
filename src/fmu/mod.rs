//! FMU files: the exported models wrapped for importers of FMI 2.0 and 3.0.

mod package;

pub use package::{PackageError, find_library, package};
pub use struna_fmi_export::{FmiVersion, ModelType};

use std::path::{Path, PathBuf};

/// The models that can be built.
#[must_use]
pub fn models() -> &'static [ModelType] {
    &struna_fmu_library::MODELS
}

/// Writes the FMU of the model called `name` into `folder`, from the shared library that this
/// program was built with, and gives its path.
///
/// # Errors
/// [`PackageError::UnknownModel`], and whatever [`find_library`] and [`package`] refuse.
pub fn build(name: &str, version: FmiVersion, folder: &Path) -> Result<PathBuf, PackageError> {
    let model = struna_fmu_library::model(name).ok_or_else(|| PackageError::UnknownModel {
        name: name.to_owned(),
        known: models().iter().map(|m| m.description().name()).collect(),
    })?;
    package(model, version, &find_library()?, folder)
}
