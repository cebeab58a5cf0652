//! A kick inside the window is seen, and the fit begins again behind it.

use crate::rig::{Case, Run};
use struna_estimator::{FitOutcome, Rejection};

#[test]
fn a_kick_in_the_window_is_rejected_and_a_later_window_holds() {
    for (seed, kick_s, restarts) in [(0, 33.0, 2), (1, 12.0, 1)] {
        let run = Run::of(&Case { kick_s: Some(kick_s), ..Case::new(5.0, seed, 120) });
        let mut fit = run.fit_of(&run.measured_rad_s[..6000]);
        let rejection = fit.run_to_end().unwrap_err();
        assert!(
            matches!(rejection, Rejection::Cost { .. } | Rejection::Leftover { .. }),
            "{rejection}"
        );
        assert!(matches!(fit.outcome(), FitOutcome::Pending { rejected: Some(_) }));
        for rate in &run.measured_rad_s[6000..] {
            fit.push(*rate);
        }
        let fit = fit.run_to_end().unwrap_or_else(|e| panic!("{seed}: {e}"));
        // Windows move by 20 s, and the first one that does not hold the kick is taken.
        assert_eq!(fit.restarts, restarts, "{seed}");
        let error = run.error(fit);
        assert!(error.twist_sigmas < 3.0 && error.rate_sigmas < 3.0, "{seed}: {error:?}");
    }
}
