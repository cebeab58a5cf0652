//! How punctual a pacer has been.

use hdrhistogram::Histogram;

const NS_PER_S: f64 = 1e9;
/// Longer delays count as this one: an hour, ns.
const DELAY_NS_MAX: u64 = 3_600_000_000_000;
/// Digits to which quantiles are kept.
const DIGITS: u8 = 3;

/// Delays of one kind. Mean and maximum are exact, quantiles good to a thousandth of themselves.
#[derive(Debug, Clone, PartialEq)]
pub struct Delays {
    histogram: Histogram<u64>,
    max_ns: u64,
    sum_ns: u128,
}

impl Default for Delays {
    fn default() -> Self {
        let histogram = Histogram::new_with_bounds(1, DELAY_NS_MAX, DIGITS)
            .expect("the bounds are constant and tested");
        Self { histogram, max_ns: 0, sum_ns: 0 }
    }
}

impl Delays {
    /// How many there were.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.histogram.len()
    }

    /// The longest, s; zero when there was none.
    #[must_use]
    pub fn max_s(&self) -> f64 {
        self.max_ns as f64 / NS_PER_S
    }

    /// The mean, s; zero when there was none.
    #[must_use]
    pub fn mean_s(&self) -> f64 {
        if self.count() == 0 {
            return 0.0;
        }
        self.sum_ns as f64 / self.count() as f64 / NS_PER_S
    }

    /// The delay that a share `quantile` of all does not exceed, s; zero when there was none.
    #[must_use]
    pub fn quantile_s(&self, quantile: f64) -> f64 {
        // A class of the histogram is told by its upper end, which may lie beyond the maximum.
        self.histogram.value_at_quantile(quantile).min(self.max_ns) as f64 / NS_PER_S
    }

    /// Counts one delay, ns; what is before its time is not late.
    pub fn record(&mut self, delay_ns: i64) {
        let delay_ns = u64::try_from(delay_ns).unwrap_or(0);
        self.histogram.saturating_record(delay_ns);
        self.max_ns = self.max_ns.max(delay_ns);
        self.sum_ns += u128::from(delay_ns);
    }
}

/// How punctual a [`Pacer`](crate::Pacer) has been. For reports: nothing may be decided by it.
///
/// A late wait is one of two kinds, because they have two cures. Either the instant had passed when
/// the wait began, so the bench itself was behind (`overrun`: a faster machine or less to compute);
/// or the wait began in time and the system woke it late (`oversleep`: a quieter machine or a
/// real-time priority).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Lateness {
    /// Waits whose instant had passed, by how late they began.
    pub overrun: Delays,
    /// All other waits, by how late they ended.
    pub oversleep: Delays,
}

impl Lateness {
    /// Waits so far.
    #[must_use]
    pub fn waits(&self) -> u64 {
        self.overrun.count() + self.oversleep.count()
    }

    /// The longest delay after an instant, s.
    #[must_use]
    pub fn max_s(&self) -> f64 {
        self.overrun.max_s().max(self.oversleep.max_s())
    }

    /// The mean delay after an instant, s; zero before the first wait.
    #[must_use]
    pub fn mean_s(&self) -> f64 {
        if self.waits() == 0 {
            return 0.0;
        }
        let sum_ns = self.overrun.sum_ns + self.oversleep.sum_ns;
        sum_ns as f64 / self.waits() as f64 / NS_PER_S
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_and_the_maximum_are_those_of_the_delays() {
        let mut lateness = Lateness::default();
        assert!(lateness.mean_s().abs() < f64::EPSILON);
        lateness.overrun.record(1_000_000);
        lateness.oversleep.record(5_000_000);
        lateness.oversleep.record(-7);
        assert_eq!((lateness.waits(), lateness.overrun.count()), (3, 1));
        // One rounding in each of two divisions.
        assert!((lateness.mean_s() - 0.002).abs() < 1e-15);
        assert!((lateness.max_s() - 0.005).abs() < 1e-15);
        assert!((lateness.oversleep.mean_s() - 0.0025).abs() < 1e-15);
    }

    #[test]
    fn quantiles_are_those_of_the_sorted_delays() {
        let mut delays = Delays::default();
        for ns in (1..=100_000).rev() {
            delays.record(ns);
        }
        for quantile in [0.5, 0.9, 0.99, 0.999] {
            let expected_s = quantile * 1e-4;
            let found_s = delays.quantile_s(quantile);
            // Three digits are kept.
            assert!((found_s / expected_s - 1.0).abs() < 1e-3, "{quantile}: {found_s}");
        }
        assert!((delays.quantile_s(1.0) - delays.max_s()).abs() < f64::EPSILON);
        delays.record(i64::MAX);
        assert!((delays.max_s() / 9.223_372_036_854_776e9 - 1.0).abs() < 1e-15);
        assert!(delays.quantile_s(1.0) >= 3600.0, "clipped in the histogram alone");
    }
}
