//! What the last samples were, and where the filter stood: enough to go back and run again.

use super::state::State;
use super::windows::LENGTH_MAX;
use crate::state_bytes::{Reader, RestoreError, Writer};
use alloc::boxed::Box;
use alloc::vec;

/// Samples kept. A window of 2048 goes back over 3072, and to the snapshot before that.
const SAMPLES: usize = 4096;
/// Samples from one snapshot to the next.
const SNAPSHOT_EVERY: u64 = SNAPSHOT_SPACING as u64;
const SNAPSHOT_SPACING: usize = 10;
/// Snapshots kept: enough for the longest way back.
const SNAPSHOTS: usize = 320;
/// How far before the window a re-run starts at least, samples.
const LEAD_MIN: u64 = 20;

const _: () = assert!(SAMPLES.is_power_of_two());
const _: () = assert!(LENGTH_MAX * 3 / 2 + SNAPSHOT_SPACING <= SAMPLES);
const _: () = assert!(LENGTH_MAX * 3 / 2 + SNAPSHOT_SPACING <= SNAPSHOTS * SNAPSHOT_SPACING);

/// A state of a filter, as far as a history needs to know it.
pub(crate) trait Snapshot: Copy {
    /// Bytes that [`write`](Self::write) writes.
    const SAVED_LEN: usize;

    fn write(&self, out: &mut Writer<'_>);

    fn read(bytes: &mut Reader<'_>) -> Result<Self, RestoreError>;
}

impl Snapshot for State {
    const SAVED_LEN: usize = Self::SAVED_LEN;

    fn write(&self, out: &mut Writer<'_>) {
        self.write(out);
    }

    fn read(bytes: &mut Reader<'_>) -> Result<Self, RestoreError> {
        Self::read(bytes)
    }
}

/// One measurement, as it came.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sample {
    /// Seconds since the measurement before.
    pub(crate) span_s: f64,
    /// None when it was over range.
    pub(crate) rate_rad_s: Option<f64>,
    /// Measured minus expected rate when it came, rad/s.
    pub(crate) residual_rad_s: f64,
}

/// Rings of samples, sums of clipped innovations, and snapshots of the state; allocated once.
///
/// Samples are numbered from 1; number 0 is the start. Snapshots lie at the last reset and every
/// ten samples from it.
#[derive(Debug, Clone)]
pub(crate) struct HistoryOf<S> {
    samples: Box<[Sample]>,
    /// Sum of the clipped innovations since the last reset, after each sample.
    sums: Box<[f64]>,
    snapshots: Box<[S]>,
    /// Number of the last sample.
    last: u64,
    /// Number of the sample at which the sums were last reset.
    reset: u64,
    /// Samples until the next snapshot.
    until_snapshot: u64,
}

/// The history of the five-state filter.
pub(super) type History = HistoryOf<State>;

#[expect(clippy::cast_possible_truncation, reason = "the mask keeps it below SAMPLES")]
#[inline(always)]
const fn place(number: u64) -> usize {
    (number & (SAMPLES as u64 - 1)) as usize
}

#[expect(clippy::cast_possible_truncation, reason = "the remainder is below SNAPSHOTS")]
const fn snapshot_place(k: u64) -> usize {
    (k % SNAPSHOTS as u64) as usize
}

impl<S: Snapshot> HistoryOf<S> {
    pub(crate) fn new(start: S) -> Self {
        let none = Sample { span_s: 0.0, rate_rad_s: None, residual_rad_s: 0.0 };
        Self {
            samples: vec![none; SAMPLES].into_boxed_slice(),
            sums: vec![0.0; SAMPLES].into_boxed_slice(),
            snapshots: vec![start; SNAPSHOTS].into_boxed_slice(),
            last: 0,
            reset: 0,
            until_snapshot: SNAPSHOT_EVERY,
        }
    }

    /// Adds a sample with its clipped normalised innovation, and the state after it.
    #[inline(always)]
    pub(crate) fn push(&mut self, sample: Sample, clipped: f64, state: &S) {
        let sum = self.sums[place(self.last)] + clipped;
        self.last += 1;
        let place = place(self.last);
        self.samples[place] = sample;
        self.sums[place] = sum;
        self.until_snapshot -= 1;
        if self.until_snapshot == 0 {
            self.keep_snapshot(state);
        }
    }

