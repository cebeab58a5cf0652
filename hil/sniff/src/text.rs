//! Frames that are lines of text.

use crate::layout::Role;
use crate::length::as_f64;
use crate::motion::Motion;
use std::collections::BTreeMap;

/// Lines looked at, spread over the capture.
const LINES: usize = 4096;
/// A line longer than this is no frame.
const LINE_MAX: usize = 120;
const COLUMNS_MAX: usize = 16;

/// A layout in text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Lines {
    /// What every line begins with, before the first number; often empty.
    pub prefix: String,
    /// `' '` or `','`.
    pub separator: char,
    /// The columns behind the prefix.
    pub columns: Vec<Column>,
    /// Lines end in `*hh`, the XOR of what stands before.
    pub checked: bool,
}

/// A column of text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Column {
    /// What it seems to be; `None` for the frame counter.
    pub role: Option<Role>,
    /// Digits before the point, at most.
    pub digits: usize,
    /// Digits behind the point.
    pub decimals: usize,
    /// For a counter: it runs from 0 to this less one.
    pub modulus: u64,
    /// Hexadecimal.
    pub hex: bool,
}

/// Lines and how well they are borne out.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    pub(crate) lines: Lines,
    pub(crate) frames: usize,
    /// Share of lines that fit.
    pub(crate) share: f64,
    pub(crate) wraps: usize,
    /// Of the rate; full scale is what the digits can write.
    pub(crate) motion: Motion,
}

/// The lines, when the bytes are text.
pub(crate) fn find(bytes: &[u8]) -> Option<Found> {
    if !is_text(bytes) {
        return None;
    }
    let lines = whole_lines(bytes);
    let separator = if mean_count(&lines, ',') >= 1.0 { ',' } else { ' ' };
    let checked = 2 * lines.iter().filter(|line| unstarred(line).is_some()).count() > lines.len();
    let bodies: Vec<&str> = lines
        .iter()
        .filter_map(|line| if checked { unstarred(line) } else { Some(*line) })
        .collect();
    let prefix = prefix_of(&bodies, separator);
    let cells: Vec<Vec<&str>> =
        bodies.iter().filter_map(|body| cells_of(body.strip_prefix(&prefix)?, separator)).collect();
    let count = commonest(cells.iter().map(Vec::len))?;
    let rows: Vec<Vec<&str>> = cells.into_iter().filter(|cells| cells.len() == count).collect();
    let column = |k: usize| -> Vec<&str> { rows.iter().map(|row| row[k]).collect() };
    let mut columns: Vec<Column> =
        (0..count).map(|k| describe(&column(k))).collect::<Option<_>>()?;
    let (rate, motion) = name_rate(&mut columns, &rows)?;
    let wraps = name_counter(&mut columns, &rows, rate);
    let share = as_f64(rows.len()) / as_f64(lines.len().max(1));
    let found = Lines { prefix, separator, columns, checked };
    Some(Found { lines: found, frames: rows.len(), share, wraps, motion })
}

/// Share of the lines of `bytes` that `lines` describes.
pub(crate) fn share_in(lines: &Lines, bytes: &[u8]) -> f64 {
    let all = whole_lines(bytes);
    let fits = |line: &&&str| {
        let body = if lines.checked { unstarred(line) } else { Some(**line) };
        let cells = body
            .and_then(|body| body.strip_prefix(lines.prefix.as_str()))
            .and_then(|body| cells_of(body, lines.separator));
        cells.is_some_and(|cells| cells.len() == lines.columns.len())
    };
    as_f64(all.iter().filter(fits).count()) / as_f64(all.len().max(1))
}

fn is_text(bytes: &[u8]) -> bool {
    let printable = bytes.iter().filter(|b| matches!(b, b' '..=b'~' | b'\r' | b'\n')).count();
    let feeds = bytes.iter().filter(|byte| **byte == b'\n').count();
    100 * printable > 97 * bytes.len() && 100 * feeds >= bytes.len() && feeds >= 16
}

/// Lines without their ends. The first may have been cut, the last may go on.
fn whole_lines(bytes: &[u8]) -> Vec<&str> {
    let mut lines: Vec<&str> = bytes
        .split(|byte| *byte == b'\n')
        .filter_map(|line| str::from_utf8(line.strip_suffix(b"\r").unwrap_or(line)).ok())
        .skip(1)
        .collect();
    lines.pop();
    lines.retain(|line| !line.is_empty() && line.len() <= LINE_MAX);
    let count = lines.len().min(LINES);
    let all = lines.len();
    // In thirty-twos, so that counters can be followed.
    let keep = |k: usize| all <= LINES || (k / 32) * count / all != (k / 32 + 1) * count / all;
    lines.into_iter().enumerate().filter(|(k, _)| keep(*k)).map(|(_, line)| line).collect()
}

fn mean_count(lines: &[&str], sought: char) -> f64 {
    let found: usize = lines.iter().map(|line| line.matches(sought).count()).sum();
    as_f64(found) / as_f64(lines.len().max(1))
}

/// The line before a star and the right check.
fn unstarred(line: &str) -> Option<&str> {
    let (body, stored) = line.rsplit_once('*')?;
    let stored =
        if stored.len() == 2 { u8::from_str_radix(stored, 16).ok()? } else { return None };
    let covered = body.strip_prefix('$').unwrap_or(body);
    (covered.bytes().fold(0, |a, b| a ^ b) == stored).then_some(body)
}

