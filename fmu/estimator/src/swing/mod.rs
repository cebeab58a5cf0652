//! The body that swings while it turns: its motion in five degrees of freedom, and the extended
//! Kalman filters on it.
//!
//! A gyro whose axis is not quite the body's feels the swing, and the swing drives the twist: with
//! it the one-dimensional filters are lost from 3° on. These ones follow the vertical in body axes,
//! the twist with all its turns, and the three rates.

mod amplitude;
mod config;
mod filter;
mod fit;
mod motion;
mod three_axes;

pub use amplitude::{SWING_PRESENT_RAD, SwingMeter};
pub use config::{InputAxis, SwingBody, SwingConfig};
pub use filter::{SWING_STATES, SwingBelief, SwingFilter};
pub use fit::{AcceptedFit, FitOutcome, FitStarts, Progress, Rejection, SwingFit};
pub use motion::{
    ExpectedRate, MOTION_PARAMETERS, MOTION_STATES, MOTION_TANGENTS, MotionParameters, MotionState,
    SwingMotion, Tangents,
};
pub use three_axes::ThreeAxisFilter;
