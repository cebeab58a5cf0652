//! Characterisation of noise that is known, because it was made.

#![expect(clippy::panic, reason = "a panic fails the test")]

mod coverage;
mod noise;
mod recovery;
mod refusals;
