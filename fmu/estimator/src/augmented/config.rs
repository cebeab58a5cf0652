//! What the five-state filter is told before it starts.

use super::state::{Covariance5, Densities, Mean, State};
use crate::config::{ConfigError, judge, not_negative, positive};

/// One degree, rad.
const DEG: f64 = core::f64::consts::PI / 180.0;
/// Periods that can be squared and squared again without leaving the range of floating point.
const PERIOD_S: (f64, f64) = (1e-6, 1e12);

/// What is believed of the motion at the start: a mean and a standard deviation of each quantity,
/// all independent. SI units; no sigma is negative.
///
/// A sigma of zero is certainty: that quantity is then never learnt from the measurements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StartPrior {
    /// Angle from equilibrium, rad.
    pub angle_rad: f64,
    /// Its standard deviation, rad.
    pub angle_sigma_rad: f64,
    /// Rate, rad/s.
    pub rate_rad_s: f64,
    /// Its standard deviation, rad/s.
    pub rate_sigma_rad_s: f64,
    /// Period 2π/Ω of undamped torsion, s. From 1e-6 to 1e12.
    pub period_s: f64,
    /// Its standard deviation, s.
    pub period_sigma_s: f64,
    /// Damping ratio ζ. Not negative.
    pub damping_ratio: f64,
    /// Its standard deviation.
    pub damping_ratio_sigma: f64,
    /// Bias of the gyro, rad/s.
    pub bias_rad_s: f64,
    /// Its standard deviation, rad/s.
    pub bias_sigma_rad_s: f64,
}

impl StartPrior {
    /// A body let go at rest at about `angle_rad`, on a string whose period was timed by hand: 100°
    /// about the angle, 0.01 °/s about rest, 1 % of the period, ζ = 0.03 ± 0.01, a bias of
    /// 0 ± 0.05 °/s.
    #[must_use]
    pub const fn released(angle_rad: f64, period_s: f64) -> Self {
        Self {
            angle_rad,
            angle_sigma_rad: 100.0 * DEG,
            rate_rad_s: 0.0,
            rate_sigma_rad_s: 0.01 * DEG,
            period_s,
            period_sigma_s: 0.01 * period_s,
            damping_ratio: 0.03,
            damping_ratio_sigma: 0.01,
            bias_rad_s: 0.0,
            bias_sigma_rad_s: 0.05 * DEG,
        }
    }

    fn validate(&self) -> Result<(), ConfigError> {
        let finite = |name, value| judge(name, value, true, "a number");
        finite("angle_rad", self.angle_rad)?;
        not_negative("angle_sigma_rad", self.angle_sigma_rad)?;
        finite("rate_rad_s", self.rate_rad_s)?;
        not_negative("rate_sigma_rad_s", self.rate_sigma_rad_s)?;
        let (shortest_s, longest_s) = PERIOD_S;
        let ok = (shortest_s..=longest_s).contains(&self.period_s);
        judge("period_s", self.period_s, ok, "from 1e-6 to 1e12 s")?;
        not_negative("period_sigma_s", self.period_sigma_s)?;
        not_negative("damping_ratio", self.damping_ratio)?;
        not_negative("damping_ratio_sigma", self.damping_ratio_sigma)?;
        finite("bias_rad_s", self.bias_rad_s)?;
        not_negative("bias_sigma_rad_s", self.bias_sigma_rad_s)
    }

    /// The same in the filter's own coordinates, to first order in the parameters.
    ///
    /// α = −s·φ is a product of two independent numbers, whose variance is known exactly.
    pub(super) fn state(&self) -> State {
        let omega = core::f64::consts::TAU / self.period_s;
        let s = omega * omega;
        let s_sigma = 2.0 * s * self.period_sigma_s / self.period_s;
        let (angle2, s2) = (self.angle_sigma_rad * self.angle_sigma_rad, s_sigma * s_sigma);
        let d_sigma = 2.0 * omega * self.damping_ratio_sigma;
        let p = Covariance5 {
            aa: s * s * angle2 + self.angle_rad * self.angle_rad * s2 + s2 * angle2,
            as_: -self.angle_rad * s2,
            ww: self.rate_sigma_rad_s * self.rate_sigma_rad_s,
            ss: s2,
            dd: d_sigma * d_sigma,
            bb: self.bias_sigma_rad_s * self.bias_sigma_rad_s,
            ..Covariance5::default()
        };
        let mean = Mean {
            alpha: -s * self.angle_rad,
            rate: self.rate_rad_s,
            s,
            d: 2.0 * self.damping_ratio * omega,
            bias: self.bias_rad_s,
        };
        State { mean, p }
    }
}

/// Start belief and noise of the five-state filter. SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AugmentedConfig {
    /// What is believed at the start.
    pub start: StartPrior,
    /// Variance R of one measured rate, rad²/s². Positive. See
    /// [`measurement_variance_from_rest`](crate::measurement_variance_from_rest).
    pub measurement_variance_rad2_s2: f64,
    /// Density q of white angular acceleration, rad²/s³. Not negative.
    pub process_noise_rad2_s3: f64,
    /// Density of the random walk of the bias, rad²/s³. Not negative.
    pub bias_walk_rad2_s3: f64,
    /// Standard deviation of the gyro's scale factor, relative. Not negative. It widens what is
    /// claimed and nothing else: no motion shows a scale factor, since every solution times a
    /// constant is a solution.
    pub scale_factor_sigma: f64,
    /// Measured rates at least this large are over range, rad/s: they come from a clipped gyro and
    /// are not used. Positive; none when the gyro cannot clip. See
    /// [`usable_rate_rad_s`](crate::usable_rate_rad_s).
    pub rate_limit_rad_s: Option<f64>,
}

impl AugmentedConfig {
    /// A quiet laboratory: q = (3.2e-5 °/s²)²/Hz, a bias walk of 1e-6 °/s/√s, and a perfect scale
    /// factor.
    #[must_use]
    pub const fn quiet(start: StartPrior, measurement_variance_rad2_s2: f64) -> Self {
        Self {
            start,
            measurement_variance_rad2_s2,
            process_noise_rad2_s3: 1e-9 * DEG * DEG,
            bias_walk_rad2_s3: 1e-12 * DEG * DEG,
            scale_factor_sigma: 0.0,
            rate_limit_rad_s: None,
        }
    }

    /// Checks every value against its bound.
    ///
    /// # Errors
    /// [`ConfigError`] names the first value out of its bound.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.start.validate()?;
        positive("measurement_variance_rad2_s2", self.measurement_variance_rad2_s2)?;
        not_negative("process_noise_rad2_s3", self.process_noise_rad2_s3)?;
        not_negative("bias_walk_rad2_s3", self.bias_walk_rad2_s3)?;
        not_negative("scale_factor_sigma", self.scale_factor_sigma)?;
        if let Some(limit_rad_s) = self.rate_limit_rad_s {
            positive("rate_limit_rad_s", limit_rad_s)?;
        }
        Ok(())
    }

    pub(super) fn densities(&self) -> Densities {
        Densities { acceleration: self.process_noise_rad2_s3, bias: self.bias_walk_rad2_s3 }
    }
}
