//! How fast Struna is beside its peers and limits, each pair measured in the same run.
//!
//! Criterion is not used, because it finishes one benchmark before it starts the next: on a shared
//! machine the two sides of a ratio would then meet different neighbours. Here the sides take
//! turns in short bursts, and the best burst of each counts, for whatever disturbs a burst only
//! ever makes it longer.
//!
//! A missed target is reported, not punished: the exit code is 0 unless something is broken.

#![expect(clippy::print_stdout, reason = "the table is what a bench is for")]

mod chain;
mod decoder;
mod filters;
mod fmus;
mod table;
mod timing;
mod truth;

use anyhow::Result;
use table::Row;

fn main() -> Result<()> {
    let mut rows: Vec<Row> = Vec::new();
    for part in [filters::rows, fmus::rows, truth::rows, decoder::rows, chain::rows] {
        rows.extend(part()?);
    }
    println!("{}", table::render(&rows));
    Ok(())
}
