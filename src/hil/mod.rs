//! Live runs: a real or virtual port in, record and bytes out, and the same again from the bytes.

pub mod choose;
pub mod part_file;
pub mod raw;
pub mod recorder;
pub mod report;
pub mod serial;
pub mod setup;
pub mod statistics;
pub mod words;

use crate::output::{OutputError, create_folder, write_whole};
use crate::session;
use anyhow::Result;
use recorder::{Figures, Keep, Recorder, Screen};
use report::HilReport;
use setup::{Plan, Setup};
use std::path::{Path, PathBuf};
use struna_harness::live::{
    ByteSource, Ended, HostClock, Listening, LiveObserver, LivePipeline, LiveReport, listen,
};
use struna_kernel::SimTime;
use struna_line::StopFlag;

/// What a run was asked to do, kept beside its bytes.
pub const SETUP: &str = "setup.json";

/// Where the results of a live run go, and what may end it.
pub struct Bench<'a> {
    /// Folder for the results.
    pub out: &'a Path,
    /// What a person is shown.
    pub screen: &'a mut dyn Screen,
    /// Ends the run from outside.
    pub stop: &'a StopFlag,
    /// Ends it by the clock.
    pub until: Option<SimTime>,
    /// Ends it when no frame comes.
    pub strict: bool,
}

impl std::fmt::Debug for Bench<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Bench").field("out", &self.out).finish_non_exhaustive()
    }
}

/// What a live run left behind.
#[derive(Debug)]
pub struct Finished {
    /// Its figures, written to `report.json` as well.
    pub report: HilReport,
    /// Why it ended.
    pub ended: Ended,
}

/// Listens to `source`, which `name` describes, and records.
///
/// # Errors
/// Whatever stops the run; what came until then is in `out`.
pub fn run(
    setup: &Setup,
    name: &str,
    source: &mut dyn ByteSource,
    clock: &mut dyn HostClock,
    bench: Bench<'_>,
) -> Result<Finished> {
    let plan = setup.plan()?;
    let (mut pipeline, names) = begin(&plan, bench.out)?;
    let json = setup.to_json()?;
    write_whole(&bench.out.join(SETUP), |file| writeln!(file, "{json}"))?;
    let halt = StopFlag::new();
    let keep = Keep { bytes: true, has_cross: plan.has_cross() };
    let mut recorder =
        Recorder::create(bench.out, names.clone(), keep, halt.clone(), bench.screen)?;
    let stopped = || bench.stop.is_stopped() || halt.is_stopped();
    let listening = Listening { until: bench.until, stop: &stopped, strict: bench.strict };
    let ended = listen(source, clock, &mut pipeline, &mut recorder, &listening);
    let now = clock.now();
    let live = pipeline.finish(now, &mut recorder);
    let (figures, kept) = recorder.keep(now);
    let interrupted = matches!(ended, Ok(Ended::Stopped)) && !halt.is_stopped();
    let report = HilReport::new(plan.frame.name(), name, &names, &live, &figures, interrupted);
    let written = write_report(&report, bench.out);
    // The first cause first: a device that failed, a disk that refused, a report unwritten.
    let ended = ended?;
    kept?;
    written?;
    Ok(Finished { report, ended })
}

/// Decodes what a run left in `from` again, as `setup` says, into `out`.
///
/// # Errors
/// When the files cannot be read or written, or a device fails.
pub fn replay(setup: &Setup, from: &Path, out: &Path, screen: &mut dyn Screen) -> Result<Finished> {
    let plan = setup.plan()?;
    let (mut pipeline, names) = begin(&plan, out)?;
    let halt = StopFlag::new();
    let keep = Keep { bytes: false, has_cross: plan.has_cross() };
    let mut recorder = Recorder::create(out, names.clone(), keep, halt.clone(), screen)?;
    let replayed = raw::replay(from, &mut |time, input| {
        recorder.input(time, input);
        Ok(pipeline.take(time, input, &mut recorder)?)
    });
    let now = *replayed.as_ref().unwrap_or(&SimTime::ZERO);
    let live: LiveReport = pipeline.finish(now, &mut recorder);
    let (figures, kept): (Figures, Result<(), OutputError>) = recorder.keep(now);
    let name = from.display().to_string();
    let report = HilReport::new(plan.frame.name(), &name, &names, &live, &figures, false);
    let written = write_report(&report, out);
    replayed?;
    kept?;
    written?;
    Ok(Finished { report, ended: Ended::TimeUp })
}

fn begin(plan: &Plan, out: &Path) -> Result<(LivePipeline, Vec<String>)> {
    let fmus = fmu_folder(plan, out);
    create_folder(&fmus)?;
    let devices = session::devices(&plan.estimators, &fmus)?;
    let names = plan.estimators.iter().map(|plan| plan.name.clone()).collect();
    let frame = plan.frame.clone();
    let pipeline = LivePipeline::new(frame, plan.averaging_samples, plan.latency, devices)?;
    Ok((pipeline, names))
}

/// Where FMUs are built; just the folder when none is.
fn fmu_folder(plan: &Plan, out: &Path) -> PathBuf {
    use crate::scenario::RunAs;
    let is_built = |run_as: &RunAs| matches!(run_as, RunAs::Fmi2 | RunAs::Fmi3);
    let any = plan.estimators.iter().any(|plan| is_built(&plan.run_as));
    if any { out.join("fmu") } else { out.to_owned() }
}

fn write_report(report: &HilReport, out: &Path) -> Result<()> {
    let json = serde_json::to_string_pretty(report)?;
    write_whole(&out.join("report.json"), |file| writeln!(file, "{json}"))?;
    Ok(())
}
