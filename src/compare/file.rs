//! A CSV file of signals over time, read row by row.

use super::error::{CompareError, Instant};
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// Longest line, in bytes. The longest of ours, a record of 32 estimators, has four thousand.
const LINE_MAX: u64 = 1 << 16;
/// Comment lines that are kept to be shown.
const COMMENTS_MAX: usize = 32;
/// How far |q|² may be from one before four numbers are no attitude.
const NORM2_SLACK: f64 = 1e-6;

/// A file of signals over time: comment lines, which start with `#`, a header whose first column
/// is `time`, and rows of numbers in ascending time.
///
/// Lines are read here and not by the csv crate, which counts them differently where they end in
/// CR LF and buffers a line of any length. Our files quote names at most, so a comma parts cells.
#[derive(Debug)]
pub(super) struct SignalFile {
    path: PathBuf,
    reader: BufReader<File>,
    bytes: u64,
    bytes_read: u64,
    line: u64,
    text: Vec<u8>,
    comments: Vec<String>,
    names: Vec<String>,
    row: Vec<f64>,
}

impl SignalFile {
    /// Opens the file and reads its header.
    pub(super) fn open(path: &Path) -> Result<Self, CompareError> {
        let failed = |source| CompareError::Read { path: path.to_owned(), source };
        // Asked before opening: a pipe without a writer would never open.
        let metadata = fs::metadata(path).map_err(failed)?;
        if !metadata.is_file() {
            return Err(CompareError::NotAFile { path: path.to_owned() });
        }
        let mut file = Self {
            path: path.to_owned(),
            reader: BufReader::with_capacity(1 << 16, File::open(path).map_err(failed)?),
            bytes: metadata.len(),
            bytes_read: 0,
            line: 0,
            text: Vec::new(),
            comments: Vec::new(),
            names: Vec::new(),
            row: Vec::new(),
        };
        file.read_header()?;
        Ok(file)
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Size and how much of it has been read.
    pub(super) fn bytes(&self) -> (u64, u64) {
        (self.bytes, self.bytes_read)
    }

    /// What the comment lines read so far say, without their `#`.
    pub(super) fn comments(&self) -> &[String] {
        &self.comments
    }

    /// Names of the columns, `time` first.
    pub(super) fn names(&self) -> &[String] {
        &self.names
    }

    /// Place of the column `name`.
    pub(super) fn find(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|other| other == name)
    }

    pub(super) fn time_s(&self) -> f64 {
        self.row[0]
    }

    /// The instant of the current row and where it stands.
    pub(super) fn instant(&self) -> Instant {
        Instant { path: self.path.clone(), line: self.line, time_s: self.time_s() }
    }

    /// The current row's value in column `at`; NaN where the writer did not know it.
    pub(super) fn value(&self, at: usize) -> f64 {
        self.row[at]
    }

    /// The current row's quaternion in columns `at`; nothing where the writer did not know it.
    pub(super) fn attitude(&self, at: [usize; 4]) -> Result<Option<[f64; 4]>, CompareError> {
        let q = at.map(|at| self.row[at]);
        let norm2 = q.iter().map(|c| c * c).sum::<f64>();
        if norm2.is_nan() {
            return Ok(None);
        }
        if (norm2 - 1.0).abs() <= NORM2_SLACK {
            return Ok(Some(q));
        }
        let name = &self.names[at[0]];
        Err(self.refuse(format!(
            "{q:?} in column '{name}' and its neighbours is no attitude, whose squares add up to \
             1 and not {norm2}; repair or remove the line"
        )))
    }

    /// Goes on to the next row; false at the end of the file.
    pub(super) fn advance(&mut self) -> Result<bool, CompareError> {
        let before_s = self.row.first().copied();
        if !self.next_content()? {
            return Ok(false);
        }
        let mut row = std::mem::take(&mut self.row);
        row.clear();
        self.parse_row(&mut row)?;
        self.row = row;
        if before_s.is_some_and(|before_s| self.time_s() <= before_s) {
            let (time_s, before_s) = (self.time_s(), before_s.unwrap_or_default());
            return Err(self.refuse(format!(
                "{time_s} s in column 'time' is not later than the {before_s} s before it; sort \
                 or remove the line"
            )));
        }
        Ok(true)
    }

