//! From the text of a frame file to a consistent [`FrameSpec`].

use crate::{
    CheckSpec, Coding, Crc16, Crc16Params, Endian, FieldSpec, FlagSpec, FrameSpec, LineSpec,
    MAX_FIELDS, MAX_FLAGS, MAX_FRAME_LEN, MAX_SYNC_LEN, Parity, Provenance, SequenceSpec,
    TimingSpec, Unit,
};
use struna_settings::{Result, SettingsError, Table, Value};

const ENDIANS: [(&str, Endian); 2] = [("be", Endian::Big), ("le", Endian::Little)];
const UNITS: [(&str, Unit); 4] = [
    ("rad/s", Unit::RadPerS),
    ("deg/s", Unit::DegPerS),
    ("degC", Unit::DegC),
    ("counts", Unit::Counts),
];
const PARITIES: [(&str, Parity); 3] =
    [("none", Parity::None), ("even", Parity::Even), ("odd", Parity::Odd)];
const PROVENANCES: [(&str, Provenance); 3] = [
    ("unverified", Provenance::Unverified),
    ("published", Provenance::Published),
    ("measured", Provenance::Measured),
];
/// Septet, COBS and ASCII framings would join here, each with its own layout reader.
const KINDS: [(&str, ()); 1] = [("fixed", ())];
/// Sums, exclusive-ors and other CRC widths would join here.
const CHECK_KINDS: [(&str, ()); 1] = [("crc16", ())];
/// Keeps every value far inside `f64`, whatever the raw count.
const MAX_MAGNITUDE: f64 = 1e12;
/// A scale below this times a 32-bit count would vanish beside any physical quantity.
const MIN_SCALE: f64 = 1e-18;
const MAX_NAME_LEN: usize = 64;

pub(crate) fn frame_spec(text: &str) -> Result<FrameSpec> {
    struna_settings::read(text, |root| {
        root.only(&["frame", "line", "timing"])?;
        let line = line(&root.required("line")?.table()?)?;
        let timing_table = root.required("timing")?.table()?;
        let timing = timing(&timing_table)?;
        let spec = frame(&root.required("frame")?.table()?, line, timing)?;
        let needed_baud = spec.bits_per_s();
        if needed_baud > f64::from(spec.line.baud) {
            let rate = timing_table.required("rate_hz")?;
            return Err(rate.because(format!(
                "frames at this rate need {needed_baud:.0} baud; raise `line.baud` or lower \
                 `timing.rate_hz`"
            )));
        }
        Ok(spec)
    })
}

fn frame(table: &Table<'_>, line: LineSpec, timing: TimingSpec) -> Result<FrameSpec> {
    table.only(&["name", "kind", "provenance", "sync", "len", "check", "seq", "field", "flag"])?;
    table.required("kind")?.word(&KINDS)?;
    let name = name(&table.required("name")?)?;
    let provenance = table.required("provenance")?.word(&PROVENANCES)?;
    let len = table.required("len")?.integer_in(1_u8..=64)?.into();
    let mut layout = Layout::new(len);
    let sync_value = table.required("sync")?;
    let sync = sync(&sync_value)?;
    layout.claim(&sync_value, 0, sync.len())?;
    let check = check(&table.required("check")?.table()?, &mut layout)?;
    let sequence = match table.optional("seq") {
        Some(seq) => Some(sequence(&seq.table()?, &mut layout)?),
        None => None,
    };
    let fields = fields(table, &mut layout)?;
    let flags = flags(table, &fields)?;
    Ok(FrameSpec { name, provenance, sync, len, fields, flags, check, sequence, line, timing })
}

/// Who owns each byte of the frame.
struct Layout {
    owners: Vec<Option<String>>,
}

impl Layout {
    fn new(len: usize) -> Self {
        Self { owners: vec![None; len] }
    }

    fn last(&self) -> usize {
        self.owners.len() - 1
    }

    /// Refuses a `value` that would reach byte `last`.
    fn beyond(&self, value: &Value<'_>, last: usize) -> Box<SettingsError> {
        let end = self.last();
        value.because(format!(
            "reaches byte {last}, but the frame ends at byte {end}; move it or raise `frame.len`"
        ))
    }

