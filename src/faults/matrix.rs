//! All trials of a suite, and what they say about each detector.

use super::Stream;
use super::cases::{Case, cases};
use super::trial::{Trial, trial};
use anyhow::{Context, Result};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use struna_harness::fault::{FaultKind, FaultPlan, FaultRecord};
use struna_harness::monitor::{Alarm, Detector, Limits, Observability, observability};
use struna_kernel::{Seed, SimTime};

/// Faults begin this long after the start: what looks back has seen enough by then.
pub(super) const FIRST_S: f64 = 13.0;
/// Clean time comes in pieces of this length, so that threads can share it.
const PIECE_S: f64 = 900.0;
const DETECTORS: usize = Detector::ALL.len();

/// What to try and how often.
#[derive(Debug, Clone, PartialEq)]
pub struct Suite {
    /// The streams.
    pub streams: Vec<Stream>,
    /// Events of each fault of bytes and frames.
    pub byte_events: u32,
    /// Events of each short fault.
    pub short_events: u32,
    /// Events of each fault of some seconds.
    pub long_events: u32,
    /// Clean time of each stream, h.
    pub clean_hours: f64,
    /// Of everything random.
    pub seed: Seed,
}

impl Suite {
    /// Enough for two digits: 2990, 290 and 59 events.
    #[must_use]
    pub fn full(streams: Vec<Stream>, clean_hours: f64, seed: Seed) -> Self {
        Self { streams, byte_events: 2990, short_events: 290, long_events: 59, clean_hours, seed }
    }

    /// A tenth of that, for a first look.
    #[must_use]
    pub fn small(streams: Vec<Stream>, clean_hours: f64, seed: Seed) -> Self {
        Self { streams, byte_events: 300, short_events: 60, long_events: 20, clean_hours, seed }
    }
}

/// Results of a suite.
#[derive(Debug, Clone, PartialEq)]
pub struct Matrix {
    /// One for each stream.
    pub streams: Vec<StreamMatrix>,
}

/// Results of a stream.
#[derive(Debug, Clone, PartialEq)]
pub struct StreamMatrix {
    /// Which.
    pub stream: Stream,
    /// The limits that followed from what is declared of it.
    pub limits: Limits,
    /// A row for each fault.
    pub rows: Vec<Row>,
    /// What was alarmed without a fault.
    pub clean: Clean,
}

/// False alarms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clean {
    /// Clean time, h.
    pub hours: f64,
    /// Alarms by detector.
    pub alarms: [u32; DETECTORS],
}

impl Clean {
    /// The rate that so few alarms still allow with 95 %, 1/h: 3/hours when there were none.
    #[must_use]
    pub fn bound_per_hour(&self, detector: Detector) -> f64 {
        let alarms = self.alarms[detector.index()];
        // The mean at which so few or fewer come once in twenty times, by bisection.
        let (mut low, mut high) = (0.0, 20.0 + 2.0 * f64::from(alarms));
        for _ in 0..60 {
            let mean = 0.5 * (low + high);
            if few_or_fewer(mean, alarms) > 0.05 { low = mean } else { high = mean }
        }
        high / self.hours
    }
}

/// Probability of at most `n` events when `mean` are expected.
fn few_or_fewer(mean: f64, n: u32) -> f64 {
    let mut term = (-mean).exp();
    let mut sum = term;
    for k in 1..=n {
        term *= mean / f64::from(k);
        sum += term;
    }
    sum
}

/// One fault on one stream.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// What was injected.
    pub case: Case,
    /// Whether it can be seen at all, known before the run.
    pub observability: Observability,
    /// Events injected.
    pub events: u32,
    /// What each detector made of them.
    pub cells: [Cell; DETECTORS],
    /// What all of them together find but one.
    pub ablation: Ablation,
}

/// One detector on one fault.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cell {
    /// Events in or soon after which it raised an alarm.
    pub found: u32,
    /// Alarms it raised.
    pub alarms: u32,
    /// Of these, in or soon after an event.
    pub true_alarms: u32,
    /// Median time from the start of an event to its alarm, s.
    pub delay_s: Option<f64>,
}

impl Cell {
    /// Share of alarms that belong to an event; none without alarms.
    #[must_use]
    pub fn precision(&self) -> Option<f64> {
        (self.alarms > 0).then(|| f64::from(self.true_alarms) / f64::from(self.alarms))
    }
}

impl Row {
    /// Share of the events that `detector` found.
    #[must_use]
    pub fn recall(&self, detector: Detector) -> f64 {
        f64::from(self.cells[detector.index()].found) / f64::from(self.events.max(1))
    }

