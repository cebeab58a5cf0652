//! How far the angle is off, and whether the claim covers it.

use crate::campaign::{Outcome, all, bank_run, mean, median, runs, tested_run};
use crate::rig::Thread;
use struna_estimator::{HysteresisBank, RateEstimator, Status};
use struna_kernel::RAD_PER_DEG;

/// Runs of one case.
struct Case {
    name: &'static str,
    runs: Vec<(Outcome, HysteresisBank)>,
}

impl Case {
    fn of(name: &'static str, thread: Thread) -> Self {
        let case = Self { name, runs: all(runs(8), |run| bank_run(thread, run)) };
        case.print();
        case
    }

    fn print(&self) {
        let of = |of: fn(&Outcome) -> f64| mean(self.outcomes(), of);
        let lead = self.runs.iter().map(|(_, bank)| bank.yield_lead());
        println!(
            "{}: h2 {:.2} deg, end {:.2}, claimed {:.2}, beyond 3 sigma {:.2} %, worst {:.1}, \
             NIS {:.3}",
            self.name,
            self.h2_deg(),
            of(|o| o.end_error_deg * o.end_error_deg).sqrt(),
            of(|o| o.claimed2_deg2).sqrt(),
            100.0 * self.beyond(),
            self.worst_sigmas(),
            of(|o| o.nis),
        );
        println!(
            "  {} of {} end beyond 3 sigma, worst {:.1}; yields at {:.2} deg, sigma {:.2}, \
             stiffness {:.1}; leaders {:?}, least lead {:.1}",
            self.ends_beyond(3.0),
            self.runs.len(),
            self.outcomes().map(|o| o.end_sigmas).fold(0.0, f64::max),
            self.yield_deg(),
            median(self.runs.iter().map(|(_, b)| b.yield_angle_rad().unwrap().1)) / RAD_PER_DEG,
            median(self.runs.iter().map(|(_, b)| b.leading_yield().unwrap().stiffness_ratio)),
            self.leaders(),
            lead.fold(f64::INFINITY, f64::min),
        );
    }

    fn outcomes(&self) -> impl Iterator<Item = &Outcome> {
        self.runs.iter().map(|(outcome, _)| outcome)
    }

    /// RMS of the angle error over the second half, deg.
    fn h2_deg(&self) -> f64 {
        mean(self.outcomes(), |o| o.angle2_deg2).sqrt()
    }

    /// Share of the second half beyond three sigma.
    fn beyond(&self) -> f64 {
        mean(self.outcomes(), |o| o.beyond)
    }

    fn worst_sigmas(&self) -> f64 {
        self.outcomes().map(|o| o.worst_sigmas).fold(0.0, f64::max)
    }

    fn ends_beyond(&self, sigmas: f64) -> usize {
        self.outcomes().filter(|o| o.end_sigmas > sigmas).count()
    }

    fn yield_deg(&self) -> f64 {
        let of = |(_, bank): &(_, HysteresisBank)| bank.leading_yield().unwrap().yield_angle_rad;
        median(self.runs.iter().map(of)) / RAD_PER_DEG
    }

    /// How many runs each member leads at the end.
    fn leaders(&self) -> [usize; 5] {
        let mut leaders = [0; 5];
        for (_, bank) in &self.runs {
            leaders[bank.leader()] += 1;
        }
        leaders
    }

    /// What is asked of the bank where the truth is of its own kind.
    fn assert_good(&self) {
        assert!(self.h2_deg() <= 1.5, "{}", self.name);
        assert!(self.ends_beyond(3.0) * 100 <= 3 * self.runs.len(), "{}", self.name);
    }

    fn assert_finds(&self, yield_deg: f64) {
        let found = self.yield_deg() / yield_deg;
        assert!((found - 1.0).abs() < 0.05, "{}: {found}", self.name);
        for (_, bank) in &self.runs {
            assert!(bank.leader() > 0 && bank.yield_lead() > 10.0, "{}", self.name);
            let (angle_rad, sigma_rad) = bank.yield_angle_rad().unwrap();
            let off_rad = angle_rad - yield_deg * RAD_PER_DEG;
            // Six sigmas: the thread's elements of some cases are not Dahl's.
            assert!(off_rad.abs() < 6.0 * sigma_rad, "{}: {off_rad} {sigma_rad}", self.name);
        }
    }
}

