//! `struna characterize`: what it finds in files of rates, and which files it refuses.

use crate::desk::{Desk, names};
use serde_json::Value;
use std::fmt::Write;
use struna_kernel::{Channel, RandomStream, Seed};

const RATE_HZ: f64 = 100.0;
const SIGMA_DEG_S: f64 = 0.02;
/// N of such samples, deg/sqrt(h).
const WALK_DEG_SQRT_H: f64 = 60.0 * SIGMA_DEG_S / 10.0;

/// White rates about an offset, deg/s.
fn white(samples: usize) -> impl Iterator<Item = f64> {
    // Any channel does; it only keys the stream.
    let mut stream = RandomStream::new(Seed(11), Channel::GyroAngleRandomWalk, 0);
    std::iter::repeat_with(move || 0.5 + SIGMA_DEG_S * stream.standard_normal()).take(samples)
}

/// A file of white rates with a number and a time for each, less those that `keep` drops.
fn rest_csv(samples: usize, keep: impl Fn(usize) -> bool) -> String {
    let mut text = "n,time,rate_deg_s\n".to_owned();
    for (k, rate) in white(samples).enumerate().filter(|(k, _)| keep(*k)) {
        let time_s = k as f64 / RATE_HZ;
        let _ = writeln!(text, "{k},{time_s},{rate}");
    }
    text
}

fn desk_with_rest(samples: usize) -> Desk {
    let desk = Desk::new();
    desk.write("rest.csv", rest_csv(samples, |_| true));
    desk
}

fn json(desk: &Desk, name: &str) -> Value {
    serde_json::from_str(&desk.text(name)).expect("JSON")
}

fn numbers(values: &Value) -> Vec<f64> {
    values.as_array().expect("a list").iter().map(|v| v.as_f64().expect("a number")).collect()
}

#[test]
fn ten_minutes_of_white_noise_are_characterized_in_every_form() {
    let desk = desk_with_rest(60_000);
    let said = desk.done(&[
        "characterize",
        "rest.csv",
        "--json",
        "r.json",
        "--figure",
        "r.svg",
        "--preset",
        "r.toml",
        "--name",
        "bench \"7\"",
        "--averaging",
        "25",
        "--overbound",
    ]);
    names(&said, &["bench \\\"7\\\": 60000 samples at 100 Hz, 10.0 min"]);
    names(&said, &["tau, s", "ADEV, deg/h", "95 % interval", "few averages, not used"]);
    names(&said, &["N  angle random walk  0.1", "deg/sqrt(h), between 0.1"]);
    names(&said, &["B  bias instability   at most", "deg/h; not identifiable"]);
    names(&said, &["K  rate random walk   no answer", "record 15 min without loss"]);
    names(&said, &["averaging 25 samples divides sigma by sqrt(25)"]);
    names(&said, &["written: r.json, r.svg, r.toml"]);
    let report = json(&desk, "r.json");
    assert_eq!(report["schema"], "struna.characterize/1");
    assert_eq!(report["samples"], 60_000);
    assert_eq!((&report["lost_samples"], &report["gaps"]), (&0.into(), &0.into()));
    let walk = &report["coefficients"]["angle_random_walk_deg_sqrt_h"];
    let [value, low, high] =
        ["value", "ci_low", "ci_high"].map(|key| walk[key].as_f64().expect("a number"));
    assert_eq!(walk["verdict"], "estimated");
    // 60 000 samples know N to some 0.4 %.
    assert!((value / WALK_DEG_SQRT_H - 1.0).abs() < 0.01, "{value}");
    assert!(low < WALK_DEG_SQRT_H && WALK_DEG_SQRT_H < high, "{low} to {high}");
    assert_eq!(report["coefficients"]["rate_ramp_deg_h_h"]["verdict"], "refused");
    let bounded = &report["coefficients"]["bias_instability_deg_h"];
    assert!(bounded["at_most"].as_f64().expect("a bound") > 0.0 && bounded["value"].is_null());
    the_curve_is_that_of_white_noise(&report);
    let lab = &report["lab2008"]["averaged"];
    let sigma = lab["sigma_deg_s"].as_f64().expect("a deviation");
    assert_eq!((&lab["averaging"], &lab["averages"]), (&25.into(), &2400.into()));
    // 2400 averages know their deviation to 1.5 %.
    assert!((sigma * 5.0 / SIGMA_DEG_S - 1.0).abs() < 0.06, "{sigma}");
    let printed = lab["printed_sigma2_deg2_s2"].as_f64().expect("a variance");
    assert!(printed > 8.0 * sigma * sigma, "half of a range is no deviation");
    let figure = desk.text("r.svg");
    assert!(figure.starts_with("<svg") && figure.trim_end().ends_with("</svg>"));
    names(&figure, &["N, slope -1/2"]);
    names(&figure, &["bound above the interval"]);
}

