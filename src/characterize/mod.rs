//! From a file of rates at rest to a gyro's noise: table, JSON, figure and preset.
//!
//! [`file`](mod@file) reads, [`struna_gyro::characterise`] calculates, and [`Report`], [`figure`]
//! and [`preset`] say what came out, in the units of data sheets.

mod error;
pub mod figure;
pub mod file;
mod lines;
pub mod preset;
mod report;
mod text;
pub mod unit;

pub use error::CharacterizeError;
pub use report::Report;

use struna_gyro::characterise::{Characterisation, Options, RateRecord};

/// A characterised record with what describes it.
#[derive(Debug, Clone)]
pub struct Characterized {
    /// What the gyro is called.
    pub name: String,
    /// The file, as typed.
    pub source: String,
    /// The column of rates.
    pub rate_column: String,
    /// The rates.
    pub record: RateRecord,
    /// What was asked.
    pub options: Options,
    /// What they say.
    pub found: Characterisation,
}
