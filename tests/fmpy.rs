//! FMPy, an importer that shares no code with this workspace, runs every exported FMU in both
//! versions of FMI, and the probe FMU that misbehaves on demand.

#![expect(clippy::panic, reason = "a panic fails the test")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use struna::fmu::{FmiVersion, ModelType, find_library, models, package};
use struna_estimator::{
    AugmentedConfig, AugmentedFilter, EstimatorError, Filter, FilterConfig, GyroRange,
    HysteresisBank, Innovation, InnovationTest, InputAxis, LearntParameters, LiveConfig,
    LiveEstimator, Quantiser, RateEstimator, Reading, Refinement, StartPrior, Status, SwingBody,
    SwingConfig, TestedFilter,
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

/// A rate that turns, shakes, and is struck once; now and then it is missing or marked as clipped.
#[derive(Clone, Copy)]
struct Input {
    rate_rad_s: f64,
    valid: bool,
    over_range: bool,
}

fn inputs() -> Vec<Input> {
    let row = |k: u32| {
        let t = f64::from(k);
        let kick = if k > 400 { 0.05 } else { 0.0 };
        Input {
            rate_rad_s: 0.08 * (0.013 * t).cos() + 0.002 * (2.9 * t).sin() + kick,
            valid: k % 11 != 4 && !(200..230).contains(&k),
            over_range: k % 29 == 7 || (300..320).contains(&k),
        }
    };
    (0..STEPS).map(row).collect()
}

fn little_endian(doubles: impl IntoIterator<Item = f64>) -> Vec<u8> {
    doubles.into_iter().flat_map(f64::to_le_bytes).collect()
}

fn write_inputs(file: &str) {
    let flag = |flag: bool| f64::from(u8::from(flag));
    let row = |input: Input| [input.rate_rad_s, flag(input.valid), flag(input.over_range)];
    let doubles = inputs().into_iter().flat_map(row);
    fs::write(file, little_endian(doubles)).expect("the temporary folder can be written");
}

/// The configuration that the variable tables of 2008 start from.
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

/// The same of the filter that learns.
fn default_augmented() -> AugmentedConfig {
    let r = default_config().measurement_variance_rad2_s2;
    AugmentedConfig::quiet(StartPrior::released(0.0, 480.0), r)
}

/// What the model called `name` believes in process as its variable table starts.
fn by_default(name: &str) -> Vec<u8> {
    match name {
        "PermanentRotation" => record(Filter::permanent_rotation(default_config()), nothing_more),
        "TorsionalOscillation" => {
            record(Filter::torsional_oscillation(default_config(), 480.0), nothing_more)
        }
        "AugmentedTorsion" => {
            let tested = TestedFilter::new(&default_augmented(), &InnovationTest::STANDARD);
            record(tested, of_tested)
        }
        "HysteresisBank" => record(HysteresisBank::new(&default_augmented()), of_bank),
        "LiveEstimator" => {
            let config = LiveConfig::new(default_augmented(), 0.01);
            record(LiveEstimator::new(&config), of_live)
        }
        _ => panic!("{name}: a model without counterpart in process"),
    }
}

fn nothing_more<E>(_: &E) -> Vec<f64> {
    Vec::new()
}

fn of_augmented(filter: &AugmentedFilter) -> Vec<f64> {
    [&learnt(filter, &filter.learnt())[..], &[0.0]].concat()
}

fn of_tested(filter: &TestedFilter) -> Vec<f64> {
    let alarms = filter.alarms() as f64;
    [&learnt(filter, &filter.filter().learnt())[..], &[alarms]].concat()
}

fn of_bank(bank: &HysteresisBank) -> Vec<f64> {
    let (angle_rad, sigma_rad) = bank.yield_angle_rad().expect("no member is dropped here");
    [&learnt(bank, &bank.learnt())[..], &[bank.weights()[0], angle_rad, sigma_rad]].concat()
}

fn of_live(live: &LiveEstimator) -> Vec<f64> {
    let torsion = live.torsion();
    let status = live.status();
    let yields = match status {
        Status::ThreadYields { yield_angle_rad } => yield_angle_rad,
        _ => 0.0,
    };
    let fit = match status {
        Status::Fitting { collected_s, needed_s } => [collected_s, needed_s],
        _ => [0.0; 2],
    };
    let swing_rad = live.swing_rad().unwrap_or(0.0);
    let own = [torsion.alarms() as f64, swing_rad, yields, fit[0], fit[1]];
    [&learnt(live, &torsion.filter().learnt())[..], &own].concat()
}

/// The status, and what has been learnt.
fn learnt(estimator: &impl RateEstimator, learnt: &LearntParameters) -> [f64; 7] {
    [
        f64::from(estimator.status().code()),
        learnt.period_s,
        learnt.period_sigma_s,
        learnt.damping_ratio,
        learnt.damping_ratio_sigma,
        learnt.bias_rad_s,
        learnt.bias_sigma_rad_s,
    ]
}

/// What an estimator believes after initialisation and after every step, and what it has `more`.
fn record<E: RateEstimator, F: std::fmt::Debug>(
    made: Result<E, F>,
    more: impl Fn(&E) -> Vec<f64>,
) -> Vec<u8> {
    record_by(made, more, |estimator, rate_rad_s| estimator.step(STEP_S, rate_rad_s))
}

/// The same, rates that are valid and within range taken in by `step`.
fn record_by<E: RateEstimator, F: std::fmt::Debug>(
    made: Result<E, F>,
    more: impl Fn(&E) -> Vec<f64>,
    step: impl Fn(&mut E, f64) -> Result<Innovation, EstimatorError>,
) -> Vec<u8> {
    let mut estimator = made.expect("the configuration is good");
    let row = |estimator: &E, innovation: Option<Innovation>| {
        let b = estimator.belief();
        let sigmas = [b.covariance.angle_rad2.sqrt(), b.covariance.rate_rad2_s2.sqrt()];
        let surprise = innovation.map_or([0.0; 2], |i| [i.residual_rad_s, i.nis()]);
        let common = [b.angle_rad, b.rate_rad_s, sigmas[0], sigmas[1], surprise[0], surprise[1]];
        [&common[..], &more(estimator)].concat()
    };
    let mut rows = row(&estimator, None);
    for Input { rate_rad_s, valid, over_range } in inputs() {
        let innovation = if valid && !over_range {
            Some(step(&mut estimator, rate_rad_s).expect("the rate is good"))
        } else {
            estimator.predict(STEP_S).expect("the span is good");
            valid.then(|| estimator.update_over_range(rate_rad_s).expect("the rate is good"))
        };
        rows.extend(row(&estimator, innovation));
    }
    little_endian(rows)
}

/// Compares records bit by bit, and names the first place that differs.
fn assert_same_bits(fmu: &Built, of_fmu: &str, expected: &[u8]) {
    let got = fs::read(of_fmu).expect("the script has written its outputs");
    assert_eq!(got.len(), expected.len(), "{}: bytes of record", fmu.path);
    let columns = expected.len() / 8 / (STEPS as usize + 1);
    let differs = got.chunks(8).zip(expected.chunks(8)).position(|(a, b)| a != b);
    let place = differs.map(|at| format!("row {}, column {}", at / columns, at % columns));
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
        assert_same_bits(&fmu, &outputs, &by_default(model.description().name()));
    }
}

