//! What a frame file declares, once it has been found consistent.

use crate::field::{Coding, Endian, FieldSpec, read_code, write_code};
use crate::{Crc16, parse};

/// A declared frame layout with its line and its timing.
///
/// It can only be had from [`Self::from_toml`], so every one in existence is consistent: nothing
/// overlaps, nothing leaves the frame, and the line can carry the rate.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameSpec {
    pub(crate) name: String,
    pub(crate) provenance: Provenance,
    pub(crate) sync: Vec<u8>,
    pub(crate) len: usize,
    pub(crate) fields: Vec<FieldSpec>,
    pub(crate) flags: Vec<FlagSpec>,
    pub(crate) check: CheckSpec,
    pub(crate) sequence: Option<SequenceSpec>,
    pub(crate) line: LineSpec,
    pub(crate) timing: TimingSpec,
}

/// Where a layout comes from. A layout that nobody has seen on a wire must say so.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Provenance {
    /// Invented or guessed.
    Unverified,
    /// Taken from a published document.
    Published,
    /// Observed on the device.
    Measured,
}

/// A named status bit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FlagSpec {
    pub(crate) name: String,
    pub(crate) field: usize,
    pub(crate) bit: u32,
}

impl FlagSpec {
    /// Its name in the frame file.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Index of the field that holds it.
    #[must_use]
    pub const fn field(&self) -> usize {
        self.field
    }

    /// The bit as a mask over the field's raw value.
    #[must_use]
    pub const fn mask(&self) -> i64 {
        1 << self.bit
    }
}

/// A CRC-16 over consecutive bytes of the frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CheckSpec {
    pub(crate) crc: Crc16,
    pub(crate) first: usize,
    pub(crate) last: usize,
    pub(crate) at: usize,
    pub(crate) endian: Endian,
}

impl CheckSpec {
    /// Bytes that the check occupies.
    pub(crate) const BYTES: usize = 2;

    /// The algorithm.
    #[must_use]
    pub const fn crc(&self) -> &Crc16 {
        &self.crc
    }

    /// First and last byte covered, both included.
    #[must_use]
    pub const fn range(&self) -> (usize, usize) {
        (self.first, self.last)
    }

    /// Offset of its first byte in the frame.
    #[must_use]
    pub const fn at(&self) -> usize {
        self.at
    }

    /// Byte order of the stored value.
    #[must_use]
    pub const fn endian(&self) -> Endian {
        self.endian
    }

    #[inline]
    pub(crate) fn holds(&self, frame: &[u8]) -> bool {
        let computed = self.crc.checksum(&frame[self.first..=self.last]);
        let stored = read_code(&frame[self.at..self.at + Self::BYTES], self.endian);
        u64::from(computed) == stored
    }

    pub(crate) fn write(&self, frame: &mut [u8]) {
        let computed = self.crc.checksum(&frame[self.first..=self.last]);
        let stored = &mut frame[self.at..self.at + Self::BYTES];
        write_code(u64::from(computed), self.endian, stored);
    }
}

/// The gyro's own frame counter: the one witness of lost frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SequenceSpec {
    pub(crate) at: usize,
    pub(crate) bytes: usize,
    pub(crate) modulus: u64,
    pub(crate) endian: Endian,
}

impl SequenceSpec {
    /// Offset of its first byte in the frame.
    #[must_use]
    pub const fn at(&self) -> usize {
        self.at
    }

    /// Width, bits.
    #[must_use]
    pub const fn bits(&self) -> usize {
        self.bytes * 8
    }

    /// The counter runs from 0 to one less than this, then starts again.
    #[must_use]
    pub const fn modulus(&self) -> u64 {
        self.modulus
    }

    /// Byte order.
    #[must_use]
    pub const fn endian(&self) -> Endian {
        self.endian
    }

    #[inline]
    pub(crate) fn read(&self, frame: &[u8]) -> u64 {
        read_code(&frame[self.at..self.at + self.bytes], self.endian)
    }

