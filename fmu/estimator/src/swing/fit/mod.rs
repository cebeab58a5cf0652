//! The batch fit with many starts that starts the filter of a swinging body.
//!
//! Windows of 8, 16, 30 and 60 s: 25 starts descend in the first one, and each longer window goes
//! on from the distinct ends of the one before that still fit.

mod bounded;
pub(super) mod cholesky;
mod job;
mod levenberg;
mod modes;
mod outcome;
mod pass;
mod plan;
mod problem;
mod record;
mod residuals;
mod starts;
mod verdict;
mod walk;

pub use job::{FitStarts, SwingFit};
pub use outcome::{AcceptedFit, FitOutcome, Progress, Rejection};
