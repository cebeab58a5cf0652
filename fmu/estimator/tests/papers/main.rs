//! What the 2008 filters do on the motion that the papers simulate, and what the papers say of it.
//!
//! Conventions of the comparison: degrees, 100 Hz, R = 2e-3 (deg/s)², T = 480 s, released from rest
//! at 360°, damping ratio 0.03, P₀ = diag(1, 1), 480 s. Truth is the body model's closed form of
//! damped torsion, random numbers are addressed; nothing of either is the filters'.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "numbers of samples, all small and positive"
)]

mod claims;
mod misprints;
mod residuals;
mod rig;
mod table;
mod window;
