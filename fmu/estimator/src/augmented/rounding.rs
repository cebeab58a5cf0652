//! What rounding to counts does to a measured rate, by its moments.
//!
//! In counts: a sample is q = v + n + e with the rate v = ω + b, its noise n of variance σ² and the
//! error of rounding e, a sawtooth of x = v + n. Its Fourier series, and that of its square, are
//!
//! - e = Σ (−1)ᵏ sin(2πkx)/(πk),
//! - e² = 1/12 + Σ (−1)ᵏ cos(2πkx)/(π²k²).
//!
//! A sine or cosine of a normal quantity has the mean of that of the quantity's mean times
//! exp(−2π²k²·variance), so that every moment of q under v ~ N(v̂, p) is a series of which a few
//! terms are left wherever σ is not small.

use super::config::Quantiser;
use super::state::Expectation;
use core::f64::consts::{FRAC_1_PI, TAU};

/// Harmonics kept at most: those of a noise of [`SIGMA_MIN`].
const HARMONICS: usize = 9;
/// Least noise of a raw sample that is reckoned with, counts. With less the rate stands between two
/// counts for so long, and passes from one to the next so suddenly, that neither is Gaussian.
const SIGMA_MIN: f64 = 0.1;
/// Least standard deviation of a measured rate, steps of one sample in it. In mid-count hardly any
/// sample leaves its count, and one that does would be tens of deviations away: the gate would
/// take it for an outlier, and what is left out on one side bends the rate. With half a step it is
/// two deviations. It costs little, for a rate in mid-count tells little.
const DEVIATION_MIN: f64 = 0.5;
/// Harmonics weaker than this share of the first one without noise are left out: of the mean rate
/// they hold less than 1e-7/(2π) of a count each, and each is weaker than the one before by more
/// than a factor of 20.
const HARMONIC_MIN: f64 = 1e-7;
/// 2π².
const TWO_PI2: f64 = 0.5 * TAU * TAU;

/// A quantiser that the noise does not dither away, as an update needs it. Counts and their
/// squares, where no unit is given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rounding {
    /// One count, rad/s.
    step_rad_s: f64,
    counts_per_rad_s: f64,
    /// One over the number of samples in a measured rate.
    share: f64,
    sigma2: f64,
    /// (−1)ᵏ·exp(−2π²k²σ²) for k from 1.
    weights: [f64; HARMONICS],
    /// How many of them are kept.
    kept: usize,
    /// What R has beyond the noise of the samples and of their rounding, rad²/s².
    other_rad2_s2: f64,
}

/// A measured rate as a linear function of v with noise of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Linearised {
    /// Expected error of rounding.
    error: f64,
    /// Slope of the expected rate in v.
    slope: f64,
    /// Variance of the measured rate around slope·(v − v̂).
    variance: f64,
}

impl Rounding {
    /// The quantiser, and a measurement variance R that was measured with it.
    pub(super) fn new(quantiser: &Quantiser, r_rad2_s2: f64) -> Self {
        let step_rad_s = quantiser.step_rad_s;
        let sigma = (quantiser.raw_sigma_rad_s / step_rad_s).max(SIGMA_MIN);
        let sigma2 = sigma * sigma;
        let size = |k: usize| libm::exp(-TWO_PI2 * sigma2 * (k * k) as f64);
        let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        Self {
            step_rad_s,
            counts_per_rad_s: 1.0 / step_rad_s,
            share: 1.0 / f64::from(quantiser.samples),
            sigma2,
            weights: core::array::from_fn(|i| sign(i + 1) * size(i + 1)),
            kept: (1..HARMONICS).take_while(|k| size(k + 1) >= HARMONIC_MIN).count() + 1,
            other_rad2_s2: (r_rad2_s2 - quantiser.dithered_variance_rad2_s2()).max(0.0),
        }
    }

    /// How a measured rate compares with the state, `plain` being what it is to one that knows no
    /// rounding.
    ///
    /// A linear function of v with the same mean, covariance with v and variance takes the place of
    /// rounding: statistical linearisation. It is exact in these moments for normal v, not only for
    /// a small p.
    #[inline(always)]
    pub(super) fn expected(&self, plain: &Expectation, rate_rad_s: f64) -> Expectation {
        // Numbers alone go out of line: a reference would keep `plain` in memory for those who
        // have no rounding, too.
        let expected_rad_s = rate_rad_s - plain.residual;
        let Linearised { error, slope, variance } = self.seen(expected_rad_s, plain.spread);
        Expectation {
            residual: plain.residual - error,
            spread: slope * slope * plain.spread,
            columns: plain.columns.map(|column| slope * column),
            r: variance,
        }
    }

