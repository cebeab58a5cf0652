//! The sections of the rig and its gyro: each reaches the model in SI, each is refused where it is
//! wrong.

#![expect(clippy::float_cmp, reason = "what a file says is what a rig holds")]

use crate::support::run;
use crate::{DEMO, model, motion_of, parse, refusal, with};
use struna::session;
use struna_body::{
    Backend, ClampSwing, Creep, Drag, EARTH_RATE_RAD_S, Hysteresis, Impulse, Integrator, Mounting,
    PoissonImpulses, Rig, StartErrors, Support, TorqueNoise, Vibration, YieldElement, YieldLaw,
    earth_rate_w_rad_s,
};
use struna_gyro::{GyroParams, Sampling, Surroundings, preset};
use struna_kernel::{RAD_PER_DEG, Seed, SimTime};

/// The demo with more sections at its end.
fn and(sections: &str) -> String {
    format!("{}\n{sections}\n", *DEMO)
}

/// The demo with more keys in `[body]`.
fn and_in_body(keys: &str) -> String {
    with("gravity_m_s2", &format!("gravity_m_s2 = 9.81\n{keys}"))
}

/// The demo with another `[body.start]`.
fn starting(keys: &str) -> String {
    let text = with("twist_deg", keys);
    text.lines().filter(|l| !l.starts_with("tilt_deg = 0.0")).collect::<Vec<_>>().join("\n")
}

/// Asserts that `text` is refused at `key`, on the last line that writes its last part, for a
/// reason that names each of `parts`.
#[track_caller]
fn refused_at(text: &str, key: &str, parts: &[&str]) {
    let last = key.rsplit('.').next().expect("a key").split('[').next().expect("a name");
    let writes = |line: &str| {
        let rest = line.trim_start_matches('[').trim_start_matches("body.");
        rest.strip_prefix(last).is_some_and(|rest| rest.starts_with([' ', ']']))
    };
    let line = 1 + text.lines().collect::<Vec<_>>().into_iter().rposition(writes).expect(last);
    let complaint = refusal(text);
    assert!(complaint.starts_with(&format!("folder/x.toml, line {line}, ")), "{key}: {complaint}");
    assert!(complaint.contains(&format!("`{key}` = ")), "{key}: {complaint}");
    for part in parts {
        assert!(complaint.contains(part), "{part:?} is not in: {complaint}");
    }
}

#[test]
fn what_a_scenario_leaves_out_is_off() {
    let scenario = parse(&DEMO);
    let model = model(&scenario);
    assert_eq!(model.rig, Rig::from(model.rig.body));
    assert_eq!(model.start_errors, StartErrors::NONE);
    assert_eq!(scenario.mounting, Mounting::default());
    assert_eq!(scenario.gyro.sampling, Sampling::Mean);
    assert_eq!(scenario.surroundings, Surroundings::default());
}

#[test]
fn each_section_reaches_the_rig_in_si() {
    let rig = |sections: &str| model(&parse(&and(sections))).rig.clone();
    let ideal = Rig::from(rig("").body);
    assert_eq!(
        rig("[body.string]\nlength_m = 3.0"),
        Rig { string_length_m: Some(3.0), ..ideal.clone() }
    );
    let hysteresis = "[body.torsion.hysteresis]\nlaw = \"dahl\"\n\
                      stiffness_n_m_rad = [2e-6, 1e-6]\nyield_deg = [25, 90.0]";
    let element = |stiffness_n_m_rad, yield_deg: f64| YieldElement {
        stiffness_n_m_rad,
        yield_rad: yield_deg * RAD_PER_DEG,
    };
    let elements = vec![element(2e-6, 25.0), element(1e-6, 90.0)];
    let hysteretic = Hysteresis { law: YieldLaw::Dahl, elements };
    assert_eq!(rig(hysteresis).hysteresis.as_ref(), Some(&hysteretic));
    let slipping = hysteresis.replace("dahl", "slip");
    assert_eq!(rig(&slipping).hysteresis.map(|h| h.law), Some(YieldLaw::Slip));
    assert_eq!(
        rig("[body.torsion.creep]\ntime_s = 600\nshare = 0.1").creep,
        Some(Creep { time_s: 600.0, share: 0.1 })
    );
    let drag = "[body.drag]\nrotation_n_m_s_rad = 1e-6\nrotation_quadratic_n_m_s2_rad2 = 2e-6\n\
                translation_n_s_m = 3e-3\ntranslation_quadratic_n_s2_m2 = 4e-3";
    assert_eq!(
        rig(drag).drag,
        Drag {
            rotation_n_m_s_rad: 1e-6,
            rotation_quadratic_n_m_s2_rad2: 2e-6,
            translation_n_s_m: 3e-3,
            translation_quadratic_n_s2_m2: 4e-3,
        }
    );
    let earth = rig("[environment]\nlatitude_deg = 55.9").earth_rate_w_rad_s;
    assert_eq!(earth, earth_rate_w_rad_s(55.9 * RAD_PER_DEG));
    assert!(earth.z > earth.y && earth.y > 0.0, "{earth}");
}

