//! What a live line does besides bringing samples.

use crate::clock::Basis;
use struna_kernel::SimTime;

/// Why samples are missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GapCause {
    /// Frames were lost or damaged on the line.
    Line,
    /// The port was gone.
    Port,
    /// The sensor said nothing for a while, and its counter says that it took no samples.
    Pause,
}

/// Missing samples, between two instants of the record's time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gap {
    /// End of the last sample before.
    pub from: SimTime,
    /// Begin of the first sample after.
    pub to: SimTime,
    /// Samples missing.
    pub lost: u64,
    /// Why.
    pub cause: GapCause,
    /// What the number of samples rests on.
    pub basis: Basis,
}

/// Something worth a line in the record's list of events.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum LiveEvent {
    /// Samples are missing.
    Gap(Gap),
    /// The port is gone.
    PortLost {
        /** What the system said. */
        reason: String,
    },
    /// The port is back.
    PortBack {
        /** How long it was gone, s. */
        after_s: f64,
    },
    /// Frames were found again after bytes that belong to none.
    Resync {
        /** Bytes skipped since the report before. */
        skipped_bytes: u64,
    },
    /// The frame counter began anew.
    CounterRestarted,
    /// The host's clock was set.
    ClockSet {
        /** By so much, s. */
        by_s: f64,
    },
    /// Bytes came, or none, but no frame.
    NoFrames(Sighting),
}

/// What was seen on a line that brought no frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// For how long it was looked at, s.
    pub span_s: f64,
    /// Bytes in that time.
    pub bytes: u64,
    /// Places that began like a frame and failed its check.
    pub false_starts: u64,
    /// Bytes per second that the layout sends.
    pub expected_bytes_per_s: f64,
    /// Frames per second that the layout sends.
    pub expected_frames_per_s: f64,
}

/// The likeliest reason for a [`Sighting`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Guess {
    /// Nothing is sent.
    Silence,
    /// Frames begin as they should, as often as they should, and their checks fail.
    OtherCheck,
    /// About as many bytes as expected, but not this frame.
    OtherFrame,
    /// Too many or too few bytes: another device, or another baud rate.
    OtherBaud,
}

impl Sighting {
    /// What is probably the matter.
    #[must_use]
    pub fn guess(&self) -> Guess {
        let bytes = self.expected_bytes_per_s * self.span_s;
        let frames = self.expected_frames_per_s * self.span_s;
        let share = |count: u64, of: f64| count as f64 / of.max(f64::MIN_POSITIVE);
        if self.bytes == 0 {
            Guess::Silence
        } else if share(self.false_starts, frames) > 0.5 {
            Guess::OtherCheck
        } else if (0.7..1.4).contains(&share(self.bytes, bytes)) {
            Guess::OtherFrame
        } else {
            Guess::OtherBaud
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_seen_is_told_apart() {
        let seen = |bytes, false_starts| Sighting {
            span_s: 2.0,
            bytes,
            false_starts,
            expected_bytes_per_s: 3300.0,
            expected_frames_per_s: 300.0,
        };
        assert_eq!(seen(0, 0).guess(), Guess::Silence);
        assert_eq!(seen(6600, 590).guess(), Guess::OtherCheck);
        assert_eq!(seen(6500, 1).guess(), Guess::OtherFrame);
        assert_eq!(seen(1100, 0).guess(), Guess::OtherBaud);
        assert_eq!(seen(19_600, 3).guess(), Guess::OtherBaud);
    }
}
