//! What can be typed.

mod emulate;
mod faults;
mod fmu;
mod frame;
mod gyro;
mod hil;
mod run;
mod smooth;
mod validate;

pub use emulate::Emulate;
pub use faults::{EventCount, FaultSuite, Faults};
pub use fmu::{Fmu, FmuBuild};
pub use frame::{Baud, Decode, Frame, FrameLint, FrameSniff};
pub use gyro::{Characterize, Gyro, GyroShow};
pub use hil::{Hil, Ports};
pub use run::{Compare, Demo, Run, Truth};
pub use smooth::{Smooth, SmoothMethod, SmoothPrior};
pub use validate::{Validate, ValidateSuite};

use clap::{Parser, Subcommand};

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
    /// Look back over a recorded run: the angle as the whole record tells it
    #[command(after_help = "Examples:
  struna smooth out/demo/record.csv --scenario scenarios/demo.toml --out out/demo/smooth
  struna smooth record.csv --period-s 480 --angle-deg 360 --angle-sigma-deg 5 --out smooth
  struna smooth record.csv --period-s 480 --method fixed-lag --lag-s 60 --out lag

Writes smoothed.csv, figure.svg and report.txt. Truth in the record is scored against and not
read otherwise. What the record does not say is refused in words.")]
    Smooth(Box<Smooth>),
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
    /// Tell with statistics how far each estimator can be trusted
    #[command(after_help = "Examples:
  struna validate
  struna validate --suite kicks --runs 50
  struna validate --suite all --out out/validation --threads 8

Everything is simulated; one seed makes the same rows on any number of threads. Exit code 0 when
nothing failed, 1 when a requirement is not met, 2 when the campaign could not be run or written.
What too few runs leave undecided is no failure. docs/validate.md explains suites and verdicts.")]
    Validate(Validate),
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
    /// List, judge and find out frame layouts
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

fn positive(text: &str) -> Result<f64, &'static str> {
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
