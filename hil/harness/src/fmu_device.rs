//! An estimator that runs as an FMU.

use crate::device::{DeviceError, DeviceUnderTest};
use struna_fmi_import::{FmuDescription, ImportError, Importer, Instance, Kind, ValueReference};
use struna_kernel::{AngleEstimate, EstimateStatus, RateOf, RateSample, SimTime};

/// A parameter to set before the FMU is initialised.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Variable name, unit suffix included.
    pub name: String,
    /// Its value.
    pub value: ParameterValue,
}

/// The value of a [`Parameter`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ParameterValue {
    /// Float64.
    Float64(f64),
    /// Int32.
    Int32(i32),
    /// Boolean.
    Boolean(bool),
}

/// Drives an FMU with the estimators' variables: `measured_rate_rad_s` and `measured_rate_valid`
/// in; `angle_rad`, `rate_rad_s`, `angle_sigma_rad`, `rate_sigma_rad_s`, `nis` out.
///
/// An FMU that has it is told by `measured_rate_over_range` of a clipped sample, and asked for its
/// `status`; of one without, the status follows from the sigma that it claims.
#[derive(Debug)]
pub struct FmuDevice {
    name: String,
    instance: Box<dyn Instance>,
    time: SimTime,
    variables: Variables,
    rate_of: RateOf,
}

/// Where the variables are, looked up once.
#[derive(Debug)]
struct Variables {
    rate: [ValueReference; 1],
    valid: ValueReference,
    over_range: Option<ValueReference>,
    outputs: [ValueReference; 5],
    status: Option<ValueReference>,
}

impl Variables {
    fn find(description: &FmuDescription) -> Result<Self, ImportError> {
        let float = |name: &str| description.variable(name, Kind::Float64);
        Ok(Self {
            rate: [float("measured_rate_rad_s")?],
            valid: description.variable("measured_rate_valid", Kind::Boolean)?,
            over_range: description.variable("measured_rate_over_range", Kind::Boolean).ok(),
            outputs: [
                float("angle_rad")?,
                float("rate_rad_s")?,
                float("angle_sigma_rad")?,
                float("rate_sigma_rad_s")?,
                float("nis")?,
            ],
            status: description.variable("status", Kind::Int32).ok(),
        })
    }
}

impl FmuDevice {
    /// Instantiates and initialises the FMU at time zero.
    ///
    /// # Errors
    /// [`ImportError`] when the FMU lacks a variable, or refuses a parameter or to start.
    pub fn new(
        importer: &dyn Importer,
        name: &str,
        parameters: &[Parameter],
    ) -> Result<Self, ImportError> {
        let description = importer.description();
        let variables = Variables::find(description)?;
        let mut instance = importer.instantiate(name)?;
        for Parameter { name, value } in parameters {
            match *value {
                ParameterValue::Float64(value) => {
                    let reference = description.variable(name, Kind::Float64)?;
                    instance.set_f64(&[reference], &[value])?;
                }
                ParameterValue::Int32(value) => {
                    instance.set_i32(description.variable(name, Kind::Int32)?, value)?;
                }
                ParameterValue::Boolean(value) => {
                    instance.set_bool(description.variable(name, Kind::Boolean)?, value)?;
                }
            }
        }
        instance.initialise(SimTime::ZERO.as_s())?;
        let (name, time, rate_of) = (name.to_owned(), SimTime::ZERO, RateOf::BodyAxis);
        Ok(Self { name, instance, time, variables, rate_of })
    }

    /// The same FMU, whose rate is that of `rate_of`: an FMU does not say, and its rate is taken
    /// for that about the body's axis otherwise.
    #[must_use]
    pub fn telling(self, rate_of: RateOf) -> Self {
        Self { rate_of, ..self }
    }

    /// Carries the FMU over a stretch without measurement, if there is one before the sample.
    fn cross_gap(&mut self, sample: &RateSample) -> Result<(), ImportError> {
        if sample.from <= self.time {
            return Ok(());
        }
        let gap_s = sample.from.seconds_since(self.time);
        self.instance.set_bool(self.variables.valid, false)?;
        self.instance.do_step(self.time.as_s(), gap_s)?;
        self.instance.set_bool(self.variables.valid, true)
    }

    fn advance(&mut self, sample: &RateSample) -> Result<AngleEstimate, ImportError> {
        self.cross_gap(sample)?;
        let Variables { rate, over_range, outputs, status, .. } = &self.variables;
        self.instance.set_f64(rate, &[sample.rate_rad_s])?;
        if let Some(over_range) = *over_range {
            self.instance.set_bool(over_range, sample.over_range)?;
        }
        self.instance.do_step(sample.from.as_s(), sample.span_s())?;
        self.time = sample.time;
        let mut out = [0.0; 5];
        self.instance.get_f64(outputs, &mut out)?;
        let [angle_rad, rate_rad_s, angle_sigma_rad, rate_sigma_rad_s, nis] = out;
        let status = match *status {
            Some(status) => EstimateStatus::from_code(self.instance.get_i32(status)?),
            None => EstimateStatus::of_claim(angle_sigma_rad),
        };
        Ok(AngleEstimate {
            time: sample.time,
            angle_rad,
            rate_rad_s,
            angle_sigma_rad,
            rate_sigma_rad_s,
            nis,
            status,
            rate_of: self.rate_of,
        })
    }
}

impl DeviceUnderTest for FmuDevice {
    fn name(&self) -> &str {
        &self.name
    }

    fn step(&mut self, sample: &RateSample) -> Result<AngleEstimate, DeviceError> {
        self.advance(sample).map_err(|fault| DeviceError {
            device: self.name.clone(),
            time_s: sample.time.as_s(),
            cause: Box::new(fault.into()),
        })
    }
}
