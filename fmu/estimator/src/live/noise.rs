//! How noisy the measured rate is once it swings: the numbers that size the fallback's R.

use crate::state_bytes::{Reader, RestoreError, Writer};

/// Time over which the rate is held against its mean, s: about one swing of a bench body.
const BLOCK_S: f64 = 0.64;
/// Samples that a block has at least; of fewer, a variance says little.
const BLOCK_SAMPLES_MIN: u32 = 8;
/// Blocks of which the largest variance counts.
const BLOCKS: usize = 8;
/// Rates are taken for no larger than this, rad/s, so that no sum of squares can overflow.
const RATE_MAX_RAD_S: f64 = 1e6;

/// Variances of the measured rate over the last blocks of 0.64 s.
///
/// A swing is noise to a filter that knows of none. Two views of it, the larger counts: half the
/// variance of the differences sees what is fast beside a sample, the variance about the mean of
/// the block what is as slow as the swing itself.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct RateNoise {
    block: Block,
    /// Variances of the last blocks, in a ring, rad²/s²; zero where there was none yet.
    variances: [f64; BLOCKS],
    place: usize,
    /// Variance about the straight line of the last block, rad²/s².
    about_line: f64,
}

/// Running sums of a block, about its first rate: a large bias must not cost digits.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Block {
    elapsed_s: f64,
    count: u32,
    first_rad_s: f64,
    last_rad_s: f64,
    sum: f64,
    squares: f64,
    steps: f64,
    step_squares: f64,
    /// Σ k·rate, k counted from the first rate of the block.
    moment: f64,
}

impl Block {
    fn push(&mut self, span_s: f64, rate_rad_s: f64) {
        if self.count == 0 {
            *self = Self { first_rad_s: rate_rad_s, last_rad_s: rate_rad_s, ..Self::default() };
        } else {
            let step = rate_rad_s - self.last_rad_s;
            self.steps += step;
            self.step_squares += step * step;
        }
        let off = rate_rad_s - self.first_rad_s;
        self.moment += f64::from(self.count) * off;
        self.sum += off;
        self.squares += off * off;
        self.last_rad_s = rate_rad_s;
        self.elapsed_s += span_s;
        self.count += 1;
    }

    /// The larger of half the variance of the differences and the variance about the mean.
    fn variance_rad2_s2(&self) -> f64 {
        let n = f64::from(self.count);
        let about_mean = (self.squares - self.sum * self.sum / n) / (n - 1.0);
        let of_steps = (self.step_squares - self.steps * self.steps / (n - 1.0)) / (n - 2.0);
        about_mean.max(0.5 * of_steps).max(0.0)
    }

    /// Variance about the straight line through the rates, which a slow turning leaves alone.
    fn variance_about_line_rad2_s2(&self) -> f64 {
        let n = f64::from(self.count);
        let middle = 0.5 * (n - 1.0);
        let (along, spread) = (self.moment - middle * self.sum, n * (n * n - 1.0) / 12.0);
        let about_mean = self.squares - self.sum * self.sum / n;
        ((about_mean - along * along / spread) / (n - 2.0)).max(0.0)
    }
}

impl RateNoise {
    /// Takes a measured rate, `span_s` after the one before. True when that ends a block.
    #[inline(always)]
    pub(super) fn push(&mut self, span_s: f64, rate_rad_s: f64) -> bool {
        if span_s > BLOCK_S {
            // Rates on both sides of a gap have no common mean.
            self.block.count = 0;
        }
        self.block.push(span_s, rate_rad_s.clamp(-RATE_MAX_RAD_S, RATE_MAX_RAD_S));
        if self.block.elapsed_s < BLOCK_S || self.block.count < BLOCK_SAMPLES_MIN {
            return false;
        }
        self.end_block();
        true
    }

    #[inline(never)]
    fn end_block(&mut self) {
        let variance = self.block.variance_rad2_s2();
        self.about_line = self.block.variance_about_line_rad2_s2();
        self.block.count = 0;
        self.variances[self.place] = variance;
        self.place = (self.place + 1) % BLOCKS;
    }

    /// The largest variance of the last blocks, rad²/s²; zero before the first block has ended.
    pub(super) fn variance_rad2_s2(&self) -> f64 {
        self.variances.iter().copied().fold(0.0, f64::max)
    }

