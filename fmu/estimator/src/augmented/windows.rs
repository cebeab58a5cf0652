//! The windowed test of the innovations: thresholds, and the statistic.

use crate::config::{ConfigError, judge, positive};

/// Lengths of the windows, samples.
pub(crate) const LENGTHS: [u16; 12] = [3, 4, 6, 8, 16, 32, 64, 128, 256, 512, 1024, 2048];
/// Longest window, samples.
pub(crate) const LENGTH_MAX: usize = 2048;
/// Normalised innovations are clipped here, so that an outlier weighs no more than three ordinary
/// samples of one sign. The shortest window can then not fire alone: 3·3 < 5.25·√3.
pub(crate) const CLIP: f64 = 3.0;
/// Half width of the gate for single samples, standard deviations.
pub(crate) const GATE: f64 = 5.0;
/// What the measurement variance of a gated sample is multiplied by.
pub(crate) const GATED_VARIANCE: f64 = 1e6;

/// How rarely the test may raise an alarm without a cause, and what an alarm reckons with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InnovationTest {
    /// False alarms per window length that may be expected in `horizon_samples`. In (0, 1).
    pub false_alarms: f64,
    /// Samples over which that many false alarms are allowed. At least 2048.
    pub horizon_samples: u32,
    /// Kick that an alarm reckons with on top of the one seen, rad/s. Not negative.
    pub kick_floor_rad_s: f64,
}

impl InnovationTest {
    /// One false alarm in 125 runs of 48 000 samples for each of twelve windows and either sign, so
    /// 1.4 an hour at 100 Hz; and a floor of 0.02 °/s.
    pub const STANDARD: Self = Self {
        false_alarms: 0.008,
        horizon_samples: 48_000,
        kick_floor_rad_s: 0.02 * core::f64::consts::PI / 180.0,
    };

    /// Checks every value against its bound.
    ///
    /// # Errors
    /// [`ConfigError`] names the first value out of its bound.
    pub fn validate(&self) -> Result<(), ConfigError> {
        positive("false_alarms", self.false_alarms)?;
        judge("false_alarms", self.false_alarms, self.false_alarms < 1.0, "less than 1")?;
        let horizon = f64::from(self.horizon_samples);
        judge("horizon_samples", horizon, horizon >= 2048.0, "at least 2048")?;
        crate::config::not_negative("kick_floor_rad_s", self.kick_floor_rad_s)
    }

    /// Threshold of the mean over `length` samples, standard deviations: Φ⁻¹(1 − p·L/8n).
    ///
    /// Windows of L samples overlap, and about 8 of them in a stretch of L behave as if they were
    /// independent; so the shares p are alike for all lengths.
    #[must_use]
    pub fn threshold(&self, length_samples: u16) -> f64 {
        let tail =
            self.false_alarms * f64::from(length_samples) / (8.0 * f64::from(self.horizon_samples));
        upper_quantile(tail)
    }
}

/// x with Φ(−x) = `tail`, for a tail in (0, ½).
fn upper_quantile(tail: f64) -> f64 {
    let beyond = |x: f64| 0.5 * libm::erfc(x * core::f64::consts::FRAC_1_SQRT_2);
    // Bisection: 60 halvings of [0, 40] leave 4e-17, and it is done a dozen times in a life.
    let (mut low, mut high) = (0.0, 40.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if beyond(middle) > tail { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// The windows of one test, ready for use.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Windows {
    thresholds: [f64; LENGTHS.len()],
    /// 1/(threshold·√L).
    weights: [f64; LENGTHS.len()],
}

impl Windows {
    pub(crate) fn new(test: &InnovationTest) -> Self {
        let thresholds = LENGTHS.map(|length| test.threshold(length));
        let weight = |k: usize| 1.0 / (thresholds[k] * libm::sqrt(f64::from(LENGTHS[k])));
        Self { thresholds, weights: core::array::from_fn(weight) }
    }

    /// Whether any of the windows within `reach` samples is beyond its threshold; `sum_over` gives
    /// the sum of the clipped innovations of the last so many samples.
    #[inline(always)]
    pub(crate) fn any_beyond(&self, reach: usize, sum_over: impl Fn(usize) -> f64) -> bool {
        let mut beyond = false;
        for (length, weight) in LENGTHS.into_iter().zip(self.weights) {
            let length = usize::from(length);
            // Without a branch: a window that reaches too far is looked at and not counted.
            beyond |= (sum_over(length).abs() * weight > 1.0) & (length <= reach);
        }
        beyond
    }

    /// Length of the window that is furthest beyond its threshold.
    pub(crate) fn furthest(&self, reach: usize, sum_over: impl Fn(usize) -> f64) -> usize {
        let mut furthest = (f64::NEG_INFINITY, usize::from(LENGTHS[0]));
        for (length, threshold) in LENGTHS.into_iter().zip(self.thresholds) {
            let (length, root) = (usize::from(length), libm::sqrt(f64::from(length)));
            if length > reach {
                break;
            }
            let excess = sum_over(length).abs() / root - threshold;
            if excess > furthest.0 {
                furthest = (excess, length);
            }
        }
        furthest.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_thresholds_are_the_published_ones() {
        // Φ⁻¹(1 − 0.01·L/(8·48 000)), to the two digits printed.
        let test = InnovationTest { false_alarms: 0.01, ..InnovationTest::STANDARD };
        let published = [5.25, 5.19, 5.12, 5.06, 4.93, 4.79, 4.65, 4.50, 4.35, 4.20, 4.04, 3.87];
        for (length, published) in LENGTHS.into_iter().zip(published) {
            let threshold = test.threshold(length);
            assert!((threshold - published).abs() < 0.0051, "{length}: {threshold}");
        }
    }

    #[test]
    fn three_clipped_samples_do_not_fire_and_four_do() {
        let windows = Windows::new(&InnovationTest::STANDARD);
        let outliers = |n: usize| move |length: usize| CLIP * n.min(length) as f64;
        assert!(!windows.any_beyond(LENGTH_MAX, outliers(3)));
        assert!(windows.any_beyond(LENGTH_MAX, outliers(4)));
        assert_eq!(windows.furthest(LENGTH_MAX, outliers(4)), 4);
    }

    #[test]
    fn windows_do_not_reach_behind_the_last_alarm() {
        let windows = Windows::new(&InnovationTest::STANDARD);
        assert!(!windows.any_beyond(3, |length| CLIP * length as f64));
        assert!(windows.any_beyond(4, |length| CLIP * length as f64));
    }
}
