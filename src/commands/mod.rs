//! What the commands do. Printing happens here and nowhere else in the library.

#![expect(clippy::print_stdout, reason = "commands talk to the person who typed them")]

mod compare;
mod fmu;
mod run;
mod sniff;
mod truth;

use crate::cli::{Cli, Command, Frame};
use crate::scenario::Scenario;
use anyhow::Result;
use std::path::Path;

/// How a command ended, short of an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// As asked.
    Complete,
    /// Stopped by Ctrl-C, with what there was written.
    Interrupted,
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
        Command::Truth(args) => truth::execute(&Scenario::read(&args.scenario)?, &args.csv),
        Command::Compare(args) => compare::execute(&args),
        Command::Fmu(command) => fmu::execute(command),
        Command::Frame(Frame::Sniff(args)) => sniff::execute(&args),
    }
}
