//! Smoothing and batch estimation on the motion of the body model.
//!
//! Truth is closed-form torsion and random numbers by address, the same as for the filter
//! (`tests/augmented/rig.rs`, which also says what the scenarios A to E are); nothing of it is the
//! smoother's.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "sample numbers, all small and positive"
)]

mod accuracy;
mod batch;
mod bound;
mod lag;
mod numerics;
mod refusals;
#[path = "../augmented/rig.rs"]
#[allow(dead_code, reason = "the filter's tests use more of it")]
mod rig;
mod runs;