#[test]
fn the_support_reaches_the_rig_in_si() {
    let text = and("[body.support]\nclamp_deg = 90\nclamp_rate_deg_s = 0.5\n\
                    [[body.support.vibration]]\namplitude_m = [1e-3, 2e-3, 3e-3]\n\
                    frequency_hz = 2\nphase_deg = 180\n\
                    [[body.support.clamp_swing]]\namplitude_deg = 10\nfrequency_hz = 0.25");
    let swing =
        ClampSwing { amplitude_rad: 10.0 * RAD_PER_DEG, frequency_hz: 0.25, phase_rad: 0.0 };
    assert_eq!(
        model(&parse(&text)).rig.support,
        Support {
            vibrations: vec![Vibration {
                amplitude_w_m: [1e-3, 2e-3, 3e-3],
                frequency_hz: 2.0,
                phase_rad: 180.0 * RAD_PER_DEG,
            }],
            clamp_rad: 90.0 * RAD_PER_DEG,
            clamp_rate_rad_s: 0.5 * RAD_PER_DEG,
            clamp_swings: vec![swing],
        }
    );
}

#[test]
fn disturbances_reach_the_rig_in_si() {
    let text = and("[body.disturbance]\ngrid_hz = 700\n\
                    torque_noise_n_m_sqrt_hz = [1e-7, 2e-7, 3e-7]\n\
                    [[body.disturbance.impulse]]\ntime_s = 1.5\n\
                    angular_n_m_s = [1e-4, -2e-4, 3e-4]\n\
                    [[body.disturbance.impulse]]\ntime_s = 0.5\nlinear_n_s = [1, 2, 3]\n\
                    [body.disturbance.random_impulses]\nrate_hz = 0.1\n\
                    angular_sigma_n_m_s = [0, 0, 1e-5]");
    let scenario = parse(&text);
    let disturbances = &model(&scenario).rig.disturbances;
    assert_eq!(disturbances.grid_hz, 700.0);
    let noise = TorqueNoise { density_b_n_m_sqrt_hz: [1e-7, 2e-7, 3e-7] };
    assert_eq!(disturbances.noise, Some(noise));
    let impulse = |ms: i64, angular_b_n_m_s, linear_w_n_s| Impulse {
        time: SimTime::from_ns(ms * 1_000_000),
        angular_b_n_m_s,
        linear_w_n_s,
    };
    assert_eq!(
        disturbances.impulses,
        [impulse(1500, [1e-4, -2e-4, 3e-4], [0.0; 3]), impulse(500, [0.0; 3], [1.0, 2.0, 3.0]),]
    );
    let poisson = PoissonImpulses { rate_hz: 0.1, angular_sigma_b_n_m_s: [0.0, 0.0, 1e-5] };
    assert_eq!(disturbances.poisson, Some(poisson));
}

