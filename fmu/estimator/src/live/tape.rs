//! What was measured of late, and where the filter of pure torsion stood: enough for another
//! filter to take over from before something happened.

use crate::augmented::State;
use crate::state_bytes::{Reader, RestoreError, Writer};
use alloc::boxed::Box;
use alloc::vec;

/// Beliefs kept.
const ANCHORS: usize = 4;
/// Time from one of them to the next, s: a window of the swing meter.
const ANCHOR_SPACING_S: f64 = 2.56;

/// One measurement, as it came.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sample {
    /// Seconds since the measurement before.
    pub(super) span_s: f64,
    /// None when it was over range.
    pub(super) rate_rad_s: Option<f64>,
}

/// A ring of the last samples, numbered from 1; allocated once.
#[derive(Debug, Clone)]
pub(super) struct Tape {
    samples: Box<[Sample]>,
    last: u64,
}

impl Tape {
    pub(super) fn new(capacity: usize) -> Self {
        let none = Sample { span_s: 0.0, rate_rad_s: None };
        Self { samples: vec![none; capacity.max(1)].into_boxed_slice(), last: 0 }
    }

    #[inline(always)]
    pub(super) fn push(&mut self, sample: Sample) {
        self.last += 1;
        let place = self.place(self.last);
        self.samples[place] = sample;
    }

    /// Number of the last sample; 0 before the first.
    pub(super) fn last(&self) -> u64 {
        self.last
    }

    /// Number of the oldest sample that is still there.
    pub(super) fn oldest(&self) -> u64 {
        self.last.saturating_sub(self.samples.len() as u64) + 1
    }

    /// Sample `number`; none when it has been overwritten or has not come yet.
    pub(super) fn get(&self, number: u64) -> Option<Sample> {
        let there = (self.oldest()..=self.last).contains(&number);
        there.then(|| self.samples[self.place(number)])
    }

    #[expect(clippy::cast_possible_truncation, reason = "the remainder is below the length")]
    fn place(&self, number: u64) -> usize {
        (number % self.samples.len() as u64) as usize
    }

    pub(super) fn saved_len(&self) -> usize {
        self.samples.len() * 16 + 8
    }

    pub(super) fn write(&self, out: &mut Writer<'_>) {
        for sample in &self.samples {
            out.f64(sample.span_s);
            // No measured rate is as large: its residual could not be squared.
            out.f64(sample.rate_rad_s.unwrap_or(f64::MAX));
        }
        out.u64(self.last);
    }

    /// Reads into a tape of the same capacity: all of the bytes have been judged before.
    pub(super) fn read(&mut self, bytes: &mut Reader<'_>) -> Result<(), RestoreError> {
        for sample in &mut self.samples {
            let span_s = bytes.finite("span_s")?;
            let rate_rad_s = bytes.finite("stored rate")?;
            if span_s < 0.0 {
                return Err(RestoreError::Impossible);
            }
            *sample = Sample { span_s, rate_rad_s: (rate_rad_s < f64::MAX).then_some(rate_rad_s) };
        }
        self.last = bytes.u64();
        if self.last < u64::MAX / 2 { Ok(()) } else { Err(RestoreError::Impossible) }
    }
}

/// A belief, and the number of the sample after which it was held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Anchor {
    pub(super) number: u64,
    pub(super) state: State,
}

/// Beliefs of the filter of pure torsion at the start and every 2.56 s, the last four.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Anchors {
    /// Oldest first.
    kept: [Anchor; ANCHORS],
    since_s: f64,
}

impl Anchors {
    pub(super) fn new(number: u64, state: State) -> Self {
        Self { kept: [Anchor { number, state }; ANCHORS], since_s: 0.0 }
    }

    #[inline(always)]
    pub(super) fn pass(&mut self, span_s: f64, number: u64, state: impl FnOnce() -> State) {
        self.since_s += span_s;
        if self.since_s >= ANCHOR_SPACING_S {
            self.since_s = 0.0;
            self.kept.rotate_left(1);
            self.kept[ANCHORS - 1] = Anchor { number, state: state() };
        }
    }

    /// The oldest one: from 7.7 to 10.2 s ago, or the start.
    pub(super) fn oldest(&self) -> Anchor {
        self.kept[0]
    }

    pub(super) const SAVED_LEN: usize = ANCHORS * (8 + State::SAVED_LEN) + 8;

    pub(super) fn write(&self, out: &mut Writer<'_>) {
        for anchor in &self.kept {
            out.u64(anchor.number);
            anchor.state.write(out);
        }
        out.f64(self.since_s);
    }

    pub(super) fn read(bytes: &mut Reader<'_>) -> Result<Self, RestoreError> {
        let mut read = || {
            let number = bytes.u64();
            Ok(Anchor { number, state: State::read(bytes)? })
        };
        let kept = [read()?, read()?, read()?, read()?];
        Ok(Self { kept, since_s: bytes.finite("time since an anchor")? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tape_keeps_the_last_samples_and_no_others() {
        let mut tape = Tape::new(3);
        assert_eq!(tape.get(1), None);
        for k in 1..=5_u32 {
            tape.push(Sample { span_s: f64::from(k), rate_rad_s: None });
        }
        let spans = [2, 3, 4, 5, 6].map(|number| tape.get(number).map(|sample| sample.span_s));
        assert_eq!(spans, [None, Some(3.0), Some(4.0), Some(5.0), None]);
        assert_eq!((tape.oldest(), tape.last()), (3, 5));
    }
}
