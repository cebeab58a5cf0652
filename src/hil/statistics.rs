//! Figures of a line: error rate, gaps, time between frames.

use hdrhistogram::Histogram;
use serde::Serialize;
use statrs::function::beta::beta_reg;
use struna_kernel::SimTime;

/// Error rates are given with an interval that holds the true one with this probability at least.
const CONFIDENCE: f64 = 0.95;
/// Longest time between frames that the histogram tells apart, us.
const BETWEEN_US_MAX: u64 = 3_600_000_000;
/// Times between frames are told apart to three digits.
const DIGITS: u8 = 3;
/// Halvings of an interval of probabilities until it is as narrow as numbers are.
const HALVINGS: u32 = 100;

/// A share of errors and the interval of Clopper and Pearson around it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ErrorRate {
    /// Errors over trials.
    pub rate: f64,
    /// Lower end of the 95 % interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl ErrorRate {
    /// The rate of `errors` in `trials`; none without a trial.
    ///
    /// The interval is exact: it holds the true rate with at least 95 % probability, whatever that
    /// rate is. For no error in n trials its upper end is near 3.7/n.
    ///
    /// # Source
    /// Clopper and Pearson, *The use of confidence or fiducial limits illustrated in the case of
    /// the binomial*, 1934.
    #[must_use]
    pub fn of(errors: u64, trials: u64) -> Option<Self> {
        if trials == 0 || errors > trials {
            return None;
        }
        let (x, n) = (errors as f64, trials as f64);
        let tail = (1.0 - CONFIDENCE) / 2.0;
        let low = if errors == 0 { 0.0 } else { quantile(tail, x, n - x + 1.0) };
        let high = if errors == trials { 1.0 } else { quantile(1.0 - tail, x + 1.0, n - x) };
        Some(Self { rate: x / n, low, high })
    }
}

/// Quantile of the beta distribution, by halving: the distribution function is monotone.
fn quantile(probability: f64, a: f64, b: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if beta_reg(a, b, middle) < probability {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// How many gaps lost so many samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct GapBin {
    /// Fewest samples lost.
    pub lost_from: u64,
    /// Most samples lost.
    pub lost_to: u64,
    /// Gaps.
    pub gaps: u64,
}

/// Gaps by the samples that they lost, in bins that double: 0, 1, 2 to 3, 4 to 7 and so on.
#[derive(Debug, Clone)]
pub struct Gaps {
    bins: [u64; 65],
}

impl Default for Gaps {
    fn default() -> Self {
        Self { bins: [0; 65] }
    }
}

impl Gaps {
    /// Counts a gap.
    pub fn add(&mut self, lost: u64) {
        let bin = (u64::BITS - lost.leading_zeros()) as usize;
        self.bins[bin] += 1;
    }

    /// The bins that hold anything.
    #[must_use]
    pub fn bins(&self) -> Vec<GapBin> {
        let ends = |bin: usize| match bin {
            0 => (0, 0),
            64 => (1 << 63, u64::MAX),
            bin => (1 << (bin - 1), (1 << bin) - 1),
        };
        let bin = |(bin, gaps): (usize, &u64)| {
            let (lost_from, lost_to) = ends(bin);
            GapBin { lost_from, lost_to, gaps: *gaps }
        };
        self.bins.iter().enumerate().filter(|(_, gaps)| **gaps > 0).map(bin).collect()
    }
}

/// Times from one frame's arrival to the next one's, s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BetweenFrames {
    /// Half of them are shorter.
    pub p50_s: f64,
    /// 90 % are shorter.
    pub p90_s: f64,
    /// 99 % are shorter.
    pub p99_s: f64,
    /// 99.9 % are shorter.
    pub p99_9_s: f64,
    /// The longest.
    pub max_s: f64,
}

/// Gathers times between frames in fixed memory.
#[derive(Debug, Clone)]
pub struct Arrivals {
    between_us: Histogram<u64>,
    last: Option<SimTime>,
}

