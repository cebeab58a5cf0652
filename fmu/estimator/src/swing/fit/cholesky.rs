//! Symmetric positive definite systems of a fixed, small size.

/// A square matrix by rows. Of a symmetric one only the lower triangle is read.
pub(in crate::swing) type Square<const N: usize> = [[f64; N]; N];

/// The lower triangular root L of a matrix A = L·Lᵀ.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::swing) struct Cholesky<const N: usize>(Square<N>);

impl<const N: usize> Cholesky<N> {
    /// The root of `matrix`; none when it is not positive definite, or not finite: the comparison
    /// also refuses a NaN.
    ///
    /// A pivot must be larger than what rounding leaves of a zero, N times 1e-16 of the diagonal.
    pub(in crate::swing) fn of(matrix: &Square<N>) -> Option<Self> {
        let mut l = [[0.0; N]; N];
        for j in 0..N {
            let pivot = matrix[j][j] - dot(&l[j], &l[j], j);
            if !(pivot > 1e-14 * matrix[j][j] && pivot.is_finite()) {
                return None;
            }
            let root = libm::sqrt(pivot);
            l[j][j] = root;
            for i in j + 1..N {
                l[i][j] = (matrix[i][j] - dot(&l[i], &l[j], j)) / root;
            }
        }
        Some(Self(l))
    }

    /// x with A·x = `right`.
    pub(in crate::swing) fn solve(&self, right: &[f64; N]) -> [f64; N] {
        let mut x = self.forward(right);
        for i in (0..N).rev() {
            let known: f64 = (i + 1..N).map(|k| self.0[k][i] * x[k]).sum();
            x[i] = (x[i] - known) / self.0[i][i];
        }
        x
    }

    /// y with L·y = `right`; so aᵀ·A⁻¹·b is the product of two such vectors.
    pub(in crate::swing) fn forward(&self, right: &[f64; N]) -> [f64; N] {
        let mut y = [0.0; N];
        for i in 0..N {
            y[i] = (right[i] - dot(&self.0[i], &y, i)) / self.0[i][i];
        }
        y
    }

    /// J·A⁻¹·Jᵀ for a square J: the covariance of J·x when A⁻¹ is that of x. Symmetric to the bit.
    pub(in crate::swing) fn covariance_of(&self, j: &Square<N>) -> Square<N> {
        let rows: [[f64; N]; N] = core::array::from_fn(|i| self.forward(&j[i]));
        core::array::from_fn(|a| core::array::from_fn(|b| dot(&rows[a], &rows[b], N)))
    }
}

/// Sum of the first `n` products.
fn dot<const N: usize>(a: &[f64; N], b: &[f64; N], n: usize) -> f64 {
    a.iter().zip(b).take(n).map(|(a, b)| a * b).sum()
}

/// xᵀ·A·x of a symmetric matrix of which the lower triangle is kept.
pub(in crate::swing) fn quadratic<const N: usize>(a: &Square<N>, x: &[f64; N]) -> f64 {
    let row = |i: usize| x[i] * (2.0 * dot(&a[i], x, i) + a[i][i] * x[i]);
    (0..N).map(row).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: Square<3> = [[4.0, 0.0, 0.0], [2.0, 5.0, 0.0], [1.0, 3.0, 6.0]];

    #[test]
    fn a_solution_solves() {
        let x = [1.0, -2.0, 0.5];
        // A·x by hand, upper triangle mirrored.
        let right = [4.0 - 4.0 + 0.5, 2.0 - 10.0 + 1.5, 1.0 - 6.0 + 3.0];
        let solved = Cholesky::of(&A).unwrap().solve(&right);
        for (solved, x) in solved.iter().zip(x) {
            assert!((solved - x).abs() < 1e-14, "{solved} for {x}");
        }
        assert!((quadratic(&A, &x) - (0.5 + 13.0 - 1.0)).abs() < 1e-14);
    }

    #[test]
    fn the_covariance_of_the_identity_is_the_inverse() {
        let unit: Square<3> = core::array::from_fn(|i| core::array::from_fn(|j| f64::from(i == j)));
        let inverse = Cholesky::of(&A).unwrap().covariance_of(&unit);
        for (column, unit) in inverse.iter().zip(&unit) {
            let solved = Cholesky::of(&A).unwrap().solve(unit);
            assert!(column.iter().zip(&solved).all(|(a, b)| (a - b).abs() < 1e-15));
        }
    }

    #[test]
    fn what_is_not_positive_definite_has_no_root() {
        assert!(Cholesky::of(&[[1.0, 0.0], [2.0, 1.0]]).is_none());
        assert!(Cholesky::of(&[[1.0, 0.0], [1.0, 1.0]]).is_none());
        assert!(Cholesky::of(&[[f64::NAN, 0.0], [0.0, 1.0]]).is_none());
        assert!(Cholesky::of(&[[1.0, 0.0], [f64::INFINITY, 1.0]]).is_none());
        assert!(Cholesky::of(&[[0.0, 0.0], [0.0, 1.0]]).is_none());
    }
}
