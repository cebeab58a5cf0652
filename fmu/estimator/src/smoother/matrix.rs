//! Five by five matrices, as the smoother needs them.

pub(super) type Vector = [f64; 5];
pub(super) type Matrix = [[f64; 5]; 5];

/// Pivot of a correlation matrix below which a direction counts as known exactly: thousands of
/// roundings of the 1 that it started from.
const PIVOT_MIN: f64 = 1e-13;

pub(super) const IDENTITY: Matrix = [
    [1.0, 0.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 0.0, 1.0, 0.0],
    [0.0, 0.0, 0.0, 0.0, 1.0],
];

pub(super) fn from_fn(entry: impl Fn(usize, usize) -> f64) -> Matrix {
    core::array::from_fn(|i| core::array::from_fn(|j| entry(i, j)))
}

/// A·B.
#[inline(always)]
pub(super) fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let mut out = [[0.0; 5]; 5];
    for (row, a_row) in out.iter_mut().zip(a) {
        for (a_entry, b_row) in a_row.iter().zip(b) {
            for (sum, b_entry) in row.iter_mut().zip(b_row) {
                *sum += a_entry * b_entry;
            }
        }
    }
    out
}

pub(super) fn transposed(a: &Matrix) -> Matrix {
    from_fn(|i, j| a[j][i])
}

pub(super) fn sum(a: &Matrix, b: &Matrix) -> Matrix {
    from_fn(|i, j| a[i][j] + b[i][j])
}

/// A·P·Aᵀ of a symmetric P, symmetric to the last bit.
#[inline(always)]
pub(super) fn sandwich(a: &Matrix, p: &Matrix) -> Matrix {
    let full = product(&product(a, p), &transposed(a));
    from_fn(|i, j| if i <= j { full[i][j] } else { full[j][i] })
}

pub(super) fn times(a: &Matrix, x: &Vector) -> Vector {
    core::array::from_fn(|i| a[i].iter().zip(x).map(|(a, x)| a * x).sum())
}

/// X with P·X = B, for a covariance P. Directions that have no variance are left out: X is zero
/// there.
///
/// P is scaled to correlations and factored as L·D·Lᵀ: its units differ by ten orders of magnitude.
pub(super) fn solved(p: &Matrix, b: &Matrix) -> Matrix {
    let inverse_sigma: Vector = core::array::from_fn(|i| {
        let sigma = libm::sqrt(p[i][i].max(0.0));
        if sigma > 0.0 { 1.0 / sigma } else { 0.0 }
    });
    let (mut l, mut inverse_pivot) = ([[0.0; 5]; 5], [0.0; 5]);
    for j in 0..5 {
        for i in j..5 {
            let correlation = p[i][j] * inverse_sigma[i] * inverse_sigma[j];
            // So far a column holds L·D, divided by its pivot below.
            let known: f64 = (0..j).map(|k| l[i][k] * l[j][k] * inverse_pivot[k]).sum();
            l[i][j] = correlation - known;
        }
        inverse_pivot[j] = if l[j][j] > PIVOT_MIN { 1.0 / l[j][j] } else { 0.0 };
    }
    // Column by column of B.
    let mut columns = from_fn(|j, i| b[i][j] * inverse_sigma[i]);
    for x in &mut columns {
        for i in 0..5 {
            let known: f64 = (0..i).map(|k| l[i][k] * inverse_pivot[k] * x[k]).sum();
            x[i] -= known;
        }
        for i in (0..5).rev() {
            let known: f64 = (i + 1..5).map(|k| l[k][i] * x[k]).sum();
            x[i] = (x[i] - known) * inverse_pivot[i];
        }
    }
    from_fn(|i, j| columns[j][i] * inverse_sigma[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A covariance with units as far apart as the filter's: B·Bᵀ, scaled.
    fn covariance() -> Matrix {
        let b = from_fn(|i, j| if i == j { 2.0 } else { 1.0 / (1.0 + (3 * i + 2 * j) as f64) });
        let units = [1e-3, 1e-1, 1e-6, 1e-5, 1e-4];
        let c = sandwich(&b, &IDENTITY);
        from_fn(|i, j| c[i][j] * units[i] * units[j])
    }

    #[test]
    fn a_solved_system_multiplies_back() {
        let (p, b) = (covariance(), from_fn(|i, j| (i + 2 * j) as f64 - 3.5));
        let back = product(&p, &solved(&p, &b));
        for (got, want) in back.iter().flatten().zip(b.iter().flatten()) {
            // A row's terms differ by the units, 1e5: so do their roundings from the sum, up to 5.
            assert!((got - want).abs() < 1e-10, "{got} {want}");
        }
    }

    #[test]
    fn a_direction_without_variance_is_left_out() {
        let mut p = covariance();
        p[2] = [0.0; 5];
        p.iter_mut().for_each(|row| row[2] = 0.0);
        let x = solved(&p, &p);
        let kept = from_fn(|i, j| if i == j && i != 2 { 1.0 } else { 0.0 });
        for (got, want) in x.iter().flatten().zip(kept.iter().flatten()) {
            // Units differ by up to 1e5 between rows.
            assert!((got - want).abs() < 1e-9, "{got} {want}");
        }
    }
}
