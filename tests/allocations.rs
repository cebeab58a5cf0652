//! From decoded bytes to estimates nothing is allocated once the chain is warm.

use std::path::Path;
use struna::scenario::{RunAs, Scenario};
use struna::session;
use struna_gyro::Gyro;
use struna_harness::clock::Resolved;
use struna_harness::live::{LineInput, LiveEvent, LiveObserver, LivePipeline};
use struna_harness::{Averager, DeviceUnderTest, Emulator, Pipeline};
use struna_kernel::{AngleEstimate, RateSample, SampleGrid, SimTime};
use struna_wire::FrameSpec;

/// Beside the demo's estimators.
const MORE: &str = "
[[estimator]]
name = \"bank\"
kind = \"hysteresis-bank\"
run_as = \"in-process\"
torsion_period_s = 480.0
measurement_sigma_deg_s = 0.0117
[[estimator]]
name = \"live\"
kind = \"live\"
run_as = \"in-process\"
torsion_period_s = 480.0
measurement_sigma_deg_s = 0.0117
[[estimator]]
name = \"alone\"
kind = \"augmented-torsion\"
run_as = \"in-process\"
torsion_period_s = 480.0
measurement_sigma_deg_s = 0.0117
";

/// 3000 gyro frames of the demo, then the pipeline fed with them: estimators in process and as FMUs
/// of both versions. An FMU's library has an allocator of its own, out of sight here; it runs the
/// code that is counted in process.
#[test]
fn no_sample_allocates_from_decoder_to_estimate() {
    let text = [include_str!("../scenarios/demo.toml"), MORE].concat();
    let mut scenario = Scenario::parse(&text, Path::new("demo.toml")).expect("the demo parses");
    let own = scenario.estimators[1..].to_vec();
    for (run_as, tag) in [(RunAs::Fmi2, "fmi2"), (RunAs::InProcess, "inside")] {
        let mut more = own.clone();
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
    let frame = scenario.frame.clone();
    let mut pipeline = Pipeline::new(frame, averager, devices).expect("a pipeline");

    let mut estimates = 0;
    let mut feed = |bytes: &[u8]| {
        pipeline
            .push(bytes, &mut |_, of_devices| estimates += of_devices.len())
            .expect("estimates");
    };
    let (warm_up, rest) = bytes.split_at(bytes.len() / 10);
    feed(warm_up);
    // Pieces that cut frames anywhere.
    let allocated = allocation_counter::measure(|| rest.chunks(17).for_each(&mut feed)).count_total;
    assert_eq!(estimates, 1000 * 19);
    assert_eq!(allocated, 0, "{allocated} allocations in 2700 samples");

    // Counted here and not in a test of its own, which would count this one's allocations.
    let devices = session::devices(&scenario.estimators, folder.path()).expect("devices");
    live_samples_allocate_nothing(scenario.frame, devices, &bytes);
}

/// Counts what comes out.
#[derive(Default)]
struct Count {
    frames: usize,
    outputs: usize,
}

impl LiveObserver for Count {
    fn input(&mut self, _time: SimTime, _input: LineInput<'_>) {}

    fn frame(&mut self, _arrival: SimTime, _resolved: &Resolved) {
        self.frames += 1;
    }

    fn output(&mut self, _sample: &RateSample, _estimates: &[AngleEstimate]) {
        self.outputs += 1;
    }

    fn event(&mut self, _time: SimTime, _event: &LiveEvent) {}
}

/// The same bytes at the times of a live line: the time base settles, fits and slides on the way.
fn live_samples_allocate_nothing(
    frame: FrameSpec,
    devices: Vec<Box<dyn DeviceUnderTest>>,
    bytes: &[u8],
) {
    let len = frame.frame_len();
    let mut pipeline = LivePipeline::new(frame, 3, SimTime::ZERO, devices).expect("a pipeline");
    let mut count = Count::default();
    let mut now_ns = 0;
    let mut feed = |bytes: &[u8], count: &mut Count| {
        for (k, frame) in bytes.chunks(len).enumerate() {
            // 100 ppm slow, with a delay that differs.
            now_ns += 3_333_667;
            let delay_ns = i64::try_from(k % 13).unwrap_or(0) * 50_000;
            let arrival = SimTime::from_ns(now_ns + delay_ns);
            pipeline.take(arrival, LineInput::Bytes(frame), count).expect("estimates");
        }
    };
    let (warm_up, rest) = bytes.split_at(10 * len);
    feed(warm_up, &mut count);
    let allocated = allocation_counter::measure(|| feed(rest, &mut count)).count_total;
    assert_eq!((count.frames, count.outputs), (3000, 1000));
    assert_eq!(allocated, 0, "{allocated} allocations in 2990 live samples");
}
