//! Layouts of short frames, worked out ahead: a frame is one word, and everything in it a shift
//! and a mask.
//!
//! What a layout says is known at run time only, and asking it anew for every field of every frame
//! costs far more than the frame's own arithmetic. A [`Plan`] holds the answers. Frames that are
//! too long, or framed or checked in another way, go without: [`crate::Encoder`] and
//! [`crate::Decoder`] then ask the layout, as they also do for every frame that is not exactly the
//! one expected. Both ways give the same frames, counters and bytes.

mod check;
mod word;

use crate::field::{Coding, Endian, FieldSpec};
use crate::framing::Framing;
use crate::place::Place;
use crate::{Frame, FrameSpec, MAX_FIELDS, SequenceSpec};
use check::Check;
pub(crate) use word::{WORD_LEN, Word};

/// The plan of a layout, in the smaller word that holds its frames.
#[derive(Debug, Clone)]
pub(crate) enum AnyPlan {
    Short(Plan<u64>),
    Long(Plan<u128>),
}

impl AnyPlan {
    /// The plan of a layout, if it is of a kind that can be planned.
    pub(crate) fn of(spec: &FrameSpec) -> Option<Self> {
        if spec.len <= u64::LEN {
            return Plan::of(spec).map(Self::Short);
        }
        Plan::of(spec).map(Self::Long)
    }
}

/// A layout with a sync word, at most sixteen bytes, and no check but a CRC or an exclusive or.
#[derive(Debug, Clone)]
pub(crate) struct Plan<W> {
    len: usize,
    /// The sync word and the bits that count.
    sync: W,
    sync_mask: W,
    fields: Box<[Field]>,
    flags: Box<[Flag]>,
    /// Fields and the flags that vouch for them.
    vouched: Box<[(usize, usize)]>,
    sequence: Option<(Run, u64)>,
    check: Option<Check>,
}

/// Consecutive bits of one of the two words of a frame.
#[derive(Debug, Clone, Copy)]
struct Run {
    /// In the word whose highest byte is the frame's first, not in that whose lowest is.
    big: bool,
    shift: u32,
    mask: u64,
}

/// A field: its raw value is the code with the bits of `flip` turned, less `bias`. That is all
/// that tells two's complement, plain and offset binary apart.
#[derive(Debug, Clone, Copy)]
struct Field {
    run: Run,
    flip: u64,
    bias: u64,
    /// Only frames in which the raw value of field `decider` equals this carry it, in the bits of
    /// `care`: all of them, or none when every frame does.
    decider: usize,
    equals: i64,
    care: i64,
    /// It is a number unless these bits of it are that.
    exponent: u64,
    endless: u64,
}

#[derive(Debug, Clone, Copy)]
struct Flag {
    field: usize,
    bit: u32,
}

/// A frame as a number, its first byte lowest and highest.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Words<W> {
    little: W,
    big: W,
}

impl Run {
    fn of<W: Word>(place: &Place) -> Option<Self> {
        let big = place.endian == Endian::Big && place.bytes > 1;
        let below = if big { W::LEN.checked_sub(place.at + place.bytes)? } else { place.at };
        let shift = u32::try_from(8 * below).ok()? + place.shift;
        (place.byte_bits == 8).then_some(Self { big, shift, mask: place.mask() })
    }

    #[inline(always)]
    fn read<W: Word>(&self, words: Words<W>) -> u64 {
        let word = if self.big { words.big } else { words.little };
        word.low_from(self.shift) & self.mask
    }

    /// Puts `code`, which fits, where no other bit is set.
    #[inline(always)]
    fn put<W: Word>(&self, code: u64, words: &mut Words<W>) {
        let bits = W::with_low(code, self.shift);
        if self.big {
            words.big = words.big | bits;
        } else {
            words.little = words.little | bits;
        }
    }
}

impl Field {
    fn of<W: Word>(field: &FieldSpec) -> Option<Self> {
        let top = 1 << (field.place.bits - 1);
        let (flip, bias) = match field.coding {
            Coding::Twos => (top, top),
            Coding::Unsigned | Coding::Float => (0, 0),
            Coding::OffsetBinary { null } => (0, u64::from(null)),
            Coding::Decimal { .. } | Coding::Hex { .. } => return None,
        };
        let (exponent, endless) = match field.coding {
            Coding::Float => (0x7F80_0000, 0x7F80_0000),
            _ => (0, 1),
        };
        let (decider, equals, care) = match field.when {
            Some(when) => (when.field, when.equals, -1),
            None => (0, 0, 0),
        };
        let run = Run::of::<W>(&field.place)?;
        Some(Self { run, flip, bias, decider, equals, care, exponent, endless })
    }

