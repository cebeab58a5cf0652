//! Unwraps the gyro's frame counter and counts what is missing.

use crate::LossResolver;

/// What a counter value says about the frame that carries it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Arrival {
    /// A new frame: its unwrapped index, the number of frames missing just before it, and whether
    /// a clock had its say in that.
    New { index: u64, lost_before: u64, inferred: bool },
    /// The counter has not moved since the last frame.
    Duplicate,
    /// The counter is a little behind the last frame: frames changed places.
    Backward,
}

/// Steps back that are told from a long gap forward, at most.
const BACKWARD_MAX: u64 = 4;
/// One step back in so many of the modulus is told from a gap.
const BACKWARD_SHARE: u64 = 16;

/// Follows a counter modulo `modulus`.
///
/// One frame back and `modulus - 1` frames forward look the same. A few steps back are read as
/// back when the modulus is large, for so long a gap is rarer than a fault that swaps frames; all
/// other steps are read as forward. With a clock there is no doubt.
#[derive(Debug, Clone)]
pub(crate) struct SequenceTracker {
    modulus: u64,
    last: Option<u64>,
    /// `last` modulo `modulus`, kept because a division is slow beside the rest of a frame.
    last_counter: u64,
}

impl SequenceTracker {
    pub(crate) const fn new(modulus: u64) -> Self {
        Self { modulus, last: None, last_counter: 0 }
    }

    /// Index and counter of the last frame, if there was one.
    #[inline]
    pub(crate) fn last(&self) -> Option<(u64, u64)> {
        self.last.map(|index| (index, self.last_counter))
    }

    /// Frames have come one after the other up to this one.
    #[inline]
    pub(crate) const fn catch_up(&mut self, index: u64, counter: u64) {
        (self.last, self.last_counter) = (Some(index), counter);
    }

    /// Takes the counter of a good frame; `None` stands for frames without one, which are taken
    /// to follow each other unless the clock says otherwise.
    #[inline]
    pub(crate) fn arrive(
        &mut self,
        counter: Option<u64>,
        clock: Option<(&mut LossResolver, f64)>,
    ) -> Arrival {
        let Some(last) = self.last else {
            if let Some((clock, arrival_s)) = clock {
                clock.steps_without_counter(arrival_s);
            }
            // The first frame keeps its counter as index, so that it meets the emulator's own.
            let index = counter.unwrap_or(0);
            (self.last, self.last_counter) = (Some(index), index);
            return Arrival::New { index, lost_before: 0, inferred: false };
        };
        let (steps, inferred) = match (counter, clock) {
            (None, None) => (1, false),
            (None, Some((clock, arrival_s))) => {
                let steps = clock.steps_without_counter(arrival_s);
                (steps, steps > 1)
            }
            (Some(counter), clock) => {
                let wrap = if counter < self.last_counter { self.modulus } else { 0 };
                let step = counter + wrap - self.last_counter;
                match self.whole_steps(step, clock) {
                    Ok(told) => told,
                    Err(arrival) => return arrival,
                }
            }
        };
        let index = last.saturating_add(steps);
        (self.last, self.last_counter) = (Some(index), counter.unwrap_or(0));
        Arrival::New { index, lost_before: steps - 1, inferred }
    }

    /// Frames from the last one, and whether a clock was needed; or what is no new frame.
    #[inline]
    fn whole_steps(
        &self,
        step: u64,
        clock: Option<(&mut LossResolver, f64)>,
    ) -> Result<(u64, bool), Arrival> {
        let periods = clock.as_ref().and_then(|(clock, now_s)| clock.periods_since_last(*now_s));
        let long = periods.is_some_and(|periods| periods > self.modulus as f64 / 2.0);
        if !long && step > 0 && self.modulus - step <= self.backward_max() {
            return Err(Arrival::Backward);
        }
        let steps = match clock {
            Some((clock, arrival_s)) => clock.steps_with_counter(arrival_s, step, self.modulus),
            None => step,
        };
        if steps == 0 { Err(Arrival::Duplicate) } else { Ok((steps, steps != step)) }
    }

    #[inline]
    fn backward_max(&self) -> u64 {
        BACKWARD_MAX.min(self.modulus / BACKWARD_SHARE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn new(index: u64, lost_before: u64) -> Arrival {
        Arrival::New { index, lost_before, inferred: false }
    }

    #[test]
    fn a_step_over_the_wrap_is_one_frame() {
        let mut tracker = SequenceTracker::new(256);
        assert_eq!(tracker.arrive(Some(255), None), new(255, 0));
        assert_eq!(tracker.arrive(Some(0), None), new(256, 0));
        assert_eq!(tracker.arrive(Some(0), None), Arrival::Duplicate);
        assert_eq!(tracker.arrive(Some(251), None), new(507, 250));
    }

    #[test]
    fn frames_that_change_places_are_told_from_a_long_gap() {
        let mut tracker = SequenceTracker::new(256);
        let told = [1, 3, 2, 4].map(|counter| tracker.arrive(Some(counter), None));
        assert_eq!(told, [new(1, 0), new(3, 1), Arrival::Backward, new(4, 0)]);
        // 250 lost is the most that the counter alone can tell; 251 look like four back.
        assert_eq!(tracker.clone().arrive(Some(0), None), Arrival::Backward);
        assert_eq!(tracker.arrive(Some(255), None), new(255, 250));
        assert_eq!(tracker.arrive(Some(250), None), new(506, 250));
    }

    #[test]
    fn a_clock_tells_a_turn_from_a_repeat_and_from_a_step_back() {
        let mut clock = LossResolver::new(0.01, 0.0);
        let mut tracker = SequenceTracker::new(256);
        let mut at =
            |counter, arrival_s| tracker.arrive(Some(counter), Some((&mut clock, arrival_s)));
        assert_eq!(at(7, 0.0), new(7, 0));
        assert_eq!(at(7, 0.01), Arrival::Duplicate);
        let whole_turn = Arrival::New { index: 263, lost_before: 255, inferred: true };
        assert_eq!(at(7, 2.56), whole_turn);
        assert_eq!(at(6, 2.57), Arrival::Backward);
        assert_eq!(at(6, 2.56 + 2.55), new(518, 254));
        let three = Arrival::New { index: 519 + 3 * 256, lost_before: 768, inferred: true };
        assert_eq!(at(7, 2.56 + 2.55 + 7.69), three);
    }

    proptest! {
        #[test]
        fn any_gap_shorter_than_a_turn_is_measured_exactly(
            modulus in 2_u64..=1 << 32,
            start in any::<u32>(),
            shares in proptest::collection::vec(0.0..1.0_f64, 1..50),
        ) {
            let mut tracker = SequenceTracker::new(modulus);
            let mut index = u64::from(start) % modulus;
            prop_assert_eq!(tracker.arrive(Some(index), None), new(index, 0));
            for share in shares {
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a share below one of at most 2^32 - 2 frames"
                )]
                let lost = (share * (modulus - 1 - tracker.backward_max()) as f64) as u64;
                index += lost + 1;
                prop_assert_eq!(tracker.arrive(Some(index % modulus), None), new(index, lost));
            }
        }
    }
}
