//! Time of a live line: which sample a frame is, when it was taken, and a clock for estimators.
//!
//! Three stages, each of them pure: a [`Resolver`] says which sample a frame is, a [`TimeBase`]
//! when by the host's clock it was taken, and a [`SampleClock`] turns that into times that go
//! forward evenly, as estimators need them. None reads a clock: arrival times are arguments.

mod base;
mod hull;
mod resolver;
mod sample_clock;

pub use base::{Observed, Skew, TimeBase, TimeBaseSettings};
pub use hull::{Point, edge_over, extend};
pub use resolver::{Basis, Heard, Resolved, Resolver};
pub use sample_clock::SampleClock;
