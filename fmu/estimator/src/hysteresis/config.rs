//! What a filter with friction in the thread is told of it.

use crate::config::{ConfigError, judge, not_negative};

/// One degree, rad.
pub(super) const DEG: f64 = core::f64::consts::PI / 180.0;

/// What is believed of the friction in the thread: medians, and standard deviations of logarithms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct YieldPrior {
    /// Yield angle, rad: the largest friction torque over the thread's stiffness. From 0.001 to 30.
    pub yield_angle_rad: f64,
    /// Standard deviation of its logarithm. Not negative.
    pub yield_angle_log_sigma: f64,
    /// Stiffness k_h of the friction before it yields over the stiffness k of the thread. From 0.3
    /// to 1000.
    pub stiffness_ratio: f64,
    /// Standard deviation of its logarithm. Not negative.
    pub stiffness_ratio_log_sigma: f64,
    /// Standard deviation of the friction at the start, about zero, as a share of its largest. Not
    /// negative.
    pub preload_sigma: f64,
}

impl YieldPrior {
    /// A yield angle within a factor of 1.8 of the given one, and k_h = 13.5 k within a factor of
    /// two; the thread is released with 0 ± 0.3 of its friction.
    #[must_use]
    pub const fn around(yield_angle_rad: f64) -> Self {
        Self {
            yield_angle_rad,
            yield_angle_log_sigma: 0.6,
            // exp(0.3) times ten: the logarithm is skewed towards stiff threads, where the ratio
            // matters least.
            stiffness_ratio: 13.498_588_075_760_032,
            stiffness_ratio_log_sigma: 0.7,
            preload_sigma: 0.3,
        }
    }

    /// The four priors of the bank: about 3°, 8°, 20° and 50°, so that each reaches its neighbour
    /// within one and a half of its sigmas.
    pub const BANK: [Self; 4] = [
        Self::around(3.0 * DEG),
        Self::around(8.0 * DEG),
        Self::around(20.0 * DEG),
        Self::around(50.0 * DEG),
    ];

    /// Checks every value against its bound.
    ///
    /// # Errors
    /// [`ConfigError`] names the first value out of its bound.
    pub fn validate(&self) -> Result<(), ConfigError> {
        let angle = self.yield_angle_rad;
        let bound = "from 0.001 to 30 rad";
        judge("yield_angle_rad", angle, (1e-3..=30.0).contains(&angle), bound)?;
        not_negative("yield_angle_log_sigma", self.yield_angle_log_sigma)?;
        let ratio = self.stiffness_ratio;
        let bound = "from 0.3 to 1000";
        judge("stiffness_ratio", ratio, (0.3..=1000.0).contains(&ratio), bound)?;
        not_negative("stiffness_ratio_log_sigma", self.stiffness_ratio_log_sigma)?;
        not_negative("preload_sigma", self.preload_sigma)
    }
}
