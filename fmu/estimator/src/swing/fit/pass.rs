//! One walk of the model along the record: its cost, and the normal equations about it.

use super::cholesky::Square;
use super::problem::{Problem, UNKNOWNS, Unknowns};
use super::walk::Walk;

/// Work that may still be done before a call returns, in steps of the model with its tangents.
#[derive(Debug)]
pub(super) struct Budget(pub(super) usize);

impl Budget {
    /// Takes one step's worth, unless nothing is left.
    pub(super) fn take(&mut self) -> bool {
        let left = self.0 > 0;
        self.0 = self.0.saturating_sub(1);
        left
    }
}

/// How far a pass has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reached {
    /// The budget is spent.
    Budget,
    /// The end of the window.
    End,
    /// A cost beyond the limit, or a motion that the model does not have.
    Limit,
}

/// Cost and normal equations of unknowns u over the samples from the first one on.
///
/// Cost is Σ(z − h)²/R + uᵀu. A pass can be stopped and continued at any sample, and a finished one
/// continues where it stopped when the window grows.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pass {
    u: Unknowns,
    walk: Walk,
    /// Samples walked over.
    at: usize,
    cost: f64,
    /// Σ hᵀh/R + 1, lower triangle.
    normal: Square<UNKNOWNS>,
    /// Half of minus the derivative of the cost: Σ hᵀ(z − h)/R − u.
    descent: Unknowns,
}

impl Pass {
    /// A pass that has seen no samples: only what is believed beforehand counts.
    pub(super) fn new(problem: &Problem, u: Unknowns) -> Self {
        let mut normal = [[0.0; UNKNOWNS]; UNKNOWNS];
        for (i, row) in normal.iter_mut().enumerate() {
            row[i] = 1.0;
        }
        let cost = u.iter().map(|u| u * u).sum();
        let walk = Walk::new(problem, &u);
        Self { u, walk, at: 0, cost, normal, descent: u.map(|u| -u) }
    }

    /// Walks on over `samples`, the window from its first sample on; those that are not finite are
    /// missing. The cost never falls on the way, so a pass beyond `cost_limit` is not finished.
    pub(super) fn advance(
        &mut self,
        problem: &Problem,
        samples: &[f64],
        cost_limit: f64,
        budget: &mut Budget,
    ) -> Reached {
        while let Some(sample) = samples.get(self.at) {
            if !budget.take() {
                return Reached::Budget;
            }
            let moved = match self.at {
                0 => self.walk.enter(problem),
                _ => self.walk.step(problem),
            };
            if !moved {
                return Reached::Limit;
            }
            self.at += 1;
            if sample.is_finite() {
                self.weigh(problem, *sample);
                if self.cost.is_nan() || self.cost > cost_limit {
                    return Reached::Limit;
                }
            }
        }
        Reached::End
    }

    fn weigh(&mut self, problem: &Problem, sample: f64) {
        let residual = (sample - self.walk.rate_rad_s()) * problem.inverse_noise;
        let row = self.walk.row(problem);
        self.cost += residual * residual;
        for (i, entries) in self.normal.iter_mut().enumerate() {
            let weight = row[i];
            for (entry, other) in entries.iter_mut().zip(&row).take(i + 1) {
                *entry += weight * other;
            }
            self.descent[i] += weight * residual;
        }
    }

    pub(super) fn unknowns(&self) -> &Unknowns {
        &self.u
    }

    pub(super) fn cost(&self) -> f64 {
        self.cost
    }

    pub(super) fn normal(&self) -> &Square<UNKNOWNS> {
        &self.normal
    }

    pub(super) fn descent(&self) -> &Unknowns {
        &self.descent
    }

    pub(super) fn walk(&self) -> &Walk {
        &self.walk
    }
}
