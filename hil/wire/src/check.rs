//! The check that a frame carries.

use crate::place::Place;
use crate::{Crc, CrcParams};

/// What a check computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum CheckKind {
    /// No check: damage to the payload cannot be seen.
    None,
    /// Sum of the bytes, modulo 256.
    Sum8,
    /// What makes the sum of the bytes zero modulo 256.
    NegSum8,
    /// Exclusive or of the bytes.
    Xor8,
    /// A cyclic redundancy check.
    Crc(CrcParams),
    /// One bit inside the range makes the number of ones even or odd.
    Parity {
        /// Odd, not even.
        odd: bool,
    },
}

/// The check over consecutive bytes of the frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CheckSpec {
    pub(crate) algorithm: Algorithm,
    pub(crate) first: usize,
    pub(crate) last: usize,
    /// Where the value is stored; the parity bit for parity, and meaningless in a line of text,
    /// which ends in it, and without a check.
    pub(crate) place: Place,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Algorithm {
    None,
    Sum { negated: bool },
    Xor,
    Crc(Crc),
    Parity { odd: bool },
}

impl CheckSpec {
    /// What it computes.
    #[must_use]
    pub fn kind(&self) -> CheckKind {
        match &self.algorithm {
            Algorithm::None => CheckKind::None,
            Algorithm::Sum { negated: false } => CheckKind::Sum8,
            Algorithm::Sum { negated: true } => CheckKind::NegSum8,
            Algorithm::Xor => CheckKind::Xor8,
            Algorithm::Crc(crc) => CheckKind::Crc(crc.params()),
            Algorithm::Parity { odd } => CheckKind::Parity { odd: *odd },
        }
    }

    /// Bits that a frame of random content must hit: 0 without a check, 1 for parity.
    #[must_use]
    pub const fn bits(&self) -> u32 {
        match self.algorithm {
            Algorithm::None => 0,
            _ => self.place.bits,
        }
    }

    /// First and last byte covered, both included. A line's check covers what stands before it.
    #[must_use]
    pub const fn range(&self) -> (usize, usize) {
        (self.first, self.last)
    }

    /// Offset of the first byte of the stored value in the frame.
    #[must_use]
    pub const fn at(&self) -> usize {
        self.place.at
    }

    /// Byte order of the stored value.
    #[must_use]
    pub const fn endian(&self) -> crate::Endian {
        self.place.endian
    }

    /// Whether the check of a whole frame is right.
    #[inline]
    pub(crate) fn holds(&self, frame: &[u8]) -> bool {
        match &self.algorithm {
            Algorithm::None => true,
            Algorithm::Crc(crc) => {
                u64::from(crc.checksum(self.covered(frame))) == self.place.read(frame)
            }
            Algorithm::Parity { odd } => ones(self.covered(frame)) % 2 == u32::from(*odd),
            Algorithm::Sum { .. } | Algorithm::Xor => {
                self.byte_check(self.covered(frame)) == self.place.read(frame)
            }
        }
    }

    /// Whether `text`, up to a line's `*`, has the check `stored` behind it.
    pub(crate) fn holds_for_text(&self, text: &[u8], stored: u8) -> bool {
        self.byte_check(text) == u64::from(stored)
    }

    /// The check of a line's `text`.
    pub(crate) fn of_text(&self, text: &[u8]) -> u8 {
        self.byte_check(text).to_le_bytes()[0]
    }

    /// Completes a frame in which everything else has been written.
    pub(crate) fn write(&self, frame: &mut [u8]) {
        let value = match &self.algorithm {
            Algorithm::None => return,
            Algorithm::Crc(crc) => u64::from(crc.checksum(self.covered(frame))),
            Algorithm::Parity { odd } => {
                self.place.write(0, frame);
                u64::from(ones(self.covered(frame)) % 2 != u32::from(*odd))
            }
            Algorithm::Sum { .. } | Algorithm::Xor => self.byte_check(self.covered(frame)),
        };
        self.place.write(value, frame);
    }

    /// The value over the covered bytes alone, of a check that is linear in them.
    pub(crate) fn of_covered(&self, covered: &[u8]) -> u32 {
        match &self.algorithm {
            Algorithm::Crc(crc) => crc.checksum(covered),
            _ => u32::from(self.of_text(covered)),
        }
    }

    #[inline]
    fn covered<'a>(&self, frame: &'a [u8]) -> &'a [u8] {
        &frame[self.first..=self.last]
    }

    /// Sum or exclusive or, as wide as it is stored.
    #[inline]
    fn byte_check(&self, bytes: &[u8]) -> u64 {
        let sum = || bytes.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte));
        let value = match self.algorithm {
            Algorithm::Sum { negated: false } => sum(),
            Algorithm::Sum { negated: true } => sum().wrapping_neg(),
            _ => bytes.iter().fold(0, |xor, byte| xor ^ byte),
        };
        u64::from(value) & self.place.mask()
    }
}

fn ones(bytes: &[u8]) -> u32 {
    bytes.iter().map(|byte| byte.count_ones()).sum()
}
