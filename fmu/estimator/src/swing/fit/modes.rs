//! Which of the descents go on to a longer window.

use super::bounded::Bounded;
use super::cholesky::quadratic;
use super::levenberg::Descent;
use super::plan::STARTS_MAX;
use super::problem::{UNKNOWNS, Unknowns};

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

/// Moves the distinct ends within the cut to `kept`, lowest cost first, and the others nowhere. Of
/// equal costs the earlier start counts.
pub(super) fn prune(ends: &mut Bounded<Descent>, kept: &mut Bounded<Descent>, cut: Cut) {
    kept.clear();
    let mut order: [usize; STARTS_MAX] = core::array::from_fn(|place| place);
    let order = &mut order[..ends.len().min(STARTS_MAX)];
    let cost = |place: usize| ends[place].best().cost();
    order.sort_unstable_by(|a, b| cost(*a).total_cmp(&cost(*b)).then(a.cmp(b)));
    for place in order {
        let end = &ends[*place];
        let least = kept.first().map_or(end.best().cost(), |best| best.best().cost());
        if kept.len() == cut.count || end.best().cost() > least + cut.cost {
            break;
        }
        if !kept.iter().any(|better| are_equal(better, end)) {
            kept.push(end.clone());
        }
    }
    ends.clear();
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
    use std::vec::Vec;

    /// Ends at these distances from the prior in the first unknown: their costs are the squares.
    fn kept(at: &[f64], cut: Cut) -> Vec<f64> {
        let problem = problem();
        let end = |at: &f64| {
            let mut u = [0.0; UNKNOWNS];
            u[0] = *at;
            Descent::new(&problem, u)
        };
        let (mut ends, mut kept) = (Bounded::new(4), Bounded::new(4));
        ends.extend(at.iter().map(end));
        prune(&mut ends, &mut kept, cut);
        assert!(ends.is_empty());
        kept.iter().map(|end| end.best().unknowns()[0]).collect()
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
