//! `struna frame`.

use super::{Outcome, print};
use crate::cli::Frame;
use crate::frames::{SHIPPED, frame_named_or_file, judged};
use anyhow::{Result, bail};
use std::fmt::Write;
use struna_wire::{
    CheckKind, Coding, FieldSpec, FrameSpec, Lint, Load, Parity, Provenance, TimeSource, Undetected,
};

pub(super) fn execute(command: &Frame) -> Result<Outcome> {
    match command {
        Frame::List => list(),
        Frame::Lint(args) => lint(&args.frames),
        Frame::Sniff(args) => super::sniff::execute(args),
    }
}

fn list() -> Result<Outcome> {
    let mut rows = vec![["name", "kind", "bytes", "rate", "line", "fields"].map(str::to_owned)];
    for (name, _) in SHIPPED {
        let spec = frame_named_or_file(name)?;
        let fields: Vec<_> = spec.fields().iter().map(FieldSpec::name).collect();
        rows.push([
            name.to_owned(),
            spec.kind().name().to_owned(),
            spec.wire_len().to_string(),
            format!("{} Hz", spec.timing().rate_hz),
            line(&spec),
            fields.join(" "),
        ]);
    }
    print(&columns(&rows))?;
    Ok(Outcome::Complete)
}

/// Cells in columns, two blanks apart.
fn columns<const N: usize>(rows: &[[String; N]]) -> String {
    let mut widths = [0; N];
    for row in rows {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.chars().count());
        }
    }
    let mut text = String::new();
    for row in rows {
        let padded = row.iter().zip(widths).map(|(cell, width)| format!("{cell:<width$}  "));
        text += padded.collect::<String>().trim_end();
        text.push('\n');
    }
    text
}

/// Prints what is to be said of each layout; those that are refused are named together at the end.
fn lint(frames: &[String]) -> Result<Outcome> {
    let mut refusals = Vec::new();
    for name in frames {
        match judged(name, Lint::of) {
            Ok(lint) => print(&report(&lint)?)?,
            Err(refusal) => refusals.push(refusal.to_string()),
        }
    }
    if !refusals.is_empty() {
        bail!(refusals.join("\nstruna: "));
    }
    Ok(Outcome::Complete)
}

fn line(spec: &FrameSpec) -> String {
    let line = spec.line();
    let parity = match line.parity {
        Parity::None => 'N',
        Parity::Even => 'E',
        Parity::Odd => 'O',
    };
    format!("{} baud {}{parity}{}", line.baud, line.data, line.stop)
}

fn report(lint: &Lint) -> Result<String, std::fmt::Error> {
    let spec = &lint.spec;
    let (timing, evidence) = (spec.timing(), spec.evidence());
    let mut text = format!("{}  {}\n", spec.name(), provenance(spec.provenance()));
    let time = match timing.time {
        TimeSource::Counter => "counter",
        TimeSource::Arrival => "arrival",
    };
    writeln!(text, "  frame       {}, {} bytes on the wire", spec.kind().name(), spec.wire_len())?;
    writeln!(text, "  check       {}", check(spec, lint.undetected))?;
    writeln!(
        text,
        "  rate        {} Hz +-{} %, time by {time}",
        timing.rate_hz,
        100.0 * timing.rate_tolerance
    )?;
    writeln!(text, "  line        {}, {:.0} bit/s needed", line(spec), spec.bits_per_s())?;
    for load in &lint.loads {
        writeln!(text, "    {}", one_load(load, spec.line().baud))?;
    }
    writeln!(
        text,
        "  evidence    {:.1} bits a frame ({:.1} framing, {:.1} check), {:.1} more in each after",
        evidence.frame_bits(),
        evidence.framing_bits,
        evidence.check_bits,
        evidence.following_bits
    )?;
    writeln!(
        text,
        "  believed    {} in a row: noise passes with {:.1e} per byte, {:.1e} per hour",
        evidence.confirm,
        evidence.false_accepts_per_byte(),
        lint.false_frames_per_hour
    )?;
    text += &fields(spec);
    for blind in &lint.blind_spots {
        writeln!(text, "  cannot show: {blind}")?;
    }
    for warning in &lint.warnings {
        writeln!(text, "  warning: {warning}")?;
    }
    text.push('\n');
    Ok(text)
}

const fn provenance(provenance: Provenance) -> &'static str {
    match provenance {
        Provenance::Unverified => "UNVERIFIED: invented or guessed",
        Provenance::Published => "published",
        Provenance::Measured => "measured",
        _ => "of unknown origin",
    }
}

fn one_load(load: &Load, declared: u32) -> String {
    let mark = match (load.share > 1.0, load.baud == declared) {
        (true, _) => "  TOO SLOW",
        (false, true) => "  as declared",
        (false, false) => "",
    };
    format!("{:>8} baud {:>5.0} %{mark}", load.baud, 100.0 * load.share)
}

fn check(spec: &FrameSpec, undetected: Undetected) -> String {
    let (first, last) = spec.check().range();
    let what = match spec.check().kind() {
        CheckKind::None => return "none: no damage is seen".to_owned(),
        CheckKind::Sum8 => "sum".to_owned(),
        CheckKind::NegSum8 => "negative sum".to_owned(),
        CheckKind::Xor8 => "exclusive or".to_owned(),
        CheckKind::Crc(crc) => format!("CRC-{} {:#X}", crc.width, crc.poly),
        CheckKind::Parity { odd } => format!("{} parity", if odd { "odd" } else { "even" }),
        _ => "unknown".to_owned(),
    };
    let covered = match spec.separator() {
        Some(_) => "all before the star".to_owned(),
        None => format!("bytes {first} to {last}"),
    };
    let unseen = match undetected {
        Undetected::WrongBits(bits) => format!("Hamming distance {bits}"),
        Undetected::AtLeast(bits) => format!("Hamming distance {bits} or more"),
        _ => "sees nothing".to_owned(),
    };
    format!("{what} over {covered}, {} bits: {unseen}", spec.check().bits())
}

fn fields(spec: &FrameSpec) -> String {
    let mut rows = vec![["  field", "LSB", "range", "carried"].map(str::to_owned)];
    for field in spec.fields() {
        let unit = field.unit().name();
        let range = match field.code_range() {
            Some([least, greatest]) => format!("{least} to {greatest} {unit}"),
            None => format!("any {unit}"),
        };
        let clip = field.clip_si().map(|clip| {
            let in_file = clip.map(|si| si / (field.scale_si() / field.scale()));
            format!(", clipped to {} to {}", round(in_file[0]), round(in_file[1]))
        });
        let carried = match field.when() {
            Some((decider, value)) => {
                format!("when {} = {value}", spec.fields()[decider].name())
            }
            None => "always".to_owned(),
        };
        let usable = field.valid_if().map(|flag| format!(", if {}", spec.flags()[flag].name()));
        let lsb = match field.coding() {
            Coding::Float => "float".to_owned(),
            _ => format!("{} {unit}", field.scale().abs()),
        };
        rows.push([
            format!("  {}", field.name()),
            lsb,
            range + &clip.unwrap_or_default(),
            carried + &usable.unwrap_or_default(),
        ]);
    }
    columns(&rows)
}

/// Takes back what the way through radians did to the last digits.
fn round(number: f64) -> f64 {
    (number * 1e9).round() / 1e9
}
