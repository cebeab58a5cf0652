//! The string-suspended body: equations of motion and their integrators.
//!
//! A rigid body hangs by a point A above its centre of mass C on an infinitely long string, so A
//! keeps its height and moves freely in its horizontal plane. The string resists twist.
//! [`BodyParams`] describe the body, [`Body`] is what remains once they are judged, and
//! [`TruthMotion`] turns a [`StartState`] into the [`struna_kernel::BodyMotion`] at any instant.
//!
//! ```
//! use struna_body::{Body, Integrator, StartState, TruthMotion, reference};
//! use struna_kernel::{SampleGrid, SimTime};
//!
//! let body = Body::new(&reference::PARAMS)?;
//! let mut truth = TruthMotion::new(body, &reference::S3, Integrator::Rk4 { step_s: 1e-3 })?;
//! let grid = SampleGrid::new(SimTime::ZERO, 300.0)?;
//! for k in 0..=300 {
//!     let motion = truth.motion_at(grid.time_of(k))?;
//!     assert!(motion.twist_rad.is_finite());
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! **Architecture Invariant:** no random numbers and no gyro here. The motion is a function of
//! parameters, start and applied torque; noise is applied by whoever owns the random stream.

mod equations;
mod error;
mod motion;
pub mod ode;
mod params;
mod rapier;
pub mod reference;
mod start;
mod torsion;

pub use equations::{BodyEquations, STATES, TILT_MAX_RAD};
pub use error::BodyError;
pub use motion::{Integrator, TruthMotion};
pub use params::{Body, BodyParams, Torsion, TorsionDamping, TorsionStiffness};
pub use rapier::RapierMotion;
pub use start::{StartState, TWIST_MAX_RAD};
pub use torsion::DampedTorsion;
