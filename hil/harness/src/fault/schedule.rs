//! When the events of one fault begin.

use super::{Fault, Trigger};
use struna_kernel::{Channel, RandomStream, Seed, SimTime};

/// Beginnings of events, one after the other.
#[derive(Debug, Clone)]
pub(super) struct Schedule {
    fault: Fault,
    stream: RandomStream,
    begun: u64,
    next: Option<SimTime>,
    /// Next byte of a trigger by the byte, counted from the start of the clean stream.
    next_byte: u64,
}

impl Schedule {
    pub(super) fn new(fault: Fault, seed: Seed, stream: u64) -> Self {
        let stream = RandomStream::new(seed, Channel::FaultTime, stream);
        let mut schedule = Self { fault, stream, begun: 0, next: None, next_byte: u64::MAX };
        if let Trigger::PerByte { .. } = fault.trigger {
            schedule.next_byte = 0;
            schedule.advance_byte();
        } else {
            schedule.next = schedule.beginning(SimTime::ZERO);
        }
        schedule
    }

    /// The next beginning, if it has come by `time`; `None` for faults that come by the byte.
    pub(super) fn due(&self, time: SimTime) -> Option<SimTime> {
        self.next.filter(|next| *next <= time)
    }

    /// Goes on to the event after the one that began at `begin` and lasts until `end`.
    pub(super) fn advance(&mut self, end: SimTime) {
        self.begun += 1;
        self.next = self.beginning(end);
    }

    /// The next byte to hit, if it lies before `end`.
    pub(super) fn due_byte(&self, end: u64) -> Option<u64> {
        (self.next_byte < end).then_some(self.next_byte)
    }

    /// Goes on to the byte after that.
    pub(super) fn advance_byte(&mut self) {
        let Trigger::PerByte { rate_per_byte } = self.fault.trigger else { return };
        let wait = exponential(&mut self.stream) / rate_per_byte;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "not negative; a float-to-int cast saturates"
        )]
        let bytes = wait as u64;
        // The first may be hit at once; each later one lies behind the one before.
        let step = u64::from(self.begun > 0);
        self.begun += 1;
        self.next_byte = self.next_byte.saturating_add(bytes).saturating_add(step);
    }

    fn beginning(&mut self, after: SimTime) -> Option<SimTime> {
        match self.fault.trigger {
            Trigger::At(time) => (self.begun == 0).then_some(time),
            Trigger::Every { first, period_s, jitter_s } => {
                let late_s = self.begun as f64 * period_s + jitter_s * self.stream.uniform();
                later(first, late_s)
            }
            Trigger::Random { rate_hz } => later(after, exponential(&mut self.stream) / rate_hz),
            Trigger::PerByte { .. } => None,
        }
    }
}

/// The time `wait_s` after `time`; none when time ends before.
fn later(time: SimTime, wait_s: f64) -> Option<SimTime> {
    let wait = SimTime::from_s(wait_s).ok()?;
    time.as_ns().checked_add(wait.as_ns()).map(SimTime::from_ns)
}

/// Exponential with mean 1.
fn exponential(stream: &mut RandomStream) -> f64 {
    -(-stream.uniform()).ln_1p()
}
