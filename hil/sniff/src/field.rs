//! Finds where numbers begin and end, by minimum description length.
//!
//! Bytes of one number carry into each other. Taken together the number moves smoothly, so its
//! differences take few bits; split or joined wrongly they take more. Dynamic programming over
//! the free columns finds the cheapest split.

use crate::frames::Frames;
use crate::length::{as_f64, as_float};

/// Frames in a row that a second difference needs, and how many such are coded together.
const RUN: usize = 3;
const BLOCK: usize = 32;
/// Values of a block that set its scale; the others may be damage.
const CALM: usize = 28;
/// Blocks looked at, spread over the capture.
const BLOCKS: usize = 96;
/// Bits that one more field costs: settles a tie in favour of the longer number.
const FIELD_BITS: f64 = 0.06;

/// What a window costs more whose top digit leaps by itself.
const STRANGER_BITS: f64 = 1.0;

/// A run of columns that is one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Window {
    pub(crate) at: usize,
    pub(crate) bytes: usize,
    pub(crate) big_endian: bool,
}

/// Three frames in a row, by their starts.
type Triple = [usize; RUN];

/// The cheapest split of the `free` columns into numbers.
pub(crate) fn split(frames: &Frames<'_>, free: &[bool]) -> Vec<Window> {
    let triples = triples_of(frames);
    let mut windows = float_windows(frames, free);
    let mut free = free.to_vec();
    for window in &windows {
        free[window.at..window.at + window.bytes].fill(false);
    }
    let mut at = 0;
    while at < frames.len {
        let run = free[at..].iter().take_while(|free| **free).count();
        windows.extend(split_run(frames, &triples, at, run));
        at += run.max(1);
    }
    windows.sort_by_key(|window| window.at);
    windows
}

fn triples_of(frames: &Frames<'_>) -> Vec<Triple> {
    let len = frames.len;
    let all: Vec<Triple> = frames
        .starts
        .windows(RUN)
        .filter(|run| run[0] + len == run[1] && run[1] + len == run[2])
        .map(|run| [run[0], run[1], run[2]])
        .collect();
    let blocks = all.len() / BLOCK;
    if blocks <= BLOCKS {
        return all;
    }
    let block = |k: usize| &all[k * blocks / BLOCKS * BLOCK..][..BLOCK];
    (0..BLOCKS).flat_map(block).copied().collect()
}

fn split_run(frames: &Frames<'_>, triples: &[Triple], at: usize, run: usize) -> Vec<Window> {
    let longest = if frames.digit_bits == 7 { 5 } else { 4 };
    let mut best: Vec<(f64, Option<Window>)> = vec![(0.0, None)];
    for end in 1..=run {
        let mut least: (f64, Option<Window>) = (f64::INFINITY, None);
        for bytes in 1..=longest.min(end) {
            for big_endian in if bytes == 1 { &[true][..] } else { &[true, false][..] } {
                let window = Window { at: at + end - bytes, bytes, big_endian: *big_endian };
                let cost = best[end - bytes].0 + bits_of(frames, triples, window) + FIELD_BITS;
                if cost < least.0 {
                    least = (cost, Some(window));
                }
            }
        }
        best.push(least);
    }
    let (mut windows, mut end) = (Vec::new(), run);
    while let Some(window) = best[end].1 {
        end -= window.bytes;
        windows.push(window);
    }
    windows
}

/// Bits per frame that the differences of a number take.
fn bits_of(frames: &Frames<'_>, triples: &[Triple], window: Window) -> f64 {
    let codes: Vec<[u64; RUN]> = triples
        .iter()
        .map(|t| t.map(|k| frames.number(k, window.at, window.bytes, window.big_endian)))
        .collect();
    let whole = frames.digit_bits * u32::try_from(window.bytes).unwrap_or(4);
    let moving = active_bits(&codes, whole);
    let cost = |width| mean_block_bits(&codes, width);
    let bits = if moving < whole { cost(whole).min(cost(moving)) } else { cost(whole) };
    let top = window.bytes > 1 && top_jumps(&codes, (whole, moving), frames.digit_bits);
    if top { bits + STRANGER_BITS } else { bits }
}

