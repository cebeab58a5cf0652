//! What a proposal says about a frame, and reading frames by it.

use crate::catalogue::{Crc, KERNELS};

/// How frames are told apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A sync word and a fixed length.
    Fixed,
    /// One marker byte with bit 7 set, all other bytes below 128.
    Septet,
}

/// What a check is computed by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CheckKind {
    /// Sum of the bytes.
    Sum8,
    /// Two's complement of the sum: range and check add up to zero.
    NegSum8,
    /// XOR of the bytes.
    Xor8,
    /// A CRC.
    Crc(Crc),
}

impl CheckKind {
    /// Bytes that the check takes.
    #[must_use]
    pub const fn bytes(&self) -> usize {
        match self {
            Self::Crc(crc) => crc.width as usize / 8,
            _ => 1,
        }
    }

    /// The check of `range`.
    pub(crate) fn of(&self, range: impl Iterator<Item = u8>) -> u64 {
        match self {
            Self::Sum8 => range.fold(0u8, u8::wrapping_add).into(),
            Self::NegSum8 => range.fold(0u8, u8::wrapping_sub).into(),
            Self::Xor8 => range.fold(0u8, |a, b| a ^ b).into(),
            Self::Crc(crc) => {
                let kernel = KERNELS.iter().find(|kernel| kernel.belongs(crc));
                kernel.map_or(0, |kernel| kernel.crc(crc, range).into())
            }
        }
    }
}

/// The check of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Check {
    /// The algorithm.
    pub kind: CheckKind,
    /// First byte covered.
    pub first: usize,
    /// Last byte covered.
    pub last: usize,
    /// Where it is stored.
    pub at: usize,
    /// Order of its bytes, where it has several.
    pub big_endian: bool,
    /// Only seven bits are stored, as in septet frames.
    pub seven_bits: bool,
}

impl Check {
    /// Whether `frame`, whole, passes.
    #[must_use]
    pub fn holds(&self, frame: &[u8]) -> bool {
        let Some(range) = frame.get(self.first..=self.last) else { return false };
        let Some(stored) = frame.get(self.at..self.at + self.kind.bytes()) else { return false };
        let computed = self.kind.of(range.iter().copied());
        let mask = if self.seven_bits { 0x7F } else { u64::MAX };
        computed & mask == read(stored, self.big_endian, 8)
    }
}

/// The frame counter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Counter {
    /// Where it lies.
    pub at: usize,
    /// Bytes, or septets, that it takes.
    pub bytes: usize,
    /// Their order.
    pub big_endian: bool,
    /// It runs from 0 to this less one.
    pub modulus: u32,
}

/// How a field's bits are a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coding {
    /// Two's complement.
    Twos,
    /// Offset binary: zero is the middle of the code.
    OffsetBinary,
    /// The bits as they are.
    Unsigned,
    /// IEEE 754, 32 bits.
    Float,
}

/// What a field seems to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// The rate: the field that moves most for its size.
    Rate,
    /// A slow number of two bytes.
    Temperature,
    /// A byte that jumps.
    Status,
    /// Channel bits of a word that carries several quantities in turn.
    Channel,
    /// Something else.
    Unknown,
}

/// A number in the frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Field {
    /// What it seems to be.
    pub role: Role,
    /// Where its bytes start.
    pub at: usize,
    /// Bytes, or septets, that hold it.
    pub bytes: usize,
    /// Its bits in them.
    pub bits: u32,
    /// Its lowest bit in them.
    pub shift: u32,
    /// Order of the bytes.
    pub big_endian: bool,
    /// How bits are a number.
    pub coding: Coding,
    /// Whether it is there only in frames whose channel bits are zero.
    pub only_channel_zero: bool,
}

impl Field {
    /// The raw value in `frame`; for a float its bit pattern. `digit_bits` is 8, or 7 in septets.
    #[must_use]
    pub fn raw(&self, frame: &[u8], digit_bits: u32) -> i64 {
        let container = read(&frame[self.at..self.at + self.bytes], self.big_endian, digit_bits);
        let mask = u64::MAX >> (64 - self.bits);
        let code = ((container >> self.shift) & mask).cast_signed();
        match self.coding {
            Coding::Unsigned | Coding::Float => code,
            Coding::OffsetBinary => code - (1 << (self.bits - 1)),
            Coding::Twos if code >> (self.bits - 1) == 1 => code - (1 << self.bits),
            Coding::Twos => code,
        }
    }
}

/// A frame layout in binary.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    /// How frames are told apart.
    pub kind: Kind,
    /// Bytes in a frame.
    pub len: usize,
    /// The first bytes of every frame; at least one.
    pub sync: Vec<u8>,
    /// The check, if there is one.
    pub check: Option<Check>,
    /// The frame counter, if there is one.
    pub counter: Option<Counter>,
    /// Numbers, in the order in which they lie.
    pub fields: Vec<Field>,
}

impl Layout {
    /// Bits of a number that one byte carries.
    #[must_use]
    pub const fn digit_bits(&self) -> u32 {
        match self.kind {
            Kind::Fixed => 8,
            Kind::Septet => 7,
        }
    }

    /// The rate.
    #[must_use]
    pub fn rate(&self) -> Option<&Field> {
        self.fields.iter().find(|field| field.role == Role::Rate)
    }

    /// The counter's value in a whole frame.
    pub(crate) fn count_in(&self, frame: &[u8]) -> Option<u64> {
        let counter = self.counter.as_ref()?;
        let stored = frame.get(counter.at..counter.at + counter.bytes)?;
        Some(read(stored, counter.big_endian, self.digit_bits()))
    }

    fn begins(&self, bytes: &[u8]) -> bool {
        bytes.starts_with(&self.sync)
    }

    /// Starts of the frames in `bytes`, ascending, none overlapping. Without a check, a frame
    /// counts when another one borders on it.
    #[must_use]
    pub fn scan(&self, bytes: &[u8]) -> Vec<usize> {
        let (mut starts, mut at) = (Vec::new(), 0);
        while at + self.len <= bytes.len() {
            if self.is_frame(bytes, at, starts.last().copied()) {
                starts.push(at);
                at += self.len;
            } else {
                at += 1;
            }
        }
        starts
    }

    fn is_frame(&self, bytes: &[u8], at: usize, last: Option<usize>) -> bool {
        if !self.begins(&bytes[at..]) {
            return false;
        }
        let frame = &bytes[at..at + self.len];
        match &self.check {
            Some(check) => check.holds(frame),
            None => {
                let next = &bytes[at + self.len..];
                self.begins(next) || last.is_some_and(|last| last + self.len == at)
            }
        }
    }
}

/// The number in `digits` of 7 or 8 bits.
pub(crate) fn read(digits: &[u8], big_endian: bool, digit_bits: u32) -> u64 {
    let push = |value: u64, digit: &u8| (value << digit_bits) | u64::from(*digit);
    if big_endian { digits.iter().fold(0, push) } else { digits.iter().rev().fold(0, push) }
}
