//! What the help promises is written, and by a motion that stops as much of it as there is.

use crate::desk::{DEMO, Desk, csv, names, read_zip};
use std::collections::BTreeSet;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread;

const SWING: &str = include_str!("../../scenarios/swing.toml");

/// Exit code of a run that SIGINT ended.
const INTERRUPTED: i32 = 130;
/// Exit code of a motion that could not be carried to its end.
const STOPPED: i32 = 1;

#[test]
fn the_help_of_every_command_shows_an_example() {
    let desk = Desk::new();
    for (command, example) in [
        (&[][..], "struna demo"),
        (&["demo"], "\n  struna demo --out "),
        (&["run"], "\n  struna run scenarios/demo.toml"),
        (&["truth"], "\n  struna truth scenarios/swing.toml --csv truth.csv"),
        (&["compare"], "\n  struna compare lagrange.csv rapier.csv"),
        (&["fmu"], "\n  struna fmu list"),
        (&["fmu", "build"], "\n  struna fmu build --out "),
        (&["fmu", "list"], "\n  struna fmu list"),
        (&["gyro"], "\n  struna gyro list"),
        (&["gyro", "list"], "\n  struna gyro list"),
        (&["gyro", "show"], "\n  struna gyro show adis16100"),
    ] {
        let help = desk.done(&[command, &["--help"]].concat());
        assert!(help.contains(example), "{command:?}:\n{help}");
    }
}

#[test]
fn fmu_list_names_every_model_and_its_variables() {
    let list = Desk::new().done(&["fmu", "list"]);
    for word in [
        "PermanentRotation ",
        "TorsionalOscillation ",
        "AugmentedTorsion ",
        "HysteresisBank ",
        "LiveEstimator ",
        " measured_rate_rad_s ",
        " nis ",
        " status ",
    ] {
        assert!(list.contains(word), "{word:?} not in:\n{list}");
    }
    // A parameter of the one that knows it, an output of the three that learn it.
    assert_eq!(list.matches(" period_s ").count(), 4, "{list}");
}

#[test]
fn fmu_list_shows_kind_causality_unit_and_start_in_columns() {
    let list = Desk::new().done(&["fmu", "list"]);
    let shown: Vec<Vec<&str>> =
        list.lines().map(|line| line.split_whitespace().take(5).collect()).collect();
    for row in [
        "variable kind causality unit start",
        "time Float64 independent s -",
        "measured_rate_valid Boolean input 1 true",
        "angle_sigma_rad Float64 output rad -",
        "refinement_samples Int32 parameter 1 100",
        "period_s Float64 parameter s 480.0",
        "period_s Float64 output s -",
        "period_start_s Float64 parameter s 480.0",
        "innovation_test Boolean parameter 1 true",
        "status Int32 output 1 -",
    ] {
        let cells: Vec<_> = row.split(' ').collect();
        assert!(shown.contains(&cells), "{row:?} not in:\n{list}");
    }
    // In each model's table every kind starts where the heading says.
    let mut kind_column = 0;
    for line in list.lines() {
        let mut cells = line.split_whitespace();
        match (line.starts_with("  "), cells.nth(1)) {
            (true, Some("kind")) => kind_column = line.find("kind").unwrap(),
            (true, Some(kind)) => assert!(line[kind_column..].starts_with(kind), "{line}"),
            _ => {}
        }
    }
}

#[test]
fn gyro_list_and_show_print_the_presets_with_unit_and_provenance() {
    let desk = Desk::new();
    let list = desk.done(&["gyro", "list"]);
    for row in ["vg910d fog 300 Hz +-200 deg/s", "adis16100 mems 1400 Hz +-300 deg/s"] {
        let words: Vec<_> = row.split(' ').collect();
        let is_row = |line: &str| line.split_whitespace().take(6).eq(words.iter().copied());
        assert!(list.lines().any(is_row), "{row:?} not in:\n{list}");
    }
    let shown = desk.done(&["gyro", "show", "adis16100"]);
    for row in [
        "parameter value unit provenance note",
        "lsb_deg_s 0.24390243902439024 deg/s published 1230",
        "bandwidth_hz 40 Hz unverified second",
        "noise_density_sided 1 - derived data",
        "clock_offset_sigma_ppm 50 ppm invented a",
    ] {
        let words: Vec<_> = row.split(' ').collect();
        let is_row = |line: &str| line.split_whitespace().take(5).eq(words.iter().copied());
        assert!(shown.lines().any(is_row), "{row:?} not in:\n{shown}");
    }
    assert!(!shown.contains(" given"), "{shown}");
}

