//! The decoder as one would write it on a napkin: the whole stream at hand, everything looked up
//! again at every byte, bits one by one.

mod form;
mod number;

use form::{Front, front, next_start};
use number::{check_holds, field_value, sequence_value};
use struna_wire::{Counters, FrameSpec, Kind};

/// A frame as the naive decoder tells it: index, lost before, raw values, fields it has.
pub(crate) type Told = (u64, u64, Vec<i64>, Vec<bool>);

#[derive(Default)]
struct State {
    counters: Counters,
    told: Vec<Told>,
    last: Option<u64>,
    seen: bool,
    locked: bool,
    adrift: usize,
    /// The last rate in SI, and the good frames since that had none.
    rate: Option<(f64, u64)>,
    counter: Option<u64>,
}

/// What is found at one place.
enum Place {
    Good(Vec<u8>, usize),
    Bad(usize),
    BadSequence(usize),
    /// Bytes to pass over, with a delimiter behind them or not.
    Nothing(usize, bool),
    End,
}

pub(crate) fn decode(spec: &FrameSpec, bytes: &[u8]) -> (Vec<Told>, Counters) {
    let mut s = State::default();
    s.counters.bytes = bytes.len() as u64;
    let (mut at, mut aligned) = (0, false);
    let delimited = matches!(spec.kind(), Kind::Cobs | Kind::Ascii);
    let (confirm, confirm_due) = (spec.evidence().confirm, spec.evidence().confirm_due);
    while at < bytes.len() {
        let rest = &bytes[at..];
        let due = s.locked && (delimited || s.adrift.is_multiple_of(spec.frame_len()));
        let needed = match (s.locked, s.adrift) {
            (true, 0) => 1,
            _ if due => confirm_due,
            _ => confirm,
        };
        let (wire_len, wrong) = match look(spec, rest, aligned) {
            Place::End => break,
            Place::Nothing(skip, line_end) => {
                match behind(spec, rest, due && !delimited && confirm > 1, confirm_due) {
                    None => break,
                    Some(true) => {
                        at += skipped(&mut s, spec, spec.frame_len());
                        aligned = false;
                    }
                    Some(false) => {
                        // A place where a weak frame is due is never jumped over.
                        let due = spec.frame_len() - s.adrift % spec.frame_len();
                        let weak = s.locked && !delimited && confirm > 1;
                        at += skipped(&mut s, spec, if weak { skip.min(due) } else { skip });
                        aligned = line_end;
                    }
                }
                continue;
            }
            Place::Good(content, wire_len) if !credible(&s, spec, &content) => (wire_len, 3),
            Place::Good(content, wire_len) => match row(spec, rest, needed, aligned) {
                None => break,
                Some(true) => {
                    take(&mut s, spec, &content, wire_len);
                    (at, aligned) = (at + wire_len, true);
                    continue;
                }
                Some(false) => (wire_len, 2),
            },
            Place::Bad(wire_len) => (wire_len, 0),
            Place::BadSequence(wire_len) => (wire_len, 1),
        };
        let step = match behind(spec, rest, due && !delimited && confirm > 1, confirm_due) {
            None => break,
            Some(true) => spec.frame_len(),
            Some(false) if delimited => wire_len,
            Some(false) => 1,
        };
        s.counters.bad_check += u64::from(wrong == 0);
        s.counters.bad_sequence += u64::from(wrong == 1);
        s.counters.unconfirmed += u64::from(wrong == 2);
        s.counters.implausible += u64::from(wrong == 3);
        (at, aligned) = (at + skipped(&mut s, spec, step), true);
    }
    skipped(&mut s, spec, bytes.len() - at);
    (s.told, s.counters)
}

fn look(spec: &FrameSpec, rest: &[u8], aligned: bool) -> Place {
    if let Some((skip, line_end)) = next_start(spec, rest, aligned) {
        return Place::Nothing(skip, line_end);
    }
    match front(spec, rest) {
        Front::Short => Place::End,
        Front::Broken(wire_len) => Place::Bad(wire_len),
        Front::Whole(content, wire_len) => {
            if !check_holds(spec, &content) {
                return Place::Bad(wire_len);
            }
            let modulus = spec.sequence().map_or(1, |sequence| sequence.modulus());
            let sane = sequence_value(spec, &content).is_none_or(|counter| counter < modulus);
            if sane { Place::Good(content, wire_len) } else { Place::BadSequence(wire_len) }
        }
    }
}

