//! A proposal as the text of a frame file.

use crate::layout::{Check, CheckKind, Coding, Counter, Field, Kind, Layout, Role};
use crate::report::{Proposal, Shape};
use crate::text::{Column, Lines};
use crate::word::{ParityWord, SYNC_MASK};
use std::fmt::{self, Write};

/// What a frame file holds that the bytes do not.
#[derive(Debug, Clone, PartialEq)]
pub struct Labels {
    /// Name of the layout, as `lab/unknown-gyro@1`. Characters that a name cannot have become `-`.
    pub name: String,
    /// Baud rate of the line; if not known, the lowest usual one that carries the frames.
    pub baud: Option<u32>,
    /// Frames per second; if not known, 100 with a remark.
    pub rate_hz: Option<f64>,
    /// The layout was confirmed on a device, not only guessed.
    pub measured: bool,
}

/// Baud rates in use.
const BAUDS: [u32; 13] = [
    9600, 19_200, 38_400, 57_600, 115_200, 230_400, 250_000, 460_800, 500_000, 614_400, 921_600,
    1_000_000, 2_000_000,
];
const BITS_PER_BYTE: f64 = 10.0;
const NAME_MAX: usize = 64;

impl Proposal {
    /// The text of a frame file; `None` when no frame file can say it: a binary frame without a
    /// sync word, or without a field.
    #[must_use]
    pub fn to_toml(&self, labels: &Labels) -> Option<String> {
        if let Shape::Binary(layout) = &self.shape
            && (layout.sync.is_empty() || layout.fields.is_empty())
        {
            return None;
        }
        let mut text = String::new();
        // Writing to a String cannot fail.
        write_file(&mut text, self, labels).ok()?;
        Some(text)
    }
}

fn write_file(out: &mut String, proposal: &Proposal, labels: &Labels) -> fmt::Result {
    writeln!(out, "# Found by `struna frame sniff` from captured bytes.")?;
    writeln!(out, "#")?;
    writeln!(
        out,
        "# SCALE AND SIGN ARE NOT KNOWN: scale = 1 counts. Turn the gyro by a known angle"
    )?;
    writeln!(out, "# (360 deg on a table), add up the rate counts from start to stop and write")?;
    writeln!(out, "#     scale = angle * rate_hz / sum of counts, unit = \"deg/s\"")?;
    writeln!(out, "# A negative result means that the positive direction is the other one.")?;
    writeln!(out)?;
    writeln!(out, "[frame]")?;
    writeln!(out, "name = \"{}\"", clean(&labels.name))?;
    match &proposal.shape {
        Shape::Binary(layout) => write_binary(out, layout, labels.measured)?,
        Shape::Lines(lines) => write_lines(out, lines, labels.measured)?,
        Shape::Word(word) => write_word(out, *word, labels.measured)?,
    }
    let len = match &proposal.shape {
        Shape::Lines(lines) => crate::length::as_f64(longest(lines)),
        other => proposal.mean_len_of(other),
    };
    write_line(out, len, labels)
}

impl Proposal {
    fn mean_len_of(&self, shape: &Shape) -> f64 {
        match shape {
            Shape::Binary(layout) => crate::length::as_f64(layout.len),
            _ => self.mean_len(0).max(4.0),
        }
    }
}

fn clean(name: &str) -> String {
    let good = |c: char| c.is_ascii_graphic() && !matches!(c, '"' | '\'' | '\\');
    let mut name: String =
        name.chars().take(NAME_MAX).map(|c| if good(c) { c } else { '-' }).collect();
    if name.is_empty() {
        name.push_str("sniffed");
    }
    name
}

fn write_provenance(out: &mut String, measured: bool) -> fmt::Result {
    writeln!(out, "provenance = \"{}\"", if measured { "measured" } else { "unverified" })
}

fn write_binary(out: &mut String, layout: &Layout, measured: bool) -> fmt::Result {
    let kind = if layout.kind == Kind::Septet { "septet" } else { "fixed" };
    writeln!(out, "kind = \"{kind}\"")?;
    write_provenance(out, measured)?;
    let sync: Vec<String> = layout.sync.iter().map(|byte| format!("{byte:02X}")).collect();
    writeln!(out, "sync = \"{}\"\nlen = {}", sync.join(" "), layout.len)?;
    write_check(out, layout.check.as_ref())?;
    if let Some(counter) = &layout.counter {
        write_counter(out, counter, layout.kind)?;
    }
    // A condition names a field above it.
    let channels = layout.fields.iter().filter(|field| field.role == Role::Channel);
    let others = layout.fields.iter().filter(|field| field.role != Role::Channel);
    let mut unknown = 0;
    for field in channels.chain(others) {
        write_field(out, field, layout.kind, &mut unknown)?;
    }
    Ok(())
}

