//! Arguments of the commands for real and virtual ports.

use super::positive;
use clap::Args;
use std::path::PathBuf;

/// Arguments of `struna hil`.
#[derive(Debug, Args)]
pub struct Hil {
    /// Serial port: a device, a link to one, or `auto` for the one that speaks the frame
    #[arg(long, value_name = "PATH", required_unless_present = "replay")]
    pub port: Option<PathBuf>,
    /// Frame layout: a shipped name or a .toml file [default: the scenario's]
    #[arg(long, value_name = "FRAME")]
    pub frame: Option<String>,
    /// Estimator to run, by name; may be given several times [default: the usual]
    #[arg(long = "estimator", value_name = "NAME")]
    pub estimators: Vec<String>,
    /// Scenario whose estimators, averaging and frame are taken [default: none]
    #[arg(long, value_name = "SCENARIO.toml")]
    pub scenario: Option<PathBuf>,
    /// Folder for the results [default: out/hil, or replay in the replayed folder]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Baud rate [default: the frame's]
    #[arg(long, value_name = "N")]
    pub baud: Option<u32>,
    /// End after so many seconds [default: at Ctrl-C]
    #[arg(long, value_name = "S", value_parser = positive)]
    pub duration: Option<f64>,
    /// Gyro samples averaged into one [default: the scenario's, or to at most 100 Hz]
    #[arg(long, value_name = "M")]
    pub averaging: Option<u64>,
    /// Period of the torsional oscillation, s, to 1 %: runs the filter that learns it
    #[arg(long, value_name = "T", value_parser = positive, conflicts_with = "scenario")]
    pub period_s: Option<f64>,
    /// Angle at the start, deg
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, conflicts_with = "scenario")]
    pub angle_start_deg: Option<f64>,
    /// Constant delay from sample to arrival, which no arrival can show, microseconds
    #[arg(long, value_name = "US", allow_negative_numbers = true)]
    pub latency_us: Option<f64>,
    /// End with an error when no good frame comes within two seconds
    #[arg(long)]
    pub strict: bool,
    /// Decode the bytes of an earlier run again
    #[arg(long, value_name = "DIR", conflicts_with_all = ["port", "baud", "duration", "strict"])]
    pub replay: Option<PathBuf>,
}

/// Arguments of `struna ports`.
#[derive(Debug, Args)]
pub struct Ports {
    /// Directory with further links to virtual ports; may be given several times
    #[arg(long = "dir", value_name = "DIR")]
    pub directories: Vec<PathBuf>,
    /// Write JSON instead of a table
    #[arg(long)]
    pub json: bool,
}
