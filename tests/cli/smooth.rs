//! `struna smooth`: what it finds in a record, what it says of itself, and what it refuses.

use crate::desk::{DEMO, Desk, csv, edited, names};
use std::fmt::Write;
use struna_kernel::{Channel, RandomStream, Seed};

const NOISE_DEG_S: f64 = 0.02;
const BIAS_DEG_S: f64 = 0.035;
const PERIOD_S: f64 = 60.2;
const DAMPING: f64 = 0.02;
const STEP_S: f64 = 0.05;

/// Angle and rate of damped torsion let go at 95°, deg and deg/s.
fn torsion(time_s: f64) -> (f64, f64) {
    let omega = std::f64::consts::TAU / PERIOD_S;
    let (decay, beat) = (DAMPING * omega, omega * (1.0 - DAMPING * DAMPING).sqrt());
    let (sin, cos) = (beat * time_s).sin_cos();
    let fading = 95.0 * (-decay * time_s).exp();
    (fading * (cos + decay / beat * sin), -fading * omega * omega / beat * sin)
}

/// A record of two periods, with `more` added to the rate of each row, deg/s. Rates are means over
/// the step, as an averaged gyro has them.
fn record_csv(more: impl Fn(usize) -> f64) -> String {
    let mut stream = RandomStream::new(Seed(3), Channel::GyroAngleRandomWalk, 0);
    let mut text = "\"time\",\"measured_rate_rad_s\",\"over_range\",\"truth.twist_rad\",\
                    \"truth.body_rate_rad_s\"\n"
        .to_owned();
    for k in 1..=2_400 {
        let time_s = k as f64 * STEP_S;
        let (angle, rate) = torsion(time_s);
        let mean = (angle - torsion(time_s - STEP_S).0) / STEP_S;
        let measured = mean + BIAS_DEG_S + NOISE_DEG_S * stream.standard_normal() + more(k);
        let [measured, angle, rate] = [measured, angle, rate].map(f64::to_radians);
        let _ = writeln!(text, "{time_s},{measured},0,{angle},{rate}");
    }
    text
}

fn desk_with(more: impl Fn(usize) -> f64) -> Desk {
    let desk = Desk::new();
    desk.write("r.csv", record_csv(more));
    desk
}

/// `struna smooth r.csv` with what is known of the torsion, and more.
fn told<'a>(more: &[&'a str]) -> Vec<&'a str> {
    let known = ["smooth", "r.csv", "--out", "s", "--period-s", "60.5", "--angle-deg", "80"];
    let known = known.into_iter().chain(["--angle-sigma-deg", "30", "--rate-sigma-deg-s", "0.1"]);
    known.chain(more.iter().copied()).collect()
}

/// RMS of a method's angle error in `s/smoothed.csv`, deg, and its largest claimed sigma.
fn angle_error_deg(desk: &Desk, method: &str) -> (f64, f64) {
    let (header, rows) = csv(&desk.text("s/smoothed.csv"));
    let at = |name: &str| header.iter().position(|other| other == name).expect("a column");
    let (angle, truth) = (at(&format!("{method}.angle_rad")), at("truth.twist_rad"));
    let sigma = at(&format!("{method}.angle_sigma_rad"));
    let squares: f64 = rows.iter().map(|row| (row[angle] - row[truth]).powi(2)).sum();
    let largest = rows.iter().map(|row| row[sigma]).fold(0.0, f64::max);
    ((squares / rows.len() as f64).sqrt().to_degrees(), largest.to_degrees())
}

#[test]
fn undisturbed_torsion_is_fitted_and_scored() {
    let desk = desk_with(|_| 0.0);
    let said = desk.done(&told(&[]));
    names(&said, &["record   r.csv: 2400 rows to 120 s, 0 over range"]);
    names(&said, &["noise    0.0", "by the record's second differences", "method   map"]);
    names(&said, &["the residuals are the gyro's noise; chi-square", "2400 used, 0 rejected"]);
    names(&said, &["period   60.", "damping  0.0", "bias     0.03", "angle    9"]);
    names(&said, &["angle - twist, deg", "map", "written to s: smoothed.csv, figure.svg"]);
    let (rms, sigma) = angle_error_deg(&desk, "map");
    // Half a step of delay, taken for none, would be 0.25° at the largest rate.
    assert!(rms < 0.05 && rms < 3.0 * sigma, "{rms}° of {sigma}°");
    assert!(desk.text("s/figure.svg").contains("angle error and claimed 3 sigma, deg"));
    assert!(said.starts_with(&desk.text("s/report.txt")));
}

#[test]
fn each_method_can_be_asked_for() {
    let desk = desk_with(|_| 0.0);
    for method in ["map", "rts", "fixed-lag"] {
        let said = desk.done(&told(&["--method", method, "--lag-s", "20"]));
        names(&said, &[&format!("method   {method}")]);
        let (header, rows) = csv(&desk.text("s/smoothed.csv"));
        assert_eq!(rows.len(), 2_400, "{method}: a row for each row");
        assert!(header.contains(&format!("{method}.residual_rad_s")));
        let (rms, _) = angle_error_deg(&desk, method);
        // Without the future the start stays as uncertain as it was: 30°, for a lag's time.
        assert!(rms < if method == "fixed-lag" { 5.0 } else { 0.1 }, "{method}: {rms}°");
    }
}

