//! When a gyro samples: by a clock of its own.

use crate::ClockParams;
use struna_kernel::{AddressedRandom, Channel, GridWalk, RandomStream, SampleGrid, Seed, SimTime};

/// The clock's rate stops drifting after this long, so that it never runs backwards.
const DRIFT_S_MAX: f64 = 1e7;
/// Jitter beyond this share of the interval is cut, so that no sample overtakes another.
const JITTER_SHARE_MAX: f64 = 0.45;
const NS_PER_S: f64 = 1e9;

/// The true instants of a gyro's samples.
///
/// A gyro counts periods of a clock that is fast or slow by some parts in a million, differently
/// from run to run, drifts, and trembles. The instant of sample k follows from k, seed and run
/// alone, in whatever order it is asked for, and never decreases with k. A perfect clock gives the
/// instants of its [`SampleGrid`] to the nanosecond.
#[derive(Debug, Clone)]
pub struct SampleClock {
    walk: GridWalk,
    /// Error of the true period, and half its change per second of the gyro's own time.
    period_error: f64,
    half_period_drift_per_s: f64,
    jitter: Option<Box<Jitter>>,
}

#[derive(Debug, Clone)]
struct Jitter {
    sigma_s: f64,
    limit_s: f64,
    numbers: AddressedRandom,
}

impl SampleClock {
    /// The clock of run `run` of the campaign `seed` that means to keep `grid`. Values that
    /// [`crate::GyroParams::validate`] refuses are not looked at here.
    #[must_use]
    pub fn new(grid: SampleGrid, params: &ClockParams, seed: Seed, run: u64) -> Self {
        let spread = RandomStream::new(seed, Channel::GyroClockOffset, run).standard_normal();
        let rate_error = params.offset + params.turn_on_sigma * spread;
        let jitter = (params.jitter_s > 0.0).then(|| {
            Box::new(Jitter {
                sigma_s: params.jitter_s,
                limit_s: JITTER_SHARE_MAX * grid.period_s(),
                numbers: AddressedRandom::new(seed, Channel::GyroClockJitter, run),
            })
        });
        Self {
            walk: GridWalk::new(grid),
            period_error: -rate_error / (1.0 + rate_error),
            half_period_drift_per_s: -0.5 * params.drift_per_s,
            jitter,
        }
    }

    /// The true instant of sample `k`. Changes nothing but what is kept ready for neighbours.
    #[must_use]
    pub fn time_of(&mut self, k: u64) -> SimTime {
        let ideal = self.walk.time_of(k);
        if self.is_perfect() {
            return ideal;
        }
        let own_s = ideal.as_s();
        let drifted_s = own_s.min(DRIFT_S_MAX);
        // Beyond the end of drift the last rate holds.
        let drift_s =
            self.half_period_drift_per_s * drifted_s * (drifted_s + 2.0 * (own_s - drifted_s));
        let jitter_s = self.jitter.as_mut().map_or(0.0, |jitter| jitter.at(k));
        let late_ns = (own_s * self.period_error + drift_s + jitter_s) * NS_PER_S;
        #[expect(clippy::cast_possible_truncation, reason = "the cast saturates, as the sum does")]
        let late_ns = late_ns.round() as i64;
        SimTime::from_ns(ideal.as_ns().saturating_add(late_ns).max(0))
    }

    /// The grid that it means to keep: the gyro's own time.
    #[must_use]
    pub fn grid(&self) -> SampleGrid {
        self.walk.grid()
    }

    /// Relative error of the sample rate at the start of this run, positive when the clock is
    /// fast: truth that only a score may look at.
    #[must_use]
    pub fn rate_error(&self) -> f64 {
        -self.period_error / (1.0 + self.period_error)
    }

    fn is_perfect(&self) -> bool {
        self.period_error == 0.0 && self.half_period_drift_per_s == 0.0 && self.jitter.is_none()
    }
}

