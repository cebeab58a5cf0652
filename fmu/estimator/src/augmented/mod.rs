//! The augmented torsional filter: an extended Kalman filter of angle, rate, the oscillator's two
//! parameters, and the gyro's bias.
//!
//! States are (α, ω, s, d, b) with α = −s·(φ − φ_eq), s = Ω² and d = 2ζΩ, so that α′ = −s·ω,
//! ω′ = α − d·ω. With the angle itself as state the product s·φ of two unknowns would be
//! linearised; here the only products are s·ω and d·ω, and ω is known well from the first sample
//! on. The same filter in (φ, ω, s, d, b) is inconsistent: it claims less than half of its error.

mod config;
mod filter;
pub(crate) mod history;
mod state;
mod tested;
mod transition;
pub(crate) mod watch;
pub(crate) mod windows;

pub use config::{AugmentedConfig, GyroRange, StartPrior};
pub use filter::{AugmentedFilter, LearntParameters};
pub use tested::TestedFilter;
pub use windows::InnovationTest;
