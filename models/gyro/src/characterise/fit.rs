//! Least squares of the five slopes, none of them negative.

use super::{NoiseModel, Term};

/// Weights are taken from the model and the model from the weights, this many times over.
const REWEIGHTINGS: usize = 4;
/// Relative accuracy beyond which five straight slopes are no description of any gyro: its band,
/// its rounding and its vibration bend them. No point may claim to be known better.
pub(super) const MODEL_ERROR: f64 = 0.01;
/// A pivot below this share of its column means that the columns cannot be told apart.
const PIVOT_MIN: f64 = 1e-12;

const TERMS: usize = Term::ALL.len();

/// An Allan variance to be fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Observation {
    pub tau_s: f64,
    pub variance: f64,
    pub edf: f64,
    /// How much of an independent point this one is: neighbours within an octave share most of
    /// their samples.
    pub independence: f64,
}

impl Observation {
    /// Points (τ, variance, edf) in ascending τ, each with the share of an octave that is its own.
    pub(super) fn of(points: &[(f64, f64, f64)]) -> Vec<Self> {
        let octaves = |a: usize, b: usize| (points[b].0 / points[a].0).log2();
        let own = |k: usize| {
            let below = if k > 0 { octaves(k - 1, k) } else { 1.0 };
            let above = if k + 1 < points.len() { octaves(k, k + 1) } else { 1.0 };
            (0.5 * (below + above)).min(1.0)
        };
        let observation = |(k, &(tau_s, variance, edf)): (usize, &(f64, f64, f64))| Self {
            tau_s,
            variance,
            edf,
            independence: own(k),
        };
        points.iter().enumerate().map(observation).collect()
    }

    /// Degrees of freedom, as far as a model of slopes deserves them.
    fn freedom(&self) -> f64 {
        self.edf.min(2.0 / (MODEL_ERROR * MODEL_ERROR))
    }

    /// Minus twice the logarithm of the likelihood of a variance that is χ²-distributed about
    /// `model`, less what does not depend on the model.
    fn deviance(&self, model: f64) -> f64 {
        let ratio = self.variance / model;
        self.independence * self.freedom() * (ratio - 1.0 - ratio.ln())
    }
}

/// A model with what it leaves unexplained.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Candidate {
    pub model: NoiseModel,
    pub deviance: f64,
    pub aicc: f64,
    pub bic: f64,
}

/// How many points are independent.
pub(super) fn independent_points(observations: &[Observation]) -> f64 {
    observations.iter().map(|o| o.independence).sum()
}

/// Every set of `allowed` terms that the curve fills with positive coefficients, best first by the
/// Akaike criterion corrected for few points.
pub(super) fn candidates(observations: &[Observation], allowed: &[Term]) -> Vec<Candidate> {
    let n = independent_points(observations);
    let mut found: Vec<Candidate> = subsets(allowed)
        .filter_map(|terms| {
            let model = reweighted(observations, &terms, &NoiseModel::default())?;
            if !terms.iter().all(|term| model.has(*term)) {
                return None; // a smaller set says the same
            }
            let deviance = deviance(observations, &model);
            let k = terms.len() as f64;
            // Beyond n − 1 coefficients the correction has no meaning; such a set is no candidate.
            let correction = (n > k + 1.0).then(|| 2.0 * k * (k + 1.0) / (n - k - 1.0))?;
            let (aicc, bic) = (deviance + 2.0 * k + correction, deviance + k * n.ln());
            Some(Candidate { model, deviance, aicc, bic })
        })
        .collect();
    found.sort_by(|a, b| a.aicc.total_cmp(&b.aicc));
    found
}

/// Total deviance of a model.
pub(super) fn deviance(observations: &[Observation], model: &NoiseModel) -> f64 {
    observations.iter().map(|o| o.deviance(model.variance(o.tau_s))).sum()
}

/// Least squares of `terms` on top of `fixed`, with weights √(edf/2)/model. None when nothing
/// positive fits.
pub(super) fn reweighted(
    observations: &[Observation],
    terms: &[Term],
    fixed: &NoiseModel,
) -> Option<NoiseModel> {
    let mut weights_by: Vec<f64> = observations.iter().map(|o| o.variance).collect();
    let mut best = None;
    for _ in 0..=REWEIGHTINGS {
        let normal = Normal::of(observations, &weights_by, fixed);
        let model = normal.non_negative(terms, fixed);
        for (weight, o) in weights_by.iter_mut().zip(observations) {
            *weight = model.variance(o.tau_s);
        }
        if weights_by.iter().any(|model| !(*model > 0.0 && model.is_finite())) {
            return None;
        }
        best = Some(model);
    }
    best
}

fn subsets(terms: &[Term]) -> impl Iterator<Item = Vec<Term>> {
    (1..1_u32 << terms.len()).map(|set| {
        let chosen = terms.iter().enumerate().filter(|(k, _)| set & (1 << k) != 0);
        chosen.map(|(_, term)| *term).collect()
    })
}

/// Normal equations of the weighted least squares, all five columns scaled to unit length.
struct Normal {
    gram: [[f64; TERMS]; TERMS],
    right: [f64; TERMS],
    scale: [f64; TERMS],
}

