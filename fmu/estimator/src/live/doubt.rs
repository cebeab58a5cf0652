//! Whether the filter of the swinging body still follows it.

use crate::Innovation;
use crate::state_bytes::{Reader, RestoreError, Writer};

/// Samples over which the normalised innovation squared is averaged.
const BLOCK: u32 = 500;
/// Mean over a block beyond which it is not noise: 1 + 6·√(2/500).
const BLOCK_MEAN_MAX: f64 = 1.379_473_319_220_205_5;
/// Normalised innovations squared count as this at most: beyond, they are outliers.
const GATE2: f64 = 25.0;
/// Blocks in a row with too much of it: one may be a blow, which the filter recovers from.
const BLOCKS_LOST: u32 = 2;

/// Mean surprise in blocks of samples.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Doubt {
    sum: f64,
    count: u32,
    large: u32,
}

impl Doubt {
    pub(super) fn push(&mut self, innovation: &Innovation) {
        let nis = innovation.nis();
        // An outlier counts as the gate itself: a filter that is lost may find nothing else.
        self.sum += nis.min(GATE2);
        self.count += 1;
        if self.count >= BLOCK {
            let is_large = self.sum > BLOCK_MEAN_MAX * f64::from(self.count);
            self.large = if is_large { self.large.saturating_add(1) } else { 0 };
            (self.sum, self.count) = (0.0, 0);
        }
    }

    /// Whether two blocks in a row held more surprise than noise can.
    pub(super) fn is_lost(&self) -> bool {
        self.large >= BLOCKS_LOST
    }

    pub(super) const SAVED_LEN: usize = 16;

    pub(super) fn write(&self, out: &mut Writer<'_>) {
        out.f64(self.sum);
        out.u32(self.count);
        out.u32(self.large);
    }

    pub(super) fn read(bytes: &mut Reader<'_>) -> Result<Self, RestoreError> {
        let doubt =
            Self { sum: bytes.finite("block sum")?, count: bytes.u32(), large: bytes.u32() };
        if doubt.count < BLOCK { Ok(doubt) } else { Err(RestoreError::Impossible) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(blocks: &[f64]) -> Doubt {
        let mut doubt = Doubt::default();
        for nis in blocks {
            let surprise = Innovation { residual_rad_s: libm::sqrt(*nis), variance_rad2_s2: 1.0 };
            (0..BLOCK).for_each(|_| doubt.push(&surprise));
        }
        doubt
    }

    #[test]
    fn two_bad_blocks_in_a_row_are_a_filter_that_is_lost() {
        assert!(!after(&[1.0, 1.3, 1.3]).is_lost());
        assert!(!after(&[1.0, 2.0, 1.0, 2.0]).is_lost(), "blows, one at a time");
        assert!(after(&[1.0, 2.0, 1e9]).is_lost());
    }
}