    pub(crate) fn write(&self, index: u64, frame: &mut [u8]) {
        let bytes = &mut frame[self.at..self.at + self.bytes];
        write_code(index % self.modulus, self.endian, bytes);
    }
}

/// Parity bit of a character on the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parity {
    /// No parity bit.
    None,
    /// An even number of ones.
    Even,
    /// An odd number of ones.
    Odd,
}

/// Settings of the serial line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LineSpec {
    /// Symbols per second.
    pub baud: u32,
    /// Data bits per character. Frames are made of whole bytes, so always eight.
    pub data: u32,
    /// Parity.
    pub parity: Parity,
    /// Stop bits.
    pub stop: u32,
}

impl LineSpec {
    /// Symbols that one byte takes: start bit, data, parity, stop bits.
    #[must_use]
    pub const fn bits_per_byte(&self) -> u32 {
        let parity = match self.parity {
            Parity::None => 0,
            Parity::Even | Parity::Odd => 1,
        };
        1 + self.data + parity + self.stop
    }
}

/// When frames come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimingSpec {
    /// Nominal frame rate, Hz.
    pub rate_hz: f64,
    /// How far the true rate may lie from the nominal one, as a fraction of it.
    pub rate_tolerance: f64,
}

impl FrameSpec {
    /// Reads a frame file. The format is described in `docs/wire.md`.
    ///
    /// # Errors
    /// [`struna_settings::SettingsError`], with line, key, value and remedy, for text that is not
    /// TOML, for keys or words that are not understood, and for layouts that contradict
    /// themselves. No text makes it panic.
    pub fn from_toml(text: &str) -> struna_settings::Result<Self> {
        parse::frame_spec(text)
    }

    /// The layout's name and version, such as `struna/vg910d@1`.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Where the layout comes from.
    #[must_use]
    pub const fn provenance(&self) -> Provenance {
        self.provenance
    }

    /// The bytes every frame starts with; never empty.
    #[must_use]
    pub fn sync(&self) -> &[u8] {
        &self.sync
    }

    /// Length of a frame, bytes, sync and check included.
    #[must_use]
    pub const fn frame_len(&self) -> usize {
        self.len
    }

    /// The fields in the order of the file; indices into it are stable for the life of the spec.
    #[must_use]
    pub fn fields(&self) -> &[FieldSpec] {
        &self.fields
    }

    /// Index of the field called `name`.
    #[must_use]
    pub fn field_index(&self, name: &str) -> Option<usize> {
        self.fields.iter().position(|field| field.name == name)
    }

    /// The status bits in the order of the file.
    #[must_use]
    pub fn flags(&self) -> &[FlagSpec] {
        &self.flags
    }

    /// Index of the status bit called `name`.
    #[must_use]
    pub fn flag_index(&self, name: &str) -> Option<usize> {
        self.flags.iter().position(|flag| flag.name == name)
    }

    /// The check.
    #[must_use]
    pub const fn check(&self) -> &CheckSpec {
        &self.check
    }

    /// The frame counter, when the frame has one. Without it losses cannot be seen.
    #[must_use]
    pub const fn sequence(&self) -> Option<SequenceSpec> {
        self.sequence
    }

    /// The serial line.
    #[must_use]
    pub const fn line(&self) -> LineSpec {
        self.line
    }

    /// The frame rate.
    #[must_use]
    pub const fn timing(&self) -> TimingSpec {
        self.timing
    }

    /// Bits per second on the line at the nominal rate, start and stop bits included.
    #[must_use]
    pub fn bits_per_s(&self) -> f64 {
        self.len as f64 * f64::from(self.line.bits_per_byte()) * self.timing.rate_hz
    }

    /// Fields that may hold flags.
    pub(crate) fn may_hold_flags(field: &FieldSpec) -> bool {
        field.coding == Coding::Unsigned
    }
}
