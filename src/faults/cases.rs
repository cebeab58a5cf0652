//! The faults that are tried, with their sizes and how often.

use super::Stream;
use super::matrix::Suite;
use struna_gyro::Rail;
use struna_gyro::datasheet::rad_s_from_deg_s;
use struna_harness::fault::{Fault, FaultKind, FaultPlan, Trigger};
use struna_kernel::SimTime;

/// How often a fault is tried and how long it lasts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// One frame or byte, twice a second.
    Byte,
    /// A moment or 0.2 s, every three seconds.
    Short,
    /// 5 s, every fifteen.
    Persistent,
    /// Of the clock: every twenty-five seconds, since twelve are remembered.
    Timing,
}

impl Family {
    /// Seconds from event to event, and by how much each may be late. Odd numbers, so that events
    /// meet every phase of motion and bridge.
    const fn spacing_s(self) -> (f64, f64) {
        match self {
            Self::Byte => (0.45, 0.09),
            Self::Short => (3.07, 1.3),
            Self::Persistent => (15.13, 6.0),
            Self::Timing => (25.3, 5.0),
        }
    }

    /// Events in a trial.
    #[must_use]
    pub const fn events(self, suite: &Suite) -> u32 {
        match self {
            Self::Byte => suite.byte_events,
            Self::Short => suite.short_events,
            Self::Persistent | Self::Timing => suite.long_events,
        }
    }
}

/// One row of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Case {
    /// What is injected.
    pub kind: FaultKind,
    /// Its size for people.
    pub size: &'static str,
    /// How often and how long.
    pub family: Family,
    /// Length of each event, s; zero for a moment.
    pub duration_s: f64,
}

impl Case {
    /// The fault of this case in a plan of its own, beginning at `first_s`.
    ///
    /// # Panics
    /// Never: the numbers are constant and tested.
    #[must_use]
    pub fn fault(&self, first_s: f64) -> Fault {
        let time = |s| SimTime::from_s(s).expect("some seconds");
        let (period_s, jitter_s) = self.family.spacing_s();
        let trigger = Trigger::Every { first: time(first_s), period_s, jitter_s };
        Fault { kind: self.kind, trigger, duration: time(self.duration_s) }
    }

    /// The plan of that fault.
    ///
    /// # Panics
    /// Never: every case is tested.
    #[must_use]
    pub fn plan(&self, first_s: f64) -> FaultPlan {
        FaultPlan::new(vec![self.fault(first_s)]).expect("every case is tested")
    }

    /// Length of a trial with `events` events, s.
    #[must_use]
    pub fn trial_s(&self, first_s: f64, events: u32) -> f64 {
        let (period_s, _) = self.family.spacing_s();
        first_s + f64::from(events) * period_s
    }
}

/// The catalogue for a stream: every kind, with sizes that suit the gyro.
#[must_use]
pub fn cases(stream: Stream) -> Vec<Case> {
    let adis = stream == Stream::Adis;
    let rate = |fine: f64, coarse: f64| rad_s_from_deg_s(if adis { coarse } else { fine });
    let word = |fine, coarse| if adis { coarse } else { fine };
    let byte = |kind, size| Case { kind, size, family: Family::Byte, duration_s: 0.0 };
    let moment = |kind, size| Case { kind, size, family: Family::Short, duration_s: 0.0 };
    let short = |kind, size| Case { kind, size, family: Family::Short, duration_s: 0.2 };
    let long = |kind, size| Case { kind, size, family: Family::Persistent, duration_s: 5.0 };
    let timing = |kind, size, duration_s| Case { kind, size, family: Family::Timing, duration_s };
    let (bias_rad_s, ramp_rad_s2, spike_rad_s) = (rate(0.5, 5.0), rate(0.1, 1.0), rate(10.0, 30.0));
    vec![
        byte(FaultKind::ByteDrop, ""),
        byte(FaultKind::BitFlip, ""),
        byte(FaultKind::DuplicateByte, ""),
        byte(FaultKind::InsertedByte, ""),
        byte(FaultKind::Burst { bytes: 8 }, "8 bytes"),
        byte(FaultKind::Truncated, ""),
        moment(FaultKind::WrongValue, "whole range"),
        byte(FaultKind::SwappedFrames, ""),
        byte(FaultKind::DuplicatedFrame, ""),
        short(FaultKind::Stuck, "0.2 s"),
        short(FaultKind::Saturation { rail: Rail::Positive }, "0.2 s"),
        long(FaultKind::BiasStep { rate_rad_s: bias_rad_s }, word("0.5 deg/s", "5 deg/s")),
        long(FaultKind::BiasRamp { rate_rad_s2: ramp_rad_s2 }, word("0.1 deg/s2", "1 deg/s2")),
        long(FaultKind::ScaleChange { share: 0.05 }, "+5 %"),
        long(FaultKind::NoiseChange { factor: 3.0 }, "x3"),
        moment(FaultKind::Spike { rate_rad_s: spike_rad_s }, word("10 deg/s", "30 deg/s")),
        short(FaultKind::Dropout, "0.2 s"),
        short(FaultKind::PortLoss, "0.2 s"),
        short(FaultKind::BaudError { share: 0.08 }, "+8 %"),
        short(FaultKind::BaudError { share: 0.02 }, "+2 %"),
        long(FaultKind::Jitter { delay_max_s: 0.01 }, "0..10 ms"),
        timing(FaultKind::ClockDrift { share: 2e-3 }, "2000 ppm", 5.0),
        timing(FaultKind::ClockDrift { share: 1e-4 }, "100 ppm", 5.0),
        timing(FaultKind::ClockJump { jump_s: 0.03 }, "30 ms", 0.0),
        timing(FaultKind::Delay { delay_s: 0.01 }, "10 ms", 5.0),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_case_of_every_stream_is_a_plan() {
        for stream in Stream::ALL {
            for case in cases(stream) {
                assert_eq!(case.fault(3.0).validate(), Ok(()), "{case:?}");
            }
        }
    }
}
