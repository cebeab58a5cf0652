//! The judges of what an estimator is handed in each step.

use crate::{Belief, Covariance, EstimatorError};

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

/// Refuses a belief, or an integral of the rate, that has left the range of floating point.
#[inline]
pub(crate) fn check_range(belief: &Belief, integral_rad: f64) -> Result<(), EstimatorError> {
    let Covariance { angle_rad2, cross_rad2_s, rate_rad2_s2 } = belief.covariance;
    let sum = belief.angle_rad + belief.rate_rad_s + angle_rad2 + cross_rad2_s + rate_rad2_s2;
    // One test for all six: a sum is finite only if each term is.
    if (sum + integral_rad).is_finite() { Ok(()) } else { Err(EstimatorError::Overflow) }
}
