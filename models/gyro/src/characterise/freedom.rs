//! Degrees of freedom of an Allan variance, and the interval they leave.

use super::Term;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Above this the chi-square quantile is taken from its cube root, which is normal to 1e-7 there.
const CUBE_ROOT_FROM: f64 = 1000.0;

/// Equivalent degrees of freedom of the overlapping Allan variance at `factor` samples, from
/// `points` points of angle, when the noise is of the kind that makes `term`.
///
/// A ramp is no noise and has none of its own; it takes those of the rate random walk, which are
/// the fewest.
///
/// # Source
/// Riley, *Handbook of Frequency Stability Analysis* (NIST SP 1065), 2008, the simple formulas for
/// white phase, white frequency, flicker frequency and random-walk frequency noise, which for
/// angles and rates are quantisation, angle random walk, bias instability and rate random walk.
#[must_use]
pub fn degrees_of_freedom(term: Term, points: usize, factor: usize) -> f64 {
    let (n, m) = (points as f64, factor as f64);
    let edf = match term {
        Term::Quantisation => (n + 1.0) * (n - 2.0 * m) / (2.0 * (n - m)),
        Term::AngleRandomWalk => {
            let share = 4.0 * m * m / (4.0 * m * m + 5.0);
            (3.0 * (n - 1.0) / (2.0 * m) - 2.0 * (n - 2.0) / n) * share
        }
        Term::BiasInstability if factor == 1 => 2.0 * (n - 2.0).powi(2) / (2.3 * n - 4.9),
        Term::BiasInstability => 5.0 * n * n / (4.0 * m * (n + 3.0 * m)),
        Term::RateRandomWalk | Term::RateRamp => {
            let spread = (n - 1.0).powi(2) - 3.0 * m * (n - 1.0) + 4.0 * m * m;
            (n - 2.0) / m * spread / (n - 3.0).powi(2)
        }
    };
    // Three averages, the fewest that are used, leave at least one; below, nothing holds.
    if points > 3 && edf >= 1.0 { edf } else { 1.0 }
}

/// The factors by which a variance with `edf` degrees of freedom may be too large and too small at
/// `confidence`: the true one lies between estimate × first and estimate × second.
#[must_use]
pub fn variance_interval(edf: f64, confidence: f64) -> [f64; 2] {
    let tail = 0.5 * (1.0 - confidence);
    [1.0 - tail, tail].map(|probability| edf / chi_squared(edf, probability))
}

/// The value below which a chi-square variable with `freedom` degrees stays with `probability`.
fn chi_squared(freedom: f64, probability: f64) -> f64 {
    if freedom < CUBE_ROOT_FROM
        && let Ok(distribution) = ChiSquared::new(freedom)
    {
        return distribution.inverse_cdf(probability);
    }
    let normal = statrs::distribution::Normal::standard().inverse_cdf(probability);
    let spread = 2.0 / (9.0 * freedom);
    freedom * (1.0 - spread + normal * spread.sqrt()).powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_tables() {
        // SciPy's chi2.ppf.
        for (freedom, probability, expected) in [
            (1.0, 0.025, 9.820_691_171_752_555e-4),
            (2.5, 0.975, 8.392_295_266_912_964),
            (11.5, 0.975, 22.630_713_681_037_747),
            (999.0, 0.025, 913.300_998_302_113_4),
            (1e6, 0.975, 1_002_773.701_467_926),
        ] {
            let found = chi_squared(freedom, probability);
            assert!((found / expected - 1.0).abs() < 1e-6, "{freedom}: {found} for {expected}");
        }
    }

    #[test]
    fn the_two_ways_to_a_quantile_meet() {
        for probability in [0.005, 0.025, 0.5, 0.975, 0.995] {
            let below = chi_squared(CUBE_ROOT_FROM * (1.0 - 1e-12), probability);
            let above = chi_squared(CUBE_ROOT_FROM, probability);
            // The normal approximation of the cube root is good to some 1e-6 here.
            assert!((below / above - 1.0).abs() < 1e-5, "{probability}: {below} {above}");
        }
    }

    #[test]
    fn few_points_leave_at_least_one_degree() {
        for term in Term::ALL {
            for points in 0..8 {
                for factor in 1..4 {
                    let edf = degrees_of_freedom(term, points, factor);
                    assert!(edf >= 1.0 && edf.is_finite(), "{term:?} {points} {factor}: {edf}");
                }
            }
        }
    }
}
