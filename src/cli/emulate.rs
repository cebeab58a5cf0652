//! Arguments of `struna emulate`.

use clap::Args;
use std::path::PathBuf;
use struna_kernel::SimTime;

/// Arguments of `struna emulate`.
#[derive(Debug, Args)]
pub struct Emulate {
    /// Scenario file
    #[arg(value_name = "SCENARIO.toml")]
    pub scenario: PathBuf,
    /// Lasting name for the port [default: $XDG_RUNTIME_DIR/struna/NAME]
    #[arg(long, value_name = "PATH")]
    pub link: Option<PathBuf>,
    /// Seed in place of the scenario's
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Length in simulated seconds in place of the scenario's
    #[arg(long, value_name = "S", value_parser = duration)]
    pub duration: Option<SimTime>,
    /// Simulated seconds in one of the clock
    #[arg(long, value_name = "X", default_value = "1", value_parser = speed)]
    pub speed: f64,
    /// Start the clock when somebody opens the port
    #[arg(long)]
    pub wait_for_client: bool,
    /// Let clients come in within a frame, as they do with a real gyro
    #[arg(long)]
    pub mid_frame: bool,
    /// Ask for real-time priority and locked memory; goes on without
    #[arg(long)]
    pub rt: bool,
    /// CSV file for the instants of each frame on the monotonic clock
    #[arg(long, value_name = "FILE")]
    pub log: Option<PathBuf>,
    /// CSV file for what the scenario's faults did [default: out/NAME/faults.csv]
    #[arg(long, value_name = "FILE")]
    pub faults: Option<PathBuf>,
}

/// Longest duration that can be typed, s: the same as in a scenario.
const DURATION_S_MAX: f64 = 1e7;
/// Fastest and slowest pace.
const SPEED_MAX: f64 = 1000.0;

fn duration(text: &str) -> Result<SimTime, &'static str> {
    let usable = |s: &f64| *s > 0.0 && *s <= DURATION_S_MAX;
    let duration_s = text.parse().ok().filter(usable);
    duration_s
        .and_then(|duration_s| SimTime::from_s(duration_s).ok())
        .ok_or("write a number of seconds greater than 0, at most 1e7")
}

fn speed(text: &str) -> Result<f64, &'static str> {
    let usable = |speed: &f64| (1.0 / SPEED_MAX..=SPEED_MAX).contains(speed);
    text.parse().ok().filter(usable).ok_or("write a number from 0.001 to 1000")
}
