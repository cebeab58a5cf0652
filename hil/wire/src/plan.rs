//! Layouts of short frames, worked out ahead: a frame is one word, and everything in it a shift
//! and a mask.
//!
//! What a layout says is known at run time only, and asking it anew for every field of every frame
//! costs far more than the frame's own arithmetic. A [`Plan`] holds the answers. Frames that are
//! too long, or framed or checked in another way, go without: [`crate::Encoder`] and
//! [`crate::Decoder`] then ask the layout, as they also do for every frame that is not exactly the
//! one expected. Both ways give the same frames, counters and bytes.

mod carried;
mod check;
mod word;

use crate::field::{Endian, FieldSpec};
use crate::framing::Framing;
use crate::place::Place;
use crate::{FlagSpec, Frame, FrameSpec, MAX_FIELDS, SequenceSpec};
use carried::{Carried, Deciding};
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

/// A layout with a sync word, at most sixteen bytes, no check but a CRC or an exclusive or, and at
/// most one field that decides which others there are.
#[derive(Debug, Clone)]
pub(crate) struct Plan<W> {
    len: usize,
    field_count: usize,
    /// The sync word, and the bits that are known beforehand: its own and the counter's.
    sync: W,
    known: W,
    counter: Counter,
    deciding: Deciding<W>,
    flags: Box<[Flags]>,
    /// Fields and the flags that vouch for them.
    vouched: Box<[(usize, usize)]>,
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

/// The frame counter. Without one it has the modulus 1 and is always zero.
#[derive(Debug, Clone, Copy)]
struct Counter {
    run: Run,
    modulus: u64,
}

/// Flags one after the other that are bits of a field, one after the other.
#[derive(Debug, Clone, Copy)]
struct Flags {
    field: usize,
    /// The lowest of the bits, and a mask over all of them when it is lowest.
    bit: u32,
    mask: u64,
    /// Index of the lowest flag.
    flag: u32,
}

/// A frame as a number, its first byte lowest and highest.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Words<W> {
    little: W,
    big: W,
}

/// A frame to read others into, and what the last one carried.
#[derive(Debug)]
pub(crate) struct Slate<'a, W> {
    pub(crate) frame: Frame,
    code: u64,
    carried: &'a Carried<W>,
}

impl Run {
    const NONE: Self = Self { big: false, shift: 0, mask: 0 };

    /// Whether the order of its bytes calls for the word whose highest byte is the frame's first.
    fn is_big(place: &Place) -> bool {
        place.endian == Endian::Big && place.bytes > 1
    }

    /// `byte_big` is the word for a single byte, which may be in either.
    fn of<W: Word>(place: &Place, byte_big: bool) -> Option<Self> {
        let big = Self::is_big(place) || (byte_big && place.bytes == 1);
        let below = if big { W::LEN.checked_sub(place.at + place.bytes)? } else { place.at };
        let shift = u32::try_from(8 * below).ok()? + place.shift;
        (place.byte_bits == 8).then_some(Self { big, shift, mask: place.mask() })
    }

    #[inline(always)]
    fn read<W: Word>(&self, little: W, big: W) -> u64 {
        let word = if self.big { big } else { little };
        word.low_from(self.shift) & self.mask
    }

    /// The word, first byte lowest, that has `code`, which fits, here and zeros elsewhere.
    #[inline(always)]
    fn word_of<W: Word>(&self, code: u64) -> W {
        let word = W::with_low(code, self.shift);
        if self.big { word.swapped() } else { word }
    }
}

impl Counter {
    fn of<W: Word>(spec: Option<&SequenceSpec>) -> Option<Self> {
        match spec {
            Some(SequenceSpec { place, modulus }) => {
                Some(Self { run: Run::of::<W>(place, false)?, modulus: *modulus })
            }
            None => Some(Self { run: Run::NONE, modulus: 1 }),
        }
    }
}

impl Flags {
    fn of(specs: &[FlagSpec]) -> Box<[Self]> {
        let mut all: Vec<Self> = Vec::new();
        for (flag, spec) in (0..).zip(specs) {
            match all.last_mut() {
                Some(last) if last.field == spec.field && last.bit + flag == spec.bit + last.flag => {
                    last.mask = 2 * last.mask + 1;
                }
                _ => all.push(Self { field: spec.field, bit: spec.bit, mask: 1, flag }),
            }
        }
        all.into_boxed_slice()
    }

