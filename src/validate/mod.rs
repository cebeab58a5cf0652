//! How far each estimator can be trusted: campaigns of many runs, requirements, verdicts.
//!
//! A [`Suite`] asks one question. Its cases draw a motion and a gyro for each run and let
//! estimators race on the same measurements; every run of every estimator becomes a [`Row`]. A
//! [`Requirement`] holds a statistic of some rows against a range, with the interval that so many
//! runs leave open. Table, files and report read rows and verdicts and nothing else.
//!
//! **Architecture Invariant:** one seed makes the same rows on any number of threads. Estimators
//! get measured rates; truth goes to the tally beside them.

mod bound;
pub mod campaign;
mod contestant;
mod entrant;
pub mod figures;
mod gyro;
pub mod junit;
mod kicks;
mod limits;
mod line;
mod paper;
pub mod parquet;
mod race;
mod refinement;
pub mod report;
pub mod requirement;
pub mod row;
mod slip;
pub mod statistics;
pub mod suite;
mod swing;
mod swing_rig;
pub mod table;
mod tally;
mod thread;
mod torsion;

pub use campaign::{Plan, Results, Watcher, run};
pub use requirement::{Judgement, Requirement, Statistic, Verdict};
pub use row::{Column, Outcome, Row};
pub use suite::{Case, Figure, RunId, Suite};

/// Judges all requirements of `suites` by `results`.
#[must_use]
pub fn judge(suites: &[Suite], results: &Results) -> Vec<Judgement> {
    let of = |suite: &Suite| {
        let rows = results.of(suite.name);
        let judge = |requirement: &Requirement| requirement.judge(suite.name, &rows);
        suite.requirements.iter().map(judge).collect::<Vec<_>>()
    };
    suites.iter().flat_map(of).collect()
}
