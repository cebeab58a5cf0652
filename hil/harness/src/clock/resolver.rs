//! Which sample a frame is, when its counter alone cannot tell.

use super::TimeBase;
use struna_kernel::SimTime;

/// Frames in a row that must all be late before a silent loss is inferred from it. Longer than any
/// burst of a USB bridge.
const LATE_FRAMES: u32 = 32;
/// A frame this far off its sample's time was numbered by a counter that started again.
const RESTART_S: f64 = 0.05;

/// A frame as the decoder handed it out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Heard {
    /// Its index by the decoder.
    pub index: u64,
    /// When its last byte arrived.
    pub arrival: SimTime,
    /// The latest instant at which the line was seen to be silent since the frame before. Only a
    /// silent line shows that time has passed there: a host that was held up finds a backlog.
    pub silent_until: Option<SimTime>,
    /// The port was lost and opened again since the frame before.
    pub after_outage: bool,
}

/// What a sample index rests on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Basis {
    /// The frame counter.
    Counter,
    /// The frame counter, and the time passed for its whole turns.
    CounterAndTime,
    /// The time passed alone.
    Inferred,
    /// The time passed alone, because the counter has started again.
    Restarted,
}

/// A frame with its place among the samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Resolved {
    /// Sample index; zero for the first frame.
    pub index: u64,
    /// Samples missing before it.
    pub lost: u64,
    /// What that rests on.
    pub basis: Basis,
}

#[derive(Debug, Clone, Copy)]
struct Last {
    heard: u64,
    index: u64,
    arrival: SimTime,
}

/// Numbers samples without gaps in meaning: two frames whose indices differ by n were taken n
/// periods apart, whatever was lost between them.
///
/// A counter tells losses shorter than its modulus; longer ones are told by the time for which the
/// line was silent, to the nearest whole turn of the counter. Frames without a counter are numbered
/// by time: at once after a silence, and after `LATE_FRAMES` frames that were all late by a
/// period or more otherwise.
#[derive(Debug, Clone)]
pub struct Resolver {
    /// Of the counter; none without one.
    modulus: Option<u64>,
    last: Option<Last>,
    late_frames: u32,
    least_late_s: f64,
}

impl Resolver {
    /// A resolver for frames whose counter has this modulus, if they have one.
    #[must_use]
    pub const fn new(modulus: Option<u64>) -> Self {
        Self { modulus, last: None, late_frames: 0, least_late_s: f64::INFINITY }
    }

    /// The place of the next frame.
    pub fn resolve(&mut self, heard: &Heard, base: &TimeBase) -> Resolved {
        let Some(last) = self.last else {
            self.note(heard, 0);
            return Resolved { index: 0, lost: 0, basis: Basis::Counter };
        };
        let step = heard.index.saturating_sub(last.heard).max(1);
        let (step, basis) = match self.modulus {
            Some(modulus) => by_counter(heard, last, step, modulus, base),
            None => self.by_time(heard, last, base),
        };
        let index = last.index.saturating_add(step);
        self.note(heard, index);
        Resolved { index, lost: step - 1, basis }
    }

    fn note(&mut self, heard: &Heard, index: u64) {
        self.last = Some(Last { heard: heard.index, index, arrival: heard.arrival });
    }

    /// Without a counter.
    fn by_time(&mut self, heard: &Heard, last: Last, base: &TimeBase) -> (u64, Basis) {
        if !base.is_settled() && !heard.after_outage {
            return (1, Basis::Counter);
        }
        let late_s = base.lateness_s(last.index.saturating_add(1), heard.arrival);
        let late_periods = late_s / base.period_s();
        if heard.silent_until.is_some() || heard.after_outage {
            self.forget_lateness();
            return inferred(late_periods);
        }
        self.late_frames += 1;
        self.least_late_s = self.least_late_s.min(late_s);
        if self.late_frames < LATE_FRAMES {
            return (1, Basis::Counter);
        }
        let least_periods = self.least_late_s / base.period_s();
        self.forget_lateness();
        inferred(least_periods)
    }

    fn forget_lateness(&mut self) {
        self.late_frames = 0;
        self.least_late_s = f64::INFINITY;
    }
}

/// One step, and as many as fit into `late_periods`.
fn inferred(late_periods: f64) -> (u64, Basis) {
    match whole(late_periods) {
        0 => (1, Basis::Counter),
        lost => (lost.saturating_add(1), Basis::Inferred),
    }
}

/// With a counter, which says `step` up to whole turns.
fn by_counter(heard: &Heard, last: Last, step: u64, modulus: u64, base: &TimeBase) -> (u64, Basis) {
    let period_s = base.period_s();
    let passed_s = heard.arrival.seconds_since(last.arrival);
    let silent_s = heard.silent_until.map_or(0.0, |until| until.seconds_since(last.arrival));
    let turn_s = modulus as f64 * period_s;
    let shown_s = if heard.after_outage { passed_s } else { silent_s };
    let turns = if shown_s > 0.5 * turn_s {
        whole((passed_s / period_s - step as f64) / modulus as f64)
    } else {
        0
    };
    let candidate = step.saturating_add(turns.saturating_mul(modulus));
    if heard.after_outage {
        let off_s = base.lateness_s(last.index.saturating_add(candidate), heard.arrival).abs();
        // A counter too short to be off by much cannot show that it started again.
        let allowed_s = RESTART_S + if base.is_settled() { 1e-4 } else { 0.03 } * passed_s;
        if off_s > allowed_s && allowed_s < 0.25 * turn_s {
            return (whole(passed_s / period_s).max(1), Basis::Restarted);
        }
    }
    (candidate, if turns > 0 { Basis::CounterAndTime } else { Basis::Counter })
}

/// The nearest whole number that is not negative.
fn whole(number: f64) -> u64 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a float-to-int cast saturates, and negative numbers are meant to become zero"
    )]
    return number.round() as u64;
}
