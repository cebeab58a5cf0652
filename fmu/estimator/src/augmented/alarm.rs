//! What an alarm of the innovation test says.

use crate::state_bytes::{Reader, RestoreError, Writer};

/// When the innovations showed a kick, and what was made of it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Alarm {
    /// Seconds of measurements taken in when it was raised, s. The kick was earlier, by up to the
    /// window.
    pub time_s: f64,
    /// Length of the window that raised it, samples.
    pub window_samples: u32,
    /// Mean innovation over that window, rad/s: about the change of the rate.
    pub kick_rad_s: f64,
    /// How many samples were run again with a kick reckoned with. None when the run would have
    /// left the range of floating point.
    pub rerun_samples: u32,
}

impl Alarm {
    pub(super) const SAVED_LEN: usize = 8 + 4 + 8 + 4;

    /// A count of samples that the history can hold.
    pub(super) fn count(samples: u64) -> u32 {
        u32::try_from(samples).unwrap_or(u32::MAX)
    }

    pub(super) fn write(&self, out: &mut Writer<'_>) {
        out.f64(self.time_s);
        out.u32(self.window_samples);
        out.f64(self.kick_rad_s);
        out.u32(self.rerun_samples);
    }

    pub(super) fn read(bytes: &mut Reader<'_>) -> Result<Self, RestoreError> {
        Ok(Self {
            time_s: bytes.finite("alarm time")?,
            window_samples: bytes.u32(),
            kick_rad_s: bytes.finite("kick")?,
            rerun_samples: bytes.u32(),
        })
    }
}
