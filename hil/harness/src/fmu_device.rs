//! An estimator that runs as an FMU.

use crate::device::{DeviceError, DeviceUnderTest};
use struna_fmi_import::{ImportError, Importer, Instance, Kind, ValueReference};
use struna_kernel::{AngleEstimate, RateSample, SimTime};

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
}

/// Drives an FMU with the estimators' variables: `measured_rate_rad_s` and `measured_rate_valid`
/// in; `angle_rad`, `rate_rad_s`, `angle_sigma_rad`, `rate_sigma_rad_s` out.
#[derive(Debug)]
pub struct FmuDevice {
    name: String,
    instance: Box<dyn Instance>,
    time: SimTime,
    rate: [ValueReference; 1],
    valid: ValueReference,
    outputs: [ValueReference; 4],
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
        let output = |name: &str| description.variable(name, Kind::Float64);
        let rate = [output("measured_rate_rad_s")?];
        let valid = description.variable("measured_rate_valid", Kind::Boolean)?;
        let outputs = [
            output("angle_rad")?,
            output("rate_rad_s")?,
            output("angle_sigma_rad")?,
            output("rate_sigma_rad_s")?,
        ];
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
            }
        }
        instance.initialise(SimTime::ZERO.as_s())?;
        let name = name.to_owned();
        Ok(Self { name, instance, time: SimTime::ZERO, rate, valid, outputs })
    }

    /// Carries the FMU over a stretch without measurement, if there is one before the sample.
    fn cross_gap(&mut self, sample: &RateSample) -> Result<(), ImportError> {
        if sample.from <= self.time {
            return Ok(());
        }
        let gap_s = sample.from.seconds_since(self.time);
        self.instance.set_bool(self.valid, false)?;
        self.instance.do_step(self.time.as_s(), gap_s)?;
        self.instance.set_bool(self.valid, true)
    }

    fn advance(&mut self, sample: &RateSample) -> Result<AngleEstimate, ImportError> {
        self.cross_gap(sample)?;
        self.instance.set_f64(&self.rate, &[sample.rate_rad_s])?;
        self.instance.do_step(sample.from.as_s(), sample.span_s())?;
        self.time = sample.time;
        let mut out = [0.0; 4];
        self.instance.get_f64(&self.outputs, &mut out)?;
        let [angle_rad, rate_rad_s, angle_sigma_rad, rate_sigma_rad_s] = out;
        let time = sample.time;
        Ok(AngleEstimate { time, angle_rad, rate_rad_s, angle_sigma_rad, rate_sigma_rad_s })
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
