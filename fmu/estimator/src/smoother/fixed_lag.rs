//! The smoother in running form.

use super::backward::BackwardMap;
use super::forward::step;
use super::record::RateSample;
use super::rts::smooth_back;
use crate::augmented::{AugmentedFilter, Trace, WAY_BACK_MAX};
use crate::state_bytes::{Reader, RestoreError, Writer};
use crate::{
    AugmentedConfig, Belief, ConfigError, EstimatorError, InnovationTest, RateEstimator,
    TestedFilter,
};
use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

/// Smooths while it watches: at each sample it says what the sample `lag` samples ago looks like.
///
/// With a lag of seconds little is gained: what tells the angle comes over fractions of a period.
///
/// Steps back in time are affine maps, and a window of them slides by keeping two products: one
/// from now back to a turning point, and for each older sample one from the turning point back to
/// it. When the window has passed the turning point, now becomes the next one and the second kind
/// is made anew. So a sample costs some three products whatever the lag, and one in every `lag`
/// samples (and each alarm) costs `lag` of them. All memory, about 540 bytes for each sample of
/// lag and a megabyte, is allocated when it is made.
#[derive(Debug, Clone)]
pub struct FixedLag {
    filter: TestedFilter,
    lag: u64,
    /// Traces in a ring; number 0 is the start, number k stands after the k-th sample.
    traces: Box<[Trace]>,
    /// Number of the newest trace.
    last: u64,
    /// Number of the turning point.
    turn: u64,
    /// Maps from the turning point to the `lag` numbers before it, in a ring.
    before_turn: Box<[BackwardMap]>,
    /// From the newest trace to the turning point.
    since_turn: BackwardMap,
    /// Time of the lagged trace since the start, s.
    lagged_time_s: f64,
}

/// What is known of an earlier sample.
#[derive(Debug, Clone)]
pub struct LaggedFilter {
    /// When that was, s since the start belief.
    pub time_s: f64,
    /// The filter as it would have stood then, had it known what came since.
    pub filter: AugmentedFilter,
}

impl FixedLag {
    /// Longest lag: an hour at 100 Hz.
    pub const LAG_MAX_SAMPLES: u32 = 360_000;

    /// A smoother with the given prior, noise and test, `lag_samples` behind.
    ///
    /// # Errors
    /// [`ConfigError`] names the value out of its bound.
    pub fn new(
        config: &AugmentedConfig,
        test: &InnovationTest,
        lag_samples: u32,
    ) -> Result<Self, ConfigError> {
        let ok = lag_samples <= Self::LAG_MAX_SAMPLES;
        crate::config::judge("lag_samples", f64::from(lag_samples), ok, "at most 360 000")?;
        let filter = TestedFilter::new(config, test)?;
        let lag = usize::try_from(lag_samples).unwrap_or(usize::MAX);
        let start = filter.trace(0.0);
        Ok(Self {
            lag: u64::from(lag_samples),
            traces: vec![start; lag.max(WAY_BACK_MAX) + 1].into_boxed_slice(),
            last: 0,
            turn: 0,
            before_turn: vec![BackwardMap::IDENTITY; lag].into_boxed_slice(),
            since_turn: BackwardMap::IDENTITY,
            lagged_time_s: 0.0,
            filter,
        })
    }

    /// Takes in a measurement `span_s` after the one before.
    ///
    /// # Errors
    /// What the filter refuses; the smoother is then as it was before the call.
    pub fn step(&mut self, span_s: f64, rate_rad_s: f64) -> Result<(), EstimatorError> {
        self.take(span_s, &RateSample { time_s: 0.0, rate_rad_s, over_range: false })
    }

    /// Notes a measurement that the gyro flags as over range. It is not used.
    ///
    /// # Errors
    /// What the filter refuses; the smoother is then as it was before the call.
    pub fn step_over_range(&mut self, span_s: f64, rate_rad_s: f64) -> Result<(), EstimatorError> {
        self.take(span_s, &RateSample { time_s: 0.0, rate_rad_s, over_range: true })
    }

    fn take(&mut self, span_s: f64, sample: &RateSample) -> Result<(), EstimatorError> {
        let alarms = self.filter.alarms();
        step(&mut self.filter, span_s, sample)?;
        self.last += 1;
        *self.trace_mut(self.last) = self.filter.trace(span_s);
        let alarmed = self.filter.alarms() > alarms;
        if alarmed {
            self.go_back();
        }
        if self.last < self.lag {
            return Ok(());
        }
        let lagged = self.last - self.lag;
        self.lagged_time_s += if lagged > 0 { self.trace(lagged).span_s } else { 0.0 };
        if alarmed || lagged >= self.turn {
            self.turn_here();
        } else {
            self.since_turn = self.map_to(self.last - 1).then(&self.since_turn);
        }
        Ok(())
    }

    /// Replaces the traces of the samples that the filter has just run again.
    fn go_back(&mut self) {
        let count = self.filter.last_alarm().map_or(0, |alarm| u64::from(alarm.rerun_samples));
        let Some(first) = self.last.checked_sub(count) else { return };
        let from = *self.trace(first);
        let (traces, mut number) = (&mut self.traces, first);
        self.filter.retrace(&from, |trace| {
            number += 1;
            let place = place(number, traces.len());
            traces[place] = trace;
        });
    }

