//! How fast Struna is beside its peers and limits, each pair measured in the same run.
//!
//! Criterion is not used, because it finishes one benchmark before it starts the next: on a shared
//! machine the two sides of a ratio would then meet different neighbours. Here the sides take
//! turns in short bursts, and the best burst of each counts, for whatever disturbs a burst only
//! ever makes it longer.
//!
//! A missed target is reported, not punished: the exit code is 0 unless something is broken. Names
//! of parts as arguments, as in `cargo bench --bench ratios -- fmus`, run those parts alone.

#![expect(clippy::print_stdout, reason = "the table is what a bench is for")]

mod allan;
mod augmented;
mod batch;
mod chain;
mod decoder;
mod filters;
mod fmus;
mod fused;
mod gyro;
mod line;
mod rapier;
mod swing;
mod table;
mod timing;
mod truth;

use anyhow::{Result, ensure};
use table::Row;

type Part = (&'static str, fn() -> Result<Vec<Row>>);

const PARTS: [Part; 13] = [
    ("filters", filters::rows),
    ("augmented", augmented::rows),
    ("swing", swing::rows),
    ("fmus", fmus::rows),
    ("truth", truth::rows),
    ("batch", batch::rows),
    ("rapier", rapier::rows),
    ("gyro", gyro::rows),
    ("decoder", decoder::rows),
    ("fused", fused::rows),
    ("chain", chain::rows),
    ("allan", allan::rows),
    ("line", line::rows),
];

fn main() -> Result<()> {
    // Cargo adds options of its own, which are for Rust's test harness.
    let asked: Vec<_> = std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    for word in &asked {
        let known = PARTS.map(|(name, _)| name);
        ensure!(known.contains(&word.as_str()), "no part is called {word}; there are {known:?}");
    }
    let mut rows = Vec::new();
    for (name, part) in PARTS {
        if asked.is_empty() || asked.iter().any(|word| word == name) {
            rows.extend(part()?);
        }
    }
    println!("{}", table::render(&rows));
    Ok(())
}
