//! What the innovations of late say of the filter that they came from.

use crate::state_bytes::{Reader, RestoreError, Writer};
use crate::status::{Status, is_unseen};

/// How long a clipped gyro may stay silent, s.
const OVER_RANGE_MAX_S: f64 = 1.0;
/// Samples over which the normalised innovation squared is averaged.
const BLOCK: u32 = 500;
/// Mean over a block beyond which it is not noise: 1 + 6·√(2/500).
const BLOCK_MEAN_MAX: f64 = 1.379_473_319_220_205_5;
/// Alarms in half a period beyond which the model itself is in doubt.
const ALARMS_MAX: usize = 3;

/// Watches the innovations for the status; not part of the estimate.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Watch {
    elapsed_s: f64,
    /// Times of the last alarms, in a ring.
    alarms_s: [f64; ALARMS_MAX + 1],
    alarms: u64,
    /// When a block of innovations was last too large.
    large_block_s: Option<f64>,
    block_sum: f64,
    block_count: u32,
    over_range_s: f64,
}

impl Watch {
    /// A measurement that was taken in, with its normalised innovation squared unless gated.
    #[inline(always)]
    pub(crate) fn used(&mut self, span_s: f64, nis: Option<f64>) {
        self.elapsed_s += span_s;
        self.over_range_s = 0.0;
        if let Some(nis) = nis {
            self.block_sum += nis;
            self.block_count += 1;
            if self.block_count >= BLOCK {
                self.end_block();
            }
        }
    }

    #[inline(never)]
    fn end_block(&mut self) {
        if self.block_sum > BLOCK_MEAN_MAX * f64::from(self.block_count) {
            self.large_block_s = Some(self.elapsed_s);
        }
        (self.block_sum, self.block_count) = (0.0, 0);
    }

    pub(crate) fn over_range(&mut self, span_s: f64) {
        self.elapsed_s += span_s;
        self.over_range_s += span_s;
    }

    pub(crate) fn alarm(&mut self) {
        self.alarms_s[self.ring_place()] = self.elapsed_s;
        self.alarms += 1;
        // The block holds innovations of the belief that was given up.
        (self.block_sum, self.block_count) = (0.0, 0);
    }

    /// Forgets what was disturbed, `passed_s` later; the number of alarms stays.
    pub(super) fn restart(&mut self, passed_s: f64) {
        self.elapsed_s += passed_s;
        self.alarms_s = [f64::MIN; ALARMS_MAX + 1];
        self.large_block_s = None;
        (self.block_sum, self.block_count, self.over_range_s) = (0.0, 0, 0.0);
    }

    /// Where the next alarm goes; the oldest one kept is there now.
    fn ring_place(&self) -> usize {
        usize::try_from(self.alarms % self.alarms_s.len() as u64).unwrap_or(0)
    }

    /// Seconds of measurements so far.
    pub(super) fn elapsed_s(&self) -> f64 {
        self.elapsed_s
    }

    pub(crate) fn alarms(&self) -> u64 {
        self.alarms
    }

    /// Seconds since the last alarm or the end of the last block that was too large.
    fn since_disturbance_s(&self) -> Option<f64> {
        let newest = (self.alarms + self.alarms_s.len() as u64 - 1) % self.alarms_s.len() as u64;
        let newest = usize::try_from(newest).unwrap_or(0);
        let alarm_s = (self.alarms > 0).then(|| self.alarms_s[newest]);
        let last_s = match (alarm_s, self.large_block_s) {
            (Some(alarm_s), Some(block_s)) => alarm_s.max(block_s),
            (either, other) => either.or(other)?,
        };
        Some(self.elapsed_s - last_s)
    }

    fn is_crowded(&self, period_s: f64) -> bool {
        self.alarms > ALARMS_MAX as u64
            && self.elapsed_s - self.alarms_s[self.ring_place()] < 0.5 * period_s
    }

    pub(crate) fn status(&self, angle_variance: f64, period_s: f64, at_bound: bool) -> Status {
        if is_unseen(angle_variance) || at_bound || self.over_range_s > OVER_RANGE_MAX_S {
            return Status::NotObservable;
        }
        if self.is_crowded(period_s) {
            return Status::ModelDoubtful;
        }
        match self.since_disturbance_s() {
            Some(since_s) if since_s < 0.25 * period_s => Status::Disturbed { since_s },
            _ => Status::Nominal,
        }
    }

    pub(crate) const SAVED_LEN: usize = 8 * (1 + ALARMS_MAX + 1 + 1 + 2 + 1 + 1) + 4;

    pub(crate) fn write(&self, out: &mut Writer<'_>) {
        out.f64(self.elapsed_s);
        for alarm_s in self.alarms_s {
            out.f64(alarm_s);
        }
        out.u64(self.alarms);
        out.u64(u64::from(self.large_block_s.is_some()));
        out.f64(self.large_block_s.unwrap_or(0.0));
        out.f64(self.block_sum);
        out.u32(self.block_count);
        out.f64(self.over_range_s);
    }

    pub(crate) fn read(bytes: &mut Reader<'_>) -> Result<Self, RestoreError> {
        let mut watch = Self { elapsed_s: bytes.finite("elapsed_s")?, ..Self::default() };
        for alarm_s in &mut watch.alarms_s {
            *alarm_s = bytes.finite("alarm time")?;
        }
        watch.alarms = bytes.u64();
        let known = bytes.u64() != 0;
        let block_s = bytes.finite("block time")?;
        watch.large_block_s = known.then_some(block_s);
        watch.block_sum = bytes.finite("block sum")?;
        watch.block_count = bytes.u32();
        watch.over_range_s = bytes.finite("over_range_s")?;
        if watch.block_count >= BLOCK || watch.alarms >= u64::MAX / 2 {
            return Err(RestoreError::Impossible);
        }
        Ok(watch)
    }
}
