//! Promises about the whole chain: motion, gyro, frames, pseudo-terminal, decoder, estimators.

mod support;

use std::path::Path;
use struna::record::Record;
use struna::scenario::{RunAs, Scenario};
use struna::score::Score;
use struna::session::{self, Drive, Session};
use struna_gyro::{ClockParams, GyroParams, datasheet};
use struna_harness::Pacing;
use struna_kernel::{Seed, SimTime};
use struna_line::StopFlag;
use support::run;

/// The demo's scenario, cut to `duration_s`.
fn demo(duration_s: f64) -> Scenario {
    let text = include_str!("../scenarios/demo.toml");
    let mut scenario = Scenario::parse(text, Path::new("demo.toml")).expect("the demo parses");
    scenario.duration = SimTime::from_s(duration_s).expect("a duration");
    scenario
}

fn csv(record: &Record) -> Vec<u8> {
    let mut bytes = Vec::new();
    record.write_csv(&mut bytes).expect("writing to memory");
    bytes
}

fn all_run_as(mut scenario: Scenario, run_as: &RunAs) -> Scenario {
    for plan in scenario.estimators.iter_mut().filter(|plan| plan.name != "integration") {
        plan.run_as = run_as.clone();
    }
    scenario
}

#[test]
fn one_seed_makes_one_record_byte_for_byte() {
    let first = csv(&run(&demo(20.0)).record);
    assert_eq!(first, csv(&run(&demo(20.0)).record));
    let mut other = demo(20.0);
    other.seed = Seed(2);
    assert_ne!(first, csv(&run(&other).record));
}

#[test]
fn the_record_does_not_depend_on_how_the_estimators_run() {
    let as_fmi3 = csv(&run(&all_run_as(demo(20.0), &RunAs::Fmi3)).record);
    let as_fmi2 = csv(&run(&all_run_as(demo(20.0), &RunAs::Fmi2)).record);
    let in_process = csv(&run(&all_run_as(demo(20.0), &RunAs::InProcess)).record);
    assert!(as_fmi3 == as_fmi2, "FMI 2.0 and FMI 3.0 disagree");
    assert!(as_fmi3 == in_process, "FMU and in-process estimates disagree");
}

#[test]
fn nothing_is_lost_on_the_virtual_line() {
    let Session { record, report } = run(&demo(60.0));
    assert_eq!(report.emulator.frames, 18_000);
    let wire = report.pipeline.wire;
    assert_eq!(wire.ok, 18_000);
    assert_eq!(wire.bytes, report.emulator.bytes);
    assert_eq!((wire.lost, wire.bad_check, wire.skipped_bytes, wire.duplicates), (0, 0, 0, 0));
    assert_eq!(record.rows(), 6_000);
    assert!(!report.interrupted);
}

#[test]
fn a_perfect_gyro_integrates_to_the_true_angle() {
    let mut scenario = demo(480.0);
    scenario.gyro = scenario.gyro.without_errors();
    let score = Score::of(&run(&scenario).record);
    let integration = &score.estimators[0];
    let error = integration.angle_vs_body_rate_integral_deg.expect("truth is known");
    // What is left is rounding of 144 000 counts of 2^-15 deg/s over 1/300 s each: a random walk
    // of LSB/sqrt(12)·sqrt(n)/300 = 1.1e-5 deg at the end; six of them.
    assert!(error.max_abs < 6.6e-5, "{error:?}");
}

/// RMS errors of angle against twist, deg, and of rate against the body's, deg/s.
fn rms(score: &Score, estimator: usize) -> (f64, f64) {
    let of = &score.estimators[estimator];
    let angle = of.angle_vs_twist_deg.expect("truth is known").rms;
    (angle, of.rate_vs_body_rate_deg_s.expect("truth is known").rms)
}

