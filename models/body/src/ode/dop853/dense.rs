//! The polynomial through one step.

use super::super::dop853_tableau::DENSE_ROWS;

/// Dense output of one step, in Hairer's nested form.
#[derive(Debug, Clone)]
pub(super) struct Dense<const N: usize> {
    pub(super) start_s: f64,
    pub(super) step_s: f64,
    pub(super) start: [f64; N],
    pub(super) rows: [[f64; N]; 3 + DENSE_ROWS],
}

impl<const N: usize> Dense<N> {
    pub(super) fn at(&self, time_s: f64) -> [f64; N] {
        let x = (time_s - self.start_s) / self.step_s;
        let mut y = [0.0; N];
        for (depth, row) in self.rows.iter().enumerate().rev() {
            let factor = if depth % 2 == 0 { x } else { 1.0 - x };
            for (y, row) in y.iter_mut().zip(row) {
                *y = (*y + row) * factor;
            }
        }
        for (y, start) in y.iter_mut().zip(&self.start) {
            *y += start;
        }
        y
    }
}
