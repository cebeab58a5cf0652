//! Why two files cannot be compared.

use std::path::{Path, PathBuf};

/// Why two files cannot be compared.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CompareError {
    /// The file cannot be read.
    #[error("cannot read {}: {source}; check the path", path.display())]
    Read {
        /** The file. */
        path: PathBuf,
        /** The system's reason. */
        source: std::io::Error,
    },
    /// A folder or a device.
    #[error("{} is not a file; name a CSV of `struna truth` or `struna run`", path.display())]
    NotAFile {
        /** What it names. */
        path: PathBuf,
    },
    /// No header, or nothing below it.
    #[error("{} ends at line {line} without {missing}; write the file again", path.display())]
    Empty {
        /** The file. */
        path: PathBuf,
        /** Its last line, from 1; 0 in a file without any. */
        line: u64,
        /** What it lacks. */
        missing: &'static str,
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
    /// Nothing but the time is in both files.
    #[error(
        "{} and {} have no column in common but 'time': one has {columns_a}, the other \
         {columns_b}; compare files of one kind",
        a.display(),
        b.display()
    )]
    NoCommonColumn {
        /** One file. */
        a: PathBuf,
        /** Its columns. */
        columns_a: String,
        /** The other file. */
        b: PathBuf,
        /** Its columns. */
        columns_b: String,
    },
    /// Each file has instants that the other lacks.
    #[error(
        "column 'time': {a} has no counterpart, nor has {b}; write both files with the same \
         `sample_rate_hz`, or with one that is a multiple of the other"
    )]
    GridsDiffer {
        /** First instant without counterpart in one file. */
        a: Instant,
        /** First instant without counterpart in the other file. */
        b: Instant,
    },
    /// One file ends before the other begins.
    #[error(
        "column 'time': {last} ends its file before {first} begins the other; write both files \
         over the same time"
    )]
    NoCommonInstant {
        /** The last instant of the file that ends. */
        last: Instant,
        /** The first instant of the other. */
        first: Instant,
    },
}

/// An instant in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Instant {
    /// The file.
    pub path: PathBuf,
    /// Line, from 1.
    pub line: u64,
    /// The instant, s.
    pub time_s: f64,
}

impl std::fmt::Display for Instant {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} s in {}, line {}", self.time_s, self.path.display(), self.line)
    }
}

impl CompareError {
    pub(super) fn bad_line(path: &Path, line: u64, reason: impl Into<String>) -> Self {
        Self::BadLine { path: path.to_owned(), line, reason: reason.into() }
    }
}
