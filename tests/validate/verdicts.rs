//! Verdicts on rows made by hand.

use crate::desk::{SUITE, row};
use struna::validate::{Column, Requirement, Row, Statistic, Verdict};

const END: Column = Column::EndSigmas;
const HALF2: Column = Column::AngleHalf2Deg;

fn verdict(rows: &[Row], statistic: Statistic, range: std::ops::RangeInclusive<f64>) -> Verdict {
    let rows: Vec<&Row> = rows.iter().collect();
    Requirement::new(("case", "filter"), statistic, range).judge(SUITE, &rows).verdict
}

fn rows(runs: u32, column: Column, value: impl Fn(u32) -> f64) -> Vec<Row> {
    (0..runs).map(|run| row(run, column, Some(value(run)))).collect()
}

#[test]
fn a_share_is_met_only_when_enough_runs_say_so() {
    let beyond = Statistic::ShareAbove(END, 3.0);
    // 1 - 0.025^(1/n): 1.8 % of 200, 8.8 % of 40.
    assert_eq!(verdict(&rows(200, END, |_| 1.0), beyond, 0.0..=0.02), Verdict::Met);
    assert_eq!(verdict(&rows(40, END, |_| 1.0), beyond, 0.0..=0.02), Verdict::Undecided);
    let half = |run| if run % 2 == 0 { 4.0 } else { 1.0 };
    assert_eq!(verdict(&rows(40, END, half), beyond, 0.0..=0.02), Verdict::NotMet);
    // Exactly three sigma is not beyond them.
    assert_eq!(verdict(&rows(200, END, |_| 3.0), beyond, 0.0..=0.02), Verdict::Met);
}

#[test]
fn a_root_mean_square_is_known_to_1_96_over_the_root_of_2m() {
    let of = Statistic::Rms(HALF2);
    // 200 runs: 9.8 %.
    let rows = rows(200, HALF2, |run| if run % 2 == 0 { 1.0 } else { -1.0 });
    assert_eq!(verdict(&rows, of, 0.0..=1.099), Verdict::Met);
    assert_eq!(verdict(&rows, of, 0.0..=1.097), Verdict::Undecided);
    assert_eq!(verdict(&rows, of, 1.097..=2.0), Verdict::Undecided);
    assert_eq!(verdict(&rows, of, 1.099..=2.0), Verdict::NotMet);
}

#[test]
fn a_ratio_is_held_against_the_bound_of_the_same_runs() {
    let mut all = rows(200, HALF2, |_| 0.9);
    all.iter_mut().for_each(|row| row.set(Column::BoundAngleDeg, 1.0));
    let of = Statistic::RmsOver(HALF2, Column::BoundAngleDeg);
    assert_eq!(verdict(&all, of, 0.8..=1.15), Verdict::Met);
    all.iter_mut().for_each(|row| row.set(Column::BoundAngleDeg, 0.5));
    assert_eq!(verdict(&all, of, 0.8..=1.15), Verdict::NotMet);
}

#[test]
fn a_run_that_stopped_is_infinitely_wrong() {
    let mut rows = rows(199, HALF2, |_| 0.1);
    assert_eq!(verdict(&rows, Statistic::Rms(HALF2), 0.0..=0.6), Verdict::Met);
    rows.push(row(199, HALF2, None));
    assert_eq!(verdict(&rows, Statistic::Rms(HALF2), 0.0..=0.6), Verdict::NotMet);
    assert_eq!(verdict(&rows, Statistic::Median(HALF2), 0.0..=0.6), Verdict::Met);
    // One in 200 is a share of 0.5 %, at most 2.8 %.
    let beyond = Statistic::ShareAbove(HALF2, 3.0);
    assert_eq!(verdict(&rows, beyond, 0.0..=0.02), Verdict::Undecided);
    assert_eq!(verdict(&rows, beyond, 0.0..=0.03), Verdict::Met);
}

#[test]
fn a_claim_too_small_by_a_half_is_found_by_its_squares() {
    let with_nees = |nees: f64| {
        let mut rows = rows(200, Column::NeesStates, |_| 5.0);
        for row in &mut rows {
            row.epochs.iter_mut().for_each(|epoch| epoch.nees = nees);
        }
        rows
    };
    assert_eq!(verdict(&with_nees(4.5), Statistic::Nees, 3.0..=6.5), Verdict::Met);
    assert_eq!(verdict(&with_nees(9.0), Statistic::Nees, 3.0..=6.5), Verdict::NotMet);
    // One epoch of ten is enough to spoil it.
    let mut rows = with_nees(4.5);
    rows.iter_mut().for_each(|row| row.epochs[3].nees = 20.0);
    assert_ne!(verdict(&rows, Statistic::Nees, 3.0..=6.5), Verdict::Met);
}

#[test]
fn false_alarms_are_counted_by_poisson() {
    let alarms = Statistic::Count(Column::Alarms);
    let one_in_five = |run: u32| if run.is_multiple_of(5) { 1.0 } else { 0.0 };
    // 40 in 200 runs: at most 54.5, at least 28.6.
    let rows = rows(200, Column::Alarms, one_in_five);
    assert_eq!(verdict(&rows, alarms, 0.0..=0.28), Verdict::Met);
    assert_eq!(verdict(&rows, alarms, 0.0..=0.25), Verdict::Undecided);
    assert_eq!(verdict(&rows, alarms, 0.0..=0.14), Verdict::NotMet);
}

#[test]
fn the_best_length_is_told_with_those_that_cannot_be_told_from_it() {
    let mut rows = Vec::new();
    for (length, error) in [(1.0, 3.0), (10.0, 1.0), (100.0, 1.01), (1000.0, 4.0)] {
        for run in 0..20 {
            let scatter = 0.1 * f64::from(run % 5);
            let mut row = row(run, HALF2, Some(error + scatter));
            row.estimator = format!("F1 N={length}");
            row.set(Column::RefinementSamples, length);
            rows.push(row);
        }
    }
    let best = Statistic::BestRefinement("F1", HALF2);
    assert_eq!(verdict(&rows, best, 10.0..=100.0), Verdict::Met);
    assert_eq!(verdict(&rows, best, 10.0..=50.0), Verdict::Undecided);
    assert_eq!(verdict(&rows, best, 200.0..=5000.0), Verdict::NotMet);
}

#[test]
fn without_a_run_nothing_is_decided() {
    for statistic in [Statistic::Rms(HALF2), Statistic::Nees, Statistic::ShareWith(HALF2)] {
        assert_eq!(verdict(&[], statistic, 0.0..=1.0), Verdict::Undecided);
    }
}
