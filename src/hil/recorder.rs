//! Keeps what a live run brings: record, bytes, events, figures.

use super::part_file::PartFile;
use super::raw::RawWriter;
use super::statistics::{Arrivals, Gaps};
use super::words;
use crate::output::OutputError;
use crate::record::{
    ESTIMATOR_SIGNALS, estimator_values, measured_signals, measured_values, write_csv_names,
    write_csv_row,
};
use std::io::{self, Write};
use std::path::Path;
use struna_harness::clock::{Resolved, Skew};
use struna_harness::live::{LineInput, LiveEvent, LiveObserver, LivePipeline};
use struna_kernel::{AngleEstimate, RateSample, SimTime};
use struna_line::StopFlag;

/// The record.
pub const RECORD: &str = "record.csv";
/// What happened besides.
pub const EVENTS: &str = "events.csv";
/// How often a person is shown the state.
const SHOWN_EVERY_NS: i64 = 100_000_000;
/// How often everything is handed to the system.
const FLUSHED_EVERY_NS: i64 = 1_000_000_000;

/// What a person watching a run is shown.
pub trait Screen {
    /// The present state, some ten times a second.
    fn status(&mut self, status: &Status<'_>);

    /// Something to know.
    fn say(&mut self, text: &str);
}

/// The state of a live run.
#[derive(Debug, Clone, Copy)]
pub struct Status<'a> {
    /// The record's time.
    pub time: SimTime,
    /// Mean rate of the last averaged sample, rad/s.
    pub rate_rad_s: Option<f64>,
    /// Names of the estimators.
    pub names: &'a [String],
    /// What they last believed.
    pub estimates: &'a [AngleEstimate],
    /// Good frames.
    pub frames: u64,
    /// Samples lost.
    pub lost: u64,
    /// The sensor's skew, once known.
    pub skew: Option<Skew>,
    /// For how long the port has been gone, s.
    pub gone_s: Option<f64>,
}

/// Figures that grow with the run.
#[derive(Debug, Clone, Default)]
pub struct Figures {
    /// Times between frames.
    pub arrivals: Arrivals,
    /// Gaps by their size.
    pub gaps: Gaps,
    /// How often the port was lost.
    pub port_losses: u64,
    /// What the devices last believed.
    pub estimates: Vec<AngleEstimate>,
    /// The last averaged rate, rad/s.
    pub rate_rad_s: Option<f64>,
    /// Time of the last averaged sample.
    pub recorded_until: SimTime,
}

/// What is kept of a run beside the estimates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Keep {
    /// The bytes.
    pub bytes: bool,
    /// Columns for the rates about the other two axes.
    pub has_cross: bool,
}

/// Writes as the run goes on. The first refusal of the disk stops the run; what came until then
/// is kept.
pub struct Recorder<'a> {
    record: PartFile,
    events: PartFile,
    raw: Option<RawWriter>,
    names: Vec<String>,
    has_cross: bool,
    screen: &'a mut dyn Screen,
    halt: StopFlag,
    failure: Option<OutputError>,
    figures: Figures,
    shown_ns: i64,
    flushed_ns: i64,
    arrival: SimTime,
    gone_since: Option<SimTime>,
}

impl std::fmt::Debug for Recorder<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Recorder").field("record", &self.record).finish_non_exhaustive()
    }
}

impl<'a> Recorder<'a> {
    /// Begins files in `folder` for estimators called `names`. `halt` is thrown when the disk
    /// refuses.
    ///
    /// # Errors
    /// [`OutputError`] when a file cannot be begun.
    pub fn create(
        folder: &Path,
        names: Vec<String>,
        keep: Keep,
        halt: StopFlag,
        screen: &'a mut dyn Screen,
    ) -> Result<Self, OutputError> {
        let begun = |name: &str| {
            let path = folder.join(name);
            PartFile::of_lines(&path).map_err(|source| OutputError { path, source })
        };
        let mut record = begun(RECORD)?;
        let failed = |source| OutputError { path: folder.join(RECORD), source };
        let columns = columns(&names, keep.has_cross);
        write_csv_names(columns.iter().map(String::as_str), record.entries()).map_err(failed)?;
        let mut events = begun(EVENTS)?;
        events.entries().extend(b"time,arrival_s,kind,detail\n");
        let raw = if keep.bytes {
            let failed = |(path, source)| OutputError { path, source };
            Some(RawWriter::create(folder).map_err(failed)?)
        } else {
            None
        };
        let figures = Figures { estimates: Vec::with_capacity(names.len()), ..Figures::default() };
        Ok(Self {
            record,
            events,
            raw,
            names,
            has_cross: keep.has_cross,
            screen,
            halt,
            failure: None,
            figures,
            shown_ns: i64::MIN,
            flushed_ns: 0,
            arrival: SimTime::ZERO,
            gone_since: None,
        })
    }

