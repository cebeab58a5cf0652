//! One number of a frame: where it lies, how it is coded, and what it means.

use std::f64::consts::PI;

/// How a field's bits make a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Coding {
    /// Two's complement.
    Twos,
    /// Plain binary, never negative.
    Unsigned,
    /// Plain binary around `null`: the raw value is the code minus `null`.
    OffsetBinary {
        /// The code that means zero.
        null: u32,
    },
}

/// Order of the bytes on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Endian {
    /// Most significant byte first.
    Big,
    /// Least significant byte first.
    Little,
}

/// The unit in which a frame file states a field's scale, offset and clip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unit {
    /// Angular rate in SI.
    RadPerS,
    /// Angular rate as data sheets give it; becomes rad/s.
    DegPerS,
    /// Temperature in °C. It stays °C: data sheets speak it and no physics is computed from it.
    DegC,
    /// A bare number.
    Counts,
}

impl Unit {
    /// What one of these is in SI.
    const fn in_si(self) -> f64 {
        match self {
            Self::DegPerS => PI / 180.0,
            Self::RadPerS | Self::DegC | Self::Counts => 1.0,
        }
    }
}

/// One field: its place in the frame, its coding, and its scale to SI.
///
/// The value is `raw · scale + offset` in the file's unit. This is the only place in the chain
/// where counts and physical units meet.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldSpec {
    pub(crate) name: String,
    pub(crate) at: usize,
    pub(crate) bytes: usize,
    pub(crate) endian: Endian,
    pub(crate) coding: Coding,
    pub(crate) unit: Unit,
    pub(crate) scale: f64,
    pub(crate) offset: f64,
    pub(crate) clip: Option<[f64; 2]>,
}

impl FieldSpec {
    /// Its name in the frame file.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

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

    /// Byte order.
    #[must_use]
    pub const fn endian(&self) -> Endian {
        self.endian
    }

    /// Coding.
    #[must_use]
    pub const fn coding(&self) -> Coding {
        self.coding
    }

    /// The unit of the frame file. [`Self::to_si`] has left it behind already.
    #[must_use]
    pub const fn unit(&self) -> Unit {
        self.unit
    }

    /// SI units per raw count: rad/s for rates, °C for temperatures. Never zero; may be negative.
    #[must_use]
    pub const fn scale_si(&self) -> f64 {
        self.scale * self.unit.in_si()
    }

    /// The SI value of raw zero.
    #[must_use]
    pub const fn offset_si(&self) -> f64 {
        self.offset * self.unit.in_si()
    }

    /// The declared measuring range in SI, `[least, greatest]`, when the file declares one.
    #[must_use]
    pub fn clip_si(&self) -> Option<[f64; 2]> {
        self.clip.map(|bounds| bounds.map(|bound| bound * self.unit.in_si()))
    }

    /// Least raw value that the bits can hold.
    #[must_use]
    pub fn raw_min(&self) -> i64 {
        match self.coding {
            Coding::Twos => -(1 << (self.bits() - 1)),
            Coding::Unsigned => 0,
            Coding::OffsetBinary { null } => -i64::from(null),
        }
    }

    /// Greatest raw value that the bits can hold.
    #[must_use]
    pub fn raw_max(&self) -> i64 {
        self.raw_min() + ((1 << self.bits()) - 1)
    }

    /// The physical value of `raw`, in SI. Not clipped: what was measured is reported.
    #[must_use]
    pub fn to_si(&self, raw: i64) -> f64 {
        raw as f64 * self.scale_si() + self.offset_si()
    }

    /// The raw value nearest to `value_si`, saturating first at the clip range and then at the
    /// ends of the code, as a converter does. NaN gives the code's value nearest to raw zero.
    #[must_use]
    pub fn from_si(&self, value_si: f64) -> i64 {
        let clipped = match self.clip_si() {
            Some([least, greatest]) => value_si.clamp(least, greatest),
            None => value_si,
        };
        let exact = ((clipped - self.offset_si()) / self.scale_si()).round();
        #[expect(clippy::cast_possible_truncation, reason = "a float-to-int cast saturates")]
        let raw = exact as i64;
        raw.clamp(self.raw_min(), self.raw_max())
    }

