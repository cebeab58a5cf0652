//! `report.json` of a live run, and the lines that a person reads.

use super::recorder::Figures;
use super::statistics::{BetweenFrames, ErrorRate, GapBin};
use serde::Serialize;
use std::fmt;
use struna_harness::live::LiveReport;
use struna_kernel::RAD_PER_DEG;

/// The content of `report.json`; docs/outputs.md explains each key.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HilReport {
    schema: &'static str,
    program_version: &'static str,
    frame: String,
    source: String,
    interrupted: bool,
    recorded_until_s: f64,
    rate_samples: u64,
    line: Line,
    frame_error_rate: Option<ErrorRate>,
    gaps: Vec<GapBin>,
    between_frames: Option<BetweenFrames>,
    skew_ppm: Option<f64>,
    skew_sigma_ppm: Option<f64>,
    estimators: Vec<Final>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct Line {
    frames_ok: u64,
    bad_checks: u64,
    frames_duplicate: u64,
    frames_not_valid: u64,
    samples_lost_on_line: u64,
    samples_lost_with_port: u64,
    gaps_inferred: u64,
    port_losses: u64,
    longest_gap_s: f64,
    bytes: u64,
    bytes_skipped: u64,
    resyncs: u64,
    samples_over_range: u64,
}

/// What an estimator believed at the end.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Final {
    name: String,
    angle_deg: f64,
    angle_sigma_deg: f64,
    rate_deg_s: f64,
    rate_sigma_deg_s: f64,
    status: &'static str,
}

impl HilReport {
    /// Puts the results together of frames called `frame` from `source`, for estimators called
    /// `names`.
    #[must_use]
    pub fn new(
        frame: &str,
        source: &str,
        names: &[String],
        live: &LiveReport,
        figures: &Figures,
        interrupted: bool,
    ) -> Self {
        let wire = &live.wire;
        let finals = names.iter().zip(&figures.estimates).map(|(name, e)| Final {
            name: name.clone(),
            angle_deg: e.angle_rad / RAD_PER_DEG,
            angle_sigma_deg: e.angle_sigma_rad / RAD_PER_DEG,
            rate_deg_s: e.rate_rad_s / RAD_PER_DEG,
            rate_sigma_deg_s: e.rate_sigma_rad_s / RAD_PER_DEG,
            status: e.status.words(),
        });
        Self {
            schema: "struna.hil/1",
            program_version: env!("CARGO_PKG_VERSION"),
            frame: frame.to_owned(),
            source: source.to_owned(),
            interrupted,
            recorded_until_s: figures.recorded_until.as_s(),
            rate_samples: live.outputs,
            line: Line {
                frames_ok: wire.ok,
                bad_checks: wire.bad_check + wire.bad_sequence,
                frames_duplicate: wire.duplicates,
                frames_not_valid: live.not_valid,
                samples_lost_on_line: live.lost_on_line,
                samples_lost_with_port: live.lost_with_port,
                gaps_inferred: live.inferred_gaps,
                port_losses: figures.port_losses,
                longest_gap_s: live.longest_gap_s,
                bytes: wire.bytes,
                bytes_skipped: wire.skipped_bytes,
                resyncs: wire.resyncs,
                samples_over_range: live.over_range,
            },
            frame_error_rate: error_rate(live),
            gaps: figures.gaps.bins(),
            between_frames: figures.arrivals.between(),
            skew_ppm: live.skew.map(|skew| skew.ppm),
            skew_sigma_ppm: live.skew.map(|skew| skew.sigma_ppm),
            estimators: finals.collect(),
        }
    }
}

/// Frames that should have come while the port was there, and did not.
fn error_rate(live: &LiveReport) -> Option<ErrorRate> {
    ErrorRate::of(live.lost_on_line, live.wire.ok.saturating_add(live.lost_on_line))
}

impl fmt::Display for HilReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write_estimators(f)?;
        self.write_line(f)?;
        self.write_time(f)
    }
}

impl HilReport {
    fn write_estimators(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.estimators.iter().map(|e| e.name.len()).max().unwrap_or(0).max(9);
        writeln!(
            f,
            "{:width$}  {:>11}  {:>9}  {:>11}  {:>9}  status",
            "estimator", "angle, deg", "+-", "rate, deg/s", "+-"
        )?;
        for e in &self.estimators {
            writeln!(
                f,
                "{:width$}  {:>11.4}  {:>9}  {:>11.6}  {:>9}  {}",
                e.name,
                e.angle_deg,
                claimed(e.angle_sigma_deg, 4),
                e.rate_deg_s,
                claimed(e.rate_sigma_deg_s, 6),
                e.status,
            )?;
        }
        writeln!(f)
    }

    fn write_line(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let line = &self.line;
        writeln!(
            f,
            "frames  {} good, {} bad checks, {} lost on the line, {} duplicate ({})",
            line.frames_ok,
            line.bad_checks,
            line.samples_lost_on_line,
            line.frames_duplicate,
            self.frame,
        )?;
        if let Some(rate) = &self.frame_error_rate {
            writeln!(
                f,
                "errors  {} of the frames; 95 % interval {} to {}",
                share(rate.rate),
                share(rate.low),
                share(rate.high)
            )?;
        }
        writeln!(
            f,
            "bytes   {} received, {} skipped, {} resyncs",
            line.bytes, line.bytes_skipped, line.resyncs
        )?;
        if line.port_losses > 0 {
            let (losses, lost) = (line.port_losses, line.samples_lost_with_port);
            writeln!(f, "port    times gone: {losses}, samples lost by that: {lost}")?;
        }
        if self.gaps.is_empty() {
            return writeln!(f, "gaps    none");
        }
        let bin = |bin: &GapBin| match bin.lost_from == bin.lost_to {
            true => format!("{} of {}", bin.gaps, bin.lost_from),
            false => format!("{} of {} to {}", bin.gaps, bin.lost_from, bin.lost_to),
        };
        let bins: Vec<_> = self.gaps.iter().map(bin).collect();
        writeln!(f, "gaps    {} samples; longest {:.3} s", bins.join(", "), line.longest_gap_s)
    }

    fn write_time(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(between) = &self.between_frames {
            let ms = [between.p50_s, between.p90_s, between.p99_s, between.p99_9_s, between.max_s];
            let [p50, p90, p99, p99_9, max] = ms.map(|s| s * 1e3);
            writeln!(
                f,
                "between frames, ms: p50 {p50:.3}, p90 {p90:.3}, p99 {p99:.3}, p99.9 {p99_9:.3}, \
                 max {max:.3}"
            )?;
        }
        match (self.skew_ppm, self.skew_sigma_ppm) {
            (Some(ppm), Some(sigma)) => {
                write!(f, "time    {:.3} s; ", self.recorded_until_s)?;
                write!(f, "the gyro's period is off by {ppm:+.2} +- {sigma:.2} ppm")
            }
            _ => write!(f, "time    {:.3} s; too short to tell the skew", self.recorded_until_s),
        }
    }
}

/// A claimed deviation; an estimator that claims none has a dash.
fn claimed(sigma: f64, digits: usize) -> String {
    if sigma.is_nan() { "-".to_owned() } else { format!("{sigma:.digits$}") }
}
/// A share as a person writes it: powers of ten are no way to say none.
fn share(share: f64) -> String {
    if share > 0.0 { format!("{share:.2e}") } else { "0".to_owned() }
}
