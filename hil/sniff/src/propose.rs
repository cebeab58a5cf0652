//! From what was discovered to proposals and a verdict.

use crate::discover::{Discovery, discover, discover_at, discover_in, is_generic};
use crate::layout::{Kind, Layout};
use crate::length::{Framing, as_f64};
use crate::report::{Alternative, Doubt, Evidence, Proposal, Report, Shape, Verdict};
use crate::{text, word};

/// Share of the bytes that must lie in good frames.
const SHARE_MIN: f64 = 0.95;
/// The capture is cut into so many blocks; every fourth is held back for the test.
const BLOCKS: usize = 8;
const HELD_BACK: usize = 4;
/// Highest score of a proposal that there is a doubt about.
const DOUBTFUL_SCORE: f64 = 0.75;
/// Frames from which the amount of evidence counts for itself.
const MANY_FRAMES: usize = 800;

/// Proposes layouts for `bytes`. `second` is another capture of the same gyro, on which the
/// proposal is tested; without one it is tested on parts of `bytes` held back.
///
/// Looks at bytes alone, reads no clock, and gives the same answer for the same bytes. Any bytes
/// will do; nothing makes it fail.
#[must_use]
pub fn sniff(bytes: &[u8], second: Option<&[u8]>) -> Report {
    let Found { mut proposals, framing } = of_kind(bytes);
    let verdict = match proposals.first() {
        None => Verdict::Unknown,
        Some(first) => judge(first, framing.as_ref(), bytes, second),
    };
    if let (Some(first), Verdict::Unconfirmed(_)) = (proposals.first_mut(), verdict) {
        first.score = first.score.min(DOUBTFUL_SCORE);
    }
    Report { bytes: bytes.len(), verdict, proposals }
}

/// Proposals, and where the frames of the first are if it is binary.
#[derive(Default)]
struct Found {
    proposals: Vec<Proposal>,
    framing: Option<Framing>,
}

fn of_kind(bytes: &[u8]) -> Found {
    if let Some(found) = text::find(bytes) {
        return Found { proposals: vec![of_lines(found)], framing: None };
    }
    if let Some(found) = word::find(bytes) {
        return Found { proposals: vec![of_word(&found)], framing: None };
    }
    let Some(best) = discover(bytes) else { return Found::default() };
    let mut proposals = vec![of_binary(&best)];
    if best.layout.check.is_none() && best.layout.kind == Kind::Fixed {
        // Nothing proves the length: the next likely one stands beside it.
        let others = crate::length::candidates(bytes);
        let other = others.iter().find(|other| other.len != best.layout.len);
        let other = other.and_then(|other| discover_at(bytes, other.len));
        proposals.extend(other.as_ref().map(of_binary).map(|mut other| {
            other.score = other.score.min(0.5 * proposals[0].score);
            other
        }));
    }
    Found { proposals, framing: Some(best.framing) }
}

fn of_lines(found: text::Found) -> Proposal {
    let moved = found.motion.turned;
    let counted = found.lines.columns.iter().any(|column| column.role.is_none());
    let score = 0.5 + bonus(0.25, found.lines.checked) + bonus(0.1, counted) + bonus(0.15, moved);
    let evidence = Evidence {
        frames: found.frames,
        share: found.share,
        wraps: found.wraps,
        excursion: found.motion.excursion,
        turned: found.motion.turned,
        ..Evidence::default()
    };
    let alternatives = vec![Alternative::ScaleAndSign, Alternative::SlowFields];
    Proposal { shape: Shape::Lines(found.lines), score, evidence, alternatives }
}

fn of_word(found: &word::Found) -> Proposal {
    let evidence = Evidence {
        frames: found.frames,
        share: found.share,
        excursion: found.motion.excursion,
        turned: found.motion.turned,
        ..Evidence::default()
    };
    let score = 0.7 + bonus(0.15, found.motion.turned);
    let alternatives = vec![Alternative::ScaleAndSign];
    Proposal { shape: Shape::Word(found.word), score, evidence, alternatives }
}

