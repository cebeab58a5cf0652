//! Recorded rates as input: saturation, flags and counts, and the real recording when it is there.

#![expect(clippy::panic, reason = "a panic fails the test")]

mod support;

use std::fs;
use std::path::{Path, PathBuf};
use struna::scenario::{Scenario, Source};
use struna::score::Score;
use struna::session::Session;
use struna_kernel::RAD_PER_DEG;
use support::run;

const SCENARIO: &str = include_str!("../scenarios/recording.toml");

fn scenario(file: &Path) -> Scenario {
    let mut scenario =
        Scenario::parse(SCENARIO, Path::new("recording.toml")).expect("the scenario parses");
    let Source::Recording(source) = &mut scenario.source else { panic!("not a recording") };
    source.file = file.to_owned();
    scenario
}

/// A turn-table: still, then 190 deg/s, then 250 deg/s for one second, then still.
fn turn_table(folder: &Path) -> PathBuf {
    let file = folder.join("turn_table.csv");
    let corners = [
        (0.0, 0.0),
        (1.0, 0.0),
        (2.0, 190.0),
        (3.0, 190.0),
        (3.5, 250.0),
        (4.5, 250.0),
        (5.0, 0.0),
        (10.0, 0.0),
    ];
    let mut text = String::from("Time (s),Gyroscope Z (deg/s)\n");
    for (time_s, rate_deg_s) in corners {
        text.push_str(&format!("{time_s},{rate_deg_s}\n"));
    }
    fs::write(&file, text).expect("a small file");
    file
}

#[test]
fn rates_beyond_the_range_saturate_are_flagged_and_counted() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut scenario = scenario(&turn_table(folder.path()));
    scenario.duration = struna_kernel::SimTime::from_s(10.0).expect("a duration");
    let Session { record, report } = run(&scenario);

    // 200 deg/s is passed 3.0833 s and 4.6 s after the start: 1.51667 s at 300 Hz. Samples are
    // means over their interval, so the two at the edges may fall either way.
    let expected = 455_u64;
    let saturated = report.emulator.saturated;
    assert!(saturated.abs_diff(expected) <= 1, "{saturated} saturated, {expected} expected");
    assert_eq!(report.pipeline.over_range, saturated);

    let measured = record.column("measured_rate_rad_s").expect("a column");
    let greatest = measured.iter().copied().fold(0.0, f64::max) / RAD_PER_DEG;
    // Clipped to +6 553 600 counts of 2^-15 deg/s, and the mean of equal samples is that sample.
    assert!((greatest - 200.0).abs() < 1e-9, "{greatest} deg/s");
    let flagged = record.column("over_range").expect("a column").iter().sum::<f64>();
    assert!((152.0..=153.0).contains(&flagged), "{flagged} averages flagged");

    // What was cut off is missing in every angle: the area above 200 deg/s.
    let above_deg = 0.5 * 50.0 * (0.5 - 0.083_333) + 50.0 + 0.5 * 50.0 * 0.1;
    let score = Score::of(&record);
    let end = score.estimators[0].angle_vs_body_rate_integral_deg.expect("an integral").end;
    // Rounding to 2^-15 deg/s over 10 s: far below a thousandth of a degree.
    assert!((end + above_deg).abs() < 1e-3, "{end} deg against {above_deg} cut off");
    assert_eq!(score.estimators[0].angle_vs_twist_deg, None, "a recording has no twist");
}

#[test]
fn a_recording_within_the_range_comes_through_to_the_last_count() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut scenario = scenario(&turn_table(folder.path()));
    // Before the range is left.
    scenario.duration = struna_kernel::SimTime::from_s(3.0).expect("a duration");
    let Session { record, report } = run(&scenario);
    assert_eq!(report.pipeline.over_range, 0);
    let score = Score::of(&record);
    let error = score.estimators[0].angle_vs_body_rate_integral_deg.expect("an integral");
    // 900 samples, each rounded by at most half of 2^-15 deg/s over 1/300 s.
    assert!(error.max_abs < 900.0 * 0.5 * 2.0_f64.powi(-15) / 300.0, "{error:?}");
}

#[test]
fn the_real_recording_runs_through_when_it_is_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let file = root.join("../shared/data/xio-imu/sensor_data.csv");
    if !file.is_file() {
        println!("no real recording at {}: nothing tested", file.display());
        return;
    }
    let Session { record, report } = run(&scenario(&file));
    assert_eq!(report.emulator.frames, 40_200);
    assert_eq!(report.pipeline.wire.ok, 40_200);
    assert_eq!(report.pipeline.over_range, report.emulator.saturated);
    assert!(report.pipeline.over_range > 0, "the recording leaves the range at 66 s");
    let score = Score::of(&record);
    println!("{score}\n{} samples over range", report.pipeline.over_range);
    for estimator in &score.estimators {
        let error = estimator.angle_vs_body_rate_integral_deg.expect("an integral");
        // Three turns of motion; the saturated stretch costs 3.7 deg and no filter may add more
        // than a few degrees to it.
        assert!(error.rms < 5.0, "{score}");
    }
}
