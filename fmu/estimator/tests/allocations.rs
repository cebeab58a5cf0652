//! Once they are made, the filters with innovation test allocate nothing: not in a step, not in an
//! alarm with its roll-back, not when they are saved.

#![expect(unsafe_code, reason = "counting allocations takes an allocator of its own")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use struna_estimator::{
    AugmentedConfig, InnovationTest, InputAxis, RateEstimator, SWING_STATES, StartPrior,
    SwingBelief, SwingBody, SwingConfig, SwingFilter, TestedFilter, ThreeAxisFilter,
};

/// The system's allocator, counting.
struct Counting;

thread_local! {
    /// Per thread, so that the test harness's own threads do not disturb the count.
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
fn no_step_and_no_roll_back_allocates() {
    let start = StartPrior::released(6.0, 480.0);
    let config = AugmentedConfig::quiet(start, 6e-7);
    let mut filter = TestedFilter::new(&config, &InnovationTest::STANDARD).expect("a filter");
    let mut bytes = vec![0; filter.saved_len()];
    let before = ALLOCATIONS.get();
    for k in 1..=20_000_u32 {
        let time_s = f64::from(k) * 0.01;
        // A blow of 0.05 rad/s after 100 s.
        let blow_rad_s = if k > 10_000 { 0.05 } else { 0.0 };
        let rate_rad_s = -0.0785 * (0.01309 * time_s).sin() + blow_rad_s;
        filter.step(0.01, rate_rad_s).expect("a step");
    }
    filter.save(&mut bytes);
    let allocated = ALLOCATIONS.get() - before;
    assert!(filter.alarms() > 0, "the blow raised an alarm");
    assert_eq!(allocated, 0, "{allocated} allocations");
}

#[test]
fn no_step_and_no_roll_back_of_a_swinging_body_allocates() {
    let body = SwingBody {
        mass_kg: 1.0,
        com_depth_m: 0.1,
        inertia_kg_m2: [0.0100, 0.0105, 0.0100],
        gravity_m_s2: 9.81,
        swing_damping_1_s: 2e-3,
    };
    let axis = InputAxis::towards(0.017, 0.7, 1.7e-3);
    let start = StartPrior::released(6.0, 120.0);
    let config = SwingConfig::quiet(body, axis, start, 6e-7);
    let mean = [0.0, 0.0, 6.0, 0.0, 0.0, 0.0, 2.7e-3, 6e-3, 1.0, 1.0, 1.0, 0.0, 0.013, 0.011];
    let belief = SwingBelief::independent(mean, [1e-3; SWING_STATES]);
    let mut one = SwingFilter::new(&config, &InnovationTest::STANDARD, &belief)
        .expect("a filter of one axis");
    let mut three = ThreeAxisFilter::new(&config, 0.1).expect("a filter of three axes");
    let mut bytes = vec![0; one.saved_len()];
    let before = ALLOCATIONS.get();
    for k in 1..=3_000_u32 {
        // A blow after 20 s.
        let rate_rad_s = if k > 2_000 { 0.05 } else { 0.0 };
        one.step(0.01, rate_rad_s).expect("a step");
        three.step(0.01, [0.0, 0.0, rate_rad_s]).expect("a step");
    }
    one.save(&mut bytes);
    one.restart(&belief).expect("a restart");
    let allocated = ALLOCATIONS.get() - before;
    assert_eq!(allocated, 0, "{allocated} allocations");
    one.restore(&bytes).expect("its own bytes");
    assert!(one.alarms() > 0, "the blow raised an alarm");
}
