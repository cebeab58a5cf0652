//! What a filter is told before it starts, and the one judge of it.

use crate::{Covariance, Refinement};

/// Start belief, noise and refinement of a two-state filter. SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilterConfig {
    /// Believed angle from equilibrium at the start, rad.
    pub angle_start_rad: f64,
    /// Believed rate at the start, rad/s.
    pub rate_start_rad_s: f64,
    /// Variance of the start angle, rad². Not negative.
    pub angle_variance_start_rad2: f64,
    /// Variance of the start rate, rad²/s². Not negative.
    pub rate_variance_start_rad2_s2: f64,
    /// Variance R of one measured rate, rad²/s². Positive.
    pub measurement_variance_rad2_s2: f64,
    /// Density q of white angular acceleration, rad²/s³. Zero is the papers' choice: none.
    pub process_noise_rad2_s3: f64,
    /// Covariance refinement.
    pub refinement: Refinement,
}

/// A parameter that no filter can work with.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{name} = {value} is refused: it must be finite and {bound}")]
pub struct ConfigError {
    /// The parameter's name, unit suffix included.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// The bound that it breaks.
    pub bound: &'static str,
}

impl FilterConfig {
    /// Checks every value against its bound.
    ///
    /// # Errors
    /// [`ConfigError`] names the first value out of its bound.
    pub fn validate(&self) -> Result<(), ConfigError> {
        any("angle_start_rad", self.angle_start_rad)?;
        any("rate_start_rad_s", self.rate_start_rad_s)?;
        not_negative("angle_variance_start_rad2", self.angle_variance_start_rad2)?;
        not_negative("rate_variance_start_rad2_s2", self.rate_variance_start_rad2_s2)?;
        positive("measurement_variance_rad2_s2", self.measurement_variance_rad2_s2)?;
        not_negative("process_noise_rad2_s3", self.process_noise_rad2_s3)
    }

    /// The start covariance, diagonal.
    pub(crate) fn covariance_start(&self) -> Covariance {
        Covariance::diagonal(self.angle_variance_start_rad2, self.rate_variance_start_rad2_s2)
    }
}

pub(crate) fn positive(name: &'static str, value: f64) -> Result<(), ConfigError> {
    judge(name, value, value > 0.0, "greater than 0")
}

pub(crate) fn not_negative(name: &'static str, value: f64) -> Result<(), ConfigError> {
    judge(name, value, value >= 0.0, "not negative")
}

fn any(name: &'static str, value: f64) -> Result<(), ConfigError> {
    judge(name, value, true, "a number")
}

pub(crate) fn judge(
    name: &'static str,
    value: f64,
    ok: bool,
    bound: &'static str,
) -> Result<(), ConfigError> {
    if ok && value.is_finite() { Ok(()) } else { Err(ConfigError { name, value, bound }) }
}