fn of_binary(found: &Discovery) -> Proposal {
    let evidence = Evidence {
        frames: found.frames,
        share: found.share,
        saved_bits: found.framing.saved,
        counter_share: found.counter.map_or(0.0, |counter| counter.share),
        wraps: found.counter.map_or(0, |counter| counter.wraps),
        excursion: found.motion.excursion,
        turned: found.motion.turned,
    };
    Proposal {
        score: score_of(found),
        evidence,
        alternatives: alternatives_of(found),
        shape: Shape::Binary(found.layout.clone()),
    }
}

fn bonus(value: f64, given: bool) -> f64 {
    if given { value } else { 0.0 }
}

fn score_of(found: &Discovery) -> f64 {
    let check = match &found.layout.check {
        Some(check) if is_generic(check) => 0.125,
        Some(_) => 0.25,
        None => 0.0,
    };
    let moved = found.motion.turned;
    let alone = found.motion.excursion > 4.0 * found.next_excursion;
    let score = 0.35
        + check
        + bonus(0.12, found.layout.counter.is_some())
        + bonus(0.15, moved)
        + bonus(0.08, alone)
        + bonus(0.05, found.frames > MANY_FRAMES)
        - bonus(0.15, found.constant_top)
        - bonus(0.2, found.layout.sync.is_empty());
    score.clamp(0.0, 1.0)
}

fn alternatives_of(found: &Discovery) -> Vec<Alternative> {
    let mut open = Vec::new();
    if found.checks.len() > 1 {
        open.push(Alternative::Checks(found.checks.clone()));
    }
    if found.checks.first().is_some_and(is_generic) {
        open.push(Alternative::GenericCheck);
    }
    let run = found.constant_run;
    let covered = found.layout.check.map_or(0, |check| check.first);
    if run > 1 && covered != run && found.layout.kind == Kind::Fixed {
        open.push(Alternative::SyncLength { least: 1, most: run });
    }
    let constant: Vec<usize> =
        (found.layout.sync.len()..run).chain(found.constant_elsewhere.iter().copied()).collect();
    if !constant.is_empty() {
        open.push(Alternative::ConstantBytes(constant));
    }
    if found.noisy_bytes > 0 {
        open.push(Alternative::NoisyBytes { bytes: found.noisy_bytes });
    }
    if found.constant_top {
        open.push(Alternative::ConstantTop);
    }
    open.extend([Alternative::ScaleAndSign, Alternative::SlowFields]);
    open
}

fn judge(
    first: &Proposal,
    framing: Option<&Framing>,
    bytes: &[u8],
    second: Option<&[u8]>,
) -> Verdict {
    // A second capture had no part in the proposal; of the only one, parts are held back.
    let about_part =
        || if second.is_none() { doubt_about_part(first, framing, bytes) } else { None };
    match doubt_of(first).or_else(about_part) {
        Some(doubt) => Verdict::Unconfirmed(doubt),
        None => test(first, bytes, second),
    }
}

/// What the evidence itself leaves in doubt.
fn doubt_of(proposal: &Proposal) -> Option<Doubt> {
    let Evidence { share, excursion, turned, .. } = proposal.evidence;
    if let Shape::Binary(layout) = &proposal.shape {
        if layout.sync.is_empty() {
            return Some(Doubt::NoSync);
        }
        if layout.rate().is_none() {
            return Some(Doubt::NoRate);
        }
        if layout.check.is_none() && layout.counter.is_none() {
            return Some(Doubt::NothingVouches);
        }
    }
    if share < SHARE_MIN {
        return Some(Doubt::Damaged { share });
    }
    (!turned).then_some(Doubt::AtRest { excursion })
}

