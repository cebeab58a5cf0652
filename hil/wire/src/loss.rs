//! How many frames are missing, told by the clock where the counter cannot.

use crate::TimingSpec;

/// Resolves losses by the time between frames.
///
/// A counter tells a gap modulo its modulus; elapsed time tells how many whole turns it made. A
/// frame without a counter tells nothing, and the gap is elapsed time over the period, rounded.
///
/// Frames arrive late and never early, and several may arrive together. So what is followed is
/// the earliest instant at which the last frame can have been sent: one period after the one
/// before it, or its arrival if that is earlier. A pure function of what it is given.
///
/// ```
/// use struna_wire::LossResolver;
///
/// // 300 frames per second, a counter of one byte.
/// let mut clock = LossResolver::new(1.0 / 300.0, 0.03);
/// assert_eq!(clock.steps_with_counter(0.0, 1, 256), 1);
/// // The counter moved by 5, but 1.73 s passed: 5 + 2 * 256 frames.
/// assert_eq!(clock.steps_with_counter(1.73, 5, 256), 517);
/// // Nothing to go by but time: 10 periods, so nine frames are missing.
/// assert_eq!(clock.steps_without_counter(1.73 + 10.0 / 300.0), 10);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LossResolver {
    period_s: f64,
    tolerance: f64,
    latency_s: f64,
    last_s: Option<f64>,
}

impl LossResolver {
    /// A resolver for frames every `period_s`, the true period longer by no more than the
    /// fraction `tolerance`.
    #[must_use]
    pub const fn new(period_s: f64, tolerance: f64) -> Self {
        Self { period_s, tolerance, latency_s: 0.0, last_s: None }
    }

    /// A resolver for a declared rate.
    #[must_use]
    pub fn of(timing: TimingSpec) -> Self {
        Self::new(1.0 / timing.rate_hz, timing.rate_tolerance)
    }

    /// The same on a line that holds bytes back for up to `latency_s`, as a USB bridge does until
    /// its packet is full. A delay as long as that is no loss.
    #[must_use]
    pub const fn with_latency_s(self, latency_s: f64) -> Self {
        Self { latency_s, ..self }
    }

    /// Frames from the last one to this one, 1 when none is missing, for a counter that has moved
    /// by `step`, 0 to `modulus - 1`; 0 for a repeated frame.
    ///
    /// Time decides only when more than half a turn of the counter has passed. It is right as long
    /// as the period is known well enough: an error of the fraction e is too much after
    /// `modulus / (2 e)` frames.
    pub fn steps_with_counter(&mut self, arrival_s: f64, step: u64, modulus: u64) -> u64 {
        let turn = modulus as f64;
        let periods = self.periods_since_last(arrival_s).unwrap_or(0.0);
        let turns = if periods > turn / 2.0 { whole((periods - step as f64) / turn) } else { 0 };
        let steps = step.saturating_add(turns.saturating_mul(modulus));
        self.follow(arrival_s, steps);
        steps
    }

    /// Frames from the last one to this one, 1 when none is missing, by time alone.
    pub fn steps_without_counter(&mut self, arrival_s: f64) -> u64 {
        let late = self.latency_s / self.period_s + 0.5;
        let periods = self.periods_since_last(arrival_s).unwrap_or(1.0);
        let steps = if periods - 1.0 > late { whole(periods) } else { 1 };
        self.follow(arrival_s, steps);
        steps
    }

    /// Nominal periods since the earliest instant at which the last frame can have been sent.
    pub(crate) fn periods_since_last(&self, arrival_s: f64) -> Option<f64> {
        self.last_s.map(|last_s| (arrival_s - last_s) / self.period_s)
    }

    fn follow(&mut self, arrival_s: f64, steps: u64) {
        let longest_s = self.period_s * (1.0 + self.tolerance);
        let due_s = self.last_s.map(|last_s| last_s + steps as f64 * longest_s);
        self.last_s = Some(due_s.map_or(arrival_s, |due_s| due_s.min(arrival_s)));
    }
}

/// The nearest whole number, none below 0.
fn whole(number: f64) -> u64 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
    let whole = number.round().max(0.0) as u64;
    whole
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PERIOD_S: f64 = 1.0 / 300.0;

    #[test]
    fn frames_that_arrive_in_bursts_are_not_lost() {
        // A USB bridge that hands over what it has every 16 ms: 4.8 frames.
        let mut clock = LossResolver::new(PERIOD_S, 0.03).with_latency_s(0.016);
        let steps: Vec<_> = (0..3000)
            .map(|k| {
                let sent_s = f64::from(k) * PERIOD_S;
                clock.steps_without_counter((sent_s / 0.016).ceil() * 0.016)
            })
            .collect();
        assert!(steps.iter().all(|step| *step == 1), "{steps:?}");
    }

    #[test]
    fn a_gyro_that_is_slow_within_its_tolerance_loses_nothing() {
        let mut clock = LossResolver::new(PERIOD_S, 0.03);
        let steps = (0..3000).map(|k| clock.steps_without_counter(f64::from(k) * PERIOD_S * 1.029));
        assert_eq!(steps.sum::<u64>(), 3000);
    }

    proptest! {
        #[test]
        fn whole_turns_of_the_counter_come_out_right(
            modulus in 4_u64..=256,
            steps in prop::collection::vec(1_u64..2000, 1..20),
            late in prop::collection::vec(0.0_f64..0.4, 20),
            // 2000 frames at this error are at most 0.4 frames off.
            error in -2e-4_f64..2e-4,
        ) {
            let mut clock = LossResolver::new(PERIOD_S, 0.0);
            let mut sent = 0;
            clock.steps_with_counter(0.0, 1, modulus);
            for (step, late) in steps.into_iter().zip(late) {
                sent += step;
                let arrival_s = (sent as f64 * (1.0 + error) + late) * PERIOD_S;
                let told = clock.steps_with_counter(arrival_s, step % modulus, modulus);
                // Half a turn or less may be told from nothing by the counter alone.
                let visible = step as f64 > modulus as f64 / 2.0 + 1.0 || step < modulus;
                prop_assert!(!visible || told == step, "{told} for {step}");
                clock.last_s = Some(sent as f64 * (1.0 + error) * PERIOD_S);
            }
        }

        #[test]
        fn gaps_without_a_counter_are_periods(
            gaps in prop::collection::vec(1_u64..500, 1..20),
            late in prop::collection::vec(0.0_f64..0.4, 20),
        ) {
            let mut clock = LossResolver::new(PERIOD_S, 0.0);
            clock.steps_without_counter(0.0);
            let mut sent = 0;
            for (gap, late) in gaps.into_iter().zip(late) {
                sent += gap;
                // Lateness below half a period cannot be taken for a frame.
                let steps = clock.steps_without_counter((sent as f64 + late) * PERIOD_S);
                prop_assert_eq!(steps, gap);
            }
        }

        #[test]
        fn no_time_upsets_it(times in prop::collection::vec(any::<f64>(), 0..20)) {
            let mut clock = LossResolver::new(PERIOD_S, 0.5);
            for arrival_s in times {
                clock.steps_without_counter(arrival_s);
                clock.steps_with_counter(arrival_s, 255, 256);
            }
        }
    }
}