#[test]
fn body_start_and_gyro_take_their_new_keys() {
    let text = and_in_body(
        "com_offset_m = [1e-3, -2e-3]\nproducts_of_inertia_kg_m2 = [1e-5, 2e-5, -3e-5]",
    );
    let scenario = parse(&text);
    let params = model(&scenario).rig.body.params();
    assert_eq!(params.com_offset_m, [1e-3, -2e-3]);
    assert_eq!(params.products_kg_m2, [1e-5, 2e-5, -3e-5]);

    let scenario = parse(&starting(
        "tilt_deg = 1\ncom_velocity_m_s = [0.1, 0.2]\nsuspension_m = [0.3, 0.4]\n\
         twist_sigma_deg = 2\ntilt_sigma_deg = 3\nrate_sigma_deg_s = 4",
    ));
    let model = model(&scenario);
    assert_eq!(model.start.com_velocity_w_m_s, [0.1, 0.2]);
    assert_eq!(model.start.suspension_w_m, [0.3, 0.4]);
    assert_eq!(
        model.start_errors,
        StartErrors {
            twist_sigma_rad: 2.0 * RAD_PER_DEG,
            tilt_sigma_rad: 3.0 * RAD_PER_DEG,
            rate_sigma_rad_s: 4.0 * RAD_PER_DEG,
        }
    );

    let mounting = "[gyro.mounting]\nmisalignment_deg = [1, -2]\nposition_m = [0.1, 0.2, 0.3]";
    let misaligned = Mounting::new([RAD_PER_DEG, -2.0 * RAD_PER_DEG], [0.1, 0.2, 0.3]);
    assert_eq!(Ok(parse(&and(mounting)).mounting), misaligned);
    let sampled = with("preset", "preset = \"vg910d\"\nsampling = \"instantaneous\"");
    assert_eq!(parse(&sampled).gyro.sampling, Sampling::Instantaneous);
}

#[test]
fn a_gyro_is_a_preset_a_file_or_its_keys_alone_and_keys_come_last() {
    let of = |keys: &str| with("preset", keys);
    let adis = "preset = \"adis16100\"\nwarm_up_deg_h = 0\nbandwidth_hz = 80";
    let gyro = parse(&of(adis)).gyro;
    assert_eq!(gyro.counts_max, 2047);
    assert!(gyro.bias_effects.warm_up_rad_s == 0.0);
    assert!((gyro.response.natural_frequency_hz - 80.0).abs() < 1e-12);

    let keys = "sample_rate_hz = 300\nrate_max_deg_s = 200\nlsb_deg_s = 3.0517578125e-5\n\
                counts_bits = 24";
    let alone = parse(&of(keys)).gyro;
    let exact = preset::vg910d().without_errors();
    // The demo adds 3 deg/h.
    assert_eq!(GyroParams { bias_rad_s: 0.0, ..alone }, exact);
    let bare = refusal(&of("sample_rate_hz = 300"));
    assert!(bare.contains("`gyro.rate_max_deg_s`") && bare.contains("missing"), "{bare}");

    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("x.toml");
    let own = folder.path().join("own.toml");
    let text = of("file = \"own.toml\"\nangle_random_walk_deg_sqrt_h = 0.5");
    let missing = struna::scenario::Scenario::parse(&text, &path)
        .expect_err("there is no such file")
        .to_string();
    assert!(missing.contains("`gyro.file`") && missing.contains("check the path"), "{missing}");
    std::fs::write(&own, format!("[gyro]\nname = \"own\"\nkind = \"fog\"\n{keys}\nbias = 1"))
        .expect("a small file");
    let broken = struna::scenario::Scenario::parse(&text, &path)
        .expect_err("there is no such key")
        .to_string();
    assert!(broken.contains("own.toml, line 8") && !broken.contains("x.toml"), "{broken}");
    std::fs::write(&own, format!("[gyro]\nname = \"own\"\nkind = \"fog\"\n{keys}\n"))
        .expect("a small file");
    let gyro =
        struna::scenario::Scenario::parse(&text, &path).unwrap_or_else(|e| panic!("{e}")).gyro;
    assert!((gyro.angle_random_walk_rad_sqrt_s * 60.0 / RAD_PER_DEG - 0.5).abs() < 1e-15);
    assert_eq!(gyro.counts_max, exact.counts_max);
    let both = of("preset = \"vg910d\"\nfile = \"own.toml\"");
    refused_at(&both, "gyro.file", &["remove one of the two"]);
}

#[test]
fn surroundings_become_si() {
    let text = "[gyro.surroundings]\ntemperature_deg_c = 20\ntemperature_deg_c_min = 3\n\
                magnetic_field_gauss = 0.5";
    let expected = Surroundings {
        temperature_deg_c: 20.0,
        temperature_rate_deg_c_s: 0.05,
        magnetic_field_t: 0.5e-4,
    };
    assert_eq!(parse(&and(text)).surroundings, expected);
    let unknown = and("[gyro.surroundings]\ntemperature = 20");
    refused_at(&unknown, "gyro.surroundings.temperature", &["did you mean"]);
}

