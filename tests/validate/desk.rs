//! Suites, cases and rows made for a test.

use anyhow::{Result, bail};
use struna::validate::{Case, Column, Requirement, Row, RunId, Suite, Watcher};

/// Name of the suite.
pub(crate) const SUITE: &str = "test";

/// A case whose runs are numbers that its seed and run make up. Every fourth run cannot begin.
pub(crate) struct Numbers {
    pub(crate) name: &'static str,
    pub(crate) fails: bool,
}

impl Case for Numbers {
    fn name(&self) -> &str {
        self.name
    }

    fn estimators(&self) -> Vec<String> {
        vec!["first".to_owned(), "second <&>".to_owned()]
    }

    fn run(&self, id: RunId) -> Result<Vec<Row>> {
        if self.fails && id.run % 4 == 3 {
            bail!("the string broke");
        }
        let row = |(k, name): (usize, &String)| {
            let mut row = id.row(SUITE, self.name, name);
            let value = (id.seed.0 as f64 + f64::from(id.run) * 1.37 + k as f64).sin();
            row.set(Column::AngleHalf2Deg, value);
            row
        };
        Ok(self.estimators().iter().enumerate().map(row).collect())
    }
}

/// A suite of cases and requirements.
pub(crate) fn suite(cases: Vec<Box<dyn Case>>, requirements: Vec<Requirement>) -> Suite {
    let draw = |_: &[&Row]| Ok(Vec::new());
    Suite { name: SUITE, about: "A suite for tests.", runs: 3, cases, requirements, draw }
}

/// Lets a campaign run to its end.
pub(crate) struct Silent;

impl Watcher for Silent {
    fn progress(&self, _: usize, _: usize) {}

    fn is_stopped(&self) -> bool {
        false
    }
}

/// A row with one number, or one that stopped.
pub(crate) fn row(run: u32, column: Column, value: Option<f64>) -> Row {
    let mut row = Row::new(SUITE, "case", "filter", (0, run));
    match value {
        Some(value) => row.set(column, value),
        None => row.outcome = struna::validate::Outcome::Stopped("it diverged".to_owned()),
    }
    row
}