/// Whether the top digit belongs to something else: where it changes, the number does not glide
/// through the change but leaps, far beyond its steps before and after. A number need not fill its
/// top digit: what leaps in the `whole` width and glides in the `moving` bits has changed its sign.
fn top_jumps(codes: &[[u64; RUN]], (whole, moving): (u32, u32), digit_bits: u32) -> bool {
    let (mut changes, mut leaps) = (0, 0);
    for block in codes.chunks(BLOCK).filter(|block| 2 * block.len() >= BLOCK) {
        let step = |[_, b, c]: &[u64; RUN]| {
            let difference = c.wrapping_sub(*b);
            magnitude(difference, whole).min(magnitude(difference, moving))
        };
        let mut steps: Vec<f64> = block.iter().map(step).collect();
        steps.sort_by(f64::total_cmp);
        let usual = steps[steps.len() / 2];
        for code in block {
            if code[1] >> (whole - digit_bits) != code[2] >> (whole - digit_bits) {
                changes += 1;
                leaps += usize::from(step(code) > 12.0 * usual + 1.0);
            }
        }
    }
    changes >= 2 && 10 * leaps > 6 * changes
}

/// Bits up to the highest that changes more often than damage explains.
fn active_bits(codes: &[[u64; RUN]], whole: u32) -> u32 {
    let Some(first) = codes.first() else { return whole };
    let changed = |bit: u32| {
        let differs = |code: &&[u64; RUN]| ((code[0] ^ first[0]) >> bit) & 1 == 1;
        100 * codes.iter().filter(differs).count() >= codes.len()
    };
    (0..whole).rev().find(|bit| changed(*bit)).map_or(1, |bit| bit + 1)
}

fn mean_block_bits(codes: &[[u64; RUN]], width: u32) -> f64 {
    let mut total = 0.0;
    let mut blocks = 0.0;
    for block in codes.chunks(BLOCK).filter(|block| 2 * block.len() >= BLOCK) {
        let step = |a: u64, b: u64| a.wrapping_sub(b);
        let first = block.iter().map(|[_, b, c]| magnitude(step(*c, *b), width));
        let second =
            block.iter().map(|[a, b, c]| magnitude(step(*c, *b).wrapping_sub(step(*b, *a)), width));
        total += block_bits(first, width).min(block_bits(second, width));
        blocks += 1.0;
    }
    total / f64::max(blocks, 1.0)
}

/// |x| of a difference modulo 2^`width`.
fn magnitude(difference: u64, width: u32) -> f64 {
    let mask = u64::MAX >> (64 - width);
    let code = difference & mask;
    as_float(code.min(code.wrapping_neg() & mask))
}

/// Bits per value of a two-sided exponential code whose scale the calm values set; those far out
/// are told one by one.
fn block_bits(values: impl Iterator<Item = f64>, width: u32) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let calm = values.len() * CALM / BLOCK;
    let scale = values[..calm].iter().sum::<f64>() / as_f64(calm);
    let usual = (1.0 + 2.0 * std::f64::consts::E * scale).log2();
    let limit = f64::from(width);
    let told = |value: &f64| {
        if *value > 12.0 * scale {
            (5.0 + 2.0 * (1.0 + value).log2()).min(5.0 + limit)
        } else {
            usual
        }
    };
    (values.iter().map(told).sum::<f64>() / as_f64(values.len())).min(limit)
}

/// Runs of four columns that are IEEE 754 numbers around zero: sign both ways, exponents of
/// ordinary numbers, several of them.
fn float_windows(frames: &Frames<'_>, free: &[bool]) -> Vec<Window> {
    if frames.digit_bits == 7 || frames.len < 4 {
        return Vec::new();
    }
    let mut found = Vec::new();
    let mut at = 0;
    while at + 4 <= frames.len {
        let all_free = free[at..at + 4].iter().all(|free| *free);
        let order = [true, false].into_iter().find(|be| all_free && is_float(frames, at, *be));
        match order {
            Some(big_endian) => {
                found.push(Window { at, bytes: 4, big_endian });
                at += 4;
            }
            None => at += 1,
        }
    }
    found
}

pub(crate) fn is_float(frames: &Frames<'_>, at: usize, big_endian: bool) -> bool {
    let (mut ordinary, mut negative, mut exponents) = (0, 0, [0usize; 256]);
    for start in &frames.starts {
        let code = frames.number(*start, at, 4, big_endian);
        let exponent = (code >> 23) & 0xFF;
        ordinary += usize::from(code << 1 == 0 || (90..=150).contains(&exponent));
        negative += usize::from(code >> 31 == 1);
        exponents[usize::try_from(exponent).unwrap_or(0)] += 1;
    }
    let all = frames.count();
    let several = exponents.iter().filter(|count| 200 * **count >= all).count() >= 4;
    let whole = if frames.verified { 995 } else { 970 };
    let both_signs = 50 * negative >= all && 50 * (all - negative) >= all;
    1000 * ordinary >= whole * all && both_signs && several
}
