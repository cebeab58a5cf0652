//! Frames that are lost or damaged on the way, and what the estimators make of it.

use std::path::Path;
use struna::record::Record;
use struna::scenario::{EstimatorKind, RunAs, Scenario};
use struna::session;
use struna_gyro::Gyro;
use struna_harness::{Averager, Emulator, Pipeline, PipelineReport};
use struna_kernel::{AngleEstimate, RateSample, SampleGrid, SimTime};

const FRAME_BYTES: usize = 11;
const FRAMES: usize = 3000;

fn demo(run_as: &RunAs) -> Scenario {
    let text = include_str!("../scenarios/demo.toml");
    let mut scenario = Scenario::parse(text, Path::new("demo.toml")).expect("the demo parses");
    scenario.estimators.remove(0);
    for plan in &mut scenario.estimators {
        plan.run_as = run_as.clone();
        // Without insertions, so that the covariance tells of gaps alone.
        match &mut plan.kind {
            EstimatorKind::PlainIntegration(config)
            | EstimatorKind::PermanentRotation(config)
            | EstimatorKind::TorsionalOscillation { config, .. } => {
                config.refinement.samples = 0;
                config.process_noise_rad2_s3 = 1e-8;
            }
            EstimatorKind::AugmentedTorsion(config)
            | EstimatorKind::HysteresisBank(config)
            | EstimatorKind::TestedTorsion { config, .. } => config.process_noise_rad2_s3 = 1e-8,
            EstimatorKind::Live(config) => config.torsion.process_noise_rad2_s3 = 1e-8,
            EstimatorKind::ThreeAxisSwing(plan) => plan.config.rate_walk_rad2_s3 = 1e-8,
        }
    }
    scenario
}

/// Ten seconds of the demo as bytes, one frame after the other.
fn stream(scenario: &Scenario) -> Vec<u8> {
    let grid = SampleGrid::new(SimTime::ZERO, scenario.gyro.sample_rate_hz).expect("a grid");
    let gyro = Gyro::new(scenario.gyro, scenario.seed, 0).expect("a gyro");
    let source = session::motion_source(scenario).expect("a source");
    let mut emulator = Emulator::new(source, gyro, grid, &scenario.frame).expect("an emulator");
    let mut bytes = Vec::new();
    for _ in 0..FRAMES {
        emulator.emit(&mut bytes).expect("a frame");
    }
    assert_eq!(bytes.len(), FRAMES * FRAME_BYTES);
    bytes
}

type Outputs = Vec<(RateSample, Vec<AngleEstimate>)>;

fn decode(scenario: &Scenario, bytes: &[u8]) -> (Outputs, PipelineReport) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let grid = SampleGrid::new(SimTime::ZERO, scenario.gyro.sample_rate_hz).expect("a grid");
    let devices = session::devices(&scenario.estimators, folder.path()).expect("devices");
    let averager = Averager::new(grid, scenario.averaging_samples).expect("an averager");
    let mut pipeline =
        Pipeline::new(scenario.frame.clone(), averager, devices).expect("a pipeline");
    let mut outputs = Outputs::new();
    pipeline
        .push(bytes, &mut |sample, estimates| outputs.push((*sample, estimates.to_vec())))
        .expect("estimates");
    let report = pipeline.finish();
    (outputs, report)
}

/// Half a second of frames missing, from frame 1500 on.
fn with_gap(bytes: &[u8]) -> Vec<u8> {
    [&bytes[..1500 * FRAME_BYTES], &bytes[1650 * FRAME_BYTES..]].concat()
}

#[test]
fn lost_frames_widen_the_covariance_until_the_next_sample() {
    let scenario = demo(&RunAs::InProcess);
    let bytes = stream(&scenario);
    let (whole, _) = decode(&scenario, &bytes);
    let (gapped, report) = decode(&scenario, &with_gap(&bytes));
    assert_eq!(report.wire.lost, 150);
    assert_eq!(whole.len() - gapped.len(), 50);
    let after = &gapped[500];
    let same_time = &whole[550];
    assert_eq!(after.0.time, same_time.0.time, "time is the sensor's, whatever was lost");
    assert_eq!(after.0.lost_before, 150);
    for (gapped, whole) in after.1.iter().zip(&same_time.1) {
        assert!(gapped.rate_sigma_rad_s > 1.01 * whole.rate_sigma_rad_s);
    }
}

#[test]
fn a_gap_is_the_same_gap_to_an_fmu_and_in_process() {
    let bytes = stream(&demo(&RunAs::InProcess));
    let reference = decode(&demo(&RunAs::InProcess), &with_gap(&bytes)).0;
    for run_as in [RunAs::Fmi2, RunAs::Fmi3] {
        let outputs = decode(&demo(&run_as), &with_gap(&bytes)).0;
        assert!(outputs == reference, "{run_as:?} differs");
    }
}

#[test]
fn a_damaged_byte_costs_one_frame_and_nothing_else() {
    let scenario = demo(&RunAs::InProcess);
    let bytes = stream(&scenario);
    let whole = decode(&scenario, &bytes).0;
    let mut damaged = bytes.clone();
    damaged[1500 * FRAME_BYTES + 5] ^= 0x10;
    let (outputs, report) = decode(&scenario, &damaged);
    assert_eq!((report.wire.lost, report.wire.ok), (1, FRAMES as u64 - 1));
    assert_eq!(report.wire.bad_check, 1);
    assert_eq!(outputs.len(), whole.len());
    let rate_bits = |output: &(RateSample, Vec<AngleEstimate>)| output.0.rate_rad_s.to_bits();
    let thinned = outputs.iter().zip(&whole).filter(|(a, b)| rate_bits(a) != rate_bits(b));
    assert_eq!(thinned.count(), 1, "only the damaged frame's own average changes");
}

#[test]
fn the_record_counts_what_was_lost() {
    let mut record = Record::with_columns(["time", "lost_before"].map(str::to_owned));
    let scenario = demo(&RunAs::InProcess);
    for (sample, _) in decode(&scenario, &with_gap(&stream(&scenario))).0 {
        record.push(&[sample.time.as_s(), sample.lost_before as f64]);
    }
    let lost: f64 = record.column("lost_before").expect("a column").iter().sum();
    assert_eq!(lost.to_bits(), 150.0_f64.to_bits());
}