#[test]
fn the_backend_decides_which_integrator_keys_there_are() {
    let backend = |text: &str| model(&parse(text)).backend;
    assert_eq!(backend(&DEMO), Backend::Lagrange(Integrator::Rk4 { step_s: 1e-3 }));
    assert_eq!(backend(&with("backend", "")), backend(&DEMO), "the default");
    let rapier = with("backend", "backend = \"rapier\"");
    refused_at(&rapier, "body.integrator.method", &["rapier has one method"]);
    let no_method = rapier.replace("method = \"rk4\"", "# rapier's own");
    assert_eq!(backend(&no_method), Backend::Rapier { step_s: 1e-3 });
    let no_section = no_method.replace("[body.integrator]", "").replace("step_s = 1e-3", "");
    assert_eq!(backend(&no_section), Backend::Rapier { step_s: 2e-4 });
    let tolerance = no_method.replace("step_s = 1e-3", "relative_tolerance = 1e-9");
    refused_at(&tolerance, "body.integrator.relative_tolerance", &["use one of: step_s"]);
    refused_at(&with("backend", "backend = \"mujoco\""), "body.backend", &["\"rapier\""]);
    let finite = format!("{no_method}\n[body.string]\nlength_m = 2\n");
    let remedy = "choose backend = \"lagrange\"";
    refused_at(&finite, "body.string.length_m", &["rapier cannot do this", remedy]);
}

const VIBRATION: &str = "[[body.support.vibration]]\namplitude_m = [0, 0, 0]\n";
const YIELDING: &str = "[body.torsion.hysteresis]\nlaw = \"slip\"\n";

/// A section, what is wrong in it, the key at fault, and a part of the remedy.
const BAD_VALUES: [(&str, &str, &str, &str); 16] = [
    ("[environment]\n", "latitude_deg = 91", "environment.latitude_deg", "-9e1 to 9e1"),
    ("[body.string]\n", "length_m = 0", "body.string.length_m", "greater than 0"),
    ("[body.string]\n", "lenght_m = 1", "body.string.lenght_m", "did you mean `length_m`?"),
    (YIELDING, "stiffness_n_m_rad = []\n", "body.torsion.hysteresis.stiffness_n_m_rad", "1 to 4"),
    (
        YIELDING,
        "stiffness_n_m_rad = [1e-6, 1e-6]\nyield_deg = [25.0]",
        "body.torsion.hysteresis.yield_deg",
        "2 numbers, one for each stiffness",
    ),
    (
        YIELDING,
        "stiffness_n_m_rad = [1e-6]\nyield_deg = [-1]",
        "body.torsion.hysteresis.yield_deg[0]",
        "greater than 0",
    ),
    (
        "[body.torsion.hysteresis]\n",
        "law = \"bouc\"",
        "body.torsion.hysteresis.law",
        "\"slip\", \"dahl\"",
    ),
    ("[body.torsion.creep]\ntime_s = 1\n", "share = 1.1", "body.torsion.creep.share", "0e0 to 1e0"),
    ("[body.drag]\n", "translation_n_s_m = -1", "body.drag.translation_n_s_m", "0 or a greater"),
    (VIBRATION, "frequency_hz = 0", "body.support.vibration[0].frequency_hz", "greater than 0"),
    (
        "[[body.support.vibration]]\n",
        "amplitude_m = [1, 2]",
        "body.support.vibration[0].amplitude_m",
        "three numbers",
    ),
    (
        "[[body.support.clamp_swing]]\nfrequency_hz = 1\n",
        "amplitude_deg = inf",
        "body.support.clamp_swing[0].amplitude_deg",
        "a finite number",
    ),
    ("[body.disturbance]\n", "grid_hz = 1e9", "body.disturbance.grid_hz", "1e-3 to 1e5"),
    (
        "[body.disturbance]\n",
        "torque_noise_n_m_sqrt_hz = [0, -1, 0]",
        "body.disturbance.torque_noise_n_m_sqrt_hz[1]",
        "0 or a greater",
    ),
    (
        "[[body.disturbance.impulse]]\n",
        "time_s = -1",
        "body.disturbance.impulse[0].time_s",
        "0 or a greater",
    ),
    (
        "[gyro.mounting]\n",
        "misalignment_deg = [0, 60]",
        "gyro.mounting.misalignment_deg[1]",
        "-4.5e1 to 4.5e1",
    ),
];

