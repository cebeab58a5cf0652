//! Why a file cannot be characterised.

use super::unit::UnknownUnit;
use std::path::{Path, PathBuf};
use struna_gyro::characterise::CharacteriseError;

/// Why a file cannot be characterised.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CharacterizeError {
    /// The file cannot be read.
    #[error("cannot read {}: {source}; check the path", path.display())]
    Read {
        /** The file. */
        path: PathBuf,
        /** The system's reason. */
        source: std::io::Error,
    },
    /// A folder or a device.
    #[error("{} is not a file; name a CSV file of rates", path.display())]
    NotAFile {
        /** What it names. */
        path: PathBuf,
    },
    /// No header, or nothing below it.
    #[error("{} ends at line {line} without {missing}", path.display())]
    Empty {
        /** The file. */
        path: PathBuf,
        /** Its last line, from 1; 0 in a file without any. */
        line: u64,
        /** What it lacks. */
        missing: &'static str,
    },
    /// A column that was asked for is not there.
    #[error("{} has no column '{column}'; it has: {present}", path.display())]
    NoColumn {
        /** The file. */
        path: PathBuf,
        /** The column asked for. */
        column: String,
        /** The columns that are there. */
        present: String,
    },
    /// No column was asked for, and none has a name that says it is a rate.
    #[error(
        "no column of {} is known to be a rate; choose one with --rate-column: {present}",
        path.display()
    )]
    NoRateColumn {
        /** The file. */
        path: PathBuf,
        /** The columns that are there. */
        present: String,
    },
    /// Neither the option nor the name of the column says the unit.
    #[error(
        "the name of column '{column}' does not end in its unit; add --unit deg/s, rad/s or deg/h"
    )]
    NoUnit {
        /** The column. */
        column: String,
    },
    /// The option names no unit.
    #[error("--unit: {0}")]
    Unit(#[from] UnknownUnit),
    /// Neither the option nor a column of time says the sample rate.
    #[error("the sample rate is not known; add --sample-rate HZ, or --time-column NAME in s")]
    NoSampleRate,
    /// The column of time contradicts the option.
    #[error(
        "column '{column}' has {measured_hz:.6} samples per second and --sample-rate says \
         {given_hz}; leave the option away, or check that the column is in s"
    )]
    RatesDiffer {
        /** The column of time. */
        column: String,
        /** Its median rate. */
        measured_hz: f64,
        /** The option. */
        given_hz: f64,
    },
    /// A line that cannot be used.
    #[error("{}, line {line}: {reason}", path.display())]
    BadLine {
        /** The file. */
        path: PathBuf,
        /** Line, from 1. */
        line: u64,
        /** What is wrong with it, and what to do. */
        reason: String,
    },
    /// The numbers allow no answer.
    #[error("{}: {source}", path.display())]
    Unusable {
        /** The file. */
        path: PathBuf,
        /** Why. */
        source: CharacteriseError,
    },
}

impl CharacterizeError {
    pub(super) fn bad_line(path: &Path, line: u64, reason: impl Into<String>) -> Self {
        Self::BadLine { path: path.to_owned(), line, reason: reason.into() }
    }

    pub(super) fn unusable(path: &Path) -> impl FnOnce(CharacteriseError) -> Self {
        let path = path.to_owned();
        move |source| Self::Unusable { path, source }
    }
}
