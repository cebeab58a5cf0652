//! Whether the best end of the last window is taken.

use super::AcceptedFit;
use super::cholesky::Cholesky;
use super::levenberg::Descent;
use super::outcome::Rejection;
use super::plan::{COST_MAX, COST_UNDECIDED, LEFTOVER_MEAN_MAX, LEFTOVER_SQUARE_MAX, TWIST_APART};
use super::problem::{Problem, TWIST};
use super::residuals::Leftover;
use crate::swing::SwingBelief;

/// What the last window came to, before it is judged.
#[derive(Debug, Clone, Copy)]
pub(super) struct Verdict<'a> {
    pub(super) problem: &'a Problem,
    /// Distinct ends, the best one first.
    pub(super) ends: &'a [Descent],
    /// What the best one leaves.
    pub(super) leftover: Leftover,
    /// Samples of the window.
    pub(super) window: usize,
}

impl Verdict<'_> {
    /// The fit, if it passes every test.
    pub(super) fn fit(
        &self,
        samples: u64,
        restarts: u32,
        dense: bool,
    ) -> Result<AcceptedFit, Rejection> {
        let missing = self.window - self.leftover.samples.min(self.window);
        if missing > self.window / 10 {
            return Err(Rejection::TooManyMissing { missing });
        }
        let best = self.ends.first().ok_or(Rejection::NoMotion)?.best();
        let cost_per_sample = best.cost() / self.leftover.samples as f64;
        if cost_per_sample.is_nan() || cost_per_sample >= COST_MAX {
            return Err(Rejection::Cost { cost_per_sample });
        }
        let Leftover { mean_max: mean, square_max: square, tilt_max_rad, .. } = self.leftover;
        if !(mean < LEFTOVER_MEAN_MAX && square < LEFTOVER_SQUARE_MAX) {
            return Err(Rejection::Leftover { mean, square });
        }
        let x = self.problem.x(best.unknowns());
        let mean_now = best.walk().unknowns_now(&x);
        let root = Cholesky::of(best.normal()).ok_or(Rejection::NoMotion)?;
        let covariance = root.covariance_of(&best.walk().derivatives_now(self.problem));
        self.check_alone(mean_now[TWIST], libm::sqrt(covariance[TWIST][TWIST]))?;
        Ok(AcceptedFit {
            samples,
            belief: SwingBelief { mean: mean_now, covariance },
            cost_per_sample,
            leftover_mean: mean,
            leftover_square: square,
            amplitude_rad: tilt_max_rad,
            modes: self.ends.len(),
            restarts,
            dense,
        })
    }

    /// Refuses a best end whose twist another end, about as good, contradicts.
    ///
    /// Mirror images of the swing, when the misalignment is hardly known, agree in twist.
    fn check_alone(&self, twist_rad: f64, sigma_rad: f64) -> Result<(), Rejection> {
        let [best, others @ ..] = self.ends else {
            return Err(Rejection::NoMotion);
        };
        for other in others {
            let cost = other.best().cost() - best.best().cost();
            let x = self.problem.x(other.best().unknowns());
            let apart_rad = (other.best().walk().unknowns_now(&x)[TWIST] - twist_rad).abs();
            if cost < COST_UNDECIDED && apart_rad > TWIST_APART * sigma_rad {
                return Err(Rejection::Ambiguous { apart_rad, cost });
            }
        }
        Ok(())
    }
}
