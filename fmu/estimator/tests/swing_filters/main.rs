//! The filters of a swinging body on the motion of the body model.
//!
//! Truth is the Lagrange backend of the body model and random numbers by address; nothing of it is
//! the filters'. A body of A = 0.0100, B = 0.0105, C = 0.0100 kg·m² on a string of T = 120 s ± 1 %
//! and ζ = 0.06 ± 0.005, in air that takes the swing's amplitude at 1/500 s; let go at 360°,
//! swinging at 1.58 Hz along an ellipse of 5 : 1, watched at 100 Hz with R = 2e-3 (deg/s)² for
//! 240 s by gyros with a bias of 0.05 deg/s. The filters believe A and B wrong by 1 % and 0.5 %.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod contract;
mod one_axis;
mod rig;
mod three_axes;
