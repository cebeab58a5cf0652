//! What can be typed.

use clap::{Args, Parser, Subcommand, ValueEnum};
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
    /// Try every fault against every detector and print who finds what
    #[command(after_help = "Examples:
  struna faults
  struna faults --suite vg --events full --hours 24 --csv faults.csv --svg faults.svg

Everything is simulated: three streams, 25 faults, 11 detectors; one seed makes one table.
docs/faults.md explains faults, detectors and limits.")]
    Faults(Faults),
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

/// Arguments of `struna faults`.
#[derive(Debug, Args)]
pub struct Faults {
    /// Streams to try
    #[arg(long, value_enum, default_value = "all")]
    pub suite: FaultSuite,
    /// Seed of noise and faults
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Events of each fault: 300, 60 or 20 by its length, or 2990, 290 or 59
    #[arg(long, value_enum, default_value = "small")]
    pub events: EventCount,
    /// Clean time of each stream, in which every alarm is false, h
    #[arg(long, value_name = "HOURS", default_value = "1", value_parser = hours)]
    pub hours: f64,
    /// CSV file to write, one line for each cell
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Figure to write
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
}

/// Streams of `struna faults`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FaultSuite {
    /// VG-910D: CRC and counter
    Vg,
    /// ADIS16100: CRC and counter, coarse counts
    Adis,
    /// VG-910D behind a frame with an 8-bit sum and no counter
    Weak,
    /// All three
    All,
}

/// Events of `struna faults`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum EventCount {
    /// For a first look
    Small,
    /// For two digits
    Full,
}

fn hours(text: &str) -> Result<f64, &'static str> {
    let number = text.parse().ok().filter(|number: &f64| (0.0..=1000.0).contains(number));
    number.ok_or("write a number of hours, 0 to 1000")
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
