//! The `struna` command as a person meets it.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a failed unwrap fails the test")]

mod compare;
mod desk;
mod refusals;
mod results;
mod sniff;
