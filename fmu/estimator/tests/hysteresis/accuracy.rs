//! How far the angle is off, and whether the claim covers it.

use crate::campaign::{Outcome, all, bank_run, mean, median, runs, tested_run};
use crate::rig::Thread;
use struna_estimator::HysteresisBank;
use struna_kernel::RAD_PER_DEG;

/// Figures of a case, and what is printed of them.
struct Case {
    runs: Vec<(Outcome, HysteresisBank)>,
}

impl Case {
    fn of(name: &str, thread: Thread, runs: u32) -> Self {
        let case = Self { runs: all(runs, |run| bank_run(thread, run)) };
        let (ends, worst) = (case.ends_beyond(3.0), case.worst_at_end());
        let outcomes = || case.runs.iter().map(|(outcome, _)| outcome);
        println!(
            "{name}: h2 {:.2} deg, end {:.2}, claimed {:.2}, beyond 3 sigma {:.2} %, worst {:.1}; \
             ends beyond 3 sigma {ends} of {}, worst {worst:.1}; NIS {:.3}; yields {:.2} deg, \
             sigma {:.2}; stiffness {:.1}; leader {:?}; lead {:.0} to {:.0}",
            case.h2_deg(),
            mean(outcomes(), |o| o.end_error_deg.powi(2)).sqrt(),
            mean(outcomes(), |o| o.claimed2_deg2).sqrt(),
            100.0 * mean(outcomes(), |o| o.beyond),
            outcomes().map(|o| o.worst_sigmas).fold(0.0, f64::max),
            case.runs.len(),
            mean(outcomes(), |o| o.nis),
            case.yield_deg(),
            median(case.runs.iter().map(|(_, b)| b.yield_angle_rad().unwrap().1 / RAD_PER_DEG)),
            median(case.runs.iter().map(|(_, b)| b.leading_yield().unwrap().stiffness_ratio)),
            case.leaders(),
            case.runs.iter().map(|(_, b)| b.yield_lead()).fold(f64::INFINITY, f64::min),
            case.runs.iter().map(|(_, b)| b.yield_lead()).fold(f64::NEG_INFINITY, f64::max),
        );
        case
    }

    fn h2_deg(&self) -> f64 {
        mean(self.runs.iter().map(|(outcome, _)| outcome), |o| o.angle2_deg2).sqrt()
    }

    fn ends_beyond(&self, sigmas: f64) -> usize {
        self.runs.iter().filter(|(outcome, _)| outcome.end_sigmas > sigmas).count()
    }

    fn worst_at_end(&self) -> f64 {
        self.runs.iter().map(|(outcome, _)| outcome.end_sigmas).fold(0.0, f64::max)
    }

    fn yield_deg(&self) -> f64 {
        median(self.runs.iter().map(|(_, b)| b.leading_yield().unwrap().yield_angle_rad))
            / RAD_PER_DEG
    }

    /// How many runs each member leads at the end.
    fn leaders(&self) -> [usize; 5] {
        let mut leaders = [0; 5];
        for (_, bank) in &self.runs {
            leaders[bank.leader()] += 1;
        }
        leaders
    }
}

#[test]
fn survey() {
    let n = runs(8);
    Case::of("linear", Thread::Linear, n);
    for y in [10.0, 25.0, 50.0] {
        Case::of(&format!("Dahl {y}"), Thread::Dahl(y), n);
    }
    for y in [25.0, 50.0] {
        Case::of(&format!("six slips {y}"), Thread::SixSlips(y), n);
    }
    for y in [0.0, 25.0] {
        let thread = if y > 0.0 { Thread::Dahl(y) } else { Thread::Linear };
        let out = all(n, |run| tested_run(thread, run));
        let h2 = mean(out.iter().map(|o| &o.0), |o| o.angle2_deg2).sqrt();
        let fewest = out.iter().map(|o| o.1).min().unwrap();
        println!("tested on {y}: h2 {h2:.2}, fewest alarms {fewest}");
    }
}
