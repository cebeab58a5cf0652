//! Follows a stream from one candidate to the next.

use super::counters::Counters;
use super::judge::{Facts, Row, Verdict, is_credible, row, verdict};
use crate::kind::{Cut, Cutter, Scratch};
use crate::plan::{Plan, Word};
use crate::sequence::{Arrival, SequenceTracker};
use crate::{Frame, FrameSpec, LossResolver};

/// Frames' length of bytes without a good frame after which the stream counts as lost.
const ADRIFT_FRAMES: u64 = 5;
/// Beyond this index frames are counted with care, lest the index overflow.
const INDEX_MAX: u64 = u64::MAX / 2;

/// Where the decoder stands in the stream, and what it has made of it.
#[derive(Debug, Clone)]
pub(super) struct Follower {
    pub(super) spec: FrameSpec,
    pub(super) counters: Counters,
    /// The clock, and the arrival of the bytes at hand.
    pub(super) clock: Option<(LossResolver, f64)>,
    tracker: SequenceTracker,
    /// A good frame has come, not so long ago.
    locked: bool,
    /// Bytes skipped since the last good frame.
    adrift: u64,
    /// A delimiter stands before the bytes at hand.
    aligned: bool,
    /// The last rate, and good frames since that carried none.
    last_rate: Option<(f64, u64)>,
    /// The last good frame's counter.
    last_counter: Option<u64>,
}

/// Why a candidate is not believed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Bad {
    Check,
    Sequence,
    Implausible,
    Unconfirmed,
}

impl Follower {
    pub(super) fn new(spec: FrameSpec) -> Self {
        Self {
            counters: Counters::default(),
            clock: None,
            tracker: SequenceTracker::new(spec.modulus()),
            locked: false,
            adrift: 0,
            aligned: false,
            last_rate: None,
            last_counter: None,
            spec,
        }
    }

    /// Works through `bytes`; returns how many of them are done with.
    #[inline]
    pub(super) fn scan<C: Cutter>(
        &mut self,
        cutter: &C,
        bytes: &[u8],
        scratch: &mut Scratch,
        sink: &mut impl FnMut(&Frame),
    ) -> usize {
        let mut at = 0;
        while at < bytes.len() {
            match self.step(cutter, &bytes[at..], scratch, sink) {
                Some(done) => at += done,
                None => break,
            }
        }
        at
    }

    /// As [`Self::scan`], for the first `filled` bytes of `window`: runs of frames in step are
    /// taken by the `plan`, all else step by step.
    #[inline]
    pub(super) fn scan_planned<W: Word, C: Cutter>(
        &mut self,
        plan: &Plan<W>,
        cutter: &C,
        (window, filled): (&[u8], usize),
        scratch: &mut Scratch,
        sink: &mut impl FnMut(&Frame),
    ) -> usize {
        let mut at = 0;
        while at < filled {
            at += self.run_in_step(plan, (&window[at..], filled - at), sink);
            if at < filled {
                match self.step(cutter, &window[at..filled], scratch, sink) {
                    Some(done) => at += done,
                    None => break,
                }
            }
        }
        at
    }

    /// Takes frames from the front of `window`, of which `filled` bytes have come, as long as each
    /// is the very next one: whole, in lock, right behind the one before in bytes and by counter.
    /// Returns the bytes taken.
    #[inline]
    fn run_in_step<W: Word>(
        &mut self,
        plan: &Plan<W>,
        (window, filled): (&[u8], usize),
        sink: &mut impl FnMut(&Frame),
    ) -> usize {
        let Some((last_index, mut last_counter)) = self.tracker.last() else { return 0 };
        let untold = self.clock.is_some() || self.spec.plausible.is_some();
        if !self.locked || self.adrift > 0 || untold || last_index > INDEX_MAX {
            return 0;
        }
        let mut slate = plan.slate(&self.spec, last_index);
        let mut at = 0;
        while filled - at >= plan.len() {
            let Some(front) = window[at..].first_chunk() else { break };
            let counter = plan.counter_after(last_counter);
            let Some(word) = plan.cut(front, counter) else { break };
            plan.read(word, &mut slate);
            last_counter = counter;
            at += plan.len();
            sink(&slate.frame);
        }
        if at > 0 {
            self.aligned = true;
            self.counters.frame_bytes += at as u64;
            self.counters.ok += slate.frame.index - last_index;
            self.tracker.catch_up(slate.frame.index, last_counter);
            self.last_counter = self.spec.sequence.map(|_| last_counter);
        }
        at
    }

