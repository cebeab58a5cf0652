//! `score.json`: what happened in a run, for other programs, and the lines that a person reads.

use crate::backend;
use crate::record::Record;
use crate::scenario::Scenario;
use crate::score::{EstimatorScore, Score};
use serde::Serialize;
use std::fmt;
use struna_harness::RunReport;

/// The content of `score.json`; docs/outputs.md explains each key.
///
/// Holds nothing that differs between two runs of one scenario and seed, lateness in a paced run
/// excepted.
#[derive(Debug, Clone, Serialize)]
pub struct Report<'a> {
    schema: &'static str,
    program_version: &'static str,
    scenario: &'a str,
    seed: u64,
    backend: String,
    duration_s: f64,
    recorded_until_s: f64,
    interrupted: bool,
    stopped: Option<String>,
    rate_samples: usize,
    line: LineReport,
    pacing: Option<PacingReport>,
    estimators: &'a [EstimatorScore],
}

#[derive(Debug, Clone, Serialize)]
struct LineReport {
    frame: String,
    frames_sent: u64,
    frames_received: u64,
    frames_lost: u64,
    frames_duplicate: u64,
    frames_not_valid: u64,
    bad_checks: u64,
    bytes_sent: u64,
    bytes_received: u64,
    bytes_skipped: u64,
    resyncs: u64,
    samples_saturated: u64,
    samples_flagged_over_range: u64,
}

#[derive(Debug, Clone, Serialize)]
struct PacingReport {
    frames_paced: u64,
    frames_behind: u64,
    late_mean_s: f64,
    late_max_s: f64,
}

impl<'a> Report<'a> {
    /// Puts a run's results together.
    #[must_use]
    pub fn new(scenario: &'a Scenario, record: &Record, run: &RunReport, score: &'a Score) -> Self {
        let wire = &run.pipeline.wire;
        Self {
            schema: "struna.score/1",
            program_version: env!("CARGO_PKG_VERSION"),
            scenario: &scenario.name,
            seed: scenario.seed.0,
            backend: backend::sentence(&scenario.source),
            duration_s: scenario.duration.as_s(),
            recorded_until_s: record
                .column("time")
                .and_then(|time| time.last().copied())
                .unwrap_or(0.0),
            interrupted: run.interrupted,
            stopped: run.stopped.as_ref().map(ToString::to_string),
            rate_samples: record.rows(),
            line: LineReport {
                frame: scenario.frame.name().to_owned(),
                frames_sent: run.emulator.frames,
                frames_received: wire.ok,
                frames_lost: wire.lost,
                frames_duplicate: wire.duplicates,
                frames_not_valid: run.pipeline.not_valid,
                bad_checks: wire.bad_check + wire.bad_sequence,
                bytes_sent: run.emulator.bytes,
                bytes_received: wire.bytes,
                bytes_skipped: wire.skipped_bytes,
                resyncs: wire.resyncs,
                samples_saturated: run.emulator.saturated,
                samples_flagged_over_range: run.pipeline.over_range,
            },
            pacing: run.late.as_ref().map(|late| PacingReport {
                frames_paced: late.waits(),
                frames_behind: late.overrun.count(),
                late_mean_s: late.mean_s(),
                late_max_s: late.max_s(),
            }),
            estimators: &score.estimators,
        }
    }
}

impl fmt::Display for Report<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let line = &self.line;
        writeln!(f, "truth   {}", self.backend)?;
        write!(
            f,
            "line    {} frames sent, {} received, {} lost, {} bad checks, {} over range ({})",
            line.frames_sent,
            line.frames_received,
            line.frames_lost,
            line.bad_checks,
            line.samples_flagged_over_range,
            line.frame,
        )?;
        if let Some(pacing) = &self.pacing {
            write!(
                f,
                "\npacing  late by {:.3} ms on average, {:.3} ms at most",
                pacing.late_mean_s * 1e3,
                pacing.late_max_s * 1e3,
            )?;
        }
        if self.interrupted || self.stopped.is_some() {
            write!(
                f,
                "\nstopped at {} s of {} s; everything until then is recorded",
                self.recorded_until_s, self.duration_s,
            )?;
        }
        Ok(())
    }
}
