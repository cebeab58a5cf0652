//! Levenberg-Marquardt on the normal equations.

use super::cholesky::{Cholesky, Square};
use super::pass::{Budget, Pass, Reached};
use super::problem::{Problem, UNKNOWNS, Unknowns};

/// Damping at the start, in units of the diagonal; and the largest, beyond which nothing is gained.
const DAMPING: (f64, f64) = (1e-3, 1e7);
/// The damping after a step that failed, and after one that held: times this, divided by that.
const DAMPING_STEP: (f64, f64) = (8.0, 10.0);

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
    /// The model has no such motion, or the numbers have none: nothing to keep.
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
        (problem, samples): (&Problem, &[f64]),
        patience: Patience,
        budget: &mut Budget,
    ) -> Descending {
        match self.best.advance(problem, samples, f64::MAX, budget) {
            Reached::Budget => return Descending::Budget,
            Reached::Limit => return Descending::Lost,
            Reached::End => {}
        }
        loop {
            let next = trial.take().or_else(|| self.propose(problem, patience));
            let Some(mut next) = next else {
                return Descending::Done;
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

    /// The next point to try; none at the bottom.
    ///
    /// The bottom is where the undamped step promises nothing. What a damped one promises says
    /// little: along a flat valley, where only the prior has a say, the damping all but stops it.
    fn propose(&mut self, problem: &Problem, patience: Patience) -> Option<Pass> {
        let (normal, slope) = (self.best.normal(), self.best.descent());
        let promised = Cholesky::of(normal).map(|root| root.forward(slope));
        if promised.is_some_and(|y| y.iter().map(|y| y * y).sum::<f64>() < patience.fall) {
            return None;
        }
        while self.steps < patience.steps && self.damping < DAMPING.1 {
            self.steps += 1;
            if let Some(root) = Cholesky::of(&damped(normal, self.damping)) {
                let step = root.solve(slope);
                let u = core::array::from_fn(|i| self.best.unknowns()[i] + step[i]);
                return Some(Pass::new(problem, problem.within_bounds(u)));
            }
            self.damping *= DAMPING_STEP.0;
        }
        None
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
