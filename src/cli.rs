//! What can be typed.

use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

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
    /// Run the estimators on a gyro at a serial port, real or virtual
    #[command(after_help = "Examples:
  struna hil --port /dev/ttyUSB0 --frame struna/vg910d@1
  struna hil --port auto --frame frames/mine.toml --duration 480 --period-s 480
  struna hil --port /run/struna/vg910d --scenario scenarios/demo.toml --out out/monday
  struna hil --replay out/monday --averaging 15

Writes record.csv, events.csv, report.json, and the bytes as they came (raw.bin, raw.csv). A port
that is unplugged is opened again when it comes back. Ctrl-C ends the run; what came is kept.")]
    Hil(Box<Hil>),
    /// List the serial ports, real and virtual
    #[command(after_help = "Examples:
  struna ports
  struna ports --dir /tmp/gyros --json")]
    Ports(Ports),
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

/// Arguments of `struna hil`.
#[derive(Debug, Args)]
pub struct Hil {
    /// Serial port: a device, a link to one, or `auto` for the one that speaks the frame
    #[arg(long, value_name = "PATH", required_unless_present = "replay")]
    pub port: Option<PathBuf>,
    /// Frame layout: a shipped name or a .toml file [default: the scenario's]
    #[arg(long, value_name = "FRAME")]
    pub frame: Option<String>,
    /// Estimator to run, by name; may be given several times [default: all there are]
    #[arg(long = "estimator", value_name = "NAME")]
    pub estimators: Vec<String>,
    /// Scenario whose estimators, averaging and frame are taken [default: integration and rotation]
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
    /// Period of the torsional oscillation, s: adds the filter that knows it
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

fn positive(text: &str) -> Result<f64, &'static str> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number > 0.0);
    number.ok_or("write a number greater than 0")
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