/// What is held back must not have shaped the proposal: the rest alone has to lead to the same
/// one. Only where frames lie is taken over; they would be cut the same way.
fn doubt_about_part(first: &Proposal, framing: Option<&Framing>, bytes: &[u8]) -> Option<Doubt> {
    let parts: Vec<(usize, usize)> = blocks(bytes.len())
        .enumerate()
        .filter(|(k, _)| !is_held_back(*k))
        .map(|(_, part)| part)
        .collect();
    let kept: Vec<u8> =
        parts.iter().flat_map(|(from, to)| bytes[*from..*to].iter().copied()).collect();
    let again = match (&first.shape, framing) {
        (Shape::Binary(layout), Some(framing)) => {
            let again = discover_in(&kept, &framing.within(&parts), layout.kind);
            again.map(|again| Shape::Binary(again.layout))
        }
        _ => of_kind(&kept).proposals.into_iter().next().map(|again| again.shape),
    };
    let same = again.is_some_and(|again| agree(&again, &first.shape));
    (!same).then_some(Doubt::PartDisagrees)
}

/// Lines seen in part may show fewer digits than the whole; anything else must be equal.
fn agree(a: &Shape, b: &Shape) -> bool {
    match (a, b) {
        (Shape::Lines(a), Shape::Lines(b)) => {
            let roles = |lines: &text::Lines| -> Vec<_> {
                lines.columns.iter().map(|column| (column.role, column.decimals)).collect()
            };
            roles(a) == roles(b) && a.checked == b.checked && a.prefix == b.prefix
        }
        _ => a == b,
    }
}

/// The bounds of the blocks of a capture of `total` bytes.
fn blocks(total: usize) -> impl Iterator<Item = (usize, usize)> {
    let size = total.div_ceil(BLOCKS).max(1);
    (0..total).step_by(size).map(move |from| (from, total.min(from + size)))
}

const fn is_held_back(block: usize) -> bool {
    block % HELD_BACK == HELD_BACK - 1
}

/// Reads bytes that the proposal was not made from.
fn test(first: &Proposal, bytes: &[u8], second: Option<&[u8]>) -> Verdict {
    let held_back: Vec<&[u8]> = match second {
        Some(second) => vec![second],
        None => blocks(bytes.len())
            .enumerate()
            .filter(|(k, _)| is_held_back(*k))
            .map(|(_, (from, to))| &bytes[from..to])
            .collect(),
    };
    let shares: Vec<f64> = held_back.iter().map(|block| share_in(&first.shape, block)).collect();
    let share = shares.iter().sum::<f64>() / as_f64(shares.len().max(1));
    if share >= SHARE_MIN {
        Verdict::Confirmed { share }
    } else {
        Verdict::Unconfirmed(Doubt::SecondDisagrees { share })
    }
}

/// Share of `bytes` in good frames, of those that could be: a frame may be cut at each end.
fn share_in(shape: &Shape, bytes: &[u8]) -> f64 {
    match shape {
        Shape::Lines(lines) => text::share_in(lines, bytes),
        Shape::Word(word) => whole_share(word::scan(word, bytes).len(), 4, bytes.len()),
        Shape::Binary(layout) => {
            let starts = layout.scan(bytes);
            let share = whole_share(starts.len(), layout.len, bytes.len());
            share.min(counted_share(layout, &starts, bytes))
        }
    }
}

fn whole_share(frames: usize, len: usize, bytes: usize) -> f64 {
    let room = (bytes / len).saturating_sub(2).max(1);
    as_f64(frames.min(room)) / as_f64(room)
}

/// Share of neighbouring frames whose counter moves on by one; 1 without a counter.
fn counted_share(layout: &Layout, starts: &[usize], bytes: &[u8]) -> f64 {
    let Some(counter) = &layout.counter else { return 1.0 };
    let (mut steps, mut good) = (0, 0);
    for pair in starts.windows(2).filter(|pair| pair[0] + layout.len == pair[1]) {
        let count = |start: usize| layout.count_in(&bytes[start..start + layout.len]);
        let (Some(before), Some(after)) = (count(pair[0]), count(pair[1])) else { continue };
        steps += 1;
        good += usize::from((before + 1) % u64::from(counter.modulus) == after);
    }
    if steps == 0 { 0.0 } else { as_f64(good) / as_f64(steps) }
}
