//! The serial line in simulated time: when bytes that leave the gyro reach the host.

mod bridge;
mod uart;

pub use bridge::Bridge;

use bridge::BridgeState;
use struna_kernel::SimTime;
use uart::Uart;

/// What the line between gyro and host consists of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineSettings {
    /// Symbols per second of the gyro's own clock. Positive.
    pub baud: f64,
    /// Symbols that one byte takes: start, data, parity and stop bits.
    pub bits_per_byte: u32,
    /// Constant delay of everything behind the last bit.
    pub latency: SimTime,
    /// What stands between the line and the host.
    pub bridge: Bridge,
}

impl LineSettings {
    /// A line of `baud` with eight data bits, no parity, one stop bit and nothing behind it.
    #[must_use]
    pub const fn direct(baud: f64) -> Self {
        Self { baud, bits_per_byte: 10, latency: SimTime::ZERO, bridge: Bridge::Direct }
    }
}

/// A serial line in simulated time.
///
/// A pseudo-terminal passes bytes at once, so all that makes a real line slow is calculated here:
/// each byte takes its symbols, bytes queue behind each other, and a USB bridge hands them over in
/// packets. The result depends on the calls alone, never on a clock.
#[derive(Debug, Clone)]
pub struct LineModel {
    settings: LineSettings,
    uart: Uart,
    bridge: BridgeState,
}

impl LineModel {
    /// An idle line.
    #[must_use]
    pub fn new(settings: LineSettings) -> Self {
        let uart = Uart::new(settings.baud, settings.bits_per_byte);
        Self { settings, uart, bridge: BridgeState::new(settings.bridge) }
    }

    /// Lets the gyro send at `ratio` times its declared baud rate from now on, as a clock that is
    /// off does. Only the timing: what a receiver makes of such bits is not the line's affair.
    pub fn set_baud_ratio(&mut self, ratio: f64) {
        let LineSettings { baud, bits_per_byte, .. } = self.settings;
        self.uart.set_byte_ns(uart::byte_ns(baud * ratio, bits_per_byte));
    }

    /// Its settings.
    #[must_use]
    pub const fn settings(&self) -> LineSettings {
        self.settings
    }

    /// Puts `bytes` on the line as soon as it is free, not before `ready`. Whatever reaches the
    /// host because of that, or would have reached it before `ready`, goes to `sink` with its
    /// arrival time; arrival times never go back.
    pub fn send(&mut self, ready: SimTime, bytes: &[u8], sink: &mut dyn FnMut(SimTime, &[u8])) {
        self.advance(ready, sink);
        let mut sink = delayed(self.settings.latency, sink);
        for byte in bytes {
            let end = self.uart.carry(ready);
            self.bridge.take(end, *byte, &mut sink);
        }
        self.bridge.end_of_send(&mut sink);
    }

    /// Lets time pass to `now`: a bridge whose timer runs out hands over what it holds.
    pub fn advance(&mut self, now: SimTime, sink: &mut dyn FnMut(SimTime, &[u8])) {
        self.bridge.advance(now, &mut delayed(self.settings.latency, sink));
    }

    /// Hands over everything still on its way.
    pub fn flush(&mut self, sink: &mut dyn FnMut(SimTime, &[u8])) {
        self.bridge.flush(&mut delayed(self.settings.latency, sink));
    }

    /// When the last byte sent so far has left the gyro.
    #[must_use]
    pub fn free_at(&self) -> SimTime {
        self.uart.free_at()
    }
}

/// `sink`, a constant `latency` later.
fn delayed(latency: SimTime, sink: &mut dyn FnMut(SimTime, &[u8])) -> impl FnMut(SimTime, &[u8]) {
    move |time, bytes| sink(later(time, latency.as_ns()), bytes)
}

