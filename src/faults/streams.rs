//! The three streams on which faults are tried.

use super::motion::TestMotion;
use struna_gyro::datasheet::{rad_s_from_deg_h, rad_s_from_deg_s};
use struna_gyro::{GyroParams, preset};
use struna_harness::monitor::Declared;
use struna_kernel::{RAD_PER_DEG, SimTime};
use struna_line::{Bridge, LineSettings};
use struna_wire::FrameSpec;

/// A gyro, its frame and its line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stream {
    /// The VG-910D: 11 bytes, CRC-16, counter, 300 Hz, white noise of 0.02 deg/s.
    Vg,
    /// The ADIS16100: 7 bytes, CRC-16, counter, 1400 Hz, 12 bits of 0.244 deg/s, noise of 40 Hz.
    Adis,
    /// The VG-910D behind a weak frame: one sync byte, 24 bits, an 8-bit sum, no counter.
    Weak,
}

const WEAK: &str = r#"
[frame]
name = "struna/weak@1"
kind = "fixed"
provenance = "unverified"
sync = "A5"
len = 5
[frame.check]
kind = "sum8"
range = [1, 3]
at = 4
[[frame.field]]
name = "rate"
at = 1
bits = 24
endian = "be"
coding = "twos"
scale = 3.0517578125e-5
unit = "deg/s"
clip = [-200.0, 200.0]
[line]
baud = 115200
data = 8
parity = "none"
stop = 1
[timing]
rate_hz = 300.0
rate_tol = 0.03
"#;

impl Stream {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Vg, Self::Adis, Self::Weak];

    /// Its word in tables and files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Vg => "vg",
            Self::Adis => "adis",
            Self::Weak => "weak",
        }
    }

    /// What it is, for people.
    #[must_use]
    pub const fn describe(self) -> &'static str {
        match self {
            Self::Vg => "11 bytes, CRC-16, counter, 300 Hz, white noise 0.02 deg/s",
            Self::Adis => "7 bytes, CRC-16, counter, 1400 Hz, 12 bits, noise 0.33 deg/s in 40 Hz",
            Self::Weak => "5 bytes, one sync byte, 8-bit sum, no counter, 300 Hz, noise as vg",
        }
    }

    /// The layout of its frames.
    ///
    /// # Panics
    /// Never: the layouts are constant and tested.
    #[must_use]
    pub fn frame(self) -> FrameSpec {
        let text = match self {
            Self::Vg => include_str!("../../frames/vg910d.toml"),
            Self::Adis => include_str!("../../frames/adis16100.toml"),
            Self::Weak => WEAK,
        };
        FrameSpec::from_toml(text).expect("constant layouts are tested")
    }

    /// Its gyro: the preset with its white noise and nothing else, so that what is found is the
    /// fault.
    #[must_use]
    pub fn gyro(self) -> GyroParams {
        let walk = |sigma_deg_s: f64, hz: f64| rad_s_from_deg_s(sigma_deg_s) / hz.sqrt();
        match self {
            Self::Vg | Self::Weak => GyroParams {
                angle_random_walk_rad_sqrt_s: walk(0.02, 300.0),
                ..preset::vg910d().without_errors()
            },
            Self::Adis => GyroParams {
                angle_random_walk_rad_sqrt_s: 0.035 * RAD_PER_DEG,
                response: preset::adis16100().response,
                ..preset::adis16100().without_errors()
            },
        }
    }

    /// What a monitor is told of it.
    #[must_use]
    pub fn declared(self) -> Declared {
        let (gyro, frame) = (self.gyro(), self.frame());
        let (noise_sigma_rad_s, noise_bandwidth_hz) = match self {
            Self::Vg | Self::Weak => (gyro.noise_sigma_rad_s(), None),
            Self::Adis => (rad_s_from_deg_s(0.333), Some(40.0)),
        };
        Declared {
            sample_rate_hz: gyro.sample_rate_hz,
            frame_len: frame.frame_len(),
            counter_modulus: frame.sequence().map(|sequence| sequence.modulus()),
            rate_max_rad_s: gyro.rate_max_rad_s,
            lsb_rad_s: gyro.lsb_rad_s,
            noise_sigma_rad_s,
            noise_bandwidth_hz,
            acceleration_max_rad_s2: TestMotion::ACCELERATION_MAX_RAD_S2,
            bias_max_rad_s: rad_s_from_deg_h(36.0),
        }
    }

    /// Its line: the layout's baud rate, behind a USB bridge as delivered.
    #[must_use]
    pub fn line(self) -> LineSettings {
        let line = self.frame().line();
        let bridge = Bridge::Ftdi {
            packet_bytes: 62,
            latency_timer: SimTime::from_ns(16_000_000),
            usb_frame: SimTime::from_ns(1_000_000),
        };
        let bits_per_byte = line.bits_per_byte();
        LineSettings { bits_per_byte, bridge, ..LineSettings::direct(f64::from(line.baud)) }
    }
}