/// Whether so many good frames stand at the front, their counters in step; `None` if the stream
/// ends before that is known.
fn row(spec: &FrameSpec, rest: &[u8], frames: usize, aligned: bool) -> Option<bool> {
    let (mut at, mut aligned, mut before, mut rate) = (0, aligned, None, None);
    for _ in 0..frames {
        match front(spec, &rest[at..]) {
            Front::Short => return None,
            Front::Broken(_) => return Some(false),
            Front::Whole(content, wire_len) => {
                let Place::Good(..) = look(spec, &rest[at..], aligned) else { return Some(false) };
                let counter = sequence_value(spec, &content);
                if let (Some(sequence), Some(before)) = (spec.sequence(), before) {
                    let due: u64 = before;
                    if Some((due + 1) % sequence.modulus()) != counter {
                        return Some(false);
                    }
                }
                let next = rate_si(spec, &content);
                if let (Some(gate), Some(now), Some(then)) = (spec.plausible(), next, rate) {
                    let then: f64 = then;
                    if (now - then).abs() > gate.step_max_si {
                        return Some(false);
                    }
                }
                (at, aligned, before, rate) = (at + wire_len, true, counter, next);
            }
        }
    }
    Some(true)
}

/// Whether a row of good frames stands one frame behind the front.
fn behind(spec: &FrameSpec, rest: &[u8], asked: bool, frames: usize) -> Option<bool> {
    if !asked {
        return Some(false);
    }
    row(spec, rest.get(spec.frame_len()..)?, frames, true)
}

fn rate_si(spec: &FrameSpec, content: &[u8]) -> Option<f64> {
    let field = &spec.fields()[spec.plausible()?.field];
    let carried = field.when().is_none_or(|(decider, value)| {
        field_value(spec, &spec.fields()[decider], content) == value
    });
    let value = field.to_si(field_value(spec, field, content));
    Some(value).filter(|value| carried && value.is_finite())
}

/// Whether the rate can have come from the last one, in as many frames as there were.
fn credible(s: &State, spec: &FrameSpec, content: &[u8]) -> bool {
    let (Some(gate), Some((before, age)), Some(now)) =
        (spec.plausible(), s.rate, rate_si(spec, content))
    else {
        return true;
    };
    let by_bytes = 1 + (s.adrift / spec.wire_len()) as u64;
    let by_counter = match (spec.sequence(), s.counter, sequence_value(spec, content)) {
        (Some(seq), Some(last), Some(now)) => (now + seq.modulus() - last) % seq.modulus(),
        _ => 0,
    };
    (now - before).abs() <= gate.step_max_si * (age + by_bytes.max(by_counter)) as f64
}

fn skipped(s: &mut State, spec: &FrameSpec, bytes: usize) -> usize {
    s.counters.skipped_bytes += bytes as u64;
    s.adrift += bytes;
    if s.locked && s.adrift >= 5 * form::longest(spec) {
        (s.locked, s.rate, s.counter) = (false, None, None);
        s.counters.unlocks += 1;
    }
    bytes
}

fn take(s: &mut State, spec: &FrameSpec, content: &[u8], wire_len: usize) {
    let c = &mut s.counters;
    c.frame_bytes += wire_len as u64;
    c.resyncs += u64::from(s.adrift > 0 && c.ok > 0);
    c.locks += u64::from(!s.locked);
    (s.locked, s.adrift) = (true, 0);
    s.counter = sequence_value(spec, content);
    s.rate = match (rate_si(spec, content), s.rate) {
        (Some(rate), _) => Some((rate, 0)),
        (None, last) => last.map(|(rate, age)| (rate, age + 1)),
    };
    let index = match (spec.sequence(), s.last, sequence_value(spec, content)) {
        (Some(seq), Some(last), Some(counter)) => {
            let same_lap = last - last % seq.modulus() + counter;
            let ahead = if same_lap < last { same_lap + seq.modulus() } else { same_lap };
            let back = seq.modulus() - (ahead - last);
            if ahead > last && back <= 4.min(seq.modulus() / 16) {
                c.backward += 1;
                return;
            }
            ahead
        }
        (_, None, counter) => counter.unwrap_or(0),
        (_, Some(last), _) => last + 1,
    };
    if s.seen && s.last == Some(index) {
        c.duplicates += 1;
        return;
    }
    let lost = s.last.map_or(0, |last| index - last - 1);
    c.ok += 1;
    c.lost += lost;
    c.sequence_gaps += u64::from(lost > 0);
    (s.last, s.seen) = (Some(index), true);
    let (mut raw, mut has) = (Vec::new(), Vec::new());
    for field in spec.fields() {
        let carried = field.when().is_none_or(|(decider, value)| raw[decider] == value);
        let value = if carried { field_value(spec, field, content) } else { 0 };
        has.push(carried && field.to_si(value).is_finite());
        raw.push(value);
    }
    for (field, has) in spec.fields().iter().zip(&mut has) {
        if let Some(flag) = field.valid_if() {
            let flag = &spec.flags()[flag];
            *has &= raw[flag.field()] & flag.mask() != 0;
        }
    }
    s.told.push((index, lost, raw, has));
}
