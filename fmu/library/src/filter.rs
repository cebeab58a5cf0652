//! What the Kalman filters have in common as FMUs.
//!
//! A step from t to t + h carries the belief over h and then takes in the input, which is the mean
//! rate over the step and valid at its end. Without a valid input it only carries the belief: that
//! is how a gap in the measurements is told.

use std::borrow::Cow;
use std::fmt::Debug;
use struna_estimator::{
    ConfigError, Covariance, EstimatorError, Filter, FilterConfig, Innovation, Motion,
    RateEstimator, Reading, Refinement, RestoreError,
};
use struna_fmi_export::{
    DefaultExperiment, Domain, Model, ModelDescription, ModelError, Role, Unit, ValueReference,
    Values, Variable,
};
use struna_kernel::RAD_PER_DEG;

pub(crate) const MEASURED_RATE_RAD_S: ValueReference = 1;
pub(crate) const MEASURED_RATE_VALID: ValueReference = 2;
pub(crate) const ANGLE_RAD: ValueReference = 3;
pub(crate) const RATE_RAD_S: ValueReference = 4;
pub(crate) const ANGLE_SIGMA_RAD: ValueReference = 5;
pub(crate) const RATE_SIGMA_RAD_S: ValueReference = 6;
pub(crate) const INNOVATION_RAD_S: ValueReference = 7;
pub(crate) const NIS: ValueReference = 8;
const ANGLE_START_RAD: ValueReference = 9;
const RATE_START_RAD_S: ValueReference = 10;
const ANGLE_VARIANCE_START_RAD2: ValueReference = 11;
const RATE_VARIANCE_START_RAD2_S2: ValueReference = 12;
const MEASUREMENT_VARIANCE_RAD2_S2: ValueReference = 13;
const PROCESS_NOISE_RAD2_S3: ValueReference = 14;
const REFINEMENT_SAMPLES: ValueReference = 15;
const REFINEMENT_READING: ValueReference = 16;

/// The rows that every filter has.
pub(crate) const COMMON_ROWS: usize = 17;

/// One period of the 2008 rig at the 100 Hz to which it averaged.
pub(crate) const EXPERIMENT: DefaultExperiment =
    DefaultExperiment { stop_time_s: 480.0, step_size_s: 0.01 };

/// (1°)².
const DEG2: f64 = RAD_PER_DEG * RAD_PER_DEG;
/// Variance of one averaged reading of the rig's fibre-optic gyro, (°/s)².
const MEASUREMENT_VARIANCE_DEG2_S2: f64 = 1.37e-4;
/// The same, rad²/s².
pub(crate) const MEASUREMENT_VARIANCE_RAD2_S2_START: f64 = MEASUREMENT_VARIANCE_DEG2_S2 * DEG2;

