//! Presets: what ships is sound and says where it comes from, what is broken is refused in place.

use super::*;
use crate::datasheet::{rad_s_from_deg_h, rad_s_from_deg_s};
use proptest::prelude::*;
use struna_kernel::RAD_PER_DEG;

const OWN: &str = "[gyro]\nname = \"own\"\nkind = \"fog\"\nsample_rate_hz = 100\n\
                   rate_max_deg_s = 100\nlsb_deg_s = 0.01\ncounts_bits = 16\n";

fn refusal(text: &str) -> String {
    match read(text) {
        Ok(_) => format!("accepted: {text}"),
        Err(error) => error.to_string(),
    }
}

/// One and the other are the same but for some roundings.
fn alike(one: f64, other: f64) -> bool {
    (one - other).abs() <= 8.0 * f64::EPSILON * other.abs()
}

#[test]
fn every_parameter_of_a_shipped_preset_says_where_it_comes_from() {
    for name in NAMES {
        let preset = named(name).unwrap();
        assert_eq!(preset.name, name);
        preset.params.validate().unwrap();
        assert!(preset.entries.len() > 20, "{name}");
        for entry in &preset.entries {
            assert_ne!(entry.provenance, Provenance::Given, "{name}: {}", entry.key);
            assert!(entry.key.ends_with("damping_ratio") || !entry.value.is_empty());
        }
        let of = |key: &str| preset.entries.iter().find(|entry| entry.key == key).unwrap();
        assert_eq!(of("rate_max_deg_s").provenance, Provenance::Published);
        assert_eq!(of("bandwidth_hz").provenance, Provenance::Unverified);
    }
    assert!(named("vg910").is_none());
}

#[test]
fn the_presets_hold_what_their_sources_say() {
    let (vg, adis) = (vg910d(), adis16100());
    assert_eq!(vg.counts_at_range(), 6_553_600);
    assert_eq!(adis.counts_at_range(), 1230);
    assert_eq!((vg.counts_max, adis.counts_max), ((1 << 23) - 1, 2047));
    // Two units for one value: 0.00117 and 0.035 deg/s/sqrt(Hz), both two-sided.
    let walk = |params: &GyroParams| params.angle_random_walk_rad_sqrt_s / RAD_PER_DEG;
    assert!(alike(walk(&vg), 0.07 / 60.0));
    assert!(alike(walk(&adis), 0.05 / 2.0_f64.sqrt()));
    assert!((60.0 * walk(&adis) - 2.1).abs() < 0.03);
    // 58 deg/h is 0.016 deg/s, the turn-on bias 2 deg/s, the temperature's 0.05 deg/s/degC.
    assert!((adis.drift.bias_instability_rad_s / RAD_PER_DEG - 0.016).abs() < 2e-4);
    assert!(alike(adis.turn_on_bias_sigma_rad_s, rad_s_from_deg_s(2.0)));
    assert!(alike(adis.bias_effects.per_deg_c_rad_s, rad_s_from_deg_s(0.05)));
    assert!(alike(adis.response.delay_s, 1.0 / 1400.0));
    assert!(adis.response.noise_before_filter && !vg.response.noise_before_filter);
    assert!(alike(vg.scale.turn_on_sigma, 0.002));
    assert!(alike(vg.bias_effects.warm_up_rad_s, rad_s_from_deg_h(10.0)));
}

#[test]
fn every_unit_becomes_si() {
    let with = |key: &str, value: f64| {
        let mut params = read(&format!("{OWN}{key} = {value}\n")).unwrap().params;
        let place = NUMBERS.iter().find(|number| number.name == key).unwrap().place;
        *place(&mut params)
    };
    let (deg, hour) = (RAD_PER_DEG, 3600.0_f64);
    for (key, value, si) in [
        ("rate_random_walk_deg_h_sqrt_h", 2.0, 2.0 * deg / hour / hour.sqrt()),
        ("rate_ramp_deg_h_h", 3.0, 3.0 * deg / hour / hour),
        // 10 deg/h for each deg/min: 600 deg/h for each deg/s.
        ("bias_deg_h_deg_c_min", 10.0, 600.0 * deg / hour),
        ("magnetic_deg_h_gauss", 1.0, 1e4 * deg / hour),
        ("g_sensitivity_y_deg_s_g", 0.2, 0.2 * deg / 9.80665),
        ("delay_ms", 2.25, 2.25e-3),
        ("nonlinearity_percent_fs", 0.1, 1e-3),
        ("scale_percent_deg_c", 0.05, 5e-4),
        ("clock_offset_ppm", 20_000.0, 0.02),
        ("clock_drift_ppm_h", 36.0, 1e-8),
        ("clock_jitter_us", 5.0, 5e-6),
        ("angle_random_walk_deg_sqrt_h", 0.07, 0.07 * deg / 60.0),
        ("bias_correlation_s", 300.0, 300.0),
    ] {
        let got = with(key, value);
        assert!(alike(got, si), "{key}: {got} {si}");
    }
}

