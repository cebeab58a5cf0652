//! Normal equations: symmetric, positive definite, as many rows as there are parameters.

use alloc::vec;
use alloc::vec::Vec;

/// N·x = g.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Normal {
    n: usize,
    /// Row by row; the lower triangle counts.
    rows: Vec<f64>,
    pub(super) gradient: Vec<f64>,
}

/// A factored N.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Factor {
    n: usize,
    /// L of the correlation-like matrix, row by row.
    l: Vec<f64>,
    /// 1/√Nᵢᵢ.
    scale: Vec<f64>,
}

impl Normal {
    pub(super) fn new(n: usize) -> Self {
        Self { n, rows: vec![0.0; n * n], gradient: vec![0.0; n] }
    }

    /// Adds an observation with derivatives `row` (those left out are zero), and its residual.
    #[inline]
    pub(super) fn observe(&mut self, row: &[f64], residual: f64, weight: f64) {
        for (i, a) in row.iter().enumerate() {
            let weighted = a * weight;
            self.gradient[i] += weighted * residual;
            for (sum, b) in self.rows[i * self.n..=i * self.n + i].iter_mut().zip(row) {
                *sum += weighted * b;
            }
        }
    }

    /// Adds a belief about one parameter by itself.
    pub(super) fn believe(&mut self, i: usize, off: f64, weight: f64) {
        self.rows[i * self.n + i] += weight;
        self.gradient[i] += weight * off;
    }

    /// Takes a parameter for known.
    pub(super) fn fix(&mut self, i: usize) {
        for k in 0..self.n {
            self.rows[i * self.n + k] = 0.0;
            self.rows[k * self.n + i] = 0.0;
        }
        self.rows[i * self.n + i] = 1.0;
        self.gradient[i] = 0.0;
    }

    /// Factors N with its diagonal raised by the share `damping`. None when it is not positive
    /// definite.
    pub(super) fn factored(&self, damping: f64) -> Option<Factor> {
        let n = self.n;
        let scale: Vec<f64> = (0..n).map(|i| 1.0 / libm::sqrt(self.rows[i * n + i])).collect();
        let mut l = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..=i {
                let known: f64 = (0..j).map(|k| l[i * n + k] * l[j * n + k]).sum();
                let rest = self.rows[i * n + j] * scale[i] * scale[j] - known;
                l[i * n + j] = if i > j {
                    rest / l[j * n + j]
                } else {
                    let pivot = rest + damping;
                    // Thousands of roundings of the 1 that it started from; NaN fails too.
                    if !(pivot > 1e-13 && pivot < f64::MAX) {
                        return None;
                    }
                    libm::sqrt(pivot)
                };
            }
        }
        Some(Factor { n, l, scale })
    }
}

impl Factor {
    /// N⁻¹·g.
    pub(super) fn solve(&self, g: &[f64]) -> Vec<f64> {
        let (n, l) = (self.n, &self.l);
        let mut x: Vec<f64> = g.iter().zip(&self.scale).map(|(g, scale)| g * scale).collect();
        for i in 0..n {
            let known: f64 = (0..i).map(|k| l[i * n + k] * x[k]).sum();
            x[i] = (x[i] - known) / l[i * n + i];
        }
        for i in (0..n).rev() {
            let known: f64 = (i + 1..n).map(|k| l[k * n + i] * x[k]).sum();
            x[i] = (x[i] - known) / l[i * n + i];
        }
        x.iter().zip(&self.scale).map(|(x, scale)| x * scale).collect()
    }

    /// N⁻¹, row by row; symmetric up to rounding.
    pub(super) fn inverse(&self) -> Vec<f64> {
        let mut inverse = vec![0.0; self.n * self.n];
        for i in 0..self.n {
            let mut unit = vec![0.0; self.n];
            unit[i] = 1.0;
            inverse[i * self.n..(i + 1) * self.n].copy_from_slice(&self.solve(&unit));
        }
        inverse
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn normal() -> Normal {
        let mut normal = Normal::new(3);
        normal.observe(&[1.0, 1e-6, 0.0], 1.0, 2.0);
        normal.observe(&[0.5, -1e-6], 0.0, 1.0);
        normal.observe(&[0.0, 0.0, 1e5], 3.0, 1.0);
        normal.believe(0, 0.1, 4.0);
        normal
    }

    #[test]
    fn the_solution_solves() {
        let normal = normal();
        let factor = normal.factored(0.0).unwrap();
        let x = factor.solve(&normal.gradient);
        // By hand: third alone, 3e-5. The others: [6.25, 1.5e-6; 1.5e-6, 3e-12]·x = [2.4, 2e-6].
        let det = 6.25 * 3e-12 - 1.5e-6 * 1.5e-6;
        let want = [(2.4 * 3e-12 - 1.5e-6 * 2e-6) / det, (6.25 * 2e-6 - 1.5e-6 * 2.4) / det, 3e-5];
        for (got, want) in x.iter().zip(want) {
            assert!((got / want - 1.0).abs() < 1e-12, "{got} {want}");
        }
        assert!((factor.inverse()[0] / (3e-12 / det) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_fixed_parameter_stays_and_frees_the_others() {
        let mut normal = normal();
        normal.fix(1);
        let x = normal.factored(0.0).unwrap().solve(&normal.gradient);
        assert!(x[1].abs() < 1e-300 && (x[0] - 2.4 / 6.25).abs() < 1e-15, "{x:?}");
    }

    #[test]
    fn what_nothing_was_observed_of_is_not_factored() {
        assert!(Normal::new(2).factored(0.0).is_none());
        let mut twice = Normal::new(2);
        twice.observe(&[1.0, 1.0], 1.0, 1.0);
        assert!(twice.factored(0.0).is_none());
    }
}
