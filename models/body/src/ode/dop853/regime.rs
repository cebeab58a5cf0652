//! Steps that end where the equations change.

use super::super::Rhs;
use super::{Dop853, END, Step};

/// Halvings that place a change of regime within a step: to 1e-9 of its length.
const HALVINGS: u32 = 30;
/// How far past the change a step ends at least, as a share of the step that ran over it.
const MARGIN: f64 = 1e-9;

impl<const N: usize> Dop853<N> {
    /// `step`, or if the regime changes within it, the shorter step that ends just past that.
    ///
    /// Past it, so that the next step starts on the far side and does not meet the change again.
    pub(super) fn within_regime<R: Rhs<N>>(
        &self,
        rhs: &R,
        first: &[f64; N],
        step: Step<N>,
    ) -> Step<N> {
        let before = rhs.regime(step.start_s, &step.start);
        let passed = |time_s: f64, y: &[f64; N]| rhs.regime(time_s, y) != before;
        if !passed(step.end_s(), &step.end) {
            return step;
        }
        let mut share = change_share(rhs, &step, passed) + MARGIN;
        // The interpolant errs as the step does, and may put the change a little early.
        let mut margin = MARGIN;
        while share < 1.0 {
            let cut = self.attempt(rhs, first, share * step.step_s);
            if passed(cut.end_s(), &cut.end) {
                return cut;
            }
            (share, margin) = (share + 10.0 * margin, 10.0 * margin);
        }
        step
    }
}

/// Where in `step` the regime changes, by bisection of the dense output.
fn change_share<const N: usize, R: Rhs<N>>(
    rhs: &R,
    step: &Step<N>,
    passed: impl Fn(f64, &[f64; N]) -> bool,
) -> f64 {
    let mut whole = step.clone();
    whole.k[END] = rhs.derivative(whole.end_s(), &whole.end);
    let dense = whole.dense(rhs);
    let (mut before, mut after) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (before + after);
        let time_s = step.start_s + middle * step.step_s;
        if passed(time_s, &dense.at(time_s)) {
            after = middle;
        } else {
            before = middle;
        }
    }
    after
}