fn the_curve_is_that_of_white_noise(report: &Value) {
    let [taus_s, adev, low, high] =
        ["taus_s", "adev_deg_h", "ci_low_deg_h", "ci_high_deg_h"].map(|key| numbers(&report[key]));
    // The sample rate comes from the column of times, whose last digits are rounded.
    assert!((taus_s[0] - 0.01).abs() < 1e-13, "{}", taus_s[0]);
    assert_eq!(taus_s.len(), report["trusted"].as_array().expect("a list").len());
    let truth = |tau_s: f64| 60.0 * WALK_DEG_SQRT_H / tau_s.sqrt();
    let held = (0..taus_s.len()).filter(|k| (low[*k]..high[*k]).contains(&truth(taus_s[*k])));
    // 95 % of some forty points, which hang together.
    assert!(held.count() * 10 > taus_s.len() * 7);
    assert!((0..taus_s.len()).all(|k| low[k] < adev[k] && adev[k] < high[k]));
    assert_eq!(report["trusted"][0], true);
    assert_eq!(report["trusted"][taus_s.len() - 1], false);
}

#[test]
fn a_preset_of_what_was_found_is_toml_with_provenance() {
    let desk = desk_with_rest(20_000);
    desk.done(&["characterize", "rest.csv", "--bandwidth-hz", "45", "--preset", "r.toml"]);
    let preset: toml::Table = desk.text("r.toml").parse().expect("TOML");
    let gyro = preset["gyro"].as_table().expect("a table");
    assert_eq!(gyro["name"].as_str(), Some("rest"));
    let of = |key: &str| {
        let entry = gyro[key].as_table().expect("a table");
        (entry["value"].as_float().expect("a number"), entry["provenance"].as_str().expect("text"))
    };
    let (rate_hz, provenance) = of("sample_rate_hz");
    assert!((rate_hz - 100.0).abs() < 1e-6 && provenance == "measured");
    assert_eq!(of("bandwidth_hz"), (45.0, "given"));
    let (walk, provenance) = of("angle_random_walk_deg_sqrt_h");
    assert!((walk / WALK_DEG_SQRT_H - 1.0).abs() < 0.03 && provenance == "measured", "{walk}");
    // What was not found is no value.
    assert!(gyro.get("rate_random_walk_deg_h_sqrt_h").is_none());
    names(&desk.text("r.toml"), &["# rate_random_walk_deg_h_sqrt_h: the record supports"]);
}

#[test]
fn a_record_of_motion_gets_no_coefficient_and_one_reason() {
    let desk = Desk::new();
    let mut text = "time,rate_deg_s\n".to_owned();
    for (k, rate) in white(6_000).enumerate() {
        let time_s = k as f64 / RATE_HZ;
        let _ = writeln!(text, "{time_s},{}", rate + 30.0 * (5.0 * time_s).sin());
    }
    desk.write("moved.csv", text);
    let said = desk.done(&["characterize", "moved.csv"]);
    names(&said, &["no coefficient: the curve misses every sum", "moved or was vibrated"]);
    assert_eq!(said.matches("the curve misses").count(), 1, "{said}");
    names(&said, &["averaging 10 samples does not divide sigma by sqrt(10)"]);
}

