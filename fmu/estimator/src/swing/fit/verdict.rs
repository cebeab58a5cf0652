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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::swing::fit::problem::tests::problem;
    use crate::swing::fit::problem::{EX, UNKNOWNS};
    use std::vec::Vec;

    const GOOD: Leftover =
        Leftover { mean_max: 4.0, square_max: 1.0, tilt_max_rad: 0.1, samples: 6000 };

    /// The verdict on ends that differ from the prior by so many sigmas in one unknown each.
    fn verdict(ends: &[(usize, f64)], leftover: Leftover) -> Result<AcceptedFit, Rejection> {
        let problem = problem();
        let ends: Vec<Descent> = ends
            .iter()
            .map(|(unknown, sigmas)| {
                let mut u = [0.0; UNKNOWNS];
                u[*unknown] = *sigmas;
                Descent::new(&problem, u)
            })
            .collect();
        Verdict { problem: &problem, ends: &ends, leftover, window: 6000 }.fit(6000, 0, false)
    }

    #[test]
    fn a_good_end_is_taken_with_the_claim_of_its_normal_equations() {
        let fit = verdict(&[(EX, 1.0)], GOOD).unwrap();
        // Without a sample the claim is the prior: 100 degrees of twist.
        let sigma = fit.belief.covariance[TWIST][TWIST].sqrt().to_degrees();
        assert!((sigma - 100.0).abs() < 1e-9, "{sigma}");
        assert!((fit.belief.mean[EX] - 0.1).abs() < 1e-12);
    }

    #[test]
    fn what_is_left_must_be_noise() {
        for (leftover, accepted) in [
            (GOOD, true),
            (Leftover { mean_max: 5.3, ..GOOD }, false),
            (Leftover { mean_max: f64::INFINITY, ..GOOD }, false),
            (Leftover { square_max: 5.1, ..GOOD }, false),
            (Leftover { square_max: f64::NAN, ..GOOD }, false),
            (Leftover { samples: 5401, ..GOOD }, true),
            (Leftover { samples: 5399, ..GOOD }, false),
        ] {
            assert_eq!(verdict(&[(EX, 1.0)], leftover).is_ok(), accepted, "{leftover:?}");
        }
        // A cost of 82² over 6000 samples is 1.121.
        assert!(matches!(verdict(&[(EX, 82.0)], GOOD), Err(Rejection::Cost { .. })));
        assert!(verdict(&[(EX, 81.9)], GOOD).is_ok());
        assert_eq!(verdict(&[], GOOD), Err(Rejection::NoMotion));
    }

    #[test]
    fn another_twist_that_fits_as_well_is_another_answer() {
        let rejection = verdict(&[(EX, 0.0), (TWIST, 4.0)], GOOD).unwrap_err();
        assert!(matches!(rejection, Rejection::Ambiguous { .. }), "{rejection}");
        // A worse one, a mirror image, and a twist that is hardly another.
        for (unknown, sigmas) in [(TWIST, 5.1), (EX, 4.0), (TWIST, 2.9)] {
            assert!(verdict(&[(EX, 0.0), (unknown, sigmas)], GOOD).is_ok(), "{unknown} {sigmas}");
        }
    }
}