#[test]
fn estimates_are_as_good_as_white_noise_and_a_constant_bias_allow() {
    let mut scenario = demo(480.0);
    let bias_rad_s = scenario.gyro.bias_rad_s;
    scenario.gyro = GyroParams { bias_rad_s, ..datasheet::vg910d() };
    let score = Score::of(&run(&scenario).record);
    // White noise of 0.00117 deg/sqrt(s) walks to 0.026 deg in 480 s, and a bias of 3 ± 5 deg/h
    // drifts by up to 1.7 deg at two sigma; this seed draws a small one. No 2008 filter can do
    // better in angle than the integral it copies.
    for k in 0..3 {
        assert!(rms(&score, k).0 < 0.1, "{score}");
    }
    // Averaging 300 Hz samples of 0.0203 deg/s by three leaves 0.0117 deg/s; both filters smooth.
    assert!((rms(&score, 0).1 / 0.0117 - 1.0).abs() < 0.03, "{score}");
    assert!(rms(&score, 2).1 < 0.3 * rms(&score, 0).1, "{score}");
}

#[test]
fn the_demo_estimates_stay_within_the_budget_of_its_gyro() {
    let score = Score::of(&run(&demo(480.0)).record);
    // Over 480 s and the 690 deg between the two ends of the swing, at one sigma: scale factor
    // 0.2 % or 1.38 deg, turn-on bias 5 deg/h or 0.67, bias instability and random walk 0.4,
    // clock 0.03; and for certain, bias 3 deg/h or 0.40 and warm-up 10 deg/h times 120 s or 0.33.
    let budget_deg = 3.0 * 1.38_f64.hypot(0.67).hypot(0.4) + 0.40 + 0.33;
    for k in 0..3 {
        assert!(rms(&score, k).0 < budget_deg, "{score}");
        // All three copy the same integral: none is much better in angle, none worse.
        assert!((rms(&score, k).0 - rms(&score, 0).0).abs() < 0.1, "{score}");
    }
    // White noise, and what is systematic in a rate of 3.3 deg/s RMS: three sigma of its scale.
    let worst_deg_s = 0.0117_f64.hypot(3.0 * 0.002 * 3.3) + 0.005;
    assert!((0.0117..worst_deg_s).contains(&rms(&score, 0).1), "{score}");
}

#[test]
fn a_fast_clock_shows_as_angle_and_the_truth_is_that_of_the_samples() {
    let mut scenario = demo(60.0);
    let clock = ClockParams { offset: 0.02, ..ClockParams::default() };
    scenario.gyro = GyroParams { clock, ..scenario.gyro.without_errors() };
    let record = run(&scenario).record;
    let column = |name: &str| record.column(name).expect("a column of every record");
    let (angle, spin) = (column("integration.angle_rad"), column("truth.body_rate_integral_rad"));
    assert_eq!(record.rows(), 6_000);
    for k in [2_999, 5_999] {
        // Each sample is taken for 2 % longer than it was.
        let (believed, turned) = (angle[k] - angle[0], spin[k] - spin[0]);
        // Rounding to counts walks to some 1e-7 rad.
        assert!((believed - 1.02 * turned).abs() < 1e-6, "{believed} {turned}");
    }
}

#[test]
fn a_run_that_is_stopped_keeps_what_it_has() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let stop = StopFlag::new();
    let mut stop_after_ten_seconds = |time: SimTime| {
        if time >= SimTime::from_ns(10_000_000_000) {
            stop.stop();
        }
    };
    let drive = Drive {
        fmu_folder: folder.path(),
        pacing: Pacing::AsFastAsPossible,
        stop: &stop,
        progress: &mut stop_after_ten_seconds,
    };
    let Session { record, report } =
        session::run(&demo(480.0), drive).expect("a stopped run is no failure");
    assert!(report.interrupted);
    // Everything that was sent was also received, decoded and recorded.
    assert_eq!(report.pipeline.wire.ok, report.emulator.frames);
    assert_eq!(record.rows() as u64, report.emulator.frames / 3);
    assert!(record.rows() >= 1000 && record.rows() < 48_000, "{} rows", record.rows());
    // And it is the start of the whole run, not another one.
    let whole = csv(&run(&demo(20.0)).record);
    let part = csv(&record);
    let shorter = whole.len().min(part.len());
    assert_eq!(whole[..shorter], part[..shorter]);
}
