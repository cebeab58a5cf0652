//! From a byte stream of any quality to frames.

mod counters;
mod follower;
mod judge;

use crate::kind::{AnyCutter, Scratch};
use crate::plan::{AnyPlan, WORD_LEN};
use crate::{Frame, FrameSpec, LossResolver, MAX_CONTENT_LEN};
pub use counters::Counters;
use follower::Follower;

/// Bytes that the decoder looks at in one go. Larger pushes are worked off in pieces of this.
const WINDOW: usize = 4096;

/// Finds frames in a byte stream: no clock of its own, no port, no failure.
///
/// After a failed check it moves on by one byte, not by one frame: the bytes of a false start may
/// hold a true one. A frame that carries little evidence is believed in company only: so many in a
/// row as [`crate::Evidence::confirm`] says, and fewer while the stream is in lock. All memory is
/// taken at construction.
///
/// The frame counter is the only witness of loss that [`Self::push`] has, so a gap of a whole turn
/// of it cannot be told from a shorter one; [`Self::push_at`] asks the time of arrival as well.
#[derive(Debug, Clone)]
pub struct Decoder {
    cutter: AnyCutter,
    plan: Option<AnyPlan>,
    /// Bytes at hand, and room for a word behind them: a planned frame is read as a whole word.
    window: Box<[u8]>,
    filled: usize,
    scratch: Scratch,
    follower: Follower,
}

impl Decoder {
    /// A decoder that has seen nothing.
    #[must_use]
    pub fn new(spec: FrameSpec) -> Self {
        Self {
            cutter: AnyCutter::of(&spec),
            plan: AnyPlan::of(&spec),
            window: vec![0; WINDOW + WORD_LEN].into_boxed_slice(),
            filled: 0,
            scratch: [0; MAX_CONTENT_LEN],
            follower: Follower::new(spec),
        }
    }

    /// The same decoder, asking the layout about everything.
    #[cfg(test)]
    pub(crate) fn without_plan(self) -> Self {
        Self { plan: None, ..self }
    }

    /// The layout.
    #[must_use]
    pub const fn spec(&self) -> &FrameSpec {
        &self.follower.spec
    }

    /// The counters so far.
    #[must_use]
    pub const fn counters(&self) -> Counters {
        self.follower.counters
    }

    /// Bytes held back because they may be a frame: less than one, or as many as must be seen
    /// together before a frame of little evidence is believed.
    #[must_use]
    pub const fn pending_bytes(&self) -> usize {
        self.filled
    }

    /// Takes the next bytes of the stream and hands every frame they complete to `sink`.
    pub fn push(&mut self, bytes: &[u8], sink: &mut impl FnMut(&Frame)) {
        let mut rest = bytes;
        while !rest.is_empty() {
            // Never empty: a scan leaves a few frames, far less than the window.
            let room = &mut self.window[self.filled..WINDOW];
            let (now, later) = rest.split_at(rest.len().min(room.len()));
            room[..now.len()].copy_from_slice(now);
            self.filled += now.len();
            self.follower.counters.bytes += now.len() as u64;
            self.scan(sink);
            rest = later;
        }
    }

    /// The same for bytes of which the last has arrived at `arrival_s`, on any clock that does not
    /// go back, s. Losses are then resolved by [`LossResolver`]: gaps of whole turns of the
    /// counter, and gaps between frames that have none.
    ///
    /// What is handed out depends on bytes and times alone. A time that is no number is ignored.
    pub fn push_at(&mut self, bytes: &[u8], arrival_s: f64, sink: &mut impl FnMut(&Frame)) {
        if arrival_s.is_finite() {
            match &mut self.follower.clock {
                Some((_, now_s)) => *now_s = arrival_s,
                None => {
                    let resolver = LossResolver::of(self.spec().timing());
                    self.follower.clock = Some((resolver, arrival_s));
                }
            }
        }
        self.push(bytes, sink);
    }

    /// The same decoder with a clock of other properties for [`Self::push_at`], such as one that
    /// knows of a USB bridge's latency.
    #[must_use]
    pub fn with_clock(mut self, resolver: LossResolver) -> Self {
        self.follower.clock = Some((resolver, 0.0));
        self
    }

    /// Ends the stream: bytes still pending can no longer become a frame and are counted as
    /// skipped. The decoder may go on with another stretch of the same gyro's stream.
    pub fn finish(&mut self) -> Counters {
        self.follower.end(self.filled);
        self.filled = 0;
        self.counters()
    }

    /// Works through the window until more bytes are needed, and moves the rest to the front.
    fn scan(&mut self, sink: &mut impl FnMut(&Frame)) {
        let Self { cutter, plan, window, filled, scratch, follower } = self;
        let bytes = &window[..*filled];
        let done = match (cutter, plan) {
            (AnyCutter::Fixed(cutter), Some(AnyPlan::Short(plan))) => {
                follower.scan_planned(plan, cutter, (window, *filled), scratch, sink)
            }
            (AnyCutter::Fixed(cutter), Some(AnyPlan::Long(plan))) => {
                follower.scan_planned(plan, cutter, (window, *filled), scratch, sink)
            }
            (AnyCutter::Fixed(cutter), None) => follower.scan(cutter, bytes, scratch, sink),
            (AnyCutter::Septet(cutter), _) => follower.scan(cutter, bytes, scratch, sink),
            (AnyCutter::Cobs(cutter), _) => follower.scan(cutter, bytes, scratch, sink),
            (AnyCutter::Line(cutter), _) => follower.scan(cutter, bytes, scratch, sink),
        };
        window.copy_within(done..*filled, 0);
        *filled -= done;
    }
}
