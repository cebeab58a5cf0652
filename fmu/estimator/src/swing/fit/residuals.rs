//! Whether what a fit leaves is noise.

use super::pass::Budget;
use super::problem::{Problem, Unknowns};
use super::walk::Walk;

/// Lengths of the windows whose mean is tested, samples.
const LENGTHS: [usize; 5] = [8, 32, 128, 512, 1024];
/// Sums kept: those that the longest window reaches back to, and the last one.
const SUMS: usize = 1025;
/// Length of the blocks whose mean square is tested, s.
const BLOCK_S: f64 = 5.0;

/// What a fit leaves, in standard deviations.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Leftover {
    /// Largest mean over a window: |Σr|/√L. 3.4 to 4.3 when the fit is good.
    pub(super) mean_max: f64,
    /// Largest excess of the mean square of a block of 5 s over one.
    pub(super) square_max: f64,
    /// Largest tilt on the way, rad.
    pub(super) tilt_max_rad: f64,
    /// Samples that were there.
    pub(super) samples: usize,
}

/// A walk along the window that looks at each residual.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Inspection {
    walk: Walk,
    at: usize,
    /// Sums of the residuals over √R up to each sample that was there, in a ring.
    sums: [f64; SUMS],
    block: usize,
    block_squares: f64,
    leftover: Leftover,
}

impl Inspection {
    pub(super) fn new(problem: &Problem, u: &Unknowns, period_s: f64) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "the period lies between 1 us and 1 s"
        )]
        let block = libm::round(BLOCK_S / period_s).clamp(1.0, 1e9) as usize;
        Self {
            walk: Walk::new(problem, u),
            at: 0,
            sums: [0.0; SUMS],
            block,
            block_squares: 0.0,
            leftover: Leftover::default(),
        }
    }

    /// Goes on; what was found when the end is reached. A motion that the model does not have is
    /// as bad as it can be.
    pub(super) fn advance(
        &mut self,
        problem: &Problem,
        samples: &[f64],
        budget: &mut Budget,
    ) -> Option<Leftover> {
        while let Some(sample) = samples.get(self.at) {
            if !budget.take() {
                return None;
            }
            if self.at > 0 && !self.walk.step_plainly(problem) {
                self.leftover.mean_max = f64::INFINITY;
                return Some(self.leftover);
            }
            self.at += 1;
            self.leftover.tilt_max_rad = self.leftover.tilt_max_rad.max(self.walk.tilt_rad());
            if sample.is_finite() {
                self.weigh((sample - self.walk.rate_rad_s()) * problem.inverse_noise);
            }
        }
        Some(self.leftover)
    }

    fn weigh(&mut self, residual: f64) {
        let sum = self.sums[self.leftover.samples % SUMS] + residual;
        let count = self.leftover.samples + 1;
        self.sums[count % SUMS] = sum;
        for length in LENGTHS {
            if let Some(before) = count.checked_sub(length) {
                let mean = (sum - self.sums[before % SUMS]).abs() / libm::sqrt(length as f64);
                self.leftover.mean_max = self.leftover.mean_max.max(mean);
            }
        }
        self.block_squares += residual * residual;
        if count.is_multiple_of(self.block) {
            let n = self.block as f64;
            let excess = (self.block_squares / n - 1.0) / libm::sqrt(2.0 / n);
            self.leftover.square_max = self.leftover.square_max.max(excess);
            self.block_squares = 0.0;
        }
        self.leftover.samples = count;
    }
}
