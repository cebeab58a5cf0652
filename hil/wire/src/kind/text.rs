//! Lines of text.
//!
//! A line becomes a record with eight bytes for each column, so that whatever reads fields out of
//! bytes reads them out of text too.

use super::{Cut, Cutter, Scratch, Seek};
use crate::framing::Text;
use crate::{CheckSpec, Coding};
use memchr::memmem;

/// Finds lines and reads their columns.
#[derive(Debug, Clone)]
pub(crate) struct Line {
    prefix: Vec<u8>,
    text: Text,
    check: CheckSpec,
}

impl Line {
    pub(crate) fn new(prefix: &[u8], text: &Text, check: &CheckSpec) -> Self {
        Self { prefix: prefix.to_owned(), text: text.clone(), check: check.clone() }
    }

    /// Reads a line without its LF into a record; `None` when it is no frame.
    fn read(&self, line: &[u8], record: &mut Scratch) -> Option<()> {
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        let body = line.strip_prefix(self.prefix.as_slice())?;
        // The last prefix of a line begins its frame, even one that overlaps the first.
        if !self.prefix.is_empty() && memmem::find(&line[1..], &self.prefix).is_some() {
            return None;
        }
        let body = if self.text.starred { self.unstarred(line, body)? } else { body };
        let mut columns = Columns { rest: Some(body), separator: self.text.separator };
        for (coding, cell) in self.text.columns.iter().zip(record.chunks_exact_mut(8)) {
            let value = number(columns.next()?, *coding)?;
            cell.copy_from_slice(&value.to_be_bytes());
        }
        columns.next().is_none().then_some(())
    }

    /// Takes `*hh` off the end, if it is right. The check covers all before the star, but for a
    /// dollar sign in front.
    fn unstarred<'a>(&self, line: &[u8], body: &'a [u8]) -> Option<&'a [u8]> {
        let (body, end) = body.split_at_checked(body.len().checked_sub(3)?)?;
        let [b'*', high, low] = *end else { return None };
        let stored = hex_digit(high)? << 4 | hex_digit(low)?;
        let covered = &line[..line.len() - 3];
        let covered = covered.strip_prefix(b"$").unwrap_or(covered);
        self.check.holds_for_text(covered, stored).then_some(body)
    }

    /// Where the frame of the line `before` a line feed must begin, if anywhere.
    fn last_prefix(&self, before: &[u8]) -> Option<usize> {
        memmem::rfind(before, &self.prefix)
    }

    /// [`Cutter::seek`] for lines that begin with a prefix.
    fn seek_prefix(&self, bytes: &[u8]) -> Seek {
        let line_end = memchr::memchr(b'\n', bytes);
        let line = &bytes[..line_end.unwrap_or(bytes.len())];
        let start = self.last_prefix(line).filter(|at| line.len() - at < self.text.longest);
        match (start, line_end) {
            // The front itself is a line, and it has been found wanting.
            (Some(0), _) => Seek { skip: 0, aligned: true },
            (Some(at), _) => Seek { skip: at, aligned: false },
            (None, Some(end)) => Seek { skip: end + 1, aligned: true },
            // The last bytes may be the beginning of a prefix.
            (None, None) => {
                let keep = bytes.len().min(self.prefix.len() - 1);
                Seek { skip: bytes.len() - keep, aligned: false }
            }
        }
    }
}

impl Cutter for Line {
    const DELIMITED: bool = true;

    fn cut<'a>(&self, bytes: &'a [u8], aligned: bool, scratch: &'a mut Scratch) -> Cut<'a> {
        let front = &bytes[..bytes.len().min(self.text.longest)];
        let Some(end) = memchr::memchr(b'\n', front) else {
            let full = front.len() == self.text.longest;
            return if full { Cut::Broken { wire_len: 1 } } else { Cut::Short };
        };
        let wire_len = end + 1;
        // Without a prefix, what came before decides whether this is the beginning of a line.
        let begins = aligned || !self.prefix.is_empty();
        match begins.then(|| self.read(&front[..end], scratch)).flatten() {
            Some(()) => Cut::Whole { content: &scratch[..8 * self.text.columns.len()], wire_len },
            None => Cut::Broken { wire_len },
        }
    }

    fn seek(&self, bytes: &[u8], aligned: bool) -> Seek {
        if !self.prefix.is_empty() {
            return self.seek_prefix(bytes);
        }
        let fits = |line_len: usize| aligned && line_len <= self.text.longest;
        match memchr::memchr(b'\n', bytes) {
            Some(end) if fits(end + 1) => Seek { skip: 0, aligned },
            Some(end) => Seek { skip: end + 1, aligned: true },
            None if fits(bytes.len() + 1) => Seek { skip: 0, aligned },
            None => Seek { skip: bytes.len(), aligned: false },
        }
    }
}