    /// Ends the files at `now` and gives them their names, the record even when others fail.
    ///
    /// # Errors
    /// The first refusal of the run.
    pub fn keep(self, now: SimTime) -> (Figures, Result<(), OutputError>) {
        let mut failure = self.failure;
        let record = self.record.path().to_owned();
        let mut note = |name: &str, kept: io::Result<()>| {
            if let (Err(source), None) = (kept, &failure) {
                failure = Some(OutputError { path: record.with_file_name(name), source });
            }
        };
        note(RECORD, self.record.keep());
        note(EVENTS, self.events.keep());
        note(super::raw::BYTES, self.raw.map_or(Ok(()), |raw| raw.keep(now)));
        (self.figures, failure.map_or(Ok(()), Err))
    }

    /// Notes what the disk said to the file called `name`.
    fn note(&mut self, name: &str, outcome: io::Result<()>) {
        if let Err(source) = outcome {
            self.halt.stop();
            let path = self.record.path().with_file_name(name);
            self.failure.get_or_insert(OutputError { path, source });
        }
    }

    fn flush(&mut self) {
        let flushed = self.record.flush();
        self.note(RECORD, flushed);
        let flushed = self.events.flush();
        self.note(EVENTS, flushed);
        let flushed = self.raw.as_mut().map_or(Ok(()), RawWriter::flush);
        self.note(super::raw::BYTES, flushed);
    }
}

/// Columns of the record: those of a run, without its truth.
fn columns(names: &[String], has_cross: bool) -> Vec<String> {
    let measured = measured_signals(has_cross);
    let of = |name: &String| ESTIMATOR_SIGNALS.map(|signal| format!("{name}.{signal}"));
    measured.into_iter().chain(names.iter().flat_map(of)).collect()
}

impl LiveObserver for Recorder<'_> {
    fn input(&mut self, time: SimTime, input: LineInput<'_>) {
        self.arrival = time;
        match input {
            LineInput::Lost => {
                self.figures.port_losses += 1;
                self.gone_since = Some(time);
            }
            LineInput::Back => self.gone_since = None,
            LineInput::Bytes(_) | LineInput::Silent => {}
        }
        let noted = self.raw.as_mut().map_or(Ok(()), |raw| raw.note(time, input));
        self.note(super::raw::BYTES, noted);
    }

    fn frame(&mut self, arrival: SimTime, _resolved: &Resolved) {
        self.figures.arrivals.add(arrival);
    }

    fn output(&mut self, sample: &RateSample, estimates: &[AngleEstimate]) {
        self.figures.rate_rad_s = Some(sample.rate_rad_s);
        self.figures.recorded_until = sample.time;
        self.figures.estimates.clear();
        self.figures.estimates.extend_from_slice(estimates);
        let measured = measured_values(sample, self.has_cross);
        let row = measured.chain(estimates.iter().flat_map(estimator_values));
        let written = write_csv_row(row, self.record.entries()).and_then(|()| self.record.settle());
        self.note(RECORD, written);
    }

    fn event(&mut self, time: SimTime, event: &LiveEvent) {
        if let LiveEvent::Gap(gap) = event {
            self.figures.gaps.add(gap.lost);
        }
        let detail = words::detail(event);
        let is_for_people = matches!(
            event,
            LiveEvent::PortLost { .. }
                | LiveEvent::PortBack { .. }
                | LiveEvent::CounterRestarted
                | LiveEvent::ClockSet { .. }
                | LiveEvent::NoFrames(_)
        );
        if is_for_people {
            self.screen.say(&format!("{}: {detail}", words::kind(event)));
        }
        let detail = detail.replace('"', "'").replace(['\n', '\r'], " ");
        let (time_s, arrival_s) = (time.as_s(), self.arrival.as_s());
        let kind = words::kind(event);
        let written =
            writeln!(self.events.entries(), "{time_s:.9},{arrival_s:.9},{kind},\"{detail}\"")
                .and_then(|()| self.events.settle());
        self.note(EVENTS, written);
    }

    fn look(&mut self, now: SimTime, pipeline: &LivePipeline) {
        let now_ns = now.as_ns();
        if now_ns >= self.flushed_ns.saturating_add(FLUSHED_EVERY_NS) {
            self.flushed_ns = now_ns;
            self.flush();
        }
        if now_ns < self.shown_ns.saturating_add(SHOWN_EVERY_NS) {
            return;
        }
        self.shown_ns = now_ns;
        let report = pipeline.report();
        self.screen.status(&Status {
            time: pipeline.time(),
            rate_rad_s: self.figures.rate_rad_s,
            names: &self.names,
            estimates: &self.figures.estimates,
            frames: report.wire.ok,
            lost: report.lost_on_line.saturating_add(report.lost_with_port),
            skew: report.skew,
            gone_s: self.gone_since.map(|since| now.seconds_since(since)),
        });
    }
}
