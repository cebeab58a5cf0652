//! The Kalman filter that assumes undamped torsion of known period, as the FMU
//! `TorsionalOscillation`.

use crate::filter::{COMMON_ROWS, COMMON_VARIABLES, EXPERIMENT, ExportedMotion};
use struna_estimator::{ConfigError, TorsionalOscillation};
use struna_fmi_export::{Domain, ModelDescription, Role, Unit, ValueReference, Values, Variable};

const PERIOD_S: ValueReference = 17;

static VARIABLES: [Variable; COMMON_ROWS + 1] = {
    let period = Domain::not_negative(Unit::S, 480.0);
    let meaning = "Period of the torsional oscillation; greater than 0.";
    let mut rows = [Variable::TIME; COMMON_ROWS + 1];
    let (common, own) = rows.split_at_mut(COMMON_ROWS);
    common.copy_from_slice(&COMMON_VARIABLES);
    own[0] = Variable::new(PERIOD_S, Role::Parameter, "period_s", period, meaning);
    rows
};

impl ExportedMotion for TorsionalOscillation {
    const DESCRIPTION: ModelDescription = ModelDescription::new(
        "TorsionalOscillation",
        env!("CARGO_PKG_VERSION"),
        "Kalman filter of angle and rate from one gyro, for a body that swings on a string of \
         known torsional period.",
        EXPERIMENT,
        &VARIABLES,
    );

    fn from_values(values: &Values) -> Result<Self, ConfigError> {
        Self::with_period(values.float64(PERIOD_S))
    }
}
