//! Scenario files of any quality: shipped ones parse, broken ones are refused where they break,
//! none panics.

#![expect(clippy::panic, reason = "a panic fails the test")]

mod learning;
mod rig;
#[path = "../support/mod.rs"]
mod support;

use proptest::prelude::*;
use std::fs;
use std::path::Path;
use std::sync::LazyLock;
use struna::scenario::{EstimatorKind, ModelSource, Scenario, ScenarioError, Source};
use struna_kernel::{BodyMotion, Seed, SimTime};

/// The demo, moved by the equations of motion: they can do all that a scenario may ask for.
static DEMO: LazyLock<String> = LazyLock::new(|| {
    let demo = include_str!("../../scenarios/demo.toml");
    let lagrange = demo.replacen("backend = \"rapier\"", "backend = \"lagrange\"", 1);
    lagrange.replacen("step_s = 1e-3", "method = \"rk4\"\nstep_s = 1e-3", 1)
});

fn refusal(text: &str) -> String {
    match Scenario::parse(text, Path::new("folder/x.toml")) {
        Ok(_) => panic!("accepted:\n{text}"),
        Err(error) => error.to_string(),
    }
}

/// The demo with one line replaced.
fn with(line: &str, replacement: &str) -> String {
    assert!(DEMO.lines().any(|l| l.trim_start().starts_with(line)), "no line {line}");
    DEMO.lines()
        .map(|l| if l.trim_start().starts_with(line) { replacement } else { l })
        .collect::<Vec<_>>()
        .join("\n")
}

#[test]
fn every_shipped_scenario_parses() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let mut count = 0;
    for entry in fs::read_dir(folder).expect("a folder of scenarios") {
        let path = entry.expect("an entry").path();
        let scenario = Scenario::read(&path).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(path.file_stem().and_then(|stem| stem.to_str()), Some(&*scenario.name));
        if let Source::Model(model) = &scenario.source {
            let end = motion_of(model, scenario.seed);
            assert!(end.q_wb.coords.iter().all(|part| part.is_finite()), "{}", path.display());
        }
        count += 1;
    }
    assert!(count >= 4, "{count} scenarios");
}

fn parse(text: &str) -> Scenario {
    Scenario::parse(text, Path::new("folder/x.toml")).unwrap_or_else(|e| panic!("{e}"))
}

fn model(scenario: &Scenario) -> &ModelSource {
    match &scenario.source {
        Source::Model(model) => model,
        Source::Recording(_) => panic!("a model was asked for"),
    }
}

/// The motion a second after the start.
fn motion_of(model: &ModelSource, seed: Seed) -> BodyMotion {
    let mut motion = model.motion(seed, 0).unwrap_or_else(|e| panic!("{e}"));
    motion.motion_at(SimTime::from_ns(1_000_000_000)).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn degrees_become_radians_on_the_way_in() {
    let scenario = Scenario::parse(&DEMO, Path::new("x.toml")).expect("the demo parses");
    let Source::Model(model) = &scenario.source else { panic!("the demo runs a model") };
    let turn_rad = std::f64::consts::TAU;
    assert!((model.start.twist_rad / turn_rad - 1.0).abs() < 1e-15);
    let EstimatorKind::PermanentRotation(filter) = &scenario.estimators[1].kind else {
        panic!("the demo's second estimator assumes a constant rate")
    };
    assert!((filter.angle_start_rad / turn_rad - 1.0).abs() < 1e-15);
    let sigma_deg_s = filter.measurement_variance_rad2_s2.sqrt().to_degrees();
    // A square and its root, and a degree and back: a few last bits.
    assert!((sigma_deg_s / 0.0117 - 1.0).abs() < 1e-14);
    let bias_deg_h = scenario.gyro.bias_rad_s.to_degrees() * 3600.0;
    assert!((bias_deg_h / 3.0 - 1.0).abs() < 1e-14);
}

#[test]
fn refusals_name_file_line_key_value_and_remedy() {
    let cases = [
        ("duration_s", "duratoin_s = 1", "`run.duratoin_s`", "did you mean `duration_s`?"),
        ("duration_s", "duration_s = -1", "`run.duration_s` = -1", "greater than 0"),
        ("duration_s", "duration_s = nan", "`run.duration_s` = nan", "finite"),
        ("seed", "seed = -1", "`run.seed` = -1", "0 to"),
        ("mass_kg", "mass_kg = 0.0", "`body.mass_kg` = 0.0", "greater than 0"),
        ("inertia_kg_m2", "inertia_kg_m2 = [1.0, -1.0, 1.0]", "inertia_kg_m2[1]", "greater than 0"),
        (
            "inertia_kg_m2",
            "inertia_kg_m2 = [1.0, 1.0, 3.0]",
            "`body.inertia_kg_m2`",
            "the other two",
        ),
        ("period_s", "period_s = 0", "`body.torsion.period_s` = 0", "greater than 0"),
        ("preset", "preset = \"vg910\"", "`gyro.preset`", "did you mean `vg910d`?"),
        ("frame", "frame = \"vg910d\"", "`line.frame`", "struna/vg910d@1"),
        ("samples", "samples = 0", "`averaging.samples` = 0", "1 to"),
        ("kind = \"plain", "kind = \"plain\"", "estimator[0].kind", "plain-integration"),
        ("torsion_period_s", "", "torsion_period_s", "missing"),
        ("method", "method = \"euler\"", "`body.integrator.method`", "rk4"),
        ("name = \"rotation\"", "name = \"integration\"", "estimator[1].name", "another estimator"),
    ];
    for (line, replacement, place, remedy) in cases {
        let text = refusal(&with(line, replacement));
        assert!(text.starts_with("folder/x.toml, line "), "{text}");
        assert!(text.contains(place) && text.contains(remedy), "{replacement}: {text}");
    }
}

#[test]
fn a_table_that_is_not_there_is_asked_for() {
    for table in ["run", "body", "gyro"] {
        let text = DEMO.replace(&format!("[{table}]"), &format!("[x-{table}]"));
        assert!(refusal(&text).contains(table));
    }
}

#[test]
fn a_missing_or_broken_frame_file_is_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("x.toml");
    let text = with("frame", "frame = \"own.toml\"");
    let missing = Scenario::parse(&text, &path).expect_err("there is no such file");
    assert!(matches!(missing, ScenarioError::ReadFrame { .. }), "{missing}");
    assert!(missing.to_string().contains("own.toml"), "{missing}");
    fs::write(folder.path().join("own.toml"), "[frame]\nname = \"x\"\n").expect("a small file");
    let broken = Scenario::parse(&text, &path).expect_err("the layout is not complete");
    assert!(broken.to_string().contains("own.toml, line "), "{broken}");
    fs::write(folder.path().join("own.toml"), include_str!("../../frames/vg910d.toml"))
        .expect("a small file");
    assert!(Scenario::parse(&text, &path).is_ok());
}

proptest! {
    #[test]
    fn no_damage_to_a_scenario_makes_it_panic(
        at in any::<prop::sample::Index>(),
        removed in 0_usize..40,
        inserted in "[\\[\\]\"=.,#a-z0-9 \\-\n]{0,12}",
    ) {
        let start = at.index(DEMO.len());
        let end = (start + removed).min(DEMO.len());
        let text = [&DEMO[..start], &inserted, &DEMO[end..]].concat();
        if let Err(error) = Scenario::parse(&text, Path::new("x.toml")) {
            prop_assert!(error.to_string().contains("x.toml"), "{error}");
        }
    }
}
