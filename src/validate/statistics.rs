//! Estimates from so many runs, with the intervals that so many runs leave open.
//!
//! All intervals are two-sided and hold the true value in 95 of 100 campaigns, unless a level is
//! given.

use statrs::distribution::{Beta, Binomial, ChiSquared, ContinuousCDF, DiscreteCDF, StudentsT};

/// Share of campaigns in which an interval does not hold the true value.
pub const ERROR_RATE: f64 = 0.05;
/// Half width of a normal interval at that rate, standard deviations.
const NORMAL_HALF: f64 = 1.96;

/// A value with what can be said of the true one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// As measured.
    pub value: f64,
    /// The true one is hardly below this.
    pub low: f64,
    /// The true one is hardly above this.
    pub high: f64,
    /// Runs that it comes from.
    pub runs: usize,
}

impl Measured {
    /// The interval that says nothing of a quantity that is not negative.
    fn open(value: f64, runs: usize) -> Self {
        Self { value, low: 0.0, high: f64::INFINITY, runs }
    }

    /// The same divided by something known exactly.
    #[must_use]
    pub fn over(self, divisor: f64) -> Self {
        let Self { value, low, high, runs } = self;
        Self { value: value / divisor, low: low / divisor, high: high / divisor, runs }
    }
}

/// Root of the mean square of errors: ± 1.96/√(2M) of itself. One infinite error makes it infinite.
#[must_use]
pub fn rms(errors: &[f64]) -> Option<Measured> {
    let n = errors.len();
    if n == 0 {
        return None;
    }
    let value = (errors.iter().map(|error| error * error).sum::<f64>() / n as f64).sqrt();
    if value.is_infinite() {
        return Some(Measured { value, low: value, high: value, runs: n });
    }
    let half = NORMAL_HALF / (2.0 * n as f64).sqrt();
    let (low, high) = (value * (1.0 - half).max(0.0), value * (1.0 + half));
    Some(Measured { value, low, high, runs: n })
}

/// Share of `hits` among `n`, by Clopper and Pearson.
#[must_use]
pub fn share(hits: usize, n: usize) -> Option<Measured> {
    if n == 0 {
        return None;
    }
    let (k, m) = (hits as f64, n as f64);
    let quantile = |a: f64, b: f64, p: f64| Beta::new(a, b).map(|beta| beta.inverse_cdf(p));
    let low = if hits == 0 { 0.0 } else { quantile(k, m - k + 1.0, ERROR_RATE / 2.0).ok()? };
    let high =
        if hits == n { 1.0 } else { quantile(k + 1.0, m - k, 1.0 - ERROR_RATE / 2.0).ok()? };
    Some(Measured { value: k / m, low, high, runs: n })
}

/// Mean number of events in a run from their sum over `n` runs, by Poisson's law.
#[must_use]
pub fn mean_count(events: f64, n: usize) -> Option<Measured> {
    if n == 0 {
        return None;
    }
    let quantile = |freedom: f64, p: f64| chi_square(freedom, p).map(|q| 0.5 * q);
    let low = if events > 0.0 { quantile(2.0 * events, ERROR_RATE / 2.0)? } else { 0.0 };
    let high = quantile(2.0 * events + 2.0, 1.0 - ERROR_RATE / 2.0)?;
    Some(Measured { value: events, low, high, runs: n }.over(n as f64))
}

/// Mean of squares that are chi-square distributed with `states` degrees of freedom up to a common
/// factor, at an error rate of its own.
#[must_use]
pub fn mean_square(squares: &[f64], states: f64, error_rate: f64) -> Option<Measured> {
    let n = squares.len();
    if n == 0 {
        return None;
    }
    let value = squares.iter().sum::<f64>() / n as f64;
    let freedom = states * n as f64;
    let low = value * freedom / chi_square(freedom, 1.0 - error_rate / 2.0)?;
    let high = value * freedom / chi_square(freedom, error_rate / 2.0)?;
    Some(Measured { value, low, high, runs: n })
}

fn chi_square(freedom: f64, p: f64) -> Option<f64> {
    ChiSquared::new(freedom).ok().map(|law| law.inverse_cdf(p))
}