/// Runs every FMU of the model called `name` with `parameters`; `expected` is what it believes.
fn assert_parameters_reach(name: &str, parameters: &[&str], expected: &[u8]) {
    for (_, _, fmu) in every_fmu().filter(|(model, ..)| model.description().name() == name) {
        let (inputs, outputs) = (fmu.file("inputs"), fmu.file("outputs"));
        write_inputs(&inputs);
        let step = STEP_S.to_string();
        let arguments = [&[fmu.path.as_str(), &step, &inputs, &outputs], parameters].concat();
        run("steps.py", &arguments);
        assert_same_bits(&fmu, &outputs, expected);
    }
}

#[test]
fn parameters_reach_the_filters_of_2008_inside_the_fmu() {
    let config = FilterConfig {
        angle_start_rad: 0.75,
        rate_start_rad_s: -0.125,
        angle_variance_start_rad2: 0.5,
        rate_variance_start_rad2_s2: 0.25,
        measurement_variance_rad2_s2: 0.0625,
        process_noise_rad2_s3: 0.001,
        refinement: Refinement { samples: 7, reading: Reading::M0 },
    };
    let common = [
        "angle_start_rad=0.75",
        "rate_start_rad_s=-0.125",
        "angle_variance_start_rad2=0.5",
        "rate_variance_start_rad2_s2=0.25",
        "measurement_variance_rad2_s2=0.0625",
        "process_noise_rad2_s3=0.001",
        "refinement_samples=7",
        "refinement_reading=0",
    ];
    let rotation = record(Filter::permanent_rotation(config), nothing_more);
    assert_parameters_reach("PermanentRotation", &common, &rotation);
    let torsion = record(Filter::torsional_oscillation(config, 12.5), nothing_more);
    let parameters = [&common[..], &["period_s=12.5"]].concat();
    assert_parameters_reach("TorsionalOscillation", &parameters, &torsion);
}

