//! What stands between the line and the host: nothing, or a USB bridge that packs bytes.

use super::later;
use struna_kernel::SimTime;

/// How received bytes are handed to the host.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Bridge {
    /// What was sent together arrives together, with its last bit.
    #[default]
    Direct,
    /// A USB bridge of the FT232 kind: it hands over a packet when that is full or when its
    /// latency timer runs out, and the host asks once in each USB frame.
    ///
    /// # Source
    /// FTDI, AN232B-04 "Small amounts of data and end of buffer conditions".
    Ftdi {
        /** Data bytes of a full packet: 62 in a 64-byte USB packet. */
        packet_bytes: usize,
        /** Latency timer: 16 ms as delivered. */
        latency_timer: SimTime,
        /** Period at which the host asks: 1 ms at full speed. */
        usb_frame: SimTime,
    },
}

/// A bridge with the bytes it holds.
#[derive(Debug, Clone)]
pub(super) struct BridgeState {
    kind: Bridge,
    held: Vec<u8>,
    /// End of the last byte taken.
    last: SimTime,
    /// When the latency timer runs out.
    timeout: SimTime,
}

impl BridgeState {
    pub(super) fn new(kind: Bridge) -> Self {
        let timeout = match kind {
            Bridge::Direct => SimTime::ZERO,
            Bridge::Ftdi { latency_timer, .. } => latency_timer,
        };
        Self { kind, held: Vec::with_capacity(64), last: SimTime::ZERO, timeout }
    }

    /// Takes a byte whose last symbol ended at `end`.
    pub(super) fn take(&mut self, end: SimTime, byte: u8, sink: &mut dyn FnMut(SimTime, &[u8])) {
        self.advance(end, sink);
        self.held.push(byte);
        self.last = end;
        if let Bridge::Ftdi { packet_bytes, latency_timer, .. } = self.kind
            && self.held.len() >= packet_bytes
        {
            self.hand_over(end, sink);
            self.timeout = later(end, latency_timer.as_ns());
        }
    }

    /// What was sent together is complete.
    pub(super) fn end_of_send(&mut self, sink: &mut dyn FnMut(SimTime, &[u8])) {
        if self.kind == Bridge::Direct {
            self.hand_over(self.last, sink);
        }
    }

    /// Runs the latency timer up to `now`. It starts anew each time it runs out, bytes or not.
    pub(super) fn advance(&mut self, now: SimTime, sink: &mut dyn FnMut(SimTime, &[u8])) {
        let Bridge::Ftdi { latency_timer, .. } = self.kind else { return };
        if self.timeout > now {
            return;
        }
        self.hand_over(self.timeout, sink);
        let period_ns = latency_timer.as_ns().max(1);
        let late_ns = now.as_ns().saturating_sub(self.timeout.as_ns());
        self.timeout = later(self.timeout, (late_ns / period_ns).saturating_add(1) * period_ns);
    }

    pub(super) fn flush(&mut self, sink: &mut dyn FnMut(SimTime, &[u8])) {
        let due = if matches!(self.kind, Bridge::Direct) { self.last } else { self.timeout };
        self.hand_over(due, sink);
    }

    fn hand_over(&mut self, time: SimTime, sink: &mut dyn FnMut(SimTime, &[u8])) {
        if self.held.is_empty() {
            return;
        }
        let asked = match self.kind {
            Bridge::Direct => time,
            Bridge::Ftdi { usb_frame, .. } => round_up(time, usb_frame),
        };
        sink(asked, &self.held);
        self.held.clear();
    }
}

/// The first multiple of `step` that is not before `time`.
fn round_up(time: SimTime, step: SimTime) -> SimTime {
    let step_ns = step.as_ns().max(1);
    let past_ns = time.as_ns().rem_euclid(step_ns);
    if past_ns == 0 { time } else { later(time, step_ns - past_ns) }
}