#[test]
fn fmu_list_ends_well_when_its_reader_has_seen_enough() {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let desk = Desk::new();
    let mut list = desk.command(&["fmu", "list"]);
    let ended = list.stdout(writer).stderr(Stdio::piped()).output().unwrap();
    assert!(ended.status.success() && ended.stderr.is_empty(), "{ended:?}");
}

const FMUS: [&str; 10] = [
    "AugmentedTorsion_fmi2.fmu",
    "AugmentedTorsion_fmi3.fmu",
    "HysteresisBank_fmi2.fmu",
    "HysteresisBank_fmi3.fmu",
    "LiveEstimator_fmi2.fmu",
    "LiveEstimator_fmi3.fmu",
    "PermanentRotation_fmi2.fmu",
    "PermanentRotation_fmi3.fmu",
    "TorsionalOscillation_fmi2.fmu",
    "TorsionalOscillation_fmi3.fmu",
];

#[test]
fn fmu_build_writes_every_model_for_both_versions() {
    let desk = Desk::new();
    let printed = desk.done(&["fmu", "build", "--out", "fmus"]);
    let expected: BTreeSet<String> = FMUS.iter().map(|name| format!("fmus/{name}")).collect();
    assert_eq!(desk.files(), expected);
    assert_eq!(printed.lines().map(str::to_owned).collect::<BTreeSet<_>>(), expected);
    for fmu in &expected {
        let entries = read_zip(&desk.path(fmu));
        assert!(entries.iter().any(|(name, _)| name == "modelDescription.xml"), "{fmu}");
    }
}

#[test]
fn truth_writes_the_motion_at_every_sample_instant() {
    let desk = Desk::with_scenario(SWING, &[]);
    let printed = desk.done(&["truth", "s.toml", "--csv", "truth.csv"]);
    assert!(printed.contains("601 instants") && printed.contains("truth.csv"), "{printed}");
    let text = desk.text("truth.csv");
    let head = "# struna truth\n# scenario: swing\n# backend: lagrange, rk4, step 0.001 s\n\
                # seed: 1\n# columns: SI units in the names; q_wb carries body components to \
                world\n\"time\",";
    assert!(text.starts_with(head), "{}", &text[..400]);
    assert_eq!(text.matches('#').count(), 5, "a motion that does not stop says nothing more");
    let (header, rows) = csv(&text);
    let columns = "time twist_rad twist_rate_rad_s body_rate_integral_rad omega_wb_b_x_rad_s \
                   omega_wb_b_y_rad_s omega_wb_b_z_rad_s q_wb_w q_wb_x q_wb_y q_wb_z com_w_x_m \
                   com_w_y_m com_w_z_m com_velocity_w_x_m_s com_velocity_w_y_m_s \
                   com_velocity_w_z_m_s input_rate_rad_s input_angle_rad";
    assert_eq!(header.join(" "), columns);
    // 2 s at 300 Hz, both ends included.
    assert_eq!(rows.len(), 601);
    assert!((rows[0][0], rows[300][0], rows[600][0]) == (0.0, 1.0, 2.0));
    for row in &rows {
        let norm = row[7..11].iter().map(|q| q * q).sum::<f64>().sqrt();
        // Normalised in double precision: a few roundings off one.
        assert!((norm - 1.0).abs() < 1e-14, "{norm}");
        // The gyro sits straight on the axis: what it feels is the body's rate, here and there.
        assert!(row[6].to_bits() == row[17].to_bits());
        assert!((row[18] - (row[3] - rows[0][3])).abs() < 1e-14);
    }
}

#[test]
fn one_seed_makes_one_truth_byte_for_byte_with_noise_and_blows_too() {
    let rig = include_str!("../../scenarios/rig.toml");
    let desk = Desk::with_scenario(rig, &[]);
    let truth = |seed: &str, name: &str| {
        let text = desk.text("s.toml");
        desk.write("seeded.toml", text.replacen("\nseed = 1", &format!("\nseed = {seed}"), 1));
        desk.done(&["truth", "seeded.toml", "--csv", name]);
        desk.text(name)
    };
    let (first, again, other) = (truth("1", "a.csv"), truth("1", "b.csv"), truth("2", "c.csv"));
    assert_eq!(first, again);
    let rows = |text: &str| text.lines().skip(6).map(str::to_owned).collect::<Vec<_>>();
    assert!(rows(&first)[1..] != rows(&other)[1..], "another seed, another path");
}