/// What the estimators that learn are told below, and the same for an FMU.
fn learning() -> (AugmentedConfig, [&'static str; 19]) {
    let config = AugmentedConfig {
        start: StartPrior {
            angle_rad: 0.75,
            angle_sigma_rad: 0.5,
            rate_rad_s: -0.125,
            rate_sigma_rad_s: 0.25,
            period_s: 12.5,
            period_sigma_s: 0.5,
            damping_ratio: 0.0625,
            damping_ratio_sigma: 0.03125,
            bias_rad_s: 0.001,
            bias_sigma_rad_s: 0.002,
        },
        measurement_variance_rad2_s2: 1e-6,
        process_noise_rad2_s3: 1e-5,
        bias_walk_rad2_s3: 1e-8,
        scale_factor_sigma: 0.125,
        range: Some(GyroRange { limit_rad_s: 0.1, margin_rad_s: 0.02 }),
        quantiser: Some(Quantiser {
            step_rad_s: 0.0009765625,
            raw_sigma_rad_s: 0.000244140625,
            samples: 3,
        }),
    };
    let parameters = [
        "angle_start_rad=0.75",
        "angle_sigma_start_rad=0.5",
        "rate_start_rad_s=-0.125",
        "rate_sigma_start_rad_s=0.25",
        "period_start_s=12.5",
        "period_sigma_start_s=0.5",
        "damping_ratio_start=0.0625",
        "damping_ratio_sigma_start=0.03125",
        "bias_start_rad_s=0.001",
        "bias_sigma_start_rad_s=0.002",
        "measurement_variance_rad2_s2=1e-6",
        "process_noise_rad2_s3=1e-5",
        "bias_walk_rad2_s3=1e-8",
        "scale_factor_sigma=0.125",
        "gyro_range_rad_s=0.1",
        "gyro_range_margin_rad_s=0.02",
        "gyro_count_rad_s=0.0009765625",
        "gyro_raw_sigma_rad_s=0.000244140625",
        "gyro_samples=3",
    ];
    (config, parameters)
}

/// A test that fires easily, and the same for an FMU.
const EASY: InnovationTest =
    InnovationTest { false_alarms: 0.5, horizon_samples: 2048, kick_floor_rad_s: 0.015625 };
const EASY_PARAMETERS: [&str; 3] =
    ["test_false_alarms=0.5", "test_horizon_samples=2048", "test_kick_floor_rad_s=0.015625"];

#[test]
fn parameters_reach_the_filter_that_learns_and_its_test_inside_the_fmu() {
    let (config, common) = learning();
    let alone = record(AugmentedFilter::new(&config), of_augmented);
    let parameters = [&common[..], &["innovation_test=false"]].concat();
    assert_parameters_reach("AugmentedTorsion", &parameters, &alone);
    let parameters = [&common[..], &EASY_PARAMETERS].concat();
    let tested = TestedFilter::new(&config, &EASY);
    assert_parameters_reach("AugmentedTorsion", &parameters, &record(tested, of_tested));
}

#[test]
fn an_fmu_takes_means_at_their_middle_when_it_is_told_so() {
    let (config, common) = learning();
    let parameters = [&common[..], &["measured_rate_is_mean=true"]].concat();
    let bank = HysteresisBank::new(&config);
    let means = record_by(bank, of_bank, |bank, rate| bank.step_mean(STEP_S, rate));
    assert_parameters_reach("HysteresisBank", &parameters, &means);
    let parameters = [&parameters[..], &EASY_PARAMETERS].concat();
    let tested = TestedFilter::new(&config, &EASY);
    let means = record_by(tested, of_tested, |tested, rate| tested.step_mean(STEP_S, rate));
    assert_parameters_reach("AugmentedTorsion", &parameters, &means);
}

#[test]
fn parameters_reach_the_bank_inside_the_fmu() {
    let (config, common) = learning();
    let bank = record(HysteresisBank::new(&config), of_bank);
    assert_parameters_reach("HysteresisBank", &common, &bank);
}

#[test]
fn parameters_reach_the_live_estimator_and_its_body_inside_the_fmu() {
    let (torsion, common) = learning();
    let body = SwingBody {
        mass_kg: 2.0,
        com_depth_m: 0.25,
        inertia_kg_m2: [0.0625, 0.09375, 0.125],
        gravity_m_s2: 9.75,
        swing_damping_1_s: 0.03125,
    };
    let axis = InputAxis { tilt_b_rad: [0.015625, -0.03125], tilt_sigma_rad: 0.001953125 };
    let swing = SwingConfig {
        inertia_sigma: 0.0625,
        swing_damping_sigma: 0.25,
        ..SwingConfig::quiet(body, axis, torsion.start, torsion.measurement_variance_rad2_s2)
    };
    let config = LiveConfig {
        test: EASY,
        swing: Some(swing),
        swing_max_rad: 0.125,
        work_per_sample: 7,
        ..LiveConfig::new(torsion, STEP_S)
    };
    let own = [
        "sample_period_s=0.0078125",
        "swing_max_rad=0.125",
        "fit_work_per_sample=7",
        "body_mass_kg=2",
        "body_com_depth_m=0.25",
        "body_inertia_x_kg_m2=0.0625",
        "body_inertia_y_kg_m2=0.09375",
        "body_inertia_z_kg_m2=0.125",
        "body_inertia_sigma=0.0625",
        "body_swing_damping_1_s=0.03125",
        "body_swing_damping_sigma=0.25",
        "gravity_m_s2=9.75",
        "input_axis_x_rad=0.015625",
        "input_axis_y_rad=-0.03125",
        "input_axis_sigma_rad=0.001953125",
    ];
    let declared = record(LiveEstimator::new(&config), of_live);
    let parameters = [&common[..], &EASY_PARAMETERS, &own].concat();
    assert_parameters_reach("LiveEstimator", &parameters, &declared);
    // Without a body the same numbers are another estimator.
    let undeclared = LiveEstimator::new(&LiveConfig { swing: None, ..config });
    assert!(record(undeclared, of_live) != declared, "the body makes no difference here");
}

/// The bits above mean little for the test if it never raised an alarm.
#[test]
fn the_inputs_make_the_tested_filter_go_back() {
    let doubles: Vec<f64> = by_default("AugmentedTorsion")
        .chunks(8)
        .map(|bytes| f64::from_le_bytes(bytes.try_into().expect("eight bytes")))
        .collect();
    let last = doubles.chunks(14).last().expect("a row for each step");
    let (status, alarms) = (last[6], last[13]);
    assert!(alarms >= 2.0, "{alarms} alarms");
    assert!(status > 0.0, "status {status}");
}

#[test]
fn fmpys_own_simulation_gives_the_same_bits() {
    for (model, _, fmu) in every_fmu() {
        let (inputs, outputs) = (fmu.file("inputs"), fmu.file("outputs"));
        write_inputs(&inputs);
        run("simulate.py", &[&fmu.path, &STEP_S.to_string(), &inputs, &outputs]);
        assert_same_bits(&fmu, &outputs, &by_default(model.description().name()));
    }
}

#[test]
fn saved_serialized_and_reset_states_continue_bit_for_bit() {
    let fmus: Vec<_> = every_fmu().collect();
    for of_a_version in fmus.chunks(models().len()) {
        for (k, (_, _, fmu)) in of_a_version.iter().enumerate() {
            let (_, _, another) = &of_a_version[(k + 1) % of_a_version.len()];
            run("states.py", &[&fmu.path, &another.path]);
        }
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
