//! One seed makes one result; what stops is a row.

use crate::desk::{Numbers, Silent, suite};
use std::sync::atomic::{AtomicUsize, Ordering};
use struna::validate::parquet::write_parquet;
use struna::validate::table::write_csv;
use struna::validate::{Outcome, Plan, Results, Suite, Watcher, run};
use struna_kernel::Seed;

fn plan(runs: u32, seed: u64, threads: usize) -> Plan {
    Plan { runs: Some(runs), seed: Seed(seed), threads }
}

/// Both tables as bytes.
fn bytes(results: &Results) -> (Vec<u8>, Vec<u8>) {
    let (mut csv, mut parquet) = (Vec::new(), Vec::new());
    write_csv(&results.rows, &mut csv).unwrap();
    write_parquet(&results.rows, !results.is_partial(), &mut parquet).unwrap();
    (csv, parquet)
}

#[test]
fn one_seed_makes_the_same_bytes_on_any_number_of_threads() {
    for name in ["limits", "gyro"] {
        let suites = [Suite::named(name).unwrap()];
        let alone = bytes(&run(&suites, &plan(2, 7, 1), &Silent));
        let many = bytes(&run(&suites, &plan(2, 7, 5), &Silent));
        assert!(alone == many, "{name}");
        assert!(alone.0.len() > 10_000, "{name}: {} bytes", alone.0.len());
        let other = bytes(&run(&suites, &plan(1, 8, 2), &Silent));
        let fresh = bytes(&run(&suites, &plan(1, 7, 2), &Silent));
        assert!(other != fresh, "{name}: another seed");
    }
}

#[test]
fn a_run_does_not_depend_on_how_many_there_are() {
    let suites = [Suite::named("paper").unwrap()];
    let one = run(&suites, &plan(1, 7, 2), &Silent);
    let two = run(&suites, &plan(2, 7, 2), &Silent);
    let first: Vec<_> = two.rows.into_iter().filter(|row| row.run == 0).collect();
    // Rows hold numbers that are none, which equal nothing: compared as text.
    assert_eq!(format!("{:?}", one.rows), format!("{first:?}"));
}

#[test]
fn rows_come_by_case_estimator_and_run() {
    let case = |name| Box::new(Numbers { name, fails: false }) as Box<_>;
    let suites = [suite(vec![case("b"), case("a")], Vec::new())];
    let results = run(&suites, &plan(3, 1, 3), &Silent);
    let order: Vec<(String, String, u32)> =
        results.rows.iter().map(|r| (r.case.clone(), r.estimator.clone(), r.run)).collect();
    let mut expected = Vec::new();
    for case in ["b", "a"] {
        for estimator in ["first", "second <&>"] {
            expected.extend((0..3).map(|run| (case.to_owned(), estimator.to_owned(), run)));
        }
    }
    assert_eq!(order, expected);
    assert_eq!(results.done, (6, 6));
}

#[test]
fn a_run_that_stopped_is_a_row_with_its_reason() {
    let suites = [suite(vec![Box::new(Numbers { name: "weak", fails: true })], Vec::new())];
    let results = run(&suites, &plan(8, 1, 2), &Silent);
    assert_eq!(results.rows.len(), 16, "two estimators, eight runs");
    for row in &results.rows {
        let stopped = row.outcome == Outcome::Stopped("the string broke".to_owned());
        assert_eq!(stopped, row.run % 4 == 3, "{row:?}");
    }
    let (csv, _) = bytes(&results);
    assert_eq!(String::from_utf8(csv).unwrap().matches("the string broke").count(), 4);
}

/// Stops a campaign after some runs.
struct After(AtomicUsize);

impl Watcher for After {
    fn progress(&self, _: usize, _: usize) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }

    fn is_stopped(&self) -> bool {
        self.0.load(Ordering::Relaxed) == 0
    }
}

#[test]
fn a_campaign_that_is_stopped_keeps_what_it_has_and_says_so() {
    let suites = [suite(vec![Box::new(Numbers { name: "long", fails: false })], Vec::new())];
    let plan = plan(100, 1, 1);
    let results = run(&suites, &plan, &After(AtomicUsize::new(5)));
    assert_eq!((results.done, results.rows.len()), ((5, 100), 10));
    assert!(results.is_partial());
    let whole = run(&suites, &plan, &Silent);
    assert!(!whole.is_partial());
    let kept = whole.rows.into_iter().filter(|row| row.run < 5).collect::<Vec<_>>();
    assert_eq!(format!("{:?}", results.rows), format!("{kept:?}"));
    let page = struna::validate::report::html(&suites, &plan, &results, &[]).unwrap();
    assert!(page.contains("Partial result") && page.contains("5 of 100 runs"), "{page}");
}
