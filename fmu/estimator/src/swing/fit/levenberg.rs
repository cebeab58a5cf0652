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
    trial: Option<Pass>,
    damping: f64,
    steps: u32,
}

impl Descent {
    pub(super) fn new(problem: &Problem, u: Unknowns) -> Self {
        Self { best: Pass::new(problem, u), trial: None, damping: DAMPING.0, steps: 0 }
    }

    /// The lowest point so far, with its normal equations over the window.
    pub(super) fn best(&self) -> &Pass {
        &self.best
    }

    /// Starts anew from where it is, for a window that has grown.
    pub(super) fn again(&mut self) {
        (self.trial, self.damping, self.steps) = (None, DAMPING.0, 0);
    }

    /// Goes on until the bottom is reached or the budget is spent.
    pub(super) fn advance(
        &mut self,
        problem: &Problem,
        samples: &[f64],
        patience: Patience,
        budget: &mut Budget,
    ) -> Descending {
        match self.best.advance(problem, samples, f64::MAX, budget) {
            Reached::Budget => return Descending::Budget,
            Reached::Limit => return Descending::Lost,
            Reached::End => {}
        }
        loop {
            let Some(mut trial) = self.trial.take().or_else(|| self.propose(problem, patience))
            else {
                return Descending::Done;
            };
            match trial.advance(problem, samples, self.best.cost(), budget) {
                Reached::Budget => {
                    self.trial = Some(trial);
                    return Descending::Budget;
                }
                Reached::Limit => self.damping *= DAMPING_STEP.0,
                Reached::End => {
                    let fall = self.best.cost() - trial.cost();
                    self.best = trial;
                    self.damping /= DAMPING_STEP.1;
                    if fall < patience.fall {
                        return Descending::Done;
                    }
                }
            }
        }
    }

    /// The next point to try; none at the bottom.
    fn propose(&mut self, problem: &Problem, patience: Patience) -> Option<Pass> {
        while self.steps < patience.steps && self.damping < DAMPING.1 {
            self.steps += 1;
            let step = Cholesky::of(&damped(self.best.normal(), self.damping))
                .map(|root| root.solve(self.best.descent()));
            let Some(step) = step else {
                self.damping *= DAMPING_STEP.0;
                continue;
            };
            let u =
                problem.within_bounds(core::array::from_fn(|i| self.best.unknowns()[i] + step[i]));
            if self.promised_fall(&u) < patience.fall {
                return None;
            }
            return Some(Pass::new(problem, u));
        }
        None
    }

    /// By how much the cost would fall if the model were linear.
    fn promised_fall(&self, u: &Unknowns) -> f64 {
        let step: Unknowns = core::array::from_fn(|i| u[i] - self.best.unknowns()[i]);
        let slope: f64 = step.iter().zip(self.best.descent()).map(|(s, d)| s * d).sum();
        2.0 * slope - super::cholesky::quadratic(self.best.normal(), &step)
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
