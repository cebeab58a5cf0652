//! Frames to be sent, each the exclusive or of what its numbers make of it.

use super::carried::deciding;
use super::linear::Linear;
use super::{WORD_LEN, Word};
use crate::check::Algorithm;
use crate::field::When;
use crate::frame::write_content;
use crate::{FieldSpec, FrameSpec, Kind};

/// The plan of sending a layout's frames, in the smaller word that holds them.
#[derive(Debug, Clone)]
pub(crate) enum AnySendPlan {
    Short(Box<SendPlan<u64>>),
    Long(Box<SendPlan<u128>>),
}

impl AnySendPlan {
    /// The plan of a layout, if it is of a kind that can be planned.
    pub(crate) fn of(spec: &FrameSpec) -> Option<Self> {
        if spec.len <= u64::LEN {
            return SendPlan::of(spec).map(Box::new).map(Self::Short);
        }
        SendPlan::of(spec).map(Box::new).map(Self::Long)
    }
}

/// A layout of at most sixteen bytes that are sent as they stand, with a check that is linear and
/// at most one field that decides which others there are.
///
/// Every bit of a number turns certain bits of the frame, its own and the check's, and whatever
/// else the frame holds it turns the same ones. Where they are is found by writing frames as the
/// layout says, so of place, order and check nothing is left to ask when a frame is sent.
#[derive(Debug, Clone)]
pub(crate) struct SendPlan<W> {
    len: usize,
    field_count: usize,
    /// A frame's counter is one byte as a rule, its values are two.
    counter: Linear<W, 1, 3>,
    /// Index of the deciding field. Any one if nothing is decided.
    deciding: usize,
    /// What frames are made of, by the value of that field, and with greater values.
    kinds: Box<[Sent<W>]>,
    otherwise: Sent<W>,
}

/// Frames of one kind.
#[derive(Debug, Clone)]
struct Sent<W> {
    /// The frame with the counter zero and the least value in each field.
    least: W,
    /// Its fields but for the deciding one, whose value is what makes the kind.
    fields: Box<[Field<W>]>,
    /// The field if there is but one and the counter has no high bytes: gyros on a short frame.
    single: Option<Field<W>>,
}

/// A field's code is the raw value less the least one that there is.
#[derive(Debug, Clone)]
struct Field<W> {
    index: usize,
    bias: u64,
    /// Bits that a code has not.
    beyond: u64,
    code: Linear<W, 2, 2>,
}

impl<W: Word> SendPlan<W> {
    fn of(spec: &FrameSpec) -> Option<Self> {
        let is_as_it_stands = matches!(spec.kind(), Kind::Fixed | Kind::Septet);
        let is_linear = !matches!(spec.check.algorithm, Algorithm::Sum { .. });
        if !is_as_it_stands || !is_linear || spec.len > W::LEN {
            return None;
        }
        let (deciding, greatest) = deciding(&spec.fields)?;
        let fields: Vec<_> = (0..spec.fields.len()).map(|index| Field::of(spec, index)).collect();
        let equals = |equals| When { field: deciding, equals };
        let counter = counter(spec);
        let sent = |decided| {
            let sent = Sent::of(spec, &fields, decided);
            if counter.is_low() { sent } else { Sent { single: None, ..sent } }
        };
        Some(Self {
            len: spec.len,
            field_count: fields.len(),
            deciding,
            kinds: (0..=greatest).map(|value| sent(Some(equals(value)))).collect(),
            otherwise: sent(None),
            counter,
        })
    }

    /// Appends the frame of these raw values and this counter to `out`; tells whether it did.
    /// Values that do not fit the layout are for the caller to find.
    #[inline]
    pub(crate) fn emit(&self, raw: &[i64], counter: u64, out: &mut Vec<u8>) -> bool {
        let Some(word) = self.kind_of(raw).and_then(|kind| kind.word_of(raw)) else { return false };
        (word ^ self.counter.word_of(counter)).append(self.len, out);
        true
    }

