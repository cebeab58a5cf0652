//! The bytes of a live run as they came: `raw.bin`, and in `raw.csv` when each piece came.

use super::part_file::PartFile;
use anyhow::{Context, Result, bail};
use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use struna_harness::live::LineInput;
use struna_kernel::SimTime;

/// The bytes.
pub const BYTES: &str = "raw.bin";
/// When they came.
pub const TIMES: &str = "raw.csv";
/// Columns of `raw.csv`.
const COLUMNS: [&str; 3] = ["offset_bytes", "arrival_s", "event"];
const NS_PER_S: i64 = 1_000_000_000;
/// Bytes given to the pipeline in one go, as in a live run at most.
const PIECE: usize = 4096;

/// Writes both files.
#[derive(Debug)]
pub struct RawWriter {
    bytes: PartFile,
    times: PartFile,
    offset: u64,
}

impl RawWriter {
    /// Begins the files in `folder`.
    ///
    /// # Errors
    /// Path and the system's reason.
    pub fn create(folder: &Path) -> Result<Self, (PathBuf, io::Error)> {
        let (bytes, times) = (folder.join(BYTES), folder.join(TIMES));
        let mut times = PartFile::of_lines(&times).map_err(|error| (times, error))?;
        times.entries().extend(format!("{}\n", COLUMNS.join(",")).bytes());
        Ok(Self { bytes: PartFile::of_bytes(&bytes).map_err(|e| (bytes, e))?, times, offset: 0 })
    }

    /// Notes what happened on the line.
    ///
    /// # Errors
    /// The system's reason.
    pub fn note(&mut self, time: SimTime, input: LineInput<'_>) -> io::Result<()> {
        let event = match input {
            LineInput::Bytes(_) => "",
            LineInput::Silent => "silent",
            LineInput::Lost => "lost",
            LineInput::Back => "back",
        };
        self.row(time, event)?;
        if let LineInput::Bytes(bytes) = input {
            self.bytes.entries().extend(bytes);
            self.offset += bytes.len() as u64;
            self.bytes.settle()?;
        }
        Ok(())
    }

    fn row(&mut self, time: SimTime, event: &str) -> io::Result<()> {
        let ns = time.as_ns().max(0);
        let (s, ns) = (ns / NS_PER_S, ns % NS_PER_S);
        writeln!(self.times.entries(), "{},{s}.{ns:09},{event}", self.offset)?;
        self.times.settle()
    }

    /// Hands everything to the system.
    ///
    /// # Errors
    /// The system's reason.
    pub fn flush(&mut self) -> io::Result<()> {
        self.bytes.flush()?;
        self.times.flush()
    }

    /// Ends both files at `now` and gives them their names.
    ///
    /// # Errors
    /// The system's reason; both have their names nevertheless.
    pub fn keep(mut self, now: SimTime) -> io::Result<()> {
        let ended = self.row(now, "end");
        let kept = self.bytes.keep();
        self.times.keep().and(kept).and(ended)
    }
}

/// What a row of `raw.csv` says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Word {
    Bytes,
    Silent,
    Lost,
    Back,
    End,
}

/// A row of `raw.csv`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Row {
    offset: u64,
    time: SimTime,
    word: Word,
}