    /// Error, rad/s, slope and variance, rad²/s², for a rate of this mean and variance.
    #[cold]
    #[inline(never)]
    fn seen(&self, expected_rad_s: f64, spread: f64) -> Linearised {
        let v = expected_rad_s * self.counts_per_rad_s;
        let p = spread.max(0.0) * self.counts_per_rad_s * self.counts_per_rad_s;
        let Linearised { error, slope, variance } = self.linearised(v, p);
        Linearised {
            error: self.step_rad_s * error,
            slope,
            variance: self.step_rad_s * self.step_rad_s * variance + self.other_rad2_s2,
        }
    }

    /// The moments for v ~ N(`v`, `p`).
    ///
    /// With τ² = σ² + p and Stein's identity for the covariance of x and e, var q = τ²·(2H − 1) +
    /// E e² − (E e)², H being the slope. Samples of one measured rate share v and not n: the
    /// covariance of two is that of their means given v, v + s(v), and that is the same with p for
    /// τ² and E s² for E e². The mean of m has var q/m + (1 − 1/m)·cov.
    fn linearised(&self, v: f64, p: f64) -> Linearised {
        let turn = v - libm::rint(v);
        let (sin, cos) = libm::sincos(TAU * turn);
        let mut waves = [Wave::default(); 2 * HARMONICS + 1];
        let faded = libm::exp(-TWO_PI2 * p);
        let (mut now, mut fade, mut fade_step) = ((0.0, 1.0), 1.0, faded);
        for wave in &mut waves[..=2 * self.kept] {
            *wave = Wave { sin: fade * now.0, cos: fade * now.1 };
            now = (now.0 * cos + now.1 * sin, now.1 * cos - now.0 * sin);
            // exp(−2π²k²p): from k to k + 1 by the (2k + 1)th power.
            fade *= fade_step;
            fade_step *= faded * faded;
        }
        let (mut error, mut slope, mut error2) = (0.0, 1.0, 1.0 / 12.0);
        for (k, Wave { sin, cos }) in waves.iter().enumerate().take(self.kept + 1).skip(1) {
            let (weight, amplitude) = (self.weights[k - 1], FRAC_1_PI / k as f64);
            error += weight * amplitude * sin;
            slope += 2.0 * weight * cos;
            error2 += weight * amplitude * amplitude * cos;
        }
        let spread = 2.0 * slope - 1.0;
        let one = (self.sigma2 + p) * spread + error2 - error * error;
        let two = p * spread + self.mean_error2(&waves) - error * error;
        let own = self.share * one + (1.0 - self.share) * two - slope * slope * p;
        let least = DEVIATION_MIN * self.share;
        let variance = own.max(least * least);
        Linearised { error, slope, variance }
    }

    /// E s², the mean square of the error that is expected of a sample given v: products of sines
    /// are half the difference of the cosines of difference and sum.
    fn mean_error2(&self, waves: &[Wave; 2 * HARMONICS + 1]) -> f64 {
        let mut sum = 0.0;
        for j in 1..=self.kept {
            for k in 1..=self.kept {
                let both = self.weights[j - 1] * self.weights[k - 1] / (j * k) as f64;
                sum += both * (waves[j.abs_diff(k)].cos - waves[j + k].cos);
            }
        }
        0.5 * FRAC_1_PI * FRAC_1_PI * sum
    }
}

/// Means of sin 2πkv and cos 2πkv.
#[derive(Debug, Clone, Copy, Default)]
struct Wave {
    sin: f64,
    cos: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In counts, without any other noise.
    fn rounding(sigma: f64, samples: u32) -> Rounding {
        let quantiser = Quantiser { step_rad_s: 1.0, raw_sigma_rad_s: sigma, samples };
        Rounding::new(&quantiser, quantiser.dithered_variance_rad2_s2())
    }

