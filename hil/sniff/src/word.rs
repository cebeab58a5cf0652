//! The parity word: four bytes, of which a bit makes the number of ones even or odd.
//!
//! It has no byte that stays the same, so its length cannot be seen; but eight words in a row
//! with equal parity are a rare chance (one in 128) everywhere except at the beginning of a word.

use crate::length::as_f64;
use crate::motion::Motion;

const WORDS: usize = 8;
const LEN: usize = 4;

/// A known word with parity: KVH's 1000 Hz format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ParityWord {
    /// The number of ones is odd.
    pub odd: bool,
    /// Value of the two sync bits, in their place in the first byte.
    pub sync: u8,
}

/// The two sync bits of the first byte.
pub(crate) const SYNC_MASK: u8 = 0x60;

/// A word and how well it is borne out.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Found {
    pub(crate) word: ParityWord,
    pub(crate) frames: usize,
    /// Share of the bytes in words that fit.
    pub(crate) share: f64,
    pub(crate) motion: Motion,
}

/// The word, when the bytes are such words.
pub(crate) fn find(bytes: &[u8]) -> Option<Found> {
    if bytes.len() < 64 * LEN || has_constant_byte(bytes) {
        return None;
    }
    let parity: Vec<bool> = bytes.windows(LEN).map(is_odd).collect();
    let steady = |k: usize| (1..WORDS).all(|n| parity[k + n * LEN] == parity[k]);
    let last = parity.len().checked_sub((WORDS - 1) * LEN)?;
    let hits: Vec<usize> = (0..last).filter(|k| steady(*k)).collect();
    if !(12 * last..=45 * last).contains(&(100 * hits.len())) {
        return None;
    }
    let odd = 2 * hits.iter().filter(|k| parity[**k]).count() > hits.len();
    let value = [0x00, 0x20, 0x40, 0x60]
        .into_iter()
        .max_by_key(|value| hits.iter().filter(|hit| bytes[**hit] & SYNC_MASK == *value).count())?;
    let fixed = hits.iter().filter(|hit| bytes[**hit] & SYNC_MASK == value).count();
    if 10 * fixed < 8 * hits.len() {
        return None;
    }
    let word = ParityWord { odd, sync: value };
    let starts = scan(&word, bytes);
    let share = as_f64(starts.len() * LEN) / as_f64(bytes.len());
    let motion = motion(bytes, &starts);
    (share > 0.5).then_some(Found { word, frames: starts.len(), share, motion })
}

/// Starts of the words in `bytes`, each vouched for by a neighbour.
pub(crate) fn scan(word: &ParityWord, bytes: &[u8]) -> Vec<usize> {
    let is_word = |k: usize| {
        bytes
            .get(k..k + LEN)
            .is_some_and(|bytes| bytes[0] & SYNC_MASK == word.sync && is_odd(bytes) == word.odd)
    };
    let (mut starts, mut at) = (Vec::new(), 0);
    while at + LEN <= bytes.len() {
        let follows = starts.last().is_some_and(|last| last + LEN == at);
        let vouched = (1..4).all(|n| at + n * LEN + LEN > bytes.len() || is_word(at + n * LEN));
        if is_word(at) && (follows || vouched) {
            starts.push(at);
            at += LEN;
        } else {
            at += 1;
        }
    }
    starts
}

fn has_constant_byte(bytes: &[u8]) -> bool {
    (0..LEN).any(|phase| {
        let mut counts = [0usize; 256];
        bytes.iter().skip(phase).step_by(LEN).for_each(|byte| counts[usize::from(*byte)] += 1);
        let most = counts.iter().max().copied().unwrap_or(0);
        100 * most * LEN > 97 * bytes.len()
    })
}

fn is_odd(word: &[u8]) -> bool {
    word.iter().fold(0, |a, b| a ^ b).count_ones() % 2 == 1
}

/// Of the 26-bit number.
fn motion(bytes: &[u8], starts: &[usize]) -> Motion {
    let value = |start: &usize| {
        let word = u32::from_be_bytes([0, 1, 2, 3].map(|k| bytes[start + k]));
        f64::from((word << 6).cast_signed() >> 6)
    };
    let values: Vec<f64> = starts.iter().map(value).collect();
    Motion::of(&values, f64::from(1 << 26))
}