    #[inline(never)]
    fn keep_snapshot(&mut self, state: &S) {
        self.until_snapshot = SNAPSHOT_EVERY;
        self.snapshots[snapshot_place((self.last - self.reset) / SNAPSHOT_EVERY)] = *state;
    }

    /// Samples since the last reset, those that no window reaches left out.
    #[inline(always)]
    pub(crate) fn reach(&self) -> usize {
        usize::try_from(self.last - self.reset).map_or(LENGTH_MAX, |n| n.min(LENGTH_MAX))
    }

    /// Sum of the clipped innovations of the last `length` samples.
    #[inline(always)]
    pub(crate) fn sum_over(&self, length: usize) -> f64 {
        self.sums[place(self.last)] - self.sums[place(self.last.wrapping_sub(length as u64))]
    }

    /// Mean residual of the last `length` samples, rad/s.
    pub(crate) fn mean_residual_rad_s(&self, length: usize) -> f64 {
        let first = self.last + 1 - length as u64;
        let sum: f64 = (first..=self.last).map(|k| self.samples[place(k)].residual_rad_s).sum();
        sum / length as f64
    }

    /// Where to start again when a window of `length` samples has raised the alarm: the state of a
    /// snapshot, and how many samples have come since.
    pub(crate) fn way_back(&self, length: usize) -> (S, u64) {
        let length = length as u64;
        let back = length + LEAD_MIN.max(length / 2);
        let wanted = (self.last - self.reset).saturating_sub(back) / SNAPSHOT_EVERY;
        let number = self.reset + wanted * SNAPSHOT_EVERY;
        (self.snapshots[snapshot_place(wanted)], self.last - number)
    }

    /// The last `count` samples, oldest first.
    pub(crate) fn latest(&self, count: u64) -> impl Iterator<Item = &Sample> {
        (self.last + 1 - count..=self.last).map(|k| &self.samples[place(k)])
    }

    /// Forgets all before now: windows start afresh, and `state` is the first snapshot.
    pub(crate) fn reset(&mut self, state: &S) {
        self.reset = self.last;
        self.sums[place(self.last)] = 0.0;
        self.until_snapshot = SNAPSHOT_EVERY;
        self.snapshots[0] = *state;
    }

    pub(crate) const SAVED_LEN: usize = SAMPLES * 4 * 8 + SNAPSHOTS * S::SAVED_LEN + 3 * 8;

    pub(crate) fn write(&self, out: &mut Writer<'_>) {
        for (sample, sum) in self.samples.iter().zip(&self.sums) {
            out.f64(sample.span_s);
            // No measured rate is as large: its residual could not be squared.
            out.f64(sample.rate_rad_s.unwrap_or(f64::MAX));
            out.f64(sample.residual_rad_s);
            out.f64(*sum);
        }
        for snapshot in &self.snapshots {
            snapshot.write(out);
        }
        out.u64(self.last);
        out.u64(self.reset);
        out.u64(self.until_snapshot);
    }

    /// Reads everything before it takes over anything.
    pub(crate) fn read(bytes: &mut Reader<'_>, start: S) -> Result<Self, RestoreError> {
        let mut history = Self::new(start);
        for (sample, sum) in history.samples.iter_mut().zip(&mut history.sums) {
            sample.span_s = bytes.finite("span_s")?;
            let rate_rad_s = bytes.finite("stored rate")?;
            sample.rate_rad_s = (rate_rad_s < f64::MAX).then_some(rate_rad_s);
            sample.residual_rad_s = bytes.finite("stored residual")?;
            *sum = bytes.finite("sum of innovations")?;
        }
        for snapshot in &mut history.snapshots {
            *snapshot = S::read(bytes)?;
        }
        history.last = bytes.u64();
        history.reset = bytes.u64();
        history.until_snapshot = bytes.u64();
        if history.is_possible() { Ok(history) } else { Err(RestoreError::Impossible) }
    }

    /// Whether the counters are those of a running filter.
    fn is_possible(&self) -> bool {
        let since = self.last.wrapping_sub(self.reset);
        self.reset <= self.last
            && self.last < u64::MAX / 2
            && self.until_snapshot == SNAPSHOT_EVERY - since % SNAPSHOT_EVERY
    }
}
