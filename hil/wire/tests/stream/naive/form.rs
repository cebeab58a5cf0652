//! What has the form of a frame, kind by kind.

use struna_wire::{Coding, FieldSpec, FrameSpec, Kind};

/// What stands at the front.
pub(crate) enum Front {
    Short,
    Broken(usize),
    Whole(Vec<u8>, usize),
}

/// Most bytes of a frame: a line may have sixteen blanks that are not sent.
pub(crate) fn longest(spec: &FrameSpec) -> usize {
    spec.wire_len() + if spec.separator() == Some(b' ') { 16 } else { 0 }
}

fn is_start(spec: &FrameSpec, rest: &[u8]) -> bool {
    rest.iter().zip(spec.sync()).enumerate().all(|(k, (byte, sync))| {
        let mask = spec.sync_mask().get(k).copied().unwrap_or(0xFF);
        (byte ^ sync) & mask == 0
    })
}

/// The form of what stands at the front, where a frame may begin.
pub(crate) fn front(spec: &FrameSpec, rest: &[u8]) -> Front {
    let len = spec.frame_len();
    match spec.kind() {
        Kind::Fixed if !is_start(spec, rest) => Front::Broken(1),
        Kind::Fixed => match rest.get(..len) {
            Some(frame) => Front::Whole(frame.to_vec(), len),
            None => Front::Short,
        },
        Kind::Septet if !is_start(spec, rest) => Front::Broken(1),
        Kind::Septet => match rest.get(..len) {
            Some(frame) if frame[1..].iter().any(|byte| *byte > 0x7F) => Front::Broken(1),
            Some(frame) => Front::Whole(frame.to_vec(), len),
            None => Front::Short,
        },
        Kind::Cobs => cobs(rest, len),
        _ => line(spec, rest),
    }
}

fn cobs(rest: &[u8], len: usize) -> Front {
    match rest.iter().take(len + 2).position(|byte| *byte == 0) {
        None if rest.len() < len + 2 => Front::Short,
        None => Front::Broken(1),
        Some(zero) => match uncobs(&rest[..zero]).filter(|content| content.len() == len) {
            Some(content) => Front::Whole(content, zero + 1),
            None => Front::Broken(zero + 1),
        },
    }
}

/// The textbook: a code byte tells how far the next zero is; the last zero is not there.
fn uncobs(coded: &[u8]) -> Option<Vec<u8>> {
    let (mut content, mut left, mut code) = (Vec::new(), 0, 0xFF);
    for byte in coded {
        if left == 0 {
            if code != 0xFF {
                content.push(0);
            }
            (code, left) = (*byte, *byte - 1);
        } else {
            content.push(*byte);
            left -= 1;
        }
    }
    (left == 0).then_some(content)
}

fn line(spec: &FrameSpec, rest: &[u8]) -> Front {
    match rest.iter().take(longest(spec)).position(|byte| *byte == b'\n') {
        None if rest.len() < longest(spec) => Front::Short,
        None => Front::Broken(1),
        Some(end) => match std::str::from_utf8(&rest[..end]).ok().and_then(|l| columns(spec, l)) {
            Some(record) => Front::Whole(record, end + 1),
            None => Front::Broken(end + 1),
        },
    }
}

fn columns(spec: &FrameSpec, line: &str) -> Option<Vec<u8>> {
    let prefix = std::str::from_utf8(spec.sync()).expect("a printable prefix");
    let line = line.strip_suffix('\r').unwrap_or(line);
    let mut body = line.strip_prefix(prefix)?;
    if spec.check().bits() > 0 {
        let star = line.len().checked_sub(3)?;
        let text = line.get(star..)?.strip_prefix('*')?;
        let covered = line.get(..star)?;
        let covered = covered.strip_prefix('$').unwrap_or(covered);
        let xor = covered.bytes().fold(0, |xor, byte| xor ^ byte);
        if text.starts_with('+') || u8::from_str_radix(text, 16) != Ok(xor) {
            return None;
        }
        body = line.get(prefix.len()..star)?;
    }
    let blank = spec.separator() == Some(b' ');
    let cells: Vec<&str> = if blank {
        body.split(' ').filter(|cell| !cell.is_empty()).collect()
    } else {
        body.split(',').collect()
    };
    if cells.len() != spec.frame_len() / 8 {
        return None;
    }
    let mut record = Vec::new();
    for (k, cell) in cells.iter().enumerate() {
        record.extend(value(spec, k, cell)?.to_be_bytes());
    }
    Some(record)
}

fn value(spec: &FrameSpec, column: usize, cell: &str) -> Option<i64> {
    let field = spec.fields().iter().find(|field| field.at() == 8 * column);
    let counter = spec.sequence().filter(|seq| seq.at() == 8 * column);
    let (digits, decimals) = match (field.map(FieldSpec::coding), counter) {
        (Some(Coding::Decimal { digits, decimals }), _) => (digits, decimals),
        (Some(Coding::Hex { digits }), _) => {
            let fits = cell.len() == digits as usize && !cell.starts_with(['+', '-']);
            return fits.then(|| i64::from_str_radix(cell, 16).ok()).flatten();
        }
        (None, Some(seq)) => ((seq.modulus() - 1).ilog10() + 1, 0),
        _ => return cell.bytes().all(|c| c.is_ascii_graphic()).then_some(0),
    };
    let (whole, fraction) = if decimals == 0 { (cell, "") } else { cell.split_once('.')? };
    let figures = whole.strip_prefix('-').unwrap_or(whole);
    let plain = |text: &str| text.bytes().all(|c| c.is_ascii_digit());
    let good = (1..=digits as usize).contains(&figures.len())
        && fraction.len() == decimals as usize
        && plain(figures)
        && plain(fraction);
    good.then(|| format!("{whole}{fraction}").parse().ok()).flatten()
}

/// Bytes at the front where no frame can begin, and whether a line ends behind them; `None` when
/// one may begin at once.
pub(crate) fn next_start(spec: &FrameSpec, rest: &[u8], aligned: bool) -> Option<(usize, bool)> {
    let nothing = |skip: usize, line_end| (skip > 0).then_some((skip, line_end));
    match spec.kind() {
        Kind::Fixed | Kind::Septet => {
            let start = (0..rest.len()).find(|at| is_start(spec, &rest[*at..]));
            nothing(start.unwrap_or(rest.len()), false)
        }
        Kind::Cobs => match rest.iter().position(|byte| *byte == 0) {
            Some(zero) if zero <= spec.frame_len() && zero != spec.frame_len() + 1 => {
                Some((zero + 1, false))
            }
            Some(zero) => nothing(zero - spec.frame_len() - 1, false),
            None => nothing(rest.len().saturating_sub(spec.frame_len() + 1), false),
        },
        _ => line_start(spec, rest, aligned),
    }
}

fn line_start(spec: &FrameSpec, rest: &[u8], aligned: bool) -> Option<(usize, bool)> {
    let Some(end) = rest.iter().position(|byte| *byte == b'\n') else {
        // Whatever it is, the stream ends before it does.
        return Some((rest.len(), false));
    };
    let prefix = spec.sync();
    let start = if prefix.is_empty() {
        aligned.then_some(0)
    } else {
        (0..=end).rev().find(|at| rest[*at..end].starts_with(prefix))
    };
    match start.filter(|start| end - start < longest(spec)) {
        Some(0) => None,
        Some(start) => Some((start, false)),
        None => Some((end + 1, true)),
    }
}
