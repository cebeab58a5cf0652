//! The last samples of three rates, and where the filter stood: enough to go back and run again.

use crate::augmented::history::Snapshot;
use crate::state_bytes::{Reader, RestoreError, Writer};
use crate::swing::filter::gaussian::Gaussian;
use alloc::boxed::Box;
use alloc::vec;

/// Samples kept.
const SAMPLES: u16 = 512;
/// Samples from one snapshot to the next.
const SNAPSHOT_EVERY: u16 = 16;
/// Snapshots kept.
const SNAPSHOTS: u16 = 32;
/// Longest window, samples. Three rates show a kick at once, and smaller ones than a window of
/// this length sees are below what a kick is reckoned with at least.
pub(super) const REACH: u16 = 256;
/// Longest way back, samples: the window, half of it before, and on to the snapshot before that.
const WAY_BACK_MAX: u16 = REACH + REACH / 2 + SNAPSHOT_EVERY;

const _: () = assert!(WAY_BACK_MAX <= SAMPLES && WAY_BACK_MAX <= SNAPSHOTS * SNAPSHOT_EVERY);

/// One measurement of three rates, as it came.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Taken {
    /// Seconds since the measurement before.
    pub(super) span_s: f64,
    /// Measured rates, rad/s.
    pub(super) rates_rad_s: [f64; 3],
    /// Measured minus expected rates when they came, rad/s.
    pub(super) residuals_rad_s: [f64; 3],
    /// Sums of the clipped normalised innovations since the last reset, this one included.
    sums: [f64; 3],
}

impl Taken {
    pub(super) const fn new(span_s: f64, rates_rad_s: [f64; 3], residuals_rad_s: [f64; 3]) -> Self {
        Self { span_s, rates_rad_s, residuals_rad_s, sums: [0.0; 3] }
    }

    const SAVED_LEN: usize = 10 * 8;

    fn write(&self, out: &mut Writer<'_>) {
        out.f64(self.span_s);
        for number in [self.rates_rad_s, self.residuals_rad_s, self.sums].into_iter().flatten() {
            out.f64(number);
        }
    }

    fn read(bytes: &mut Reader<'_>) -> Result<Self, RestoreError> {
        let mut taken = Self { span_s: bytes.finite("span_s")?, ..Self::default() };
        let of_three = [&mut taken.rates_rad_s, &mut taken.residuals_rad_s, &mut taken.sums];
        for number in of_three.into_iter().flatten() {
            *number = bytes.finite("stored rate, residual or sum")?;
        }
        Ok(taken)
    }
}

/// Rings of samples and snapshots; allocated once.
///
/// Samples are numbered from 1; number 0 is the start. Snapshots lie at the last reset and every
/// sixteen samples from it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Past {
    samples: Box<[Taken]>,
    snapshots: Box<[Gaussian]>,
    /// Number of the last sample.
    last: u64,
    /// Number of the sample at which everything before was forgotten.
    reset: u64,
}

fn place(number: u64) -> usize {
    usize::try_from(number % u64::from(SAMPLES)).unwrap_or(0)
}

fn snapshot_place(k: u64) -> usize {
    usize::try_from(k % u64::from(SNAPSHOTS)).unwrap_or(0)
}

impl Past {
    pub(super) fn new(start: Gaussian) -> Self {
        Self {
            samples: vec![Taken::default(); usize::from(SAMPLES)].into_boxed_slice(),
            snapshots: vec![start; usize::from(SNAPSHOTS)].into_boxed_slice(),
            last: 0,
            reset: 0,
        }
    }

    /// Adds a sample with its clipped normalised innovations, and the state after it.
    pub(super) fn push(&mut self, taken: Taken, clipped: [f64; 3], state: &Gaussian) {
        let before = self.samples[place(self.last)].sums;
        let sums = core::array::from_fn(|axis| before[axis] + clipped[axis]);
        self.last += 1;
        self.samples[place(self.last)] = Taken { sums, ..taken };
        let (since, every) = (self.last - self.reset, u64::from(SNAPSHOT_EVERY));
        if since.is_multiple_of(every) {
            self.snapshots[snapshot_place(since / every)] = *state;
        }
    }

    /// Samples since the start.
    pub(super) const fn samples(&self) -> u64 {
        self.last
    }

    /// Samples since the last reset, those that no window reaches left out.
    pub(super) fn reach(&self) -> usize {
        let reach = usize::from(REACH);
        usize::try_from(self.last - self.reset).map_or(reach, |n| n.min(reach))
    }

    /// Sum of the clipped innovations of one axis over the last `length` samples. One that reaches
    /// behind the reset is a number without a meaning.
    pub(super) fn sum_over(&self, axis: usize, length: usize) -> f64 {
        let before = self.last.wrapping_sub(length as u64);
        self.samples[place(self.last)].sums[axis] - self.samples[place(before)].sums[axis]
    }

    /// Mean residuals of the last `length` samples, rad/s.
    pub(super) fn mean_residuals_rad_s(&self, length: usize) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for taken in self.latest(length as u64) {
            for (sum, residual_rad_s) in sums.iter_mut().zip(taken.residuals_rad_s) {
                *sum += residual_rad_s;
            }
        }
        sums.map(|sum| sum / length as f64)
    }

    /// The state of the snapshot that lies `back` samples ago or just before, at the last reset at
    /// most, and how many samples have come since.
    pub(super) fn way_back(&self, back: u64) -> (Gaussian, u64) {
        let back = back.min(u64::from(WAY_BACK_MAX - SNAPSHOT_EVERY));
        let wanted = (self.last - self.reset).saturating_sub(back) / u64::from(SNAPSHOT_EVERY);
        let number = self.reset + wanted * u64::from(SNAPSHOT_EVERY);
        (self.snapshots[snapshot_place(wanted)], self.last - number)
    }

    /// The last `count` samples, oldest first.
    pub(super) fn latest(&self, count: u64) -> impl Iterator<Item = &Taken> {
        (self.last + 1 - count..=self.last).map(|number| &self.samples[place(number)])
    }

    /// Forgets all before now: windows start afresh, and `state` is the first snapshot.
    pub(super) fn reset(&mut self, state: &Gaussian) {
        self.reset = self.last;
        self.samples[place(self.last)].sums = [0.0; 3];
        self.snapshots[0] = *state;
    }

    pub(super) const SAVED_LEN: usize =
        SAMPLES as usize * Taken::SAVED_LEN + SNAPSHOTS as usize * Gaussian::SAVED_LEN + 2 * 8;

    pub(super) fn write(&self, out: &mut Writer<'_>) {
        self.samples.iter().for_each(|taken| taken.write(out));
        self.snapshots.iter().for_each(|state| state.write(out));
        out.u64(self.last);
        out.u64(self.reset);
    }

    /// Reads everything before it takes over anything.
    pub(super) fn read(bytes: &mut Reader<'_>, start: Gaussian) -> Result<Self, RestoreError> {
        let mut past = Self::new(start);
        for taken in &mut past.samples {
            *taken = Taken::read(bytes)?;
        }
        for snapshot in &mut past.snapshots {
            *snapshot = Gaussian::read(bytes)?;
        }
        past.last = bytes.u64();
        past.reset = bytes.u64();
        let is_possible = past.reset <= past.last && past.last < u64::MAX / 2;
        if is_possible { Ok(past) } else { Err(RestoreError::Impossible) }
    }
}
