//! An accepted fit holds the truth.

use crate::rig::{Case, PERIOD_S, Run};
use struna_kernel::RAD_PER_DEG;

#[test]
fn accepted_fits_hold_the_truth_at_every_size_of_swing() {
    for swing_deg in [0.0, 1.0, 3.0, 5.0, 10.0, 15.0] {
        for seed in 0..4 {
            let run = Run::of(&Case::new(swing_deg, seed, 60));
            let mut fit = run.fit();
            let fit = fit.run_to_end().unwrap_or_else(|e| panic!("{swing_deg}°, {seed}: {e}"));
            let error = run.error(fit);
            // 24 fits; the claim holds within 3 sigma in all but 1 of 370 for each of the two.
            assert!(error.twist_sigmas < 3.0, "{swing_deg}°, {seed}: {error:?}");
            assert!(error.rate_sigmas < 3.0, "{swing_deg}°, {seed}: {error:?}");
            // The mean square of 6000 samples lies within 5.5 % of R, 3 sigma, and the fit takes
            // fourteen of them.
            assert!((fit.cost_per_sample - 1.0).abs() < 0.06, "{}", fit.cost_per_sample);
            assert_eq!((fit.samples, fit.modes), (6000, 1));
        }
    }
}

#[test]
fn the_swing_is_as_large_as_it_is() {
    for (swing_deg, seed) in [(3.0, 5), (10.0, 5)] {
        let case = Case { ratio: Some(0.2), ..Case::new(swing_deg, seed, 60) };
        let run = Run::of(&case);
        let mut fit = run.fit();
        let amplitude_deg = fit.run_to_end().unwrap().amplitude_rad / RAD_PER_DEG;
        // Two modes that beat make at most √(1 + 0.2²) of the larger axis, to 2 % of the moments.
        let ratio = amplitude_deg / swing_deg;
        assert!((0.98..1.04).contains(&ratio), "{amplitude_deg} of {swing_deg}");
    }
}

#[test]
fn a_quarter_of_a_long_period_is_waited_for() {
    let run = Run::of(&Case { torsion_s: 480.0, ..Case::new(5.0, 1, 125) });
    let mut fit = run.fit();
    let fit = fit.run_to_end().unwrap();
    // Of the period as it is believed.
    let quarter_s = 0.25 * run.config.start.period_s;
    assert!((fit.samples as f64 * PERIOD_S - quarter_s).abs() <= PERIOD_S, "{}", fit.samples);
    let error = run.error(fit);
    assert!(error.twist_sigmas < 3.0 && error.rate_sigmas < 3.0, "{error:?}");
}

#[test]
fn missing_samples_are_missed_and_no_more() {
    let mut run = Run::of(&Case::new(5.0, 2, 60));
    for (k, rate) in run.measured_rad_s.iter_mut().enumerate() {
        if k % 50 < 2 {
            *rate = f64::NAN;
        }
    }
    let mut fit = run.fit();
    let fit = fit.run_to_end().unwrap();
    let error = run.error(fit);
    assert!(error.twist_sigmas < 3.0 && error.rate_sigmas < 3.0, "{error:?}");
}
