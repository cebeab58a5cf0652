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
    /// Find out frame layouts
    #[command(
        subcommand,
        after_help = "Example:
  struna frame sniff --port /dev/ttyUSB0 --out my-gyro.toml"
    )]
    Frame(Frame),
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
    /// Propose the layout of an unknown gyro's frames from its bytes
    #[command(after_help = "Examples:
  struna frame sniff --port /dev/ttyUSB0
  struna frame sniff --port /dev/ttyUSB0 --baud 115200 --seconds 20 --out my-gyro.toml
  struna frame sniff --file capture.bin --seconds 8
  struna frame sniff --file monday.bin --second tuesday.bin --rate-hz 300 --out my-gyro.toml

Keep the gyro still for 3 s, then turn it by hand both ways for 5 s. A layout is \"confirmed\" only
when it has read bytes that it was not made from. Scale and sign are never in the bytes.")]
    Sniff(FrameSniff),
}

/// Arguments of `struna frame sniff`.
#[derive(Debug, Args)]
pub struct FrameSniff {
    /// Serial port to capture from
    #[arg(long, value_name = "PORT", required_unless_present = "file", conflicts_with = "file")]
    pub port: Option<PathBuf>,
    /// File of raw bytes
    #[arg(long, value_name = "CAPTURE")]
    pub file: Option<PathBuf>,
    /// Another capture of the same gyro, to test the proposal on
    #[arg(long, value_name = "FILE", conflicts_with = "port")]
    pub second: Option<PathBuf>,
    /// Baud rate of the port, or auto to try the usual ones
    #[arg(long, value_name = "auto|N", default_value = "auto", value_parser = baud)]
    pub baud: Baud,
    /// How long to capture [default: 8], or how long the file took
    #[arg(long, value_name = "S", value_parser = positive, conflicts_with = "rate_hz")]
    pub seconds: Option<f64>,
    /// Frame rate, if it is known
    #[arg(long, value_name = "F", value_parser = positive)]
    pub rate_hz: Option<f64>,
    /// Frame file to write; a capture from a port is put beside it [default: print, or
    /// out/sniffed.toml with --port]
    #[arg(long, value_name = "FRAME.toml")]
    pub out: Option<PathBuf>,
    /// Name of the layout
    #[arg(long, value_name = "NAME", default_value = "sniffed@1")]
    pub name: String,
}

/// Which baud rate to open a port at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Baud {
    /// The usual one at which bytes make most sense.
    Auto,
    /// This one.
    At(u32),
}

fn baud(text: &str) -> Result<Baud, &'static str> {
    if text == "auto" {
        return Ok(Baud::Auto);
    }
    let number = text.parse().ok().filter(|baud| *baud > 0);
    number.map(Baud::At).ok_or("write auto or a whole number above 0")
}

fn positive(text: &str) -> Result<f64, &'static str> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number > 0.0);
    number.ok_or("write a number above 0")
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