impl Normal {
    fn of(observations: &[Observation], weights_by: &[f64], fixed: &NoiseModel) -> Self {
        let (mut gram, mut right) = ([[0.0; TERMS]; TERMS], [0.0; TERMS]);
        for (o, by) in observations.iter().zip(weights_by) {
            let weight = (0.5 * o.freedom()).sqrt() / by;
            let row = Term::ALL.map(|term| weight * term.unit_variance(o.tau_s));
            let rest = weight * (o.variance - fixed.variance(o.tau_s));
            for i in 0..TERMS {
                right[i] += row[i] * rest;
                for j in 0..TERMS {
                    gram[i][j] += row[i] * row[j];
                }
            }
        }
        let scale: [f64; TERMS] = std::array::from_fn(|i| gram[i][i].sqrt());
        for i in 0..TERMS {
            right[i] /= scale[i];
            for j in 0..TERMS {
                gram[i][j] /= scale[i] * scale[j];
            }
        }
        Self { gram, right, scale }
    }

    /// The best of all sets of terms whose unconstrained solution is positive, added to `fixed`.
    ///
    /// With five terms there are 31 sets; going through them needs no tolerance that an active-set
    /// method would.
    fn non_negative(&self, terms: &[Term], fixed: &NoiseModel) -> NoiseModel {
        let mut best = (0.0, [0.0; TERMS]);
        for set in subsets(terms) {
            let Some(solution) = self.solve(&set) else { continue };
            if solution.iter().any(|x| *x < 0.0) {
                continue;
            }
            // What the set takes off the sum of squares.
            let gain: f64 = solution.iter().zip(self.right).map(|(x, b)| x * b).sum();
            if gain > best.0 {
                best = (gain, solution);
            }
        }
        let squares = fixed.squares();
        NoiseModel::from_squares(std::array::from_fn(|i| squares[i] + best.1[i] / self.scale[i]))
    }

    /// Solution for the terms of `set`, zero elsewhere, by Cholesky factors.
    fn solve(&self, set: &[Term]) -> Option<[f64; TERMS]> {
        let n = set.len();
        let at: Vec<usize> = set.iter().map(|term| term.index()).collect();
        let mut factor = [[0.0; TERMS]; TERMS];
        for i in 0..n {
            for j in 0..=i {
                let known: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
                let rest = self.gram[at[i]][at[j]] - known;
                if i == j {
                    factor[i][i] = (rest > PIVOT_MIN).then(|| rest.sqrt())?;
                } else {
                    factor[i][j] = rest / factor[j][j];
                }
            }
        }
        let mut y = [0.0; TERMS];
        for i in 0..n {
            let known: f64 = (0..i).map(|k| factor[i][k] * y[k]).sum();
            y[i] = (self.right[at[i]] - known) / factor[i][i];
        }
        let mut solution = [0.0; TERMS];
        for i in (0..n).rev() {
            let known: f64 = (i + 1..n).map(|k| factor[k][i] * solution[at[k]]).sum();
            solution[at[i]] = (y[i] - known) / factor[i][i];
        }
        Some(solution)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A curve without noise, ten points per decade.
    fn exact(model: &NoiseModel, decades: [i32; 2]) -> Vec<Observation> {
        let points: Vec<_> = (10 * decades[0]..=10 * decades[1])
            .map(|k| 10.0_f64.powf(f64::from(k) / 10.0))
            .map(|tau_s| (tau_s, model.variance(tau_s), 1e5 / tau_s))
            .collect();
        Observation::of(&points)
    }

    #[test]
    fn slopes_that_are_there_come_back_exactly() {
        let model = NoiseModel::from_coefficients([1e-4, 2e-2, 3e-3, 4e-4, 5e-6]);
        let found = reweighted(&exact(&model, [-2, 4]), &Term::ALL, &NoiseModel::default());
        let found = found.unwrap();
        for term in Term::ALL {
            let ratio = found.coefficient(term) / model.coefficient(term);
            // The normal equations square a condition number of some 1e3.
            assert!((ratio - 1.0).abs() < 1e-6, "{term:?}: {ratio}");
        }
    }

    #[test]
    fn the_criterion_finds_the_terms_that_are_there_and_no_other() {
        for coefficients in [
            [0.0, 2e-2, 0.0, 0.0, 0.0],
            [0.0, 2e-2, 3e-3, 0.0, 0.0],
            [1e-3, 2e-2, 0.0, 4e-4, 0.0],
            [0.0, 2e-2, 3e-3, 0.0, 1e-5],
        ] {
            let model = NoiseModel::from_coefficients(coefficients);
            let best = candidates(&exact(&model, [-2, 4]), &Term::ALL)[0];
            for term in Term::ALL {
                assert_eq!(best.model.has(term), model.has(term), "{term:?} {coefficients:?}");
            }
        }
    }

    #[test]
    fn no_coefficient_is_negative_where_the_curve_bends_the_other_way() {
        // Falls faster than any sum of the slopes can.
        let taus = (0..20).map(|k| 1.3_f64.powi(k));
        let points: Vec<_> = taus.map(|tau_s| (tau_s, tau_s.powi(-3), 50.0)).collect();
        let model = reweighted(&Observation::of(&points), &Term::ALL, &NoiseModel::default());
        assert!(model.unwrap().squares().iter().all(|square| *square >= 0.0));
    }

    #[test]
    fn ten_points_in_a_decade_count_as_an_octave_each_three() {
        let model = NoiseModel::from_coefficients([0.0, 1.0, 0.0, 0.0, 0.0]);
        let observations = exact(&model, [0, 3]);
        // 29 tenths of a decade, and two ends that own half an octave more.
        let expected = 30.0 * 0.1 * 10.0_f64.log2() + 1.0;
        assert!((independent_points(&observations) - expected).abs() < 1e-9);
        let octave = Observation::of(&[(1.0, 1.0, 9.0), (2.0, 1.0, 9.0), (4.0, 1.0, 9.0)]);
        assert!((independent_points(&octave) - 3.0).abs() < 1e-12);
    }
}
