//! How much larger the innovations are than the noise that was declared.

use crate::augmented::windows::CLIP;
use crate::state_bytes::{Reader, RestoreError, Writer};

/// Samples of three rates in a block.
pub(super) const BLOCK: u32 = 100;
/// Mean over a block beyond which it is not noise. Squares of normal numbers, clipped at 9, have
/// the mean 0.995 and the deviation 1.38; six of its deviations above, of 300 of them.
const LARGE: f64 = 1.473;
/// Most that R is ever multiplied by: the gate's own.
const FACTOR_MAX: f64 = crate::augmented::windows::GATED_VARIANCE;

/// Mean squares of normalised innovations in blocks, and what R is multiplied by for them.
///
/// Squares are clipped as the sums of the windows are, so that neither a kick, which the windows
/// see within a few samples, nor outliers among the rest make a block large; what is noisy for a
/// second does. A clipped mean tells less than the noise is; the next blocks tell the rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Gauge {
    /// What R is multiplied by now, at least 1.
    pub(super) factor: f64,
    sum: f64,
    count: u32,
}

impl Gauge {
    pub(super) const NEW: Self = Self { factor: 1.0, sum: 0.0, count: 0 };

    /// Takes the normalised innovations of a sample. True at the end of a block that was too
    /// large: the samples in it counted too much.
    pub(super) fn is_large(&mut self, normalised: [f64; 3]) -> bool {
        let squares = normalised.map(|n| (n * n).min(CLIP * CLIP));
        self.sum += squares.iter().sum::<f64>() / 3.0;
        self.count += 1;
        if self.count < BLOCK {
            return false;
        }
        let mean = self.sum / f64::from(BLOCK);
        (self.sum, self.count) = (0.0, 0);
        let is_large = mean > LARGE;
        if is_large || self.factor > 1.0 {
            self.factor = (self.factor * mean).clamp(1.0, FACTOR_MAX);
        }
        is_large
    }

    pub(super) const SAVED_LEN: usize = 2 * 8 + 4;

    pub(super) fn write(&self, out: &mut Writer<'_>) {
        out.f64(self.factor);
        out.f64(self.sum);
        out.u32(self.count);
    }

    pub(super) fn read(bytes: &mut Reader<'_>) -> Result<Self, RestoreError> {
        let factor = bytes.finite("factor of R")?;
        let sum = bytes.finite("sum of squares")?;
        let count = bytes.u32();
        let is_possible = (1.0..=FACTOR_MAX).contains(&factor) && sum >= 0.0 && count < BLOCK;
        if is_possible { Ok(Self { factor, sum, count }) } else { Err(RestoreError::Impossible) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `blocks` blocks of one magnitude; how many were large.
    fn blocks(gauge: &mut Gauge, blocks: u32, normalised: f64) -> u32 {
        (0..blocks * BLOCK).map(|_| u32::from(gauge.is_large([normalised; 3]))).sum()
    }

    #[test]
    fn noise_that_goes_on_is_counted_and_forgotten_when_it_ends() {
        let mut gauge = Gauge::NEW;
        assert_eq!(blocks(&mut gauge, 3, 1.0), 0);
        assert!((gauge.factor - 1.0).abs() < 1e-12);
        // Three hundred times the variance, in three blocks of nine at most.
        let excess = 300.0_f64;
        for _ in 0..3 {
            let seen = (excess / gauge.factor).sqrt();
            assert_eq!(blocks(&mut gauge, 1, seen), 1);
        }
        assert!((gauge.factor / excess - 1.0).abs() < 1e-9, "{}", gauge.factor);
        assert_eq!(blocks(&mut gauge, 1, 1.0), 0);
        assert!((gauge.factor / excess - 1.0).abs() < 1e-9, "{}", gauge.factor);
        assert_eq!(blocks(&mut gauge, 1, (1.0 / excess).sqrt()), 0);
        assert!((gauge.factor - 1.0).abs() < 1e-9, "{}", gauge.factor);
    }

    #[test]
    fn a_kick_of_four_samples_and_outliers_make_no_block_large() {
        let mut gauge = Gauge::NEW;
        let large = (0..BLOCK).any(|k| gauge.is_large([if k < 4 { 50.0 } else { 1.0 }; 3]));
        assert!(!large && gauge.factor <= 1.0);
    }

    #[test]
    fn the_factor_has_an_end() {
        let mut gauge = Gauge::NEW;
        blocks(&mut gauge, 20, 1e9);
        assert!(gauge.factor <= FACTOR_MAX, "{}", gauge.factor);
    }
}
