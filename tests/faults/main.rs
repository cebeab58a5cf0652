//! Faults on purpose: each does what its record says, and the detectors find what they promise.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod bench;
mod bytes;
mod detectors;
mod times;
mod upsets;
