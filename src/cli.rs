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
    /// Build or list the FMUs
    #[command(
        subcommand,
        after_help = "Examples:
  struna fmu list
  struna fmu build --out fmus"
    )]
    Fmu(Fmu),
    /// List and judge frame layouts
    #[command(
        subcommand,
        after_help = "Examples:
  struna frame list
  struna frame lint frames/vg910d.toml"
    )]
    Frame(Frame),
    /// Decode a file of raw bytes, as they came off a serial line
    #[command(after_help = "Examples:
  struna decode capture.bin --frame struna/vg910d@1
  struna decode capture.bin --frame frames/adis16100.toml --csv out.csv
  struna decode capture.bin --frame struna/vg910d@1 --csv - | head

Prints what became of every byte. The CSV has one row for each frame, in SI.")]
    Decode(Decode),
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

/// Frame commands.
#[derive(Debug, Subcommand)]
pub enum Frame {
    /// List the shipped layouts
    #[command(after_help = "Example:
  struna frame list")]
    List,
    /// Tell what layouts can and cannot do; exit code 1 for one that cannot be decoded uniquely
    #[command(after_help = "Examples:
  struna frame lint struna/vg910d@1
  struna frame lint my-gyro.toml other-gyro.toml")]
    Lint(FrameLint),
}

/// Arguments of `struna frame lint`.
#[derive(Debug, Args)]
pub struct FrameLint {
    /// Frame files, or names of shipped layouts
    #[arg(value_name = "FILE|NAME", required = true)]
    pub frames: Vec<String>,
}

/// Arguments of `struna decode`.
#[derive(Debug, Args)]
pub struct Decode {
    /// File of raw bytes
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Frame file, or name of a shipped layout
    #[arg(long, value_name = "FILE|NAME")]
    pub frame: String,
    /// CSV file to write; - for standard output
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Frame rate for the column of times, in place of the layout's nominal one
    #[arg(long, value_name = "HZ", value_parser = rate)]
    pub rate_hz: Option<f64>,
}

fn rate(text: &str) -> Result<f64, &'static str> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number > 0.0);
    number.ok_or("write a number greater than 0")
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