    /// The stream has come to an end with `pending` bytes that are no frame.
    pub(super) fn end(&mut self, pending: usize) {
        self.skip(pending, false);
        (self.locked, self.last_rate, self.last_counter) = (false, None, None);
    }

    /// Bytes that the front of `rest` is done with; `None` when more are needed.
    #[inline]
    fn step<C: Cutter>(
        &mut self,
        cutter: &C,
        rest: &[u8],
        scratch: &mut Scratch,
        sink: &mut impl FnMut(&Frame),
    ) -> Option<usize> {
        let (content, wire_len) = match cutter.cut(rest, self.aligned, scratch) {
            Cut::Whole { content, wire_len } => (content, wire_len),
            Cut::Short => {
                let seek = cutter.seek(rest, self.aligned);
                return (seek.skip > 0).then(|| self.skip(seek.skip, seek.aligned));
            }
            Cut::Broken { wire_len } => return self.pass_broken(cutter, rest, wire_len),
        };
        let facts = match verdict(&self.spec, content) {
            Verdict::Good(facts) => facts,
            Verdict::BadCheck => return self.pass_over(cutter, rest, wire_len, Bad::Check),
            Verdict::BadSequence => return self.pass_over(cutter, rest, wire_len, Bad::Sequence),
        };
        if self.spec.plausible.is_some() && !self.credible(&facts) {
            return self.pass_over(cutter, rest, wire_len, Bad::Implausible);
        }
        let behind = self.needed::<C>() - 1;
        if behind > 0 {
            match row(&self.spec, cutter, &rest[wire_len..], Some(facts), behind) {
                Row::Confirmed => (),
                Row::Incomplete => return None,
                Row::Refused => return self.pass_over(cutter, rest, wire_len, Bad::Unconfirmed),
            }
        }
        self.accept(content, wire_len, &facts, sink);
        Some(wire_len)
    }

    /// Frames in a row that must be good here before the first of them is believed.
    #[inline]
    fn needed<C: Cutter>(&self) -> usize {
        let evidence = &self.spec.evidence;
        match (self.locked, self.adrift) {
            _ if evidence.confirm == 1 => 1,
            (true, 0) => 1,
            _ if self.is_due::<C>() => evidence.confirm_due,
            _ => evidence.confirm,
        }
    }

    /// Whether a frame is due here: a whole number of frames behind the last good one.
    fn is_due<C: Cutter>(&self) -> bool {
        self.locked && (C::DELIMITED || self.adrift.is_multiple_of(self.spec.len as u64))
    }

    /// Bytes to the next place where a weak frame is due. None is jumped over, for then the end of
    /// a push would decide which of them are looked at.
    fn to_due<C: Cutter>(&self) -> usize {
        if C::DELIMITED || self.spec.evidence.confirm == 1 || !self.locked {
            return usize::MAX;
        }
        let past = usize::try_from(self.adrift).map_or(0, |adrift| adrift % self.spec.len);
        self.spec.len - past
    }

    /// Whether the rate can have come from the last one.
    fn credible(&self, facts: &Facts) -> bool {
        let (Some((before, age)), Some(now)) = (self.last_rate, facts.rate_si) else { return true };
        let by_bytes = 1 + self.adrift / self.spec.wire_len() as u64;
        let by_counter = match (self.spec.sequence, self.last_counter, facts.counter) {
            (Some(sequence), Some(last), Some(now)) => {
                (now + sequence.modulus - last) % sequence.modulus
            }
            _ => 0,
        };
        is_credible(&self.spec, before, now, age + by_bytes.max(by_counter))
    }

