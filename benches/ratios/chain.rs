//! The whole chain, `struna demo`: one torsion period from true motion to scored estimates.

use crate::table::Row;
use crate::timing::{best_in_turns, time_per_unit};
use anyhow::{Context, Result, ensure};
use std::process::Command;

const SIMULATED_S: f64 = 480.0;
/// What the demo may take on a laptop.
const LIMIT_S: f64 = 20.0;

pub(crate) fn rows() -> Result<Vec<Row>> {
    let [taken_s] = best_in_turns([Box::new(|| time_per_unit(1, demo))])?;
    Ok(vec![Row {
        what: "struna demo, 480 s of the laboratory".into(),
        ours: format!("{taken_s:.2} s ({:.0} x real time)", SIMULATED_S / taken_s),
        other: format!("{LIMIT_S:.0} s (limit)"),
        ratio: Some(LIMIT_S / taken_s),
        target: 1.0,
    }])
}

fn demo() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let run = Command::new(env!("CARGO_BIN_EXE_struna"))
        .args(["demo", "--out"])
        .arg(folder.path())
        .output()
        .context("cannot start struna")?;
    ensure!(run.status.success(), "struna demo: {}", String::from_utf8_lossy(&run.stderr));
    Ok(())
}
