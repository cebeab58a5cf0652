//! From a byte stream of any quality to frames.

use crate::sequence::{Arrival, SequenceTracker};
use crate::{FrameSpec, MAX_FIELDS};

/// Bytes that the decoder looks at in one go. Larger pushes are worked off in pieces of this.
const WINDOW: usize = 4096;

/// One good frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    /// Sample index: the frame counter unwrapped across its modulus. The first frame of a stream
    /// keeps its counter value; without a counter, frames are numbered from zero.
    pub index: u64,
    /// Frames missing between the previous frame and this one, as far as the counter can tell.
    pub lost_before: u64,
    raw: [i64; MAX_FIELDS],
    field_count: usize,
    flags: u32,
}

impl Frame {
    /// Raw field values, indexed as [`FrameSpec::fields`].
    #[must_use]
    pub fn raw(&self) -> &[i64] {
        &self.raw[..self.field_count]
    }

    /// Whether the status bit with this index in [`FrameSpec::flags`] is set; `false` for an
    /// index that the layout does not have.
    #[must_use]
    pub fn flag(&self, index: usize) -> bool {
        u32::try_from(index).is_ok_and(|bit| self.flags.checked_shr(bit).unwrap_or(0) & 1 == 1)
    }
}

/// What became of every byte and every frame.
///
/// Always `bytes == frame_len · (ok + duplicates) + skipped_bytes + pending`, where pending is
/// [`Decoder::pending_bytes`], zero after [`Decoder::finish`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// Bytes pushed.
    pub bytes: u64,
    /// Frames handed out.
    pub ok: u64,
    /// Places that began with the sync word but failed the check. In noise many of these were
    /// never frames.
    pub bad_check: u64,
    /// Places that passed the check but held a counter not below the modulus; treated as failed.
    pub bad_sequence: u64,
    /// Bytes that belong to no frame.
    pub skipped_bytes: u64,
    /// Times a frame was found again after skipped bytes. Finding the first one does not count.
    pub resyncs: u64,
    /// Steps of the frame counter by more than one.
    pub sequence_gaps: u64,
    /// Frames missing in those gaps.
    pub lost: u64,
    /// Good frames that repeated the previous counter; counted, not handed out.
    pub duplicates: u64,
}

/// Finds frames in a byte stream: no clock, no port, no failure.
///
/// After a failed check it moves on by one byte, not by one frame: the bytes of a false start may
/// hold a true one. All memory is taken at construction.
///
/// The frame counter is the only witness of loss, so a gap of `modulus - 1` frames or more cannot
/// be told from a shorter one (exactly `modulus - 1` lost looks like a duplicate).
#[derive(Debug, Clone)]
pub struct Decoder {
    spec: FrameSpec,
    window: Box<[u8]>,
    filled: usize,
    tracker: SequenceTracker,
    counters: Counters,
    /// Bytes have been skipped since the last good frame.
    astray: bool,
}

impl Decoder {
    /// A decoder that has seen nothing.
    #[must_use]
    pub fn new(spec: FrameSpec) -> Self {
        Self {
            window: vec![0; WINDOW].into_boxed_slice(),
            filled: 0,
            tracker: SequenceTracker::new(spec.sequence.map_or(1, |sequence| sequence.modulus)),
            counters: Counters::default(),
            astray: false,
            spec,
        }
    }

    /// The layout.
    #[must_use]
    pub const fn spec(&self) -> &FrameSpec {
        &self.spec
    }

    /// The counters so far.
    #[must_use]
    pub const fn counters(&self) -> Counters {
        self.counters
    }

    /// Bytes held back because they may be the start of a frame; always less than one frame.
    #[must_use]
    pub const fn pending_bytes(&self) -> usize {
        self.filled
    }

