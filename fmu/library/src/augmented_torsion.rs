//! The filter that learns period, damping and bias while it watches, alone or behind the test of
//! its own innovations, as the FMU `AugmentedTorsion`.

use crate::exported::{ExportedEstimator, parameter};
use crate::filter::EXPERIMENT;
use crate::learning::{TESTED_ROWS, bad, config, test, tested_table, write_alarms, write_learnt};
use struna_estimator::{AugmentedFilter, EstimatorError, Innovation, RateEstimator, TestedFilter};
use struna_fmi_export::{Domain, ModelDescription, ModelError, ValueReference, Values, Variable};

#[expect(clippy::cast_possible_truncation, reason = "a few dozen rows")]
const INNOVATION_TEST: ValueReference = TESTED_ROWS as ValueReference;

static VARIABLES: [Variable; TESTED_ROWS + 1] = tested_table(&[parameter(
    INNOVATION_TEST,
    "innovation_test",
    Domain::boolean(true),
    "True: outliers are gated, and kicks answered with a roll-back.",
)]);

/// The filter, with or without the test.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "made once, and behind a box already")]
pub(crate) enum AugmentedTorsion {
    Alone(AugmentedFilter),
    Tested(TestedFilter),
}

impl AugmentedTorsion {
    fn filter(&self) -> (&AugmentedFilter, u64) {
        match self {
            Self::Alone(filter) => (filter, 0),
            Self::Tested(tested) => (tested.filter(), tested.alarms()),
        }
    }
}

impl ExportedEstimator for AugmentedTorsion {
    const DESCRIPTION: ModelDescription = ModelDescription::new(
        "AugmentedTorsion",
        env!("CARGO_PKG_VERSION"),
        "Extended Kalman filter of angle and rate from one gyro, for a body that swings on a \
         string: it learns period, damping and the gyro's bias, and survives kicks and outliers.",
        EXPERIMENT,
        &VARIABLES,
    );

    fn from_values(values: &Values) -> Result<Self, ModelError> {
        let config = config(values);
        Ok(if values.boolean(INNOVATION_TEST) {
            Self::Tested(TestedFilter::new(&config, &test(values)).map_err(bad)?)
        } else {
            Self::Alone(AugmentedFilter::new(&config).map_err(bad)?)
        })
    }

    fn estimator(&self) -> &dyn RateEstimator {
        match self {
            Self::Alone(filter) => filter,
            Self::Tested(filter) => filter,
        }
    }

    fn estimator_mut(&mut self) -> &mut dyn RateEstimator {
        match self {
            Self::Alone(filter) => filter,
            Self::Tested(filter) => filter,
        }
    }

    fn step(&mut self, span_s: f64, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        match self {
            Self::Alone(filter) => filter.step(span_s, rate_rad_s),
            Self::Tested(filter) => filter.step(span_s, rate_rad_s),
        }
    }

    fn step_over_range(
        &mut self,
        span_s: f64,
        rate_rad_s: f64,
    ) -> Result<Innovation, EstimatorError> {
        match self {
            Self::Alone(filter) => filter.step_over_range(span_s, rate_rad_s),
            Self::Tested(filter) => filter.step_over_range(span_s, rate_rad_s),
        }
    }

    fn write_more(&self, values: &mut Values) {
        let (filter, alarms) = self.filter();
        write_learnt(values, &filter.learnt());
        write_alarms(values, alarms);
    }
}
