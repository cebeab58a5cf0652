//! A model that promises no less noise than was seen.

use super::fit::Observation;
use super::{NoiseModel, Term};

/// What a Kalman filter can carry: white noise, a slow bias and its walk.
const TERMS: [Term; 3] = [Term::AngleRandomWalk, Term::BiasInstability, Term::RateRandomWalk];
/// Shortfall that is rounding.
const SLACK: f64 = 1e-9;

/// The least N, B and K whose Allan variance is nowhere below that of `observations`.
///
/// Least is the sum over the points of model over observation, which is linear in the squared
/// coefficients. So the answer is a corner where three of the conditions hold exactly, and all
/// corners can be tried: sixty points make some forty thousand.
pub(super) fn overbound(observations: &[Observation]) -> Option<NoiseModel> {
    let demand = |o: &Observation| TERMS.map(|term| term.unit_variance(o.tau_s) / o.variance);
    // In units in which each coefficient alone, at one, covers its easiest point.
    let unit: [f64; 3] = std::array::from_fn(|k| {
        observations.iter().map(|o| demand(o)[k]).fold(f64::MIN_POSITIVE, f64::max)
    });
    let rows: Vec<[f64; 3]> =
        observations.iter().map(|o| std::array::from_fn(|k| demand(o)[k] / unit[k])).collect();
    let cost: [f64; 3] = std::array::from_fn(|k| rows.iter().map(|row| row[k]).sum());
    let axes: [[f64; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(i == j)));
    // A row demands at least one, an axis at least zero.
    let conditions: Vec<([f64; 3], f64)> =
        rows.iter().map(|row| (*row, 1.0)).chain(axes.map(|axis| (axis, 0.0))).collect();
    let mut best: Option<(f64, [f64; 3])> = None;
    for i in 0..conditions.len() {
        for j in 0..i {
            for k in 0..j {
                let Some(corner) = corner([conditions[i], conditions[j], conditions[k]]) else {
                    continue;
                };
                let price = dot(cost, corner);
                let cheaper = best.is_none_or(|(least, _)| price < least);
                if cheaper
                    && conditions.iter().all(|(row, least)| dot(*row, corner) >= least - SLACK)
                {
                    best = Some((price, corner));
                }
            }
        }
    }
    let squares = best?.1;
    // Rounding may not leave a point uncovered.
    let [n, b, k] = std::array::from_fn(|k| squares[k].max(0.0) / unit[k] * (1.0 + 2.0 * SLACK));
    Some(NoiseModel::from_squares([0.0, n, b, k, 0.0]))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Where three conditions hold exactly, by Cramer's rule on rows of unit length.
fn corner(conditions: [([f64; 3], f64); 3]) -> Option<[f64; 3]> {
    let [(a, x), (b, y), (c, z)] = conditions.map(|(row, least)| {
        let length = dot(row, row).sqrt();
        (row.map(|value| value / length), least / length)
    });
    let determinant = dot(a, cross(b, c));
    if determinant.abs() < 1e-15 {
        return None; // no point, a line
    }
    let (bc, ca, ab) = (cross(b, c), cross(c, a), cross(a, b));
    let corner: [f64; 3] =
        std::array::from_fn(|k| (x * bc[k] + y * ca[k] + z * ab[k]) / determinant);
    corner.iter().all(|value| value.is_finite()).then_some(corner)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn observed(variance: impl Fn(f64) -> f64) -> Vec<Observation> {
        let taus = (-20..=26).map(|k| 10.0_f64.powf(f64::from(k) / 10.0));
        Observation::of(&taus.map(|t| (t, variance(t), 20.0)).collect::<Vec<_>>())
    }

    #[test]
    fn a_curve_of_the_three_terms_is_its_own_bound() {
        let model = NoiseModel::from_coefficients([0.0, 2e-5, 3e-6, 1e-7, 0.0]);
        let bound = overbound(&observed(|tau_s| model.variance(tau_s))).unwrap();
        for term in TERMS {
            let ratio = bound.coefficient(term) / model.coefficient(term);
            assert!((ratio - 1.0).abs() < 1e-6, "{term:?}: {ratio}");
        }
    }

    #[test]
    fn no_point_lies_above_the_bound_and_some_lie_on_it() {
        // A hump that no sum of the three has, as vibration makes it.
        let curve = observed(|t| 1e-9 / t + 4e-10 * (-(t / 3.0).ln().powi(2)).exp() + 1e-13 * t);
        let bound = overbound(&curve).unwrap();
        let margins: Vec<f64> =
            curve.iter().map(|o| bound.variance(o.tau_s) / o.variance).collect();
        assert!(margins.iter().all(|margin| *margin >= 1.0), "{margins:?}");
        assert!(margins.iter().any(|margin| *margin < 1.0 + 1e-6), "{margins:?}");
    }

    #[test]
    fn a_corner_is_where_three_planes_meet() {
        let at = corner([([2.0, 0.0, 0.0], 4.0), ([0.0, 1.0, 0.0], 3.0), ([1.0, 1.0, 1.0], 6.0)]);
        assert!(at.unwrap().iter().zip([2.0, 3.0, 1.0]).all(|(a, b)| (a - b).abs() < 1e-12));
        assert_eq!(corner([([1.0, 0.0, 0.0], 1.0); 3]), None);
    }
}
