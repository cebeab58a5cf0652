//! Estimation on a thread that yields, on the motion of the body model.
//!
//! A body let go at rest at 360° of a relaxed thread, T = 480 s ± 1 %, ζ = 0.01 ± 0.003, 100 Hz,
//! R = 2e-3 (deg/s)², 480 s; the estimators are told 360° ± 100° and a bias of 0 ± 0.05 deg/s.
//! Friction in the thread is ten times as stiff as the thread before it yields. All runs are
//! seeded, and nothing of the truth is the filters'.
//!
//! The figures in the documentation are those of 40 runs a case: set `STRUNA_HYSTERESIS_RUNS`.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
#![expect(clippy::print_stdout, reason = "the figures that the documentation quotes")]

mod accuracy;
mod campaign;
mod contract;
mod kicks;
mod motion;
mod rest;
mod rig;
mod slip;