    /// The quickest detector that finds nearly all, with its delay, s.
    #[must_use]
    pub fn quickest(&self) -> Option<(Detector, f64)> {
        let able = Detector::ALL.into_iter().filter(|detector| self.recall(*detector) >= 0.9);
        let timed = able.filter_map(|d| Some((d, self.cells[d.index()].delay_s?)));
        timed.min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// Recall of the whole set, and without each of its seven parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ablation {
    /// Events found by any part.
    pub all: u32,
    /// Events found by any part but this.
    pub without: [u32; 7],
}

impl Ablation {
    /// The seven parts: name and detectors. The flag of saturation stays beside them, and rest
    /// needs knowledge from outside.
    pub const PARTS: [(&'static str, &'static [Detector]); 7] = [
        ("check", &[Detector::Check]),
        ("counter (gap, repeat)", &[Detector::Gap, Detector::Repeat]),
        ("stuck", &[Detector::Stuck]),
        ("step, innovation", &[Detector::Step, Detector::Innovation]),
        ("variance", &[Detector::Variance]),
        ("clock", &[Detector::Clock]),
        ("rate", &[Detector::Rate]),
    ];

    fn of(found_by: &[u16]) -> Self {
        let whole = bits(&Detector::ALL) & !bits(&[Detector::Rest]);
        let found = |by: u16| found_by.iter().map(|found| u32::from(found & by != 0)).sum();
        Self { all: found(whole), without: Self::PARTS.map(|(_, part)| found(whole & !bits(part))) }
    }

