//! The catalogue.

use struna_gyro::Rail;

/// Where a fault acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// On the gyro's sample, before it becomes counts.
    Gyro,
    /// On a whole frame.
    Frame,
    /// On single bytes.
    Byte,
    /// On when bytes leave, or whether they do.
    Line,
}

impl Stage {
    /// Its word in records.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Gyro => "gyro",
            Self::Frame => "frame",
            Self::Byte => "byte",
            Self::Line => "line",
        }
    }
}

/// One kind of fault with its magnitude, SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FaultKind {
    /// One byte of the frame is lost.
    ByteDrop,
    /// One bit of the frame is inverted.
    BitFlip,
    /// One byte of the frame comes twice.
    DuplicateByte,
    /// A random byte comes between two others, or beside the frame.
    InsertedByte,
    /// Consecutive bytes, over the frame's end if need be, are replaced by other ones.
    Burst {
        /** How many. */
        bytes: u32,
    },
    /// The frame breaks off after at least one byte.
    Truncated,
    /// The rate is replaced by one drawn from the whole range; the check is right.
    WrongValue,
    /// The frame comes after its successor.
    SwappedFrames,
    /// The frame comes twice.
    DuplicatedFrame,
    /// The gyro repeats its last counts.
    Stuck,
    /// The gyro's output lies at the end of its range.
    Saturation {
        /** Which end. */
        rail: Rail,
    },
    /// The bias is off.
    BiasStep {
        /** By this much, rad/s. */
        rate_rad_s: f64,
    },
    /// The bias grows from the start of the event and falls back at its end.
    BiasRamp {
        /** By this much in a second, rad/s². */
        rate_rad_s2: f64,
    },
    /// The scale factor is off.
    ScaleChange {
        /** By this share of itself. */
        share: f64,
    },
    /// The white noise changes.
    NoiseChange {
        /** To this many times its deviation. */
        factor: f64,
    },
    /// One sample is off.
    Spike {
        /** By this much, rad/s. */
        rate_rad_s: f64,
    },
    /// Frames are not sent, though they are counted.
    Dropout,
    /// Bytes come later.
    Delay {
        /** By this much, s. */
        delay_s: f64,
    },
    /// Bytes come later by a random time, uniform and new for each frame.
    Jitter {
        /** Up to this, s. */
        delay_max_s: f64,
    },
    /// The gyro's bit clock is off: bytes are shorter or longer and, further off, misread.
    BaudError {
        /** Share by which it runs fast. */
        share: f64,
    },
    /// The port is gone, and back at the end of the event.
    PortLoss,
    /// The gyro's sample clock runs slow; what it has fallen behind stays.
    ClockDrift {
        /** Share by which it runs slow. */
        share: f64,
    },
    /// The gyro's samples come later from now on.
    ClockJump {
        /** By this much, s. */
        jump_s: f64,
    },
}

impl FaultKind {
    /// Its word in scenarios and records.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::ByteDrop => "byte-drop",
            Self::BitFlip => "bit-flip",
            Self::DuplicateByte => "duplicate-byte",
            Self::InsertedByte => "inserted-byte",
            Self::Burst { .. } => "burst",
            Self::Truncated => "truncated-frame",
            Self::WrongValue => "wrong-value",
            Self::SwappedFrames => "swapped-frames",
            Self::DuplicatedFrame => "duplicated-frame",
            Self::Stuck => "stuck",
            Self::Saturation { .. } => "saturation",
            Self::BiasStep { .. } => "bias-step",
            Self::BiasRamp { .. } => "bias-ramp",
            Self::ScaleChange { .. } => "scale-change",
            Self::NoiseChange { .. } => "noise-change",
            Self::Spike { .. } => "spike",
            Self::Dropout => "dropout",
            Self::Delay { .. } => "delay",
            Self::Jitter { .. } => "jitter",
            Self::BaudError { .. } => "baud-error",
            Self::PortLoss => "port-loss",
            Self::ClockDrift { .. } => "clock-drift",
            Self::ClockJump { .. } => "clock-jump",
        }
    }

    /// Where it acts.
    #[must_use]
    pub const fn stage(&self) -> Stage {
        match self {
            Self::ByteDrop
            | Self::BitFlip
            | Self::DuplicateByte
            | Self::InsertedByte
            | Self::Burst { .. } => Stage::Byte,
            Self::Truncated | Self::WrongValue | Self::SwappedFrames | Self::DuplicatedFrame => {
                Stage::Frame
            }
            Self::Stuck
            | Self::Saturation { .. }
            | Self::BiasStep { .. }
            | Self::BiasRamp { .. }
            | Self::ScaleChange { .. }
            | Self::NoiseChange { .. }
            | Self::Spike { .. } => Stage::Gyro,
            Self::Dropout
            | Self::Delay { .. }
            | Self::Jitter { .. }
            | Self::BaudError { .. }
            | Self::PortLoss
            | Self::ClockDrift { .. }
            | Self::ClockJump { .. } => Stage::Line,
        }
    }

    /// Whether an event has a length of its own. The others hit one frame or sample, or each one
    /// of a stretch when the plan gives them a duration.
    #[must_use]
    pub const fn lasts(&self) -> bool {
        match self.stage() {
            Stage::Byte | Stage::Frame => false,
            Stage::Gyro => !matches!(self, Self::Spike { .. }),
            Stage::Line => !matches!(self, Self::ClockJump { .. }),
        }
    }

    /// Whether it shows only to those who look at arrival times: the bytes are the same.
    #[must_use]
    pub const fn is_timing_only(&self) -> bool {
        matches!(
            self,
            Self::Delay { .. }
                | Self::Jitter { .. }
                | Self::ClockDrift { .. }
                | Self::ClockJump { .. }
        )
    }

    /// Its magnitude as the plan gives it, and the unit of that; 0 where there is none.
    #[must_use]
    pub const fn magnitude(&self) -> (f64, &'static str) {
        match *self {
            Self::Burst { bytes } => (bytes as f64, "byte"),
            Self::Saturation { rail: Rail::Positive } => (1.0, "rail"),
            Self::Saturation { rail: Rail::Negative } => (-1.0, "rail"),
            Self::BiasStep { rate_rad_s } | Self::Spike { rate_rad_s } => (rate_rad_s, "rad/s"),
            Self::BiasRamp { rate_rad_s2 } => (rate_rad_s2, "rad/s2"),
            Self::ScaleChange { share }
            | Self::BaudError { share }
            | Self::ClockDrift { share } => (share, "1"),
            Self::NoiseChange { factor } => (factor, "1"),
            Self::Delay { delay_s } => (delay_s, "s"),
            Self::Jitter { delay_max_s } => (delay_max_s, "s"),
            Self::ClockJump { jump_s } => (jump_s, "s"),
            Self::BitFlip => (0.0, "bit"),
            Self::WrongValue => (0.0, "counts"),
            Self::Truncated => (0.0, "byte"),
            _ => (0.0, ""),
        }
    }
}
