//! Levenberg-Marquardt on the normal equations.

use super::cholesky::{Cholesky, Square};
use super::pass::{Budget, Pass, Reached};
use super::problem::{Problem, UNKNOWNS, Unknowns};

/// Damping at the start, in units of the diagonal; and the largest, beyond which nothing is gained.
const DAMPING: (f64, f64) = (1e-3, 1e7);
/// The damping after a step that failed, and after one that held: times this, divided by that.
const DAMPING_STEP: (f64, f64) = (8.0, 10.0);

/// Steps after which what a descent promises is believed: the first ones lead anywhere.
const STEPS_TO_JUDGE: u32 = 2;

/// Where a descent goes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ground<'a> {
    pub(super) problem: &'a Problem,
    /// The window.
    pub(super) samples: &'a [f64],
    pub(super) patience: Patience,
    /// Cost of a bottom that would not be kept.
    pub(super) hopeless: f64,
}

/// When a descent has come far enough.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Patience {
    /// Fall of the cost that is not worth another step.
    pub(super) fall: f64,
    /// Steps that may be tried.
    pub(super) steps: u32,
}

/// How a descent stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Descending {
    /// The budget is spent.
    Budget,
    /// At the bottom, or out of patience.
    Done,
    /// The model has no such motion, the numbers have none, or the bottom is hopelessly high:
    /// nothing to keep.
    Lost,
}

/// The descent of one start to the bottom of its valley.
///
/// Each step costs one walk along the window: cost and normal equations come from the same pass,
/// and a step that climbs is noticed, and left, as soon as its sum passes the cost to beat.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Descent {
    best: Pass,
    damping: f64,
    steps: u32,
}

impl Descent {
    pub(super) fn new(problem: &Problem, u: Unknowns) -> Self {
        Self { best: Pass::new(problem, u), damping: DAMPING.0, steps: 0 }
    }

    /// The lowest point so far, with its normal equations over the window.
    pub(super) fn best(&self) -> &Pass {
        &self.best
    }

    /// Starts anew from where it is, for a window that has grown.
    pub(super) fn again(&mut self) {
        (self.damping, self.steps) = (DAMPING.0, 0);
    }

    /// Goes on until the bottom is reached or the budget is spent. A step under way is left in
    /// `trial`, and taken from there.
    pub(super) fn advance(
        &mut self,
        trial: &mut Option<Pass>,
        ground: &Ground<'_>,
        budget: &mut Budget,
    ) -> Descending {
        let Ground { problem, samples, .. } = *ground;
        match self.best.advance(problem, samples, f64::MAX, budget) {
            Reached::Budget => return Descending::Budget,
            Reached::Limit => return Descending::Lost,
            Reached::End => {}
        }
        loop {
            let mut next = match trial.take() {
                Some(trial) => trial,
                None => match self.propose(ground) {
                    Ok(next) => next,
                    Err(descending) => return descending,
                },
            };
            match next.advance(problem, samples, self.best.cost(), budget) {
                Reached::Budget => {
                    *trial = Some(next);
                    return Descending::Budget;
                }
                Reached::Limit => self.damping *= DAMPING_STEP.0,
                Reached::End => {
                    self.best = next;
                    self.damping /= DAMPING_STEP.1;
                }
            }
        }
    }

    /// The next point to try; at the bottom, and where it is hopeless, what to say of it.
    ///
    /// The bottom is where the undamped step promises nothing. What a damped one promises says
    /// little: along a flat valley, where only the prior has a say, the damping all but stops it.
    fn propose(&mut self, ground: &Ground<'_>) -> Result<Pass, Descending> {
        let Ground { problem, patience, hopeless, .. } = *ground;
        let (normal, slope) = (self.best.normal(), self.best.descent());
        let promised = Cholesky::of(normal).map(|root| root.forward(slope));
        if let Some(fall) = promised.map(|y| y.iter().map(|y| y * y).sum::<f64>()) {
            if fall < patience.fall {
                return Err(Descending::Done);
            }
            if self.steps >= STEPS_TO_JUDGE && self.best.cost() - fall > hopeless {
                return Err(Descending::Lost);
            }
        }
        while self.steps < patience.steps && self.damping < DAMPING.1 {
            self.steps += 1;
            if let Some(root) = Cholesky::of(&damped(normal, self.damping)) {
                let step = root.solve(slope);
                let u = core::array::from_fn(|i| self.best.unknowns()[i] + step[i]);
                return Ok(Pass::new(problem, problem.within_bounds(u)));
            }
            self.damping *= DAMPING_STEP.0;
        }
        Err(Descending::Done)
    }
}

/// The normal matrix with its diagonal raised.
fn damped(normal: &Square<UNKNOWNS>, damping: f64) -> Square<UNKNOWNS> {
    let mut damped = *normal;
    for (i, row) in damped.iter_mut().enumerate() {
        row[i] *= 1.0 + damping;
    }
    damped
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::swing::fit::problem::G1;
    use crate::swing::fit::problem::tests::problem;

    /// A descent of a body at rest that is taken to be one sigma off in each unknown but the axis.
    fn descent(problem: &Problem, hopeless: f64, steps: u32) -> (Descending, f64) {
        let mut u = [1.0; UNKNOWNS];
        (u[G1], u[G1 + 1]) = (0.0, 0.0);
        let samples = [0.0; 400];
        let patience = Patience { fall: 1e-3, steps };
        let ground = Ground { problem, samples: &samples, patience, hopeless };
        let mut descent = Descent::new(problem, u);
        let descending = descent.advance(&mut None, &ground, &mut Budget(usize::MAX));
        (descending, descent.best().cost())
    }

    #[test]
    fn a_descent_comes_to_the_bottom_unless_even_that_would_not_be_kept() {
        let problem = problem();
        let (descending, bottom) = descent(&problem, f64::INFINITY, 60);
        // At rest nothing is left of 400 samples, and the prior has nothing against it.
        assert_eq!(descending, Descending::Done);
        assert!(bottom < 1.0, "{bottom}");
        // What is promised on the way is not below the bottom by much, nor above it for long.
        assert_eq!(descent(&problem, bottom + 10.0, 60).0, Descending::Done);
        let (descending, cost) = descent(&problem, -1e30, 60);
        assert_eq!(descending, Descending::Lost);
        assert!(cost > bottom, "it was given up before the bottom");
        // Out of steps before it is judged.
        assert_eq!(descent(&problem, -1e30, STEPS_TO_JUDGE - 1).0, Descending::Done);
    }
}
