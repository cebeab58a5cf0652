//! Noise that need not be white, and what filters make of it.

use std::f64::consts::{PI, SQRT_2};

/// Most terms of an impulse response that are summed.
const TERMS_MAX: usize = 1 << 17;
/// Terms that matter to a sum of squared correlations.
const LAGS_MAX: usize = 1 << 12;

/// The noise of a sampled gyro as the response of a filter to white noise.
///
/// White, or a two-pole low-pass with the poles of a Butterworth filter of the bandwidth:
/// h_k = 2·e⁻ˣ·cos x·h_(k−1) − e⁻²ˣ·h_(k−2) with x = √2·π·f/f_s.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseShape {
    first: f64,
    second: f64,
    /// Terms until the response has died away.
    terms: usize,
    /// Makes the variance 1.
    gain: f64,
}

impl NoiseShape {
    /// Noise of the given bandwidth at a sample rate, both Hz; white without one.
    #[must_use]
    pub fn new(sample_rate_hz: f64, bandwidth_hz: Option<f64>) -> Self {
        let (first, second, terms) = match bandwidth_hz {
            None => (0.0, 0.0, 1),
            Some(bandwidth_hz) => {
                let x = SQRT_2 * PI * bandwidth_hz / sample_rate_hz;
                // e⁻²⁰ of the response is left out.
                let terms = (20.0 / x).ceil().clamp(1.0, TERMS_MAX as f64);
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "clamped to a small positive number"
                )]
                let terms = terms as usize;
                (2.0 * (-x).exp() * x.cos(), -(-2.0 * x).exp(), terms)
            }
        };
        let mut shape = Self { first, second, terms, gain: 1.0 };
        shape.gain = 1.0 / shape.response().map(|h| h * h).sum::<f64>().sqrt();
        shape
    }

    /// The next value of unit variance, from white noise `white` and the two values before.
    #[must_use]
    pub fn next(&self, white: f64, last: [f64; 2]) -> f64 {
        self.gain * white + self.first * last[0] + self.second * last[1]
    }

    /// The impulse response; its squares add up to 1.
    fn response(&self) -> impl Iterator<Item = f64> + '_ {
        let mut last = [0.0; 2];
        (0..self.terms).map(move |k| {
            let now = self.next(f64::from(u8::from(k == 0)), last);
            last = [now, last[0]];
            now
        })
    }

    /// What `filter` answers to one impulse of white noise that has gone through this shape,
    /// followed by `tail` terms of its own memory.
    fn through(&self, tail: usize, mut filter: impl FnMut(f64) -> f64) -> Vec<f64> {
        let silence = std::iter::repeat_n(0.0, tail);
        self.response().chain(silence).map(&mut filter).collect()
    }

    /// Deviation of what `filter` makes of noise of deviation 1.
    #[must_use]
    pub fn sigma_through(&self, tail: usize, filter: impl FnMut(f64) -> f64) -> f64 {
        self.through(tail, filter).iter().map(|h| h * h).sum::<f64>().sqrt()
    }

    /// For how many samples the square of what `filter` makes of the noise is alike: the sum of
    /// its squared correlations over all lags, 1 for white noise left alone.
    #[must_use]
    pub fn alike_samples(&self, tail: usize, filter: impl FnMut(f64) -> f64) -> f64 {
        let mut h = self.through(tail, filter);
        h.truncate(LAGS_MAX);
        let power: f64 = h.iter().map(|h| h * h).sum();
        let correlation =
            |lag: usize| h.iter().zip(&h[lag..]).map(|(a, b)| a * b).sum::<f64>() / power;
        let one_side: f64 = (1..h.len()).map(|lag| correlation(lag).powi(2)).sum();
        1.0 + 2.0 * one_side
    }

    /// Deviation of the mean of `n` samples of noise of deviation 1, for `n` far beyond the
    /// noise's memory.
    #[must_use]
    pub fn sigma_of_mean(&self, n: f64) -> f64 {
        self.response().sum::<f64>().abs() / n.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use struna_kernel::{Channel, RandomStream, Seed};

    fn samples(shape: &NoiseShape, n: usize) -> Vec<f64> {
        let mut stream = RandomStream::new(Seed(5), Channel::NoiseTrial, 0);
        let mut last = [0.0; 2];
        let mut draw = || {
            let now = shape.next(stream.standard_normal(), last);
            last = [now, last[0]];
            now
        };
        (0..1000).for_each(|_| {
            draw();
        });
        (0..n).map(|_| draw()).collect()
    }

    #[test]
    fn computed_deviations_are_those_of_drawn_noise() {
        let shape = NoiseShape::new(1400.0, Some(40.0));
        let drawn = samples(&shape, 400_000);
        let sigma = |x: &[f64]| (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt();
        // Some 20 000 independent values: four standard errors of a deviation are 2 %.
        assert!((sigma(&drawn) - 1.0).abs() < 0.02, "{}", sigma(&drawn));
        let steps: Vec<f64> = drawn.windows(2).map(|w| w[1] - w[0]).collect();
        let mut last = 0.0;
        let computed = shape.sigma_through(1, |x| x - std::mem::replace(&mut last, x));
        assert!((sigma(&steps) / computed - 1.0).abs() < 0.02, "{computed}");
        let means: Vec<f64> =
            drawn.chunks_exact(1400).map(|c| c.iter().sum::<f64>() / 1400.0).collect();
        // 285 means: four standard errors are 17 %.
        assert!((sigma(&means) / shape.sigma_of_mean(1400.0) - 1.0).abs() < 0.17);
    }

    #[test]
    fn white_noise_is_alike_for_one_sample() {
        let shape = NoiseShape::new(300.0, None);
        assert!((shape.alike_samples(0, |x| x) - 1.0).abs() < 1e-12);
        assert!(NoiseShape::new(1400.0, Some(40.0)).alike_samples(0, |x| x) > 5.0);
    }
}
