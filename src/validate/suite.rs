//! What a suite is: cases to run, requirements to hold them against, and figures.

use super::requirement::Requirement;
use super::row::Row;
use super::{gyro, kicks, limits, line, paper, swing, thread};
use crate::figure::FigureError;
use anyhow::Result;
use struna_kernel::Seed;

/// One run of a campaign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RunId {
    /// Of everything random in the campaign.
    pub seed: Seed,
    /// Which run: equal numbers draw equal numbers in every case.
    pub run: u32,
}

impl RunId {
    /// An empty row of this run.
    #[must_use]
    pub fn row(self, suite: &'static str, case: &str, estimator: &str) -> Row {
        Row::new(suite, case, estimator, (self.seed.0, self.run))
    }
}

/// What is done to body, gyro or line, and the estimators that watch it.
///
/// A cell of the campaign is a case with one of its estimators. The estimators of a case run
/// together, so that each gets the very same measurements.
pub trait Case: Send + Sync {
    /// Name, unique in its suite.
    fn name(&self) -> &str;

    /// Names of the estimators, in the order of the rows.
    fn estimators(&self) -> Vec<String>;

    /// Makes a run: one row for each estimator. Depends on `id` alone.
    ///
    /// # Errors
    /// What stopped the run before any estimator had a part in it.
    fn run(&self, id: RunId) -> Result<Vec<Row>>;
}

/// A figure of the report.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// What is to be seen.
    pub caption: String,
    /// SVG.
    pub svg: String,
}

/// Draws the figures of a suite from its rows.
pub type Draw = fn(&[&Row]) -> Result<Vec<Figure>, FigureError>;

/// A suite.
pub struct Suite {
    /// Name on the command line.
    pub name: &'static str,
    /// What it asks, in a sentence or two.
    pub about: &'static str,
    /// Runs of each cell unless told otherwise.
    pub runs: u32,
    /// Cases.
    pub cases: Vec<Box<dyn Case>>,
    /// What must hold.
    pub requirements: Vec<Requirement>,
    /// Its figures.
    pub draw: Draw,
}

impl std::fmt::Debug for Suite {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Suite").field("name", &self.name).finish_non_exhaustive()
    }
}

impl Suite {
    /// Names of all suites, in the order in which they run.
    pub const NAMES: &[&str] = &["paper", "limits", "kicks", "gyro", "line", "thread", "swing"];

    /// The suite of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "paper" => Some(paper::suite()),
            "limits" => Some(limits::suite()),
            "kicks" => Some(kicks::suite()),
            "gyro" => Some(gyro::suite()),
            "line" => Some(line::suite()),
            "thread" => Some(thread::suite()),
            "swing" => Some(swing::suite()),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_requirement_names_a_cell_of_its_suite() {
        for name in Suite::NAMES {
            let suite = Suite::named(name).unwrap();
            assert_eq!(suite.name, *name);
            let cells: BTreeSet<(String, String)> = suite
                .cases
                .iter()
                .flat_map(|case| {
                    let name = case.name().to_owned();
                    case.estimators().into_iter().map(move |estimator| (name.clone(), estimator))
                })
                .collect();
            for requirement in &suite.requirements {
                let Requirement { case, estimator, .. } = requirement;
                let known = cells.contains(&(case.clone(), estimator.clone()));
                assert!(known, "{name}: no cell {case} / {estimator}");
                assert!(requirement.at_least <= requirement.at_most, "{name}: {requirement:?}");
            }
        }
    }
}
