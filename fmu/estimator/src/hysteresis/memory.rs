//! What the bank keeps to go back and run again: its last samples, and where it stood.

use super::member::Seats;
use crate::state_bytes::{Reader, RestoreError, Writer};
use alloc::boxed::Box;
use alloc::vec;

/// Longest window that the bank tests, samples. A re-run costs all members again: with longer
/// windows one would take longer than a sample.
pub(super) const WINDOW_MAX: usize = 256;
/// Samples from one checkpoint to the next: a window and what lies before it.
const SPACING: u64 = 512;
/// Samples kept: two checkpoints' worth.
const SAMPLES: usize = 1024;
/// How far before the window the rate is widened at least, samples.
const LEAD_MIN: u64 = 20;

const _: () = assert!(SAMPLES.is_power_of_two() && SAMPLES as u64 == 2 * SPACING);
const _: () = assert!((WINDOW_MAX * 3 / 2) as u64 <= SPACING);

/// One measurement, as it came.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sample {
    /// Seconds since the measurement before.
    pub(super) span_s: f64,
    /// None when it was left out.
    pub(super) rate_rad_s: Option<f64>,
    /// Measured minus expected rate when it came, rad/s.
    pub(super) residual_rad_s: f64,
}

impl Sample {
    const NONE: Self = Self { span_s: 0.0, rate_rad_s: None, residual_rad_s: 0.0 };
}

/// Rings of samples and of sums of clipped innovations, and two checkpoints; allocated once.
///
/// Samples are numbered from 1; number 0 is the start. Checkpoints lie at the last reset and every
/// [`SPACING`] samples from it; the two latest are kept.
#[derive(Debug, Clone)]
pub(super) struct Memory {
    samples: Box<[Sample]>,
    /// Sum of the clipped innovations since the last reset, after each sample.
    sums: Box<[f64]>,
    older: Seats,
    newer: Seats,
    /// Number of the last sample.
    last: u64,
    /// Number of the sample at which the sums were last reset.
    reset: u64,
}

/// Where to start again.
pub(super) struct WayBack<'a> {
    pub(super) seats: &'a Seats,
    /// Samples since the checkpoint.
    pub(super) count: u64,
    /// Samples, the last of those, in which the kick may have come.
    pub(super) doubted: u64,
}

#[expect(clippy::cast_possible_truncation, reason = "the mask keeps it below SAMPLES")]
const fn place(number: u64) -> usize {
    (number & (SAMPLES as u64 - 1)) as usize
}

impl Memory {
    pub(super) fn new(start: &Seats) -> Self {
        Self {
            samples: vec![Sample::NONE; SAMPLES].into_boxed_slice(),
            sums: vec![0.0; SAMPLES].into_boxed_slice(),
            older: start.clone(),
            newer: start.clone(),
            last: 0,
            reset: 0,
        }
    }

    /// As new, with these members.
    pub(super) fn clear(&mut self, start: &Seats) {
        self.samples.fill(Sample::NONE);
        self.sums.fill(0.0);
        self.last = 0;
        self.reset(start);
    }

    /// Adds a sample with its clipped normalised innovation, and the members after it.
    #[inline]
    pub(super) fn push(&mut self, sample: Sample, clipped: f64, seats: &Seats) {
        let sum = self.sums[place(self.last)] + clipped;
        self.last += 1;
        self.samples[place(self.last)] = sample;
        self.sums[place(self.last)] = sum;
        if (self.last - self.reset).is_multiple_of(SPACING) {
            core::mem::swap(&mut self.older, &mut self.newer);
            self.newer.clone_from(seats);
        }
    }

    /// Samples since the last reset, those that no window reaches left out.
    #[inline]
    pub(super) fn reach(&self) -> usize {
        usize::try_from(self.last - self.reset).map_or(WINDOW_MAX, |n| n.min(WINDOW_MAX))
    }

    /// Sum of the clipped innovations of the last `length` samples, of those that are kept.
    #[inline]
    pub(super) fn sum_over(&self, length: usize) -> f64 {
        self.sums[place(self.last)] - self.sums[place(self.last.wrapping_sub(length as u64))]
    }

    /// Mean residual of the last `length` samples, rad/s.
    pub(super) fn mean_residual_rad_s(&self, length: usize) -> f64 {
        let sum: f64 = self.latest(length as u64).map(|sample| sample.residual_rad_s).sum();
        sum / length as f64
    }

    /// Numbers of the two checkpoints.
    fn checkpoints(&self) -> (u64, u64) {
        let newer = self.last - (self.last - self.reset) % SPACING;
        (newer.saturating_sub(SPACING).max(self.reset), newer)
    }

    /// Where to start again when a window of `length` samples has raised the alarm.
    pub(super) fn way_back(&self, length: usize) -> WayBack<'_> {
        let length = length as u64;
        let doubted = (length + LEAD_MIN.max(length / 2)).min(self.last - self.reset);
        let (older, newer) = self.checkpoints();
        if newer <= self.last - doubted {
            WayBack { seats: &self.newer, count: self.last - newer, doubted }
        } else {
            WayBack { seats: &self.older, count: self.last - older, doubted }
        }
    }

    /// The last `count` samples, oldest first.
    pub(super) fn latest(&self, count: u64) -> impl Iterator<Item = &Sample> {
        (self.last + 1 - count..=self.last).map(|k| &self.samples[place(k)])
    }

    /// Forgets all before now: windows start afresh from here.
    pub(super) fn reset(&mut self, seats: &Seats) {
        self.reset = self.last;
        self.sums[place(self.last)] = 0.0;
        self.older.clone_from(seats);
        self.newer.clone_from(seats);
    }

    pub(super) fn saved_len(&self) -> usize {
        SAMPLES * 4 * 8 + self.older.saved_len() + self.newer.saved_len() + 2 * 8
    }

    pub(super) fn write(&self, out: &mut Writer<'_>) {
        for (sample, sum) in self.samples.iter().zip(&self.sums) {
            out.f64(sample.span_s);
            // No measured rate is as large: its residual could not be squared.
            out.f64(sample.rate_rad_s.unwrap_or(f64::MAX));
            out.f64(sample.residual_rad_s);
            out.f64(*sum);
        }
        self.older.write(out);
        self.newer.write(out);
        out.u64(self.last);
        out.u64(self.reset);
    }

    pub(super) fn read(&mut self, bytes: &mut Reader<'_>) -> Result<(), RestoreError> {
        for (sample, sum) in self.samples.iter_mut().zip(&mut self.sums) {
            sample.span_s = bytes.finite("span_s")?;
            let rate_rad_s = bytes.finite("stored rate")?;
            sample.rate_rad_s = (rate_rad_s < f64::MAX).then_some(rate_rad_s);
            sample.residual_rad_s = bytes.finite("stored residual")?;
            *sum = bytes.finite("sum of innovations")?;
        }
        self.older.read(bytes)?;
        self.newer.read(bytes)?;
        (self.last, self.reset) = (bytes.u64(), bytes.u64());
        let possible = self.reset <= self.last && self.last < u64::MAX / 2;
        if possible { Ok(()) } else { Err(RestoreError::Impossible) }
    }
}