/// The columns of a line.
struct Columns<'a> {
    rest: Option<&'a [u8]>,
    separator: u8,
}

impl<'a> Iterator for Columns<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let blank = self.separator == b' ';
        let first = self.rest?.iter().position(|byte| !blank || *byte != b' ');
        let rest = &self.rest?[first.unwrap_or(self.rest?.len())..];
        if blank && rest.is_empty() {
            self.rest = None;
            return None;
        }
        match memchr::memchr(self.separator, rest) {
            Some(end) => {
                self.rest = Some(&rest[end + 1..]);
                Some(&rest[..end])
            }
            None => {
                self.rest = None;
                Some(rest)
            }
        }
    }
}

/// The number that a column holds; zero for one that is not looked at.
fn number(text: &[u8], coding: Option<Coding>) -> Option<i64> {
    match coding {
        Some(Coding::Decimal { digits, decimals }) => decimal(text, digits, decimals),
        Some(Coding::Hex { digits }) => {
            let fits = text.len() == digits as usize;
            let append = |value: i64, c: &u8| Some(value << 4 | i64::from(hex_digit(*c)?));
            fits.then(|| text.iter().try_fold(0, append)).flatten()
        }
        _ => text.iter().all(u8::is_ascii_graphic).then_some(0),
    }
}

/// Digits with the point left out.
fn decimal(text: &[u8], digits: u32, decimals: u32) -> Option<i64> {
    let unsigned = text.strip_prefix(b"-").unwrap_or(text);
    let behind = if decimals == 0 { 0 } else { 1 + decimals as usize };
    let (whole, behind) = unsigned.split_at_checked(unsigned.len().checked_sub(behind)?)?;
    let fraction = if decimals == 0 { behind } else { behind.strip_prefix(b".")? };
    if whole.is_empty() || whole.len() > digits as usize {
        return None;
    }
    let append = |value: i64, c: &u8| c.is_ascii_digit().then(|| 10 * value + i64::from(c - b'0'));
    let magnitude = whole.iter().chain(fraction).try_fold(0, append)?;
    Some(if unsigned.len() < text.len() { -magnitude } else { magnitude })
}

fn hex_digit(c: u8) -> Option<u8> {
    char::from(c).to_digit(16).and_then(|digit| u8::try_from(digit).ok())
}

/// Appends the line of a record.
pub(super) fn emit(
    prefix: &[u8],
    text: &Text,
    check: &CheckSpec,
    record: &[u8],
    out: &mut Vec<u8>,
) {
    let start = out.len();
    out.extend_from_slice(prefix);
    for (k, (coding, cell)) in text.columns.iter().zip(record.chunks_exact(8)).enumerate() {
        if k > 0 {
            out.push(text.separator);
        }
        let value = cell.iter().fold(0, |value, byte| value << 8 | u64::from(*byte));
        emit_number(value.cast_signed(), *coding, out);
    }
    if text.starred {
        let line = &out[start..];
        let covered = line.strip_prefix(b"$").unwrap_or(line);
        let value = check.of_text(covered);
        out.push(b'*');
        out.extend(
            [value >> 4, value & 0xF].map(|nibble| b"0123456789ABCDEF"[usize::from(nibble)]),
        );
    }
    out.extend_from_slice(b"\r\n");
}

fn emit_number(value: i64, coding: Option<Coding>, out: &mut Vec<u8>) {
    match coding {
        Some(Coding::Hex { digits }) => {
            for place in (0..digits).rev() {
                let nibble = usize::try_from(value >> (4 * place) & 0xF).unwrap_or(0);
                out.push(b"0123456789ABCDEF"[nibble]);
            }
        }
        Some(Coding::Decimal { decimals, .. }) => emit_decimal(value, decimals, out),
        _ => out.push(b'0'),
    }
}

fn emit_decimal(value: i64, decimals: u32, out: &mut Vec<u8>) {
    if value < 0 {
        out.push(b'-');
    }
    let magnitude = value.unsigned_abs();
    let digits = (magnitude.checked_ilog10().unwrap_or(0) + 1).max(decimals + 1);
    for place in (0..digits).rev() {
        let digit = magnitude / 10_u64.pow(place) % 10;
        out.push(b'0' + u8::try_from(digit).unwrap_or(0));
        if place == decimals && decimals > 0 {
            out.push(b'.');
        }
    }
}
