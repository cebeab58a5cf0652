//! Why a body, a start or a run is refused, and why a motion stops.

use nalgebra::{Quaternion, Vector3};
use std::fmt;
use struna_kernel::{ParameterError, SimTime, TimeError};

/// Why a body, a start or a run is refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BodyError {
    /// A value that no body, string, start or integration can have.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A grid of disturbances that is none.
    #[error("the grid of the disturbances: {0}")]
    Grid(#[from] TimeError),
    /// Something that the chosen engine cannot do.
    #[error("{backend} cannot do this: {what}; remove it or choose backend = \"lagrange\"")]
    Unsupported {
        /** The engine. */
        backend: &'static str,
        /** What it was asked for. */
        what: &'static str,
    },
    /// Asked for an instant before one already answered, or before the start.
    #[error("the motion at {asked} was asked for after the motion at {reached}")]
    TimeReversal {
        /** The instant asked for. */
        asked: SimTime,
        /** The latest instant answered. */
        reached: SimTime,
    },
    /// The motion cannot be carried on.
    #[error(transparent)]
    Stopped(#[from] Stop),
}

/// Where and why a motion stopped: time, state, reason.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub struct Stop {
    /// Why.
    pub reason: StopReason,
    /// When, s since the start of the run.
    pub time_s: f64,
    /// The last good state.
    pub posture: Posture,
}

impl fmt::Display for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { reason, time_s, posture } = self;
        write!(f, "at {time_s:.9} s {reason}; {posture}")
    }
}

/// Why a motion stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StopReason {
    /// The string would have to push.
    #[error("the string went slack, and free flight is not modelled")]
    Slack,
    /// The body came too near to upside down.
    #[error("the body turned over, where the twist of a string is undefined")]
    Overturned,
    /// The string came too near to horizontal.
    #[error("the string swung up to the horizontal, where its length no longer gives its height")]
    StringTooTilted,
    /// The states grew without bound or became NaN.
    #[error("the motion diverged; choose a shorter step or a tighter tolerance")]
    Diverged,
    /// No step is small enough to meet the tolerance.
    #[error("no step is small enough for the tolerance")]
    StepTooSmall,
    /// One call needs too many steps.
    #[error("too many steps lie between two samples; choose a longer step")]
    TooManySteps,
}

/// Attitude, rate and twist of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Posture {
    /// Quaternion (w, x, y, z) that carries body components into world components.
    pub q_wb: [f64; 4],
    /// Rate of body relative to world, body components, rad/s.
    pub omega_wb_b_rad_s: [f64; 3],
    /// Twist, rad.
    pub twist_rad: f64,
}

impl Posture {
    /// Tilt of the body axis from the vertical, rad.
    #[must_use]
    pub fn tilt_rad(&self) -> f64 {
        let [w, x, y, z] = self.q_wb;
        let q = Quaternion::new(w, x, y, z);
        2.0 * q.i.hypot(q.j).atan2(q.w.hypot(q.k))
    }
}

impl fmt::Display for Posture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rate = Vector3::from(self.omega_wb_b_rad_s).norm();
        let (tilt, twist) = (self.tilt_rad(), self.twist_rad);
        write!(f, "tilt {tilt:.6} rad, twist {twist:.6} rad, rate {rate:.6} rad/s")
    }
}
