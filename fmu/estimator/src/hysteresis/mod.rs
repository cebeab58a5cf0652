//! Estimation on a thread that yields: Kalman filters with Dahl's friction in the string, and the
//! bank that weighs them against the filter of a linear thread.
//!
//! Friction inside the thread is a torque that follows the turn elastically, with stiffness k_h,
//! and saturates at k·ζ_y: ζ_y is the *yield angle*. On such a thread the filter of a linear one
//! is wrong by tens of degrees and does not know it. A single filter with friction as a state has
//! the opposite trouble: from a wide prior it settles on a wrong yield angle. Four of them, with
//! priors about 3°, 8°, 20° and 50°, and the linear one cover the range between them.
//!
//! Angles count from the equilibrium of the thread's linear part, where the body would rest if
//! friction were not. Until the first full slip a friction torque at the start and an offset of
//! that equilibrium are the same thing; and where a body will rest within ±ζ_y of it, nothing in
//! the rate foretells.

mod bank;
mod config;
mod dahl;
mod filter;
mod member;
mod memory;

pub use bank::HysteresisBank;
pub use config::YieldPrior;
pub use filter::{DahlFilter, LearntYield};
pub use member::MEMBERS;
