//! The host's monotonic clock, for arrival times and back-off.

use rustix::io::Errno;
use rustix::thread::clock_nanosleep_relative;
use rustix::time::{ClockId, Timespec, clock_gettime};
use struna_kernel::SimTime;

const NS_PER_S: i64 = 1_000_000_000;

/// Time since it was started, by the clock that nobody sets.
#[derive(Debug, Clone, Copy)]
pub struct MonotonicClock {
    start_ns: i64,
}

impl MonotonicClock {
    /// Starts it: [`SimTime::ZERO`] is now.
    #[must_use]
    pub fn start() -> Self {
        Self { start_ns: monotonic_ns() }
    }

    /// The time since the start.
    #[must_use]
    pub fn now(&self) -> SimTime {
        SimTime::from_ns(monotonic_ns().saturating_sub(self.start_ns))
    }

    /// Waits for `span`, less if a signal comes.
    pub fn wait(&self, span: SimTime) {
        let ns = span.as_ns().max(0);
        let request = Timespec { tv_sec: ns / NS_PER_S, tv_nsec: ns % NS_PER_S };
        // An interrupted wait is over: who interrupts wants to be heard.
        let _: Result<(), Errno> = match clock_nanosleep_relative(ClockId::Monotonic, &request) {
            rustix::thread::NanosleepRelativeResult::Err(errno) => Err(errno),
            _ => Ok(()),
        };
    }
}

/// Nanoseconds on the system's monotonic clock, the same in every process of this machine; it
/// starts at boot, so they fit for three centuries.
#[must_use]
pub fn monotonic_ns() -> i64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec.saturating_mul(NS_PER_S).saturating_add(now.tv_nsec)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_starts_at_zero_and_goes_forward() {
        let clock = MonotonicClock::start();
        let mut last = SimTime::ZERO;
        for _ in 0..100 {
            let now = clock.now();
            assert!(now >= last);
            last = now;
        }
        clock.wait(SimTime::from_ns(1000));
        assert!(clock.now().as_ns() >= last.as_ns() + 1000);
    }
}