#[test]
fn a_run_writes_record_score_figure_and_fmus() {
    let desk = Desk::with_scenario(DEMO, &[]);
    let printed = desk.done(&["run", "s.toml", "--out", "results", "--seed", "7"]);
    let backend = "rapier, rapier3d-f64 0.36.1, step 0.001 s";
    names(
        &printed,
        &[
            "integration",
            "rotation",
            "torsion",
            "tested",
            backend,
            "600 frames sent, 600 received, 0 lost",
        ],
    );
    let written = ["record.csv", "score.json", "figure.svg"];
    names(&printed, &["written to results"]);
    let fmus = ["AugmentedTorsion", "PermanentRotation", "TorsionalOscillation"]
        .map(|model| format!("fmu/{model}_fmi3.fmu"));
    let mut expected: BTreeSet<String> = written
        .map(str::to_owned)
        .iter()
        .chain(&fmus)
        .map(|name| format!("results/{name}"))
        .collect();
    expected.insert("s.toml".to_owned());
    assert_eq!(desk.files(), expected);

    let (header, rows) = csv(&desk.text("results/record.csv"));
    assert_eq!((header[0].as_str(), rows.len()), ("time", 200));
    assert!(header.iter().any(|name| name == "torsion.angle_sigma_rad"), "{header:?}");
    let by_rapier = header.iter().position(|name| name == "truth.by_rapier").unwrap();
    assert!(rows.iter().all(|row| row[by_rapier].to_bits() == 1.0_f64.to_bits()));
    let score = score(&desk, "results/score.json");
    assert_eq!((&score["seed"], &score["interrupted"]), (&7.into(), &false.into()));
    assert_eq!((&score["backend"], &score["stopped"]), (&backend.into(), &().into()));
    assert_eq!(score["estimators"].as_array().map(Vec::len), Some(4));
    let figure = desk.text("results/figure.svg");
    assert!(figure.starts_with("<svg") && figure.trim_end().ends_with("</svg>"));
    names(&figure, &["demo: 2 s, seed 7, ", backend]);
}

/// A push that throws the body up: its string goes slack beyond the horizontal, and so ends the
/// motion, 20 gyro samples on.
const THROWN_UP: (&str, &str) = ("[0.0, 19.3, 0.0]", "[2000.0, 0.0, 0.0]");

#[test]
fn a_truth_that_stops_keeps_what_came_and_says_why() {
    let desk = Desk::with_scenario(SWING, &[THROWN_UP]);
    let output = desk.struna(&["truth", "s.toml", "--csv", "truth.csv"]);
    let complaint = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(STOPPED), "{complaint}");
    let reason = "at 0.064331719 s the string went slack";
    names(&complaint, &["struna: 20 instants written to truth.csv until the motion", reason]);
    assert_eq!(complaint.lines().count(), 1, "{complaint}");
    let text = desk.text("truth.csv");
    let last = text.lines().last().unwrap();
    assert!(last.starts_with(&format!("# stopped: {reason}")), "{last}");
    assert!(complaint.trim_end().ends_with(last.trim_start_matches("# stopped: ")), "{last}");
    let (_, rows) = csv(&text);
    assert_eq!((rows.len(), rows[19][0]), (20, 0.063333333));
}

#[test]
fn a_run_whose_motion_stops_keeps_what_came_and_says_why() {
    let desk = Desk::with_scenario(SWING, &[THROWN_UP]);
    let output = desk.struna(&["run", "s.toml", "--out", "out"]);
    let complaint = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(STOPPED), "{complaint}");
    let reason = "at 0.064331719 s the string went slack";
    names(&complaint, &["struna: recorded in out until the motion stopped: ", reason]);
    let printed = String::from_utf8(output.stdout).unwrap();
    names(&printed, &["19 frames sent, 19 received", "stopped at 0.06 s of 2 s", "written to out"]);
    let score = score(&desk, "out/score.json");
    assert!(score["stopped"].as_str().is_some_and(|stopped| stopped.starts_with(reason)));
    assert_eq!((&score["interrupted"], &score["rate_samples"]), (&false.into(), &6.into()));
    let (_, rows) = csv(&desk.text("out/record.csv"));
    assert_eq!((rows.len(), rows[5][0]), (6, 0.06));
    assert!(desk.text("out/figure.svg").starts_with("<svg"));
}

