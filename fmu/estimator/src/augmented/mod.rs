//! The augmented torsional filter: an extended Kalman filter of angle, rate, the oscillator's two
//! parameters, and the gyro's bias.
//!
//! States are (α, ω, s, d, b) with α = −s·(φ − φ_eq), s = Ω² and d = 2ζΩ, so that α′ = −s·ω,
//! ω′ = α − d·ω. With the angle itself as state the product s·φ of two unknowns would be
//! linearised; here the only products are s·ω and d·ω, and ω is known well from the first sample
//! on. The same filter in (φ, ω, s, d, b) is inconsistent: it claims less than half of its error.

mod alarm;
mod config;
mod filter;
pub(crate) mod history;
mod pass;
mod rounding;
mod state;
mod tested;
pub(crate) mod transition;
pub(crate) mod watch;
pub(crate) mod windows;

pub use alarm::Alarm;
pub use config::{AugmentedConfig, GyroRange, Quantiser, StartPrior};
pub use filter::{AugmentedFilter, LearntParameters};
pub(crate) use history::WAY_BACK_MAX;
pub(crate) use pass::{Bounds, Link, Trace};
pub(crate) use state::{Densities, State};
pub use tested::TestedFilter;
pub use windows::InnovationTest;
pub(crate) use windows::{CLIP, GATE, LENGTHS};
