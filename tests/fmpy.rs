//! FMPy, an importer that shares no code with this workspace, runs every exported FMU in both
//! versions of FMI, and the probe FMU that misbehaves on demand.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use struna::fmu::{FmiVersion, ModelType, find_library, models, package};
use struna_estimator::{
    Filter, FilterConfig, PermanentRotation, RateEstimator, Reading, Refinement,
    TorsionalOscillation,
};
use struna_kernel::RAD_PER_DEG;
use tempfile::TempDir;

#[path = "../fmu/export/examples/probe/model.rs"]
mod probe;

static PROBE: ModelType = ModelType::of::<probe::Probe>();

/// A power of two, so that FMPy's own arithmetic on times is exact.
const STEP_S: f64 = 1.0 / 128.0;
const STEPS: u32 = 600;

/// Runs a script of `tests/fmpy` in the virtual environment and reports what it says if it fails.
fn run(script: &str, arguments: &[&str]) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let python = std::env::var_os("STRUNA_PYTHON")
        .map_or_else(|| root.join(".venv/bin/python"), PathBuf::from);
    assert!(python.is_file(), "{} is missing: run make test", python.display());
    let output = Command::new(python)
        .arg("-B") // leaves no byte code beside the scripts
        .arg(root.join("tests/fmpy").join(script))
        .args(arguments)
        .output()
        .expect("an interpreter that exists can be started");
    assert!(
        output.status.success(),
        "{script} {arguments:?}: {}\n{}{}",
        output.status,
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
}

/// An FMU in a folder of its own.
struct Built {
    path: String,
    folder: TempDir,
}

impl Built {
    fn file(&self, name: &str) -> String {
        text(&self.folder.path().join(name))
    }
}

fn text(path: &Path) -> String {
    path.to_str().expect("temporary folders have UTF-8 names").to_owned()
}

fn build(model: &ModelType, version: FmiVersion, library: &Path) -> Built {
    let folder = tempfile::tempdir().expect("the temporary folder can be written");
    let path = package(model, version, library, folder.path()).expect("the FMU can be packed");
    Built { path: text(&path), folder }
}

/// Every exported model in both versions of FMI.
fn every_fmu() -> impl Iterator<Item = (&'static ModelType, FmiVersion, Built)> {
    let library = find_library().expect("the FMU library is built with this test");
    FmiVersion::ALL.into_iter().flat_map(move |version| {
        let library = library.clone();
        models().iter().map(move |model| (model, version, build(model, version, &library)))
    })
}

fn probes() -> impl Iterator<Item = Built> {
    // target/<profile>/deps/<this test> -> target/<profile>/examples/libprobe.so
    let program = std::env::current_exe().expect("a running program has a path");
    let profile = program.parent().and_then(Path::parent).expect("tests lie in deps");
    let library = profile.join("examples/libprobe.so");
    let remedy = "cargo build -p struna-fmi-export --example probe";
    assert!(library.is_file(), "{} is missing: {remedy}", library.display());
    FmiVersion::ALL.into_iter().map(move |version| build(&PROBE, version, &library))
}

/// A rate that turns, shakes and now and then is missing: (rate in rad/s, valid).
fn inputs() -> Vec<(f64, bool)> {
    let row = |k: u32| {
        let t = f64::from(k);
        (
            0.08 * (0.013 * t).cos() + 0.002 * (2.9 * t).sin(),
            k % 11 != 4 && !(200..230).contains(&k),
        )
    };
    (0..STEPS).map(row).collect()
}

fn little_endian(doubles: impl IntoIterator<Item = f64>) -> Vec<u8> {
    doubles.into_iter().flat_map(f64::to_le_bytes).collect()
}

fn write_inputs(file: &str) {
    let doubles = inputs().into_iter().flat_map(|(rate, valid)| [rate, f64::from(u8::from(valid))]);
    fs::write(file, little_endian(doubles)).expect("the temporary folder can be written");
}

/// The configuration that the variable table starts from.
fn default_config() -> FilterConfig {
    let deg2 = RAD_PER_DEG * RAD_PER_DEG;
    FilterConfig {
        angle_start_rad: 0.0,
        rate_start_rad_s: 0.0,
        angle_variance_start_rad2: deg2,
        rate_variance_start_rad2_s2: deg2,
        measurement_variance_rad2_s2: 1.37e-4 * deg2,
        process_noise_rad2_s3: 0.0,
        refinement: Refinement { samples: 100, reading: Reading::M6 },
    }
}

/// What the filter believes in process, after initialisation and after every step.
fn in_process(model: &ModelType, config: FilterConfig, period_s: f64) -> Vec<u8> {
    let name = model.description().name();
    if name == "PermanentRotation" {
        return record(Filter::<PermanentRotation>::permanent_rotation(config));
    }
    assert_eq!(name, "TorsionalOscillation", "a model without counterpart in process");
    record(Filter::<TorsionalOscillation>::torsional_oscillation(config, period_s))
}

