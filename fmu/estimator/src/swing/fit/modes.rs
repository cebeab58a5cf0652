//! Which of the descents go on to a longer window.

use super::cholesky::quadratic;
use super::levenberg::Descent;
use super::problem::{UNKNOWNS, Unknowns};
use alloc::vec::Vec;

/// Squared distance, by the better one's normal equations, below which two ends are one mode.
const EQUAL: f64 = 50.0;

/// What a window leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cut {
    /// Cost above the best that is given up.
    pub(super) cost: f64,
    /// How many are kept.
    pub(super) count: usize,
}

/// The distinct ends within the cut, lowest cost first. Of equal costs the earlier start counts.
pub(super) fn pruned(mut ends: Vec<Descent>, cut: Cut) -> Vec<Descent> {
    // A stable sort: the order of equals is that of the starts.
    ends.sort_by(|a, b| a.best().cost().total_cmp(&b.best().cost()));
    let mut kept: Vec<Descent> = Vec::with_capacity(cut.count.min(ends.len()));
    for end in ends {
        let least = kept.first().map_or(end.best().cost(), |best| best.best().cost());
        if kept.len() == cut.count || end.best().cost() > least + cut.cost {
            break;
        }
        if !kept.iter().any(|better| are_equal(better, &end)) {
            kept.push(end);
        }
    }
    kept
}

fn are_equal(better: &Descent, other: &Descent) -> bool {
    let (a, b) = (better.best().unknowns(), other.best().unknowns());
    let apart: Unknowns = core::array::from_fn(|i: usize| b[i] - a[i]);
    debug_assert_eq!(apart.len(), UNKNOWNS);
    quadratic(better.best().normal(), &apart) < EQUAL
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::swing::fit::problem::tests::problem;

    /// Ends at these distances from the prior in the first unknown: their costs are the squares.
    fn kept(at: &[f64], cut: Cut) -> Vec<f64> {
        let problem = problem();
        let end = |at: &f64| {
            let mut u = [0.0; UNKNOWNS];
            u[0] = *at;
            Descent::new(&problem, u)
        };
        let ends = at.iter().map(end).collect();
        pruned(ends, cut).iter().map(|end| end.best().unknowns()[0]).collect()
    }

    const ALL: Cut = Cut { cost: f64::INFINITY, count: 25 };

    #[test]
    fn ends_come_in_the_order_of_their_cost_and_once() {
        assert_eq!(kept(&[20.0, -9.0, 1.0, 8.0], ALL), [1.0, -9.0, 20.0]);
    }

    #[test]
    fn the_cut_is_by_cost_above_the_best_and_by_count() {
        assert_eq!(kept(&[0.0, 8.0, 16.0], Cut { cost: 100.0, count: 25 }), [0.0, 8.0]);
        assert_eq!(kept(&[0.0, 8.0, 16.0], Cut { count: 1, ..ALL }), [0.0]);
        assert!(kept(&[], ALL).is_empty());
    }
}
