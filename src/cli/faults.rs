//! Arguments of `struna faults`.

use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Arguments of `struna faults`.
#[derive(Debug, Args)]
pub struct Faults {
    /// Streams to try
    #[arg(long, value_enum, default_value = "all")]
    pub suite: FaultSuite,
    /// Seed of noise and faults
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Events of each fault: 300, 60 or 20 by its length, or 2990, 290 or 59
    #[arg(long, value_enum, default_value = "small")]
    pub events: EventCount,
    /// Clean time of each stream, in which every alarm is false, h
    #[arg(long, value_name = "HOURS", default_value = "1", value_parser = hours)]
    pub hours: f64,
    /// CSV file to write, one line for each cell
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Figure to write
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
}

/// Streams of `struna faults`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FaultSuite {
    /// VG-910D: CRC and counter
    Vg,
    /// ADIS16100: CRC and counter, coarse counts
    Adis,
    /// VG-910D behind a frame with an 8-bit sum and no counter
    Weak,
    /// All three
    All,
}

/// Events of `struna faults`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum EventCount {
    /// For a first look
    Small,
    /// For two digits
    Full,
}

fn hours(text: &str) -> Result<f64, &'static str> {
    let number = text.parse().ok().filter(|number: &f64| (0.0..=1000.0).contains(number));
    number.ok_or("write a number of hours, 0 to 1000")
}
