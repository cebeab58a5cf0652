//! The live estimator: which filter may speak at the moment, and what is said of it.

mod config;
mod doubt;
mod estimator;
mod eye;
mod fallback;
mod handover;
mod noise;
mod pursuit;
mod saved;
mod switch;
mod tape;

pub use config::LiveConfig;
pub use estimator::{LiveEstimator, LiveWarning};
pub use fallback::{SwingFallback, SwingScale};
