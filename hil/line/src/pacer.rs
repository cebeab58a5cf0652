//! Holding simulated time to the wall clock: the one corner that reads a clock.

use crate::host_clock::monotonic_ns;
use crate::{Lateness, StopFlag};
use rustix::io::Errno;
use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec};
use struna_kernel::SimTime;

const NS_PER_S: i64 = 1_000_000_000;
/// Longest sleep before the stop flag is looked at again.
const STOP_CHECK_NS: i64 = 20_000_000;

/// How a wait ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[must_use]
pub enum Waited {
    /// The instant has come.
    Due,
    /// The wait was stopped before that.
    Stopped,
}

/// Waits for the instants of simulated time on the monotonic clock.
///
/// Every deadline is absolute, counted from one start: a late wake-up delays itself and nothing
/// after it, and a bench that has fallen behind catches up without skipping a sample. Sleeping one
/// period after another would lose several per cent of the rate instead.
#[derive(Debug, Clone)]
pub struct Pacer {
    start_ns: i64,
    speed: f64,
    lateness: Lateness,
}

impl Pacer {
    /// Starts the clock: [`SimTime::ZERO`] is now.
    #[must_use]
    pub fn start() -> Self {
        Self::at_speed(1.0)
    }

    /// The same, with `speed` simulated seconds in one of the clock. Positive.
    #[must_use]
    pub fn at_speed(speed: f64) -> Self {
        Self { start_ns: monotonic_ns(), speed, lateness: Lateness::default() }
    }

    /// Sleeps until `time` has come; returns at once when it has passed. A stopped wait ends within
    /// 20 ms and is not counted.
    pub fn wait_until(&mut self, time: SimTime, stop: &StopFlag) -> Waited {
        let due_ns = self.due_ns(time);
        let began_ns = monotonic_ns();
        if began_ns > due_ns {
            self.lateness.overrun.record(began_ns.saturating_sub(due_ns));
            return Waited::Due;
        }
        let mut now = began_ns;
        while now < due_ns {
            if stop.is_stopped() {
                return Waited::Stopped;
            }
            sleep_until(due_ns.min(now.saturating_add(STOP_CHECK_NS)));
            now = monotonic_ns();
        }
        self.lateness.oversleep.record(now.saturating_sub(due_ns));
        Waited::Due
    }

    /// What [`monotonic_ns`] reads when `time` is due; instants before the start are due at the
    /// start.
    #[must_use]
    pub fn due_ns(&self, time: SimTime) -> i64 {
        deadline_ns(self.start_ns, self.speed, time)
    }

    /// How punctual it has been.
    #[must_use]
    pub const fn lateness(&self) -> &Lateness {
        &self.lateness
    }
}

fn deadline_ns(start_ns: i64, speed: f64, time: SimTime) -> i64 {
    // Exact at speed 1 for a hundred days; the cast saturates.
    #[expect(clippy::cast_possible_truncation, reason = "a float-to-int cast saturates")]
    let after_ns = (time.as_ns().max(0) as f64 / speed) as i64;
    start_ns.saturating_add(after_ns)
}

/// Sleeps until `ns` or a signal.
fn sleep_until(ns: i64) {
    let outcome = clock_nanosleep_absolute(ClockId::Monotonic, &timespec(ns));
    debug_assert!(matches!(outcome, Ok(()) | Err(Errno::INTR)), "{outcome:?}");
}

fn timespec(ns: i64) -> Timespec {
    Timespec { tv_sec: ns / NS_PER_S, tv_nsec: ns % NS_PER_S }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use struna_kernel::SampleGrid;

    #[test]
    fn deadlines_of_a_300_hz_grid_do_not_drift() {
        let grid = SampleGrid::new(SimTime::ZERO, 300.0).unwrap();
        let start_ns = 123_456_789_012;
        for hour in [0_u32, 1, 24, 1000] {
            let k = u64::from(hour) * 3600 * 300;
            let expected_ns = i64::from(hour) * 3600 * NS_PER_S;
            for (speed, divisor) in [(1.0, 1), (4.0, 4)] {
                let due_ns = deadline_ns(start_ns, speed, grid.time_of(k));
                assert_eq!(due_ns, start_ns + expected_ns / divisor);
            }
        }
    }

    #[test]
    fn a_pacer_that_is_behind_counts_it_and_goes_on() {
        let mut pacer = Pacer::start();
        // Due a second before the start of the clock's own life: certainly passed.
        pacer.start_ns = -NS_PER_S;
        for k in 0..3 {
            assert_eq!(pacer.wait_until(SimTime::from_ns(k), &StopFlag::new()), Waited::Due);
        }
        let lateness = pacer.lateness();
        assert_eq!((lateness.overrun.count(), lateness.oversleep.count()), (3, 0));
        assert!(lateness.max_s() >= 1.0 && lateness.mean_s() >= 1.0);
    }

    #[test]
    fn a_wait_never_ends_before_its_instant() {
        let mut pacer = Pacer::start();
        for k in 1..=20 {
            let time = SimTime::from_ns(k * 100_000);
            assert_eq!(pacer.wait_until(time, &StopFlag::new()), Waited::Due);
            assert!(monotonic_ns() >= pacer.due_ns(time));
        }
        assert_eq!(pacer.lateness().waits(), 20);
    }

    #[test]
    fn a_wait_of_centuries_can_be_stopped() {
        let stop = StopFlag::new();
        let waiting = {
            let stop = stop.clone();
            std::thread::spawn(move || {
                let mut pacer = Pacer::start();
                (pacer.wait_until(SimTime::from_ns(i64::MAX), &stop), pacer.lateness().waits())
            })
        };
        stop.stop();
        assert_eq!(waiting.join().unwrap(), (Waited::Stopped, 0));
    }

    proptest! {
        #[test]
        fn deadlines_keep_the_order_of_time(
            start_ns in 0..i64::MAX,
            (a, b) in any::<(i64, i64)>(),
            speed in 1e-3..1e3,
        ) {
            let (early, late) = (a.min(b), a.max(b));
            let early_ns = deadline_ns(start_ns, speed, SimTime::from_ns(early));
            let late_ns = deadline_ns(start_ns, speed, SimTime::from_ns(late));
            prop_assert!(start_ns <= early_ns && early_ns <= late_ns);
            let spec = timespec(late_ns);
            prop_assert!((0..NS_PER_S).contains(&spec.tv_nsec));
            prop_assert_eq!(spec.tv_sec * NS_PER_S + spec.tv_nsec, late_ns);
        }
    }
}
