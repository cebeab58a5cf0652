//! Recorded runs in hindsight: the angle as the whole record tells it.
//!
//! The three methods are those of `struna-estimator`; here a record is read, the belief at its
//! start put together, and what came of it written down.

pub mod belief;
mod error;
pub mod figure;
pub mod file;
mod hindsight;
pub mod text;

pub use belief::{StartBelief, start_belief};
pub use error::SmoothingError;
pub use file::MeasuredRecord;
pub use hindsight::{Hindsight, Learnt, look_back};