    /// Reads the raw value out of a whole frame.
    #[inline]
    pub(crate) fn read(&self, frame: &[u8]) -> i64 {
        let code = read_code(&frame[self.at..self.at + self.bytes], self.endian);
        match self.coding {
            Coding::Twos => {
                let unused_bits = 64 - self.bits();
                (code << unused_bits).cast_signed() >> unused_bits
            }
            Coding::Unsigned => code.cast_signed(),
            Coding::OffsetBinary { null } => code.cast_signed() - i64::from(null),
        }
    }

    /// Writes a raw value, already checked against the range, into a whole frame.
    pub(crate) fn write(&self, raw: i64, frame: &mut [u8]) {
        let code = match self.coding {
            Coding::Twos | Coding::Unsigned => raw,
            Coding::OffsetBinary { null } => raw + i64::from(null),
        };
        let bytes = &mut frame[self.at..self.at + self.bytes];
        write_code(code.cast_unsigned(), self.endian, bytes);
    }
}

/// The number in `bytes`, at most eight of them.
#[inline]
pub(crate) fn read_code(bytes: &[u8], endian: Endian) -> u64 {
    let append = |code: u64, byte: &u8| code << 8 | u64::from(*byte);
    match endian {
        Endian::Big => bytes.iter().fold(0, append),
        Endian::Little => bytes.iter().rev().fold(0, append),
    }
}

/// Fills `bytes`, at most eight of them, with the low bits of `code`.
pub(crate) fn write_code(code: u64, endian: Endian, bytes: &mut [u8]) {
    let width = bytes.len();
    match endian {
        Endian::Big => bytes.copy_from_slice(&code.to_be_bytes()[8 - width..]),
        Endian::Little => bytes.copy_from_slice(&code.to_le_bytes()[..width]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn rate(bits: usize, coding: Coding) -> FieldSpec {
        FieldSpec {
            name: "rate".to_owned(),
            at: 1,
            bytes: bits / 8,
            endian: Endian::Big,
            coding,
            unit: Unit::DegPerS,
            scale: 1.0 / 32768.0,
            offset: 0.0,
            clip: Some([-200.0, 200.0]),
        }
    }

    #[test]
    fn a_degree_per_second_becomes_radians_per_second() {
        let field = rate(24, Coding::Twos);
        // One rounding of the scale and one of the product.
        assert!((field.to_si(32768) - PI / 180.0).abs() < 1e-17);
        assert_eq!(field.from_si(PI / 180.0), 32768);
        assert_eq!(field.from_si(-PI / 180.0), -32768);
    }

    #[test]
    fn a_value_off_the_scale_saturates_at_clip_and_then_at_the_code() {
        let clipped = rate(24, Coding::Twos);
        assert_eq!(clipped.from_si(1e9), 6_553_600);
        assert_eq!(clipped.from_si(f64::NEG_INFINITY), -6_553_600);
        let open = FieldSpec { clip: None, ..rate(24, Coding::Twos) };
        assert_eq!(open.from_si(1e300), 8_388_607);
        assert_eq!(open.from_si(f64::NEG_INFINITY), -8_388_608);
        assert_eq!((open.from_si(f64::NAN), clipped.from_si(f64::NAN)), (0, 0));
        let null = FieldSpec { clip: None, ..rate(16, Coding::OffsetBinary { null: 2048 }) };
        assert_eq!((null.raw_min(), null.raw_max()), (-2048, 65_535 - 2048));
    }

    fn coding() -> impl Strategy<Value = Coding> {
        prop_oneof![
            Just(Coding::Twos),
            Just(Coding::Unsigned),
            (0_u32..=255).prop_map(|null| Coding::OffsetBinary { null })
        ]
    }

    proptest! {
        #[test]
        fn a_raw_value_survives_the_wire_and_si(
            bytes in 1_usize..=4,
            coding in coding(),
            little in any::<bool>(),
            (share, offset) in (0.0..=1.0_f64, -100.0..100.0_f64),
        ) {
            let endian = if little { Endian::Little } else { Endian::Big };
            let field = FieldSpec { endian, offset, clip: None, ..rate(bytes * 8, coding) };
            let span = field.raw_max() - field.raw_min();
            #[expect(clippy::cast_possible_truncation, reason = "a share of a 32-bit span")]
            let raw = field.raw_min() + (share * span as f64) as i64;
            let mut frame = [0xAA; 6];
            field.write(raw, &mut frame);
            prop_assert_eq!(field.read(&frame), raw);
            prop_assert_eq!((frame[0], frame[5]), (0xAA, 0xAA));
            prop_assert_eq!(field.from_si(field.to_si(raw)), raw);
        }
    }
}