#[test]
fn a_thread_that_does_not_yield_is_left_to_the_linear_filter() {
    let case = Case::of("linear", Thread::Linear);
    case.assert_good();
    assert_eq!(case.leaders(), [case.runs.len(), 0, 0, 0, 0]);
    for (_, bank) in &case.runs {
        // A false alarm shortly before the end, one in two dozen runs, is told for T/4.
        let status = bank.status();
        assert!(matches!(status, Status::Nominal | Status::Disturbed { .. }), "{status:?}");
        assert!(bank.yield_lead() < 0.0);
    }
}

#[test]
fn a_yield_angle_of_10_degrees_is_found_and_the_angle_with_it() {
    let case = Case::of("Dahl 10", Thread::Dahl(10.0));
    case.assert_good();
    case.assert_finds(10.0);
}

#[test]
fn a_yield_angle_of_25_degrees_is_found_and_the_angle_with_it() {
    let case = Case::of("Dahl 25", Thread::Dahl(25.0));
    case.assert_good();
    case.assert_finds(25.0);
    let told = |(_, bank): &(_, HysteresisBank)| match bank.status() {
        Status::ThreadYields { yield_angle_rad } => Some(yield_angle_rad / RAD_PER_DEG),
        _ => None,
    };
    let told: Vec<f64> = case.runs.iter().filter_map(told).collect();
    // A false alarm shortly before the end, one in two dozen runs, is told instead for T/4.
    assert!(told.len() * 10 >= case.runs.len() * 9, "{} of {}", told.len(), case.runs.len());
    assert!(told.iter().all(|told_deg| (told_deg - 25.0).abs() < 2.5), "{told:?}");
}

#[test]
fn a_yield_angle_of_50_degrees_is_found_and_the_angle_with_it() {
    let case = Case::of("Dahl 50", Thread::Dahl(50.0));
    case.assert_good();
    case.assert_finds(50.0);
}

/// The truth is not in the bank: six elements slip one after another, where its members have one
/// that yields smoothly. Without a noise for what their law leaves out the bank is at 50° wrong by
/// 3.8° and up to nine of its sigmas.
#[test]
fn a_thread_that_slips_is_covered_though_no_member_is_one() {
    let at_25 = Case::of("six slips 25", Thread::SixSlips(25.0));
    at_25.assert_finds(25.0);
    let at_50 = Case::of("six slips 50", Thread::SixSlips(50.0));
    at_50.assert_finds(50.0);
    for (case, h2_deg) in [(&at_25, 1.8), (&at_50, 2.8)] {
        // 1.4 and 2.4 in forty runs: a quarter more. Two of the forty at 25° end beyond three
        // sigmas, the worse one at 5.2.
        assert!(case.h2_deg() < h2_deg, "{}", case.name);
        assert!(case.beyond() < 0.02 && case.worst_sigmas() < 6.0, "{}", case.name);
        assert!(case.ends_beyond(3.0) * 20 <= case.runs.len(), "{}", case.name);
    }
}

/// The negative control: the linear filter's residuals look well, its angle is lost, and nothing
/// but the number of its alarms shows it.
#[test]
fn the_linear_filter_alone_is_lost_and_its_alarms_show_it() {
    let lost = all(runs(4), |run| tested_run(Thread::Dahl(25.0), run));
    for (_, alarms) in &lost {
        assert!(*alarms > 10, "{alarms} alarms");
    }
    let h2_deg = mean(lost.iter().map(|run| &run.0), |o| o.angle2_deg2).sqrt();
    let beyond = mean(lost.iter().map(|run| &run.0), |o| o.beyond);
    let fewest = lost.iter().map(|run| run.1).min().unwrap();
    println!("linear on Dahl 25: h2 {h2_deg:.1} deg, beyond {beyond:.2}, {fewest} alarms at least");
    assert!(h2_deg > 10.0 && beyond > 0.8, "{h2_deg} {beyond}");
}