/// The part of the variable table that every filter has.
pub(crate) const COMMON_VARIABLES: [Variable; COMMON_ROWS] = {
    use Role::{Input, Output, Parameter};
    use Variable as V;
    let rad = Domain::float64(Unit::RAD, 0.0);
    let rad_s = Domain::float64(Unit::RAD_S, 0.0);
    let one = Domain::float64(Unit::ONE, 0.0);
    let start_rad2 = Domain::not_negative(Unit::RAD2, DEG2);
    let start_rad2_s2 = Domain::not_negative(Unit::RAD2_S2, DEG2);
    let reading_rad2_s2 = Domain::not_negative(Unit::RAD2_S2, MEASUREMENT_VARIANCE_RAD2_S2_START);
    [
        V::TIME,
        V::new(
            MEASURED_RATE_RAD_S,
            Input,
            "measured_rate_rad_s",
            rad_s,
            "Mean measured rate over the step about to be done.",
        ),
        V::new(
            MEASURED_RATE_VALID,
            Input,
            "measured_rate_valid",
            Domain::boolean(true),
            "False in a gap of the measurements: the step then only predicts.",
        ),
        V::new(ANGLE_RAD, Output, "angle_rad", rad, "Believed angle from equilibrium.")
            .starting_from(&[ANGLE_START_RAD]),
        V::new(RATE_RAD_S, Output, "rate_rad_s", rad_s, "Believed rate.")
            .starting_from(&[RATE_START_RAD_S]),
        V::new(
            ANGLE_SIGMA_RAD,
            Output,
            "angle_sigma_rad",
            rad,
            "Standard deviation of the angle that the filter claims.",
        )
        .starting_from(&[ANGLE_VARIANCE_START_RAD2])
        .on_demand(),
        V::new(
            RATE_SIGMA_RAD_S,
            Output,
            "rate_sigma_rad_s",
            rad_s,
            "Standard deviation of the rate that the filter claims.",
        )
        .starting_from(&[RATE_VARIANCE_START_RAD2_S2])
        .on_demand(),
        V::new(
            INNOVATION_RAD_S,
            Output,
            "innovation_rad_s",
            rad_s,
            "Measured minus predicted rate; 0 after a step without measurement.",
        ),
        V::new(
            NIS,
            Output,
            "nis",
            one,
            "Normalised innovation squared, 1 on average when the filter is consistent; \
             0 after a step without measurement.",
        )
        .on_demand(),
        V::new(ANGLE_START_RAD, Parameter, "angle_start_rad", rad, "Believed angle at the start."),
        V::new(
            RATE_START_RAD_S,
            Parameter,
            "rate_start_rad_s",
            rad_s,
            "Believed rate at the start.",
        ),
        V::new(
            ANGLE_VARIANCE_START_RAD2,
            Parameter,
            "angle_variance_start_rad2",
            start_rad2,
            "Variance of the start angle.",
        ),
        V::new(
            RATE_VARIANCE_START_RAD2_S2,
            Parameter,
            "rate_variance_start_rad2_s2",
            start_rad2_s2,
            "Variance of the start rate.",
        ),
        V::new(
            MEASUREMENT_VARIANCE_RAD2_S2,
            Parameter,
            "measurement_variance_rad2_s2",
            reading_rad2_s2,
            "Variance of one measured rate; greater than 0.",
        ),
        V::new(
            PROCESS_NOISE_RAD2_S3,
            Parameter,
            "process_noise_rad2_s3",
            Domain::not_negative(Unit::RAD2_S3, 0.0),
            "Density of white angular acceleration.",
        ),
        V::new(
            REFINEMENT_SAMPLES,
            Parameter,
            "refinement_samples",
            Domain::int32(100, 0, i32::MAX),
            "Measurements per covariance refinement; 0 switches it off.",
        ),
        V::new(
            REFINEMENT_READING,
            Parameter,
            "refinement_reading",
            Domain::int32(6, 0, 6),
            "Reading of the refinement formula: 0 for M0, 1 for M1, 4 for M4, 6 for M6.",
        ),
    ]
};

/// A motion whose filter is exported.
pub(crate) trait ExportedMotion: Motion + Clone + Debug + Send + 'static {
    /// Name and variable table; the table begins with [`COMMON_VARIABLES`].
    const DESCRIPTION: ModelDescription;

    /// The motion with the given parameters.
    fn from_values(values: &Values) -> Result<Self, ConfigError>;
}

/// A filter as an FMU.
#[derive(Debug)]
pub(crate) struct FilterModel<M> {
    filter: Filter<M>,
    /// Of the last step; none if it had no measurement.
    innovation: Option<Innovation>,
}

impl<M: ExportedMotion> FilterModel<M> {
    fn with_parameters(values: &Values) -> Result<Self, ModelError> {
        let motion = M::from_values(values).map_err(bad_parameter)?;
        let filter = Filter::new(config(values)?, motion).map_err(bad_parameter)?;
        Ok(Self { filter, innovation: None })
    }
}

impl<M: ExportedMotion> Model for FilterModel<M> {
    const DESCRIPTION: ModelDescription = M::DESCRIPTION;

    fn initialise(values: &Values, _start_time_s: f64) -> Result<Self, ModelError> {
        Self::with_parameters(values)
    }