    /// Mean and variance of a count given v, by the normal distribution's shares.
    fn count_given(v: f64, sigma: f64) -> (f64, f64) {
        let below =
            |edge: f64| 0.5 * libm::erfc((v - edge) / sigma * core::f64::consts::FRAC_1_SQRT_2);
        let middle = libm::rint(v);
        let (mut mean, mut square) = (0.0, 0.0);
        for n in -5..=5 {
            let count = f64::from(n);
            let share = below(middle + count + 0.5) - below(middle + count - 0.5);
            mean += share * count;
            square += share * count * count;
        }
        (middle + mean, square - mean * mean)
    }

    /// The same moments as of the series, by integration over v ~ N(`v`, `p`): expected rate less
    /// v, slope, and variance that is left.
    fn by_integration(v: f64, p: f64, sigma: f64, samples: u32) -> Linearised {
        let (root, step) = (libm::sqrt(p), 0.02);
        let (mut mean, mut square, mut slope, mut inner) = (0.0, 0.0, 0.0, 0.0);
        for k in -400..=400 {
            let x = step * f64::from(k);
            let weight = step * libm::exp(-0.5 * x * x) / libm::sqrt(TAU);
            let (of_count, scatter) = count_given(v + root * x, sigma);
            mean += weight * of_count;
            square += weight * of_count * of_count;
            slope += weight * of_count * x / root;
            inner += weight * scatter;
        }
        let whole = square - mean * mean + inner / f64::from(samples);
        Linearised { error: mean - v, slope, variance: whole - slope * slope * p }
    }

    #[test]
    fn the_series_are_the_moments_of_rounded_normal_rates() {
        for sigma in [0.1, 0.15, 0.2, 0.3176, 0.45, 0.5] {
            for (samples, p) in [(1, 1e-6), (3, 1e-3), (3, 0.04), (14, 0.2), (2, 1.5)] {
                for v in [0.0, 0.13, 0.37, 0.5, -0.74, 1_000.61, -3.25] {
                    let ours = rounding(sigma, samples).linearised(v, p);
                    let numeric = by_integration(v, p, sigma, samples);
                    let least = DEVIATION_MIN / f64::from(samples);
                    let variance = numeric.variance.max(least * least);
                    let off = [
                        ours.error - numeric.error,
                        ours.slope - numeric.slope,
                        ours.variance - variance,
                    ];
                    // The first harmonic left out has a weight of at most 1e-7: in the slope twice
                    // that and a little for the next, and less in what is divided by πk. The
                    // integral errs by nothing against that, but for 2.5e-8 where v is 1000: its
                    // counts, squared, have lost six digits of sixteen, and √p divides them.
                    for (k, off) in off.into_iter().enumerate() {
                        let place = format_args!("{k} at σ {sigma}, v {v}, p {p}: {off:e}");
                        assert!(off.abs() < 2.5e-7, "moment {place}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_dithered_count_is_a_rate_with_white_rounding() {
        // exp(−2π²/4) = 0.72 %: the share of the first harmonic at the limit of what is dithered.
        let share = 0.0072;
        for v in [0.0, 0.2, 0.5, 0.8] {
            let Linearised { error, slope, variance } = rounding(0.5, 3).linearised(v, 1e-4);
            assert!(error.abs() < share / core::f64::consts::PI, "{error}");
            assert!((slope - 1.0).abs() < 2.0 * share, "{slope}");
            // Of τ²(2H − 1) four shares of a quarter, and one over π² of the mean square.
            let white = (0.25 + 1.0 / 12.0) / 3.0;
            assert!((variance - white).abs() < (1.0 + 0.11) * share / 3.0, "{variance}");
        }
    }

    #[test]
    fn what_the_record_shows_beyond_the_samples_own_noise_is_added() {
        let quantiser = Quantiser { step_rad_s: 2.0, raw_sigma_rad_s: 0.6, samples: 4 };
        let own_rad2_s2 = quantiser.dithered_variance_rad2_s2();
        let plain = Expectation { residual: 0.1, spread: 0.01, columns: [0.01; 5], r: 1.0 };
        let noise = |r: f64| Rounding::new(&quantiser, r).expected(&plain, 0.4).r;
        assert!(noise(0.5 * own_rad2_s2).to_bits() == noise(own_rad2_s2).to_bits());
        let more = noise(own_rad2_s2 + 0.25) - noise(own_rad2_s2);
        assert!((more - 0.25).abs() < 1e-15, "{more}");
    }
}
