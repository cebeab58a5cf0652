//! The live estimator on motions of the body model: what it announces, and whether what it claims
//! holds.
//!
//! Truth is integrated by the body model and measured by a gyro 1° askew; nothing of it is the
//! estimator's, which believes in slightly other moments, a slightly other period, start and
//! misalignment. All runs are seeded: 100 Hz, R = 2e-3 (deg/s)².

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod allocations;
mod contract;
mod fallback;
mod rig;
mod sight;
mod swing;
#[path = "../shared/swinging.rs"]
mod swinging;
mod thread;
mod torsion;
