//! `[frame.seq]`, `[[frame.field]]` and `[[frame.flag]]`.

use super::layout::{Layout, whole};
use super::{endian, name};
use crate::field::When;
use crate::framing::Kind;
use crate::place::Place;
use crate::{
    Coding, Endian, FieldSpec, FlagSpec, FrameSpec, MAX_FIELDS, MAX_FLAGS, MAX_FRAME_LEN,
    SequenceSpec, Unit,
};
use struna_settings::{Result, Table, Value};

const UNITS: [(&str, Unit); 8] = [
    ("rad/s", Unit::RadPerS),
    ("deg/s", Unit::DegPerS),
    ("rad", Unit::Rad),
    ("deg", Unit::Deg),
    ("degC", Unit::DegC),
    ("V", Unit::Volt),
    ("counts", Unit::Counts),
    ("s", Unit::Second),
];
/// Keeps every value far inside `f64`, whatever the raw count.
const MAX_MAGNITUDE: f64 = 1e12;
/// A scale below this times a 32-bit count would vanish beside any physical quantity.
const MIN_SCALE: f64 = 1e-18;
/// Decimal digits of a column, before and after the point: `f64` holds as many exactly.
const MAX_DIGITS: u32 = 15;
/// Hexadecimal digits of a column.
const MAX_HEX_DIGITS: u32 = 8;
/// Greatest modulus of a counter.
const MAX_MODULUS: u64 = 1 << 32;

pub(super) fn sequence(table: &Table<'_>, kind: Kind, layout: &mut Layout) -> Result<SequenceSpec> {
    if kind == Kind::Ascii {
        table.only(&["column", "modulus"])?;
        let place = column(table, layout, None)?;
        let modulus = table.required("modulus")?.integer_in(2..=MAX_MODULUS)?;
        return Ok(SequenceSpec { place, modulus });
    }
    table.only(&["at", "bits", "septets", "bytes", "shift", "modulus", "endian"])?;
    let place = place(table, kind)?;
    claim(table, &place, None, layout)?;
    let modulus = table.required("modulus")?.integer_in(2..=place.mask() + 1)?;
    Ok(SequenceSpec { place, modulus })
}

/// Bits inside bytes, as declared by `bits` or `septets`, `bytes`, `shift` and `endian`.
fn place(table: &Table<'_>, kind: Kind) -> Result<Place> {
    if let Some(septets) = table.optional("septets") {
        return septet_place(table, &septets, kind);
    }
    let bits_value = table.required("bits")?;
    let bits = bits_value.integer_in(1_u32..=32)?;
    let bytes = match table.optional("bytes") {
        Some(value) => value.integer_in(1_usize..=4)?,
        None if bits % 8 == 0 => bits as usize / 8,
        None => return Err(bits_value.out_of_range("8, 16, 24 or 32, or say the `bytes` it is in")),
    };
    let shift = match table.optional("shift") {
        Some(value) => value.integer_in(0_u32..=31)?,
        None => 0,
    };
    let (byte_bits, bits) = match kind {
        // Plain 8-bit things, whose value stays below 128.
        Kind::Septet if bits == 8 => (7, 7),
        Kind::Septet => (7, bits),
        _ => (8, bits),
    };
    let room = byte_bits * u32::try_from(bytes).unwrap_or(u32::MAX);
    if shift + bits > room {
        return Err(bits_value.because(format!(
            "bits {shift} to {} do not fit in {bytes} byte{} of {byte_bits} bits; raise `bytes` or \
             lower `shift`",
            shift + bits - 1,
            if bytes == 1 { "" } else { "s" }
        )));
    }
    let at = table.required("at")?.integer_in(0..=MAX_FRAME_LEN - 1)?;
    Ok(Place { at, bytes, shift, bits, endian: endian(table, bytes)?, byte_bits })
}

fn septet_place(table: &Table<'_>, septets: &Value<'_>, kind: Kind) -> Result<Place> {
    if kind != Kind::Septet {
        return Err(septets.because("septets exist in kind = \"septet\" only; write `bits`"));
    }
    for key in ["bits", "bytes", "shift"] {
        if let Some(value) = table.optional(key) {
            return Err(value.because("`septets` says it all; remove this key"));
        }
    }
    let bytes = septets.integer_in(1_usize..=5)?;
    // Five septets hold 35 bits, of which the upper three carry nothing.
    let bits = (7 * u32::try_from(bytes).unwrap_or(u32::MAX)).min(32);
    let at = table.required("at")?.integer_in(0..=MAX_FRAME_LEN - 1)?;
    Ok(Place { at, bytes, shift: 0, bits, endian: endian(table, bytes)?, byte_bits: 7 })
}

