//! What a record of the resting body tells about the gyro.

/// Why a record gives no measurement variance.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RestError {
    /// Too short for what is asked of it.
    #[error("a record of {got} samples is too short, {need} are needed")]
    Short {
        /** Samples given. */
        got: usize,
        /** Samples needed. */
        need: usize,
    },
    /// A sample is not finite, or so large that its square is not.
    #[error("sample {index} of the record cannot be squared")]
    NotFinite {
        /** Its place in the record. */
        index: usize,
    },
    /// All samples are equal: the gyro is dead, or its quantiser hides all noise.
    #[error("all samples of the record are equal")]
    Constant,
}

/// Samples that a record has at least.
const RECORD_MIN: usize = 500;
/// Share of the record over which correlations are summed at most: further ones average too few
/// products.
const LAGS_SHARE: usize = 20;
/// On top of what the record shows: its own statistical error, and a room noisier than this one.
const MARGIN: f64 = 1.2;

/// The measurement variance R to give a filter, from rates measured on the resting body, rad²/s².
///
/// R = variance·(1 + 2·Σρₖ)·1.2. The bracket makes it the spectral density at zero frequency times
/// the sample rate, which is what coloured noise does to a filter that believes in white noise and
/// averages over many samples. Correlations ρₖ are summed up to the first that chance could
/// explain, |ρₖ| < 2/√n; their sum never makes R smaller than the variance.
///
/// Give it what the filter will be given: the shipped averaging, quantiser included.
///
/// # Errors
/// [`RestError`] when the record is shorter than 500 samples, holds a number that cannot be
/// squared, or is constant.
pub fn measurement_variance_from_rest(rates_rad_s: &[f64]) -> Result<f64, RestError> {
    let n = rates_rad_s.len();
    check_record(rates_rad_s, RECORD_MIN)?;
    let mean = rates_rad_s.iter().sum::<f64>() / n as f64;
    let covariance = |lag: usize| {
        let pairs = rates_rad_s.iter().zip(&rates_rad_s[lag..]);
        pairs.map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>() / n as f64
    };
    let variance = covariance(0);
    if variance <= 0.0 {
        return Err(RestError::Constant);
    }
    let chance = 2.0 / libm::sqrt(n as f64);
    let correlations = (1..=n / LAGS_SHARE).map(|lag| covariance(lag) / variance);
    let sum: f64 = correlations.take_while(|rho| rho.abs() >= chance).sum();
    Ok(variance * (1.0 + 2.0 * sum).max(1.0) * MARGIN)
}

/// Long enough, and made of numbers whose squares can be summed.
fn check_record(rates_rad_s: &[f64], need: usize) -> Result<(), RestError> {
    let n = rates_rad_s.len();
    if n < need {
        return Err(RestError::Short { got: n, need });
    }
    let summable = |rate: &f64| (rate * rate * n as f64).is_finite();
    match rates_rad_s.iter().position(|rate| !summable(rate)) {
        Some(index) => Err(RestError::NotFinite { index }),
        None => Ok(()),
    }
}