/// Gives everything that a run in `folder` noted to `sink`, in order; returns when it ended.
///
/// A run that was cut off has bytes without a time or times without bytes; both are left out.
///
/// # Errors
/// File, line and reason; what `sink` says.
pub fn replay(
    folder: &Path,
    sink: &mut dyn FnMut(SimTime, LineInput<'_>) -> Result<()>,
) -> Result<SimTime> {
    let open = |name| {
        let path = folder.join(name);
        File::open(&path).with_context(|| format!("cannot read {}", path.display()))
    };
    let mut bytes = BufReader::new(open(BYTES)?);
    let mut rows = csv::Reader::from_reader(BufReader::new(open(TIMES)?));
    let mut record = csv::StringRecord::new();
    let mut pending: Option<Row> = None;
    let mut last = SimTime::ZERO;
    while rows.read_record(&mut record)? {
        let line = record.position().map_or(0, csv::Position::line);
        let row = row(&record).with_context(|| format!("{TIMES}, line {line}"))?;
        let before = pending.map_or(0, |row| row.offset);
        if row.time < last || row.offset < before {
            bail!("{TIMES}, line {line}: time and offset never go back");
        }
        last = row.time;
        if let Some(pending) = pending {
            give(pending, row.offset - pending.offset, &mut bytes, sink)?;
        }
        pending = Some(row);
    }
    if let Some(pending) = pending {
        give(pending, u64::MAX, &mut bytes, sink)?;
    }
    Ok(last)
}

/// Gives what `row` says, and the next `length` bytes if it speaks of bytes.
fn give(
    row: Row,
    length: u64,
    bytes: &mut impl Read,
    sink: &mut dyn FnMut(SimTime, LineInput<'_>) -> Result<()>,
) -> Result<()> {
    match row.word {
        Word::Silent => return sink(row.time, LineInput::Silent),
        Word::Lost => return sink(row.time, LineInput::Lost),
        Word::Back => return sink(row.time, LineInput::Back),
        Word::End => return Ok(()),
        Word::Bytes => {}
    }
    let mut piece = [0; PIECE];
    let mut bytes = bytes.take(length);
    loop {
        let n = bytes.read(&mut piece).with_context(|| format!("cannot read {BYTES}"))?;
        if n == 0 {
            return Ok(());
        }
        sink(row.time, LineInput::Bytes(&piece[..n]))?;
    }
}

fn row(record: &csv::StringRecord) -> Result<Row> {
    let cell = |k: usize| record.get(k).unwrap_or_default();
    let offset = cell(0).parse().with_context(|| format!("'{}' is no offset", cell(0)))?;
    let time = nanoseconds(cell(1)).with_context(|| format!("'{}' is no time", cell(1)))?;
    let word = match cell(2) {
        "" => Word::Bytes,
        "silent" => Word::Silent,
        "lost" => Word::Lost,
        "back" => Word::Back,
        "end" => Word::End,
        other => bail!("'{other}' is no event; there are silent, lost, back and end"),
    };
    Ok(Row { offset, time: SimTime::from_ns(time), word })
}

/// Seconds with nine decimals as nanoseconds: exactly, where a float would round.
fn nanoseconds(text: &str) -> Option<i64> {
    let (s, ns) = text.split_once('.')?;
    let digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    if ns.len() != 9 || !digits(s) || !digits(ns) {
        return None;
    }
    let s: i64 = s.parse().ok()?;
    s.checked_mul(NS_PER_S)?.checked_add(ns.parse().ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An input with its own bytes.
    fn owned(input: LineInput<'_>) -> (&'static str, Vec<u8>) {
        match input {
            LineInput::Bytes(bytes) => ("bytes", bytes.to_vec()),
            LineInput::Silent => ("silent", Vec::new()),
            LineInput::Lost => ("lost", Vec::new()),
            LineInput::Back => ("back", Vec::new()),
        }
    }

    /// Time in nanoseconds, kind, bytes.
    type Owned = (i64, (&'static str, Vec<u8>));

    fn read(folder: &Path) -> Result<Vec<Owned>> {
        let mut read = Vec::new();
        replay(folder, &mut |time, input| {
            read.push((time.as_ns(), owned(input)));
            Ok(())
        })?;
        Ok(read)
    }

    #[test]
    fn what_was_noted_is_read_again_to_the_nanosecond() {
        let folder = tempfile::tempdir().unwrap();
        let mut raw = RawWriter::create(folder.path()).unwrap();
        let inputs = [
            (0, LineInput::Bytes(&[1, 2, 3])),
            (20_000_001, LineInput::Silent),
            (1_000_000_007, LineInput::Bytes(&[0xA5])),
            (1_000_000_007, LineInput::Lost),
            (9_007_199_254_740_993, LineInput::Back),
            (9_007_199_254_740_995, LineInput::Bytes(&[9; 4096])),
        ];
        for (ns, input) in inputs {
            raw.note(SimTime::from_ns(ns), input).unwrap();
        }
        raw.keep(SimTime::from_ns(9_007_199_254_740_996)).unwrap();
        let expected: Vec<_> = inputs.iter().map(|(ns, input)| (*ns, owned(*input))).collect();
        assert_eq!(read(folder.path()).unwrap(), expected);
    }

    #[test]
    fn a_damaged_file_is_refused_by_line_and_a_short_one_is_read_as_far_as_it_goes() {
        let folder = tempfile::tempdir().unwrap();
        let write = |times: &str| {
            std::fs::write(folder.path().join(BYTES), [7; 10]).unwrap();
            let text = format!("offset_bytes,arrival_s,event\n{times}");
            std::fs::write(folder.path().join(TIMES), text).unwrap();
        };
        for bad in [
            "0,1.5,\n",
            "x,1.500000000,\n",
            "0,-1.500000000,\n",
            "0,1.500000000,later\n",
            "0,2.000000000,\n5,1.000000000,\n",
            "5,1.000000000,\n4,2.000000000,\n",
        ] {
            write(bad);
            let refused = format!("{:#}", read(folder.path()).unwrap_err());
            assert!(refused.contains("line"), "{bad}: {refused}");
        }
        write("0,1.000000000,\n8,2.000000000,\n20,3.000000000,\n");
        let read = read(folder.path()).unwrap();
        assert_eq!(read.iter().map(|(_, (_, bytes))| bytes.len()).collect::<Vec<_>>(), [8, 2]);
    }
}
