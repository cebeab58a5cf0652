//! Which sample a frame is: from its counter, or inferred.

use super::Declared;
use struna_kernel::SimTime;

/// What the counter says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Step {
    /// The first frame.
    First,
    /// A later sample: so many after the last one, and so many missing by the counter alone.
    Forward { steps: u64, missing: u64 },
    /// The counter stood still or went back.
    Back,
}

/// Follows the counter, and time where the counter is ambiguous.
#[derive(Debug, Clone)]
pub(super) struct Tracker {
    modulus: Option<u64>,
    frame_len: u64,
    period_s: f64,
    last: Option<(u64, SimTime)>,
    /// Unwrapped number of the last sample.
    index: u64,
    /// Bytes without a frame since then.
    skipped: u64,
}

impl Tracker {
    pub(super) fn new(declared: &Declared) -> Self {
        Self {
            modulus: declared.counter_modulus,
            frame_len: declared.frame_len.max(1) as u64,
            period_s: declared.period_s(),
            last: None,
            index: 0,
            skipped: 0,
        }
    }

    pub(super) fn skip(&mut self, bytes: u64) {
        self.skipped += bytes;
    }

    pub(super) const fn index(&self) -> u64 {
        self.index
    }

    /// Whether the number is the gyro's own and not inferred.
    pub(super) const fn counts(&self) -> bool {
        self.modulus.is_some()
    }

    /// Takes a frame, `index` by the decoder, come at `arrival`.
    pub(super) fn arrive(&mut self, index: u64, arrival: SimTime) -> Step {
        let skipped = std::mem::take(&mut self.skipped);
        let Some((last, last_arrival)) = self.last else {
            self.last = Some((index, arrival));
            self.index = index;
            return Step::First;
        };
        let step = match self.modulus {
            Some(modulus) => {
                let waited_s = arrival.seconds_since(last_arrival);
                self.by_counter((index % modulus + modulus - last % modulus) % modulus, waited_s)
            }
            // As many frames as their bytes were lost; what never came is not known.
            None => {
                let missing = (skipped + self.frame_len / 2) / self.frame_len;
                Step::Forward { steps: 1 + missing, missing: 0 }
            }
        };
        if let Step::Forward { steps, .. } = step {
            self.index = self.index.saturating_add(steps);
            self.last = Some((index, arrival));
        }
        step
    }

    /// `step` by the counter; whole rounds of it by the time that has passed.
    fn by_counter(&self, step: u64, waited_s: f64) -> Step {
        let modulus = self.modulus.unwrap_or(1);
        let round_s = modulus as f64 * self.period_s;
        let rest_s = waited_s - step as f64 * self.period_s;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a float-to-int cast saturates"
        )]
        let rounds = (rest_s / round_s).round().max(0.0) as u64;
        // The last fifth of the counter is read as a step back, as a line without gaps of that
        // length has it.
        if rounds == 0 && (step == 0 || step > modulus - modulus / 5) {
            return Step::Back;
        }
        let steps = rounds.saturating_mul(modulus).saturating_add(step);
        Step::Forward { steps, missing: steps - 1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tracker(counter_modulus: Option<u64>) -> Tracker {
        Tracker::new(&Declared {
            sample_rate_hz: 1000.0,
            frame_len: 10,
            counter_modulus,
            rate_max_rad_s: 1.0,
            lsb_rad_s: 1e-3,
            noise_sigma_rad_s: 1e-2,
            noise_bandwidth_hz: None,
            acceleration_max_rad_s2: 1.0,
            bias_max_rad_s: 0.0,
        })
    }

    fn at_ms(ms: i64) -> SimTime {
        SimTime::from_ns(ms * 1_000_000)
    }

    fn forward(steps: u64, missing: u64) -> Step {
        Step::Forward { steps, missing }
    }

    #[test]
    fn whole_rounds_of_the_counter_are_told_by_time() {
        let mut tracker = tracker(Some(256));
        assert_eq!(tracker.arrive(250, at_ms(0)), Step::First);
        assert_eq!(tracker.arrive(251, at_ms(1)), forward(1, 0));
        assert_eq!(tracker.arrive(256 + 3, at_ms(9)), forward(8, 7));
        // 300 frames later the counter says 44, and the same value after 256 says nothing.
        assert_eq!(tracker.arrive(256 + 47, at_ms(309)), forward(300, 299));
        assert_eq!(tracker.arrive(256 + 47, at_ms(565)), forward(256, 255));
        assert_eq!(tracker.index(), 250 + 1 + 8 + 300 + 256);
    }

    #[test]
    fn the_counter_goes_back_without_taking_the_index_along() {
        let mut tracker = tracker(Some(256));
        tracker.arrive(10, at_ms(0));
        assert_eq!(tracker.arrive(12, at_ms(2)), forward(2, 1));
        assert_eq!(tracker.arrive(11, at_ms(2)), Step::Back);
        assert_eq!(tracker.arrive(12, at_ms(2)), Step::Back);
        assert_eq!(tracker.arrive(13, at_ms(3)), forward(1, 0));
    }

    #[test]
    fn without_a_counter_lost_bytes_stand_for_frames() {
        let mut tracker = tracker(None);
        tracker.arrive(0, at_ms(0));
        tracker.skip(9);
        assert_eq!(tracker.arrive(1, at_ms(2)), forward(2, 0));
        tracker.skip(1);
        assert_eq!(tracker.arrive(2, at_ms(3)), forward(1, 0));
    }
}
