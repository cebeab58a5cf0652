//! Why a record cannot be smoothed.

use std::path::{Path, PathBuf};
use struna_estimator::{ConfigError, FitRefusal, SmoothError};

/// Why a record cannot be smoothed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SmoothingError {
    /// The file cannot be read.
    #[error("cannot read the record {}: {source}; check the path", path.display())]
    Read {
        /** The file. */
        path: PathBuf,
        /** The system's reason. */
        source: std::io::Error,
    },
    /// A column is not there.
    #[error(
        "{} has no column '{column}'; smooth a record.csv of `struna run` or `struna hil`, or \
         rename the column",
        path.display()
    )]
    NoColumn {
        /** The file. */
        path: PathBuf,
        /** The column. */
        column: &'static str,
    },
    /// A line is cut short or holds no number.
    #[error("{}, line {line}: {reason}; repair or remove the line", path.display())]
    BadLine {
        /** The file. */
        path: PathBuf,
        /** Line, from 1. */
        line: u64,
        /** What is wrong with it. */
        reason: String,
    },
    /// Too few rows to tell a step or a noise from.
    #[error("{} holds {rows} rows; a record to be smoothed has at least {need}", path.display())]
    TooShort {
        /** The file. */
        path: PathBuf,
        /** Rows in it. */
        rows: usize,
        /** Rows needed. */
        need: usize,
    },
    /// All rates are equal: there is no noise to be told from them.
    #[error(
        "{} shows no noise from row to row; say what it is with --noise-deg-s",
        path.display()
    )]
    NoNoise {
        /** The file. */
        path: PathBuf,
    },
    /// Neither a scenario nor an option says the period.
    #[error("the period is not known beforehand; add --period-s or --scenario")]
    NoPeriod,
    /// A scenario without an estimator that knows a period.
    #[error(
        "{} has no [[estimator]] of kind \"torsional-oscillation\"; add --period-s in its place",
        path.display()
    )]
    NoTorsion {
        /** The scenario. */
        path: PathBuf,
    },
    /// The lag is longer than a running smoother may have.
    #[error("a lag of {lag_s} s is {samples:.0} samples, at most {most}; make --lag-s smaller")]
    LagTooLong {
        /** The lag, s. */
        lag_s: f64,
        /** In samples. */
        samples: f64,
        /** The most there can be. */
        most: u32,
    },
    /// The belief is unusable.
    #[error("{source}; change the belief at the start")]
    Belief {
        /** Which number, and why. */
        source: ConfigError,
    },
    /// The record cannot be taken in.
    #[error("{}: {source}", path.display())]
    Unusable {
        /** The file. */
        path: PathBuf,
        /** Where and why. */
        source: SmoothError,
    },
    /// The fit says no.
    #[error("{}: {source}; `--method rts` says what can be said", path.display())]
    Refused {
        /** The file. */
        path: PathBuf,
        /** In its words. */
        source: FitRefusal,
    },
}

impl SmoothingError {
    pub(super) fn bad_line(path: &Path, line: u64, reason: impl Into<String>) -> Self {
        Self::BadLine { path: path.to_owned(), line, reason: reason.into() }
    }
}
