//! One number of a frame: where it lies, how it is coded, and what it means.

use crate::place::Place;
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
    /// IEEE 754 binary32; the raw value is the bit pattern.
    Float,
    /// Decimal text; the raw value is its digits with the point left out.
    Decimal {
        /// Digits before the point, at most.
        digits: u32,
        /// Digits after the point, exactly.
        decimals: u32,
    },
    /// Hexadecimal text, never negative.
    Hex {
        /// Digits, exactly.
        digits: u32,
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
    /// Angle turned since the last sample, in SI.
    Rad,
    /// Angle turned since the last sample; becomes rad.
    Deg,
    /// Temperature in °C. It stays °C: data sheets speak it and no physics is computed from it.
    DegC,
    /// Voltage.
    Volt,
    /// A bare number.
    Counts,
    /// Time.
    Second,
}

impl Unit {
    /// What one of these is in SI.
    #[inline]
    const fn in_si(self) -> f64 {
        match self {
            Self::DegPerS | Self::Deg => PI / 180.0,
            Self::RadPerS | Self::Rad | Self::DegC | Self::Volt | Self::Counts | Self::Second => {
                1.0
            }
        }
    }

    /// Its name in frame files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::RadPerS => "rad/s",
            Self::DegPerS => "deg/s",
            Self::Rad => "rad",
            Self::Deg => "deg",
            Self::DegC => "degC",
            Self::Volt => "V",
            Self::Counts => "counts",
            Self::Second => "s",
        }
    }

    /// Ending of a column or variable that holds what [`FieldSpec::to_si`] gives; none for a bare
    /// number.
    #[must_use]
    pub const fn si_suffix(self) -> &'static str {
        match self {
            Self::RadPerS | Self::DegPerS => "_rad_s",
            Self::Rad | Self::Deg => "_rad",
            Self::DegC => "_deg_c",
            Self::Volt => "_v",
            Self::Counts => "",
            Self::Second => "_s",
        }
    }
}

/// A field that only some frames carry: those in which another field has a certain raw value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct When {
    /// Index of the deciding field, which is unsigned and in every frame.
    pub(crate) field: usize,
    pub(crate) equals: i64,
}

impl When {
    /// Whether both can hold in one frame.
    pub(crate) const fn meets(&self, other: &Self) -> bool {
        self.field != other.field || self.equals == other.equals
    }
}

/// One field: its place in the frame, its coding, and its scale to SI.
///
/// The value is `raw · scale + offset` in the file's unit, where raw stands for the number itself
/// when the coding is a float. This is the only place in the chain where counts and physical units
/// meet.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldSpec {
    pub(crate) name: String,
    pub(crate) place: Place,
    pub(crate) coding: Coding,
    pub(crate) unit: Unit,
    pub(crate) scale: f64,
    pub(crate) offset: f64,
    pub(crate) clip: Option<[f64; 2]>,
    pub(crate) when: Option<When>,
    /// Index of the flag without which the value means nothing.
    pub(crate) valid_if: Option<usize>,
}

impl FieldSpec {
    /// Its name in the frame file.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

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