    /// Gives `bytes` bytes from `at` to the thing whose place `value` states.
    fn claim(&mut self, value: &Value<'_>, at: usize, bytes: usize) -> Result<()> {
        let last = at + bytes - 1;
        if last > self.last() {
            return Err(self.beyond(value, last));
        }
        for (byte, slot) in self.owners.iter_mut().enumerate().take(last + 1).skip(at) {
            if let Some(owner) = slot {
                return Err(value
                    .because(format!("byte {byte} already belongs to {owner}; move one of them")));
            }
            *slot = Some(value.path().trim_end_matches(".at").to_owned());
        }
        Ok(())
    }
}

fn name(value: &Value<'_>) -> Result<String> {
    let text = value.text()?;
    let plain = |c: char| c.is_ascii_graphic() && !matches!(c, '"' | '\'' | '`' | '\\');
    if text.is_empty() || text.len() > MAX_NAME_LEN || !text.chars().all(plain) {
        let expected = format!("1 to {MAX_NAME_LEN} printable ASCII characters, no space or quote");
        return Err(value.out_of_range(expected));
    }
    Ok(text.to_owned())
}

fn sync(value: &Value<'_>) -> Result<Vec<u8>> {
    let refusal = || value.out_of_range(format!("1 to {MAX_SYNC_LEN} bytes in hex, as \"A5 5A\""));
    let is_byte = |word: &&str| word.len() == 2 && word.bytes().all(|c| c.is_ascii_hexdigit());
    let words: Vec<_> = value.text()?.split_ascii_whitespace().take(MAX_SYNC_LEN + 1).collect();
    if words.is_empty() || words.len() > MAX_SYNC_LEN || !words.iter().all(is_byte) {
        return Err(refusal());
    }
    words.iter().map(|word| u8::from_str_radix(word, 16).map_err(|_| refusal())).collect()
}

fn offset(value: &Value<'_>) -> Result<usize> {
    value.integer_in(0..=MAX_FRAME_LEN - 1)
}

/// A width in bits, as bytes. Bit fields would need a sub-byte place as well.
fn whole_bytes(value: &Value<'_>) -> Result<usize> {
    match value.integer_in(1_u8..=64).map_err(|_| value.out_of_range("8, 16, 24 or 32"))? {
        8 => Ok(1),
        16 => Ok(2),
        24 => Ok(3),
        32 => Ok(4),
        _ => Err(value.out_of_range("8, 16, 24 or 32 (bit fields are not supported)")),
    }
}

/// Byte order; one byte has none, so there it may be left out.
fn endian(table: &Table<'_>, bytes: usize) -> Result<Endian> {
    match table.optional("endian") {
        Some(value) => value.word(&ENDIANS),
        None if bytes == 1 => Ok(Endian::Big),
        None => table.required("endian")?.word(&ENDIANS),
    }
}

fn check(table: &Table<'_>, layout: &mut Layout) -> Result<CheckSpec> {
    table.required("kind")?.word(&CHECK_KINDS)?;
    table.only(&["kind", "poly", "init", "refin", "refout", "xorout", "range", "at", "endian"])?;
    let number = |key| table.required(key)?.integer_in(0..=u16::MAX);
    let params = Crc16Params {
        poly: table.required("poly")?.integer_in(1..=u16::MAX)?,
        init: number("init")?,
        refin: table.required("refin")?.boolean()?,
        refout: table.required("refout")?.boolean()?,
        xorout: number("xorout")?,
    };
    let place = table.required("at")?;
    let at = offset(&place)?;
    layout.claim(&place, at, CheckSpec::BYTES)?;
    let (first, last) = check_range(&table.required("range")?, at, layout)?;
    let endian = endian(table, CheckSpec::BYTES)?;
    Ok(CheckSpec { crc: Crc16::new(params), first, last, at, endian })
}

fn check_range(value: &Value<'_>, at: usize, layout: &Layout) -> Result<(usize, usize)> {
    let [first, last] = value.pair()?;
    let (first, last) = (offset(&first)?, offset(&last)?);
    if first > last {
        return Err(value.out_of_range("[first, last] with first not after last"));
    }
    if last > layout.last() {
        return Err(layout.beyond(value, last));
    }
    match (at..at + CheckSpec::BYTES).find(|byte| (first..=last).contains(byte)) {
        // Such a check could be met by accident only.
        Some(byte) => {
            Err(value
                .because(format!("covers the check's own byte {byte}; end the range before it")))
        }
        None => Ok((first, last)),
    }
}