#[test]
fn the_record_of_a_run_needs_no_options() {
    let scenario = include_str!("../../scenarios/demo.toml");
    let desk = Desk::with_scenario(scenario, &[("twist_deg = 360.0", "twist_deg = 0.0")]);
    desk.done(&["run", "s.toml", "--out", "out"]);
    let said = desk.done(&["characterize", "out/record.csv"]);
    // 300 Hz in averages of three, and 0.07 deg/sqrt(h) of the preset.
    names(&said, &["record: ", "samples at 100 Hz", "N  angle random walk  0.0", "deg/sqrt(h)"]);
}

#[test]
fn losses_are_known_by_time_by_number_or_by_holes() {
    let desk = desk_with_rest(30_000);
    let kept = |k: usize| !(10_000..10_040).contains(&k) && k != 20_000;
    desk.write("lossy.csv", rest_csv(30_000, kept));
    let mut holes = "rate_deg_s,x\n".to_owned();
    for (k, rate) in white(30_000).enumerate() {
        let cell = if kept(k) { rate.to_string() } else { String::new() };
        let _ = writeln!(holes, "{cell},1");
    }
    desk.write("holes.csv", holes);
    let rate = ["--sample-rate", "100"];
    let by_time = desk.done(&["characterize", "lossy.csv", "--name", "x"]);
    let index = ["characterize", "lossy.csv", "--name", "x", "--index-column", "n"];
    let by_number = desk.done(&[&index[..], &rate].concat());
    let by_holes = desk.done(&[&["characterize", "holes.csv", "--name", "x"][..], &rate].concat());
    names(&by_time, &["41 samples lost in 2 gaps", "the longest stretch is 100 s"]);
    assert_eq!(by_time, by_number);
    assert_eq!(by_time, by_holes);
}

#[test]
fn units_scale_and_octaves_thin() {
    let desk = desk_with_rest(6_000);
    let text = desk.text("rest.csv");
    desk.write("other.csv", text.replacen("rate_deg_s", "\"omega, z\"", 1));
    let found = |unit: &str| {
        let columns = ["characterize", "other.csv", "--rate-column", "omega, z", "--unit", unit];
        desk.done(&[&columns[..], &["--octaves", "--json", "r.json"]].concat());
        json(&desk, "r.json")
    };
    let (deg_s, deg_h, rad_s) = (found("deg/s"), found("deg/h"), found("rad/s"));
    let first = |report: &Value| numbers(&report["adev_deg_h"])[0];
    // One product and one quotient more.
    let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-12;
    assert!(close(first(&deg_s) / first(&deg_h), 3600.0));
    assert!(close(first(&rad_s) / first(&deg_s), 180.0 / std::f64::consts::PI));
    let taus_s = numbers(&deg_s["taus_s"]);
    assert!(taus_s.windows(2).all(|pair| close(pair[1] / pair[0], 2.0)), "{taus_s:?}");
}

#[test]
fn one_record_writes_the_same_bytes_each_time() {
    let desk = desk_with_rest(6_000);
    let files = ["--json", "a.json", "--figure", "a.svg", "--preset", "a.toml"];
    let once = desk.done(&[&["characterize", "rest.csv"][..], &files].concat());
    let before = ["a.json", "a.svg", "a.toml"].map(|name| desk.text(name));
    assert_eq!(desk.done(&[&["characterize", "rest.csv"][..], &files].concat()), once);
    assert_eq!(["a.json", "a.svg", "a.toml"].map(|name| desk.text(name)), before);
}

/// The complaint about a file of this content.
#[track_caller]
fn complains(content: impl AsRef<[u8]>, options: &[&str], parts: &[&str]) {
    let desk = Desk::new();
    desk.write("bad.csv", content);
    let arguments = [&["characterize", "bad.csv", "--json", "out.json"][..], options].concat();
    names(&desk.refused(&arguments), parts);
}

#[test]
fn a_file_that_is_none_is_refused() {
    let desk = Desk::new();
    let missing = desk.refused(&["characterize", "nowhere.csv"]);
    names(&missing, &["nowhere.csv", "No such file", "check the path"]);
    names(&desk.refused(&["characterize", "."]), &["is not a file", "name a CSV"]);
    names(&desk.refused(&["characterize", "/dev/zero"]), &["is not a file"]);
    complains("", &[], &["bad.csv ends at line 0 without a header"]);
    complains("time,rate_deg_s\n", &[], &["bad.csv ends at line 1 without rows"]);
    complains(b"time,rate_deg_s\n0,\xff\n", &[], &["bad.csv, line 2: not UTF-8"]);
    let endless = format!("time,rate_deg_s\n0,{}\n", "1".repeat(100_000));
    complains(endless, &[], &["line 2: longer than 65536 bytes"]);
}

