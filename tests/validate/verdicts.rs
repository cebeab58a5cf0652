//! Verdicts on rows made by hand.

use crate::desk::{SUITE, row};
use struna::validate::requirement::{Published, honest_nees};
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
fn a_root_mean_square_is_known_by_the_scatter_of_its_squares() {
    let of = Statistic::Rms(HALF2);
    // Squares of 0 and 2 in turns: 1 ± 1.972/√199 over 200 runs, its root from 0.928 to 1.068.
    let rows = rows(200, HALF2, |run| if run % 2 == 0 { 2_f64.sqrt() } else { 0.0 });
    assert_eq!(verdict(&rows, of, 0.0..=1.069), Verdict::Met);
    assert_eq!(verdict(&rows, of, 0.0..=1.066), Verdict::Undecided);
    assert_eq!(verdict(&rows, of, 1.066..=2.0), Verdict::Undecided);
    assert_eq!(verdict(&rows, of, 1.069..=2.0), Verdict::NotMet);
    assert_eq!(verdict(&rows[..1], of, 0.0..=10.0), Verdict::Undecided);
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
fn a_claim_that_is_not_honest_is_found_by_its_squares() {
    let with_nees = |nees: f64| {
        let mut rows = rows(1000, Column::NeesStates, |_| 5.0);
        for row in &mut rows {
            row.epochs.iter_mut().for_each(|epoch| epoch.nees = nees);
        }
        rows
    };
    // Of 200 runs at ten epochs: 5 ± 2.8·√(10/200), 0.6. A thousand runs leave 0.28 open.
    let honest = honest_nees(5.0);
    assert!((honest.start() - 4.4).abs() < 0.03 && (honest.end() - 5.65).abs() < 0.03);
    assert_eq!(verdict(&with_nees(5.0), Statistic::Nees, honest.clone()), Verdict::Met);
    assert_eq!(verdict(&with_nees(5.5), Statistic::Nees, honest.clone()), Verdict::Undecided);
    assert_eq!(verdict(&with_nees(6.1), Statistic::Nees, honest.clone()), Verdict::NotMet);
    assert_eq!(verdict(&with_nees(4.0), Statistic::Nees, honest.clone()), Verdict::NotMet);
    // One epoch of ten is enough to spoil it.
    let mut rows = with_nees(5.0);
    rows.iter_mut().for_each(|row| row.epochs[3].nees = 20.0);
    assert_ne!(verdict(&rows, Statistic::Nees, honest), Verdict::Met);
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
    // In runs of eight minutes one in five is 1.5 an hour, 1.07 to 2.04.
    let mut rows = rows;
    rows.iter_mut().for_each(|row| row.set(Column::DurationS, 480.0));
    let an_hour = Statistic::CountAnHour(Column::Alarms);
    assert_eq!(verdict(&rows, an_hour, 1.07..=2.05), Verdict::Met);
    assert_eq!(verdict(&rows, an_hour, 0.0..=2.0), Verdict::Undecided);
    assert_eq!(verdict(&rows, an_hour, 0.0..=1.06), Verdict::NotMet);
}

/// Squared errors of a filter of each length, least at `least`, with a scatter of their own.
fn refined(least: f64, scatter: f64) -> Vec<Row> {
    let mut rows = Vec::new();
    for length in [1.0, 20.0, 40.0, 50.0, 60.0, 80.0, 100.0, 1000.0_f64] {
        for run in 0..20 {
            let off = (length / least).ln();
            let own = scatter * (f64::from(run) * length).sin();
            let mut row = row(run, HALF2, Some((0.5 * off * off + own).exp()));
            row.estimator = format!("F1 N={length}");
            row.set(Column::RefinementSamples, length);
            rows.push(row);
        }
    }
    rows
}

#[test]
fn the_best_length_is_found_between_those_tried() {
    let best = Statistic::BestRefinement("F1", HALF2);
    let clear = refined(55.0, 1e-3);
    assert_eq!(verdict(&clear, best, 54.0..=56.0), Verdict::Met);
    assert_eq!(verdict(&clear, best, 57.0..=90.0), Verdict::NotMet);
    assert_eq!(verdict(&clear, best, 20.0..=53.0), Verdict::NotMet);
    // Where each length has a scatter of a tenth, 20 runs leave some per cent open.
    let scattered = refined(55.0, 0.1);
    assert_eq!(verdict(&scattered, best, 40.0..=80.0), Verdict::Met);
    assert_eq!(verdict(&scattered, best, 54.9..=55.1), Verdict::Undecided);
}

#[test]
fn what_is_promised_of_every_run_fails_by_one() {
    let end = Statistic::Largest(END);
    let mut many = rows(200, END, |_| 1.5);
    assert_eq!(verdict(&many, end, 0.0..=3.0), Verdict::Met);
    assert_eq!(verdict(&many[..49], end, 0.0..=3.0), Verdict::Undecided, "promised of fifty");
    many[137].set(END, 3.2);
    assert_eq!(verdict(&many, end, 0.0..=3.0), Verdict::NotMet);
    let mut stopped = rows(199, END, |_| 1.5);
    stopped.push(row(199, END, None));
    assert_eq!(verdict(&stopped, end, 0.0..=3.0), Verdict::NotMet);
}

#[test]
fn a_published_value_is_left_by_its_own_standard_errors() {
    let of = |value| {
        let published = Published { value, rounding: 5e-4, runs: 50 };
        Statistic::RmsOff(HALF2, published)
    };
    // Squares of 0.5 and 1.5 in turns: the root over 50 runs is 1 ± 0.25/√50 = 0.0354.
    let half = |run: u32| if run.is_multiple_of(2) { 0.5_f64.sqrt() } else { 1.5_f64.sqrt() };
    let rows = rows(5000, HALF2, half);
    assert_eq!(verdict(&rows, of(1.0), -0.5..=0.5), Verdict::Met);
    // 0.07 is two of them, known to a tenth of one twice over.
    assert_eq!(verdict(&rows, of(0.93), 1.7..=2.3), Verdict::Met);
    assert_eq!(verdict(&rows, of(1.07), -2.3..=-1.7), Verdict::Met);
    assert_eq!(verdict(&rows, of(1.2), -3.2..=3.2), Verdict::NotMet);
    let mut stopped = rows.clone();
    stopped.push(row(5000, HALF2, None));
    assert_eq!(verdict(&stopped, of(1.0), -99.0..=99.0), Verdict::NotMet);
    // Nineteen do not know their own scatter well enough to be held against anything.
    assert_eq!(verdict(&rows[..19], of(1.0), -99.0..=99.0), Verdict::Undecided);
}

#[test]
fn without_a_run_nothing_is_decided() {
    for statistic in [Statistic::Rms(HALF2), Statistic::Nees, Statistic::ShareWith(HALF2)] {
        assert_eq!(verdict(&[], statistic, 0.0..=1.0), Verdict::Undecided);
    }
}
