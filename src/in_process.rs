//! Estimators that run in this process, as devices under test.

use struna_estimator::RateEstimator;
use struna_harness::{DeviceError, DeviceFault, DeviceUnderTest};
use struna_kernel::{AngleEstimate, EstimateStatus, RateOf, RateSample, SimTime};

/// An estimator in process. Steps exactly as the FMU of the same estimator does, to the last bit.
pub struct InProcess {
    name: String,
    estimator: Box<dyn RateEstimator>,
    time: SimTime,
    rate_of: RateOf,
}

impl InProcess {
    /// Starts `estimator` at time zero. Its rate is taken for that about the body's axis, unless
    /// [`telling`](Self::telling) says otherwise.
    #[must_use]
    pub fn new(name: &str, estimator: Box<dyn RateEstimator>) -> Self {
        Self { name: name.to_owned(), estimator, time: SimTime::ZERO, rate_of: RateOf::BodyAxis }
    }

    /// The same of an estimator whose rate is that of `rate_of`.
    #[must_use]
    pub fn telling(self, rate_of: RateOf) -> Self {
        Self { rate_of, ..self }
    }
}

impl std::fmt::Debug for InProcess {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("InProcess").field("name", &self.name).finish_non_exhaustive()
    }
}

impl DeviceUnderTest for InProcess {
    fn name(&self) -> &str {
        &self.name
    }

    fn step(&mut self, sample: &RateSample) -> Result<AngleEstimate, DeviceError> {
        let advance = |estimator: &mut dyn RateEstimator| {
            if sample.from > self.time {
                estimator.predict(sample.from.seconds_since(self.time))?;
            }
            if sample.over_range {
                estimator.predict(sample.span_s())?;
                estimator.update_over_range(sample.rate_rad_s)
            } else {
                estimator.step_mean(sample.span_s(), sample.rate_rad_s)
            }
        };
        let innovation = advance(self.estimator.as_mut()).map_err(|fault| DeviceError {
            device: self.name.clone(),
            time_s: sample.time.as_s(),
            cause: Box::new(DeviceFault::InProcess(Box::new(fault))),
        })?;
        self.time = sample.time;
        let (belief, status) = self.estimator.report();
        Ok(AngleEstimate {
            time: sample.time,
            angle_rad: belief.angle_rad,
            rate_rad_s: belief.rate_rad_s,
            angle_sigma_rad: belief.covariance.angle_rad2.sqrt(),
            rate_sigma_rad_s: belief.covariance.rate_rad2_s2.sqrt(),
            nis: innovation.nis(),
            status: EstimateStatus::from_code(status.code()),
            rate_of: self.rate_of,
        })
    }
}
