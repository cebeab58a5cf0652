//! Unwraps the gyro's frame counter and counts what is missing.

/// What a counter value says about the frame that carries it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Arrival {
    /// A new frame: its unwrapped index and the number of frames missing just before it.
    New { index: u64, lost_before: u64 },
    /// The counter has not moved since the last frame.
    Duplicate,
}

/// Follows a counter modulo `modulus`.
///
/// A serial line keeps its bytes in order, so every step is read as forward: one frame back and
/// `modulus - 1` frames forward look the same, and only the second can happen.
#[derive(Debug, Clone)]
pub(crate) struct SequenceTracker {
    modulus: u64,
    last: Option<u64>,
}

impl SequenceTracker {
    pub(crate) const fn new(modulus: u64) -> Self {
        Self { modulus, last: None }
    }

    /// Takes the counter of a good frame; `None` stands for frames without one, which are taken
    /// to follow each other.
    #[inline]
    pub(crate) fn arrive(&mut self, counter: Option<u64>) -> Arrival {
        let (index, lost_before) = match (counter, self.last) {
            (Some(counter), Some(last)) => {
                let step = (counter + self.modulus - last % self.modulus) % self.modulus;
                if step == 0 {
                    return Arrival::Duplicate;
                }
                (last.saturating_add(step), step - 1)
            }
            // The first frame keeps its counter as index, so that it meets the emulator's own.
            (Some(counter), None) => (counter, 0),
            (None, last) => (last.map_or(0, |last| last.saturating_add(1)), 0),
        };
        self.last = Some(index);
        Arrival::New { index, lost_before }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_step_over_the_wrap_is_one_frame() {
        let mut tracker = SequenceTracker::new(256);
        assert_eq!(tracker.arrive(Some(255)), Arrival::New { index: 255, lost_before: 0 });
        assert_eq!(tracker.arrive(Some(0)), Arrival::New { index: 256, lost_before: 0 });
        assert_eq!(tracker.arrive(Some(0)), Arrival::Duplicate);
        assert_eq!(tracker.arrive(Some(255)), Arrival::New { index: 511, lost_before: 254 });
    }

    proptest! {
        #[test]
        fn any_gap_shorter_than_the_modulus_is_measured_exactly(
            modulus in 2_u64..=1 << 32,
            start in any::<u32>(),
            shares in proptest::collection::vec(0.0..1.0_f64, 1..50),
        ) {
            let mut tracker = SequenceTracker::new(modulus);
            let mut index = u64::from(start) % modulus;
            prop_assert_eq!(
                tracker.arrive(Some(index)),
                Arrival::New { index, lost_before: 0 }
            );
            for share in shares {
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a share below one of at most 2^32 - 2 frames"
                )]
                let lost_before = (share * (modulus - 1) as f64) as u64;
                index += lost_before + 1;
                prop_assert_eq!(
                    tracker.arrive(Some(index % modulus)),
                    Arrival::New { index, lost_before }
                );
            }
        }
    }
}