    #[inline]
    fn step(&mut self, values: &Values, _time_s: f64, step_s: f64) -> Result<(), ModelError> {
        match advance(&mut self.filter, values, step_s) {
            Ok(innovation) => self.innovation = innovation,
            Err(error) => return Err(ModelError::Step { reason: error.to_string().into() }),
        }
        Ok(())
    }

    #[inline]
    fn write_outputs(&self, values: &mut Values) {
        let belief = self.filter.belief();
        values.set_float64(ANGLE_RAD, belief.angle_rad);
        values.set_float64(RATE_RAD_S, belief.rate_rad_s);
        values.set_float64(INNOVATION_RAD_S, self.innovation.map_or(0.0, |i| i.residual_rad_s));
    }

    /// Two square roots and a division, a good part of what the step itself costs.
    fn write_outputs_on_demand(&self, values: &mut Values) {
        let Covariance { angle_rad2, rate_rad2_s2, .. } = self.filter.belief().covariance;
        values.set_float64(ANGLE_SIGMA_RAD, angle_rad2.sqrt());
        values.set_float64(RATE_SIGMA_RAD_S, rate_rad2_s2.sqrt());
        values.set_float64(NIS, self.innovation.map_or(0.0, |i| i.nis()));
    }

    fn save(&self, saved: &mut Vec<u8>) {
        let start = saved.len();
        saved.resize(start + self.filter.saved_len(), 0);
        self.filter.save(&mut saved[start..]);
    }

    /// The innovation is not brought back: it is an output of the last step, and outputs are among
    /// the values.
    fn restore(values: &Values, saved: &[u8]) -> Result<Self, ModelError> {
        let mut model = Self::with_parameters(values)?;
        model.filter.restore(saved).map_err(bad_state)?;
        Ok(model)
    }
}

/// One step of the filter, done whole or not at all: predicts, and takes the measurement in if
/// there is one.
#[inline]
fn advance<M: Motion>(
    filter: &mut Filter<M>,
    values: &Values,
    step_s: f64,
) -> Result<Option<Innovation>, EstimatorError> {
    if values.boolean(MEASURED_RATE_VALID) {
        filter.step(step_s, values.float64(MEASURED_RATE_RAD_S)).map(Some)
    } else {
        filter.predict(step_s).map(|()| None)
    }
}

fn config(values: &Values) -> Result<FilterConfig, ModelError> {
    Ok(FilterConfig {
        angle_start_rad: values.float64(ANGLE_START_RAD),
        rate_start_rad_s: values.float64(RATE_START_RAD_S),
        angle_variance_start_rad2: values.float64(ANGLE_VARIANCE_START_RAD2),
        rate_variance_start_rad2_s2: values.float64(RATE_VARIANCE_START_RAD2_S2),
        measurement_variance_rad2_s2: values.float64(MEASUREMENT_VARIANCE_RAD2_S2),
        process_noise_rad2_s3: values.float64(PROCESS_NOISE_RAD2_S3),
        refinement: refinement(values)?,
    })
}

fn refinement(values: &Values) -> Result<Refinement, ModelError> {
    let samples = values.int32(REFINEMENT_SAMPLES);
    let reading = values.int32(REFINEMENT_READING);
    let bad = |reference: ValueReference, value: i32, reason: &'static str| {
        let variable = COMMON_VARIABLES[reference as usize].name();
        ModelError::BadValue { variable, value: f64::from(value), reason: reason.into() }
    };
    Ok(Refinement {
        samples: u32::try_from(samples)
            .map_err(|_| bad(REFINEMENT_SAMPLES, samples, "it must not be negative"))?,
        reading: Reading::from_number(reading)
            .ok_or_else(|| bad(REFINEMENT_READING, reading, "it must be 0, 1, 4 or 6"))?,
    })
}

/// The estimators name their parameters as the variable table does.
pub(crate) fn bad_parameter(error: ConfigError) -> ModelError {
    let reason = Cow::Owned(format!("it must be finite and {}", error.bound));
    ModelError::BadValue { variable: error.name, value: error.value, reason }
}

pub(crate) fn bad_state(error: RestoreError) -> ModelError {
    ModelError::BadState { reason: error.to_string().into() }
}