fn sequence(table: &Table<'_>, layout: &mut Layout) -> Result<SequenceSpec> {
    table.only(&["at", "bits", "modulus", "endian"])?;
    let bytes = whole_bytes(&table.required("bits")?)?;
    let place = table.required("at")?;
    let at = offset(&place)?;
    layout.claim(&place, at, bytes)?;
    let modulus = table.required("modulus")?.integer_in(2..=1_u64 << (8 * bytes))?;
    Ok(SequenceSpec { at, bytes, modulus, endian: endian(table, bytes)? })
}

fn fields(table: &Table<'_>, layout: &mut Layout) -> Result<Vec<FieldSpec>> {
    let declared = table.required("field")?;
    if declared.array()?.is_empty() {
        return Err(declared.out_of_range("at least one [[frame.field]]"));
    }
    let mut fields: Vec<FieldSpec> = Vec::new();
    for entry in table.tables("field", MAX_FIELDS)? {
        let read = field(&entry, layout)?;
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

fn field(table: &Table<'_>, layout: &mut Layout) -> Result<FieldSpec> {
    table.only(&[
        "name", "at", "bits", "endian", "coding", "null", "scale", "offset", "unit", "clip",
    ])?;
    let name = name(&table.required("name")?)?;
    let bytes = whole_bytes(&table.required("bits")?)?;
    let place = table.required("at")?;
    let at = offset(&place)?;
    layout.claim(&place, at, bytes)?;
    let coding = coding(table, bytes)?;
    let unit = table.required("unit")?.word(&UNITS)?;
    let scale = scale(table)?;
    let offset = match table.optional("offset") {
        Some(value) => value.number_in(-MAX_MAGNITUDE..=MAX_MAGNITUDE)?,
        None => 0.0,
    };
    let endian = endian(table, bytes)?;
    let clip = table.optional("clip").map(|value| clip(&value)).transpose()?;
    Ok(FieldSpec { name, at, bytes, endian, coding, unit, scale, offset, clip })
}

fn coding(table: &Table<'_>, bytes: usize) -> Result<Coding> {
    let null = match table.optional("null") {
        // The code must be able to say zero.
        Some(value) => value.integer_in(0..=u32::MAX >> (32 - 8 * bytes))?,
        None => 0,
    };
    let coding = table.required("coding")?.word(&[
        ("twos", Coding::Twos),
        ("unsigned", Coding::Unsigned),
        ("offset_binary", Coding::OffsetBinary { null }),
    ])?;
    match (coding, table.optional("null")) {
        (Coding::OffsetBinary { .. }, None) => table.required("null").map(|_| coding),
        (Coding::Twos | Coding::Unsigned, Some(null)) => {
            Err(null.out_of_range("no `null` at all, or coding = \"offset_binary\""))
        }
        _ => Ok(coding),
    }
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

fn flags(table: &Table<'_>, fields: &[FieldSpec]) -> Result<Vec<FlagSpec>> {
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
    if bit as usize >= fields[index].bits() {
        let expected = format!("0 to {}", fields[index].bits() - 1);
        return Err(table.required("bit")?.out_of_range(expected));
    }
    Ok(FlagSpec { name, field: index, bit })
}

fn line(table: &Table<'_>) -> Result<LineSpec> {
    table.only(&["baud", "data", "parity", "stop"])?;
    Ok(LineSpec {
        baud: table.required("baud")?.integer_in(50..=20_000_000)?,
        data: table.required("data")?.integer_in(8..=8)?,
        parity: table.required("parity")?.word(&PARITIES)?,
        stop: table.required("stop")?.integer_in(1..=2)?,
    })
}

fn timing(table: &Table<'_>) -> Result<TimingSpec> {
    table.only(&["rate_hz", "rate_tol"])?;
    Ok(TimingSpec {
        rate_hz: table.required("rate_hz")?.number_in(1e-3..=1e6)?,
        rate_tolerance: table.required("rate_tol")?.number_in(0.0..=0.5)?,
    })
}