    /// The same, only where it takes no loop and no memory: other frames are not appended.
    #[inline(always)]
    pub(crate) fn emit_single(&self, raw: &[i64], counter: u64, out: &mut Vec<u8>) -> bool {
        if out.capacity() - out.len() < W::LEN {
            return false;
        }
        let Some(word) = self.kind_of(raw).and_then(|kind| kind.word_of_single(raw)) else {
            return false;
        };
        (word ^ self.counter.word_of_low(counter)).append(self.len, out);
        true
    }

    /// What frames of these raw values are made of, if there are as many as there are fields.
    #[inline(always)]
    fn kind_of(&self, raw: &[i64]) -> Option<&Sent<W>> {
        if raw.len() != self.field_count {
            return None;
        }
        let value =
            raw.get(self.deciding).and_then(|raw| usize::try_from(raw.cast_unsigned()).ok());
        Some(value.and_then(|value| self.kinds.get(value)).unwrap_or(&self.otherwise))
    }
}

impl<W: Word> Sent<W> {
    /// Frames in which a field is what `decided` says, or in which none is what any field asks.
    fn of(spec: &FrameSpec, fields: &[Field<W>], decided: Option<When>) -> Self {
        let mut raw = least(spec);
        if let Some(When { field, equals }) = decided {
            raw[field] = equals;
        }
        let is_carried = |field: &FieldSpec| field.when.is_none() || field.when == decided;
        let is_open = |field: &&Field<W>| {
            is_carried(&spec.fields[field.index])
                && decided.is_none_or(|when| when.field != field.index)
        };
        let fields: Box<[_]> = fields.iter().filter(is_open).cloned().collect();
        let single = match &*fields {
            [field] => Some(field.clone()),
            _ => None,
        };
        Self { least: word(spec, &raw, 0, is_carried), fields, single }
    }

    /// The word of these raw values and the counter zero, unless a value does not fit.
    #[inline]
    fn word_of(&self, raw: &[i64]) -> Option<W> {
        let (mut word, mut beyond) = (self.least, 0);
        for field in &self.fields {
            let code = field.code_of(raw)?;
            beyond |= code & field.beyond;
            word = word ^ field.code.word_of(code);
        }
        (beyond == 0).then_some(word)
    }

    /// The same for a single field.
    #[inline(always)]
    fn word_of_single(&self, raw: &[i64]) -> Option<W> {
        let field = self.single.as_ref()?;
        let code = field.code_of(raw)?;
        (code & field.beyond == 0).then(|| self.least ^ field.code.word_of(code))
    }
}

impl<W: Word> Field<W> {
    fn of(spec: &FrameSpec, index: usize) -> Self {
        let (field, least) = (&spec.fields[index], least(spec));
        let is_carried = |other: &FieldSpec| std::ptr::eq(other, field);
        let of_least = word::<W>(spec, &least, 0, is_carried);
        let of_bit = |bit| {
            let mut raw = least.clone();
            raw[index] += 1_i64 << bit;
            word::<W>(spec, &raw, 0, is_carried) ^ of_least
        };
        Self {
            index,
            bias: least[index].wrapping_neg().cast_unsigned(),
            beyond: !field.place.mask(),
            code: Linear::of_bits(field.place.bits, of_bit),
        }
    }

    #[inline(always)]
    fn code_of(&self, raw: &[i64]) -> Option<u64> {
        Some(raw.get(self.index)?.cast_unsigned().wrapping_add(self.bias))
    }
}

/// What each bit of the frame counter turns.
fn counter<W: Word>(spec: &FrameSpec) -> Linear<W, 1, 3> {
    let least = least(spec);
    let word = |counter| word::<W>(spec, &least, counter, |_| false);
    let bits = spec.sequence.map_or(0, |sequence| sequence.place.bits);
    Linear::of_bits(bits, |bit| word(1 << bit) ^ word(0))
}

/// The least raw value of each field.
fn least(spec: &FrameSpec) -> Vec<i64> {
    spec.fields.iter().map(FieldSpec::raw_min).collect()
}

/// A frame as the layout says, its first byte lowest.
fn word<W: Word>(
    spec: &FrameSpec,
    raw: &[i64],
    counter: u64,
    is_carried: impl Fn(&FieldSpec) -> bool,
) -> W {
    let mut content = [0; WORD_LEN];
    write_content(spec, raw, counter, is_carried, &mut content);
    W::load(&content, false)
}
