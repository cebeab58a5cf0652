//! One step back in time.

use super::matrix::{IDENTITY, Matrix, Vector};
use super::matrix::{from_fn, product, sandwich, solved, sum, times, transposed};
use crate::augmented::{AugmentedFilter, Link, Trace};

/// Least determinant of a step's transition that is inverted. Over a longer gap the motion has
/// died down by as much and nothing of it can be told from its end.
const DETERMINANT_MIN: f64 = 1e-4;

/// What the state at one sample is, given the state at a later one: x = gain·x′ + offset, with
/// noise of this covariance.
///
/// Such maps can be joined end to end, which is what a running smoother lives on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BackwardMap {
    gain: Matrix,
    offset: Vector,
    noise: Matrix,
}

impl BackwardMap {
    /// From a sample to itself.
    pub(super) const IDENTITY: Self =
        Self { gain: IDENTITY, offset: [0.0; 5], noise: [[0.0; 5]; 5] };

    /// From the end of trace `later` to that of `from`, the one before it.
    pub(super) fn between(model: &AugmentedFilter, from: &Trace, later: &Trace) -> Self {
        Self::of(&model.link(from, later))
    }

    /// Rauch, Tung and Striebel's gain G = P·Fᵀ·(P⁻)⁻¹ in the form F⁻¹·(I − Q·(P⁻)⁻¹).
    ///
    /// The two are equal because P⁻ = F·P·Fᵀ + Q. In the second one the inverse of P⁻, which is
    /// nearly singular once the filter knows its parameters, is multiplied by the little that the
    /// step adds, and its rounding with it. The noise, A·P·Aᵀ + G·Q·Gᵀ with A = I − G·F, is a sum
    /// of squares and cannot lose its sign.
    ///
    /// # Source
    /// Rauch, Tung and Striebel, *Maximum likelihood estimates of linear dynamic systems*, 1965.
    fn of(link: &Link) -> Self {
        let Link { covariance: p, covariance_later, transition: f, noise: q, .. } = link;
        let (gain, rest) = match inverse(f) {
            Some(back) => {
                let renewed = transposed(&solved(covariance_later, q));
                let kept = from_fn(|i, j| IDENTITY[i][j] - renewed[i][j]);
                (product(&back, &kept), product(&back, &product(&renewed, f)))
            }
            None => {
                let gain = transposed(&solved(covariance_later, &product(f, p)));
                let known = product(&gain, f);
                (gain, from_fn(|i, j| IDENTITY[i][j] - known[i][j]))
            }
        };
        let expected = times(&gain, &link.mean_later);
        Self {
            offset: core::array::from_fn(|i| link.mean[i] - expected[i]),
            noise: sum(&sandwich(&rest, p), &sandwich(&gain, q)),
            gain,
        }
    }

    /// Mean and covariance at the earlier sample from those at the later one.
    pub(super) fn apply(&self, mean: &Vector, covariance: &Matrix) -> (Vector, Matrix) {
        let carried = times(&self.gain, mean);
        let mean = core::array::from_fn(|i| carried[i] + self.offset[i]);
        (mean, sum(&sandwich(&self.gain, covariance), &self.noise))
    }

    /// From still later: `earlier` after `self`.
    pub(super) fn then(&self, earlier: &Self) -> Self {
        let (offset, noise) = earlier.apply(&self.offset, &self.noise);
        Self { gain: product(&earlier.gain, &self.gain), offset, noise }
    }

    /// The trace that `from` becomes, given what is known at the later sample. `from` itself if
    /// the numbers have left the range of floating point: less is known then, not something else.
    pub(super) fn smoothed(&self, from: &Trace, mean: &Vector, covariance: &Matrix) -> Trace {
        let (mean, covariance) = self.apply(mean, covariance);
        let smoothed = from.with(mean, &covariance);
        if smoothed.is_sound() { smoothed } else { *from }
    }
}

/// F⁻¹ of a step's transition, whose rows of parameters are those of the identity.
fn inverse(f: &Matrix) -> Option<Matrix> {
    let determinant = f[0][0] * f[1][1] - f[0][1] * f[1][0];
    if !(DETERMINANT_MIN..=1.0 / DETERMINANT_MIN).contains(&determinant) {
        return None;
    }
    let scale = 1.0 / determinant;
    let t = [[f[1][1] * scale, -f[0][1] * scale], [-f[1][0] * scale, f[0][0] * scale]];
    let by = |i: usize, j: usize| -(t[i][0] * f[0][j] + t[i][1] * f[1][j]);
    Some(from_fn(|i, j| match (i, j) {
        (0 | 1, 0 | 1) => t[i][j],
        (0 | 1, _) => by(i, j),
        _ => IDENTITY[i][j],
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AugmentedConfig, InnovationTest, StartPrior, TestedFilter};

    const STEP_S: f64 = 0.1;

    /// Two samples a gap apart, in a motion of 20 s that dies down by a fifth in 2 s.
    fn across(gap_s: f64) -> Link {
        let start = StartPrior { damping_ratio: 0.2, ..StartPrior::released(6.3, 20.0) };
        let config = AugmentedConfig::quiet(start, 1e-6);
        let mut filter = TestedFilter::new(&config, &InnovationTest::STANDARD).unwrap();
        for k in 1..=40 {
            let time_s = STEP_S * f64::from(k);
            filter.step(STEP_S, -6.3 * 0.0987 * time_s * libm::exp(-0.2 * time_s)).unwrap();
        }
        let from = filter.trace(STEP_S);
        filter.step(gap_s, 0.0).unwrap();
        filter.filter().link(&from, &filter.trace(gap_s))
    }

    /// However far apart the two are: what the later one is expected to be tells nothing new.
    #[test]
    fn a_later_state_that_is_as_expected_leaves_the_earlier_one_as_it_was() {
        for gap_s in [STEP_S, 10.0, 60.0, 100.0, 300.0] {
            let link = across(gap_s);
            let is_inverted = inverse(&link.transition).is_some();
            assert_eq!(is_inverted, gap_s < 70.0, "{gap_s}: 1e-4 is left after 73 s");
            let (mean, p) = BackwardMap::of(&link).apply(&link.mean_later, &link.covariance_later);
            let sigma: Vector = core::array::from_fn(|i| libm::sqrt(link.covariance[i][i]));
            let off = from_fn(|i, j| (p[i][j] - link.covariance[i][j]) / (sigma[i] * sigma[j]));
            // F⁻¹ magnifies a rounding by up to 1e4, in the covariance twice.
            for i in 0..5 {
                let off_sigmas = (mean[i] - link.mean[i]) / sigma[i];
                assert!(off_sigmas.abs() < 1e-11, "{gap_s} s, mean {i}: {off_sigmas}");
            }
            assert!(off.iter().flatten().all(|off| off.abs() < 1e-8), "{gap_s} s: {off:?}");
        }
    }
}
