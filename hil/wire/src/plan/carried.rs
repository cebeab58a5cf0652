//! What a frame carries, which the value of one of its fields may decide.

use super::{Run, Word, is_big, shift_of};
use crate::MAX_FIELDS;
use crate::field::{Coding, FieldSpec, When};

/// Greatest value that a deciding field may have.
const CODE_MAX: u64 = 0xFF;
/// All bits of a float's exponent: it is no number.
const ENDLESS: i64 = 0x7F80_0000;

/// The deciding field and the greatest value that another field asks of it, -1 if none does;
/// `None` if there are several of them, or the values would be too many.
pub(super) fn deciding(fields: &[FieldSpec]) -> Option<(usize, i64)> {
    let whens = || fields.iter().filter_map(|field| field.when);
    let Some(first) = whens().next() else { return Some((0, -1)) };
    let is_planned = fields[first.field].place.mask() <= CODE_MAX
        && whens().all(|when| when.field == first.field);
    is_planned.then_some((first.field, whens().map(|when| when.equals).max()?))
}

/// The deciding field, and what each value of it makes a frame carry.
#[derive(Debug, Clone)]
pub(super) struct Deciding<W> {
    /// Index of the field. Any one if nothing is decided.
    pub(super) field: usize,
    /// Its bits; none of them if nothing is decided.
    run: Run<W>,
    /// What frames carry, by the value.
    kinds: Box<[Carried<W>]>,
    /// What they carry with greater values.
    otherwise: Carried<W>,
}

/// The fields of one kind of frame.
///
/// A raw value is the code with some bits turned, less a bias: that is all that tells two's
/// complement, plain and offset binary apart. The bits to turn are the same in every frame, and so
/// are the deciding field's where its value is what makes the kind; no list has it then.
#[derive(Debug, Clone)]
pub(super) struct Carried<W> {
    /// Bits that are the same in every such frame, and those to turn.
    turned: W,
    fields: Box<[Field]>,
    /// Fields whose bytes are the other way round than the word's.
    swapped: Box<[Swapped]>,
    /// Fields that have a usable value, floats among them if they are numbers.
    has: u64,
    floats: Box<[usize]>,
}

#[derive(Debug, Clone, Copy)]
struct Field {
    index: usize,
    /// The lowest bit.
    shift: u32,
    /// Bits that a code has not.
    beyond: u64,
    bias: u64,
}

/// A field in the upper bytes of 64 bits, which swapped are in the word where the field says.
#[derive(Debug, Clone, Copy)]
struct Swapped {
    shift: u32,
    field: Field,
}

impl<W: Word> Deciding<W> {
    /// The fields of a layout, whose frames all have the bits of `same`. `None` if more than one
    /// field decides, or one of more than eight bits.
    pub(super) fn of(fields: &[FieldSpec], same: W, big: bool) -> Option<Self> {
        let (field, greatest) = deciding(fields)?;
        let run = if greatest < 0 { Run::none() } else { Run::of(&fields[field].place, big)? };
        let kind = |equals: i64| {
            let same = same | run.with(equals.cast_unsigned());
            Carried::of(fields, Some(When { field, equals }), same, big)
        };
        let kinds = (0..=greatest).map(kind).collect::<Option<_>>()?;
        Some(Self { field, run, kinds, otherwise: Carried::of(fields, None, same, big)? })
    }

    /// The deciding code in a frame, zero if nothing is decided.
    #[inline(always)]
    pub(super) fn code_in(&self, word: W) -> u64 {
        self.run.read(word)
    }

    /// What frames carry in which the deciding field has this code. One that is too great for it
    /// is found with those of other fields.
    #[inline(always)]
    pub(super) fn carried(&self, code: u64) -> &Carried<W> {
        let kind = usize::try_from(code).ok().and_then(|code| self.kinds.get(code));
        kind.unwrap_or(&self.otherwise)
    }
}

impl<W: Word> Carried<W> {
    /// What frames carry in which a field is what `decided` says, or only what every frame carries;
    /// they all have the bits of `same`.
    fn of(specs: &[FieldSpec], decided: Option<When>, same: W, big: bool) -> Option<Self> {
        let (mut fields, mut swapped, mut floats) = (Vec::new(), Vec::new(), Vec::new());
        let (mut turned, mut has) = (same, 0);
        for (index, spec) in specs.iter().enumerate() {
            if spec.when.is_some() && spec.when != decided {
                continue;
            }
            has |= 1 << index;
            if decided.is_some_and(|when| when.field == index) {
                continue;
            }
            if spec.place.byte_bits != 8 {
                return None;
            }
            let (turns, bias) = turns_and_bias(spec)?;
            let beyond = !spec.place.mask();
            let shift = shift_of::<W>(spec.place.at, spec.place.bytes, big)?;
            if is_big(&spec.place).is_none_or(|it| it == big) {
                let shift = shift + spec.place.shift;
                let field = Field { index, shift, beyond, bias };
                turned = turned ^ W::with_bits(turns, W::unit(shift));
                fields.push(field);
            } else {
                let (field, unit) = (Field { index, shift, beyond, bias }, W::unit(shift));
                let shift = 64 - 8 * u32::try_from(spec.place.bytes).ok()? + spec.place.shift;
                turned = turned ^ W::with_bits((turns << shift).swap_bytes(), unit);
                swapped.push(Swapped { shift, field });
            }
            if spec.coding == Coding::Float {
                floats.push(index);
            }
        }
        let (fields, swapped) = (fields.into_boxed_slice(), swapped.into_boxed_slice());
        Some(Self { turned, fields, swapped, has, floats: floats.into_boxed_slice() })
    }

    /// Reads the fields of a frame; the others stay as they are.
    #[inline(always)]
    pub(super) fn read(&self, word: W, raw: &mut [i64; MAX_FIELDS]) {
        let turned = word ^ self.turned;
        let mut read = |field: &Field| {
            raw[field.index % MAX_FIELDS] = field.raw(turned.low_from(field.shift));
        };
        // Most often it is only one.
        if let Some((first, others)) = self.fields.split_first() {
            read(first);
            others.iter().for_each(read);
        }
        for Swapped { shift, field } in &self.swapped {
            let bits = turned.low_from(field.shift).swap_bytes() >> (shift % u64::BITS);
            raw[field.index % MAX_FIELDS] = field.raw(bits);
        }
    }

    /// The fields that a frame read like this has usable values of, flags left aside.
    #[inline(always)]
    pub(super) fn has(&self, raw: &[i64; MAX_FIELDS]) -> u64 {
        let is_endless = |index: usize| raw[index % MAX_FIELDS] & ENDLESS == ENDLESS;
        self.floats.iter().fold(self.has, |has, &k| has & !(u64::from(is_endless(k)) << k))
    }
}

impl Field {
    /// The raw value, whose code with bits turned is lowest in `bits`.
    #[inline(always)]
    const fn raw(&self, bits: u64) -> i64 {
        (bits & !self.beyond).wrapping_sub(self.bias).cast_signed()
    }
}

/// Bits of the code to turn, and what to take away then; `None` for text.
fn turns_and_bias(spec: &FieldSpec) -> Option<(u64, u64)> {
    let top = 1 << (spec.place.bits - 1);
    match spec.coding {
        Coding::Twos => Some((top, top)),
        Coding::Unsigned | Coding::Float => Some((0, 0)),
        Coding::OffsetBinary { null } => Some((0, u64::from(null))),
        Coding::Decimal { .. } | Coding::Hex { .. } => None,
    }
}
