//! Arguments of `struna smooth`.

use super::positive;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Arguments of `struna smooth`.
#[derive(Debug, Args)]
pub struct Smooth {
    /// record.csv of `struna run` or `struna hil`, or a CSV with its columns `time` and
    /// `measured_rate_rad_s`
    #[arg(value_name = "RECORD.csv")]
    pub record: PathBuf,
    /// How to look back [default: map, and rts where the record holds more than map can tell]
    #[arg(long, value_enum)]
    pub method: Option<SmoothMethod>,
    /// Lag of fixed-lag, s
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = positive)]
    pub lag_s: f64,
    /// Folder for the results
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// What is believed beforehand.
    #[command(flatten)]
    pub prior: SmoothPrior,
    /// Times of kicks, in place of those that the innovations show (map only)
    #[arg(long, value_name = "S,S...", value_delimiter = ',', allow_negative_numbers = true)]
    pub kicks_s: Option<Vec<f64>>,
}

/// How `struna smooth` looks back.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SmoothMethod {
    /// The most probable damped torsion behind the whole record, kicks as breakpoints
    Map,
    /// Rauch-Tung-Striebel smoother of the five-state filter: random torque is allowed for
    Rts,
    /// The same in running form: each sample as it looks a lag later
    FixedLag,
}

/// What is believed before the record is read.
#[derive(Debug, Args)]
#[command(next_help_heading = "Belief at the start of the record")]
pub struct SmoothPrior {
    /// Scenario whose first torsional estimator says period, start and noise; options below
    /// replace what it says
    #[arg(long, value_name = "SCENARIO.toml")]
    pub scenario: Option<PathBuf>,
    /// Period of undamped torsion; needed without a scenario
    #[arg(long, value_name = "S", value_parser = positive)]
    pub period_s: Option<f64>,
    /// Its standard deviation [default: 1 % of it]
    #[arg(long, value_name = "S", value_parser = not_negative, allow_negative_numbers = true)]
    pub period_sigma_s: Option<f64>,
    /// Angle from equilibrium [default: 0]
    #[arg(long, value_name = "DEG", value_parser = finite, allow_negative_numbers = true)]
    pub angle_deg: Option<f64>,
    /// Its standard deviation [default: 360]
    #[arg(long, value_name = "DEG", value_parser = not_negative, allow_negative_numbers = true)]
    pub angle_sigma_deg: Option<f64>,
    /// Rate of the body [default: 0]
    #[arg(long, value_name = "DEG/S", value_parser = finite, allow_negative_numbers = true)]
    pub rate_deg_s: Option<f64>,
    /// Its standard deviation; 0.01 for a body let go at rest [default: 1]
    #[arg(long, value_name = "DEG/S", value_parser = not_negative, allow_negative_numbers = true)]
    pub rate_sigma_deg_s: Option<f64>,
    /// Damping ratio
    #[arg(long, value_name = "X", default_value_t = 0.03, value_parser = not_negative)]
    pub damping_ratio: f64,
    /// Its standard deviation
    #[arg(long, value_name = "X", default_value_t = 0.02, value_parser = not_negative)]
    pub damping_ratio_sigma: f64,
    /// Standard deviation of the gyro's bias about zero
    #[arg(long, value_name = "DEG/S", default_value_t = 0.05, value_parser = not_negative)]
    pub bias_sigma_deg_s: f64,
    /// Noise of one rate in the record, 1 sigma [default: what its second differences say]
    #[arg(long, value_name = "DEG/S", value_parser = positive)]
    pub noise_deg_s: Option<f64>,
    /// Random angular acceleration that rts and fixed-lag allow for, (deg/s^2)^2/Hz
    #[arg(long, value_name = "Q", default_value_t = 1e-9, value_parser = not_negative)]
    pub random_torque: f64,
    /// Standard deviation of the gyro's scale factor, relative; widens what is claimed
    #[arg(long, value_name = "X", default_value_t = 0.0, value_parser = not_negative)]
    pub scale_factor_sigma: f64,
}

fn finite(text: &str) -> Result<f64, &'static str> {
    text.parse().ok().filter(|number: &f64| number.is_finite()).ok_or("write a number")
}

fn not_negative(text: &str) -> Result<f64, &'static str> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number >= 0.0);
    number.ok_or("write a number of at least 0")
}
