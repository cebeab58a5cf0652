//! What can be typed.

use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;
use struna_kernel::SimTime;

/// Co-simulation and hardware-in-the-loop bench for a string-suspended body watched by gyros.
#[derive(Debug, Parser)]
#[command(
    version,
    after_help = "Start with `struna demo`, then copy and change scenarios/demo.toml."
)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run the whole chain on one turn of damped torsion and score both 2008 filters
    #[command(after_help = "Examples:
  struna demo
  struna demo --out /tmp/first-light

Writes record.csv, score.json, figure.svg and the FMUs into the folder.")]
    Demo(Demo),
    /// Run a scenario file through the whole chain
    #[command(after_help = "Examples:
  struna run scenarios/demo.toml
  struna run scenarios/swing.toml --seed 7 --out out/swing-7
  struna run scenarios/demo.toml --realtime

Ctrl-C ends the run early; what came until then is recorded and scored.")]
    Run(Run),
    /// Stand in for the gyro of a scenario on a virtual serial port, in real time
    #[command(after_help = "Examples:
  struna emulate scenarios/swing.toml
  struna emulate scenarios/swing.toml --link vg910d --wait-for-client
  struna emulate scenarios/swing.toml --duration 60 --rt --log emissions.csv

Prints the port to open. Frames that nobody listens to are gone, as with a real gyro.")]
    Emulate(Emulate),
    /// Write the truth motion of a scenario as CSV, without gyro or filters
    #[command(after_help = "Example:
  struna truth scenarios/swing.toml --csv truth.csv")]
    Truth(Truth),
    /// Print how far two truth files or records are apart, column by column
    #[command(after_help = "Examples:
  struna compare lagrange.csv rapier.csv
  struna compare out/a/record.csv out/b/record.csv
  struna compare truth.csv finer.csv --tolerance-rad 1e-7

Rows are matched by time; one file may have more of them. The attitude is compared as one angle.")]
    Compare(Compare),
    /// Build or list the FMUs
    #[command(
        subcommand,
        after_help = "Examples:
  struna fmu list
  struna fmu build --out fmus"
    )]
    Fmu(Fmu),
}

/// Arguments of `struna demo`.
#[derive(Debug, Args)]
pub struct Demo {
    /// Folder for the results [default: out/demo]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Arguments of `struna run`.
#[derive(Debug, Args)]
pub struct Run {
    /// Scenario file
    #[arg(value_name = "SCENARIO.toml")]
    pub scenario: PathBuf,
    /// Folder for the results [default: out/NAME, with the scenario's name]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Seed in place of the scenario's
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Send each frame at its own time instead of as fast as possible
    #[arg(long)]
    pub realtime: bool,
}

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

/// Arguments of `struna truth`.
#[derive(Debug, Args)]
pub struct Truth {
    /// Scenario file
    #[arg(value_name = "SCENARIO.toml")]
    pub scenario: PathBuf,
    /// CSV file to write
    #[arg(long, value_name = "FILE")]
    pub csv: PathBuf,
}

/// Arguments of `struna compare`.
#[derive(Debug, Args)]
pub struct Compare {
    /// CSV file of `struna truth` or `struna run`
    #[arg(value_name = "A.csv")]
    pub a: PathBuf,
    /// The file to compare it with
    #[arg(value_name = "B.csv")]
    pub b: PathBuf,
    /// End with exit code 1 when the attitude or a column in rad differs by more
    #[arg(long, value_name = "X", value_parser = tolerance, allow_negative_numbers = true)]
    pub tolerance_rad: Option<f64>,
}

fn tolerance(text: &str) -> Result<f64, &'static str> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number >= 0.0);
    number.ok_or("write a number of at least 0")
}

/// FMU commands.
#[derive(Debug, Subcommand)]
pub enum Fmu {
    /// Write every model as .fmu files, FMI 2.0 and FMI 3.0
    #[command(after_help = "Examples:
  struna fmu build
  struna fmu build --out fmus && fmpy validate fmus/PermanentRotation_fmi3.fmu")]
    Build(FmuBuild),
    /// List the models and their variables
    #[command(after_help = "Example:
  struna fmu list")]
    List,
}

/// Arguments of `struna fmu build`.
#[derive(Debug, Args)]
pub struct FmuBuild {
    /// Folder for the .fmu files
    #[arg(long, value_name = "DIR", default_value = "out/fmu")]
    pub out: PathBuf,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