#[test]
fn a_motion_of_which_nothing_came_is_its_error_alone() {
    // Thrown up before the second frame is out, and a row takes three.
    let push = ("[0.0, 19.3, 0.0]", "[30000.0, 0.0, 0.0]");
    let desk = Desk::with_scenario(SWING, &[push, ("step_s = 1e-3", "step_s = 1e-4")]);
    let output = desk.struna(&["run", "s.toml", "--out", "out"]);
    let complaint = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(STOPPED), "{complaint}");
    assert!(complaint.starts_with("struna: at 0.00"), "{complaint}");
    assert!(output.stdout.is_empty());
    assert!(!desk.path("out/record.csv").exists() && !desk.path("out/score.json").exists());
}

fn score(desk: &Desk, name: &str) -> serde_json::Value {
    serde_json::from_str(&desk.text(name)).expect("score.json is JSON")
}

#[test]
fn results_go_to_a_folder_of_the_scenarios_name_unless_told_otherwise() {
    let desk = Desk::with_scenario(DEMO, &[("name = \"demo\"", "name = \"first.light\"")]);
    desk.done(&["run", "s.toml"]);
    assert!(desk.path("out/first.light/record.csv").is_file());
}

/// A running program that does not outlive its test.
struct Running(Child);

impl Running {
    /// Looks at the program until `is_so`, which must not take longer than the program lives.
    fn wait_for(&mut self, is_so: impl Fn(&Self) -> bool) {
        while !is_so(self) {
            assert_eq!(self.0.try_wait().expect("our child"), None, "ended by itself");
            thread::yield_now();
        }
    }

    fn proc(&self, name: &str) -> PathBuf {
        Path::new("/proc").join(self.0.id().to_string()).join(name)
    }

    fn has_line_open(&self) -> bool {
        let open = fs::read_dir(self.proc("fd")).expect("Linux lists what is open");
        // A descriptor may be closed while its turn comes.
        let targets = open.filter_map(|entry| fs::read_link(entry.ok()?.path()).ok());
        targets.into_iter().any(|target| target.ends_with("ptmx"))
    }

    fn bytes_written(&self) -> u64 {
        let io = fs::read_to_string(self.proc("io")).expect("Linux counts what is written");
        let written = io.lines().find_map(|line| line.strip_prefix("wchar: "));
        written.expect("a count").parse().expect("a number")
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // Fails when it has ended already, which is the aim.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn an_interrupted_run_keeps_what_came_until_then() {
    let desk = Desk::with_scenario(DEMO, &[("duration_s = 2.0", "duration_s = 1e6")]);
    let mut command = desk.command(&["run", "s.toml", "--out", "out", "--realtime"]);
    command.stdout(Stdio::piped()).stderr(Stdio::null());
    let mut running = Running(command.spawn().expect("the program starts"));
    // Once the line is open, frames are all that is written: 11 bytes each.
    running.wait_for(Running::has_line_open);
    let before = running.bytes_written();
    running.wait_for(|running| running.bytes_written() >= before + 300 * 11);
    // The standard library sends no signal but SIGKILL; every shell can.
    let kill = format!("kill -INT {}", running.0.id());
    assert!(Command::new("sh").args(["-c", &kill]).status().expect("a shell").success());
    let status = running.0.wait().expect("our child");
    assert_eq!(status.code(), Some(INTERRUPTED));

    let score = score(&desk, "out/score.json");
    assert_eq!(score["interrupted"], true);
    assert_eq!(score["duration_s"], 1e6);
    let (header, rows) = csv(&desk.text("out/record.csv"));
    assert_eq!(header[0], "time");
    assert_eq!(score["rate_samples"], rows.len());
    assert_eq!(score["recorded_until_s"], rows.last().expect("rows")[0]);
    let line = &score["line"];
    assert_eq!(line["frames_received"], line["frames_sent"]);
    // Three frames make one row.
    assert!(rows.len() >= 100 && line["frames_sent"].as_u64() >= Some(300), "{line}");
    assert!(desk.text("out/figure.svg").starts_with("<svg"));
    let mut said = String::new();
    running.0.stdout.take().expect("piped").read_to_string(&mut said).expect("UTF-8");
    names(&said, &["stopped at ", " of 1000000 s", "everything until then is recorded"]);
    assert!(desk.files().iter().all(|name| !name.ends_with(".tmp")), "{:?}", desk.files());
}
