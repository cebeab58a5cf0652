//! A thread that yields: the filter of pure torsion raises alarm after alarm, and the bank speaks.

use crate::rig::{Case, Run};
use struna_estimator::Status;
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
    // 0.88° published for the second half, worst of forty not given; pure torsion is off by 20°.
    assert!(trace.rms_deg(240) < 2.0, "{}°", trace.rms_deg(240));
    let (worst, count) = trace.worst_sigmas(|status| matches!(status, Status::ThreadYields { .. }));
    assert!(count > 24_000 && worst < 6.0, "{worst} sigmas in {count} samples");
    assert!(live.torsion().alarms() > 10, "{} alarms", live.torsion().alarms());
}

#[test]
fn a_linear_thread_is_never_called_yielding_by_blows() {
    for seed in 10..14 {
        let blow = Some((100.0, [0.0, 0.0, if seed % 2 == 0 { 3.0 } else { -1.0 }]));
        let case = Case { blow, seed, seconds: 480, torsion_s: 480.0, ..Case::STILL };
        let run = Run::of(&case);
        let trace = run.trace(&mut run.estimator());
        assert_eq!(trace.first_s("yields"), None, "{:?}", trace.announced());
        assert_eq!(trace.status.last(), Some(&Status::Nominal));
    }
}