#[test]
fn no_two_keys_share_a_name_or_but_for_the_density_a_place() {
    let keys: Vec<_> = parameter_keys().collect();
    for (k, key) in keys.iter().enumerate() {
        assert!(!keys[..k].contains(key), "{key} twice");
    }
    let mut params = GyroParams::exact(0.0, 0.0, 0.0, 0);
    for (k, key) in NUMBERS.iter().enumerate() {
        let mark = 1e6 + k as f64;
        *(key.place)(&mut params) = mark;
        for earlier in &NUMBERS[..k] {
            let shared = (earlier.place)(&mut params).to_bits() == mark.to_bits();
            let known = [earlier.name, key.name] == [WALK, DENSITY];
            assert!(!shared || known, "{} and {}", earlier.name, key.name);
        }
    }
}

#[test]
fn a_density_is_one_sided_or_two_sided_but_never_a_guess() {
    let density = |sided: &str| format!("{OWN}noise_density_deg_s_sqrt_hz = 0.05\n{sided}");
    let walk = |text: &str| read(text).unwrap().params.angle_random_walk_rad_sqrt_s;
    let two = walk(&density("noise_density_sided = 2"));
    assert!(alike(two, rad_s_from_deg_s(0.05)));
    assert!(alike(walk(&density("noise_density_sided = 1")), two / 2.0_f64.sqrt()));
    assert!(refusal(&density("")).contains("noise_density_sided = 1"));
    let twice = density("noise_density_sided = 1\nangle_random_walk_deg_sqrt_h = 1\n");
    assert!(refusal(&twice).contains("remove one of the two"), "{}", refusal(&twice));
    let alone = refusal(&format!("{OWN}noise_density_sided = 1"));
    assert!(alone.contains("there is no `noise_density_deg_s_sqrt_hz`"), "{alone}");
}

#[test]
fn a_key_replaces_what_a_preset_says_and_is_marked_as_given() {
    let text = "bias_deg_h = 3\nangle_random_walk_deg_sqrt_h = 0.5\nother = 1";
    let adis = named("adis16100").unwrap();
    let own = struna_settings::read(text, |root| adis.clone().with(root)).unwrap();
    assert!(alike(own.params.bias_rad_s, rad_s_from_deg_h(3.0)));
    assert!(alike(own.params.angle_random_walk_rad_sqrt_s, 0.5 * RAD_PER_DEG / 60.0));
    let given: Vec<_> =
        own.entries.iter().filter(|e| e.provenance == Provenance::Given).map(|e| e.key).collect();
    assert_eq!(given, ["angle_random_walk_deg_sqrt_h", "bias_deg_h"]);
    // The density that the walk replaces is not shown beside it.
    assert!(own.entries.iter().all(|entry| entry.key != DENSITY && entry.key != SIDED));
    assert_eq!(own.params.scale, adis.params.scale);
}

#[test]
fn refusals_name_line_key_value_and_remedy() {
    for (line, parts) in [
        ("bandwith_hz = 40", ["`gyro.bandwith_hz`", "did you mean `bandwidth_hz`?"]),
        ("bandwidth_hz = -1", ["line 8", "0 or a greater"]),
        ("bias_deg_h = nan", ["`gyro.bias_deg_h` = nan", "finite"]),
        ("bias_deg_h = \"3\"", ["`gyro.bias_deg_h`", "a decimal number"]),
        ("bias_deg_h = { value = 3 }", ["gyro.bias_deg_h.provenance", "missing"]),
        ("bias_deg_h = { value = 3, provenance = \"heard\" }", ["provenance", "unverified"]),
        ("bias_deg_h = { value = 3, source = \"x\" }", ["bias_deg_h.source", "no such key"]),
        ("clock_offset_ppm = 2e5", ["clock_offset_ppm", "-1e5 to 1e5"]),
        ("output = \"angel\"", ["`gyro.output`", "did you mean `angle`?"]),
        ("delay_ms = 1e9", ["response.delay_s * sample_rate_hz", "at most 250"]),
        ("nonlinearity_percent_fs = 22", ["|linearity.nonlinearity|", "0.2105"]),
    ] {
        let text = refusal(&format!("{OWN}{line}\n"));
        assert!(parts.iter().all(|part| text.contains(part)), "{line}: {text}");
    }
    let mems = OWN.replace("fog", "mems");
    assert!(refusal(&format!("{mems}fold_back = true")).contains("kind = \"fog\""));
    for key in REQUIRED.iter().chain(&["name", "kind"]) {
        let line = OWN.lines().find(|line| line.starts_with(key)).unwrap();
        let text = refusal(&OWN.replace(line, ""));
        assert!(text.contains(&format!("gyro.{key}")) && text.contains("missing"), "{text}");
    }
    assert!(refusal(&OWN.replace("own", "")).contains("a name of up to"));
    assert!(refusal(&OWN.replace("= 16", "= 13")).contains("exceeds the output code"));
}

#[test]
fn a_provenance_is_printed_in_the_word_that_is_read() {
    for (word, provenance) in PROVENANCES {
        assert_eq!(provenance.to_string(), word);
    }
}

proptest! {
    #[test]
    fn no_damage_to_a_preset_makes_it_panic(
        at in any::<prop::sample::Index>(),
        removed in 0_usize..40,
        inserted in "[\\[\\]{}\"=.,#a-z0-9 \\-\n]{0,12}",
    ) {
        let text = SHIPPED[1].1;
        let start = at.index(text.len());
        let end = (start + removed).min(text.len());
        if let Ok(preset) = read(&[&text[..start], &inserted, &text[end..]].concat()) {
            prop_assert!(preset.params.validate().is_ok());
        }
    }
}
