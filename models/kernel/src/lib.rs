//! What every crate of Struna agrees on: time, seeded random streams, bounds of parameters, and the
//! samples that cross crate borders.
//!
//! Signals keep their names along the chain: a body has [`BodyMotion`] (truth), a gyro emits
//! [`GyroReading`] (counts), the harness decodes [`RateSample`], an estimator believes an
//! [`AngleEstimate`]. They are never mixed, and SI units hold inside all of them.
//!
//! **Architecture Invariant:** no wall clock, no input or output, and no other Struna crate is
//! reachable from here.

mod addressed;
mod bound;
mod random;
mod samples;
mod time;

pub use addressed::AddressedRandom;
pub use bound::{Bound, ParameterError};
pub use random::{Channel, RandomStream, Seed};
pub use samples::{
    AngleEstimate, BodyMotion, Counts, EstimateStatus, GyroReading, RateOf, RateSample,
    ReadingFlags,
};
pub use time::{GridWalk, SampleGrid, SimTime, TimeError};

/// Radians in one degree; multiply degrees by it at the edge, never inside.
pub const RAD_PER_DEG: f64 = std::f64::consts::PI / 180.0;
