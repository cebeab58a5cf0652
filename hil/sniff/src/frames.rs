//! Frames at known places, as columns.

use crate::layout::{Check, read};
use crate::length::as_f64;

/// Frames of one length; all columns of all of them are there.
#[derive(Debug, Clone)]
pub(crate) struct Frames<'a> {
    bytes: &'a [u8],
    pub(crate) len: usize,
    /// Ascending, none overlapping.
    pub(crate) starts: Vec<usize>,
    /// Bits of a number in one byte: 8, or 7 in septets.
    pub(crate) digit_bits: u32,
    /// Every frame passed its check.
    pub(crate) verified: bool,
}

impl<'a> Frames<'a> {
    pub(crate) fn new(
        bytes: &'a [u8],
        len: usize,
        mut starts: Vec<usize>,
        digit_bits: u32,
        verified: bool,
    ) -> Self {
        starts.retain(|start| start + len <= bytes.len());
        Self { bytes, len, starts, digit_bits, verified }
    }

    pub(crate) fn count(&self) -> usize {
        self.starts.len()
    }

    pub(crate) fn frame(&self, start: usize) -> &[u8] {
        &self.bytes[start..start + self.len]
    }

    pub(crate) fn byte(&self, start: usize, column: usize) -> u8 {
        self.bytes[start + column]
    }

    /// The number in `bytes` columns from `at`.
    pub(crate) fn number(&self, start: usize, at: usize, bytes: usize, big_endian: bool) -> u64 {
        read(&self.bytes[start + at..start + at + bytes], big_endian, self.digit_bits)
    }

    /// Starts of frames that border on each other.
    pub(crate) fn neighbours(&self) -> impl Iterator<Item = (usize, usize)> {
        let (len, pairs) = (self.len, self.starts.windows(2));
        pairs.filter(move |pair| pair[0] + len == pair[1]).map(|pair| (pair[0], pair[1]))
    }

    /// The commonest byte of a column and its share.
    pub(crate) fn mode(&self, column: usize) -> (u8, f64) {
        let mut counts = [0usize; 256];
        for start in &self.starts {
            counts[usize::from(self.byte(*start, column))] += 1;
        }
        let (byte, count) =
            (0u8..=255).zip(counts).max_by_key(|(_, count)| *count).unwrap_or((0, 0));
        (byte, as_f64(count) / as_f64(self.count().max(1)))
    }

    /// Columns that hold one value but for damage, which a check keeps out where it covers them.
    pub(crate) fn constant(&self, check: Option<&Check>) -> Vec<bool> {
        let covered =
            |column: &usize| check.is_some_and(|check| (check.first..=check.last).contains(column));
        // Unverified frames hold flipped bits and, at times, a slip in each direction.
        let least = |column: &usize| if covered(column) { 0.998 } else { 0.96 };
        (0..self.len).map(|column| self.mode(column).1 >= least(&column)).collect()
    }
}
