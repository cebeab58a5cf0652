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
//! Beyond that ideal, a [`Rig`] adds a string of finite length, a moving support, a thread that
//! yields and creeps, air, noise and impulses. Two engines move it, each the judge of the other:
//! the Lagrange equations and the rigid-body engine rapier ([`Backend`]).
//! [`batch`] moves many bodies at once.
//!
//! **Architecture Invariant:** no gyro here, and no random number that is not addressed by seed,
//! run, channel and index: the motion is a function of parameters, start and commanded torque.

mod air;
mod attitude;
pub mod batch;
mod disturbance;
mod error;
mod lagrange;
mod motion;
mod mounting;
pub mod ode;
mod oracles;
mod params;
mod rapier;
pub mod reference;
mod rig;
mod start;
mod support;
mod thread;
mod torsion;

pub use air::Drag;
pub use batch::{FAST_STATES, FastEquations, FastMotion};
pub use disturbance::{DISTURBANCE_GRID_HZ, Disturbances, Impulse, PoissonImpulses, TorqueNoise};
pub use error::{BodyError, Posture, Stop, StopReason};
pub use lagrange::{BodyEquations, FULL_STATES, FullEquations, STATES, TILT_MAX_RAD};
pub use motion::{Backend, Integrator, TruthMotion};
pub use mounting::{MountedMotion, Mounting};
pub use params::{Body, BodyParams, Torsion, TorsionDamping, TorsionStiffness};
pub use rapier::RapierMotion;
pub use rig::{EARTH_RATE_RAD_S, Rig, earth_rate_w_rad_s};
pub use start::{StartErrors, StartState, TWIST_MAX_RAD};
pub use support::{ClampSwing, Support, VIBRATIONS_MAX, Vibration};
pub use thread::{Creep, Hysteresis, YIELD_ELEMENTS_MAX, YieldElement, YieldLaw};
pub use torsion::DampedTorsion;

/// Version of the rigid-body engine, as pinned.
pub const RAPIER_VERSION: &str = "0.36.1";
