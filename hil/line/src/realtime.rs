//! Asking the system for punctuality.

use audio_thread_priority::{promote_current_thread_to_real_time, set_rt_priority};
use rustix::mm::{MlockAllFlags, mlockall};
use std::fmt;

/// Above ordinary threads, below the kernel's own at 50.
const PRIORITY: u8 = 40;
/// The library speaks of sound; on Linux it uses neither number.
const BUFFER_FRAMES: u32 = 0;
const SAMPLE_RATE_HZ: u32 = 48_000;

/// What the system granted. A refusal is no failure: the bench goes on, less punctually.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RealTime {
    /// Whether the thread runs before all ordinary ones (`SCHED_FIFO`), or why not.
    pub priority: Result<(), String>,
    /// Whether the memory that the program has by now stays in RAM, or why not. Memory it takes
    /// later is left out: under a limit, taking it would fail.
    pub memory: Result<(), String>,
}

impl RealTime {
    /// Asks for both, for the calling thread and for the whole program. It lasts as long as they.
    #[must_use]
    pub fn request() -> Self {
        set_rt_priority(Some(PRIORITY));
        let priority = promote_current_thread_to_real_time(BUFFER_FRAMES, SAMPLE_RATE_HZ)
            // The handle would only serve to give the priority back.
            .map(|_| ())
            .map_err(|error| error.to_string());
        let memory = mlockall(MlockAllFlags::CURRENT).map_err(|errno| errno.to_string());
        Self { priority, memory }
    }
}

impl fmt::Display for RealTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.priority {
            Ok(()) => write!(f, "SCHED_FIFO priority {PRIORITY}, ")?,
            Err(why) => write!(f, "no real-time priority ({why}; `rtprio` in limits.conf), ")?,
        };
        match &self.memory {
            Ok(()) => write!(f, "memory locked"),
            Err(why) => write!(f, "memory not locked ({why}; `memlock` in limits.conf)"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_granted_and_what_was_not_is_said() {
        let granted = RealTime { priority: Ok(()), memory: Ok(()) };
        assert_eq!(granted.to_string(), "SCHED_FIFO priority 40, memory locked");
        let refused = RealTime { priority: Err("no".into()), memory: Err("never".into()) };
        assert_eq!(
            refused.to_string(),
            "no real-time priority (no; `rtprio` in limits.conf), memory not locked (never; \
             `memlock` in limits.conf)"
        );
    }
}
