//! The Kalman filter that assumes a constant rate, as the FMU `PermanentRotation`.

use crate::filter::{COMMON_ROWS, COMMON_VARIABLES, EXPERIMENT, ExportedMotion};
use struna_estimator::{ConfigError, PermanentRotation};
use struna_fmi_export::{ModelDescription, Values, Variable};

static VARIABLES: [Variable; COMMON_ROWS] = COMMON_VARIABLES;

impl ExportedMotion for PermanentRotation {
    const DESCRIPTION: ModelDescription = ModelDescription::new(
        "PermanentRotation",
        env!("CARGO_PKG_VERSION"),
        "Kalman filter of angle and rate from one gyro, for a body that turns at a constant rate.",
        EXPERIMENT,
        &VARIABLES,
    );

    fn from_values(_values: &Values) -> Result<Self, ConfigError> {
        Ok(Self)
    }
}