/// `ns` after `time`, saturating.
fn later(time: SimTime, ns: i64) -> SimTime {
    SimTime::from_ns(time.as_ns().saturating_add(ns))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const MS: i64 = 1_000_000;

    fn arrivals(
        settings: LineSettings,
        period_ns: i64,
        frames: i64,
        len: usize,
    ) -> Vec<(i64, usize)> {
        let mut line = LineModel::new(settings);
        let mut arrivals = Vec::new();
        let mut note = |time: SimTime, bytes: &[u8]| arrivals.push((time.as_ns(), bytes.len()));
        for k in 0..frames {
            line.send(SimTime::from_ns(k * period_ns), &vec![0x55; len], &mut note);
        }
        line.flush(&mut note);
        arrivals
    }

    fn ftdi(latency_ms: i64) -> LineSettings {
        let bridge = Bridge::Ftdi {
            packet_bytes: 62,
            latency_timer: SimTime::from_ns(latency_ms * MS),
            usb_frame: SimTime::from_ns(MS),
        };
        LineSettings { bridge, ..LineSettings::direct(115_200.0) }
    }

    #[test]
    fn a_frame_takes_its_symbols() {
        // 11 bytes of 10 symbols at 115200 baud: 954.861 us.
        let arrivals = arrivals(LineSettings::direct(115_200.0), 10 * MS, 2, 11);
        assert_eq!(arrivals, [(954_861, 11), (10_954_861, 11)]);
    }

    #[test]
    fn frames_queue_on_a_line_that_is_too_slow() {
        let arrivals = arrivals(LineSettings::direct(9600.0), MS, 3, 11);
        // Each frame takes 11.458333 ms and starts when the one before has ended.
        assert_eq!(arrivals, [(11_458_333, 11), (22_916_667, 11), (34_375_000, 11)]);
    }

    #[test]
    fn a_latency_moves_everything_by_itself() {
        let latency = SimTime::from_ns(7);
        let slow = LineSettings { latency, ..LineSettings::direct(115_200.0) };
        assert_eq!(arrivals(slow, 10 * MS, 1, 11), [(954_868, 11)]);
    }

    #[test]
    fn a_bridge_with_a_16_ms_timer_bunches_300_hz_into_bursts_of_five_frames() {
        let arrivals = arrivals(ftdi(16), 3_333_333, 3000, 11);
        let bursts = arrivals.len() as f64;
        // 3300 B/s never fill 62 bytes within 16 ms, so the timer decides: 10 s / 16 ms.
        assert!((bursts - 625.0).abs() <= 2.0, "{bursts} bursts");
        assert_eq!(arrivals.iter().map(|(_, n)| n).sum::<usize>(), 33_000);
        assert!(arrivals.iter().all(|(time, _)| time % MS == 0), "USB frames are whole ms");
    }

    #[test]
    fn a_full_packet_does_not_wait_for_the_timer() {
        let settings = LineSettings { baud: 230_400.0, ..ftdi(16) };
        let arrivals = arrivals(settings, 714_286, 14_000, 7);
        let bursts = arrivals.len() as f64;
        // 9800 B/s fill 62 bytes in 6.3 ms.
        assert!((bursts - 98_000.0 / 62.0).abs() <= 2.0, "{bursts} bursts");
    }

    proptest! {
        #[test]
        fn every_byte_arrives_once_in_order_and_time_never_goes_back(
            sends in proptest::collection::vec((0..20 * MS, 0..100_usize), 1..40),
            timer_ms in 1..20_i64,
            direct in any::<bool>(),
        ) {
            let settings = if direct { LineSettings::direct(57_600.0) } else { ftdi(timer_ms) };
            let mut line = LineModel::new(settings);
            let (mut sent, mut got, mut last) = (Vec::new(), Vec::new(), i64::MIN);
            let mut ordered = true;
            let mut note = |time: SimTime, bytes: &[u8]| {
                ordered &= time.as_ns() >= last && !bytes.is_empty();
                last = time.as_ns();
                got.extend_from_slice(bytes);
            };
            let mut now = 0;
            for (wait_ns, len) in sends {
                now += wait_ns;
                let bytes: Vec<u8> = (0..len).map(|k| (sent.len() + k).to_le_bytes()[0]).collect();
                line.send(SimTime::from_ns(now), &bytes, &mut note);
                sent.extend(bytes);
            }
            line.flush(&mut note);
            prop_assert!(ordered);
            prop_assert_eq!(got, sent);
        }
    }
}
