//! What nothing can be made of is refused, with the reason.

use crate::rig::{Case, PERIOD_S, Run};
use struna_estimator::{FitOutcome, InputAxis, Progress, Rejection, SwingFit};
use struna_kernel::RAD_PER_DEG;

fn run() -> Run {
    Run::of(&Case::new(5.0, 0, 60))
}

#[test]
fn an_uncalibrated_misalignment_makes_no_claim() {
    for (tilt_deg, sigma_deg) in [(0.0, 0.1), (0.0, 0.0), (0.29, 0.1), (1.0, 0.4)] {
        let mut run = run();
        run.config.axis = InputAxis::towards(tilt_deg * RAD_PER_DEG, 1.0, sigma_deg * RAD_PER_DEG);
        let mut fit = run.fit();
        assert_eq!(fit.work(1000), Progress::Done);
        let refused = matches!(
            fit.outcome(),
            FitOutcome::Refused(Rejection::NotObservable { tilt_sigma_rad, .. })
                if tilt_sigma_rad.to_bits() == (sigma_deg * RAD_PER_DEG).to_bits()
        );
        assert!(refused, "{:?}", fit.outcome());
        assert!(matches!(fit.run_to_end(), Err(Rejection::NotObservable { .. })));
    }
}

#[test]
fn a_short_record_is_too_short() {
    let run = run();
    for (have, need) in [(0, 2432), (2431, 2432), (2600, 3000), (5999, 6000)] {
        let mut fit = run.fit_of(&run.measured_rad_s[..have]);
        let rejection = fit.run_to_end().unwrap_err();
        assert_eq!(rejection, Rejection::TooShort { have: have as u64, need });
    }
}

#[test]
fn a_record_without_numbers_is_no_record() {
    let run = run();
    for wild in [f64::NAN, f64::INFINITY, 1e300, -1e30, 1e5] {
        let mut fit = run.fit_of(&[wild; 6000]);
        assert!(fit.run_to_end().is_err(), "{wild}");
    }
    let mut some = run.measured_rad_s.clone();
    for (k, rate) in some.iter_mut().enumerate() {
        if k % 5 == 0 {
            *rate = f64::NAN;
        }
    }
    let mut fit = run.fit_of(&some);
    let rejection = fit.run_to_end().unwrap_err();
    assert!(
        matches!(rejection, Rejection::TooManyMissing { .. } | Rejection::NoMotion),
        "{rejection}"
    );
}

#[test]
fn one_wild_sample_is_rejected_and_not_believed() {
    let mut run = run();
    run.measured_rad_s[2000] = 1e9;
    let rejection = run.fit().run_to_end().unwrap_err();
    assert!(matches!(rejection, Rejection::Cost { .. } | Rejection::NoMotion), "{rejection}");
}

#[test]
fn sampling_that_cannot_follow_the_swing_is_refused() {
    let run = run();
    for period_s in [0.0, -0.01, f64::NAN, 0.06, 1e-6] {
        assert!(SwingFit::new(&run.config, period_s).is_err(), "{period_s}");
    }
    let mut config = run.config;
    config.measurement_variance_rad2_s2 = 0.0;
    assert!(SwingFit::new(&config, PERIOD_S).is_err());
}