fn record<E: std::fmt::Debug>(filter: Result<impl RateEstimator, E>) -> Vec<u8> {
    let mut filter = filter.expect("the configuration is good");
    let row = |filter: &dyn RateEstimator, residual_rad_s, nis| {
        let b = filter.belief();
        let sigmas = [b.covariance.angle_rad2.sqrt(), b.covariance.rate_rad2_s2.sqrt()];
        [b.angle_rad, b.rate_rad_s, sigmas[0], sigmas[1], residual_rad_s, nis]
    };
    let mut rows = vec![row(&filter, 0.0, 0.0)];
    for (rate_rad_s, valid) in inputs() {
        filter.predict(STEP_S).expect("the span is good");
        let (mut residual_rad_s, mut nis) = (0.0, 0.0);
        if valid {
            let innovation = filter.update(rate_rad_s).expect("the rate is good");
            (residual_rad_s, nis) = (innovation.residual_rad_s, innovation.nis());
        }
        rows.push(row(&filter, residual_rad_s, nis));
    }
    little_endian(rows.into_iter().flatten())
}

/// Compares records of six doubles a row, bit by bit, and names the first that differs.
fn assert_same_bits(fmu: &Built, of_fmu: &str, expected: &[u8]) {
    let got = fs::read(of_fmu).expect("the script has written its outputs");
    assert_eq!(got.len(), expected.len(), "{}: bytes of record", fmu.path);
    let differs = got.chunks(8).zip(expected.chunks(8)).position(|(a, b)| a != b);
    let place = differs.map(|place| format!("row {}, column {}", place / 6, place % 6));
    assert_eq!(place, None, "{} differs", fmu.path);
}

#[test]
fn fmpy_finds_no_fault_in_any_model_description() {
    for (_, _, fmu) in every_fmu() {
        run("valid.py", &[&fmu.path]);
    }
    for fmu in probes() {
        run("valid.py", &[&fmu.path]);
    }
}

#[test]
fn fmu_and_in_process_estimates_are_bit_identical_in_fmpy() {
    for (model, _, fmu) in every_fmu() {
        let (inputs, outputs) = (fmu.file("inputs"), fmu.file("outputs"));
        write_inputs(&inputs);
        run("steps.py", &[&fmu.path, &STEP_S.to_string(), &inputs, &outputs]);
        assert_same_bits(&fmu, &outputs, &in_process(model, default_config(), 480.0));
    }
}

#[test]
fn parameters_reach_the_filter_inside_the_fmu() {
    let config = FilterConfig {
        angle_start_rad: 0.75,
        rate_start_rad_s: -0.125,
        angle_variance_start_rad2: 0.5,
        rate_variance_start_rad2_s2: 0.25,
        measurement_variance_rad2_s2: 0.0625,
        process_noise_rad2_s3: 0.001,
        refinement: Refinement { samples: 7, reading: Reading::M0 },
    };
    for (model, _, fmu) in every_fmu() {
        let (inputs, outputs) = (fmu.file("inputs"), fmu.file("outputs"));
        write_inputs(&inputs);
        let step = STEP_S.to_string();
        let mut arguments = vec![fmu.path.as_str(), &step, &inputs, &outputs];
        arguments.extend([
            "angle_start_rad=0.75",
            "rate_start_rad_s=-0.125",
            "angle_variance_start_rad2=0.5",
            "rate_variance_start_rad2_s2=0.25",
            "measurement_variance_rad2_s2=0.0625",
            "process_noise_rad2_s3=0.001",
            "refinement_samples=7",
            "refinement_reading=0",
        ]);
        if model.description().name() == "TorsionalOscillation" {
            arguments.push("period_s=12.5");
        }
        run("steps.py", &arguments);
        assert_same_bits(&fmu, &outputs, &in_process(model, config, 12.5));
    }
}

#[test]
fn fmpys_own_simulation_gives_the_same_bits() {
    for (model, _, fmu) in every_fmu() {
        let (inputs, outputs) = (fmu.file("inputs"), fmu.file("outputs"));
        write_inputs(&inputs);
        run("simulate.py", &[&fmu.path, &STEP_S.to_string(), &inputs, &outputs]);
        assert_same_bits(&fmu, &outputs, &in_process(model, default_config(), 480.0));
    }
}

#[test]
fn saved_serialized_and_reset_states_continue_bit_for_bit() {
    let fmus: Vec<_> = every_fmu().collect();
    for pair in fmus.chunks(2) {
        let [(_, _, one), (_, _, other)] = pair else { panic!("each version has two models") };
        run("states.py", &[&one.path, &other.path]);
        run("states.py", &[&other.path, &one.path]);
    }
}

#[test]
fn every_misuse_is_refused_with_a_log_line_and_changes_nothing() {
    for (_, _, fmu) in every_fmu() {
        run("refusals.py", &[&fmu.path]);
    }
}

#[test]
fn a_panic_in_a_model_ends_its_instance_and_not_the_importer() {
    for fmu in probes() {
        run("probe.py", &[&fmu.path]);
    }
}