impl Jitter {
    /// Sample 0 is the start of the run and does not tremble.
    fn at(&mut self, k: u64) -> f64 {
        if k == 0 {
            return 0.0;
        }
        let jitter_s = self.sigma_s * self.numbers.standard_normal(k);
        jitter_s.clamp(-self.limit_s, self.limit_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SEED: Seed = Seed(42);

    fn clock(params: ClockParams, run: u64) -> SampleClock {
        SampleClock::new(SampleGrid::new(SimTime::ZERO, 300.0).unwrap(), &params, SEED, run)
    }

    #[test]
    fn a_perfect_clock_keeps_the_grid_to_the_nanosecond() {
        let mut perfect = clock(ClockParams::default(), 0);
        let grid = perfect.grid();
        for k in (0..10_000).chain([1 << 40, u64::MAX]) {
            assert_eq!(perfect.time_of(k), grid.time_of(k));
        }
        assert!(perfect.rate_error() == 0.0);
    }

    #[test]
    fn a_fast_clock_takes_its_samples_early() {
        let mut fast = clock(ClockParams { offset: 0.02, ..ClockParams::default() }, 0);
        for seconds in [1_u32, 480, 86_400] {
            let ideal_s = f64::from(seconds);
            let time_s = fast.time_of(u64::from(seconds) * 300).as_s();
            // Two times rounded to the nanosecond; half of one each.
            assert!((time_s - ideal_s / 1.02).abs() < 1.1e-9, "{time_s}");
        }
        assert!((fast.rate_error() - 0.02).abs() < 1e-15);
    }

    #[test]
    fn drift_adds_up_with_the_square_of_time() {
        let mut drifting = clock(ClockParams { drift_per_s: 1e-9, ..ClockParams::default() }, 0);
        let early_s = 1000.0 - drifting.time_of(300_000).as_s();
        assert!((early_s - 0.5 * 1e-9 * 1e6).abs() < 1.1e-9, "{early_s}");
        // And with time alone once it has stopped: 5e4 s early at 1e7 s, 1e-2 of what follows.
        let late_s = 3e7 - drifting.time_of(9_000_000_000).as_s();
        assert!((late_s - (5e4 + 2e7 * 1e-2)).abs() < 1e-6, "{late_s}");
    }

    #[test]
    fn offsets_spread_from_run_to_run_as_asked_for() {
        let params = ClockParams { turn_on_sigma: 50e-6, ..ClockParams::default() };
        let runs = 10_000;
        let sum: f64 = (0..runs).map(|run| clock(params, run).rate_error().powi(2)).sum();
        let ratio = (sum / runs as f64).sqrt() / 50e-6;
        // Four standard errors of a deviation, √(1/2n) each.
        assert!((ratio - 1.0).abs() < 4.0 / (2.0 * runs as f64).sqrt(), "{ratio}");
    }

    #[test]
    fn jitter_has_its_deviation_and_does_not_add_up() {
        let mut trembling = clock(ClockParams { jitter_s: 20e-6, ..ClockParams::default() }, 0);
        let grid = trembling.grid();
        let n = 50_000;
        let late_s =
            |k: u64, clock: &mut SampleClock| clock.time_of(k).seconds_since(grid.time_of(k));
        let sum: f64 = (1..=n).map(|k| late_s(k, &mut trembling).powi(2)).sum();
        let ratio = (sum / n as f64).sqrt() / 20e-6;
        // Four standard errors; rounding to the nanosecond is 1e-9 of the variance.
        assert!((ratio - 1.0).abs() < 4.0 / (2.0 * n as f64).sqrt(), "{ratio}");
    }

    proptest! {
        #[test]
        fn instants_never_decrease_and_do_not_depend_on_the_order_of_asking(
            offset in -0.1_f64..=0.1,
            drift_per_s in -1e-8_f64..=1e-8,
            jitter_share in 0.0_f64..=0.1,
            start in 0_u64..4_000_000_000,
            run in 0_u64..4,
        ) {
            let jitter_s = jitter_share / 300.0;
            let params = ClockParams { offset, turn_on_sigma: 0.001, drift_per_s, jitter_s };
            let mut forwards = clock(params, run);
            let times: Vec<_> = (start..start + 100).map(|k| forwards.time_of(k)).collect();
            prop_assert!(times.is_sorted(), "{times:?}");
            let mut backwards = clock(params, run);
            for (place, time) in times.iter().enumerate().rev() {
                prop_assert_eq!(backwards.time_of(start + place as u64), *time);
            }
        }
    }
}
