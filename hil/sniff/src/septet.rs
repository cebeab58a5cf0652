//! Frames of one marker byte with bit 7 set among bytes below 128.

use crate::length::{Framing, LEN_MAX, LEN_MIN, as_f64};

/// The frames, when the bytes are of this kind.
pub(crate) fn framing(bytes: &[u8]) -> Option<Framing> {
    let marks: Vec<usize> = (0..bytes.len()).filter(|k| bytes[*k] >= 0x80).collect();
    if marks.len() < 16 || 100 * marks.len() > 35 * bytes.len() {
        return None;
    }
    let mut values = [0usize; 256];
    for mark in &marks {
        values[usize::from(bytes[*mark])] += 1;
    }
    let (marker, count) = (0u8..=255).zip(values).max_by_key(|(_, count)| *count)?;
    if 100 * count < 85 * marks.len() {
        return None;
    }
    let mut spacings = [0usize; LEN_MAX + 1];
    for pair in marks.windows(2) {
        if let Some(spacing) = spacings.get_mut(pair[1] - pair[0]) {
            *spacing += 1;
        }
    }
    let (len, count) = spacings.into_iter().enumerate().max_by_key(|(_, count)| *count)?;
    if len < LEN_MIN || 100 * count < 60 * marks.len() {
        return None;
    }
    let whole = |pair: &[usize]| bytes[pair[0]] == marker && pair[0] + len == pair[1];
    let starts: Vec<usize> =
        marks.windows(2).filter(|pair| whole(pair)).map(|pair| pair[0]).collect();
    let coverage = as_f64(starts.len() * len) / as_f64(bytes.len());
    Some(Framing { len, starts, coverage, saved: 8.0 / as_f64(len) })
}
