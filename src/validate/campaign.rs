//! All runs of some suites, on all cores.
//!
//! **Architecture Invariant:** a row depends on seed, case and number of its run alone. Threads
//! take runs as they come; rows are put in order afterwards, and no sum crosses runs before that.

use super::row::{Outcome, Row};
use super::suite::{RunId, Suite};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use struna_kernel::Seed;

/// How much is to be run, and how.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plan {
    /// Runs of each cell; each suite's own number when none is given.
    pub runs: Option<u32>,
    /// Of everything random.
    pub seed: Seed,
    /// Threads.
    pub threads: usize,
}

/// What came of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Results {
    /// By suite, case, estimator and run.
    pub rows: Vec<Row>,
    /// Runs done and runs planned.
    pub done: (usize, usize),
}

impl Results {
    /// Whether the campaign was stopped before its end.
    #[must_use]
    pub fn is_partial(&self) -> bool {
        self.done.0 < self.done.1
    }

    /// The rows of a suite.
    #[must_use]
    pub fn of(&self, suite: &str) -> Vec<&Row> {
        self.rows.iter().filter(|row| row.suite == suite).collect()
    }
}

#[derive(Debug, Clone, Copy)]
struct Job {
    suite: usize,
    case: usize,
    run: u32,
}

/// What a campaign tells of itself while it runs, and asks.
pub trait Watcher: Sync {
    /// So many runs of so many are done.
    fn progress(&self, done: usize, all: usize);

    /// Whether to begin no further run.
    fn is_stopped(&self) -> bool;
}

/// Runs `suites`.
///
/// # Panics
/// When a run panics: a defect.
#[must_use]
pub fn run(suites: &[Suite], plan: &Plan, watcher: &dyn Watcher) -> Results {
    let jobs = jobs(suites, plan);
    let next = AtomicUsize::new(0);
    let made: Mutex<(usize, Vec<Vec<Row>>)> = Mutex::new((0, vec![Vec::new(); jobs.len()]));
    std::thread::scope(|scope| {
        for _ in 0..plan.threads.clamp(1, jobs.len().max(1)) {
            scope.spawn(|| {
                while !watcher.is_stopped() {
                    let at = next.fetch_add(1, Ordering::Relaxed);
                    let Some(job) = jobs.get(at) else { return };
                    let rows = carry_out(&suites[job.suite], *job, plan.seed);
                    let mut made = made.lock().expect("no holder panics");
                    made.0 += 1;
                    made.1[at] = rows;
                    let done = made.0;
                    drop(made);
                    watcher.progress(done, jobs.len());
                }
            });
        }
    });
    let (done, rows) = made.into_inner().expect("no holder panics");
    Results { rows: in_order(suites, &jobs, rows), done: (done, jobs.len()) }
}

/// Run after run rather than case after case: what is stopped early has some of everything.
fn jobs(suites: &[Suite], plan: &Plan) -> Vec<Job> {
    let mut jobs = Vec::new();
    for (suite, of) in suites.iter().enumerate() {
        let runs = plan.runs.unwrap_or(of.runs);
        for run in 0..runs {
            jobs.extend((0..of.cases.len()).map(|case| Job { suite, case, run }));
        }
    }
    jobs
}

/// A run that cannot even begin is a row as well.
fn carry_out(suite: &Suite, job: Job, seed: Seed) -> Vec<Row> {
    let case = &suite.cases[job.case];
    let id = RunId { seed, run: job.run };
    case.run(id).unwrap_or_else(|error| {
        let stopped = |estimator: &String| {
            let mut row = id.row(suite.name, case.name(), estimator);
            row.outcome = Outcome::Stopped(format!("{error:#}"));
            row
        };
        case.estimators().iter().map(stopped).collect()
    })
}

fn in_order(suites: &[Suite], jobs: &[Job], made: Vec<Vec<Row>>) -> Vec<Row> {
    let mut placed: Vec<((usize, usize, usize, u32), Row)> = Vec::new();
    for (job, rows) in jobs.iter().zip(made) {
        let names = suites[job.suite].cases[job.case].estimators();
        for row in rows {
            let at = names.iter().position(|name| *name == row.estimator).unwrap_or(names.len());
            placed.push(((job.suite, job.case, at, job.run), row));
        }
    }
    placed.sort_by_key(|(place, _)| *place);
    placed.into_iter().map(|(_, row)| row).collect()
}
