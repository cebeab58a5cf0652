//! The five-state filter on the motion of the body model.
//!
//! Truth is closed-form torsion and random numbers by address; nothing of it is the filter's. All
//! runs are seeded. Scenarios: a body let go at rest at 360°, T = 480 s ± 1 %, ζ = 0.03 ± 0.01,
//! 100 Hz, R = 2e-3 (deg/s)², 480 s. A: the start is known to 1°, the bias is 0.01 deg/s. B: 100°
//! and 0.05 deg/s. C: B and white angular acceleration. D: B and three kicks of 1 to 5 deg/s. E: B
//! and 1 % of outliers of 20 sigma.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "sample numbers, all small and positive"
)]

mod accuracy;
mod bound;
mod campaign;
mod gyro;
mod kicks;
mod numerics;
mod rig;
