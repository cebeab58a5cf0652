//! The `struna` command: parse, run, exit code.

use clap::Parser;
use std::process::ExitCode;
use struna::cli::Cli;
use struna::commands::{self, Outcome};

/// Exit code of a run that Ctrl-C ended: 128 + SIGINT, as shells have it.
const INTERRUPTED: u8 = 130;

#[expect(clippy::print_stderr, reason = "where errors of a command belong")]
fn main() -> ExitCode {
    let cli = Cli::parse();
    let failure = commands::failure_code(&cli.command);
    match commands::execute(cli) {
        Ok(Outcome::Complete) => ExitCode::SUCCESS,
        Ok(Outcome::NotMet) => ExitCode::FAILURE,
        Ok(Outcome::Interrupted) => ExitCode::from(INTERRUPTED),
        Err(error) => {
            eprintln!("struna: {}", message(&error));
            ExitCode::from(failure)
        }
    }
}

/// The error and its causes on one line. Where a remedy follows the cause, the error holds the
/// cause's text already; it is not said twice.
fn message(error: &anyhow::Error) -> String {
    let mut message = error.to_string();
    for cause in error.chain().skip(1).map(ToString::to_string) {
        if !message.contains(&cause) {
            message = format!("{message}: {cause}");
        }
    }
    message
}
