//! What the commands do. Printing happens here and nowhere else in the library.

#![expect(clippy::print_stdout, reason = "commands talk to the person who typed them")]

mod characterize;
mod compare;
mod decode;
mod emulate;
mod faults;
mod fmu;
mod frame;
mod gyro;
mod hil;
mod ports;
mod run;
mod screen;
mod smooth;
mod sniff;
mod truth;
mod validate;

use crate::cli::{Cli, Command};
use crate::scenario::Scenario;
use anyhow::Result;
use std::io::{self, Write};
use std::path::Path;

/// How a command ended, short of an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// As asked.
    Complete,
    /// Stopped by Ctrl-C, with what there was written.
    Interrupted,
    /// As asked, with the answer that something required does not hold.
    NotMet,
}

/// Exit code of a command that could not do its work: 1, or 2 where 1 is an answer.
#[must_use]
pub fn failure_code(command: &Command) -> u8 {
    if matches!(command, Command::Validate(_)) { 2 } else { 1 }
}

/// The scenario of `struna demo`.
const DEMO: &str = include_str!("../../scenarios/demo.toml");

/// Runs a command.
///
/// # Errors
/// What stopped it, ready to be shown.
pub fn execute(cli: Cli) -> Result<Outcome> {
    struna_fmi_import::capture_fmu_messages();
    match cli.command {
        Command::Demo(args) => {
            let scenario = Scenario::parse(DEMO, Path::new("scenarios/demo.toml"))?;
            run::execute(scenario, args.out, run::Speed::AsFastAsPossible)
        }
        Command::Run(args) => {
            let mut scenario = Scenario::read(&args.scenario)?;
            if let Some(seed) = args.seed {
                scenario.seed = struna_kernel::Seed(seed);
            }
            let speed =
                if args.realtime { run::Speed::RealTime } else { run::Speed::AsFastAsPossible };
            run::execute(scenario, args.out, speed)
        }
        Command::Emulate(args) => emulate::execute(&args),
        Command::Truth(args) => truth::execute(&Scenario::read(&args.scenario)?, &args.csv),
        Command::Compare(args) => compare::execute(&args),
        Command::Smooth(args) => smooth::execute(&args),
        Command::Characterize(args) => characterize::execute(&args),
        Command::Hil(args) => hil::execute(&args),
        Command::Ports(args) => ports::execute(&args),
        Command::Faults(args) => faults::execute(&args),
        Command::Validate(args) => validate::execute(&args),
        Command::Fmu(command) => fmu::execute(command),
        Command::Gyro(command) => gyro::execute(&command),
        Command::Frame(command) => frame::execute(&command),
        Command::Decode(args) => decode::execute(&args),
    }
}

/// A reader that has seen enough, as `head` has after ten lines, may leave early.
fn print(text: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        written => written,
    }
}

/// Rows of cells as indented text, each column as wide as its widest cell.
fn in_columns<const N: usize>(rows: &[[String; N]]) -> String {
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max();
    let widths: [usize; N] = std::array::from_fn(|column| width(column).unwrap_or_default());
    let mut text = String::new();
    for row in rows {
        let padded = row.iter().zip(widths).map(|(cell, width)| format!("  {cell:<width$}"));
        text += padded.collect::<String>().trim_end();
        text.push('\n');
    }
    text
}