    #[inline(always)]
    fn is_carried(&self, decider_raw: i64) -> bool {
        (decider_raw ^ self.equals) & self.care == 0
    }
}

impl<W: Word> Plan<W> {
    fn of(spec: &FrameSpec) -> Option<Self> {
        let Framing::Fixed { mask } = &spec.framing else { return None };
        if spec.len > W::LEN {
            return None;
        }
        let all = vec![0xFF; spec.sync.len()];
        let mask = if mask.is_empty() { &all } else { mask };
        let sequence = match &spec.sequence {
            Some(SequenceSpec { place, modulus }) => Some((Run::of::<W>(place)?, *modulus)),
            None => None,
        };
        let flag = |flag: &crate::FlagSpec| Flag { field: flag.field, bit: flag.bit };
        let vouched = |(k, field): (usize, &FieldSpec)| Some((k, field.valid_if?));
        Some(Self {
            len: spec.len,
            sync: W::of_little(&spec.sync),
            sync_mask: W::of_little(mask),
            fields: spec.fields.iter().map(Field::of::<W>).collect::<Option<_>>()?,
            flags: spec.flags.iter().map(flag).collect(),
            vouched: spec.fields.iter().enumerate().filter_map(vouched).collect(),
            sequence,
            check: Check::of::<W>(&spec.check)?,
        })
    }

    /// Bytes of a frame.
    pub(crate) const fn len(&self) -> usize {
        self.len
    }

    /// The counter behind `counter`.
    #[inline(always)]
    pub(crate) fn counter_after(&self, counter: u64) -> u64 {
        match self.sequence {
            Some((_, modulus)) if counter + 1 < modulus => counter + 1,
            _ => 0,
        }
    }

    /// The frame that `front` begins with, if its sync word and its check are right and its
    /// counter, if it has one, is `counter`.
    #[inline(always)]
    pub(crate) fn cut(&self, front: &[u8; WORD_LEN], counter: u64) -> Option<Words<W>> {
        let (little, big) = W::both(front);
        let words = Words { little, big };
        let counted = self.sequence.as_ref().is_none_or(|(run, _)| run.read(words) == counter);
        let synced = (words.little ^ self.sync) & self.sync_mask == W::default();
        let checked = self.check.as_ref().is_none_or(|check| check.holds(words));
        (counted & synced & checked).then_some(words)
    }

    /// Reads the fields into `frame`, all of which but its index is from a frame of this layout.
    #[inline(always)]
    pub(crate) fn read(&self, words: Words<W>, frame: &mut Frame) {
        let mut has = 0;
        for (k, field) in self.fields.iter().enumerate() {
            // The deciding field stands earlier in the file.
            if !field.is_carried(frame.raw[field.decider % MAX_FIELDS]) {
                frame.raw[k % MAX_FIELDS] = 0;
                continue;
            }
            let raw = (field.run.read(words) ^ field.flip).wrapping_sub(field.bias);
            frame.raw[k % MAX_FIELDS] = raw.cast_signed();
            has |= u64::from(raw & field.exponent != field.endless) << k;
        }
        let mut flags = 0;
        for (k, flag) in self.flags.iter().enumerate() {
            flags |= (frame.raw[flag.field % MAX_FIELDS].cast_unsigned() >> flag.bit & 1) << k;
        }
        for (field, flag) in &self.vouched {
            has &= !((!flags >> flag & 1) << field);
        }
        (frame.has, frame.flags) = (has, flags);
    }

    /// Appends the frame of these raw values and this counter to `out`; tells whether it did.
    /// Values that do not fit the layout are for the caller to find.
    #[inline(always)]
    pub(crate) fn emit(&self, raw: &[i64], counter: u64, out: &mut Vec<u8>) -> bool {
        let Some(words) = self.pack(raw, counter) else { return false };
        let end = out.len() + self.len;
        // A length that is known makes it one store; what is too much goes again.
        out.extend_from_slice(&W::bytes(words.little, words.big));
        out.truncate(end);
        true
    }

    #[inline(always)]
    fn pack(&self, raw: &[i64], counter: u64) -> Option<Words<W>> {
        if raw.len() != self.fields.len() {
            return None;
        }
        let mut words = Words { little: self.sync, big: W::default() };
        for (field, value) in self.fields.iter().zip(raw) {
            if field.is_carried(raw[field.decider]) {
                // The least value that fits becomes zero and the greatest the mask.
                let code = value.cast_unsigned().wrapping_add(field.bias);
                if code > field.run.mask {
                    return None;
                }
                field.run.put(code ^ field.flip, &mut words);
            }
        }
        if let Some((run, _)) = &self.sequence {
            run.put(counter, &mut words);
        }
        if let Some(check) = &self.check {
            check.put(&mut words);
        }
        Some(words)
    }
}

#[cfg(test)]
mod tests;
