//! Finds the frame counter: a column that rises by one with every frame.

use crate::frames::Frames;
use crate::layout::Counter;
use crate::length::as_f64;
use std::collections::BTreeMap;

/// A counter and what it did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Found {
    pub(crate) counter: Counter,
    /// Share of steps by one, wraps included.
    pub(crate) share: f64,
    /// Times it went back to zero.
    pub(crate) wraps: usize,
}

/// The steps of one column.
struct Steps {
    all: usize,
    by_one: usize,
    /// Returns to zero by last value before them.
    returns: BTreeMap<u8, usize>,
}

/// The counter among `columns`, the steadiest if there are several.
pub(crate) fn find(frames: &Frames<'_>, columns: &[bool]) -> Option<Found> {
    let candidates = (0..frames.len).filter(|column| columns[*column]);
    let found = candidates.filter_map(|column| judge(frames, columns, column));
    found.max_by(|a, b| a.share.total_cmp(&b.share).then(b.counter.at.cmp(&a.counter.at)))
}

fn judge(frames: &Frames<'_>, columns: &[bool], column: usize) -> Option<Found> {
    let steps = steps_of(frames, column);
    let returned: usize = steps.returns.values().sum();
    let share = as_f64(steps.by_one + returned) / as_f64(steps.all.max(1));
    let least = if frames.verified { 0.93 } else { 0.8 };
    if steps.all < 16 || 2 * steps.by_one < steps.all || share < least {
        return None;
    }
    let low = low_modulus(frames, &steps);
    let digits = 1 << frames.digit_bits;
    let counter = match high_column(frames, columns, column) {
        Some((at, big_endian)) if low == digits => {
            let modulus = digits * digits;
            Counter { at, bytes: 2, big_endian, modulus }
        }
        _ => Counter { at: column, bytes: 1, big_endian: true, modulus: low },
    };
    Some(Found { counter, share, wraps: returned })
}

fn steps_of(frames: &Frames<'_>, column: usize) -> Steps {
    let mut steps = Steps { all: 0, by_one: 0, returns: BTreeMap::new() };
    for (before, after) in frames.neighbours() {
        let (before, after) = (frames.byte(before, column), frames.byte(after, column));
        steps.all += 1;
        if before.checked_add(1) == Some(after) {
            steps.by_one += 1;
        } else if after == 0 && before != 0 {
            *steps.returns.entry(before).or_default() += 1;
        }
    }
    steps
}

fn low_modulus(frames: &Frames<'_>, steps: &Steps) -> u32 {
    let whole = 1 << frames.digit_bits;
    let returned: usize = steps.returns.values().sum();
    match steps.returns.iter().max_by_key(|(_, count)| **count) {
        Some((last, count)) if 2 * count > returned => u32::from(*last) + 1,
        _ => whole,
    }
}

/// The neighbour that rises by one whenever the low byte wraps and rests otherwise: where the
/// two start, and whether it stands first.
fn high_column(frames: &Frames<'_>, columns: &[bool], low: usize) -> Option<(usize, bool)> {
    let top = if frames.digit_bits == 7 { 0x7F } else { 0xFF };
    let carries = |high: usize| {
        let (mut wraps, mut carried, mut quiet, mut still) = (0, 0, 0, 0);
        for (before, after) in frames.neighbours() {
            let step = frames.byte(after, high).wrapping_sub(frames.byte(before, high)) & top;
            if frames.byte(before, low) == top && frames.byte(after, low) == 0 {
                wraps += 1;
                carried += usize::from(step == 1);
            } else {
                quiet += 1;
                still += usize::from(step == 0);
            }
        }
        wraps > 0 && 10 * carried >= 6 * wraps && 100 * still >= 93 * quiet
    };
    if low > 0 && columns[low - 1] && carries(low - 1) {
        return Some((low - 1, true));
    }
    (low + 1 < frames.len && columns[low + 1] && carries(low + 1)).then_some((low, false))
}