    /// Passes over what has not the form of a frame.
    fn pass_broken<C: Cutter>(
        &mut self,
        cutter: &C,
        rest: &[u8],
        wire_len: usize,
    ) -> Option<usize> {
        let seek = cutter.seek(rest, self.aligned);
        if seek.skip == 0 {
            return self.pass_over(cutter, rest, wire_len, Bad::Check);
        }
        match self.look_behind(cutter, rest) {
            Row::Incomplete => None,
            Row::Confirmed => Some(self.skip(self.spec.len, false)),
            Row::Refused => Some(self.skip(seek.skip.min(self.to_due::<C>()), seek.aligned)),
        }
    }

    /// Passes over a candidate that is not believed. Only what a delimiter ends is given up as a
    /// whole; else one byte, for its bytes may hold the true start, unless a weak frame was due
    /// here and the next one stands where it should.
    fn pass_over<C: Cutter>(
        &mut self,
        cutter: &C,
        rest: &[u8],
        wire_len: usize,
        bad: Bad,
    ) -> Option<usize> {
        let done = match self.look_behind(cutter, rest) {
            Row::Incomplete => return None,
            Row::Confirmed => self.spec.len,
            Row::Refused if C::DELIMITED => wire_len,
            Row::Refused => 1,
        };
        let counter = match bad {
            Bad::Check => &mut self.counters.bad_check,
            Bad::Sequence => &mut self.counters.bad_sequence,
            Bad::Implausible => &mut self.counters.implausible,
            Bad::Unconfirmed => &mut self.counters.unconfirmed,
        };
        *counter += 1;
        Some(self.skip(done, true))
    }

    /// Whether a bad frame at a place where a weak one is due is followed by good ones.
    fn look_behind<C: Cutter>(&self, cutter: &C, rest: &[u8]) -> Row {
        let evidence = &self.spec.evidence;
        if C::DELIMITED || evidence.confirm == 1 || !self.is_due::<C>() {
            return Row::Refused;
        }
        match rest.get(self.spec.len..) {
            Some(behind) => row(&self.spec, cutter, behind, None, evidence.confirm_due),
            None => Row::Incomplete,
        }
    }

    #[inline]
    fn accept(
        &mut self,
        content: &[u8],
        wire_len: usize,
        facts: &Facts,
        sink: &mut impl FnMut(&Frame),
    ) {
        let counters = &mut self.counters;
        counters.frame_bytes += wire_len as u64;
        counters.resyncs += u64::from(self.adrift > 0 && counters.ok > 0);
        counters.locks += u64::from(!self.locked);
        (self.locked, self.adrift, self.aligned) = (true, 0, true);
        self.last_counter = facts.counter;
        if self.spec.plausible.is_some() {
            self.last_rate = match (facts.rate_si, self.last_rate) {
                (Some(rate_si), _) => Some((rate_si, 0)),
                (None, last) => last.map(|(rate_si, age)| (rate_si, age + 1)),
            };
        }
        let clock = self.clock.as_mut().map(|(clock, arrival_s)| (clock, *arrival_s));
        match self.tracker.arrive(facts.counter, clock) {
            Arrival::Duplicate => self.counters.duplicates += 1,
            Arrival::Backward => self.counters.backward += 1,
            Arrival::New { index, lost_before, inferred } => {
                let mut frame = Frame::read(&self.spec, content);
                (frame.index, frame.lost_before, frame.inferred) = (index, lost_before, inferred);
                self.counters.ok += 1;
                self.counters.sequence_gaps += u64::from(lost_before > 0);
                self.counters.lost = self.counters.lost.saturating_add(lost_before);
                sink(&frame);
            }
        }
    }

    /// Gives up `bytes`, and returns their number.
    fn skip(&mut self, bytes: usize, aligned: bool) -> usize {
        self.counters.skipped_bytes += bytes as u64;
        self.adrift += bytes as u64;
        self.aligned = aligned;
        if self.locked && self.adrift >= ADRIFT_FRAMES * self.spec.longest() as u64 {
            self.counters.unlocks += 1;
            (self.locked, self.last_rate, self.last_counter) = (false, None, None);
        }
        bytes
    }
}
