//! The live estimator: which filter may speak at the moment, and what is said of it.

mod fallback;
mod noise;

pub use fallback::{SwingFallback, SwingScale};
