//! The fit that starts the filter of a swinging body, on the motion of the body model.
//!
//! Truth is the body model's: T = 120 s, ζ = 0.03, M = 1 kg, d = 0.1 m, A = 0.0100, B = 0.0105,
//! C = 0.0100 kg·m², one turn, let go while it swings on a random ellipse. The gyro has 2e-3 (°/s)²
//! of white noise at 100 Hz, a bias of 0.05 °/s and sits 1° askew.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod first;
mod rig;
