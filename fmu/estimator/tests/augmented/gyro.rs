//! Gyros with flaws, and what the filter makes of them when it is told, and when it is not.

use crate::campaign::Campaign;
use crate::rig::{B, Flaw, Scenario};

const RUNS: u32 = 40;

/// (told, not told) of a flaw in scenario B.
fn both(flaw: Flaw) -> (Campaign, Campaign) {
    let scenario = Scenario { flaw, ..B };
    (Campaign::of(scenario, RUNS), Campaign::of(Scenario { told: false, ..scenario }, RUNS))
}

#[test]
fn coloured_noise_is_harmless_with_the_variance_of_a_record_at_rest() {
    // First correlation 0.8/1.64 = 0.49: twice the density at zero frequency.
    let (told, not_told) = both(Flaw::Coloured(0.8));
    assert!(told.worst_sigmas() < 4.0, "{}", told.worst_sigmas());
    // No more false alarms than white noise raises, to three sigma of a count of 8 in 40 runs.
    assert!(told.alarms() < 0.42, "{} alarms a run", told.alarms());
    assert!(told.nees(9) < 5.0 + 3.0 * (10.0 / f64::from(RUNS)).sqrt(), "{}", told.nees(9));
    // Without the rule: a filter that is too sure, and alarms for nothing.
    assert!(not_told.nees(9) > 7.0, "{}", not_told.nees(9));
    assert!(not_told.alarms() > 3.0, "{} alarms a run", not_told.alarms());
}

#[test]
fn samples_near_the_limit_of_a_clipped_gyro_are_left_out() {
    // The rate peaks at 4.7 deg/s.
    let (told, not_told) = both(Flaw::Clipped(3.5));
    // 0.41° when nothing clips. To leave out what *measures* too much costs 3.1°.
    assert!(told.angle_deg() < 0.8, "{}°", told.angle_deg());
    assert!(told.alarms() < 0.42, "{} alarms a run", told.alarms());
    assert!(told.worst_sigmas() < 4.0, "{}", told.worst_sigmas());
    assert!(not_told.angle_deg() > 10.0, "{}°", not_told.angle_deg());
}

#[test]
fn a_scale_factor_is_in_the_claim_and_cannot_be_estimated_away() {
    let (told, not_told) = both(Flaw::ScaleFactor(0.01));
    // ε·angle: 2.07° published for 1 %.
    assert!((1.2..3.0).contains(&told.angle_deg()), "{}°", told.angle_deg());
    assert!(told.worst_sigmas() < 3.5, "{}", told.worst_sigmas());
    assert!(
        (told.angle_deg() / not_told.angle_deg() - 1.0).abs() < 1e-9,
        "the claim alone differs"
    );
    assert!(not_told.worst_sigmas() > 6.0, "{}", not_told.worst_sigmas());
}
