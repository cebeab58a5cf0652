//! Estimates from so many runs, with the intervals that so many runs leave open.
//!
//! All intervals are two-sided and hold the true value in 95 of 100 campaigns, unless a level is
//! given.

use statrs::distribution::{Beta, Binomial, ChiSquared, ContinuousCDF, DiscreteCDF, StudentsT};

/// Share of campaigns in which an interval does not hold the true value.
pub const ERROR_RATE: f64 = 0.05;

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

/// Root of the mean square of errors, from the scatter of the squares: ± 1.96/√(2M) of itself for
/// normal errors, less for the mean of many within a run, more where some runs are far worse than
/// others. One infinite error makes it infinite.
#[must_use]
pub fn rms(errors: &[f64]) -> Option<Measured> {
    let squares: Vec<f64> = errors.iter().map(|error| error * error).collect();
    let Measured { value, low, high, runs } = mean(&squares)?;
    if value.is_infinite() {
        return Some(Measured { value, low: value, high: value, runs });
    }
    let root = |square: f64| square.max(0.0).sqrt();
    Some(Measured { value: root(value), low: root(low), high: root(high), runs })
}

/// Ratio of two root mean squares over the same runs. Where one follows the other the ratio has
/// hardly any scatter, however much each has; so its interval is that of the differences. One
/// infinite error above makes it infinite.
#[must_use]
pub fn ratio(above: &[f64], below: &[f64]) -> Option<Measured> {
    let mean_of = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64;
    if mean_of(above).is_infinite() {
        return rms(above);
    }
    if above.len() != below.len() {
        return None;
    }
    let squared = mean_of(above) / mean_of(below);
    // Delta method: var(a/b) from the residuals a - (a/b)·b of single runs.
    let residuals: Vec<f64> =
        above.iter().zip(below).map(|(a, b)| a * a - squared * b * b).collect();
    let Measured { low, high, runs, .. } = mean(&residuals)?.over(mean_of(below));
    let root = |square: f64| square.max(0.0).sqrt();
    let (low, high) = (root(squared + low), root(squared + high));
    Some(Measured { value: root(squared), low, high, runs })
}

/// Runs for which a promise on each of them is made.
pub const RUNS_OF_A_PROMISE: usize = 50;

/// The largest of so many values: exactly that, and open above as long as there are fewer than
/// [`RUNS_OF_A_PROMISE`].
#[must_use]
pub fn largest(values: &[f64]) -> Option<Measured> {
    let value = values.iter().copied().max_by(f64::total_cmp)?;
    let runs = values.len();
    let high = if runs < RUNS_OF_A_PROMISE { f64::INFINITY } else { value };
    Some(Measured { value, low: value, high, runs })
}

/// Where the mean of `runs` squares of an honest claim on so many states lies.
#[must_use]
pub fn honest_mean_square(states: f64, runs: usize, error_rate: f64) -> Option<(f64, f64)> {
    let freedom = states * runs as f64;
    let at = |p: f64| chi_square(freedom, p).map(|quantile| quantile / runs as f64);
    Some((at(error_rate / 2.0)?, at(1.0 - error_rate / 2.0)?))
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
    use statrs::distribution::Normal;

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

    /// Errors whose distribution is normal: at the quantiles in the middles of equal shares.
    fn normal(n: usize) -> Vec<f64> {
        let law = Normal::new(0.0, 2.0).unwrap();
        (0..n).map(|k| law.inverse_cdf((k as f64 + 0.5) / n as f64)).collect()
    }

    #[test]
    fn a_root_mean_square_of_200_normal_errors_is_known_to_ten_percent() {
        let found = rms(&normal(200)).unwrap();
        // 1.96/√400 = 9.8 %; the outermost of 200 fall short of the tails by a per cent or two.
        assert!((found.low / 2.0 - 0.902).abs() < 0.01, "{found:?}");
        assert!((found.high / 2.0 - 1.098).abs() < 0.01, "{found:?}");
        // Of equal errors it is known exactly, of one not at all.
        let equal = rms(&[2.0; 200]).unwrap();
        assert!(near(equal.low, 2.0) && near(equal.high, 2.0), "{equal:?}");
        let one = rms(&[2.0]).unwrap();
        assert_eq!((one.low, one.high), (0.0, f64::INFINITY));
        assert_eq!(rms(&[1.0, f64::INFINITY]).unwrap().low, f64::INFINITY);
    }

    #[test]
    fn a_ratio_of_errors_that_go_together_is_known_well() {
        let other: Vec<f64> = (1..=20).map(f64::from).collect();
        let mine: Vec<f64> = other.iter().map(|v| 0.9 * v).collect();
        let found = ratio(&mine, &other).unwrap();
        assert!((found.value - 0.9).abs() < 1e-12 && found.high - found.low < 1e-6, "{found:?}");
        let shuffled: Vec<f64> = mine.iter().rev().copied().collect();
        let found = ratio(&shuffled, &other).unwrap();
        assert!(found.high - found.low > 0.3, "{found:?}");
        // A run that stopped is infinitely wrong, whether it has a bound or not.
        assert_eq!(ratio(&[1.0, f64::INFINITY], &[1.0, 1.0]).unwrap().low, f64::INFINITY);
        assert_eq!(ratio(&[1.0, f64::INFINITY], &[1.0]).unwrap().low, f64::INFINITY);
    }

    #[test]
    fn the_largest_of_few_is_open_above() {
        let found = largest(&[1.0; 49]).unwrap();
        assert_eq!((found.low, found.high), (1.0, f64::INFINITY));
        let mut values = [1.0; 50];
        values[7] = 4.0;
        let found = largest(&values).unwrap();
        assert_eq!((found.low, found.high), (4.0, 4.0));
    }

    #[test]
    fn honest_squares_lie_where_tables_say() {
        // Five states and fifty runs at 95 %: 4.16 to 5.91.
        let (low, high) = honest_mean_square(5.0, 50, 0.05).unwrap();
        assert!((low - 4.16).abs() < 5e-3 && (high - 5.91).abs() < 5e-3, "{low} {high}");
    }
}
