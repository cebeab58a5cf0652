//! Plain integration of the measured rate: the estimate every filter has to beat.

use crate::checks::{check_measurement, check_span};
use crate::config::ConfigError;
use crate::state_bytes::{Reader, RestoreError, Writer};
use crate::{Belief, Covariance, EstimatorError, FilterConfig, Innovation, RateEstimator};

/// Sums measured rate times span. A gap is bridged with the rate that ends it.
///
/// Its claimed angle variance counts the start variance and the white noise of the measurements;
/// bias is outside its model, and so is everything else.
#[derive(Debug, Clone)]
pub struct PlainIntegration {
    measurement_variance_rad2_s2: f64,
    angle_rad: f64,
    rate_rad_s: f64,
    angle_variance_rad2: f64,
    rate_variance_rad2_s2: f64,
    since_update_s: f64,
}

impl PlainIntegration {
    /// Starts from the angle and variances of `config`; process noise and refinement do not apply.
    ///
    /// # Errors
    /// [`ConfigError`] names the value out of its bound.
    pub fn new(config: FilterConfig) -> Result<Self, ConfigError> {
        config.validate()?;
        Ok(Self {
            measurement_variance_rad2_s2: config.measurement_variance_rad2_s2,
            angle_rad: config.angle_start_rad,
            rate_rad_s: config.rate_start_rad_s,
            angle_variance_rad2: config.angle_variance_start_rad2,
            rate_variance_rad2_s2: config.rate_variance_start_rad2_s2,
            since_update_s: 0.0,
        })
    }

    const SAVED_LEN: usize = 5 * 8;
}

impl RateEstimator for PlainIntegration {
    fn predict(&mut self, span_s: f64) -> Result<(), EstimatorError> {
        check_span(span_s)?;
        self.since_update_s += span_s;
        Ok(())
    }

    fn update(&mut self, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        check_measurement(rate_rad_s)?;
        let r = self.measurement_variance_rad2_s2;
        let variance_rad2_s2 = self.rate_variance_rad2_s2 + r;
        let residual_rad_s = rate_rad_s - self.rate_rad_s;
        let angle_rad = self.angle_rad + rate_rad_s * self.since_update_s;
        if !(angle_rad + residual_rad_s).is_finite() {
            return Err(EstimatorError::Overflow);
        }
        self.angle_rad = angle_rad;
        self.angle_variance_rad2 += r * self.since_update_s * self.since_update_s;
        self.rate_rad_s = rate_rad_s;
        self.rate_variance_rad2_s2 = r;
        self.since_update_s = 0.0;
        Ok(Innovation { residual_rad_s, variance_rad2_s2 })
    }

    /// The mean over a span times the span is the angle turned in it.
    fn step_mean(&mut self, span_s: f64, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        self.step(span_s, rate_rad_s)
    }

    fn belief(&self) -> Belief {
        Belief {
            angle_rad: self.angle_rad,
            rate_rad_s: self.rate_rad_s,
            covariance: Covariance::diagonal(self.angle_variance_rad2, self.rate_variance_rad2_s2),
        }
    }

    fn saved_len(&self) -> usize {
        Self::SAVED_LEN
    }

    fn save(&self, out: &mut [u8]) {
        let mut out = Writer::new(out);
        out.f64(self.angle_rad);
        out.f64(self.rate_rad_s);
        out.f64(self.angle_variance_rad2);
        out.f64(self.rate_variance_rad2_s2);
        out.f64(self.since_update_s);
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        let mut bytes = Reader::new(bytes, Self::SAVED_LEN)?;
        let mut restored = self.clone();
        restored.angle_rad = bytes.finite("angle_rad")?;
        restored.rate_rad_s = bytes.finite("rate_rad_s")?;
        restored.angle_variance_rad2 = bytes.finite("angle variance")?;
        restored.rate_variance_rad2_s2 = bytes.finite("rate variance")?;
        restored.since_update_s = bytes.finite("since_update_s")?;
        *self = restored;
        Ok(())
    }
}