/// Mean of numbers whose scatter is their own, by Student.
#[must_use]
pub fn mean(values: &[f64]) -> Option<Measured> {
    let n = values.len();
    if n == 0 {
        return None;
    }
    let value = values.iter().sum::<f64>() / n as f64;
    if n == 1 || !value.is_finite() {
        return Some(Measured { value, low: f64::NEG_INFINITY, high: f64::INFINITY, runs: n });
    }
    let freedom = n as f64 - 1.0;
    let variance = values.iter().map(|v| (v - value) * (v - value)).sum::<f64>() / freedom;
    let student = StudentsT::new(0.0, 1.0, freedom).ok()?;
    let half = student.inverse_cdf(1.0 - ERROR_RATE / 2.0) * (variance / n as f64).sqrt();
    Some(Measured { value, low: value - half, high: value + half, runs: n })
}

/// Median, between two order statistics. Open to either side when there are too few values.
#[must_use]
pub fn median(values: &[f64]) -> Option<Measured> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len();
    let value = *sorted.get(n / 2)?;
    let law = Binomial::new(0.5, n as u64).ok()?;
    // Largest number of values that lie below the median so rarely that it can be left out.
    let outside = (0..n / 2).take_while(|k| law.cdf(*k as u64) <= ERROR_RATE / 2.0).count();
    if outside == 0 {
        return Some(Measured::open(value, n));
    }
    let (low, high) = (sorted[outside - 1], sorted[n - outside]);
    Some(Measured { value, low, high, runs: n })
}

/// The value below which a share of the values lies; none of no values.
#[must_use]
pub fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to last")]
    let at = (share.clamp(0.0, 1.0) * last as f64).round() as usize;
    sorted.get(at).copied()
}

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "ends of intervals that are exactly 0, 1 or infinite")]

    use super::*;

    fn near(found: f64, expected: f64) -> bool {
        (found - expected).abs() < 1e-4 * expected.abs().max(1e-3)
    }

    #[test]
    fn shares_are_those_of_clopper_and_pearson() {
        // Published: 0 of 300 is below 1.22 % two-sided, 1 - 0.025^(1/300).
        let none = share(0, 300).unwrap();
        assert!(none.low == 0.0 && near(none.high, 1.0 - 0.025_f64.powf(1.0 / 300.0)));
        let all = share(200, 200).unwrap();
        assert!(all.high == 1.0 && near(all.low, 0.025_f64.powf(1.0 / 200.0)));
        // Tabulated: 2 of 10.
        let some = share(2, 10).unwrap();
        assert!(near(some.low, 0.025_211) && near(some.high, 0.556_095), "{some:?}");
    }

    #[test]
    fn counts_are_those_of_poisson() {
        // Garwood's tables: 0 gives 3.6889, 10 gives 4.7954 to 18.3904.
        assert!(near(mean_count(0.0, 1).unwrap().high, 3.688_88));
        let ten = mean_count(10.0, 5).unwrap();
        assert!(near(ten.low, 4.795_39 / 5.0) && near(ten.high, 18.390_36 / 5.0), "{ten:?}");
    }

    #[test]
    fn squares_are_those_of_chi_square() {
        // 5 states, 50 runs: the mean of a consistent filter lies in [4.16, 5.91], so that of
        // 5.91 hardly comes from less than 5.
        let found = mean_square(&[5.914; 50], 5.0, 0.05).unwrap();
        assert!(near(found.low, 5.0) || (found.low - 5.0).abs() < 5e-3, "{found:?}");
    }

    #[test]
    fn means_are_those_of_student() {
        // Two values 0 and 2: 1 ± 12.7062.
        let found = mean(&[0.0, 2.0]).unwrap();
        assert!(near(found.high - found.value, 12.7062), "{found:?}");
    }

    #[test]
    fn medians_lie_between_order_statistics() {
        let values: Vec<f64> = (1..=50).map(f64::from).collect();
        let found = median(&values).unwrap();
        // Tabulated for 50: the 18th and the 33rd.
        assert_eq!((found.low, found.high), (18.0, 33.0));
        assert_eq!(median(&values[..5]).unwrap().high, f64::INFINITY);
        assert_eq!(median(&[]), None);
    }

    #[test]
    fn a_root_mean_square_of_200_is_known_to_ten_percent() {
        let found = rms(&[2.0; 200]).unwrap();
        assert!(near(found.low, 2.0 * 0.902) && near(found.high, 2.0 * 1.098), "{found:?}");
        assert_eq!(rms(&[1.0, f64::INFINITY]).unwrap().low, f64::INFINITY);
    }
}
