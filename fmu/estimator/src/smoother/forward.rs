//! The tested filter over a record, with the past repaired wherever it went back.

use super::record::{RateRecord, RateSample, SmoothError, bad_sample};
use crate::augmented::{AugmentedFilter, Trace};
use crate::{AugmentedConfig, EstimatorError, InnovationTest, RateEstimator, Status, TestedFilter};
use alloc::vec::Vec;

/// A change of the rate that the innovations showed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kick {
    /// Place in the record of the first sample that shows it.
    pub sample: usize,
    /// When that was, s.
    pub time_s: f64,
    /// Change of the rate, rad/s.
    pub size_rad_s: f64,
    /// Its standard deviation, rad/s.
    pub size_sigma_rad_s: f64,
}

/// All that the filter leaves behind. Trace 0 is the start, trace k + 1 stands after sample k.
#[derive(Debug, Clone)]
pub(super) struct Forward {
    pub(super) model: AugmentedFilter,
    pub(super) traces: Vec<Trace>,
    pub(super) kicks: Vec<Kick>,
    pub(super) status: Status,
}

/// Takes a sample into the filter: all of it, or nothing.
pub(super) fn step(
    filter: &mut TestedFilter,
    span_s: f64,
    sample: &RateSample,
) -> Result<(), EstimatorError> {
    if !sample.over_range {
        return filter.step(span_s, sample.rate_rad_s).map(|_| ());
    }
    // Both steps are tried first: the second one could refuse what the first has begun.
    let mut trial = filter.filter().clone();
    trial.predict(span_s)?;
    trial.update_over_range(sample.rate_rad_s)?;
    filter.predict(span_s)?;
    filter.update_over_range(sample.rate_rad_s).map(|_| ())
}

impl Forward {
    pub(super) fn over(
        config: &AugmentedConfig,
        test: &InnovationTest,
        record: &RateRecord<'_>,
    ) -> Result<Self, SmoothError> {
        record.validate()?;
        let mut filter = TestedFilter::new(config, test)?;
        let mut forward = Self {
            model: filter.filter().clone(),
            traces: Vec::with_capacity(record.samples.len() + 1),
            kicks: Vec::new(),
            status: Status::Nominal,
        };
        forward.traces.push(filter.trace(0.0));
        for (index, (span_s, sample)) in record.steps().enumerate() {
            let alarms = filter.alarms();
            step(&mut filter, span_s, sample).map_err(|e| bad_sample(index, sample, e))?;
            forward.traces.push(filter.trace(span_s));
            if filter.alarms() > alarms {
                forward.go_back(&filter, record);
            }
            if filter.status() == Status::ModelDoubtful {
                forward.status = Status::ModelDoubtful;
            }
        }
        if forward.status == Status::Nominal {
            forward.status = filter.status();
        }
        Ok(forward)
    }

    /// Replaces the traces of the samples that the filter has just run again.
    fn go_back(&mut self, filter: &TestedFilter, record: &RateRecord<'_>) {
        let Some(alarm) = filter.last_alarm() else { return };
        let count = usize::try_from(alarm.rerun_samples).unwrap_or(usize::MAX);
        let Some(first) = self.traces.len().checked_sub(count + 1) else { return };
        let from = self.traces[first];
        let mut residuals = Vec::with_capacity(count);
        filter.free_residuals(&from, |residual| residuals.push(residual));
        let (at, size_rad_s) = split(&residuals, 4.0 * alarm.kick_rad_s.abs());
        // Trace `first` stands after sample `first − 1`, so the first one run again is `first`.
        let sample = first + at;
        if let Some(shown) = record.samples.get(sample) {
            let time_s = shown.time_s;
            self.kicks.push(Kick { sample, time_s, size_rad_s, size_sigma_rad_s: f64::INFINITY });
        }
        let mut place = first + 1;
        filter.retrace(&from, |trace| {
            self.traces[place] = trace;
            place += 1;
        });
    }
}

/// Where a run of numbers is best cut in two of different mean, and by how much the second one is
/// larger. Numbers are clipped at ±`limit`.
fn split(numbers: &[Option<f64>], limit: f64) -> (usize, f64) {
    let clipped = |x: &Option<f64>| x.map_or((0.0, 0.0), |x| (1.0, x.clamp(-limit, limit)));
    let add = |sum: (f64, f64), x: (f64, f64)| (sum.0 + x.0, sum.1 + x.1);
    let all = numbers.iter().map(clipped).fold((0.0, 0.0), add);
    let (mut before, mut best, mut cut) = ((0.0, 0.0), f64::NEG_INFINITY, (0, 0.0));
    for (k, x) in numbers.iter().enumerate() {
        let after = (all.0 - before.0, all.1 - before.1);
        if before.0 > 0.0 && after.0 > 0.0 {
            let change = after.1 / after.0 - before.1 / before.0;
            let gain = change * change * before.0 * after.0;
            if gain > best {
                (best, cut) = (gain, (k, change));
            }
        }
        before = add(before, clipped(x));
    }
    cut
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_found_where_it_is() {
        let numbers: Vec<_> = (0..40)
            .map(|k| Some(0.01 * f64::from(k % 3) + if k < 27 { 0.3 } else { 1.3 }))
            .collect();
        let (at, change) = split(&numbers, 10.0);
        assert_eq!(at, 27);
        assert!((change - 1.0).abs() < 0.01, "{change}");
    }

    #[test]
    fn an_outlier_and_a_missing_sample_do_not_move_it() {
        let mut numbers: Vec<_> = (0..40).map(|k| Some(f64::from(u8::from(k >= 27)))).collect();
        (numbers[5], numbers[30]) = (Some(1e6), None);
        assert_eq!(split(&numbers, 4.0).0, 27);
        assert_eq!(split(&[None, None], 1.0), (0, 0.0));
    }
}
