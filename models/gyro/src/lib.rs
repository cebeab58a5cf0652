//! Gyro error models: true rate in, counts out.
//!
//! [`GyroParams`] describe one axis in SI units; [`preset`] reads them from TOML and [`datasheet`]
//! knows the units of data sheets. [`Gyro`] turns true rates into [`struna_kernel::GyroReading`]s,
//! sample by sample, without allocating:
//!
//! ```
//! use struna_gyro::{Gyro, preset};
//! use struna_kernel::Seed;
//!
//! let mut gyro = Gyro::new(preset::vg910d(), Seed(1), 0)?;
//! let reading = gyro.sample(0.08);
//! assert!(reading.flags.valid && !reading.flags.over_range && reading.flags.warm_up);
//! let believed_rad_s = f64::from(reading.counts.0) * gyro.params().lsb_rad_s;
//! assert!((believed_rad_s - 0.08).abs() < 0.01);
//! # Ok::<(), struna_kernel::ParameterError>(())
//! ```
//!
//! What is modelled, in this order: pure delay and second-order band limit; scale factor with
//! asymmetry, turn-on spread and temperature; its bend; bias with turn-on spread, temperature, its
//! rate, specific force, magnetic field and warming up; angle random walk, bias instability, rate
//! random walk, ramp; saturation; rounding; and the clock that samples it all. Misalignment and the
//! Earth's rate are the mounting's and come with the rate. `docs/gyro.md` has the equations.
//!
//! **Architecture Invariant:** a gyro feels rate, specific force, temperature and magnetic field at
//! its place and nothing else of the truth. It knows no body and no attitude.

mod clock;
pub mod datasheet;
mod drift;
mod gyro;
mod input;
mod linearity;
mod params;
pub mod preset;
mod response;
mod upset;

pub use clock::SampleClock;
pub use gyro::Gyro;
pub use input::{GyroInput, ROOM_TEMPERATURE_DEG_C, STANDARD_GRAVITY_M_S2, Surroundings};
pub use linearity::SINE_NONLINEARITY;
pub use params::{
    BiasEffects, ClockParams, DriftParams, GyroParams, Law, Linearity, Response, Rounding,
    Sampling, ScaleFactor,
};
pub use upset::{Rail, Upset};