fn write_check(out: &mut String, check: Option<&Check>) -> fmt::Result {
    writeln!(out, "\n[frame.check]")?;
    let Some(check) = check else { return writeln!(out, "kind = \"none\"") };
    match check.kind {
        CheckKind::Sum8 => writeln!(out, "kind = \"sum8\"")?,
        CheckKind::NegSum8 => writeln!(out, "kind = \"negsum8\"")?,
        CheckKind::Xor8 => writeln!(out, "kind = \"xor8\"")?,
        CheckKind::Crc(crc) => {
            let digits = crc.width as usize / 4;
            let (name, reflected) = (crc.name, crc.reflected);
            writeln!(out, "kind = \"crc{}\" # {name}", crc.width)?;
            writeln!(out, "poly = 0x{:0digits$X}\ninit = 0x{:0digits$X}", crc.poly, crc.init)?;
            writeln!(out, "refin = {reflected}\nrefout = {reflected}")?;
            writeln!(out, "xorout = 0x{:0digits$X}", crc.xorout)?;
        }
    }
    writeln!(out, "range = [{}, {}]\nat = {}", check.first, check.last, check.at)?;
    if check.kind.bytes() > 1 {
        write_endian(out, check.big_endian)?;
    }
    Ok(())
}

fn write_endian(out: &mut String, big_endian: bool) -> fmt::Result {
    writeln!(out, "endian = \"{}\"", if big_endian { "be" } else { "le" })
}

fn write_size(out: &mut String, kind: Kind, bytes: usize, big_endian: bool) -> fmt::Result {
    match kind {
        Kind::Septet => writeln!(out, "septets = {bytes}")?,
        Kind::Fixed => writeln!(out, "bits = {}", 8 * bytes)?,
    }
    if bytes > 1 { write_endian(out, big_endian) } else { Ok(()) }
}

fn write_counter(out: &mut String, counter: &Counter, kind: Kind) -> fmt::Result {
    writeln!(out, "\n[frame.seq]\nat = {}", counter.at)?;
    write_size(out, kind, counter.bytes, counter.big_endian)?;
    writeln!(out, "modulus = {}", counter.modulus)
}

/// The name that a field of this role gets.
pub(crate) fn name_of(role: Role) -> &'static str {
    match role {
        Role::Rate => "rate",
        Role::Temperature => "temp",
        Role::Status => "status",
        Role::Channel => "chan",
        Role::Unknown => "unknown",
    }
}

/// The first of each role keeps the plain name.
fn write_name(out: &mut String, role: Role, seen: &mut u32) -> fmt::Result {
    let bit = 1 << role as u32;
    let plain = *seen & bit == 0;
    *seen |= bit;
    if plain && role != Role::Unknown {
        return writeln!(out, "name = \"{}\"", name_of(role));
    }
    // The count of numbered names stands in the upper half.
    *seen += 1 << 16;
    writeln!(out, "name = \"{}{}\"", name_of(role), *seen >> 16)
}

fn write_field(out: &mut String, field: &Field, kind: Kind, seen: &mut u32) -> fmt::Result {
    writeln!(out, "\n[[frame.field]]")?;
    write_name(out, field.role, seen)?;
    writeln!(out, "at = {}", field.at)?;
    let whole = field.shift == 0 && usize::try_from(field.bits) == Ok(8 * field.bytes);
    if whole || kind == Kind::Septet {
        write_size(out, kind, field.bytes, field.big_endian)?;
    } else {
        writeln!(out, "bytes = {}\nbits = {}", field.bytes, field.bits)?;
        if field.shift > 0 {
            writeln!(out, "shift = {}", field.shift)?;
        }
        if field.bytes > 1 {
            write_endian(out, field.big_endian)?;
        }
    }
    match field.coding {
        Coding::Twos => writeln!(out, "coding = \"twos\"")?,
        Coding::Unsigned => writeln!(out, "coding = \"unsigned\"")?,
        Coding::Float => writeln!(out, "coding = \"float\"")?,
        Coding::OffsetBinary => {
            let null = 1u64 << (field.bits - 1);
            writeln!(out, "coding = \"offset_binary\"\nnull = {null}")?;
        }
    }
    if field.only_channel_zero {
        writeln!(out, "when = {{ field = \"chan\", equals = 0 }}")?;
    }
    writeln!(out, "scale = 1.0\nunit = \"counts\"")
}

