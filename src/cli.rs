//! What can be typed.

use clap::{Args, Parser, Subcommand, ValueEnum};
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
    /// Find a gyro's noise in a record of it at rest: Allan deviation and coefficients
    #[command(after_help = "Examples:
  struna characterize rest.csv --rate-column z --unit deg/s --sample-rate 300
  struna characterize out/rest/record.csv --figure adev.svg --json adev.json
  struna characterize mems.csv --bandwidth-hz 40 --averaging 70 --preset mine.toml

An hour at rest gives angle random walk and bias instability; a minute only the former. Each
coefficient comes with an interval, with a bound, or with the reason why there is none.")]
    Characterize(Box<Characterize>),
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
    /// List or show the gyros that ship with the program
    #[command(
        subcommand,
        after_help = "Examples:
  struna gyro list
  struna gyro show vg910d"
    )]
    Gyro(Gyro),
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
