//! The record of a gyro at rest: rates at even distances in time, with holes where some were lost.

use super::CharacteriseError;
use std::ops::Range;

/// Rates of a gyro that does not turn, rad/s, in stretches without loss.
///
/// A lost sample ends a stretch. It is never filled in: an invented sample would be noise of
/// another kind than the gyro's, and closing the hole would shift the phase of all that follows.
#[derive(Debug, Clone, PartialEq)]
pub struct RateRecord {
    sample_rate_hz: f64,
    rates_rad_s: Vec<f64>,
    stretches: Vec<Range<usize>>,
    lost: u64,
    open: bool,
}

impl RateRecord {
    /// An empty record with `sample_rate_hz` samples per second.
    ///
    /// # Errors
    /// [`CharacteriseError::SampleRate`] unless the rate is positive and finite.
    pub fn new(sample_rate_hz: f64) -> Result<Self, CharacteriseError> {
        if !(sample_rate_hz.is_normal() && sample_rate_hz > 0.0) {
            return Err(CharacteriseError::SampleRate { sample_rate_hz });
        }
        let (rates_rad_s, stretches) = (Vec::new(), Vec::new());
        Ok(Self { sample_rate_hz, rates_rad_s, stretches, lost: 0, open: false })
    }

    /// A record without losses.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn contiguous(
        sample_rate_hz: f64,
        rates_rad_s: impl IntoIterator<Item = f64>,
    ) -> Result<Self, CharacteriseError> {
        let mut record = Self::new(sample_rate_hz)?;
        rates_rad_s.into_iter().for_each(|rate_rad_s| record.push(rate_rad_s));
        Ok(record)
    }

    /// Appends the next sample; one that is not finite counts as lost.
    pub fn push(&mut self, rate_rad_s: f64) {
        if !rate_rad_s.is_finite() {
            return self.lose(1);
        }
        let at = self.rates_rad_s.len();
        self.rates_rad_s.push(rate_rad_s);
        match self.stretches.last_mut().filter(|_| self.open) {
            Some(stretch) => stretch.end = at + 1,
            None => self.stretches.push(at..at + 1),
        }
        self.open = true;
    }

    /// Notes that `samples` are missing here.
    pub fn lose(&mut self, samples: u64) {
        if samples > 0 {
            self.lost = self.lost.saturating_add(samples);
            self.open = false;
        }
    }

    /// Samples per second, Hz.
    #[must_use]
    pub fn sample_rate_hz(&self) -> f64 {
        self.sample_rate_hz
    }

    /// All samples there are, rad/s.
    #[must_use]
    pub fn rates_rad_s(&self) -> &[f64] {
        &self.rates_rad_s
    }

    /// How many samples were lost.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// The stretches without loss, in order of time, rad/s.
    pub fn stretches(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.stretches.iter().map(|stretch| &self.rates_rad_s[stretch.clone()])
    }

    /// Samples in the longest stretch.
    #[must_use]
    pub fn longest_stretch(&self) -> usize {
        self.stretches().map(<[f64]>::len).max().unwrap_or(0)
    }

    /// Time that the samples cover, lost ones left out, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.rates_rad_s.len() as f64 / self.sample_rate_hz
    }

    /// Mean of all samples, rad/s; zero without any.
    #[must_use]
    pub fn mean_rad_s(&self) -> f64 {
        mean(&self.rates_rad_s)
    }
}

/// The mean of `values`; zero without any.
pub(super) fn mean(values: &[f64]) -> f64 {
    let Some(first) = values.first() else { return 0.0 };
    // About the first value, so that a large constant costs no digits.
    let rest = values.iter().map(|value| value - first).sum::<f64>();
    first + rest / values.len() as f64
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "samples are kept to the bit")]
mod tests {
    use super::*;

    #[test]
    fn losses_part_the_record_and_are_counted() {
        let mut record = RateRecord::new(2.0).unwrap();
        record.lose(3);
        [1.0, 2.0, f64::NAN, 3.0].into_iter().for_each(|rate| record.push(rate));
        record.lose(0);
        record.push(4.0);
        record.lose(u64::MAX);
        let stretches: Vec<_> = record.stretches().collect();
        assert_eq!(stretches, [&[1.0, 2.0][..], &[3.0, 4.0]]);
        assert_eq!((record.lost(), record.longest_stretch()), (u64::MAX, 2));
        assert_eq!((record.duration_s(), record.mean_rad_s()), (2.0, 2.5));
    }

    #[test]
    fn a_sample_rate_that_is_none_is_refused() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-320] {
            assert!(RateRecord::new(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn an_empty_record_has_no_stretch() {
        let record = RateRecord::new(1.0).unwrap();
        assert_eq!((record.stretches().len(), record.longest_stretch()), (0, 0));
        assert_eq!(record.mean_rad_s(), 0.0);
    }
}
