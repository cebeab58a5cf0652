//! From the text of a frame file to a consistent [`FrameSpec`].

mod check;
mod field;
mod framing;
mod layout;

use crate::evidence::Evidence;
use crate::{
    Endian, FieldSpec, FrameSpec, LineSpec, MAX_CONFIRM, Parity, PlausibleSpec, Provenance,
    TimeSource, TimingSpec,
};
use framing::Frame;
use struna_settings::{Result, Table, Value};

const ENDIANS: [(&str, Endian); 2] = [("be", Endian::Big), ("le", Endian::Little)];
const PARITIES: [(&str, Parity); 3] =
    [("none", Parity::None), ("even", Parity::Even), ("odd", Parity::Odd)];
const PROVENANCES: [(&str, Provenance); 3] = [
    ("unverified", Provenance::Unverified),
    ("published", Provenance::Published),
    ("measured", Provenance::Measured),
];
const TIMES: [(&str, TimeSource); 2] =
    [("counter", TimeSource::Counter), ("arrival", TimeSource::Arrival)];
/// Keys of `[frame]` that every kind has.
const FRAME_KEYS: [&str; 8] =
    ["name", "kind", "provenance", "check", "seq", "field", "flag", "plausible"];
const MAX_NAME_LEN: usize = 64;

pub(crate) fn frame_spec(text: &str) -> Result<FrameSpec> {
    struna_settings::read(text, from_root)
}

/// The layout that the file with this root declares.
pub(crate) fn from_root(root: &Table<'_>) -> Result<FrameSpec> {
    root.only(&["frame", "line", "timing"])?;
    let line = line(&root.required("line")?.table()?)?;
    let timing_table = root.required("timing")?.table()?;
    let spec = frame(&root.required("frame")?.table()?, line, &timing_table)?;
    let needed_baud = spec.bits_per_s();
    if needed_baud > f64::from(spec.line.baud) {
        let rate = timing_table.required("rate_hz")?;
        return Err(rate.because(format!(
            "frames at this rate need {needed_baud:.0} baud; raise `line.baud` or lower \
             `timing.rate_hz`"
        )));
    }
    Ok(spec)
}

fn frame(table: &Table<'_>, line: LineSpec, timing_table: &Table<'_>) -> Result<FrameSpec> {
    let kind = framing::kind(table)?;
    let known: Vec<_> = FRAME_KEYS.iter().chain(framing::keys(kind)).copied().collect();
    table.only(&known)?;
    let name = name(&table.required("name")?)?;
    let provenance = table.required("provenance")?.word(&PROVENANCES)?;
    let Frame { sync, mask, len, text, mut layout } = framing::frame(table, kind)?;
    let check_table = table.required("check")?.table()?;
    let check = check::check(&check_table, kind, &mut layout)?;
    let sequence = match table.optional("seq") {
        Some(seq) => Some(field::sequence(&seq.table()?, kind, &mut layout)?),
        None => None,
    };
    let mut fields = field::fields(table, kind, &mut layout)?;
    let flags = field::flags(table, &fields)?;
    field::resolve_valid_if(table, &mut fields, &flags)?;
    let check = check::with_parity_bit(&check_table, check, &mut layout)?;
    let framing = framing::framing(table, kind, mask, text, (&sync, &check, &fields, sequence))?;
    let (plausible, confirm) = plausible(table, &fields)?;
    let evidence =
        Evidence::of((&framing, &sync, len), &check, sequence.as_ref(), &fields, plausible);
    let evidence = confirm.map_or(evidence, |confirm| evidence.with_confirm(confirm));
    let timing = timing(timing_table, sequence.is_some())?;
    Ok(FrameSpec {
        name,
        provenance,
        framing,
        sync,
        len,
        fields,
        flags,
        check,
        sequence,
        plausible,
        evidence,
        line,
        timing,
    })
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

/// Byte order; one byte has none, so there it may be left out.
fn endian(table: &Table<'_>, bytes: usize) -> Result<Endian> {
    match table.optional("endian") {
        Some(value) => value.word(&ENDIANS),
        None if bytes == 1 => Ok(Endian::Big),
        None => table.required("endian")?.word(&ENDIANS),
    }
}

/// The gate on the rate, and the number of frames in a row that the file demands.
fn plausible(
    table: &Table<'_>,
    fields: &[FieldSpec],
) -> Result<(Option<PlausibleSpec>, Option<usize>)> {
    let Some(plausible) = table.optional("plausible") else { return Ok((None, None)) };
    let plausible = plausible.table()?;
    plausible.only(&["rate_step_max", "confirm"])?;
    let confirm = match plausible.optional("confirm") {
        Some(value) => Some(value.integer_in(1..=MAX_CONFIRM)?),
        None => None,
    };
    let Some(step) = plausible.optional("rate_step_max") else { return Ok((None, confirm)) };
    let step_max = step.positive()?;
    let Some(field) = fields.iter().position(|field| field.name == "rate") else {
        return Err(step.because("there is no field called rate; name one so or remove this key"));
    };
    // In the field's own unit, whatever that is in SI.
    let step_max_si = step_max * (fields[field].scale_si() / fields[field].scale);
    Ok((Some(PlausibleSpec { field, step_max_si }), confirm))
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

fn timing(table: &Table<'_>, has_counter: bool) -> Result<TimingSpec> {
    table.only(&["rate_hz", "rate_tol", "time"])?;
    let time = match table.optional("time") {
        None if has_counter => TimeSource::Counter,
        None => TimeSource::Arrival,
        Some(value) => {
            let time = value.word(&TIMES)?;
            if time == TimeSource::Counter && !has_counter {
                let reason = "the frame has no counter; write \"arrival\" or declare [frame.seq]";
                return Err(value.because(reason));
            }
            time
        }
    };
    Ok(TimingSpec {
        rate_hz: table.required("rate_hz")?.number_in(1e-3..=1e6)?,
        rate_tolerance: table.required("rate_tol")?.number_in(0.0..=0.5)?,
        time,
    })
}