fn claim(table: &Table<'_>, place: &Place, when: Option<When>, layout: &mut Layout) -> Result<()> {
    let at = table.required("at")?;
    layout.within(&at, place.at, place.bytes)?;
    layout.claim(&at, place.footprint(), when)
}

/// A column of a line, as eight bytes of the record that the line becomes.
fn column(table: &Table<'_>, layout: &mut Layout, when: Option<When>) -> Result<Place> {
    let value = table.required("column")?;
    let column = value.integer_in(0..=MAX_FIELDS - 1)?;
    layout.within(&value, column, 1)?;
    if when.is_some() {
        return Err(value.because("columns are in every line; remove `when`"));
    }
    layout.claim(&value, whole(column, 1), None)?;
    Ok(Place::whole(8 * column, 8, Endian::Big))
}

pub(super) fn fields(table: &Table<'_>, kind: Kind, layout: &mut Layout) -> Result<Vec<FieldSpec>> {
    let declared = table.required("field")?;
    if declared.array()?.is_empty() {
        return Err(declared.out_of_range("at least one [[frame.field]]"));
    }
    let mut fields: Vec<FieldSpec> = Vec::new();
    for entry in table.tables("field", MAX_FIELDS)? {
        let read = field(&entry, kind, &fields, layout)?;
        refuse_twin(&entry, &read.name, fields.iter().map(FieldSpec::name))?;
        fields.push(read);
    }
    Ok(fields)
}

fn refuse_twin<'a>(
    entry: &Table<'_>,
    name: &str,
    mut earlier: impl Iterator<Item = &'a str>,
) -> Result<()> {
    if earlier.any(|taken| taken == name) {
        let reason = format!("already taken by the entry called {name} above; choose another");
        return Err(entry.required("name")?.because(reason));
    }
    Ok(())
}

fn field(
    table: &Table<'_>,
    kind: Kind,
    earlier: &[FieldSpec],
    layout: &mut Layout,
) -> Result<FieldSpec> {
    let common = ["name", "coding", "scale", "offset", "unit", "clip", "when", "valid_if"];
    let own: &[_] = match kind {
        Kind::Ascii => &["column", "digits", "decimals"],
        _ => &["at", "bits", "septets", "bytes", "shift", "endian", "null"],
    };
    table.only(&[&common, own].concat())?;
    let name = name(&table.required("name")?)?;
    let when = table.optional("when").map(|value| when(&value, earlier)).transpose()?;
    let (place, coding) = if kind == Kind::Ascii {
        (column(table, layout, when)?, text_coding(table)?)
    } else {
        let place = place(table, kind)?;
        claim(table, &place, when, layout)?;
        (place, coding(table, &place)?)
    };
    let unit = table.required("unit")?.word(&UNITS)?;
    let scale = scale(table)?;
    let offset = match table.optional("offset") {
        Some(value) => value.number_in(-MAX_MAGNITUDE..=MAX_MAGNITUDE)?,
        None => 0.0,
    };
    let clip = table.optional("clip").map(|value| clip(&value)).transpose()?;
    Ok(FieldSpec { name, place, coding, unit, scale, offset, clip, when, valid_if: None })
}

/// The condition of a field that not every frame carries.
fn when(value: &Value<'_>, earlier: &[FieldSpec]) -> Result<When> {
    let table = value.table()?;
    table.only(&["field", "equals"])?;
    let decides = |field: &FieldSpec| field.coding == Coding::Unsigned && field.when.is_none();
    let choices: Vec<_> = earlier
        .iter()
        .enumerate()
        .filter(|(_, field)| decides(field))
        .map(|(index, field)| (field.name(), index))
        .collect();
    let named = table.required("field")?;
    if choices.is_empty() {
        return Err(named.because(
            "no unsigned field of every frame stands above this one; declare the deciding field \
             first",
        ));
    }
    let field = named.word(&choices)?;
    let equals = table.required("equals")?.integer_in(0..=earlier[field].raw_max())?;
    Ok(When { field, equals })
}

fn coding(table: &Table<'_>, place: &Place) -> Result<Coding> {
    let null = match table.optional("null") {
        // The code must be able to say zero.
        Some(value) => value.integer_in(0..=u32::MAX >> (32 - place.bits))?,
        None => 0,
    };
    let value = table.required("coding")?;
    let coding = value.word(&[
        ("twos", Coding::Twos),
        ("unsigned", Coding::Unsigned),
        ("offset_binary", Coding::OffsetBinary { null }),
        ("float", Coding::Float),
    ])?;
    let whole_byte_of_septets = place.byte_bits == 7 && table.optional("bits").is_some();
    match (coding, table.optional("null")) {
        (Coding::OffsetBinary { .. }, None) => table.required("null").map(|_| coding),
        (Coding::Twos | Coding::Unsigned | Coding::Float, Some(null)) => {
            Err(null.out_of_range("no `null` at all, or coding = \"offset_binary\""))
        }
        (Coding::Float, _) if place.bits != 32 || place.byte_bits != 8 => {
            Err(value.because("a float takes 32 bits in whole bytes; write bits = 32"))
        }
        (Coding::Twos, _) if whole_byte_of_septets && place.bits == 7 => Err(value
            .because("8 bits below 128 have no sign; write septets = 1 or coding = \"unsigned\"")),
        _ => Ok(coding),
    }
}

