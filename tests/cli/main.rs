//! The `struna` command as a person meets it.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a failed unwrap fails the test")]

mod characterize;
mod compare;
mod decode;
mod desk;
mod frame;
mod refusals;
mod results;
mod smooth;
mod sniff;
