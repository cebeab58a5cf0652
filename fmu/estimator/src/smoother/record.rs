//! What a smoother is given, and when it refuses it.

use crate::checks::{check_measurement, check_span};
use crate::{ConfigError, EstimatorError};

/// One measured rate of a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RateSample {
    /// When it was valid, s.
    pub time_s: f64,
    /// Measured rate, rad/s.
    pub rate_rad_s: f64,
    /// Whether the gyro flags it as over range. It is then left out.
    pub over_range: bool,
}

/// A record: samples in order, and when it begins.
///
/// Spans may differ, and a gap of any length is a long span.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RateRecord<'a> {
    /// When the start belief holds, s. Not after the first sample.
    pub start_time_s: f64,
    /// The samples, none earlier than the one before.
    pub samples: &'a [RateSample],
}

/// Why a record cannot be smoothed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SmoothError {
    /// The model is unusable.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// There is no sample.
    #[error("the record holds no sample")]
    Empty,
    /// A sample is not a number, or earlier than the one before it.
    #[error("sample {index} at {time_s} s: {source}")]
    BadSample {
        /** Its place in the record, from 0. */
        index: usize,
        /** Its time, s. */
        time_s: f64,
        /** What is wrong with it. */
        source: EstimatorError,
    },
}

impl<'a> RateRecord<'a> {
    /// Each sample with the seconds since the one before it.
    pub(super) fn steps(&self) -> impl Iterator<Item = (f64, &'a RateSample)> + use<'a> {
        let mut before_s = self.start_time_s;
        self.samples.iter().map(move |sample| {
            let span_s = sample.time_s - before_s;
            before_s = sample.time_s;
            (span_s, sample)
        })
    }

    /// Checks every sample.
    pub(super) fn validate(&self) -> Result<(), SmoothError> {
        if self.samples.is_empty() {
            return Err(SmoothError::Empty);
        }
        for (index, (span_s, sample)) in self.steps().enumerate() {
            check_span(span_s)
                .and_then(|()| check_measurement(sample.rate_rad_s))
                .map_err(|source| bad_sample(index, sample, source))?;
        }
        Ok(())
    }
}

pub(super) fn bad_sample(index: usize, at: &RateSample, source: EstimatorError) -> SmoothError {
    SmoothError::BadSample { index, time_s: at.time_s, source }
}