    #[inline(always)]
    fn read(&self, raw: &[i64; MAX_FIELDS]) -> u64 {
        let bits = raw[self.field % MAX_FIELDS].cast_unsigned() >> (self.bit % u64::BITS);
        (bits & self.mask) << (self.flag % u64::BITS)
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
        let counter = Counter::of::<W>(spec.sequence.as_ref())?;
        let vouched = |(k, field): (usize, &FieldSpec)| Some((k, field.valid_if?));
        Some(Self {
            len: spec.len,
            field_count: spec.fields.len(),
            sync: W::of_little(&spec.sync),
            known: W::of_little(mask) | counter.run.word_of(counter.run.mask),
            counter,
            deciding: Deciding::of(&spec.fields)?,
            flags: Flags::of(&spec.flags),
            vouched: spec.fields.iter().enumerate().filter_map(vouched).collect(),
            check: Check::of(&spec.check)?,
        })
    }

    /// Bytes of a frame.
    pub(crate) const fn len(&self) -> usize {
        self.len
    }

    /// The counter behind `counter`.
    #[inline(always)]
    pub(crate) const fn counter_after(&self, counter: u64) -> u64 {
        if counter + 1 < self.counter.modulus { counter + 1 } else { 0 }
    }

    /// The frame that `front` begins with, if its sync word and its check are right and its
    /// counter, if it has one, is `counter`.
    #[inline(always)]
    pub(crate) fn cut(&self, front: &[u8; WORD_LEN], counter: u64) -> Option<Words<W>> {
        let little = W::little(front);
        let expected = self.sync | self.counter.run.word_of(counter);
        if (little ^ expected) & self.known != W::default() {
            return None;
        }
        let checked = self.check.as_ref().is_none_or(|check| check.holds(little));
        checked.then(|| Words { little, big: little.swapped() })
    }

    /// A place for the frames of a row, of which the first is the one behind index `last_index`.
    pub(crate) fn slate(&self, spec: &FrameSpec, last_index: u64) -> Slate<'_, W> {
        let mut frame = Frame::blank(spec);
        frame.index = last_index;
        Slate { frame, code: 0, carried: self.deciding.carried(0) }
    }

    /// Reads the fields into the frame of `slate`, which was made by this plan, and counts it.
    #[inline(always)]
    pub(crate) fn read<'a>(&'a self, Words { little, big }: Words<W>, slate: &mut Slate<'a, W>) {
        let frame = &mut slate.frame;
        let code = self.deciding.code_in(little, big);
        if code != slate.code {
            (slate.code, slate.carried) = (code, self.deciding.carried(code));
            frame.raw = [0; MAX_FIELDS];
        }
        slate.carried.read(little, big, &mut frame.raw);
        let flags = self.flags.iter().fold(0, |all, flags| all | flags.read(&frame.raw));
        let mut has = slate.carried.has(&frame.raw);
        for (field, flag) in &self.vouched {
            has &= !((!flags >> flag & 1) << field);
        }
        (frame.has, frame.flags) = (has, flags);
        frame.index += 1;
    }

    /// Appends the frame of these raw values and this counter to `out`; tells whether it did.
    /// Values that do not fit the layout are for the caller to find.
    #[inline(always)]
    pub(crate) fn emit(&self, raw: &[i64], counter: u64, out: &mut Vec<u8>) -> bool {
        let Some(word) = self.word_of(raw, counter) else { return false };
        word.append(self.len, out);
        true
    }

    #[inline(always)]
    fn word_of(&self, raw: &[i64], counter: u64) -> Option<W> {
        if raw.len() != self.field_count {
            return None;
        }
        let code = raw.get(self.deciding.field).map_or(0, |raw| self.deciding.code_for(*raw));
        let fields = self.deciding.carried(code).word_of(raw)?;
        let word = fields ^ self.sync ^ self.counter.run.word_of(counter);
        Some(self.check.as_ref().map_or(word, |check| check.completed(word)))
    }
}

#[cfg(test)]
mod tests;
