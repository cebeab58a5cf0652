//! Negative controls: a fit without one of its parts fails, and says so.

use crate::rig::{Case, Run};
use struna_estimator::{FitStarts, Rejection};

/// How many of the fits are rejected. One that is accepted must hold the truth.
fn rejected(swing_deg: f64, seeds: u64, starts: FitStarts) -> usize {
    let mut rejected = 0;
    for seed in 0..seeds {
        let run = Run::of(&Case::new(swing_deg, seed, 60));
        let mut fit = run.fit().with_starts(starts);
        match fit.run_to_end() {
            Ok(fit) => {
                let error = run.error(fit);
                assert!(error.twist_sigmas < 3.0, "silent: {swing_deg}°, {seed}: {error:?}");
            }
            Err(_) => rejected += 1,
        }
    }
    rejected
}

#[test]
fn one_start_finds_the_wrong_valley_and_says_so() {
    // With all starts none of these is rejected.
    assert!(rejected(15.0, 6, FitStarts::Single) >= 2);
    assert_eq!(rejected(15.0, 6, FitStarts::All), 0);
}

#[test]
fn a_decay_that_is_not_fitted_is_seen_when_it_is_wrong() {
    for seed in 0..2 {
        let mut run = Run::of(&Case { decay_scale: 1.5, ..Case::new(10.0, seed, 60) });
        let mut fit = run.fit();
        let error = run.error(fit.run_to_end().unwrap());
        assert!(error.twist_sigmas < 3.0, "{seed}: {error:?}");
        run.config.swing_damping_sigma = 0.0;
        let rejection = run.fit().run_to_end().unwrap_err();
        assert!(matches!(rejection, Rejection::Cost { .. }), "{seed}: {rejection}");
    }
}
