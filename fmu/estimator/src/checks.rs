//! The judges of what an estimator is handed in each step, and of what it makes of it.

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

/// `value`, unless it has left the range of floating point.
///
/// A covariance is judged number by number, which is also a fence: between judgements the compiler
/// cannot pack numbers of different rows into one SIMD register. It would, and the packing lies on
/// the path that each step waits for; one judgement at the end takes a third longer per step.
#[inline]
pub(crate) fn in_range(value: f64) -> Result<f64, EstimatorError> {
    if value.is_finite() { Ok(value) } else { Err(EstimatorError::Overflow) }
}
