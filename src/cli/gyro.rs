//! Arguments of the commands about gyros and their noise.

use clap::{Args, Subcommand};
use std::path::PathBuf;

/// Gyro commands.
#[derive(Debug, Subcommand)]
pub enum Gyro {
    /// List the presets
    #[command(after_help = "Example:
  struna gyro list")]
    List,
    /// Show every parameter of a preset with its value, unit and provenance
    #[command(after_help = "Examples:
  struna gyro show adis16100
  struna gyro show vg910d | grep unverified

What is not listed is off. Any parameter can be replaced by its key in [gyro] of a scenario.")]
    Show(GyroShow),
}

/// Arguments of `struna gyro show`.
#[derive(Debug, Args)]
pub struct GyroShow {
    /// Name of the preset
    #[arg(value_name = "NAME", value_parser = struna_gyro::preset::NAMES)]
    pub name: String,
}

/// Arguments of `struna characterize`.
#[derive(Debug, Args)]
pub struct Characterize {
    /// CSV file with a header and the rates of a gyro at rest
    #[arg(value_name = "FILE.csv")]
    pub file: PathBuf,
    /// Column of the rates [default: measured_rate_rad_s, rate_deg_s or the like]
    #[arg(long, value_name = "NAME")]
    pub rate_column: Option<String>,
    /// Their unit: deg/s, rad/s or deg/h [default: what the column's name ends in]
    #[arg(long, value_name = "UNIT")]
    pub unit: Option<String>,
    /// Samples per second [default: what the column of time says]
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    pub sample_rate: Option<f64>,
    /// Column of the time in s, which tells what was lost [default: time, if there]
    #[arg(long, value_name = "NAME")]
    pub time_column: Option<String>,
    /// Column that grows by one with each sample, which tells what was lost
    #[arg(long, value_name = "NAME")]
    pub index_column: Option<String>,
    /// Bandwidth of the gyro; noise at shorter averaging times is left out of the fit
    #[arg(long, value_name = "F", allow_negative_numbers = true)]
    pub bandwidth_hz: Option<f64>,
    /// Samples per average in the laboratory's statistic
    #[arg(long, value_name = "M", default_value_t = 10, value_parser = samples)]
    pub averaging: usize,
    /// Also find N, B and K that lie nowhere below the measured curve
    #[arg(long)]
    pub overbound: bool,
    /// Averaging times in octaves and not ten per decade
    #[arg(long)]
    pub octaves: bool,
    /// Name of the gyro [default: name of the file]
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,
    /// JSON file to write
    #[arg(long, value_name = "OUT.json")]
    pub json: Option<PathBuf>,
    /// Figure to write
    #[arg(long, value_name = "OUT.svg")]
    pub figure: Option<PathBuf>,
    /// Gyro preset to write, with the noise that was found
    #[arg(long, value_name = "OUT.toml")]
    pub preset: Option<PathBuf>,
}

fn samples(text: &str) -> Result<usize, &'static str> {
    text.parse().ok().filter(|number| *number > 0).ok_or("write a whole number of at least 1")
}
