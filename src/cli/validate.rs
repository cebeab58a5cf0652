//! Arguments of `struna validate`.

use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Arguments of `struna validate`.
#[derive(Debug, Args)]
pub struct Validate {
    /// Suite to run
    #[arg(long, value_enum, value_name = "NAME", default_value = "limits")]
    pub suite: ValidateSuite,
    /// Runs of each cell; each suite has its own number, 100 to 1000
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub runs: Option<u32>,
    /// Folder for rows.csv, rows.parquet, report.html and junit.xml
    #[arg(long, value_name = "DIR", default_value = "out/validate")]
    pub out: PathBuf,
    /// Seed of everything random
    #[arg(long, value_name = "S", default_value_t = 20_080_480)]
    pub seed: u64,
    /// Threads; all cores unless told otherwise
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

/// Suites of `struna validate`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ValidateSuite {
    /// Refinement of the 2008 filters, and its best length
    Paper,
    /// Five scenarios against the least possible error
    Limits,
    /// Steps and ramps of the rate
    Kicks,
    /// Gyros that average, round, clip, drift and colour their noise
    Gyro,
    /// A serial line that alters and loses bytes, behind it the real decoder
    Line,
    /// A thread that loses energy to hysteresis
    Thread,
    /// A body that swings while it turns; some ten minutes on two cores
    Swing,
    /// All of them
    All,
}

impl ValidateSuite {
    /// Names of the suites that are meant.
    #[must_use]
    pub fn names(self) -> Vec<&'static str> {
        match self {
            Self::Paper => vec!["paper"],
            Self::Limits => vec!["limits"],
            Self::Kicks => vec!["kicks"],
            Self::Gyro => vec!["gyro"],
            Self::Line => vec!["line"],
            Self::Thread => vec!["thread"],
            Self::Swing => vec!["swing"],
            Self::All => crate::validate::Suite::NAMES.to_vec(),
        }
    }
}
