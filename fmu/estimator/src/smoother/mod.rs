//! Hindsight: the torsion of a whole record, for post-processing.

mod backward;
mod batch;
mod fixed_lag;
mod forward;
mod matrix;
mod record;
mod rts;

pub use batch::{BatchEstimate, BatchFit, FitRefusal, Verdict};
pub use fixed_lag::{FixedLag, LaggedFilter};
pub use forward::Kick;
pub use record::{RateRecord, RateSample, SmoothError};
pub use rts::{Smoothed, smooth};
