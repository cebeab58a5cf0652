//! What is said of a candidate by its content and by its neighbours.

use crate::FrameSpec;
use crate::kind::{Cut, Cutter, Scratch};
use crate::{MAX_CONTENT_LEN, PlausibleSpec};

/// What a good frame says that its neighbours can contradict.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facts {
    pub(super) counter: Option<u64>,
    /// The rate in SI, when there is a gate on it and the frame carries it.
    pub(super) rate_si: Option<f64>,
}

/// What the content alone says.
pub(super) enum Verdict {
    Good(Facts),
    BadCheck,
    BadSequence,
}

/// What the frames behind a place say.
pub(super) enum Row {
    Confirmed,
    Refused,
    /// More bytes may tell.
    Incomplete,
}

/// Inlined into both callers: the call alone, with its answer by way of memory, costs every frame a
/// tenth of its time.
#[inline(always)]
pub(super) fn verdict(spec: &FrameSpec, content: &[u8]) -> Verdict {
    if !spec.check.holds(content) {
        return Verdict::BadCheck;
    }
    let counter = spec.sequence.map(|sequence| (sequence.read(content), sequence.modulus));
    if counter.is_some_and(|(counter, modulus)| counter >= modulus) {
        return Verdict::BadSequence;
    }
    let rate_si = spec.plausible.and_then(|gate| rate_si(spec, gate, content));
    Verdict::Good(Facts { counter: counter.map(|(counter, _)| counter), rate_si })
}

fn rate_si(spec: &FrameSpec, gate: PlausibleSpec, content: &[u8]) -> Option<f64> {
    let field = &spec.fields[gate.field];
    let carried =
        field.when.is_none_or(|when| spec.fields[when.field].read(content) == when.equals);
    let raw = field.read(content);
    (carried && field.is_number(raw)).then(|| field.to_si(raw))
}

/// Whether a rate is credible so many frames after another.
pub(super) fn is_credible(spec: &FrameSpec, before: f64, now: f64, frames: u64) -> bool {
    spec.plausible.is_none_or(|gate| (now - before).abs() <= gate.step_max_si * frames as f64)
}

/// Whether `next` can stand right behind `before`.
fn follows(spec: &FrameSpec, before: &Facts, next: &Facts) -> bool {
    let modulus = spec.sequence.map_or(1, |sequence| sequence.modulus);
    let in_step = match (before.counter, next.counter) {
        (Some(before), Some(next)) => (before + 1) % modulus == next,
        _ => true,
    };
    let credible = match (before.rate_si, next.rate_si) {
        (Some(before), Some(next)) => is_credible(spec, before, next, 1),
        _ => true,
    };
    in_step && credible
}

/// Whether `bytes` begin with `frames` good frames in a row, the first of them behind `before`.
pub(super) fn row<C: Cutter>(
    spec: &FrameSpec,
    cutter: &C,
    bytes: &[u8],
    before: Option<Facts>,
    frames: usize,
) -> Row {
    let mut scratch: Scratch = [0; MAX_CONTENT_LEN];
    let (mut rest, mut before) = (bytes, before);
    for _ in 0..frames {
        let (content, wire_len) = match cutter.cut(rest, true, &mut scratch) {
            Cut::Whole { content, wire_len } => (content, wire_len),
            Cut::Short => return Row::Incomplete,
            Cut::Broken { .. } => return Row::Refused,
        };
        let Verdict::Good(next) = verdict(spec, content) else { return Row::Refused };
        if before.is_some_and(|before| !follows(spec, &before, &next)) {
            return Row::Refused;
        }
        (rest, before) = (&rest[wire_len..], Some(next));
    }
    Row::Confirmed
}