/// The square of half the range of a record, ((max − min)/2)², rad²/s²: what the lab manual of 2008
/// takes for the measurement variance R.
///
/// Kept to repeat what was done then. It is no estimate of the variance: the range of n normal
/// samples grows with n, and its half is 2.5σ at n = 100 and 3.2σ at n = 1000, so R comes out 6 to
/// 10 times too large. [`measurement_variance_from_rest`] is for use.
///
/// # Errors
/// [`RestError`] when the record is shorter than two samples, holds a number that cannot be
/// squared, or is constant.
///
/// # Source
/// Ivanov, Ovchinnikov and Tkachev, MIPT lab manual, 2008, section 5, step 4.
pub fn half_range_squared(rates_rad_s: &[f64]) -> Result<f64, RestError> {
    check_record(rates_rad_s, 2)?;
    let highest = rates_rad_s.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let lowest = rates_rad_s.iter().copied().fold(f64::INFINITY, f64::min);
    let half_range_rad_s = 0.5 * highest - 0.5 * lowest;
    if half_range_rad_s > 0.0 {
        Ok(half_range_rad_s * half_range_rad_s)
    } else {
        Err(RestError::Constant)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use std::vec::Vec;

    /// z = e + a·e(previous), with unit white e.
    fn record(n: usize, a: f64) -> Vec<f64> {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let mut before = 0.0;
        (0..n)
            .map(|_| {
                let e: f64 = StandardNormal.sample(&mut rng);
                core::mem::replace(&mut before, e) * a + e
            })
            .collect()
    }

    #[test]
    fn white_noise_has_its_variance_and_the_margin() {
        let r = measurement_variance_from_rest(&record(40_000, 0.0)).unwrap();
        // Variance to √(2/n) = 0.7 %; the first correlation is chance in 19 of 20 records, and
        // adds 2 % when it is not. Three sigma of the first.
        assert!((r / 1.2 - 1.0).abs() < 0.021, "{r}");
    }

    #[test]
    fn coloured_noise_has_the_density_at_zero_frequency() {
        for a in [0.3, 0.8] {
            let r = measurement_variance_from_rest(&record(40_000, a)).unwrap();
            // (1 + a)² exactly. One correlation counts, to about 1/√n·2·(1 + a²) = 1.6 % of it;
            // a second that is chance would add another 2/√n·2 = 2 %.
            assert!((r / (1.2 * (1.0 + a) * (1.0 + a)) - 1.0).abs() < 0.04, "{a}: {r}");
        }
    }

    #[test]
    fn noise_that_alternates_does_not_make_the_filter_bold() {
        let r = measurement_variance_from_rest(&record(40_000, -0.9)).unwrap();
        // Its density at zero frequency is 0.01; a filter that trusts that fails with any drift.
        assert!((r / (1.2 * 1.81) - 1.0).abs() < 0.03, "{r}");
    }

    #[test]
    fn a_record_that_tells_nothing_is_refused() {
        let short = measurement_variance_from_rest(&record(499, 0.0));
        assert_eq!(short, Err(RestError::Short { got: 499, need: 500 }));
        assert_eq!(measurement_variance_from_rest(&[0.25; 600]), Err(RestError::Constant));
        for bad in [f64::NAN, f64::INFINITY, 1e200] {
            let mut rates = record(600, 0.0);
            rates[17] = bad;
            let refused = measurement_variance_from_rest(&rates);
            assert_eq!(refused, Err(RestError::NotFinite { index: 17 }), "{bad}");
        }
    }

    #[test]
    fn the_recipe_of_half_the_range_overstates_the_variance_six_to_ten_times() {
        let noise = record(200_000, 0.0);
        // Means of (half range)² over records, by numerical integration of the order statistics:
        // 6.38 at n = 100 and 10.57 at n = 1000. Its relative spread is 25 % and 16 % a record,
        // and so 0.6 % and 1.2 % for the mean over 2000 and 200 records; three of that.
        for (n, expected, tolerance) in [(100, 6.38, 0.018), (1000, 10.57, 0.036)] {
            let records = noise.chunks_exact(n);
            let count = records.len() as f64;
            let sum: f64 = records.map(|record| half_range_squared(record).unwrap()).sum();
            let mean = sum / count;
            assert!((mean / expected - 1.0).abs() < tolerance, "{n}: {mean}");
        }
    }

    #[test]
    fn half_a_range_needs_two_numbers_that_differ() {
        assert_eq!(half_range_squared(&[1.0, -3.0, 2.0]), Ok(6.25));
        assert_eq!(half_range_squared(&[1.0]), Err(RestError::Short { got: 1, need: 2 }));
        assert_eq!(half_range_squared(&[0.5; 9]), Err(RestError::Constant));
        for bad in [f64::NAN, f64::INFINITY, -1e200] {
            let refused = half_range_squared(&[0.0, bad, 1.0]);
            assert_eq!(refused, Err(RestError::NotFinite { index: 1 }), "{bad}");
        }
    }
}