#[test]
fn each_section_refuses_a_bad_value_at_its_line_and_key() {
    for (section, keys, key, part) in BAD_VALUES {
        refused_at(&and(&format!("{section}{keys}")), key, &[part]);
    }
    refused_at(&starting("rate_sigma_deg_s = -1"), "body.start.rate_sigma_deg_s", &["0 or a"]);
    refused_at(&starting("com_velocity_m_s = 1"), "body.start.com_velocity_m_s", &["an array"]);
    let sampled = with("preset", "preset = \"vg910d\"\nsampling = \"peak\"");
    refused_at(&sampled, "gyro.sampling", &["\"mean\", \"instantaneous\""]);
}

#[test]
fn what_only_the_whole_rig_can_refuse_is_refused_at_the_key_it_came_from() {
    let short = and("[body.string]\nlength_m = 0.05");
    refused_at(&short, "body.string.length_m", &["string_length_m = 0.05", "at least 0.1"]);
    // The swing of this body turns 9.9 rad/s.
    let long = with("step_s", "step_s = 0.06");
    refused_at(
        &long,
        "body.integrator.step_s",
        &["step_s = 0.06", "at most 0.050", "fastest mode"],
    );
    let shaken = and("[[body.support.vibration]]\namplitude_m = [0, 0, 0]\nfrequency_hz = 1e3");
    refused_at(&shaken, "body.integrator.step_s", &["step_s = 0.001", "at most 0.000079"]);
    let thrown = starting("body_rate_deg_s = [0, 0, 1e6]");
    refused_at(&thrown, "body.integrator.step_s", &["step_s = 0.001", "fastest mode"]);
    let dense = and("[body.disturbance]\ngrid_hz = 100\n[body.disturbance.random_impulses]\n\
                     rate_hz = 11\nangular_sigma_n_m_s = [0, 0, 0]");
    refused_at(&dense, "body.disturbance.random_impulses.rate_hz", &["at most 10"]);
    let impossible = and_in_body("products_of_inertia_kg_m2 = [0.02, 0, 0]");
    refused_at(&impossible, "body.products_of_inertia_kg_m2", &["principal"]);
    let aside = format!("{}\n[body.string]\nlength_m = 1", starting("suspension_m = [2, 0]"));
    refused_at(&aside, "body.start.suspension_m", &["a share of the string's length"]);
    refused_at(&starting("tilt_deg = 175"), "body.start.tilt_deg", &["upside down"]);
    refused_at(&starting("twist_deg = 1e9"), "body.start.twist_deg", &["resolves"]);
    let free = with("period_s", "stiffness_n_m_rad = 0");
    refused_at(&free, "body.torsion.damping_ratio", &["no critical damping"]);
    let fast = with("period_s", "period_s = 1e-200");
    refused_at(&fast, "body.torsion.period_s", &["infinite stiffness"]);
}

#[test]
fn a_recording_takes_neither_place_nor_mounting() {
    let text = include_str!("../../scenarios/recording.toml");
    for (section, key) in [
        ("[environment]\nlatitude_deg = 50", "environment"),
        ("[gyro.mounting]\nmisalignment_deg = [1, 0]", "gyro.mounting"),
    ] {
        let complaint = refusal(&format!("{text}\n{section}\n"));
        let line = text.lines().count() + 2;
        assert!(complaint.starts_with(&format!("folder/x.toml, line {line}, ")), "{complaint}");
        assert!(complaint.contains(&format!("`{key}`")) && complaint.contains("remove ["));
    }
}

#[test]
fn the_seed_of_the_run_decides_everything_random_about_the_motion() {
    let noise = "[body.disturbance]\ntorque_noise_n_m_sqrt_hz = [1e-6, 1e-6, 1e-6]";
    let blows = "[body.disturbance.random_impulses]\nrate_hz = 20\n\
                 angular_sigma_n_m_s = [1e-6, 1e-6, 1e-6]";
    let missed = starting("twist_sigma_deg = 1\ntilt_sigma_deg = 1\nrate_sigma_deg_s = 1");
    for text in [and(noise), and(blows), missed] {
        // As `--seed` does: the scenario is read, then given another seed.
        let end_with = |seed: u64| {
            let mut scenario = parse(&text);
            scenario.seed = Seed(seed);
            let mut source = session::motion_source(&scenario).unwrap_or_else(|e| panic!("{e}"));
            let end = source.reference_at(SimTime::from_ns(1_000_000_000));
            end.unwrap_or_else(|e| panic!("{e}"))
        };
        assert_eq!(end_with(1), end_with(1));
        assert_ne!(end_with(1).twist_rad, end_with(2).twist_rad, "{text}");
    }
    // And the seed in the file is the one that counts without.
    let text = and(noise);
    let (one, two) = (parse(&text), parse(&text.replacen("seed = 1", "seed = 2", 1)));
    assert_eq!((one.seed, two.seed), (Seed(1), Seed(2)));
    assert_ne!(motion_of(model(&one), one.seed), motion_of(model(&two), two.seed));
}

