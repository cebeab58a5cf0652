//! Detectors: what a host can tell about a gyro and its line from bytes and arrival times.
//!
//! A [`Monitor`] is fed with decoded frames, their arrival times and the decoder's counters, and
//! raises named [`Alarm`]s. Its [`Limits`] are computed from what is [`Declared`] about gyro and
//! motion; nothing is learned, so a fault that was there from the start is no norm.
//!
//! One gyro cannot tell everything: its true rate is an arbitrary function of time, so a bias that
//! moves as a body may move looks like a body that moves. [`observability`] says which faults can
//! be seen at all, before any run.

mod alarm;
mod clock;
mod declared;
mod frames;
mod innovation;
mod limits;
mod listener;
mod noise;
mod observability;
mod watch;

pub use alarm::{Alarm, AlarmChange, Detector};
pub use declared::Declared;
pub use limits::Limits;
pub use listener::{Listener, ListenerError};
pub use noise::NoiseShape;
pub use observability::{Observability, observability};
pub use watch::Monitor;
