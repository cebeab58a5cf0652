//! Gyro error models: true rate in, counts out.
//!
//! [`GyroParams`] describe one axis in SI units; [`datasheet`] is the only place that speaks the
//! units of data sheets. [`Gyro`] turns true rates into [`struna_kernel::GyroReading`]s, sample by
//! sample, without allocating:
//!
//! ```
//! use struna_gyro::{Gyro, datasheet};
//! use struna_kernel::Seed;
//!
//! let mut gyro = Gyro::new(datasheet::vg910d(), Seed(1), 0)?;
//! let reading = gyro.sample(0.08);
//! assert!(reading.flags.valid && !reading.flags.over_range);
//! let believed_rad_s = f64::from(reading.counts.0) * gyro.params().lsb_rad_s;
//! assert!((believed_rad_s - 0.08).abs() < 0.01);
//! # Ok::<(), struna_kernel::ParameterError>(())
//! ```
//!
//! What is modelled, in this order: bias (constant and turn-on), white rate noise, saturation,
//! quantisation. What is not: scale error, bias instability, bandwidth, temperature, Earth rate.
//!
//! **Architecture Invariant:** a gyro sees a rate and nothing else of the truth. It knows no body,
//! no attitude and no clock.

pub mod datasheet;
mod gyro;
mod params;
mod upset;

pub use gyro::Gyro;
pub use params::GyroParams;
pub use upset::{Rail, Upset};
