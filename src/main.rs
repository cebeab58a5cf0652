//! The `struna` command: parse, run, exit code.

use clap::Parser;
use std::process::ExitCode;
use struna::cli::Cli;
use struna::commands::{self, Outcome};

/// Exit code of a run that Ctrl-C ended: 128 + SIGINT, as shells have it.
const INTERRUPTED: u8 = 130;

fn main() -> ExitCode {
    match commands::execute(Cli::parse()) {
        Ok(Outcome::Complete) => ExitCode::SUCCESS,
        Ok(Outcome::Interrupted) => ExitCode::from(INTERRUPTED),
        Err(error) => {
            eprintln!("struna: {error:#}");
            ExitCode::FAILURE
        }
    }
}
