//! Times for estimators: even, and never back.

use struna_kernel::SimTime;

const NS_PER_S: f64 = 1e9;
/// A clock behind by more than this is not slewed: real time has passed without samples.
const JUMP_NS: f64 = 0.25e9;
/// How fast an offset is slewed away: a fraction 1/e is left after this.
const SLEW_TIME_NS: f64 = 1e9;

/// Times of the instants between samples.
///
/// An estimator needs spans that are right to the sensor's own jitter, and a time base whose line
/// moves by microseconds with each fit would give it other spans. So this clock runs at the
/// estimated period and is slewed towards the time base, by a bounded share of each period. It
/// starts at zero, at the beginning of the first sample.
#[derive(Debug, Clone)]
pub struct SampleClock {
    /// Instant, its time, and the time of the zero by the time base.
    anchor: Option<Anchor>,
    period_ns: f64,
}

#[derive(Debug, Clone, Copy)]
struct Anchor {
    instant: u64,
    time_ns: i64,
    zero_ns: i64,
}

impl SampleClock {
    /// A clock that has seen nothing.
    #[must_use]
    pub const fn new(period_s: f64) -> Self {
        Self { anchor: None, period_ns: period_s * NS_PER_S }
    }

    /// Moves on to `instant`, the end of a sample, whose time by the time base is `target`, with
    /// samples `period_s` apart and each period changed by at most the share `slew` of it. Returns
    /// how far the clock jumped, s: time that no slewing makes up.
    pub fn advance(
        &mut self,
        instant: u64,
        target: SimTime,
        period_s: f64,
        slew: f64,
    ) -> Option<f64> {
        self.period_ns = period_s * NS_PER_S;
        let Some(anchor) = self.anchor else {
            let time_ns = nearest(self.period_ns * instant as f64);
            let zero_ns = target.as_ns().saturating_sub(time_ns);
            self.anchor = Some(Anchor { instant, time_ns, zero_ns });
            return None;
        };
        let expected_ns = self.time_of(instant).as_ns();
        let wanted_ns = target.as_ns().saturating_sub(anchor.zero_ns);
        let behind_ns = wanted_ns.saturating_sub(expected_ns) as f64;
        let passed_ns = expected_ns.saturating_sub(anchor.time_ns).max(0) as f64;
        let jumps = behind_ns > JUMP_NS + slew * passed_ns;
        let time_ns = if jumps {
            wanted_ns
        } else {
            let share = (passed_ns / SLEW_TIME_NS).min(1.0);
            let bound_ns = slew * passed_ns;
            let slewed_ns = (behind_ns * share).clamp(-bound_ns, bound_ns);
            expected_ns.saturating_add(nearest(slewed_ns))
        };
        self.anchor = Some(Anchor { instant, time_ns, ..anchor });
        jumps.then(|| behind_ns / NS_PER_S)
    }

    /// The time of `instant` as the clock runs now.
    #[must_use]
    pub fn time_of(&self, instant: u64) -> SimTime {
        let (from, time_ns) = self.anchor.map_or((0, 0), |anchor| (anchor.instant, anchor.time_ns));
        let periods = (i128::from(instant) - i128::from(from)) as f64;
        SimTime::from_ns(time_ns.saturating_add(nearest(periods * self.period_ns)))
    }

    /// What the clock showed when the host's clock, as the time base corrects it, showed `time`.
    #[must_use]
    pub fn at(&self, time: SimTime) -> SimTime {
        let zero_ns = self.anchor.map_or(0, |anchor| anchor.zero_ns);
        SimTime::from_ns(time.as_ns().saturating_sub(zero_ns))
    }
}

#[expect(clippy::cast_possible_truncation, reason = "a float-to-int cast saturates")]
fn nearest(ns: f64) -> i64 {
    ns.round() as i64
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 0.01;

    fn ms(ms: i64) -> SimTime {
        SimTime::from_ns(ms * 1_000_000)
    }

    #[test]
    fn an_offset_is_slewed_away_and_time_never_goes_back() {
        let mut clock = SampleClock::new(PERIOD_S);
        assert_eq!(clock.advance(1, ms(1010), PERIOD_S, 2e-3), None);
        let mut last = clock.time_of(1);
        assert_eq!(last, ms(10), "zero is where the first sample began");
        for k in 2..=1000_i64 {
            // The time base finds its phase 8 ms lower.
            let jumped = clock.advance(k.cast_unsigned(), ms(1000 + 10 * k - 8), PERIOD_S, 2e-3);
            assert_eq!(jumped, None);
            let now = clock.time_of(k.cast_unsigned());
            let span_s = now.seconds_since(last);
            // 2e-3 of a period, and the rounding of a nanosecond.
            assert!((span_s / PERIOD_S - 1.0).abs() <= 2e-3 + 1e-6, "a period of {span_s} s");
            last = now;
        }
        // At 2 ms a second down to 2 ms within 3 s, and 7 time constants more.
        assert!((last.as_s() - 9.992).abs() < 1e-5, "{last}");
    }

    #[test]
    fn time_that_passed_without_samples_is_a_jump() {
        let mut clock = SampleClock::new(PERIOD_S);
        clock.advance(1, ms(10), PERIOD_S, 2e-3);
        let jumped = clock.advance(2, ms(1020), PERIOD_S, 2e-3).unwrap();
        // Differences of whole milliseconds in nanoseconds.
        assert!((jumped - 1.0).abs() < 1e-9, "{jumped} s");
        assert_eq!(clock.time_of(2), ms(1020));
    }

    #[test]
    fn a_clock_far_ahead_is_slowed_down_and_not_set_back() {
        let mut clock = SampleClock::new(PERIOD_S);
        clock.advance(1, ms(10_000), PERIOD_S, 2e-3);
        assert_eq!(clock.advance(2, ms(0), PERIOD_S, 2e-3), None);
        assert_eq!(clock.time_of(2), SimTime::from_ns(10_000_000 + 9_980_000));
    }
}