    /// Variance about a straight line of the last block that has ended, rad²/s².
    pub(super) fn latest_about_line_rad2_s2(&self) -> f64 {
        self.about_line
    }

    pub(super) const SAVED_LEN: usize = 4 + 8 * 8 + 8 * BLOCKS + 8 + 8;

    pub(super) fn write(&self, out: &mut Writer<'_>) {
        let b = &self.block;
        out.u32(b.count);
        let sums = [b.sum, b.squares, b.steps, b.step_squares, b.moment];
        for value in [b.elapsed_s, b.first_rad_s, b.last_rad_s].into_iter().chain(sums) {
            out.f64(value);
        }
        self.variances.iter().for_each(|variance| out.f64(*variance));
        out.u64(self.place as u64);
        out.f64(self.about_line);
    }

    pub(super) fn read(bytes: &mut Reader<'_>) -> Result<Self, RestoreError> {
        let mut noise = Self::default();
        noise.block.count = bytes.u32();
        let b = &mut noise.block;
        for value in [
            &mut b.elapsed_s,
            &mut b.first_rad_s,
            &mut b.last_rad_s,
            &mut b.sum,
            &mut b.squares,
            &mut b.steps,
            &mut b.step_squares,
            &mut b.moment,
        ] {
            *value = bytes.finite("block of rates")?;
        }
        for variance in &mut noise.variances {
            *variance = bytes.finite("variance of a block")?;
        }
        noise.place = usize::try_from(bytes.u64()).unwrap_or(BLOCKS);
        noise.about_line = bytes.finite("variance about a line")?;
        let possible = noise.place < BLOCKS && noise.variances.iter().all(|v| *v >= 0.0);
        if possible { Ok(noise) } else { Err(RestoreError::Impossible) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_S: f64 = 0.01;

    fn after(seconds: u32, rate_rad_s: impl Fn(f64) -> f64) -> f64 {
        let mut noise = RateNoise::default();
        for k in 0..100 * seconds {
            noise.push(STEP_S, rate_rad_s(f64::from(k) * STEP_S));
        }
        noise.variance_rad2_s2()
    }

    #[test]
    fn a_swing_of_one_and_a_half_hertz_counts_with_half_its_square() {
        let swing = after(6, |t| 5.0 + 0.02 * libm::sin(9.7 * t));
        // 0.64 s hold 0.988 of a swing: the mean square is off by a share 1/(4π) at most, and
        // n − 1 = 64 samples stand for 65.
        assert!((swing / 2e-4 - 1.0).abs() < 0.1, "{swing}");
    }

    #[test]
    fn what_alternates_from_sample_to_sample_counts_too() {
        let fast =
            after(2, |t| if libm::fmod(libm::rint(t / STEP_S), 2.0) == 0.0 { 1.0 } else { -1.0 });
        // Differences of ±2: half of their variance is 2, twice the variance about the mean.
        assert!((fast - 2.0).abs() < 0.1, "{fast}");
    }

    #[test]
    fn a_gap_does_not_count_as_noise_and_old_noise_is_forgotten() {
        let mut noise = RateNoise::default();
        for k in 0..200_u32 {
            let (span_s, rate) =
                if k == 30 { (10.0, 3.0) } else { (STEP_S, if k < 30 { 0.0 } else { 3.0 }) };
            noise.push(span_s, rate);
        }
        assert!(noise.variance_rad2_s2() < 1e-300, "no rate changed");
        for k in 0..1200_u32 {
            noise.push(STEP_S, if k == 70 { 1.0 } else { 0.0 });
            if k == 140 {
                assert!(noise.variance_rad2_s2() > 0.0);
            }
        }
        assert!(noise.variance_rad2_s2() < 1e-300, "eight blocks later");
    }

    #[test]
    fn slow_turning_is_no_noise_about_a_line() {
        let mut noise = RateNoise::default();
        for k in 0..200_u32 {
            noise.push(STEP_S, 0.3 + 0.02 * f64::from(k) * STEP_S);
        }
        // A slope of 0.02 rad/s² over 0.64 s: variance (0.0128)²/12 about the mean.
        assert!((noise.variance_rad2_s2() / 1.37e-5 - 1.0).abs() < 0.1);
        // Rounding of sums of 64 squares of 0.01.
        assert!(noise.latest_about_line_rad2_s2() < 1e-16);
    }
}
