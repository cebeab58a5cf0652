//! Lines of a CSV file, counted as editors count them.

use super::CharacterizeError;
use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// Longest line, in bytes. A record of 32 estimators has four thousand.
const LINE_MAX: u64 = 1 << 16;

/// A file, line by line. Blank lines and lines that start with `#` are passed over.
///
/// The csv crate would count the lines of files that end them in CR LF differently, and hold a line
/// of any length. No cell here spans lines.
#[derive(Debug)]
pub(super) struct Lines {
    path: PathBuf,
    reader: BufReader<File>,
    bytes: u64,
    bytes_read: u64,
    number: u64,
    text: Vec<u8>,
}

impl Lines {
    pub(super) fn open(path: &Path) -> Result<Self, CharacterizeError> {
        let failed = |source| CharacterizeError::Read { path: path.to_owned(), source };
        // Asked before opening: a pipe without a writer would never open.
        let metadata = fs::metadata(path).map_err(failed)?;
        if !metadata.is_file() {
            return Err(CharacterizeError::NotAFile { path: path.to_owned() });
        }
        Ok(Self {
            path: path.to_owned(),
            reader: BufReader::with_capacity(1 << 16, File::open(path).map_err(failed)?),
            bytes: metadata.len(),
            bytes_read: 0,
            number: 0,
            text: Vec::new(),
        })
    }

    /// How much of the file has been read, in thousandths.
    pub(super) fn thousandths(&self) -> u64 {
        self.bytes_read.saturating_mul(1000) / self.bytes.max(1)
    }

    /// Reads on to a line with cells; false at the end of the file.
    pub(super) fn advance(&mut self) -> Result<bool, CharacterizeError> {
        while self.next_line()? {
            let text = self.text()?;
            if !text.is_empty() && !text.starts_with('#') {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// The current line without blanks around it.
    pub(super) fn text(&self) -> Result<&str, CharacterizeError> {
        match std::str::from_utf8(&self.text) {
            Ok(text) => Ok(text.trim_start_matches('\u{feff}').trim()),
            Err(_) => Err(self.refuse("not UTF-8 text; repair or remove the line")),
        }
    }

    /// A complaint about the current line.
    pub(super) fn refuse(&self, reason: impl Into<String>) -> CharacterizeError {
        CharacterizeError::bad_line(&self.path, self.number, reason)
    }

    /// A complaint about the end of the file.
    pub(super) fn ends_without(&self, missing: &'static str) -> CharacterizeError {
        CharacterizeError::Empty { path: self.path.clone(), line: self.number, missing }
    }

    fn next_line(&mut self) -> Result<bool, CharacterizeError> {
        self.text.clear();
        let length = (&mut self.reader)
            .take(LINE_MAX + 1)
            .read_until(b'\n', &mut self.text)
            .map_err(|source| CharacterizeError::Read { path: self.path.clone(), source })?
            as u64;
        self.bytes_read += length;
        self.number += u64::from(length > 0);
        if length > LINE_MAX {
            let reason = format!("longer than {LINE_MAX} bytes; repair or remove the line");
            return Err(self.refuse(reason));
        }
        Ok(length > 0)
    }
}

/// The cells of a line without blanks and quotes around them. Quotes keep commas together.
pub(super) fn cells(line: &str) -> impl Iterator<Item = &str> {
    let mut quoted = false;
    let parts = line.split(move |c| {
        quoted ^= c == '"';
        c == ',' && !quoted
    });
    parts.map(|cell| {
        let cell = cell.trim();
        cell.strip_prefix('"').and_then(|cell| cell.strip_suffix('"')).unwrap_or(cell)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_parted_by_commas_outside_of_quotes() {
        let line = "\"time\", a ,\"rate, deg/s\",,\"x\"";
        let found: Vec<_> = cells(line).collect();
        assert_eq!(found, ["time", "a", "rate, deg/s", "", "x"]);
    }
}
