//! The bank of filters for a thread that may yield, as the FMU `HysteresisBank`.

use crate::exported::ExportedEstimator;
use crate::filter::EXPERIMENT;
use crate::learning::{LEARNING_ROWS, bad, config, learning_table, output, write_learnt};
use struna_estimator::{HysteresisBank, RateEstimator};
use struna_fmi_export::{ModelDescription, ModelError, Unit, ValueReference, Values, Variable};

#[expect(clippy::cast_possible_truncation, reason = "a few dozen rows")]
const LINEAR_WEIGHT: ValueReference = LEARNING_ROWS as ValueReference;
const YIELD_ANGLE_RAD: ValueReference = LINEAR_WEIGHT + 1;
const YIELD_ANGLE_SIGMA_RAD: ValueReference = LINEAR_WEIGHT + 2;

static VARIABLES: [Variable; LEARNING_ROWS + 3] = {
    let weight = "Weight of the thread that does not yield; those of all members sum to 1.";
    let yields = "Angle at which the thread yields, as the members that do so believe; 0 when none \
                  of them is left.";
    let sigma = "Standard deviation of it.";
    learning_table(&[
        output(LINEAR_WEIGHT, "linear_weight", Unit::ONE, weight),
        output(YIELD_ANGLE_RAD, "yield_angle_rad", Unit::RAD, yields),
        output(YIELD_ANGLE_SIGMA_RAD, "yield_angle_sigma_rad", Unit::RAD, sigma),
    ])
};

/// The bank.
#[derive(Debug)]
pub(crate) struct Bank(HysteresisBank);

impl ExportedEstimator for Bank {
    const DESCRIPTION: ModelDescription = ModelDescription::new(
        "HysteresisBank",
        env!("CARGO_PKG_VERSION"),
        "Bank of Kalman filters of angle and rate from one gyro, for a body on a string that loses \
         energy to hysteresis: a linear thread and four that yield, weighed against each other.",
        EXPERIMENT,
        &VARIABLES,
    );

    fn from_values(values: &Values) -> Result<Self, ModelError> {
        HysteresisBank::new(&config(values)).map(Self).map_err(bad)
    }

    fn estimator(&self) -> &dyn RateEstimator {
        &self.0
    }

    fn estimator_mut(&mut self) -> &mut dyn RateEstimator {
        &mut self.0
    }

    fn write_more(&self, values: &mut Values) {
        write_learnt(values, &self.0.learnt());
        let [linear, ..] = self.0.weights();
        let (angle_rad, sigma_rad) = self.0.yield_angle_rad().unwrap_or((0.0, 0.0));
        values.set_float64(LINEAR_WEIGHT, linear);
        values.set_float64(YIELD_ANGLE_RAD, angle_rad);
        values.set_float64(YIELD_ANGLE_SIGMA_RAD, sigma_rad);
    }
}