    /// Takes the next bytes of the stream and hands every frame they complete to `sink`.
    pub fn push(&mut self, bytes: &[u8], sink: &mut impl FnMut(&Frame)) {
        let mut rest = bytes;
        while !rest.is_empty() {
            // Never empty: a scan leaves less than one frame, far less than the window.
            let room = &mut self.window[self.filled..];
            let (now, later) = rest.split_at(rest.len().min(room.len()));
            room[..now.len()].copy_from_slice(now);
            self.filled += now.len();
            self.counters.bytes += now.len() as u64;
            self.scan(sink);
            rest = later;
        }
    }

    /// Ends the stream: bytes still pending can no longer become a frame and are counted as
    /// skipped. The decoder may go on with another stretch of the same gyro's stream.
    pub fn finish(&mut self) -> Counters {
        self.skip(self.filled);
        self.filled = 0;
        self.counters
    }

    /// Works through the window until less than a frame is left, and moves that to the front.
    fn scan(&mut self, sink: &mut impl FnMut(&Frame)) {
        let len = self.spec.len;
        let mut at = 0;
        loop {
            let candidate = at + distance_to_sync(&self.window[at..self.filled], &self.spec.sync);
            self.skip(candidate - at);
            at = candidate;
            if self.filled - at < len {
                break;
            }
            if self.take(at, sink) {
                at += len;
            } else {
                self.skip(1);
                at += 1;
            }
        }
        self.window.copy_within(at..self.filled, 0);
        self.filled -= at;
    }

    /// Judges the frame at `at`; false when it is none.
    fn take(&mut self, at: usize, sink: &mut impl FnMut(&Frame)) -> bool {
        let bytes = &self.window[at..at + self.spec.len];
        if !self.spec.check.holds(bytes) {
            self.counters.bad_check += 1;
            return false;
        }
        let counter = self.spec.sequence.map(|sequence| sequence.read(bytes));
        let modulus = self.spec.sequence.map_or(1, |sequence| sequence.modulus);
        if counter.is_some_and(|counter| counter >= modulus) {
            self.counters.bad_sequence += 1;
            return false;
        }
        self.note_resync();
        match self.tracker.arrive(counter) {
            Arrival::Duplicate => self.counters.duplicates += 1,
            Arrival::New { index, lost_before } => {
                let frame = frame_of(&self.spec, &self.window[at..], index, lost_before);
                self.note_new(lost_before);
                sink(&frame);
            }
        }
        true
    }

    fn note_resync(&mut self) {
        let seen_before = self.counters.ok > 0;
        self.counters.resyncs += u64::from(self.astray && seen_before);
        self.astray = false;
    }

    fn note_new(&mut self, lost_before: u64) {
        self.counters.ok += 1;
        self.counters.sequence_gaps += u64::from(lost_before > 0);
        self.counters.lost = self.counters.lost.saturating_add(lost_before);
    }

    fn skip(&mut self, bytes: usize) {
        self.counters.skipped_bytes += bytes as u64;
        self.astray |= bytes > 0;
    }
}

/// How many bytes to skip so that what is left is empty or agrees with the sync word as far as it
/// goes.
#[inline]
fn distance_to_sync(bytes: &[u8], sync: &[u8]) -> usize {
    let mut at = 0;
    while let Some(step) = memchr::memchr(sync[0], &bytes[at..]) {
        at += step;
        let known = sync.len().min(bytes.len() - at);
        if bytes[at..at + known] == sync[..known] {
            return at;
        }
        at += 1;
    }
    bytes.len()
}

#[inline]
fn frame_of(spec: &FrameSpec, bytes: &[u8], index: u64, lost_before: u64) -> Frame {
    let mut raw = [0; MAX_FIELDS];
    for (slot, field) in raw.iter_mut().zip(&spec.fields) {
        *slot = field.read(bytes);
    }
    let flags = spec
        .flags
        .iter()
        .enumerate()
        .fold(0, |flags, (k, flag)| flags | u32::from(raw[flag.field] & flag.mask() != 0) << k);
    Frame { index, lost_before, raw, field_count: spec.fields.len(), flags }
}
