//! What the estimator needs is allocated when it is made, but for what a fit needs while it works.

#![expect(unsafe_code, reason = "counting allocations takes an allocator of its own")]

use crate::rig::{Case, Run, STEP_S};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use struna_estimator::{RateEstimator, Status};

/// The system's allocator, counting.
struct Counting;

thread_local! {
    /// Per thread, so that neither the test harness nor other tests disturb the count.
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: every call goes to the system's allocator unchanged; the counter is a plain thread-local
// cell that needs neither allocation nor destructor.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: `memory` is asked for as the caller asks, who keeps to alloc's contract.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: `memory` came from the system's allocator with this layout.
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn no_update_allocates_but_those_of_a_fit() {
    let case = Case { blow: Some((20.0, [30.0, 0.0, 1.0])), seconds: 130, ..Case::STILL };
    let run = Run::of(&case);
    let mut live = run.estimator();
    let mut bytes = vec![0; live.saved_len()];
    let (mut in_fits, mut elsewhere) = (0, 0);
    for rate_rad_s in &run.measured_rad_s {
        let before = ALLOCATIONS.get();
        live.predict(STEP_S).unwrap();
        live.update(*rate_rad_s).unwrap();
        let belief = (live.belief(), live.status());
        let allocated = ALLOCATIONS.get() - before;
        if matches!(belief.1, Status::Fitting { .. }) {
            in_fits += allocated;
        } else {
            elsewhere += allocated;
        }
    }
    let before = ALLOCATIONS.get();
    live.save(&mut bytes);
    assert_eq!(ALLOCATIONS.get(), before, "saving");
    assert!(matches!(live.status(), Status::Swinging { .. }), "{}", live.status());
    println!("{in_fits} allocations while fitting");
    assert_eq!(elsewhere, 0, "allocations elsewhere");
}