impl Default for Arrivals {
    fn default() -> Self {
        let between_us = Histogram::new_with_max(BETWEEN_US_MAX, DIGITS)
            .expect("the range and the digits are constants that it takes");
        Self { between_us, last: None }
    }
}

impl Arrivals {
    /// Notes a frame.
    pub fn add(&mut self, arrival: SimTime) {
        if let Some(last) = self.last {
            let us = arrival.as_ns().saturating_sub(last.as_ns()) / 1000;
            self.between_us.saturating_record(u64::try_from(us).unwrap_or(0));
        }
        self.last = Some(arrival);
    }

    /// The times so far, if there are any.
    #[must_use]
    pub fn between(&self) -> Option<BetweenFrames> {
        let seconds = |us: u64| us as f64 / 1e6;
        let at = |share| seconds(self.between_us.value_at_quantile(share));
        (!self.between_us.is_empty()).then(|| BetweenFrames {
            p50_s: at(0.5),
            p90_s: at(0.9),
            p99_s: at(0.99),
            p99_9_s: at(0.999),
            max_s: seconds(self.between_us.max()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_clopper_and_pearson_agrees_with_closed_forms() {
        // No error: the upper end solves (1 - p)^n = 0.025; all errors: p^n = 0.025.
        for n in [1_u32, 10, 1000] {
            let tail = 0.025_f64.powf(1.0 / f64::from(n));
            let none = ErrorRate::of(0, u64::from(n)).unwrap();
            let all = ErrorRate::of(u64::from(n), u64::from(n)).unwrap();
            // The incomplete beta function is good to some 1e-13.
            assert!((none.high - (1.0 - tail)).abs() < 1e-11 && none.low.abs() < f64::EPSILON);
            assert!((all.low - tail).abs() < 1e-11 && (all.high - 1.0).abs() < f64::EPSILON);
        }
        assert_eq!(ErrorRate::of(0, 0), None);
    }

    #[test]
    fn the_interval_s_ends_leave_a_fortieth_on_each_side() {
        // P(X >= 3 | low) = P(X <= 3 | high) = 0.025 for 3 of 20, summed term by term.
        let found = ErrorRate::of(3, 20).unwrap();
        let below = |p: f64, to: i32| -> f64 {
            let term = |k: i32| {
                let choose = (0..k).fold(1.0, |c, j| c * f64::from(20 - j) / f64::from(j + 1));
                choose * p.powi(k) * (1.0 - p).powi(20 - k)
            };
            (0..=to).map(term).sum()
        };
        assert!((1.0 - below(found.low, 2) - 0.025).abs() < 1e-11, "{found:?}");
        assert!((below(found.high, 3) - 0.025).abs() < 1e-11, "{found:?}");
    }

    #[test]
    fn gaps_fall_into_bins_that_double() {
        let mut gaps = Gaps::default();
        [0, 1, 2, 3, 4, 7, 8, u64::MAX].into_iter().for_each(|lost| gaps.add(lost));
        let bins: Vec<_> =
            gaps.bins().iter().map(|bin| (bin.lost_from, bin.lost_to, bin.gaps)).collect();
        let last = (1 << 63, u64::MAX, 1);
        assert_eq!(bins, [(0, 0, 1), (1, 1, 1), (2, 3, 2), (4, 7, 2), (8, 15, 1), last]);
    }

    #[test]
    fn times_between_frames_are_found_again() {
        let mut arrivals = Arrivals::default();
        assert_eq!(arrivals.between(), None);
        let mut now_us = 0;
        for k in 0..=1000 {
            arrivals.add(SimTime::from_ns(now_us * 1000));
            now_us += if k == 999 { 250_000 } else { 3333 };
        }
        let between = arrivals.between().unwrap();
        // Three digits.
        assert!((between.p50_s - 3.333e-3).abs() < 4e-6, "{between:?}");
        assert!((between.max_s - 0.25).abs() < 3e-4, "{between:?}");
    }
}