    /// Makes the newest trace the turning point.
    fn turn_here(&mut self) {
        self.turn = self.last;
        self.since_turn = BackwardMap::IDENTITY;
        self.fill_before_turn(self.last.saturating_sub(self.lag));
    }

    /// Maps from the turning point to each number from `oldest` on.
    fn fill_before_turn(&mut self, oldest: u64) {
        let mut map = BackwardMap::IDENTITY;
        for number in (oldest..self.turn).rev() {
            map = map.then(&self.map_to(number));
            let place = place(number, self.before_turn.len());
            self.before_turn[place] = map;
        }
    }

    /// The step back to a number from the next.
    fn map_to(&self, number: u64) -> BackwardMap {
        BackwardMap::between(self.filter.filter(), self.trace(number), self.trace(number + 1))
    }

    fn trace(&self, number: u64) -> &Trace {
        &self.traces[place(number, self.traces.len())]
    }

    fn trace_mut(&mut self, number: u64) -> &mut Trace {
        &mut self.traces[place(number, self.traces.len())]
    }

    /// What the sample `lag` samples ago looks like from here; none before there is one. The start
    /// counts as a sample.
    #[must_use]
    pub fn lagged(&self) -> Option<LaggedFilter> {
        let number = self.last.checked_sub(self.lag)?;
        let newest = self.trace(self.last);
        let (mean, covariance) = self.since_turn.apply(&newest.mean(), &newest.covariance());
        let trace = if number < self.turn {
            let to = &self.before_turn[place(number, self.before_turn.len())];
            to.smoothed(self.trace(number), &mean, &covariance)
        } else {
            *newest
        };
        let filter = self.filter.filter().standing_at(&trace);
        Some(LaggedFilter { time_s: self.lagged_time_s, filter })
    }

    /// Angle and rate at the samples after the lagged one, oldest first, as the newest sample lets
    /// them be seen: what is left at the end of a record. Allocates.
    #[must_use]
    pub fn tail(&self) -> Vec<Belief> {
        let oldest = self.last.saturating_sub(self.lag);
        let mut traces: Vec<Trace> =
            (oldest..=self.last).map(|number| *self.trace(number)).collect();
        smooth_back(self.filter.filter(), &mut traces);
        let model = self.filter.filter();
        traces[1..].iter().map(|trace| model.standing_at(trace).belief()).collect()
    }

    /// The filter that runs ahead, without lag.
    #[must_use]
    pub fn filter(&self) -> &TestedFilter {
        &self.filter
    }

    /// How many bytes [`save`](Self::save) writes.
    #[must_use]
    pub fn saved_len(&self) -> usize {
        self.filter.saved_len() + self.traces.len() * Trace::SAVED_LEN + 3 * 8
    }

    /// Writes the state, parameters excluded, into the first [`saved_len`](Self::saved_len) bytes.
    ///
    /// # Panics
    /// When `out` is shorter than [`saved_len`](Self::saved_len).
    pub fn save(&self, out: &mut [u8]) {
        let (filter, rest) = out.split_at_mut(self.filter.saved_len());
        self.filter.save(filter);
        let mut out = Writer::new(rest);
        self.traces.iter().for_each(|trace| trace.write(&mut out));
        out.u64(self.last);
        out.u64(self.turn);
        out.f64(self.lagged_time_s);
    }

    /// Takes over a state written by [`save`](Self::save) of an equally configured smoother.
    ///
    /// # Errors
    /// [`RestoreError`] when the bytes cannot be such a state; the smoother is then unchanged.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        let need = self.saved_len();
        if bytes.len() != need {
            return Err(RestoreError::Length { need, got: bytes.len() });
        }
        let mut restored = self.clone();
        let (filter, rest) = bytes.split_at(self.filter.saved_len());
        restored.filter.restore(filter)?;
        let mut bytes = Reader::new(rest, rest.len())?;
        for trace in &mut restored.traces {
            *trace = Trace::read(&mut bytes)?;
        }
        restored.last = bytes.u64();
        restored.turn = bytes.u64();
        restored.lagged_time_s = bytes.finite("lagged_time_s")?;
        restored.remake_maps()?;
        *self = restored;
        Ok(())
    }

    /// The maps, which follow from the traces.
    fn remake_maps(&mut self) -> Result<(), RestoreError> {
        let oldest = self.last.saturating_sub(self.lag);
        let is_possible = self.last < u64::MAX / 2
            && self.turn <= self.last
            && if self.last < self.lag {
                self.turn == 0
            } else {
                self.turn > oldest || self.lag == 0
            };
        if !is_possible {
            return Err(RestoreError::Impossible);
        }
        self.since_turn = BackwardMap::IDENTITY;
        if self.last >= self.lag {
            self.fill_before_turn(oldest);
            for number in self.turn..self.last {
                self.since_turn = self.map_to(number).then(&self.since_turn);
            }
        }
        Ok(())
    }
}

/// Place of a number in a ring.
fn place(number: u64, ring: usize) -> usize {
    usize::try_from(number % ring as u64).unwrap_or(0)
}
