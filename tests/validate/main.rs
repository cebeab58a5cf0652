//! `struna validate`: one seed one result, verdicts that follow from rows, and files that are read
//! by others.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod campaign;
mod command;
mod desk;
mod files;
mod verdicts;