/// Coding of a column of text.
fn text_coding(table: &Table<'_>) -> Result<Coding> {
    let is_hex = table.required("coding")?.word(&[("decimal", false), ("hex", true)])?;
    if is_hex {
        if let Some(value) = table.optional("decimals") {
            return Err(value.because("hexadecimal text has no point; remove this key"));
        }
        let digits = table.required("digits")?.integer_in(1..=MAX_HEX_DIGITS)?;
        return Ok(Coding::Hex { digits });
    }
    let decimals = match table.optional("decimals") {
        Some(value) => value.integer_in(0..=MAX_DIGITS - 1)?,
        None => 0,
    };
    let room = MAX_DIGITS - decimals;
    let digits = match table.optional("digits") {
        Some(value) => value.integer_in(1..=room)?,
        None => room,
    };
    Ok(Coding::Decimal { digits, decimals })
}

/// Units per count: 1 when left out, as for status bits.
fn scale(table: &Table<'_>) -> Result<f64> {
    let Some(value) = table.optional("scale") else { return Ok(1.0) };
    let scale = value.number()?;
    if (MIN_SCALE..=MAX_MAGNITUDE).contains(&scale.abs()) {
        return Ok(scale);
    }
    Err(value.out_of_range(format!("{MIN_SCALE:e} to {MAX_MAGNITUDE:e}, of either sign")))
}

fn clip(value: &Value<'_>) -> Result<[f64; 2]> {
    let [least, greatest] = value.pair()?;
    let bounds = [
        least.number_in(-MAX_MAGNITUDE..=MAX_MAGNITUDE)?,
        greatest.number_in(-MAX_MAGNITUDE..=MAX_MAGNITUDE)?,
    ];
    if bounds[0] >= bounds[1] {
        return Err(value.out_of_range("[least, greatest] with least below greatest"));
    }
    Ok(bounds)
}

pub(super) fn flags(table: &Table<'_>, fields: &[FieldSpec]) -> Result<Vec<FlagSpec>> {
    let mut flags: Vec<FlagSpec> = Vec::new();
    for entry in table.tables("flag", MAX_FLAGS)? {
        let read = flag(&entry, fields)?;
        refuse_twin(&entry, &read.name, flags.iter().map(FlagSpec::name))?;
        let same_bit = |other: &&FlagSpec| (other.field, other.bit) == (read.field, read.bit);
        if let Some(other) = flags.iter().find(same_bit) {
            let reason = format!("already taken by the flag {}; choose another", other.name);
            return Err(entry.required("bit")?.because(reason));
        }
        flags.push(read);
    }
    Ok(flags)
}

fn flag(table: &Table<'_>, fields: &[FieldSpec]) -> Result<FlagSpec> {
    table.only(&["name", "field", "bit"])?;
    let name = name(&table.required("name")?)?;
    let usable = fields.iter().enumerate().filter(|(_, field)| FrameSpec::may_hold_flags(field));
    let choices: Vec<_> = usable.map(|(index, field)| (field.name(), index)).collect();
    let index = table.required("field")?.word(&choices)?;
    let bit = table.required("bit")?.integer_in(0..=31)?;
    let bits = 64 - fields[index].raw_max().leading_zeros();
    if bit >= bits {
        return Err(table.required("bit")?.out_of_range(format!("0 to {}", bits - 1)));
    }
    Ok(FlagSpec { name, field: index, bit })
}

/// Fills in the flags that fields depend on; flags live in fields, so both must be there first.
pub(super) fn resolve_valid_if(
    table: &Table<'_>,
    fields: &mut [FieldSpec],
    flags: &[FlagSpec],
) -> Result<()> {
    let entries = table.tables("field", MAX_FIELDS)?;
    for (entry, field) in entries.iter().zip(fields) {
        let Some(value) = entry.optional("valid_if") else { continue };
        let choices: Vec<_> = flags.iter().map(FlagSpec::name).zip(0..).collect();
        if choices.is_empty() {
            return Err(value.because("the file declares no [[frame.flag]]; add one of this name"));
        }
        field.valid_if = Some(value.word(&choices)?);
    }
    Ok(())
}
