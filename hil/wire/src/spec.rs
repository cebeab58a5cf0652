//! What a frame file declares, once it has been found consistent.

use crate::evidence::Evidence;
use crate::field::{Coding, Endian, FieldSpec};
use crate::framing::{Framing, Kind};
use crate::place::Place;
use crate::{CheckSpec, parse};

/// A declared frame layout with its line and its timing.
///
/// It can only be had from [`Self::from_toml`], so every one in existence is consistent: nothing
/// overlaps, nothing leaves the frame, and the line can carry the rate.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameSpec {
    pub(crate) name: String,
    pub(crate) provenance: Provenance,
    pub(crate) framing: Framing,
    pub(crate) sync: Vec<u8>,
    pub(crate) len: usize,
    pub(crate) fields: Vec<FieldSpec>,
    pub(crate) flags: Vec<FlagSpec>,
    pub(crate) check: CheckSpec,
    pub(crate) sequence: Option<SequenceSpec>,
    pub(crate) plausible: Option<PlausibleSpec>,
    pub(crate) evidence: Evidence,
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

/// The gyro's own frame counter: the one witness of lost frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SequenceSpec {
    pub(crate) place: Place,
    pub(crate) modulus: u64,
}

impl SequenceSpec {
    /// Offset of its first byte in the frame; in a line of text, eight times its column.
    #[must_use]
    pub const fn at(&self) -> usize {
        self.place.at
    }

    /// Width, bits.
    #[must_use]
    pub const fn bits(&self) -> usize {
        self.place.bits as usize
    }

    /// Bytes of the container that holds the bits.
    #[must_use]
    pub const fn bytes(&self) -> usize {
        self.place.bytes
    }

    /// Lowest bit in the container.
    #[must_use]
    pub const fn shift(&self) -> usize {
        self.place.shift as usize
    }

    /// The counter runs from 0 to one less than this, then starts again.
    #[must_use]
    pub const fn modulus(&self) -> u64 {
        self.modulus
    }

    /// Byte order.
    #[must_use]
    pub const fn endian(&self) -> Endian {
        self.place.endian
    }

    #[inline]
    pub(crate) fn read(&self, frame: &[u8]) -> u64 {
        self.place.read(frame)
    }

    pub(crate) fn write(&self, counter: u64, frame: &mut [u8]) {
        self.place.write(counter, frame);
    }
}

/// What is credible of the field `rate`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlausibleSpec {
    /// Index of the field.
    pub field: usize,
    /// Largest credible difference between consecutive frames, in the field's SI unit.
    pub step_max_si: f64,
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
    /// What tells a frame's instant.
    pub time: TimeSource,
}

/// What tells a frame's instant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TimeSource {
    /// The gyro's frame counter and the nominal rate.
    Counter,
    /// When its bytes arrive.
    Arrival,
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

    /// How frames are told apart.
    #[must_use]
    pub const fn kind(&self) -> Kind {
        match self.framing {
            Framing::Fixed { .. } => Kind::Fixed,
            Framing::Septet => Kind::Septet,
            Framing::Cobs => Kind::Cobs,
            Framing::Ascii(_) => Kind::Ascii,
        }
    }

    /// The bytes every frame starts with; empty for COBS, and for lines without a prefix.
    #[must_use]
    pub fn sync(&self) -> &[u8] {
        &self.sync
    }

    /// What stands between the columns of a line of text.
    #[must_use]
    pub const fn separator(&self) -> Option<u8> {
        match &self.framing {
            Framing::Ascii(text) => Some(text.separator),
            _ => None,
        }
    }

    /// The bits of the sync word that count, as long as the word; empty when all do.
    #[must_use]
    pub fn sync_mask(&self) -> &[u8] {
        match &self.framing {
            Framing::Fixed { mask } => mask,
            _ => &[],
        }
    }

    /// Length of a frame's content, bytes: sync and check included, COBS coding left out. A line
    /// of text has eight bytes for each column.
    #[must_use]
    pub const fn frame_len(&self) -> usize {
        self.len
    }

    /// Bytes that a frame takes on the wire; the most it can take for a line of text.
    #[must_use]
    pub const fn wire_len(&self) -> usize {
        match &self.framing {
            Framing::Fixed { .. } | Framing::Septet => self.len,
            Framing::Cobs => self.len + 2,
            Framing::Ascii(text) => text.longest - text.padding,
        }
    }

    /// The most bytes that can be one frame to the decoder.
    pub(crate) const fn longest(&self) -> usize {
        match &self.framing {
            Framing::Ascii(text) => text.longest,
            _ => self.wire_len(),
        }
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

    /// The counter's modulus; without a counter all frames count zero.
    #[inline]
    pub(crate) fn modulus(&self) -> u64 {
        self.sequence.map_or(1, |sequence| sequence.modulus)
    }

    /// What is credible of the rate, when the file says.
    #[must_use]
    pub const fn plausible(&self) -> Option<PlausibleSpec> {
        self.plausible
    }

    /// How hard it is for noise to pass as a frame.
    #[must_use]
    pub const fn evidence(&self) -> Evidence {
        self.evidence
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
        self.wire_len() as f64 * f64::from(self.line.bits_per_byte()) * self.timing.rate_hz
    }

    /// Fields that may hold flags.
    pub(crate) fn may_hold_flags(field: &FieldSpec) -> bool {
        matches!(field.coding, Coding::Unsigned | Coding::Hex { .. })
    }
}
