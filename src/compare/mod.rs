//! How far two files of signals over time are apart: truth motions or records, read row by row.
//!
//! Columns are matched by name, rows by time. One file may have more instants than the other, in
//! between or at its end; the common ones are compared then.

mod difference;
mod error;
mod file;
mod table;

pub use difference::{Difference, attitude_angle_rad};
pub use error::{CompareError, Instant};

use difference::Tally;
use file::SignalFile;
use std::path::{Path, PathBuf};

/// Instants this close are one: times are whole nanoseconds, written in seconds.
const SAME_INSTANT_S: f64 = 0.5e-9;
/// Rows between two words about the progress.
const ROWS_PER_WORD: u64 = 4096;

/// What two files have in common and how far it is apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// The two files.
    pub files: [ComparedFile; 2],
    /// How many instants were compared.
    pub instants: u64,
    /// The first and the last of them, s.
    pub span_s: [f64; 2],
    /// One for each quantity that both files have, in the order of the first.
    pub differences: Vec<Difference>,
}

/// One of two compared files.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparedFile {
    /// Where it lies.
    pub path: PathBuf,
    /// What its comment lines say.
    pub comments: Vec<String>,
    /// Columns that the other file lacks.
    pub columns_alone: Vec<String>,
    /// Rows up to its last common instant that the other file lacks.
    pub rows_between: u64,
    /// Rows after the end of the other file.
    pub rows_after: u64,
}

impl Comparison {
    /// The angle (attitude, or column in rad) that is furthest apart.
    #[must_use]
    pub fn widest_angle(&self) -> Option<&Difference> {
        let angles = self.differences.iter().filter(|difference| difference.unit == "rad");
        angles.max_by(|a, b| a.largest.unwrap_or(0.0).total_cmp(&b.largest.unwrap_or(0.0)))
    }
}

/// Compares the files `a` and `b`; `progress` is told how many thousandths of them are read.
///
/// Takes the memory of two rows, however long the files are.
///
/// # Errors
/// [`CompareError`] names file, line, column and value of the first obstacle, and the remedy.
pub fn compare(
    a: &Path,
    b: &Path,
    progress: &mut dyn FnMut(u64),
) -> Result<Comparison, CompareError> {
    let (a, b) = (SignalFile::open(a)?, SignalFile::open(b)?);
    let mut tallies = Tally::of_common(&a, &b);
    if tallies.is_empty() {
        return Err(no_common_column(&a, &b));
    }
    let mut walk = Walk::new([a, b]);
    walk.along(progress, &mut |a, b| tallies.iter_mut().try_for_each(|tally| tally.add(a, b)))?;
    Ok(Comparison {
        files: [walk.compared_file(0), walk.compared_file(1)],
        instants: walk.instants,
        span_s: walk.span_s,
        differences: tallies.into_iter().map(Tally::finish).collect(),
    })
}

fn no_common_column(a: &SignalFile, b: &SignalFile) -> CompareError {
    CompareError::NoCommonColumn {
        a: a.path().to_owned(),
        columns_a: a.names().join(", "),
        b: b.path().to_owned(),
        columns_b: b.names().join(", "),
    }
}

/// A walk through two files side by side, stopping where both have a row.
struct Walk {
    files: [SignalFile; 2],
    instants: u64,
    span_s: [f64; 2],
    rows_between: [u64; 2],
    rows_after: [u64; 2],
    /// First row of each file that the other passed without having it.
    alone: [Option<Instant>; 2],
    rows: u64,
}

impl Walk {
    fn new(files: [SignalFile; 2]) -> Self {
        Self {
            files,
            instants: 0,
            span_s: [0.0; 2],
            rows_between: [0; 2],
            rows_after: [0; 2],
            alone: [None, None],
            rows: 0,
        }
    }

    /// Goes to the end of both files; `visit` sees them at each common instant.
    fn along(
        &mut self,
        progress: &mut dyn FnMut(u64),
        visit: &mut dyn FnMut(&SignalFile, &SignalFile) -> Result<(), CompareError>,
    ) -> Result<(), CompareError> {
        let mut more = [self.first(0)?, self.first(1)?];
        while more == [true, true] {
            let [a, b] = &self.files;
            let ahead_s = a.time_s() - b.time_s();
            if ahead_s.abs() <= SAME_INSTANT_S {
                visit(a, b)?;
                self.count_instant();
                more = [self.advance(0, progress)?, self.advance(1, progress)?];
            } else {
                let behind = usize::from(ahead_s > 0.0);
                self.leave_out(behind)?;
                more[behind] = self.advance(behind, progress)?;
            }
        }
        if self.instants == 0 {
            return Err(self.no_common_instant(more));
        }
        for side in [0, 1] {
            while more[side] {
                self.rows_after[side] += 1;
                more[side] = self.advance(side, progress)?;
            }
        }
        Ok(())
    }

    fn first(&mut self, side: usize) -> Result<bool, CompareError> {
        let file = &mut self.files[side];
        if file.advance()? { Ok(true) } else { Err(file.without_rows()) }
    }

    fn advance(
        &mut self,
        side: usize,
        progress: &mut dyn FnMut(u64),
    ) -> Result<bool, CompareError> {
        self.rows += 1;
        if self.rows.is_multiple_of(ROWS_PER_WORD) {
            let [(size_a, read_a), (size_b, read_b)] = [0, 1].map(|side| self.files[side].bytes());
            progress(1000 * (read_a + read_b) / (size_a + size_b).max(1));
        }
        self.files[side].advance()
    }

    fn count_instant(&mut self) {
        let time_s = self.files[0].time_s();
        if self.instants == 0 {
            self.span_s[0] = time_s;
        }
        self.span_s[1] = time_s;
        self.instants += 1;
    }

    /// Passes the current row of one file, which the other does not have. One file may do so.
    fn leave_out(&mut self, side: usize) -> Result<(), CompareError> {
        self.rows_between[side] += 1;
        if self.alone[side].is_none() {
            self.alone[side] = Some(self.files[side].instant());
        }
        match &self.alone {
            [Some(a), Some(b)] => Err(CompareError::GridsDiffer { a: a.clone(), b: b.clone() }),
            _ => Ok(()),
        }
    }

    /// One file was passed whole and the other stands at its first row still.
    fn no_common_instant(&self, more: [bool; 2]) -> CompareError {
        let [a, b] = &self.files;
        let (early, late) = if more[0] { (b, a) } else { (a, b) };
        CompareError::NoCommonInstant { last: early.instant(), first: late.instant() }
    }

    fn compared_file(&self, side: usize) -> ComparedFile {
        let (file, other) = (&self.files[side], &self.files[1 - side]);
        let alone = file.names().iter().filter(|name| other.find(name).is_none());
        ComparedFile {
            path: file.path().to_owned(),
            comments: file.comments().to_vec(),
            columns_alone: alone.cloned().collect(),
            rows_between: self.rows_between[side],
            rows_after: self.rows_after[side],
        }
    }
}
