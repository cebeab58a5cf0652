//! `struna demo` and `struna run`.

use super::Outcome;
use crate::output::{create_folder, write_whole};
use crate::progress::Progress;
use crate::report::Report;
use crate::scenario::Scenario;
use crate::session::{self, Drive, Session};
use crate::{backend, faults, figure, score::Score};
use anyhow::{Context, Result};
use std::path::{Path, PathBuf};
use struna_harness::fault::write_fault_csv;
use struna_harness::{Pacing, RunReport};
use struna_line::StopFlag;

pub(super) use struna_harness::Pacing as Speed;

pub(super) fn execute(scenario: Scenario, out: Option<PathBuf>, pacing: Pacing) -> Result<Outcome> {
    let out = out.unwrap_or_else(|| Path::new("out").join(&scenario.name));
    let stop = StopFlag::new();
    let on_interrupt = stop.clone();
    ctrlc::set_handler(move || on_interrupt.stop()).context("cannot listen for Ctrl-C")?;
    let fmu_folder = out.join("fmu");
    create_folder(&fmu_folder)?;
    for note in faults::unseen(&scenario) {
        println!("{note}");
    }
    let mut progress = Progress::new(scenario.duration, &scenario.name);
    let session = session::run(
        &scenario,
        Drive {
            fmu_folder: &fmu_folder,
            pacing,
            stop: &stop,
            progress: &mut |time| progress.advance(time),
        },
    )?;
    progress.finish();
    finish(&scenario, &session, &out)?;
    let RunReport { interrupted, stopped, .. } = session.report;
    match stopped {
        Some(reason) => {
            let kept = format!("recorded in {} until the motion stopped", out.display());
            Err(anyhow::Error::from(reason).context(kept))
        }
        None => Ok(if interrupted { Outcome::Interrupted } else { Outcome::Complete }),
    }
}

/// Writes record, score and figure, and prints the table.
fn finish(scenario: &Scenario, session: &Session, out: &Path) -> Result<()> {
    let Session { record, report } = session;
    let score = Score::of(record);
    write_whole(&out.join("record.csv"), |file| record.write_csv(file))?;
    let faulty = !scenario.faults.is_empty();
    if faulty {
        write_whole(&out.join("faults.csv"), |file| write_fault_csv(&report.faults, file))?;
    }
    let title = format!(
        "{}: {} s, seed {}, truth by {}",
        scenario.name,
        scenario.duration.as_s(),
        scenario.seed.0,
        backend::sentence(&scenario.source)
    );
    let svg = figure::svg(record, &title)?;
    write_whole(&out.join("figure.svg"), |file| file.write_all(svg.as_bytes()))?;
    let report = Report::new(scenario, record, report, &score);
    let json = serde_json::to_string_pretty(&report)?;
    write_whole(&out.join("score.json"), |file| writeln!(file, "{json}"))?;
    let sidecar = if faulty { ", faults.csv" } else { "" };
    println!(
        "{score}\n\n{report}\n\nwritten to {}: record.csv, score.json, figure.svg{sidecar}",
        out.display()
    );
    Ok(())
}
