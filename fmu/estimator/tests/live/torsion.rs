//! No swing: the estimator is the tested filter of pure torsion, bit for bit.

use crate::rig::{Case, Run, STEP_S};
use struna_estimator::{InnovationTest, RateEstimator, Status, TestedFilter};

/// Runs both side by side and compares every belief and every innovation.
fn agrees_throughout(case: &Case) -> Vec<Status> {
    let run = Run::of(case);
    let mut live = run.estimator();
    let mut tested = TestedFilter::new(&run.config.torsion, &InnovationTest::STANDARD).unwrap();
    let mut shown = Vec::new();
    for rate_rad_s in &run.measured_rad_s {
        live.predict(STEP_S).unwrap();
        tested.predict(STEP_S).unwrap();
        assert_eq!(live.belief(), tested.belief());
        assert_eq!(live.update(*rate_rad_s).unwrap(), tested.update(*rate_rad_s).unwrap());
        assert_eq!(live.belief(), tested.belief());
        shown.push(live.status());
    }
    shown
}

#[test]
fn without_swing_it_is_the_tested_filter_bit_for_bit() {
    let shown = agrees_throughout(&Case { seconds: 240, seed: 2, ..Case::STILL });
    let loud = shown.iter().position(|status| *status != Status::Nominal);
    assert_eq!(loud.map(|k| (k, shown[k])), None, "a quiet run");
}

#[test]
fn a_body_that_rests_is_nominal() {
    // Five seconds of decay: after 200 s it hangs still.
    let case = Case { torsion_s: 40.0, decay_1_s: 0.05, seconds: 200, ..Case::STILL };
    let shown = agrees_throughout(&case);
    assert_eq!(shown.last(), Some(&Status::Nominal));
}

#[test]
fn a_blow_about_the_thread_is_a_disturbance_and_no_swing() {
    for rate_deg_s in [0.05_f64, 0.1, 0.2, -1.0, 5.0] {
        let case = Case { blow: Some((60.0, [0.0, 0.0, rate_deg_s])), ..Case::STILL };
        let shown = agrees_throughout(&case);
        let struck = shown.iter().position(|status| *status != Status::Nominal).unwrap();
        assert!((6_000..6_200).contains(&struck), "{struck}");
        assert!(matches!(shown[struck], Status::Disturbed { .. }), "{:?}", shown[struck]);
        // A quarter of a period later. A thread that yields would explain a small blow as well;
        // the bank that reckons with one tests for blows itself.
        assert_eq!(shown[100 * 105], Status::Nominal, "{rate_deg_s} °/s");
    }
}
