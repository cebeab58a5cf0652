//! Holding simulated time to the wall clock: the one corner that reads a clock.

use rustix::io::Errno;
use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec, clock_gettime};
use struna_kernel::SimTime;

const NS_PER_S: i64 = 1_000_000_000;

/// How punctual a [`Pacer`] has been. For reports: nothing may be decided by it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Lateness {
    /// Waits so far.
    pub waits: u64,
    /// Waits whose instant had passed before they began: the bench itself had fallen behind.
    pub behind: u64,
    max_ns: i64,
    sum_ns: i128,
}

impl Lateness {
    /// The longest delay of a wake-up after its instant, s.
    #[must_use]
    pub fn max_s(&self) -> f64 {
        self.max_ns as f64 / NS_PER_S as f64
    }

    /// The mean delay of a wake-up after its instant, s; zero before the first wait.
    #[must_use]
    pub fn mean_s(&self) -> f64 {
        if self.waits == 0 {
            return 0.0;
        }
        self.sum_ns as f64 / self.waits as f64 / NS_PER_S as f64
    }

    fn record(&mut self, behind: bool, late_ns: i64) {
        self.waits += 1;
        self.behind += u64::from(behind);
        self.max_ns = self.max_ns.max(late_ns);
        self.sum_ns += i128::from(late_ns);
    }
}

/// Waits for the instants of simulated time on the monotonic clock.
///
/// Every deadline is absolute, counted from one start: a late wake-up delays itself and nothing
/// after it, and a bench that has fallen behind catches up without skipping a sample. Sleeping one
/// period after another would lose several per cent of the rate instead.
#[derive(Debug, Clone)]
pub struct Pacer {
    start_ns: i64,
    lateness: Lateness,
}

impl Pacer {
    /// Starts the clock: [`SimTime::ZERO`] is now.
    #[must_use]
    pub fn start() -> Self {
        Self { start_ns: now_ns(), lateness: Lateness::default() }
    }

    /// Sleeps until `time` has come; returns at once when it has passed.
    pub fn wait_until(&mut self, time: SimTime) {
        let deadline_ns = deadline_ns(self.start_ns, time);
        let behind = now_ns() > deadline_ns;
        let deadline = timespec(deadline_ns);
        while !behind && clock_nanosleep_absolute(ClockId::Monotonic, &deadline) == Err(Errno::INTR)
        {
        }
        self.lateness.record(behind, now_ns().saturating_sub(deadline_ns).max(0));
    }

    /// How punctual it has been.
    #[must_use]
    pub const fn lateness(&self) -> Lateness {
        self.lateness
    }
}

/// The clock reading at which `time` is due; instants before the start are due at the start.
fn deadline_ns(start_ns: i64, time: SimTime) -> i64 {
    start_ns.saturating_add(time.as_ns().max(0))
}

fn timespec(ns: i64) -> Timespec {
    Timespec { tv_sec: ns / NS_PER_S, tv_nsec: ns % NS_PER_S }
}

/// Nanoseconds on the monotonic clock, which starts at boot: they fit for three centuries.
pub(crate) fn now_ns() -> i64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec.saturating_mul(NS_PER_S).saturating_add(now.tv_nsec)
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
            let expected_ns = start_ns + i64::from(hour) * 3600 * NS_PER_S;
            assert_eq!(deadline_ns(start_ns, grid.time_of(k)), expected_ns);
        }
    }

    #[test]
    fn a_pacer_that_is_behind_counts_it_and_goes_on() {
        let mut pacer = Pacer::start();
        // Due a second before the start of the clock's own life: certainly passed.
        pacer.start_ns = -NS_PER_S;
        for k in 0..3 {
            pacer.wait_until(SimTime::from_ns(k));
        }
        let lateness = pacer.lateness();
        assert_eq!((lateness.waits, lateness.behind), (3, 3));
        assert!(lateness.max_s() >= 1.0 && lateness.mean_s() >= 1.0);
    }

    #[test]
    fn a_wait_never_ends_before_its_instant() {
        let mut pacer = Pacer::start();
        for k in 1..=20 {
            pacer.wait_until(SimTime::from_ns(k * 100_000));
            assert!(now_ns() >= pacer.start_ns + k * 100_000);
        }
        assert_eq!(pacer.lateness().waits, 20);
    }

    #[test]
    fn the_mean_and_the_maximum_are_those_of_the_delays() {
        let mut lateness = Lateness::default();
        assert!(lateness.mean_s().abs() < f64::EPSILON);
        for late_ns in [1_000_000, 5_000_000, 0] {
            lateness.record(late_ns == 0, late_ns);
        }
        assert_eq!((lateness.waits, lateness.behind), (3, 1));
        // One rounding in each of three divisions.
        assert!((lateness.mean_s() - 0.002).abs() < 1e-15);
        assert!((lateness.max_s() - 0.005).abs() < 1e-15);
    }

    proptest! {
        #[test]
        fn deadlines_keep_the_order_of_time(
            start_ns in 0..i64::MAX,
            (a, b) in any::<(i64, i64)>(),
        ) {
            let (early, late) = (a.min(b), a.max(b));
            let early_ns = deadline_ns(start_ns, SimTime::from_ns(early));
            let late_ns = deadline_ns(start_ns, SimTime::from_ns(late));
            prop_assert!(start_ns <= early_ns && early_ns <= late_ns);
            let spec = timespec(late_ns);
            prop_assert!((0..NS_PER_S).contains(&spec.tv_nsec));
            prop_assert_eq!(spec.tv_sec * NS_PER_S + spec.tv_nsec, late_ns);
        }
    }
}