#[test]
fn a_run_carries_mounting_sampling_and_the_earth_to_the_decoded_rate() {
    let mounted = "[gyro.mounting]\nmisalignment_deg = [-5, 0]\n[environment]\nlatitude_deg = 60";
    let mut scenario = parse(&and(mounted));
    scenario.duration = SimTime::from_ns(1_000_000_000);
    scenario.averaging_samples = 1;
    scenario.estimators.truncate(1);
    let gyro = scenario.gyro.without_errors();
    let half_a_count_rad_s = 0.5 * gyro.lsb_rad_s + 1e-15;
    let half_a_sample_s = 0.5 / gyro.sample_rate_hz;
    // Torsion alone: one turn at (2π/480)² of it per s²; the damping takes 3e-4 of that away.
    let acceleration_rad_s2 = -std::f64::consts::TAU.powi(3) / 480.0_f64.powi(2);
    for (sampling, lag_s) in [(Sampling::Instantaneous, 0.0), (Sampling::Mean, half_a_sample_s)] {
        scenario.gyro = GyroParams { sampling, ..gyro };
        let record = run(&scenario).record;
        let column = |name: &str| record.column(name).expect("a column of every record");
        let (measured, body) = (column("measured_rate_rad_s"), column("truth.body_rate_rad_s"));
        let input = column("truth.input_rate_rad_s");
        assert_eq!(measured.len(), 300);
        for k in 0..300 {
            // 3.4 counts of lag, of which the damping moves a hundredth.
            let expected = input[k] - acceleration_rad_s2 * lag_s;
            assert!((measured[k] - expected).abs() < 1.1 * half_a_count_rad_s, "{sampling:?}, {k}");
            // The axis leans to the north, which starts as y and turns away by at most 0.03 deg.
            let lean_rad = 5.0 * RAD_PER_DEG;
            let earth_rad_s = EARTH_RATE_RAD_S * (60.0 * RAD_PER_DEG + lean_rad).sin();
            let seen_rad_s = body[k] * lean_rad.cos() + earth_rad_s;
            assert!((input[k] - seen_rad_s).abs() < 1e-3 * EARTH_RATE_RAD_S, "{k}");
        }
    }
}

/// Keys that a section understands, as its refusal of an unknown one lists them.
fn known_keys(text: &str) -> Vec<String> {
    let complaint = refusal(text);
    let (_, known) = complaint.split_once("use one of: ").unwrap_or_else(|| panic!("{complaint}"));
    known.split(", ").map(str::to_owned).collect()
}

#[test]
fn the_page_on_scenarios_knows_every_section_and_key() {
    let page = include_str!("../../docs/scenarios.md");
    let rig = include_str!("../../scenarios/rig.toml");
    let headers: Vec<_> = rig.lines().filter(|line| line.starts_with('[')).collect();
    assert!(headers.len() > 20, "{headers:?}");
    for header in headers {
        let text = rig.replacen(&format!("\n{header}"), &format!("\n{header}\nzzz = 1"), 1);
        let section = header.trim_matches(['[', ']']);
        for key in known_keys(&text) {
            let below = page.contains(&format!("`[{section}.{key}]`"))
                || page.contains(&format!("`[[{section}.{key}]]`"));
            let (_, name) = section.rsplit_once('.').unwrap_or(("", section));
            let written = [format!("`{key}`"), format!("`{name}.{key}`")];
            let listed = written.iter().any(|written| page.contains(written.as_str()));
            assert!(below || listed, "{header} {key}");
        }
        assert!(page.contains(&format!("`{header}`")), "{header}");
    }
}
