//! `[line]` beside its frame: baud rate, latency, what stands between gyro and host.

use super::numbers::or;
use std::ops::RangeInclusive;
use struna_kernel::SimTime;
use struna_line::{Bridge, CharacterFormat, DeviceSettings, LineSettings};
use struna_settings::{Result, Table, Value};
use struna_wire::{FrameSpec, Parity};

/// What `[line]` may hold.
pub(super) const KEYS: [&str; 7] =
    ["frame", "baud", "latency_us", "bridge", "packet_bytes", "latency_timer_ms", "usb_frame_us"];
/// What belongs to a USB bridge alone.
const BRIDGE_KEYS: [&str; 3] = ["packet_bytes", "latency_timer_ms", "usb_frame_us"];

/// From the slowest terminals to the fastest USB bridges.
const BAUD: RangeInclusive<u32> = 50..=12_000_000;
/// A latency beyond ten seconds is a typing error.
const LATENCY_US: RangeInclusive<f64> = 0.0..=1e7;
/// What the timer of an FT232 can be set to, and as delivered.
const LATENCY_TIMER_MS: RangeInclusive<f64> = 1.0..=255.0;
const LATENCY_TIMER_MS_DEFAULT: f64 = 16.0;
/// Data bytes of a USB packet: at full speed 64 less two of status, at high speed up to 510.
const PACKET_BYTES: RangeInclusive<usize> = 1..=510;
const PACKET_BYTES_DEFAULT: usize = 62;
/// A micro-frame of high-speed USB is an eighth of this.
const USB_FRAME_US: RangeInclusive<f64> = 1.0..=100_000.0;
const USB_FRAME_US_DEFAULT: f64 = 1000.0;

/// The line between gyro and host, beside what goes over it.
#[derive(Debug, Clone, PartialEq)]
pub struct LinePlan {
    /// Baud rate of the gyro.
    pub baud: u32,
    /// How its bytes stand on the line.
    pub format: CharacterFormat,
    /// Constant delay of everything behind the last bit.
    pub latency: SimTime,
    /// What stands between the line and the host.
    pub bridge: Bridge,
}

impl LinePlan {
    /// The line that `frame` declares, and nothing behind it.
    pub(super) fn of_frame(frame: &FrameSpec) -> Self {
        let line = frame.line();
        let parity = match line.parity {
            Parity::None => struna_line::Parity::None,
            Parity::Even => struna_line::Parity::Even,
            Parity::Odd => struna_line::Parity::Odd,
        };
        let format = CharacterFormat { parity, stop_bits: line.stop };
        Self { baud: line.baud, format, latency: SimTime::ZERO, bridge: Bridge::Direct }
    }

    /// For the line in simulated time.
    #[must_use]
    pub fn settings(&self) -> LineSettings {
        LineSettings {
            baud: f64::from(self.baud),
            bits_per_byte: self.format.symbols(),
            latency: self.latency,
            bridge: self.bridge,
        }
    }

    /// For the port of the emulated device.
    #[must_use]
    pub fn device(&self) -> DeviceSettings {
        DeviceSettings { baud: self.baud, format: self.format }
    }
}

/// Symbols per second of `frame` at `rate_hz` frames per second.
pub(super) fn symbols_per_s(frame: &FrameSpec, rate_hz: f64) -> f64 {
    frame.bits_per_s() * rate_hz / frame.timing().rate_hz
}

/// The line of a scenario whose gyro sends `rate_hz` of `frame` per second.
pub(super) fn line(root: &Table<'_>, frame: &FrameSpec, rate_hz: f64) -> Result<LinePlan> {
    let mut plan = LinePlan::of_frame(frame);
    let Some(line) = root.optional("line") else { return Ok(plan) };
    let line = line.table()?;
    if let Some(baud) = line.optional("baud") {
        plan.baud = baud.integer_in(BAUD)?;
        let least = symbols_per_s(frame, rate_hz).ceil();
        if f64::from(plan.baud) < least {
            return Err(baud.out_of_range(format!(
                "at least {least}, which {rate_hz} frames of {} per second need",
                frame.name()
            )));
        }
    }
    plan.latency = or(&line, "latency_us", |value| micros(value, LATENCY_US), SimTime::ZERO)?;
    plan.bridge = bridge(&line)?;
    Ok(plan)
}

fn bridge(line: &Table<'_>) -> Result<Bridge> {
    let is_ftdi = |value: &Value<'_>| value.word(&[("direct", false), ("ftdi", true)]);
    if !or(line, "bridge", is_ftdi, false)? {
        return match BRIDGE_KEYS.iter().find_map(|key| line.optional(key)) {
            Some(value) => {
                Err(value.because("there is no USB bridge; add bridge = \"ftdi\" or remove this"))
            }
            None => Ok(Bridge::Direct),
        };
    }
    let bytes = |value: &Value<'_>| value.integer_in(PACKET_BYTES);
    let timer_ms = |value: &Value<'_>| value.number_in(LATENCY_TIMER_MS);
    let timer_ms = or(line, "latency_timer_ms", timer_ms, LATENCY_TIMER_MS_DEFAULT)?;
    let frame = |value: &Value<'_>| micros(value, USB_FRAME_US);
    Ok(Bridge::Ftdi {
        packet_bytes: or(line, "packet_bytes", bytes, PACKET_BYTES_DEFAULT)?,
        latency_timer: of_micros(timer_ms * 1e3),
        usb_frame: or(line, "usb_frame_us", frame, of_micros(USB_FRAME_US_DEFAULT))?,
    })
}

fn micros(value: &Value<'_>, range: RangeInclusive<f64>) -> Result<SimTime> {
    Ok(of_micros(value.number_in(range)?))
}

fn of_micros(us: f64) -> SimTime {
    SimTime::from_s(us * 1e-6).expect("every accepted time is short")
}