    /// Byte order.
    #[must_use]
    pub const fn endian(&self) -> Endian {
        self.place.endian
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

    /// The field and the raw value of it with which frames carry this one; `None` for a field of
    /// every frame.
    #[must_use]
    pub fn when(&self) -> Option<(usize, i64)> {
        self.when.map(|when| (when.field, when.equals))
    }

    /// Index of the flag that must be set for the value to be usable.
    #[must_use]
    pub const fn valid_if(&self) -> Option<usize> {
        self.valid_if
    }

    /// Units of the file per raw count.
    #[must_use]
    pub const fn scale(&self) -> f64 {
        self.scale
    }

    /// Least and greatest value that the code can say, in the unit of the file; `None` for floats,
    /// which can say anything.
    #[must_use]
    pub fn code_range(&self) -> Option<[f64; 2]> {
        if self.coding == Coding::Float {
            return None;
        }
        let ends =
            [self.raw_min(), self.raw_max()].map(|raw| raw as f64 * self.scale + self.offset);
        Some([ends[0].min(ends[1]), ends[0].max(ends[1])])
    }

    /// SI units per raw count: rad/s for rates, °C for temperatures. Never zero; may be negative.
    #[must_use]
    #[inline]
    pub const fn scale_si(&self) -> f64 {
        self.scale * self.unit.in_si()
    }

    /// The SI value of raw zero.
    #[must_use]
    #[inline]
    pub const fn offset_si(&self) -> f64 {
        self.offset * self.unit.in_si()
    }

    /// The declared measuring range in SI, `[least, greatest]`, when the file declares one.
    #[must_use]
    pub fn clip_si(&self) -> Option<[f64; 2]> {
        self.clip.map(|bounds| bounds.map(|bound| bound * self.unit.in_si()))
    }

    /// Least raw value that the coding can hold.
    #[must_use]
    pub fn raw_min(&self) -> i64 {
        match self.coding {
            Coding::Twos => -(1 << (self.bits() - 1)),
            Coding::Unsigned | Coding::Float | Coding::Hex { .. } => 0,
            Coding::OffsetBinary { null } => -i64::from(null),
            Coding::Decimal { .. } => -self.raw_max(),
        }
    }

    /// Greatest raw value that the coding can hold.
    #[must_use]
    pub fn raw_max(&self) -> i64 {
        match self.coding {
            Coding::Twos | Coding::Unsigned | Coding::Float | Coding::OffsetBinary { .. } => {
                self.raw_min() + self.place.mask().cast_signed()
            }
            Coding::Decimal { digits, decimals } => 10_i64.pow(digits + decimals) - 1,
            Coding::Hex { digits } => (1 << (4 * digits)) - 1,
        }
    }

    /// The physical value of `raw`, in SI. Not clipped: what was measured is reported.
    #[must_use]
    #[inline]
    pub fn to_si(&self, raw: i64) -> f64 {
        self.number(raw) * self.scale_si() + self.offset_si()
    }

    /// The number that `raw` stands for, before scaling.
    #[inline]
    fn number(&self, raw: i64) -> f64 {
        match self.coding {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a pattern"
            )]
            Coding::Float => f64::from(f32::from_bits(raw as u32)),
            _ => raw as f64,
        }
    }

    /// Whether `raw` is a number at all; only floats may not be.
    #[inline]
    pub(crate) fn is_number(&self, raw: i64) -> bool {
        !matches!(self.coding, Coding::Float) || self.number(raw).is_finite()
    }

    /// The raw value nearest to `value_si`, saturating first at the clip range and then at the
    /// ends of the code, as a converter does. NaN gives the code's value nearest to raw zero.
    #[must_use]
    pub fn from_si(&self, value_si: f64) -> i64 {
        let clipped = match self.clip_si() {
            Some([least, greatest]) => value_si.clamp(least, greatest),
            None => value_si,
        };
        let exact = (clipped - self.offset_si()) / self.scale_si();
        if self.coding == Coding::Float {
            let number = if exact.is_nan() { 0.0 } else { exact };
            let limit = f64::from(f32::MAX);
            #[expect(clippy::cast_possible_truncation, reason = "rounds to the nearest float")]
            let float = number.clamp(-limit, limit) as f32;
            return i64::from(float.to_bits());
        }
        #[expect(clippy::cast_possible_truncation, reason = "a float-to-int cast saturates")]
        let raw = exact.round() as i64;
        raw.clamp(self.raw_min(), self.raw_max())
    }

    /// Reads the raw value out of a whole frame.
    #[inline]
    pub(crate) fn read(&self, frame: &[u8]) -> i64 {
        let code = self.place.read(frame);
        match self.coding {
            Coding::Twos => {
                let unused_bits = 64 - self.bits();
                (code << unused_bits).cast_signed() >> unused_bits
            }
            Coding::OffsetBinary { null } => code.cast_signed() - i64::from(null),
            _ => code.cast_signed(),
        }
    }

    /// Writes a raw value, already checked against the range, into a whole frame.
    pub(crate) fn write(&self, raw: i64, frame: &mut [u8]) {
        let code = match self.coding {
            Coding::OffsetBinary { null } => raw + i64::from(null),
            _ => raw,
        };
        self.place.write(code.cast_unsigned(), frame);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn rate(bits: usize, coding: Coding) -> FieldSpec {
        FieldSpec {
            name: "rate".to_owned(),
            place: Place::whole(1, bits / 8, Endian::Big),
            coding,
            unit: Unit::DegPerS,
            scale: 1.0 / 32768.0,
            offset: 0.0,
            clip: Some([-200.0, 200.0]),
            when: None,
            valid_if: None,
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

    #[test]
    fn a_float_keeps_its_bits_and_what_is_no_number_says_so() {
        let field = FieldSpec { scale: 1.0, clip: None, ..rate(32, Coding::Float) };
        for value in [0.0_f32, -1.5, 3.25e-7, f32::MAX, f32::MIN_POSITIVE / 4.0] {
            let raw = i64::from(value.to_bits());
            assert!((field.raw_min()..=field.raw_max()).contains(&raw));
            let back = field.to_si(raw) * (180.0 / PI);
            // Two roundings on the way to radians and back.
            assert!((back - f64::from(value)).abs() <= f64::from(value).abs() * 1e-15);
            assert_eq!(field.from_si(field.to_si(raw)), raw);
            assert!(field.is_number(raw));
        }
        assert!(!field.is_number(i64::from(f32::NAN.to_bits())));
        assert!(!field.is_number(i64::from(f32::INFINITY.to_bits())));
        assert_eq!(field.from_si(f64::NAN), 0);
        assert_eq!(field.from_si(f64::INFINITY), i64::from(f32::MAX.to_bits()));
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
            let place = Place::whole(1, bytes, endian);
            let field = FieldSpec { place, offset, clip: None, ..rate(bytes * 8, coding) };
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
