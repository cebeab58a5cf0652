//! The estimators that learn: what a scenario tells them, in which units, and what it leaves out.

#![expect(clippy::float_cmp, reason = "numbers that need no conversion arrive as written")]

use crate::{DEMO, refusal};
use std::path::Path;
use struna::scenario::{EstimatorKind, Scenario};
use struna_estimator::{AugmentedConfig, InnovationTest, LiveConfig, StartPrior};
use struna_kernel::RAD_PER_DEG;

/// The demo without its estimators, and one with these lines instead.
fn with_estimator(lines: &str) -> String {
    let (head, _) = DEMO.split_once("# Angle by summing").expect("the demo's first estimator");
    format!("{head}[[estimator]]\nname = \"x\"\nrun_as = \"in-process\"\n{lines}\n")
}

fn kind_of(lines: &str) -> EstimatorKind {
    let text = with_estimator(lines);
    let scenario = Scenario::parse(&text, Path::new("x.toml")).unwrap_or_else(|e| panic!("{e}"));
    scenario.estimators[0].kind.clone()
}

const LEAST: &str = "torsion_period_s = 480.0\nmeasurement_sigma_deg_s = 0.01";

fn tested(lines: &str) -> (AugmentedConfig, InnovationTest) {
    match kind_of(&format!("kind = \"tested-torsion\"\n{LEAST}\n{lines}")) {
        EstimatorKind::TestedTorsion { config, test } => (config, test),
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_is_left_out_is_a_release_in_a_quiet_laboratory() {
    let sigma_rad_s = 0.01 * RAD_PER_DEG;
    let usual = AugmentedConfig::quiet(StartPrior::released(0.0, 480.0), sigma_rad_s * sigma_rad_s);
    assert_eq!(tested(""), (usual, InnovationTest::STANDARD));
    let alone = kind_of(&format!("kind = \"augmented-torsion\"\n{LEAST}"));
    assert_eq!(alone, EstimatorKind::AugmentedTorsion(usual));
}

#[test]
fn every_key_arrives_in_si() {
    let (config, test) = tested(
        "angle_start_deg = 360.0\nangle_sigma_start_deg = 2.0\nrate_start_deg_s = -1.0\n\
         rate_sigma_start_deg_s = 0.5\ntorsion_period_sigma_s = 3.0\ndamping_ratio = 0.02\n\
         damping_ratio_sigma = 0.004\nbias_deg_h = -7.2\nbias_sigma_deg_h = 36.0\n\
         process_noise_deg2_s3 = 1e-4\nbias_walk_deg2_s3 = 1e-10\n\
         scale_factor_sigma_percent = 0.2\ngyro_range_deg_s = 3.5\n\
         gyro_range_margin_deg_s = 0.1\ntest_false_alarms = 0.05\n\
         test_horizon_samples = 4096\ntest_kick_floor_deg_s = 0.03",
    );
    let start = config.start;
    let range = config.range.expect("it was given");
    let deg2 = RAD_PER_DEG * RAD_PER_DEG;
    for (si, expected) in [
        (start.angle_rad, 360.0 * RAD_PER_DEG),
        (start.angle_sigma_rad, 2.0 * RAD_PER_DEG),
        (start.rate_rad_s, -RAD_PER_DEG),
        (start.rate_sigma_rad_s, 0.5 * RAD_PER_DEG),
        (start.period_s, 480.0),
        (start.period_sigma_s, 3.0),
        (start.damping_ratio, 0.02),
        (start.damping_ratio_sigma, 0.004),
        (start.bias_rad_s, -0.002 * RAD_PER_DEG),
        (start.bias_sigma_rad_s, 0.01 * RAD_PER_DEG),
        (config.measurement_variance_rad2_s2, 1e-4 * deg2),
        (config.process_noise_rad2_s3, 1e-4 * deg2),
        (config.bias_walk_rad2_s3, 1e-10 * deg2),
        (config.scale_factor_sigma, 0.002),
        (range.limit_rad_s, 3.5 * RAD_PER_DEG),
        (range.margin_rad_s, 0.1 * RAD_PER_DEG),
        (test.false_alarms, 0.05),
        (test.kick_floor_rad_s, 0.03 * RAD_PER_DEG),
    ] {
        // A product or two: a few last bits.
        assert!((si / expected - 1.0).abs() < 1e-14, "{si} for {expected}");
    }
    assert_eq!(test.horizon_samples, 4096);
}

#[test]
fn a_range_without_a_margin_keeps_five_deviations_of_a_raw_sample_clear() {
    let range = tested("gyro_range_deg_s = 200.0").0.range.expect("it was given");
    // The demo averages three samples.
    let expected_rad_s = 5.0 * 0.01 * RAD_PER_DEG * 3.0_f64.sqrt();
    assert!((range.margin_rad_s / expected_rad_s - 1.0).abs() < 1e-14);
}

#[test]
fn keys_that_a_kind_does_not_read_are_refused_with_the_kinds_that_do() {
    let least_of_2008 = "angle_sigma_start_deg = 1.0\nrate_sigma_start_deg_s = 1.0\n\
                         measurement_sigma_deg_s = 0.01";
    for (kind, key, readers) in [
        ("permanent-rotation", "torsion_period_s", "\"torsional-oscillation\", \"augmented-"),
        ("plain-integration", "bias_deg_h", "\"augmented-torsion\", \"tested-torsion\""),
        ("torsional-oscillation", "damping_ratio", "\"augmented-torsion\", \"tested-torsion\""),
        ("torsional-oscillation", "gyro_range_deg_s", "\"augmented-torsion\""),
        ("augmented-torsion", "test_false_alarms", "but \"tested-torsion\", \"live\""),
        ("augmented-torsion", "refinement_samples", "\"plain-integration\", \"permanent-"),
        ("tested-torsion", "refinement_reading", "\"torsional-oscillation\""),
    ] {
        let lines = format!("kind = \"{kind}\"\n{least_of_2008}\n{key} = 0.125");
        let said = refusal(&with_estimator(&lines));
        let place = format!("`estimator[0].{key}` = 0.125");
        for part in ["folder/x.toml, line ", &place, "does not read it", readers, "remove it"] {
            assert!(said.contains(part), "{part:?} not in: {said}");
        }
    }
}

#[test]
fn values_out_of_their_range_are_refused_by_key_and_value() {
    for (line, remedy) in [
        ("torsion_period_sigma_s = -1.0", "0 or a greater"),
        ("damping_ratio = -0.1", "0 or a greater"),
        ("bias_sigma_deg_h = -1", "0 or a greater"),
        ("bias_deg_h = nan", "finite"),
        ("scale_factor_sigma_percent = -0.2", "0 or a greater"),
        ("gyro_range_deg_s = 0.0", "greater than 0"),
        ("gyro_range_margin_deg_s = 1.0", "add that, or remove this"),
        ("test_false_alarms = 1.0", "less than 1"),
        ("test_false_alarms = 0.0", "greater than 0"),
        ("test_horizon_samples = 2047", "2048 to"),
        ("test_kick_floor_deg_s = -0.1", "0 or a greater"),
    ] {
        let lines = format!("kind = \"tested-torsion\"\n{LEAST}\n{line}");
        let said = refusal(&with_estimator(&lines));
        let (key, value) = line.split_once(" = ").expect("a line has a key");
        let place = format!("`estimator[0].{key}` = {value}");
        assert!(said.contains(&place) && said.contains(remedy), "{line}: {said}");
    }
    let margin = "gyro_range_deg_s = 3.0\ngyro_range_margin_deg_s = 3.0";
    let lines = format!("kind = \"tested-torsion\"\n{LEAST}\n{margin}");
    let said = refusal(&with_estimator(&lines));
    assert!(said.contains("gyro_range_margin_deg_s` = 3.0") && said.contains("lower it"), "{said}");
    // Beyond what the filter itself can square.
    let lines = "kind = \"tested-torsion\"\ntorsion_period_s = 1e13\nmeasurement_sigma_deg_s = 1.0";
    let said = refusal(&with_estimator(lines));
    assert!(said.contains("`estimator[0]`") && said.contains("from 1e-6 to 1e12 s"), "{said}");
}

const BODY: &str = "body_mass_kg = 1.5\nbody_com_depth_m = 0.2\n\
                    body_inertia_kg_m2 = [0.02, 0.03, 0.04]\nbody_swing_damping_1_s = 0.01\n\
                    input_axis_deg = [1.0, -0.5]\ninput_axis_sigma_deg = 0.1";

fn live(lines: &str) -> LiveConfig {
    match kind_of(&format!("kind = \"live\"\n{LEAST}\n{lines}")) {
        EstimatorKind::Live(config) => *config,
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_live_estimator_is_told_of_no_body_unless_one_is_declared() {
    let (torsion, _) = tested("");
    // Three samples of 300 Hz make one.
    assert_eq!(live(""), LiveConfig::new(torsion, 0.01));
}

#[test]
fn a_declared_body_arrives_in_si() {
    let lines = "swing_max_deg = 3.0\nfit_work_per_sample = 9\ngyro_count_deg_s = 0.25\n\
                 gyro_raw_sigma_deg_s = 0.1\nbody_inertia_sigma_percent = 1.0\n\
                 body_swing_damping_sigma_percent = 20.0\ngravity_m_s2 = 9.8";
    let config = live(&format!("{BODY}\n{lines}"));
    let swing = config.swing.expect("it is declared");
    let quantiser = config.torsion.quantiser.expect("it was given");
    assert_eq!((swing.body.mass_kg, swing.body.com_depth_m), (1.5, 0.2));
    assert_eq!(swing.body.inertia_kg_m2, [0.02, 0.03, 0.04]);
    assert_eq!((swing.body.gravity_m_s2, swing.body.swing_damping_1_s), (9.8, 0.01));
    // Three samples of 300 Hz make one.
    assert_eq!((config.work_per_sample, quantiser.samples), (9, 3));
    for (si, expected) in [
        (swing.axis.tilt_b_rad[0], RAD_PER_DEG.sin()),
        (swing.axis.tilt_b_rad[1], -(0.5 * RAD_PER_DEG).sin()),
        (swing.axis.tilt_sigma_rad, 0.1 * RAD_PER_DEG),
        (swing.inertia_sigma, 0.01),
        (swing.swing_damping_sigma, 0.2),
        (config.swing_max_rad, 3.0 * RAD_PER_DEG),
        (quantiser.step_rad_s, 0.25 * RAD_PER_DEG),
        (quantiser.raw_sigma_rad_s, 0.1 * RAD_PER_DEG),
    ] {
        // A product or two: a few last bits.
        assert!((si / expected - 1.0).abs() < 1e-14, "{si} for {expected}");
    }
}

#[test]
fn half_a_declaration_and_impossible_bodies_are_refused() {
    for missing in BODY.lines() {
        let rest: Vec<_> = BODY.lines().filter(|line| *line != missing).collect();
        let lines = format!("kind = \"live\"\n{LEAST}\n{}", rest.join("\n"));
        let (key, _) = missing.split_once(" = ").expect("a line has a key");
        let said = refusal(&with_estimator(&lines));
        assert!(said.contains(&format!("`estimator[0].{key}`")), "{said}");
        assert!(said.contains("missing; add it"), "{said}");
    }
    for (line, place, remedy) in [
        ("body_mass_kg = 0.0", "body_mass_kg` = 0.0", "greater than 0"),
        ("body_inertia_kg_m2 = [1.0, 2.0]", "body_inertia_kg_m2` = ", "three moments"),
        ("body_inertia_kg_m2 = [1.0, -2.0, 1.0]", "body_inertia_kg_m2[1]` = ", "greater than 0"),
        ("input_axis_deg = [50.0, 0.0]", "estimator[0]`", "below 45 degrees"),
        ("swing_max_deg = 90.0", "swing_max_deg` = 90.0", "8.5e1"),
        ("gyro_raw_sigma_deg_s = 0.1", "gyro_raw_sigma_deg_s` = 0.1", "add that"),
        ("fit_work_per_sample = 0", "fit_work_per_sample` = 0", "1 to"),
    ] {
        let (key, _) = line.split_once(" = ").expect("a line has a key");
        let others: Vec<_> = BODY.lines().filter(|other| !other.starts_with(key)).collect();
        let lines = format!("kind = \"live\"\n{LEAST}\n{}\n{line}", others.join("\n"));
        let said = refusal(&with_estimator(&lines));
        assert!(said.contains(place) && said.contains(remedy), "{line}: {said}");
    }
    let said = refusal(&with_estimator(&format!("kind = \"tested-torsion\"\n{LEAST}\n{BODY}")));
    assert!(said.contains("body_mass_kg") && said.contains("but \"live\""), "{said}");
}

#[test]
fn a_bank_takes_what_the_filter_that_learns_takes() {
    let (usual, _) = tested("");
    let bank = kind_of(&format!("kind = \"hysteresis-bank\"\n{LEAST}"));
    assert_eq!(bank, EstimatorKind::HysteresisBank(usual));
}
