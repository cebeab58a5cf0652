//! However the work is cut, the outcome is the same.

use crate::rig::{Case, PERIOD_S, Run};
use struna_estimator::{AcceptedFit, FitOutcome, Progress, Rejection, SwingFit};

/// Pushes a sample and works, over and over.
fn live(run: &Run, samples: usize, steps: usize) -> SwingFit {
    let mut fit = SwingFit::new(&run.config, PERIOD_S).unwrap();
    for rate in &run.measured_rad_s[..samples] {
        fit.push(*rate);
        fit.work(steps);
    }
    fit
}

fn accepted(fit: &SwingFit) -> Option<&AcceptedFit> {
    match fit.outcome() {
        FitOutcome::Accepted(fit) => Some(fit),
        _ => None,
    }
}

#[test]
fn budgets_of_1_7_and_1000_steps_give_the_same_bits() {
    let run = Run::of(&Case::new(3.0, 0, 60));
    let mut whole = run.fit();
    let whole = whole.run_to_end().unwrap();
    for steps in [1, 7, 1000] {
        let mut fit = run.fit();
        while fit.work(steps) == Progress::Working {}
        // Debug prints every digit: the same text, the same bits.
        assert_eq!(format!("{:?}", accepted(&fit)), format!("{:?}", Some(whole)), "{steps}");
    }
}

#[test]
fn work_between_samples_gives_the_same_bits() {
    let run = Run::of(&Case::new(3.0, 0, 90));
    let mut whole = run.fit();
    let whole = whole.run_to_end().unwrap();
    let mut fit = live(&run, 6000, 31);
    while fit.work(31) == Progress::Working {}
    assert_eq!(format!("{:?}", accepted(&fit)), format!("{:?}", Some(whole)));
    // With 64 steps a sample the fit is ready soon after its window.
    let fit = live(&run, 7000, 64);
    assert_eq!(format!("{:?}", accepted(&fit)), format!("{:?}", Some(whole)));
    let same = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits();
    assert_eq!(fit.samples_after().len(), 1000);
    assert!(fit.samples_after().iter().zip(&run.measured_rad_s[6000..]).all(same));
}

#[test]
fn no_budget_is_no_work() {
    let run = Run::of(&Case::new(3.0, 0, 30));
    let mut fit = run.fit();
    for _ in 0..3 {
        assert_eq!(fit.work(0), Progress::Working);
    }
}

#[test]
fn a_fit_that_is_left_without_work_gives_up_old_samples_and_says_so() {
    let run = Run::of(&Case::new(0.0, 0, 60));
    let mut fit = run.fit();
    assert!(fit.samples_after().is_empty());
    for _ in 0..3 {
        for rate in &run.measured_rad_s {
            fit.push(*rate);
        }
    }
    assert_eq!(fit.restarts(), 3);
    assert_eq!(fit.outcome(), FitOutcome::Pending { rejected: Some(Rejection::Starved) });
}
