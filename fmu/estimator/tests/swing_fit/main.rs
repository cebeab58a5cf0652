//! The fit that starts the filter of a swinging body, on the motion of the body model.
//!
//! Truth is the body model's: T = 120 s, ζ = 0.03, M = 1 kg, d = 0.1 m, A = 0.0100, B = 0.0105,
//! C = 0.0100 kg·m², one turn, let go while it swings on a random ellipse. The gyro has 2e-3 (°/s)²
//! of white noise at 100 Hz, a bias of 0.05 °/s and sits 1° askew. Believed: the start within 10°,
//! the misalignment to 0.1° per axis, moments wrong by 1 % and 0.5 %, T to 1 %, ζ ± 0.01.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod accuracy;
mod controls;
mod kicks;
mod pieces;
mod refusals;
mod rig;
#[path = "../shared/swinging.rs"]
mod swinging;
