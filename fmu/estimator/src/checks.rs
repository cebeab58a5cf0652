//! The judges of what an estimator is handed in each step.

use crate::EstimatorError;

#[inline]
pub(crate) fn check_span(span_s: f64) -> Result<(), EstimatorError> {
    if (0.0..f64::INFINITY).contains(&span_s) {
        Ok(())
    } else {
        Err(EstimatorError::BadSpan { span_s })
    }
}

#[inline]
pub(crate) fn check_measurement(rate_rad_s: f64) -> Result<(), EstimatorError> {
    if rate_rad_s.is_finite() { Ok(()) } else { Err(EstimatorError::BadMeasurement { rate_rad_s }) }
}