    /// The complaint about a file that ended below its header.
    pub(super) fn without_rows(&self) -> CompareError {
        self.lacks("rows of numbers")
    }

    fn read_header(&mut self) -> Result<(), CompareError> {
        if !self.next_content()? {
            return Err(self.lacks("a header"));
        }
        self.names = cells(self.text()?).map(str::to_owned).collect();
        let first = &self.names[0];
        if first != "time" {
            return Err(self.refuse(format!(
                "the first column is '{first}' and not 'time'; name a CSV of `struna truth` or \
                 `struna run`"
            )));
        }
        let mut seen = BTreeSet::new();
        if let Some(twice) = self.names.iter().find(|name| !seen.insert(*name)) {
            let reason = format!("column '{twice}' is there twice; rename or remove one");
            return Err(self.refuse(reason));
        }
        Ok(())
    }

    fn parse_row(&self, row: &mut Vec<f64>) -> Result<(), CompareError> {
        let text = self.text()?;
        let (found, due) = (text.split(',').count(), self.names.len());
        if found != due {
            return Err(self.refuse(format!(
                "{found} values where the header names {due} columns; repair or remove the line"
            )));
        }
        for (name, cell) in self.names.iter().zip(cells(text)) {
            let value = cell.parse().unwrap_or(f64::INFINITY);
            // NaN is what a record holds where nothing was known; a time is always known.
            if value.is_infinite() || (row.is_empty() && value.is_nan()) {
                return Err(self.refuse(format!(
                    "'{cell}' in column '{name}' is no finite number; repair or remove the line"
                )));
            }
            row.push(value);
        }
        Ok(())
    }

    /// Reads on to a line that is neither blank nor a comment; false at the end of the file.
    fn next_content(&mut self) -> Result<bool, CompareError> {
        while self.next_line()? {
            let text = self.text()?;
            let Some(comment) = text.strip_prefix('#') else {
                if text.is_empty() {
                    continue;
                }
                return Ok(true);
            };
            if self.comments.len() < COMMENTS_MAX {
                let comment = comment.trim().to_owned();
                self.comments.push(comment);
            }
        }
        Ok(false)
    }

    fn next_line(&mut self) -> Result<bool, CompareError> {
        self.text.clear();
        let length = (&mut self.reader)
            .take(LINE_MAX + 1)
            .read_until(b'\n', &mut self.text)
            .map_err(|source| CompareError::Read { path: self.path.clone(), source })?
            as u64;
        self.bytes_read += length;
        self.line += u64::from(length > 0);
        if length > LINE_MAX {
            let reason = format!("longer than {LINE_MAX} bytes; repair or remove the line");
            return Err(self.refuse(reason));
        }
        Ok(length > 0)
    }

    /// The current line without blanks around it.
    fn text(&self) -> Result<&str, CompareError> {
        match std::str::from_utf8(&self.text) {
            Ok(text) => Ok(text.trim_start_matches('\u{feff}').trim()),
            Err(_) => Err(self.refuse("not UTF-8 text; repair or remove the line")),
        }
    }

    fn refuse(&self, reason: impl Into<String>) -> CompareError {
        CompareError::bad_line(&self.path, self.line, reason)
    }

    fn lacks(&self, missing: &'static str) -> CompareError {
        CompareError::Empty { path: self.path.clone(), line: self.line, missing }
    }
}

/// The cells of a line, without blanks and quotes around them.
fn cells(line: &str) -> impl Iterator<Item = &str> {
    line.split(',').map(|cell| {
        let cell = cell.trim();
        cell.strip_prefix('"').and_then(|cell| cell.strip_suffix('"')).unwrap_or(cell)
    })
}
