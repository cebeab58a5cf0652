//! A thread that yields: the filter of pure torsion raises alarm after alarm, and the bank speaks.

use crate::rig::{Case, Run, STEP_S, gain_of};
use struna_estimator::{RateEstimator, Status};
use struna_kernel::RAD_PER_DEG;

#[test]
fn a_thread_that_yields_is_told_and_reckoned_with() {
    let case = Case { yields_deg: Some(25.0), seconds: 480, torsion_s: 480.0, ..Case::STILL };
    let run = Run::of(&case);
    let mut live = run.estimator();
    let trace = run.trace(&mut live);
    println!("{:?}, {}°", trace.announced(), trace.rms_deg(240));
    let Some(&Status::ThreadYields { yield_angle_rad }) = trace.status.last() else {
        panic!("{:?}", trace.announced());
    };
    // Medians of 25.0° were published; the prior of the nearest member is 20° within a factor.
    assert!((yield_angle_rad / RAD_PER_DEG - 25.0).abs() < 3.0, "{yield_angle_rad} rad");
    // Until the first turning point at 240 s friction and an offset of the equilibrium are the same
    // thing: told apart when the alarms come in a row, and not before.
    let told_s = trace.first_s("yields").unwrap();
    assert!((240..280).contains(&told_s), "{told_s} s");
    // What came before is not called nominal while the bank disagrees.
    let nominal = |s: usize| trace.status[100 * s] == Status::Nominal;
    assert!(!(60..told_s).any(nominal), "{:?}", trace.announced());
    // 0.88° published for the bank's second half.
    assert!(trace.rms_deg(told_s) < 1.5, "{}°", trace.rms_deg(told_s));
    let (worst, count) = trace.worst_sigmas(|status| matches!(status, Status::ThreadYields { .. }));
    assert!(count > 20_000 && worst < 6.0, "{worst} sigmas in {count} samples");
    assert!(live.torsion().alarms() > 10, "{} alarms", live.torsion().alarms());
    // It is the bank that speaks: innovations are its own, not those of the filter that listens.
    let mut listens = live.torsion().clone();
    listens.predict(STEP_S).unwrap();
    live.predict(STEP_S).unwrap();
    let heard = listens.update(gain_of(&run) * 0.01).unwrap();
    assert_ne!(live.update(0.01).unwrap(), heard);
    assert_eq!(live.torsion().belief(), listens.belief());
    // And over range for more than a second it has nothing to say.
    for _ in 0..102 {
        live.predict(STEP_S).unwrap();
        live.update_over_range(4.0).unwrap();
    }
    assert_eq!(live.status(), Status::NotObservable);
}

#[test]
fn a_linear_thread_is_never_called_yielding_by_blows() {
    for (seed, rate_deg_s) in [(10, 3.0), (11, -1.0), (12, 0.05), (13, 0.1)] {
        let blow = Some((100.0, [0.0, 0.0, rate_deg_s]));
        let case = Case { blow, seed, seconds: 480, torsion_s: 480.0, ..Case::STILL };
        let run = Run::of(&case);
        let trace = run.trace(&mut run.estimator());
        assert_eq!(trace.first_s("yields"), None, "{:?}", trace.announced());
    }
}
