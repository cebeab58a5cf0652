//! One byte after another, each taking its symbols.

use super::later;
use struna_kernel::SimTime;

const NS_PER_S: f64 = 1e9;

/// The transmitter: knows when it is free.
#[derive(Debug, Clone)]
pub(super) struct Uart {
    byte_ns: f64,
    /// Start of the present run of bytes without a pause; times are counted from it, so that
    /// rounding does not add up.
    busy_since: SimTime,
    bytes: u64,
}

impl Uart {
    pub(super) fn new(baud: f64, bits_per_byte: u32) -> Self {
        let byte_ns = byte_ns(baud, bits_per_byte);
        Self { byte_ns, busy_since: SimTime::from_ns(i64::MIN), bytes: 0 }
    }

    /// Sends one byte, not before `ready`; returns the end of its last symbol.
    pub(super) fn carry(&mut self, ready: SimTime) -> SimTime {
        if ready > self.free_at() {
            self.busy_since = ready;
            self.bytes = 0;
        }
        self.bytes += 1;
        self.free_at()
    }

    /// Changes the length of bytes not yet sent.
    pub(super) fn set_byte_ns(&mut self, byte_ns: f64) {
        self.busy_since = self.free_at();
        self.bytes = 0;
        self.byte_ns = byte_ns;
    }

    pub(super) fn free_at(&self) -> SimTime {
        #[expect(clippy::cast_possible_truncation, reason = "a float-to-int cast saturates")]
        let busy_ns = (self.bytes as f64 * self.byte_ns).round() as i64;
        later(self.busy_since, busy_ns)
    }
}

/// How long a byte takes, ns.
pub(super) fn byte_ns(baud: f64, bits_per_byte: u32) -> f64 {
    f64::from(bits_per_byte) * NS_PER_S / baud
}