fn write_lines(out: &mut String, lines: &Lines, measured: bool) -> fmt::Result {
    writeln!(out, "kind = \"ascii\"")?;
    write_provenance(out, measured)?;
    if !lines.prefix.is_empty() {
        let hex: Vec<String> = lines.prefix.bytes().map(|byte| format!("{byte:02X}")).collect();
        writeln!(out, "sync = \"{}\" # {}", hex.join(" "), lines.prefix.trim_end())?;
    }
    writeln!(out, "separator = \"{}\"\ncolumns = {}", lines.separator, lines.columns.len())?;
    let check = if lines.checked { "xor8" } else { "none" };
    writeln!(out, "\n[frame.check]\nkind = \"{check}\"")?;
    for (k, column) in lines.columns.iter().enumerate().filter(|(_, c)| c.role.is_none()) {
        writeln!(out, "\n[frame.seq]\ncolumn = {k}\nmodulus = {}", column.modulus)?;
    }
    let mut seen = 0;
    for (k, column) in lines.columns.iter().enumerate() {
        let Some(role) = column.role else { continue };
        writeln!(out, "\n[[frame.field]]")?;
        write_name(out, role, &mut seen)?;
        writeln!(out, "column = {k}")?;
        write_digits(out, column)?;
        writeln!(out, "scale = 1.0\nunit = \"counts\"")?;
    }
    Ok(())
}

fn write_digits(out: &mut String, column: &Column) -> fmt::Result {
    if column.hex {
        return writeln!(out, "coding = \"hex\"\ndigits = {}", column.digits);
    }
    writeln!(out, "coding = \"decimal\"\ndigits = {}", column.digits)?;
    if column.decimals > 0 {
        writeln!(out, "decimals = {}", column.decimals)?;
    }
    Ok(())
}

/// Bytes of the longest line: signs, points and separators included.
fn longest(lines: &Lines) -> usize {
    let cells: usize = lines.columns.iter().map(|c| c.digits + c.decimals + 3).sum();
    lines.prefix.len() + cells + 5
}

fn write_word(out: &mut String, word: ParityWord, measured: bool) -> fmt::Result {
    writeln!(out, "kind = \"fixed\"")?;
    write_provenance(out, measured)?;
    writeln!(out, "sync = \"{:02X}\"\nsync_mask = \"{SYNC_MASK:02X}\"\nlen = 4", word.sync)?;
    let parity = if word.odd { "odd" } else { "even" };
    writeln!(
        out,
        "\n[frame.check]\nkind = \"parity\"\nrange = [0, 3]\nword_parity = \"{parity}\""
    )?;
    for (name, shift, bits) in [("status", 7, 1), ("type", 3, 2)] {
        writeln!(out, "\n[[frame.field]]\nname = \"{name}\"\nat = 0\nbytes = 1")?;
        writeln!(out, "shift = {shift}\nbits = {bits}\ncoding = \"unsigned\"\nunit = \"counts\"")?;
    }
    writeln!(out, "\n[[frame.field]]\nname = \"rate\"\nat = 0\nbytes = 4\nbits = 26")?;
    writeln!(out, "endian = \"be\"\ncoding = \"twos\"\nscale = 1.0\nunit = \"counts\"")
}

fn write_line(out: &mut String, len: f64, labels: &Labels) -> fmt::Result {
    let known = labels.rate_hz.filter(|rate| rate.is_finite() && *rate > 0.0);
    let rate_hz = known.unwrap_or(100.0);
    let needed = len * BITS_PER_BYTE * rate_hz;
    let carries = |baud: &u32| f64::from(*baud) >= needed;
    let baud = labels.baud.filter(carries).or_else(|| BAUDS.into_iter().find(carries));
    let guessed = labels.baud.is_none();
    let remark =
        if guessed { " # not known: the lowest usual one that carries the frames" } else { "" };
    writeln!(out, "\n[line]\nbaud = {}{remark}", baud.unwrap_or(4_000_000))?;
    writeln!(out, "data = 8\nparity = \"none\"\nstop = 1")?;
    let remark = if known.is_none() { " # not known: time the capture" } else { "" };
    writeln!(out, "\n[timing]\nrate_hz = {rate_hz:?}{remark}\nrate_tol = 0.05")
}