    /// Whether a fault that the whole set finds is lost without part `k`.
    #[must_use]
    pub fn is_lost_without(&self, k: usize, events: u32) -> bool {
        let share = |found: u32| f64::from(found) / f64::from(events.max(1));
        share(self.all) >= 0.95 && share(self.without[k]) < 0.8
    }
}

fn bits(detectors: &[Detector]) -> u16 {
    detectors.iter().fold(0, |bits, detector| bits | 1 << detector.index())
}

/// What one thread takes on.
#[derive(Debug, Clone, Copy)]
enum Job {
    Fault { stream: usize, case: Case },
    Clean { stream: usize, piece: u64, duration_s: f64 },
}

/// Runs `suite` on `threads` threads; `progress` is told of jobs done and jobs in all.
///
/// # Errors
/// What stopped a trial; a defect, since suites are constant.
///
/// # Panics
/// Never: locks are not held over anything that panics.
pub fn run(suite: &Suite, threads: usize, progress: &(dyn Fn(u64, u64) + Sync)) -> Result<Matrix> {
    let jobs = jobs(suite);
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<Option<Result<Trial>>>> = Mutex::new(jobs.iter().map(|_| None).collect());
    std::thread::scope(|scope| {
        for _ in 0..threads.max(1) {
            scope.spawn(|| {
                loop {
                    let at = next.fetch_add(1, Ordering::Relaxed);
                    let Some(job) = jobs.get(at) else { return };
                    let trial = carry_out(suite, *job, at);
                    let mut done = done.lock().expect("no holder panics");
                    done[at] = Some(trial);
                    let finished = done.iter().flatten().count() as u64;
                    drop(done);
                    progress(finished, jobs.len() as u64);
                }
            });
        }
    });
    let trials = done.into_inner().expect("no holder panics");
    let trials: Result<Vec<Trial>> =
        trials.into_iter().map(|trial| trial.context("a trial was not run")?).collect();
    gather(suite, &jobs, &trials?)
}

fn jobs(suite: &Suite) -> Vec<Job> {
    let mut jobs = Vec::new();
    for (stream, which) in suite.streams.iter().enumerate() {
        jobs.extend(cases(*which).into_iter().map(|case| Job::Fault { stream, case }));
        let (mut left_s, mut piece) = (suite.clean_hours * 3600.0, 0);
        while left_s > 0.0 {
            jobs.push(Job::Clean { stream, piece, duration_s: left_s.min(PIECE_S) });
            (left_s, piece) = (left_s - PIECE_S, piece + 1);
        }
    }
    // The longest first, or the last thread works alone: a fast gyro costs the most.
    jobs.sort_by_key(|job| match job {
        Job::Fault { stream, .. } | Job::Clean { stream, .. } => {
            suite.streams[*stream] != Stream::Adis
        }
    });
    jobs
}

fn carry_out(suite: &Suite, job: Job, number: usize) -> Result<Trial> {
    match job {
        Job::Fault { stream, case } => {
            let duration_s = case.trial_s(FIRST_S, case.family.events(suite));
            let plan = case.plan(FIRST_S);
            // Runs of faults are numbered apart from clean ones.
            let run = (1 << 32) + number as u64;
            trial(suite.streams[stream], &plan, duration_s, suite.seed, run)
        }
        Job::Clean { stream, piece, duration_s } => {
            let plan = FaultPlan::default();
            trial(suite.streams[stream], &plan, duration_s, suite.seed, piece)
        }
    }
}

fn gather(suite: &Suite, jobs: &[Job], trials: &[Trial]) -> Result<Matrix> {
    let streams = suite.streams.iter().enumerate().map(|(at, stream)| {
        let limits = Limits::of(&stream.declared())?;
        let mut clean = Clean { hours: suite.clean_hours, alarms: [0; DETECTORS] };
        let mut rows = Vec::new();
        for (job, trial) in jobs.iter().zip(trials) {
            match job {
                Job::Fault { stream: of, case } if *of == at => {
                    rows.push(row(*stream, &limits, *case, trial));
                }
                Job::Clean { stream: of, .. } if *of == at => {
                    for alarm in &trial.alarms {
                        clean.alarms[alarm.detector.index()] += 1;
                    }
                }
                _ => {}
            }
        }
        Ok(StreamMatrix { stream: *stream, limits, rows, clean })
    });
    Ok(Matrix { streams: streams.collect::<Result<_>>()? })
}

/// How long after an event an alarm may still be of it, s: what looks at one frame needs the
/// bridge's time, what looks at a second needs that second.
const fn tail_s(detector: Detector) -> f64 {
    match detector {
        Detector::Variance | Detector::Clock | Detector::Rate | Detector::Rest => 1.5,
        _ => 0.12,
    }
}

/// An event in the host's time.
#[derive(Debug, Clone, Copy)]
struct Span {
    start: SimTime,
    lasts_s: f64,
}

/// The events of a trial as the host meets them. Records hold the gyro's time, and what its clock
/// has lost in jumps and drifts so far lies between the two.
fn spans(records: &[FaultRecord]) -> Vec<Span> {
    let mut behind_ns = 0;
    let mut span = |record: &FaultRecord| {
        let start = SimTime::from_ns(record.start.as_ns() + behind_ns);
        let lasts_s = record.end.seconds_since(record.start);
        let lost_s = match record.kind {
            FaultKind::ClockJump { jump_s } => jump_s,
            FaultKind::ClockDrift { share } => share * lasts_s,
            _ => 0.0,
        };
        behind_ns += SimTime::from_s(lost_s).map_or(0, SimTime::as_ns);
        Span { start, lasts_s }
    };
    records.iter().map(&mut span).collect()
}

fn is_of(alarm: &Alarm, span: &Span) -> bool {
    let since_s = alarm.since.seconds_since(span.start);
    (0.0..=span.lasts_s + tail_s(alarm.detector)).contains(&since_s)
}

fn row(stream: Stream, limits: &Limits, case: Case, trial: &Trial) -> Row {
    let spans = spans(&trial.records);
    let mut found_by = vec![0_u16; spans.len()];
    let mut cells = [Cell::default(); DETECTORS];
    for detector in Detector::ALL {
        let alarms: Vec<_> = trial.alarms.iter().filter(|a| a.detector == detector).collect();
        let mut delays_s = Vec::new();
        for (found, span) in found_by.iter_mut().zip(&spans) {
            // Alarms are in the order of their beginnings.
            let from = alarms.partition_point(|alarm| alarm.since < span.start);
            if let Some(alarm) = alarms.get(from).filter(|alarm| is_of(alarm, span)) {
                *found |= bits(&[detector]);
                delays_s.push(alarm.since.seconds_since(span.start));
            }
        }
        let is_true = |alarm: &&&Alarm| {
            let to = spans.partition_point(|span| span.start <= alarm.since);
            spans[..to].iter().rev().take(8).any(|span| is_of(alarm, span))
        };
        let true_alarms = alarms.iter().filter(is_true).count();
        delays_s.sort_by(f64::total_cmp);
        cells[detector.index()] = Cell {
            found: count(delays_s.len()),
            alarms: count(alarms.len()),
            true_alarms: count(true_alarms),
            delay_s: delays_s.get(delays_s.len() / 2).copied(),
        };
    }
    Row {
        case,
        observability: observability(&case.fault(FIRST_S), &stream.declared(), limits),
        events: count(spans.len()),
        cells,
        ablation: Ablation::of(&found_by),
    }
}

fn count(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_alarm_in_a_day_bounds_the_rate_at_three_in_a_day() {
        let mut clean = Clean { hours: 24.0, alarms: [0; DETECTORS] };
        // -ln 0.05 = 2.9957.
        assert!((clean.bound_per_hour(Detector::Check) * 24.0 - 2.9957).abs() < 1e-3);
        clean.alarms[0] = 1;
        // The tabulated upper 95 % limit for one event.
        assert!((clean.bound_per_hour(Detector::Check) * 24.0 - 4.7439).abs() < 1e-3);
    }
}