/// Text that opens the lines and is no number: a dollar sign, or a word and its separator.
fn prefix_of(bodies: &[&str], separator: char) -> String {
    let first = |body: &&str| body.split(separator).next().map(str::to_owned);
    let Some(word) = commonest(bodies.iter().filter_map(first)) else { return String::new() };
    let usual = 2 * bodies.iter().filter(|body| body.starts_with(&word)).count() > bodies.len();
    if usual && !word.is_empty() && is_number(&word).is_none() {
        return format!("{word}{separator}");
    }
    let dollars = bodies.iter().filter(|body| body.starts_with('$')).count();
    if 10 * dollars > 9 * bodies.len() { "$".to_owned() } else { String::new() }
}

fn cells_of(body: &str, separator: char) -> Option<Vec<&str>> {
    let cells: Vec<&str> = if separator == ' ' {
        body.split_ascii_whitespace().collect()
    } else {
        body.split(separator).map(str::trim).collect()
    };
    let good = !cells.is_empty() && cells.len() <= COLUMNS_MAX;
    (good && cells.iter().all(|cell| is_number(cell).is_some())).then_some(cells)
}

/// Digits before and behind the point, and whether it is hexadecimal.
fn is_number(cell: &str) -> Option<(usize, usize, bool)> {
    let digits = cell.strip_prefix(['-', '+']).unwrap_or(cell);
    let (whole, part) = digits.split_once('.').unwrap_or((digits, ""));
    let decimal = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    if decimal(whole) && decimal(part) && whole.len() + part.len() > 0 {
        return Some((whole.len().max(1), part.len(), false));
    }
    let hex = digits.bytes().all(|byte| byte.is_ascii_hexdigit()) && digits.len() <= 8;
    (hex && digits == cell && !digits.is_empty()).then_some((digits.len(), 0, true))
}

fn describe(cells: &[&str]) -> Option<Column> {
    let shapes = || cells.iter().filter_map(|cell| is_number(cell));
    let decimals = commonest(shapes().map(|(_, decimals, _)| decimals))?;
    let digits = shapes().filter(|shape| shape.1 == decimals).map(|shape| shape.0).max()?;
    let hex = shapes().any(|(.., hex)| hex) && decimals == 0;
    Some(Column { role: Some(Role::Unknown), digits, decimals, modulus: 0, hex })
}

/// The rate is the column with a decimal point that moves most, or else the one that does.
fn name_rate(columns: &mut [Column], rows: &[Vec<&str>]) -> Option<(usize, Motion)> {
    let pointed = columns.iter().any(|column| column.decimals > 0);
    let mut best: Option<(usize, Motion)> = None;
    for (k, column) in columns.iter().enumerate() {
        if column.hex || (pointed && column.decimals == 0) {
            continue;
        }
        let values: Vec<f64> = rows.iter().filter_map(|row| row[k].parse().ok()).collect();
        let full = 10f64.powi(i32::try_from(column.digits).unwrap_or(9));
        let motion = Motion::of(&values, 2.0 * full);
        if best.is_none_or(|(_, least)| motion.excursion > least.excursion) {
            best = Some((k, motion));
        }
    }
    let (rate, motion) = best?;
    columns[rate].role = Some(Role::Rate);
    for column in columns.iter_mut().filter(|column| column.role == Some(Role::Unknown)) {
        let short = column.decimals == 0 && column.digits <= 2;
        column.role = Some(if short { Role::Status } else { Role::Unknown });
    }
    Some((rate, motion))
}

/// Finds the counter among the whole numbers; returns how often it went back to zero.
fn name_counter(columns: &mut [Column], rows: &[Vec<&str>], rate: usize) -> usize {
    for (k, column) in columns.iter_mut().enumerate() {
        if k == rate || column.decimals > 0 || column.hex {
            continue;
        }
        let values: Vec<u64> = rows.iter().filter_map(|row| row[k].parse().ok()).collect();
        let mut returns: BTreeMap<u64, usize> = BTreeMap::new();
        let mut by_one = 0;
        for pair in values.windows(2) {
            by_one += usize::from(pair[0].checked_add(1) == Some(pair[1]));
            if pair[1] == 0 && pair[0] > 0 {
                *returns.entry(pair[0]).or_default() += 1;
            }
        }
        if 10 * by_one <= 7 * values.len() {
            continue;
        }
        let last = returns.iter().max_by_key(|(_, count)| **count).map(|(last, _)| *last);
        let written = 10u64.saturating_pow(u32::try_from(column.digits).unwrap_or(9));
        let modulus = last.map_or_else(|| written.max(65_536), |last| last + 1);
        (column.role, column.modulus) = (None, modulus.clamp(2, 1 << 32));
        return returns.values().sum();
    }
    0
}

fn commonest<T: Ord>(values: impl Iterator<Item = T>) -> Option<T> {
    let mut counts: BTreeMap<T, usize> = BTreeMap::new();
    for value in values {
        *counts.entry(value).or_default() += 1;
    }
    counts.into_iter().max_by_key(|(_, count)| *count).map(|(value, _)| value)
}