#[test]
fn a_column_that_is_not_there_is_refused_with_those_that_are() {
    let text = "time,z\n0,1\n";
    complains(text, &["--rate-column", "x"], &["bad.csv has no column 'x'", "time, z"]);
    let time = ["--rate-column", "z", "--unit", "deg/s", "--time-column", "t"];
    complains(text, &time, &["no column 't'", "time, z"]);
    complains(text, &[], &["no column of bad.csv is known to be a rate", "--rate-column: time, z"]);
    complains("time,z,z\n0,1,2\n", &["--rate-column", "z"], &["line 1: column 'z' is there twice"]);
}

#[test]
fn a_unit_or_rate_that_nobody_said_is_refused() {
    let text = "z\n1\n2\n";
    complains(text, &["--rate-column", "z"], &["column 'z' does not end in its unit", "--unit"]);
    let column = ["--rate-column", "z", "--unit", "mdps"];
    complains(text, &column, &["--unit: 'mdps' is no unit", "deg/s, rad/s or deg/h"]);
    let column = ["--rate-column", "z", "--unit", "deg/s"];
    complains(
        text,
        &column,
        &["the sample rate is not known", "--sample-rate HZ", "--time-column"],
    );
    let rates = "time,rate_deg_s\n0,1\n0.01,2\n0.02,1\n";
    let claim = ["--sample-rate", "300"];
    complains(rates, &claim, &["'time' has 100.0", "--sample-rate says 300", "leave the option"]);
    let none = [&column[..], &["--sample-rate", "0"]].concat();
    complains(text, &none, &["bad.csv: a sample rate of 0 Hz is none"]);
}

#[test]
fn a_cell_that_is_no_number_is_refused_by_line_column_and_value() {
    let remedy = "repair or remove the line";
    complains(
        "time,rate_deg_s\n0,1\n1,2O\n",
        &[],
        &["line 3: '2O' in column 'rate_deg_s'", remedy],
    );
    complains("time,rate_deg_s\n0,1\n1,inf\n", &[], &["line 3: 'inf' in column 'rate_deg_s'"]);
    complains("time,rate_deg_s\n0,1\n,2\n", &[], &["line 3: '' in column 'time'", remedy]);
    complains("time,rate_deg_s\n0,1\n1\n", &[], &["line 3: 1 values", "2 columns", remedy]);
    complains("time,rate_deg_s\n0,1\n0,2\n", &[], &["line 3: 0 in column 'time' is not above"]);
    // Lines are counted as an editor counts them, wherever they come from.
    let crlf = "# from\r\n\r\ntime,rate_deg_s\r\n0,1\r\n\r\n1,?\r\n";
    complains(crlf, &[], &["line 6: '?' in column 'rate_deg_s'"]);
}

#[test]
fn a_record_without_answer_is_refused() {
    complains("time,rate_deg_s\n0,1\n0.01,2\n0.02,1\n", &[], &["bad.csv: 3 samples", "54 are"]);
    let constant: String = (0..1000).map(|k| format!("{k},0.25\n")).collect();
    let constant = format!("time,rate_deg_s\n{constant}");
    complains(constant, &[], &["bad.csv: the rate does not change", "no noise"]);
    let rest = rest_csv(1000, |_| true);
    complains(&rest, &["--bandwidth-hz", "0.1"], &["band of 0.1 Hz hides", "record longer"]);
    complains(&rest, &["--bandwidth-hz", "-1"], &["a bandwidth of -1 Hz is none"]);
}

#[test]
fn nothing_is_written_where_a_folder_is_missing() {
    let desk = desk_with_rest(1000);
    let complaint = desk.refused(&["characterize", "rest.csv", "--json", "no/r.json"]);
    names(&complaint, &["cannot write no/r.json", "check that its folder exists"]);
}
