//! What the five-state filter is told before it starts.

use super::rounding::Rounding;
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

    pub(crate) fn validate(&self) -> Result<(), ConfigError> {
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
    /// Variance R of one measured rate, rad²/s², rounding included: what
    /// [`measurement_variance_from_rest`](crate::measurement_variance_from_rest) makes of a record.
    /// Positive. One who is told of an under-dithered quantiser takes from it only what exceeds the
    /// declared noise and white rounding, (σ² + step²/12)/samples; any other, no less than that.
    pub measurement_variance_rad2_s2: f64,
    /// Density q of white angular acceleration, rad²/s³. Not negative.
    pub process_noise_rad2_s3: f64,
    /// Density of the random walk of the bias, rad²/s³. Not negative.
    pub bias_walk_rad2_s3: f64,
    /// Standard deviation of the gyro's scale factor, relative. Not negative. It widens what is
    /// claimed and nothing else: no motion shows a scale factor, since every solution times a
    /// constant is a solution.
    pub scale_factor_sigma: f64,
    /// Range of the gyro; none when it cannot clip.
    pub range: Option<GyroRange>,
    /// How coarsely the gyro counts; none when its counts are fine.
    pub quantiser: Option<Quantiser>,
}

/// How coarsely the gyro counts, where that is known: each sample is rounded to the nearest count
/// by itself, and a measured rate is the mean of some.
///
/// A gyro that rounds down is one with half a count less of bias.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantiser {
    /// One count, rad/s. From 1e-100 to 1e100.
    pub step_rad_s: f64,
    /// Standard deviation of the raw samples before they are counted and averaged, rad/s. Not
    /// negative.
    pub raw_sigma_rad_s: f64,
    /// Samples in a measured rate. Positive.
    pub samples: u32,
}

impl Quantiser {
    /// Raw noise over step below which the steps bend the rate.
    const DITHER_MIN: f64 = 0.5;
    /// What R is multiplied by then for a filter that knows of no rounding.
    const UNDER_DITHERED_VARIANCE: f64 = 10.0;
    /// Steps whose squares are numbers.
    const STEP_RAD_S: (f64, f64) = (1e-100, 1e100);

    /// Whether the noise is too small to carry the rate across a count: averages are then bent by
    /// up to step/π·exp(−2π²σ²/step²), which changes with the rate.
    #[must_use]
    pub fn is_under_dithered(&self) -> bool {
        self.raw_sigma_rad_s < Self::DITHER_MIN * self.step_rad_s
    }

    /// What to multiply R by for a filter that knows of no rounding: 10 for an under-dithered
    /// quantiser, 1 otherwise.
    #[must_use]
    pub fn variance_factor(&self) -> f64 {
        if self.is_under_dithered() { Self::UNDER_DITHERED_VARIANCE } else { 1.0 }
    }

    /// Variance of a measured rate whose rounding is white noise of step²/12 a sample, rad²/s².
    pub(super) fn dithered_variance_rad2_s2(&self) -> f64 {
        let (sigma, step) = (self.raw_sigma_rad_s, self.step_rad_s);
        (sigma * sigma + step * step / 12.0) / f64::from(self.samples)
    }

    fn validate(&self) -> Result<(), ConfigError> {
        let (least, most) = Self::STEP_RAD_S;
        let ok = (least..=most).contains(&self.step_rad_s);
        judge("step_rad_s", self.step_rad_s, ok, "from 1e-100 to 1e100 rad/s")?;
        not_negative("raw_sigma_rad_s", self.raw_sigma_rad_s)?;
        judge("samples", f64::from(self.samples), self.samples > 0, "positive")
    }
}

/// Where a gyro clips, and how far from there its samples are spoilt.
///
/// Samples at the limit tell little, and those just below it had their noise clipped on one side.
/// Which ones to leave out must not depend on the noise either: to drop what measures too much
/// keeps the noise that points inwards, and that is a bias again. So a sample is left out when the
/// rate *expected* lies within the margin, and by its own value only at the very limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GyroRange {
    /// Largest rate that the gyro can tell, rad/s. Positive.
    pub limit_rad_s: f64,
    /// Width below the limit in which samples are not used, rad/s. Not negative, below the limit.
    pub margin_rad_s: f64,
}

impl GyroRange {
    /// Share of the margin next to the limit in which a sample is left out by its own value: one
    /// raw standard deviation of five.
    const EDGE: f64 = 0.2;

    /// A margin of five standard deviations of the raw samples, before any averaging.
    #[must_use]
    pub const fn with_raw_sigma(limit_rad_s: f64, raw_sigma_rad_s: f64) -> Self {
        Self { limit_rad_s, margin_rad_s: 5.0 * raw_sigma_rad_s }
    }

    pub(crate) fn validate(&self) -> Result<(), ConfigError> {
        positive("limit_rad_s", self.limit_rad_s)?;
        let ok = (0.0..self.limit_rad_s).contains(&self.margin_rad_s);
        judge("margin_rad_s", self.margin_rad_s, ok, "not negative and below limit_rad_s")
    }

    /// Least expected rate, and least measured rate, that are over range.
    pub(crate) fn edges_rad_s(&self) -> (f64, f64) {
        let edge = self.limit_rad_s - Self::EDGE * self.margin_rad_s;
        (self.limit_rad_s - self.margin_rad_s, edge)
    }
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
            range: None,
            quantiser: None,
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
        self.range.map_or(Ok(()), |range| range.validate())?;
        self.quantiser.map_or(Ok(()), |quantiser| quantiser.validate())
    }

    /// R, and no less than the declared noise and its rounding have, rad²/s².
    pub(super) fn dithered_variance_rad2_s2(&self) -> f64 {
        let declared =
            self.quantiser.map_or(0.0, |quantiser| quantiser.dithered_variance_rad2_s2());
        self.measurement_variance_rad2_s2.max(declared)
    }

    /// The quantiser, where an update has to reckon with it.
    pub(super) fn rounding(&self) -> Option<Rounding> {
        let coarse = self.quantiser.filter(Quantiser::is_under_dithered)?;
        Some(Rounding::new(&coarse, self.measurement_variance_rad2_s2))
    }

    /// The same for a filter that knows of no rounding: its steps are noise there, and what they
    /// bend the rate by has to be covered by more of it.
    pub(crate) fn without_quantiser(&self) -> Self {
        let factor = self.quantiser.map_or(1.0, |quantiser| quantiser.variance_factor());
        let measurement_variance_rad2_s2 = factor * self.measurement_variance_rad2_s2;
        Self { measurement_variance_rad2_s2, quantiser: None, ..*self }
    }

    pub(super) fn densities(&self) -> Densities {
        Densities { acceleration: self.process_noise_rad2_s3, bias: self.bias_walk_rad2_s3 }
    }
}
