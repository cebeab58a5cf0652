//! `[frame.check]`.

use super::endian;
use super::layout::{Layout, whole};
use crate::check::Algorithm;
use crate::framing::Kind;
use crate::place::Place;
use crate::{CheckSpec, Crc, CrcParams, Endian, MAX_FRAME_LEN};
use struna_settings::{Result, Table, Value};

/// A check as the file calls it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Word {
    None,
    Sum,
    NegSum,
    Xor,
    Crc { width: u32 },
    Parity,
}

const KINDS: [(&str, Word); 8] = [
    ("none", Word::None),
    ("sum8", Word::Sum),
    ("negsum8", Word::NegSum),
    ("xor8", Word::Xor),
    ("crc8", Word::Crc { width: 8 }),
    ("crc16", Word::Crc { width: 16 }),
    ("crc32", Word::Crc { width: 32 }),
    ("parity", Word::Parity),
];
const SENSES: [(&str, bool); 2] = [("even", false), ("odd", true)];
/// A place that is not looked at.
const NOWHERE: Place = Place::whole(0, 1, Endian::Big);

pub(super) fn check(table: &Table<'_>, kind: Kind, layout: &mut Layout) -> Result<CheckSpec> {
    let value = table.required("kind")?;
    let word = value.word(&KINDS)?;
    refuse_misfit(&value, kind, word)?;
    table.only(match word {
        Word::None => &["kind"],
        _ if kind == Kind::Ascii => &["kind"],
        Word::Sum | Word::NegSum | Word::Xor => &["kind", "range", "at"],
        Word::Parity => &["kind", "range", "word_parity"],
        Word::Crc { .. } => {
            &["kind", "poly", "init", "refin", "refout", "xorout", "range", "at", "endian"]
        }
    })?;
    let algorithm = algorithm(table, word)?;
    match algorithm {
        Algorithm::None => return Ok(CheckSpec { algorithm, first: 0, last: 0, place: NOWHERE }),
        // `*hh` at the end of the line, over all before it.
        _ if kind == Kind::Ascii => {
            return Ok(CheckSpec { algorithm, first: 0, last: 0, place: NOWHERE });
        }
        Algorithm::Parity { .. } => {
            let (first, last) = range(&table.required("range")?, None, layout)?;
            return Ok(CheckSpec { algorithm, first, last, place: NOWHERE });
        }
        _ => (),
    }
    let bytes = if let Word::Crc { width } = word { width as usize / 8 } else { 1 };
    let at_value = table.required("at")?;
    let at = at_value.integer_in(0..=MAX_FRAME_LEN - 1)?;
    layout.within(&at_value, at, bytes)?;
    layout.claim(&at_value, whole(at, bytes), None)?;
    let (first, last) = range(&table.required("range")?, Some((at, bytes)), layout)?;
    let mut place = Place::whole(at, bytes, endian(table, bytes)?);
    if kind == Kind::Septet {
        place.bits = 7;
    }
    Ok(CheckSpec { algorithm, first, last, place })
}

/// Refuses a check that this kind of frame cannot carry.
fn refuse_misfit(value: &Value<'_>, kind: Kind, word: Word) -> Result<()> {
    let expected = match (kind, word) {
        (Kind::Septet, Word::Crc { .. } | Word::Parity) => {
            "\"sum8\", \"negsum8\", \"xor8\" or \"none\": the bytes of septets have bit 7 clear"
        }
        (Kind::Ascii, Word::None | Word::Xor) | (Kind::Fixed | Kind::Septet | Kind::Cobs, _) => {
            return Ok(());
        }
        (Kind::Ascii, _) => "\"xor8\" (sent as *hh) or \"none\" for a line of text",
    };
    Err(value.out_of_range(expected))
}

fn algorithm(table: &Table<'_>, word: Word) -> Result<Algorithm> {
    Ok(match word {
        Word::None => Algorithm::None,
        Word::Sum => Algorithm::Sum { negated: false },
        Word::NegSum => Algorithm::Sum { negated: true },
        Word::Xor => Algorithm::Xor,
        Word::Parity => Algorithm::Parity { odd: table.required("word_parity")?.word(&SENSES)? },
        Word::Crc { width } => {
            let greatest = u32::MAX >> (32 - width);
            let number = |key| table.required(key)?.integer_in(0..=greatest);
            Algorithm::Crc(Crc::new(CrcParams {
                width,
                poly: table.required("poly")?.integer_in(1..=greatest)?,
                init: number("init")?,
                refin: table.required("refin")?.boolean()?,
                refout: table.required("refout")?.boolean()?,
                xorout: number("xorout")?,
            }))
        }
    })
}

fn range(
    value: &Value<'_>,
    own: Option<(usize, usize)>,
    layout: &Layout,
) -> Result<(usize, usize)> {
    let [first, last] = value.pair()?;
    let offset = |value: &Value<'_>| value.integer_in(0..=MAX_FRAME_LEN - 1);
    let (first, last) = (offset(&first)?, offset(&last)?);
    if first > last {
        return Err(value.out_of_range("[first, last] with first not after last"));
    }
    if last > layout.last() {
        return Err(layout.beyond(value, last));
    }
    let own =
        own.and_then(|(at, bytes)| (at..at + bytes).find(|byte| (first..=last).contains(byte)));
    match own {
        // Such a check could be met by accident only.
        Some(byte) => {
            Err(value
                .because(format!("covers the check's own byte {byte}; end the range before it")))
        }
        None => Ok((first, last)),
    }
}

/// Finds the bit that parity may set: the first bit of its range that nothing else owns.
pub(super) fn with_parity_bit(
    table: &Table<'_>,
    check: CheckSpec,
    layout: &mut Layout,
) -> Result<CheckSpec> {
    if !matches!(check.algorithm, Algorithm::Parity { .. }) {
        return Ok(check);
    }
    let value = table.required("range")?;
    let Some((at, bit)) = layout.free_bit(check.first, check.last) else {
        return Err(value.because(
            "every bit of these bytes belongs to something; leave one to the parity bit",
        ));
    };
    let place = Place { at, bytes: 1, shift: bit, bits: 1, endian: Endian::Big, byte_bits: 8 };
    layout.claim(&value, place.footprint(), None)?;
    Ok(CheckSpec { place, ..check })
}
