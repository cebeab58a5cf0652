//! Recorded rates from CSV files.

use std::path::{Path, PathBuf};
use struna_harness::{Recording, SourceError};

/// Why a recording could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// The file cannot be opened.
    #[error("cannot read the recording {}: {source}; check `file` in [source]", path.display())]
    Read {
        /** The file. */
        path: PathBuf,
        /** The system's reason. */
        source: std::io::Error,
    },
    /// A column is not there.
    #[error(
        "{} has no column '{column}'; write one of these in [source]: {present}",
        path.display()
    )]
    NoColumn {
        /** The file. */
        path: PathBuf,
        /** The column asked for. */
        column: String,
        /** The columns that are there. */
        present: String,
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
    /// The samples make no recording.
    #[error("{}: {source}", path.display())]
    Unusable {
        /** The file. */
        path: PathBuf,
        /** Why. */
        source: SourceError,
    },
}

/// Reads columns `time_column`, s, and `rate_column`, multiplied by `rad_s_per_unit`.
///
/// # Errors
/// [`RecordingError`] names file, line and column.
pub fn read(
    path: &Path,
    time_column: &str,
    rate_column: &str,
    rad_s_per_unit: f64,
) -> Result<Recording, RecordingError> {
    let failed = |source: csv::Error| match source.position().map(csv::Position::line) {
        Some(line) => bad_line(path, line, source.to_string()),
        None => RecordingError::Read { path: path.to_owned(), source: source.into() },
    };
    let file = std::fs::File::open(path)
        .map_err(|source| RecordingError::Read { path: path.to_owned(), source })?;
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(file);
    let header = reader.headers().map_err(failed)?.clone();
    let find = |column: &str| {
        header.iter().position(|name| name == column).ok_or_else(|| RecordingError::NoColumn {
            path: path.to_owned(),
            column: column.to_owned(),
            present: header.iter().collect::<Vec<_>>().join(", "),
        })
    };
    let columns = [(time_column, find(time_column)?), (rate_column, find(rate_column)?)];
    let (mut time_s, mut rate_rad_s) = (Vec::new(), Vec::new());
    for row in reader.records() {
        let row = row.map_err(failed)?;
        let line = row.position().map_or(0, csv::Position::line);
        let number = |(column, at): (&str, usize)| {
            let text = row.get(at).unwrap_or_default();
            text.parse::<f64>().map_err(|_| {
                bad_line(path, line, format!("'{text}' in column '{column}' is no number"))
            })
        };
        time_s.push(number(columns[0])?);
        rate_rad_s.push(number(columns[1])? * rad_s_per_unit);
    }
    Recording::new(&time_s, &rate_rad_s)
        .map_err(|source| RecordingError::Unusable { path: path.to_owned(), source })
}

fn bad_line(path: &Path, line: u64, reason: String) -> RecordingError {
    RecordingError::BadLine { path: path.to_owned(), line, reason }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "numbers read from text are exact")]
mod tests {
    use super::*;
    use struna_harness::MotionSource;
    use struna_kernel::{RAD_PER_DEG, SimTime};

    fn read_text(text: &str) -> Result<Recording, RecordingError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.csv");
        std::fs::write(&path, text).unwrap();
        read(&path, "Time (s)", "Rate (deg/s)", RAD_PER_DEG)
    }

    #[test]
    fn named_columns_are_read_in_any_order() {
        let text = "Rate (deg/s),x,Time (s)\n10,a,5.0\n10,b,6.0\n";
        let mut recording = read_text(text).unwrap();
        assert_eq!(recording.duration_s(), 1.0);
        let reference = recording.reference_at(SimTime::ZERO).unwrap();
        assert_eq!(reference.rate_rad_s, 10.0 * RAD_PER_DEG);
    }

    #[test]
    fn a_truncated_line_is_refused_with_its_number() {
        let cut = read_text("Time (s),Rate (deg/s)\n0,1\n1,2\n2").unwrap_err();
        assert!(cut.to_string().contains("line 4"), "{cut}");
        let half = read_text("Time (s),Rate (deg/s)\n0,1\n1,-\n").unwrap_err();
        assert!(half.to_string().contains("line 3"), "{half}");
    }

    #[test]
    fn a_missing_column_is_refused_with_those_present() {
        let missing = read_text("t,Rate (deg/s)\n0,1\n1,2\n").unwrap_err();
        assert!(missing.to_string().contains("in [source]: t, Rate (deg/s)"), "{missing}");
    }

    #[test]
    fn an_empty_recording_is_refused() {
        assert!(read_text("Time (s),Rate (deg/s)\n").is_err());
        assert!(read_text("").is_err());
    }
}