#[test]
fn a_kick_is_found_at_its_row_or_where_it_is_given() {
    // A blow of 2.05 deg/s, and the motion that follows from it.
    let omega = std::f64::consts::TAU / PERIOD_S;
    let (decay, beat) = (DAMPING * omega, omega * (1.0 - DAMPING * DAMPING).sqrt());
    let after = |k: usize| {
        let since_s = (k as f64 - 1_200.5) * STEP_S;
        let (sin, cos) = (beat * since_s).sin_cos();
        let fading = 2.05 * (-decay * since_s).exp();
        if k > 1_200 { fading * (cos - decay / beat * sin) } else { 0.0 }
    };
    let desk = desk_with(after);
    let said = desk.done(&told(&["--method", "map"]));
    names(&said, &["kick     2.0", "deg/s at 60.0"]);
    let said = desk.done(&told(&["--method", "map", "--kicks-s", "60.0"]));
    names(&said, &["kick     2.0", "deg/s at 60.000 s"]);
    let outside = desk.refused(&told(&["--kicks-s", "500"]));
    names(&outside, &["a kick at 500 s is not in the record"]);
}

#[test]
fn a_record_that_holds_more_than_torsion_is_left_to_rts() {
    // A slow wander of the rate that no damped torsion makes.
    let desk = desk_with(|k| 0.3 * (0.013 * k as f64).sin());
    let said = desk.done(&told(&["--random-torque", "0.01"]));
    names(&said, &["method   rts", "not map: the record holds more than damped torsion"]);
    let said = desk.done(&told(&["--random-torque", "0.01", "--method", "map"]));
    names(&said, &["method   map", "trust    the record holds more", "trust rts"]);
}

#[test]
fn a_record_at_rest_is_refused_in_plain_words() {
    let mut stream = RandomStream::new(Seed(4), Channel::GyroAngleRandomWalk, 0);
    let mut text = "time,measured_rate_rad_s\n".to_owned();
    for k in 1..=2_000 {
        let _ = writeln!(text, "{},{}", f64::from(k) * 0.05, 1e-3 * stream.standard_normal());
    }
    let desk = Desk::new();
    desk.write("r.csv", text);
    let complaint = desk.refused(&told(&["--method", "map"]));
    names(&complaint, &["r.csv: period not identifiable from this record: no motion", "rts"]);
    let said = desk.done(&told(&[]));
    names(&said, &["method   rts", "not map: period not identifiable from this record: no motion"]);
}

#[test]
fn what_cannot_be_read_is_refused_with_its_place() {
    let desk = Desk::new();
    names(&desk.refused(&told(&[])), &["cannot read the record r.csv", "check the path"]);
    desk.write("r.csv", "time,rate\n0,1\n");
    names(&desk.refused(&told(&[])), &["r.csv has no column 'measured_rate_rad_s'"]);
    let good = record_csv(|_| 0.0);
    let lines: Vec<&str> = good.lines().collect();
    desk.write("r.csv", lines[..10].join("\n"));
    names(&desk.refused(&told(&[])), &["r.csv holds 9 rows", "at least 16"]);
    let mut broken = lines[..40].join("\n");
    broken.push_str("\n2.0,x,0,0,0\n");
    desk.write("r.csv", &broken);
    names(&desk.refused(&told(&[])), &["r.csv, line 41: 'x' in column 'measured_rate_rad_s'"]);
    let mut back = lines[..40].join("\n");
    back.push_str("\n0.5,0.0,0,0,0\n");
    desk.write("r.csv", &back);
    names(&desk.refused(&told(&[])), &["r.csv: sample 39 at", "span"]);
    desk.write("r.csv", &good);
    names(&desk.refused(&["smooth", "r.csv", "--out", "s"]), &["--period-s or --scenario"]);
    let long = told(&["--method", "fixed-lag", "--lag-s", "1e9"]);
    names(&desk.refused(&long), &["at most 360000", "--lag-s"]);
}

#[test]
fn a_run_is_smoothed_with_its_scenario() {
    let edits =
        [("duration_s = 480.0", "duration_s = 60.0"), ("\"fmi3\"      #", "\"in-process\" #")];
    let scenario = edited(DEMO, &edits).replace("run_as = \"fmi3\"", "run_as = \"in-process\"");
    let desk = Desk::new();
    desk.write("s.toml", scenario);
    desk.done(&["run", "s.toml", "--out", "out"]);
    let record = "out/record.csv";
    let said = desk.done(&["smooth", record, "--scenario", "s.toml", "--out", "s"]);
    names(&said, &["noise    0.01170 deg/s of one rate, by the scenario", "angle - int(r), deg"]);
    let (header, rows) = csv(&desk.text("s/smoothed.csv"));
    assert_eq!(rows.len(), csv(&desk.text(record)).1.len());
    assert!(header.contains(&"truth.body_rate_integral_rad".to_owned()));
    let told = desk.text("s.toml");
    let tables = told.split("[[estimator]]").filter(|table| !table.contains("torsion_period_s"));
    desk.write("n.toml", tables.collect::<Vec<_>>().join("[[estimator]]"));
    let complaint = desk.refused(&["smooth", record, "--scenario", "n.toml", "--out", "n"]);
    names(&complaint, &["n.toml has no [[estimator]]", "--period-s"]);
}
