//! What the estimator needs is allocated when it is made, through all of a swing.

use crate::rig::{Case, Run, STEP_S, name};
use struna_estimator::{LiveEstimator, RateEstimator, Status};

/// Allocations of a call.
fn allocations_of<T>(call: impl FnOnce() -> T) -> (u64, T) {
    let mut answer = None;
    let made = allocation_counter::measure(|| answer = Some(call()));
    (made.count_total, answer.unwrap())
}

/// Takes samples in, and gives the allocations and what was shown after each.
fn taken(live: &mut LiveEstimator, rates_rad_s: &[f64]) -> (u64, Vec<Status>) {
    let mut shown = Vec::with_capacity(rates_rad_s.len());
    let (allocated, ()) = allocations_of(|| {
        for (k, rate_rad_s) in rates_rad_s.iter().enumerate() {
            live.predict(STEP_S).unwrap();
            if k % 1_000 == 999 {
                live.update_over_range(*rate_rad_s).unwrap();
            } else {
                live.update(*rate_rad_s).unwrap();
            }
            assert!(live.belief().angle_rad.is_finite());
            shown.push(live.status());
        }
    });
    (allocated, shown)
}

fn names(shown: &[Status]) -> Vec<&'static str> {
    let mut names: Vec<_> = shown.iter().map(name).collect();
    names.dedup();
    names
}

/// Seconds that a fit says it has collected, where one is under way.
fn collected_s(status: &Status) -> Option<f64> {
    match status {
        Status::Fitting { collected_s, .. } => Some(*collected_s),
        _ => None,
    }
}

#[test]
fn no_update_allocates_from_rest_through_a_blow_to_the_filter_of_the_swing() {
    let case = Case { blow: Some((20.0, [30.0, 0.0, 1.0])), seconds: 130, ..Case::STILL };
    let run = Run::of(&case);
    let mut live = run.estimator();
    let (allocated, shown) = taken(&mut live, &run.measured_rad_s);
    let names = names(&shown);
    assert!(names.starts_with(&["nominal"]) && names.contains(&"fitting"), "{names:?}");
    assert_eq!(names.last(), Some(&"swinging"), "{names:?}");
    assert_eq!(allocated, 0, "allocations");
    let mut bytes = vec![0; live.saved_len()];
    assert_eq!(allocations_of(|| live.save(&mut bytes)).0, 0, "saving");
    // A clone has memory of its own. A gap that the filter of the swing cannot follow brings the
    // fallback back, and a fit.
    let mut clone = live.clone();
    let (allocated, ()) = allocations_of(|| clone.predict(1e5).unwrap());
    assert_eq!((allocated, name(&clone.status())), (0, "fitting"), "falling back");
    let (allocated, shown) = taken(&mut clone, &run.measured_rad_s[..8_000]);
    assert!(shown.iter().any(|status| name(status) == "fitting"));
    assert_eq!(allocated, 0, "after falling back");
}

#[test]
fn no_update_allocates_while_a_fit_is_retried_and_begun_again_nor_when_the_swing_has_died() {
    // A kick in the window: its fit fails, the denser one too, and a later window is taken.
    let blow = Some((12.0, [0.5, 0.5, 0.5]));
    let case = Case { swing_deg: 1.5, ratio: 0.2, decay_1_s: 0.014, blow, ..Case::STILL };
    let run = Run::of(&Case { seconds: 230, seed: 1, ..case });
    let mut live = run.estimator();
    let (allocated, shown) = taken(&mut live, &run.measured_rad_s);
    assert_eq!(allocated, 0, "allocations in {:?}", names(&shown));
    let collected: Vec<f64> = shown.iter().filter_map(collected_s).collect();
    let is_begun_again = collected.windows(2).any(|pair| pair[1] < pair[0]);
    assert!(is_begun_again, "the kick spoilt no window: {:?}", names(&shown));
    let names = names(&shown);
    assert!(names.contains(&"swinging") && names.last() == Some(&"nominal"), "{names:?}");
}

#[test]
fn no_update_allocates_while_the_thread_yields() {
    let case = Case { yields_deg: Some(25.0), torsion_s: 120.0, seconds: 240, ..Case::STILL };
    let run = Run::of(&case);
    let mut live = run.estimator();
    let (allocated, _) = taken(&mut live, &run.measured_rad_s);
    assert!(live.torsion().alarms() > 0, "a thread that yields raises alarms");
    assert_eq!(allocated, 0, "allocations");
}
