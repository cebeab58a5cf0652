//! Layouts of short frames, worked out ahead: a frame is one word, and everything in it a shift
//! and a mask.
//!
//! What a layout says is known at run time only, and asking it anew for every field of every frame
//! costs far more than the frame's own arithmetic. A [`Plan`] holds the answers for frames that
//! come, and an [`AnySendPlan`] for those that go. Frames that are too long, or framed or checked
//! in another way, go without: [`crate::Encoder`] and [`crate::Decoder`] then ask the layout, as
//! they also do for every frame that is not exactly the one expected. Both ways give the same
//! frames, counters and bytes.

mod carried;
mod check;
mod linear;
mod send;
mod word;

use crate::field::{Endian, FieldSpec};
use crate::framing::Framing;
use crate::place::Place;
use crate::{FlagSpec, Frame, FrameSpec, MAX_FIELDS, MAX_SYNC_LEN, SequenceSpec};
use carried::{Carried, Deciding};
use check::Check;
pub(crate) use send::AnySendPlan;
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
    /// Frames are taken as words whose highest byte is the first, not the lowest.
    big: bool,
    /// The sync word, and the bits that are known beforehand: its own and the counter's.
    sync: W,
    known: W,
    counter: Counter<W>,
    deciding: Deciding<W>,
    flags: Box<[Flags]>,
    /// Fields and the flags that vouch for them.
    vouched: Box<[(usize, usize)]>,
    check: Option<Check>,
}

/// Consecutive bits of a frame's word.
#[derive(Debug, Clone, Copy)]
struct Run<W> {
    /// The lowest of them, as a number and alone.
    shift: u32,
    unit: W,
    mask: u64,
}

/// The frame counter. Without one it has the modulus 1 and is always zero.
#[derive(Debug, Clone, Copy)]
struct Counter<W> {
    run: Run<W>,
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

/// A frame to read others into, and what the last one carried.
#[derive(Debug)]
pub(crate) struct Slate<'a, W> {
    pub(crate) frame: Frame,
    code: u64,
    carried: &'a Carried<W>,
}

/// Order of some bytes; `None` for a single one, which has any.
fn is_big(place: &Place) -> Option<bool> {
    (place.bytes > 1).then_some(place.endian == Endian::Big)
}

/// Lowest bit of `bytes` bytes from `at` on.
fn shift_of<W: Word>(at: usize, bytes: usize, big: bool) -> Option<u32> {
    let below = if big { W::LEN.checked_sub(at + bytes)? } else { at };
    u32::try_from(8 * below).ok()
}

impl<W: Word> Run<W> {
    fn none() -> Self {
        Self { shift: 0, unit: W::default(), mask: 0 }
    }

    /// `None` if the bytes are the other way round than the word's.
    fn of(place: &Place, big: bool) -> Option<Self> {
        let shift = shift_of::<W>(place.at, place.bytes, big)? + place.shift;
        let is_in_order = is_big(place).is_none_or(|it| it == big) && place.byte_bits == 8;
        is_in_order.then(|| Self { shift, unit: W::unit(shift), mask: place.mask() })
    }

    #[inline(always)]
    fn read(&self, word: W) -> u64 {
        word.low_from(self.shift) & self.mask
    }

    /// The word with `code`, which fits, here.
    #[inline(always)]
    fn with(&self, code: u64) -> W {
        W::with_bits(code, self.unit)
    }
}

impl<W: Word> Counter<W> {
    fn of(spec: Option<&SequenceSpec>, big: bool) -> Option<Self> {
        match spec {
            Some(SequenceSpec { place, modulus }) => {
                Some(Self { run: Run::of(place, big)?, modulus: *modulus })
            }
            None => Some(Self { run: Run::none(), modulus: 1 }),
        }
    }
}

impl Flags {
    fn of(specs: &[FlagSpec]) -> Box<[Self]> {
        let mut all: Vec<Self> = Vec::new();
        for (flag, spec) in (0..).zip(specs) {
            match all.last_mut() {
                Some(last)
                    if last.field == spec.field && last.bit + flag == spec.bit + last.flag =>
                {
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
        // The counter has to be in order; of the fields most are.
        let places = spec.sequence.iter().map(|counter| &counter.place);
        let places = places.chain(spec.fields.iter().map(|field| &field.place));
        let big = places.filter_map(is_big).next().unwrap_or(false);
        let counter = Counter::of(spec.sequence.as_ref(), big)?;
        let front = |bytes: &[u8]| {
            let mut front = [0; WORD_LEN];
            front.iter_mut().zip(bytes).for_each(|(to, byte)| *to = *byte);
            W::load(&front, big)
        };
        let sync = front(&spec.sync);
        let mask = if mask.is_empty() {
            front(&[0xFF; MAX_SYNC_LEN][..spec.sync.len()])
        } else {
            front(mask)
        };
        let vouched = |(k, field): (usize, &FieldSpec)| Some((k, field.valid_if?));
        Some(Self {
            len: spec.len,
            big,
            sync,
            known: mask | counter.run.with(counter.run.mask),
            counter,
            deciding: Deciding::of(&spec.fields, sync, big)?,
            flags: Flags::of(&spec.flags),
            vouched: spec.fields.iter().enumerate().filter_map(vouched).collect(),
            check: Check::of::<W>(&spec.check, big)?,
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
    pub(crate) fn cut(&self, front: &[u8; WORD_LEN], counter: u64) -> Option<W> {
        let word = W::load(front, self.big);
        let expected = self.sync | self.counter.run.with(counter);
        if (word ^ expected) & self.known != W::default() {
            return None;
        }
        self.check.as_ref().is_none_or(|check| check.holds(word)).then_some(word)
    }

    /// A place for the frames of a row, of which the first is the one behind index `last_index`.
    pub(crate) fn slate(&self, spec: &FrameSpec, last_index: u64) -> Slate<'_, W> {
        let mut frame = Frame::blank(spec);
        frame.index = last_index;
        Slate { frame, code: 0, carried: self.deciding.carried(0) }
    }

    /// Reads the fields into the frame of `slate`, which was made by this plan, and counts it.
    #[inline(always)]
    pub(crate) fn read<'a>(&'a self, word: W, slate: &mut Slate<'a, W>) {
        let frame = &mut slate.frame;
        let code = self.deciding.code_in(word);
        if code != slate.code {
            slate.code = code;
            slate.carried = self.deciding.carried(code);
            frame.raw = [0; MAX_FIELDS];
            frame.raw[self.deciding.field % MAX_FIELDS] = code.cast_signed();
        }
        slate.carried.read(word, &mut frame.raw);
        let flags = self.flags.iter().fold(0, |all, flags| all | flags.read(&frame.raw));
        let mut has = slate.carried.has(&frame.raw);
        for (field, flag) in &self.vouched {
            has &= !((!flags >> flag & 1) << field);
        }
        (frame.has, frame.flags) = (has, flags);
        frame.index += 1;
    }
}

#[cfg(test)]
mod tests;
