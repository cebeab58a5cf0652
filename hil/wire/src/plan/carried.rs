//! What a frame carries, which the value of one of its fields may decide.

use super::{Run, Word};
use crate::MAX_FIELDS;
use crate::field::{Coding, FieldSpec};

/// Values that a deciding field may have, at most.
const CODES: usize = 256;
/// All bits of a float's exponent: it is no number.
const ENDLESS: i64 = 0x7F80_0000;

/// The deciding field, and what each value of it makes a frame carry.
#[derive(Debug, Clone)]
pub(super) struct Deciding<W> {
    /// Index of the field. Any one if nothing is decided; it is not looked at.
    pub(super) field: usize,
    /// Its bits; none of them if nothing is decided.
    run: Run,
    /// Which of the kinds of frame each value stands for.
    choice: Box<[u8; CODES]>,
    kinds: Box<[Carried<W>]>,
}

/// The fields of one kind of frame.
///
/// A raw value is the code with some bits turned, less a bias: that is all that tells two's
/// complement, plain and offset binary apart. The bits to turn are the same in every frame.
#[derive(Debug, Clone)]
pub(super) struct Carried<W> {
    /// Bits to turn in the word whose lowest byte is the frame's first, and fields read there.
    turned_little: W,
    little: Box<[Field]>,
    /// The same in the word whose highest byte is the frame's first.
    turned_big: W,
    big: Box<[Field]>,
    /// Fields that have a usable value, floats among them if they are numbers.
    pub(super) has: u64,
    floats: Box<[usize]>,
}

#[derive(Debug, Clone, Copy)]
struct Field {
    index: usize,
    shift: u32,
    mask: u64,
    bias: u64,
}

impl<W: Word> Deciding<W> {
    /// `None` if more than one field decides, or one of more than eight bits.
    pub(super) fn of(fields: &[FieldSpec]) -> Option<Self> {
        let mut whens: Vec<_> = fields.iter().filter_map(|field| field.when).collect();
        let field = whens.first().map_or(0, |when| when.field);
        if whens.iter().any(|when| when.field != field) {
            return None;
        }
        let run = match whens.first() {
            Some(_) => Run::of::<W>(&fields[field].place, false)?,
            None => Run::NONE,
        };
        if usize::try_from(run.mask).ok()? >= CODES {
            return None;
        }
        whens.sort_unstable_by_key(|when| when.equals);
        whens.dedup_by_key(|when| when.equals);
        let mut choice = Box::new([0; CODES]);
        let mut kinds = vec![Carried::of(fields, None)?];
        for when in whens {
            *choice.get_mut(usize::try_from(when.equals).ok()?)? = u8::try_from(kinds.len()).ok()?;
            kinds.push(Carried::of(fields, Some(when.equals))?);
        }
        Some(Self { field, run, choice, kinds: kinds.into_boxed_slice() })
    }

    /// The deciding code in a frame, zero if nothing is decided.
    #[inline(always)]
    pub(super) fn code_in(&self, little: W, big: W) -> u64 {
        self.run.read(little, big)
    }

    /// The deciding code for a raw value; some code if the value does not fit.
    #[inline(always)]
    pub(super) fn code_for(&self, raw: i64) -> u64 {
        raw.cast_unsigned() & self.run.mask
    }

    /// What frames with this code carry.
    #[inline(always)]
    pub(super) fn carried(&self, code: u64) -> &Carried<W> {
        let [code, ..] = code.to_le_bytes();
        &self.kinds[usize::from(self.choice[usize::from(code)])]
    }
}

impl<W: Word> Carried<W> {
    /// What is carried if the deciding field is `decided`; only what every frame carries if it is
    /// something else.
    fn of(specs: &[FieldSpec], decided: Option<i64>) -> Option<Self> {
        let (mut little, mut big, mut floats) = (Vec::new(), Vec::new(), Vec::new());
        let (mut turned_little, mut turned_big) = (W::default(), W::default());
        let mut has = 0;
        // A single byte may stand in either word; with the others it takes no loop of its own.
        let bytes_big = specs.iter().any(|spec| Run::is_big(&spec.place));
        for (index, spec) in specs.iter().enumerate() {
            if spec.when.is_some_and(|when| Some(when.equals) != decided) {
                continue;
            }
            let (turned, bias) = turned_and_bias(spec)?;
            let Run { big: is_big, shift, mask } = Run::of::<W>(&spec.place, bytes_big)?;
            let field = Field { index, shift, mask, bias };
            let turned = W::with_low(turned, shift);
            if is_big {
                turned_big = turned_big | turned;
                big.push(field);
            } else {
                turned_little = turned_little | turned;
                little.push(field);
            }
            if spec.coding == Coding::Float {
                floats.push(index);
            }
            has |= 1 << index;
        }
        let [little, big] = [little, big].map(Vec::into_boxed_slice);
        let floats = floats.into_boxed_slice();
        Some(Self { turned_little, little, turned_big, big, has, floats })
    }

    /// Reads the fields of a frame; the others stay as they are.
    #[inline(always)]
    pub(super) fn read(&self, little: W, big: W, raw: &mut [i64; MAX_FIELDS]) {
        let (little, big) = (little ^ self.turned_little, big ^ self.turned_big);
        for field in &self.big {
            raw[field.index % MAX_FIELDS] = field.raw(big);
        }
        for field in &self.little {
            raw[field.index % MAX_FIELDS] = field.raw(little);
        }
    }

    /// The fields that a frame read like this has usable values of, flags left aside.
    #[inline(always)]
    pub(super) fn has(&self, raw: &[i64; MAX_FIELDS]) -> u64 {
        let is_endless = |index: usize| raw[index % MAX_FIELDS] & ENDLESS == ENDLESS;
        self.floats.iter().fold(self.has, |has, &k| has & !(u64::from(is_endless(k)) << k))
    }

    /// The word, first byte lowest, of these raw values, unless one does not fit.
    #[inline(always)]
    pub(super) fn word_of(&self, raw: &[i64]) -> Option<W> {
        let (mut little, mut big) = (self.turned_little, self.turned_big);
        let mut beyond = 0;
        for field in &self.big {
            let code = field.code(*raw.get(field.index)?);
            beyond |= code & !field.mask;
            big = big ^ W::with_low(code, field.shift);
        }
        for field in &self.little {
            let code = field.code(*raw.get(field.index)?);
            beyond |= code & !field.mask;
            little = little ^ W::with_low(code, field.shift);
        }
        (beyond == 0).then(|| little | big.swapped())
    }
}

impl Field {
    /// The raw value in a word whose bits have been turned.
    #[inline(always)]
    fn raw<W: Word>(&self, turned: W) -> i64 {
        (turned.low_from(self.shift) & self.mask).wrapping_sub(self.bias).cast_signed()
    }

    /// The code before bits are turned. The least value that fits is zero and the greatest is the
    /// mask.
    #[inline(always)]
    const fn code(&self, raw: i64) -> u64 {
        raw.cast_unsigned().wrapping_add(self.bias)
    }
}

/// Bits of the code to turn, and what to take away then; `None` for text.
fn turned_and_bias(spec: &FieldSpec) -> Option<(u64, u64)> {
    let top = 1 << (spec.place.bits - 1);
    match spec.coding {
        Coding::Twos => Some((top, top)),
        Coding::Unsigned | Coding::Float => Some((0, 0)),
        Coding::OffsetBinary { null } => Some((0, u64::from(null))),
        Coding::Decimal { .. } | Coding::Hex { .. } => None,
    }
}
