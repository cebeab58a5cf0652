//! From decoded bytes to estimates nothing is allocated once the chain is warm.

#![expect(unsafe_code, reason = "counting allocations takes an allocator of its own")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use struna::scenario::{RunAs, Scenario};
use struna::session;
use struna_gyro::Gyro;
use struna_harness::{Averager, Emulator, Pipeline};
use struna_kernel::{SampleGrid, SimTime};

/// The system's allocator, counting.
struct Counting;

static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);

// SAFETY: every call goes to the system's allocator unchanged; counting touches no memory of it.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller keeps to alloc's contract, which is the system's.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: `memory` came from the system's allocator with this layout.
        unsafe { System.dealloc(memory, layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: `memory` came from the system's allocator with this layout.
        unsafe { System.realloc(memory, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// 3000 gyro frames of the demo, then the pipeline fed with them: estimators in process and as FMUs
/// of both versions. An FMU's library has an allocator of its own, out of sight here; it runs the
/// code that is counted in process.
#[test]
fn no_sample_allocates_from_decoder_to_estimate() {
    let text = include_str!("../scenarios/demo.toml");
    let mut scenario = Scenario::parse(text, Path::new("demo.toml")).expect("the demo parses");
    for (run_as, tag) in [(RunAs::Fmi2, "fmi2"), (RunAs::InProcess, "inside")] {
        let mut more = scenario.estimators[1..3].to_vec();
        for plan in &mut more {
            plan.name = format!("{}-{tag}", plan.name);
            plan.run_as = run_as.clone();
        }
        scenario.estimators.extend(more);
    }
    let grid = SampleGrid::new(SimTime::ZERO, scenario.gyro.sample_rate_hz).expect("a grid");
    let gyro = Gyro::new(scenario.gyro, scenario.seed, 0).expect("a gyro");
    let source = session::motion_source(&scenario).expect("a source");
    let mut emulator = Emulator::new(source, gyro, grid, &scenario.frame).expect("an emulator");
    let mut bytes = Vec::new();
    for _ in 0..3000 {
        emulator.emit(&mut bytes).expect("a frame");
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let devices = session::devices(&scenario.estimators, folder.path()).expect("devices");
    let averager = Averager::new(grid, scenario.averaging_samples).expect("an averager");
    let mut pipeline = Pipeline::new(scenario.frame, averager, devices).expect("a pipeline");

    let mut estimates = 0;
    let mut feed = |bytes: &[u8]| {
        pipeline
            .push(bytes, &mut |_, of_devices| estimates += of_devices.len())
            .expect("estimates");
    };
    let (warm_up, rest) = bytes.split_at(bytes.len() / 10);
    feed(warm_up);
    let before = ALLOCATIONS.load(Ordering::Relaxed);
    // Pieces that cut frames anywhere.
    for piece in rest.chunks(17) {
        feed(piece);
    }
    let allocated = ALLOCATIONS.load(Ordering::Relaxed) - before;
    assert_eq!(estimates, 1000 * 7);
    assert_eq!(allocated, 0, "{allocated} allocations in 2700 samples");
}
