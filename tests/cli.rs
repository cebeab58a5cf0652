//! The `struna` command as a person meets it: bad input is refused with place and remedy and leaves
//! no file behind, good input writes what the help promises.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use tempfile::TempDir;
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

const DEMO: &str = include_str!("../scenarios/demo.toml");
const SWING: &str = include_str!("../scenarios/swing.toml");
const RECORDING: &str = include_str!("../scenarios/recording.toml");
const FRAME: &str = include_str!("../frames/vg910d.toml");

/// Exit code of a refusal, and of a run that SIGINT ended.
const REFUSED: i32 = 1;
const INTERRUPTED: i32 = 130;

/// A folder of its own to work in, thrown away afterwards.
struct Desk {
    folder: TempDir,
}

impl Desk {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a temporary folder") }
    }

    /// A desk with `s.toml`: `text` cut to 2 s, then changed as `edits` say.
    fn with_scenario(text: &str, edits: &[(&str, &str)]) -> Self {
        let desk = Self::new();
        desk.write("s.toml", edited(&two_seconds(text), edits));
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).expect("a file of ours");
    }

    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Every file, as a path from the desk.
    fn files(&self) -> BTreeSet<String> {
        let (mut files, mut open) = (BTreeSet::new(), vec![self.folder.path().to_owned()]);
        while let Some(path) = open.pop() {
            if path.is_dir() {
                open.extend(fs::read_dir(&path).unwrap().map(|entry| entry.unwrap().path()));
            } else {
                let below = path.strip_prefix(self.folder.path()).unwrap();
                files.insert(below.to_str().expect("names here are ASCII").to_owned());
            }
        }
        files
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_struna"));
        command.current_dir(self.folder.path()).args(arguments);
        command
    }

    fn struna(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().expect("the program starts")
    }

    /// What a successful command prints.
    fn done(&self, arguments: &[&str]) -> String {
        let output = self.struna(arguments);
        let (said, complained) = (utf8(output.stdout), utf8(output.stderr));
        assert!(output.status.success(), "{arguments:?}: {}\n{complained}", output.status);
        said
    }

    /// The one line that a refused command complains with; nothing may be printed or left behind.
    #[track_caller]
    fn refused(&self, arguments: &[&str]) -> String {
        let before = self.files();
        let output = self.struna(arguments);
        let complaint = utf8(output.stderr);
        assert_eq!(output.status.code(), Some(REFUSED), "{complaint}");
        assert!(output.stdout.is_empty(), "{}", utf8(output.stdout));
        assert_eq!(self.files(), before, "left behind after: {complaint}");
        assert!(complaint.starts_with("struna: "), "{complaint}");
        assert_eq!(complaint.lines().count(), 1, "{complaint}");
        complaint
    }

    /// The complaint about `s.toml`, once with results in `out` and once with the default folder.
    #[track_caller]
    fn run_refused(&self) -> String {
        let complaint = self.refused(&["run", "s.toml", "--out", "out"]);
        assert_eq!(self.refused(&["run", "s.toml"]), complaint);
        complaint
    }
}

fn utf8(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes).expect("the program writes UTF-8")
}

/// `text` with the first of each `from` replaced by its `to`.
fn edited(text: &str, edits: &[(&str, &str)]) -> String {
    edits.iter().fold(text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "the text to be edited has no {from:?}");
        text.replacen(from, to, 1)
    })
}

/// A shipped scenario, cut to 2 s.
fn two_seconds(text: &str) -> String {
    let duration = text.lines().find(|line| line.starts_with("duration_s")).expect("a duration");
    text.replacen(duration, "duration_s = 2.0", 1)
}

/// The line of `text`, from 1, that starts with `start`.
fn line_of(text: &str, start: &str) -> usize {
    text.lines().position(|line| line.starts_with(start)).expect(start) + 1
}

/// Asserts that a complaint names each of `parts`, and in this order.
#[track_caller]
fn names(complaint: &str, parts: &[&str]) {
    let mut rest = complaint;
    for part in parts {
        let found = rest.find(part).unwrap_or_else(|| panic!("{part:?} not in {complaint:?}"));
        rest = &rest[found + part.len()..];
    }
}

/// The complaint about the demo with one edit, which must name file and line of `key`, and `parts`.
#[track_caller]
fn demo_refused(edit: (&str, &str), key: &str, parts: &[&str]) {
    let complaint = Desk::with_scenario(DEMO, &[edit]).run_refused();
    names(&complaint, &[&format!("s.toml, line {}, column ", line_of(DEMO, key))]);
    names(&complaint, parts);
}

#[test]
fn a_missing_scenario_is_refused_by_its_path() {
    let desk = Desk::new();
    for arguments in [&["run", "nowhere.toml"][..], &["truth", "nowhere.toml", "--csv", "t.csv"]] {
        let complaint = desk.refused(arguments);
        names(&complaint, &["nowhere.toml", "No such file", "check the path"]);
        assert_eq!(complaint.matches("No such file").count(), 1, "{complaint}");
    }
}

#[test]
fn a_text_that_is_no_toml_is_refused_by_its_line() {
    let desk = Desk::with_scenario(DEMO, &[("[gyro]", "[gyro")]);
    let line = format!("s.toml, line {}, ", line_of(DEMO, "[gyro]"));
    names(&desk.run_refused(), &[&line, "not TOML", "correct the syntax here"]);
}

#[test]
fn an_unknown_key_is_answered_with_the_nearest_one() {
    let proposal = ["`run.sede` = sede: no such key", "did you mean `seed`?"];
    demo_refused(("\nseed", "\nsede"), "seed", &proposal);
    let proposal = ["`gyro.bais_deg_h`", "did you mean `bias_deg_h`?"];
    demo_refused(("bias_deg_h", "bais_deg_h"), "bias_deg_h", &proposal);
    let proposal = ["`bdy`", "did you mean `body`?"];
    demo_refused(("[body]", "[bdy]"), "[body]", &proposal);
}

#[test]
fn a_negative_inertia_is_refused() {
    let edit = ("[0.0100, 0.0110", "[0.0100, -0.0110");
    let said = ["`body.inertia_kg_m2[1]` = -0.0110", "write a number greater than 0"];
    demo_refused(edit, "inertia_kg_m2", &said);
}

#[test]
fn moments_that_break_the_triangle_inequality_are_refused() {
    let edit = ("0.0120]", "0.0220]");
    let said = [
        "`body.inertia_kg_m2` = [0.0100, 0.0110, 0.0220]",
        "inertia_c_kg_m2 = 0.022",
        "at most 0.021",
        "no moment of a real body exceeds the sum of the other two",
    ];
    demo_refused(edit, "inertia_kg_m2", &said);
}

#[test]
fn nan_is_refused_wherever_a_number_is_due() {
    for (from, to, key) in [
        ("mass_kg = 1.0", "mass_kg = nan", "mass_kg"),
        ("step_s = 1e-3", "step_s = nan", "step_s"),
        ("bias_deg_h = 3.0", "bias_deg_h = nan", "bias_deg_h"),
        ("angle_start_deg = 360.0", "angle_start_deg = nan", "angle_start_deg"),
    ] {
        demo_refused((from, to), key, &[key, "` = nan", "write a finite number"]);
    }
    // A shipped duration is replaced on the way to the desk.
    let desk = Desk::with_scenario(DEMO, &[("duration_s = 2.0", "duration_s = nan")]);
    names(&desk.run_refused(), &["s.toml, line", "`run.duration_s` = nan", "a finite number"]);
}

#[test]
fn a_torsion_period_of_zero_is_refused() {
    let said = ["`body.torsion.period_s` = 0.0", "write a number greater than 0"];
    demo_refused(("\nperiod_s = 480.0", "\nperiod_s = 0.0"), "period_s", &said);
    let said = ["`estimator[2].torsion_period_s` = 0.0", "write a number greater than 0"];
    let edit = ("torsion_period_s = 480.0", "torsion_period_s = 0.0");
    demo_refused(edit, "torsion_period_s", &said);
}

#[test]
fn an_estimator_with_a_bad_parameter_is_refused() {
    let said = ["`estimator[0].measurement_sigma_deg_s` = 0.0", "write a number greater than 0"];
    let edit = ("measurement_sigma_deg_s = 0.0117", "measurement_sigma_deg_s = 0.0");
    demo_refused(edit, "measurement_sigma_deg_s", &said);
    // Its square overflows, which only the filter's own judge sees.
    let said = ["`estimator[0]`", "angle_variance_start_rad2 = inf", "must be finite"];
    let edit = ("angle_sigma_start_deg = 1.0", "angle_sigma_start_deg = 1e200");
    demo_refused(edit, "[[estimator]]", &said);
}

#[test]
fn two_estimators_of_one_name_are_refused() {
    let edit = ("name = \"torsion\"", "name = \"rotation\"");
    let said = ["`estimator[2].name` = \"rotation\"", "choose a different one"];
    demo_refused(edit, "name = \"torsion\"", &said);
}

#[test]
fn a_truncated_recording_is_refused_by_its_line() {
    let desk = Desk::with_scenario(RECORDING, &[]);
    desk.write("sensor_data.csv", "Time (s),Gyroscope Z (deg/s)\n0,1\n1,2\n2");
    let said = ["sensor_data.csv, line 4: ", "repair or remove the line"];
    names(&desk.run_refused(), &said);
    desk.write("sensor_data.csv", "Time (s),Gyroscope Z (deg/s)\n0,1\n1,-");
    names(&desk.run_refused(), &["sensor_data.csv, line 3: '-'", "repair or remove the line"]);
    names(&desk.refused(&["truth", "s.toml", "--csv", "t.csv"]), &["sensor_data.csv, line 3: "]);
}

#[test]
fn a_recording_that_holds_nan_or_goes_back_in_time_is_refused() {
    let desk = Desk::with_scenario(RECORDING, &[]);
    for rows in ["0,1\n1,nan\n2,1\n", "nan,1\n1,1\n", "0,1\n2,1\n1,1\n"] {
        desk.write("sensor_data.csv", format!("Time (s),Gyroscope Z (deg/s)\n{rows}"));
        names(&desk.run_refused(), &["sensor_data.csv"]);
    }
}

#[test]
fn a_missing_recording_column_is_answered_with_those_there_are() {
    let desk = Desk::with_scenario(RECORDING, &[]);
    desk.write("sensor_data.csv", "Time (s),Gyro (deg/s)\n0,1\n1,2\n3,1\n");
    let said = ["sensor_data.csv", "'Gyroscope Z (deg/s)'", "[source]", "Time (s), Gyro (deg/s)"];
    names(&desk.run_refused(), &said);
}

#[test]
fn a_missing_recording_is_refused_by_its_path() {
    let complaint = Desk::with_scenario(RECORDING, &[]).run_refused();
    names(&complaint, &["sensor_data.csv", "No such file", "check `file` in [source]"]);
    assert_eq!(complaint.matches("No such file").count(), 1, "{complaint}");
}

#[test]
fn a_missing_frame_file_is_refused_by_its_path() {
    let complaint = Desk::with_scenario(DEMO, &[("struna/vg910d@1", "own.toml")]).run_refused();
    names(&complaint, &["own.toml", "No such file", "check `frame` in [line]"]);
    let unknown = ["`line.frame` = \"vg910\"", "write a .toml file or one of"];
    demo_refused(("struna/vg910d@1", "vg910"), "frame = ", &unknown);
}

#[test]
fn a_broken_frame_file_is_refused_by_its_line() {
    let desk = Desk::with_scenario(DEMO, &[("struna/vg910d@1", "own.toml")]);
    for (from, to, line, said) in [
        ("bits = 24", "bits = 12", "bits = 24", "`frame.field[0].bits` = 12: not usable; write 8"),
        ("refin =", "refine =", "refin =", "did you mean `refin`?"),
        ("at = 7", "at = 6", "at = 7", "byte 6 already belongs to frame.field[0]; move one"),
        ("rate_hz = 300.0", "rate_hz = 30000.0", "rate_hz", "raise `line.baud` or lower"),
    ] {
        desk.write("own.toml", edited(FRAME, &[(from, to)]));
        let place = format!("own.toml, line {}, ", line_of(FRAME, line));
        names(&desk.run_refused(), &[&place, said]);
    }
}

/// A desk whose scenario runs its last estimator as the FMU in `given.fmu`.
fn desk_with_given_fmu() -> Desk {
    let given = "run_as = \"fmu-file\"\nfmu_file = \"given.fmu\"\ntorsion_period_s";
    Desk::with_scenario(DEMO, &[("run_as = \"fmi3\"\ntorsion_period_s", given)])
}

#[test]
fn a_given_fmu_that_is_missing_is_refused_by_its_path() {
    let complaint = desk_with_given_fmu().run_refused();
    names(&complaint, &["estimator 'torsion'", "given.fmu", "No such file", "check the path"]);
}

#[test]
fn a_given_fmu_that_is_no_zip_is_refused() {
    let desk = desk_with_given_fmu();
    for content in [&b""[..], b"no zip", b"PK\x03\x04 cut short"] {
        desk.write("given.fmu", content);
        let said = ["estimator 'torsion'", "given.fmu is not an FMU", "`struna fmu build`"];
        names(&desk.run_refused(), &said);
    }
}

#[test]
fn a_given_zip_without_a_model_description_is_refused() {
    let desk = desk_with_given_fmu();
    write_zip(&desk.path("given.fmu"), &[("readme.txt".to_owned(), b"hello".to_vec())]);
    let said = ["'torsion'", "given.fmu is not an FMU", "modelDescription.xml", "struna fmu build"];
    names(&desk.run_refused(), &said);
}

#[test]
fn a_given_fmu_of_another_interface_is_refused() {
    let desk = desk_with_given_fmu();
    desk.done(&["fmu", "build", "--out", "fmus"]);
    // A shared library that is certainly there and certainly no FMU: the C library of this process.
    let maps = fs::read_to_string("/proc/self/maps").expect("Linux tells what is mapped");
    let c_library = maps.split_whitespace().find(|word| word.contains("/libc.so"));
    let c_library = fs::read(c_library.expect("tests are linked dynamically")).unwrap();
    for version in ["fmi2", "fmi3"] {
        let mut entries = read_zip(&desk.path(&format!("fmus/TorsionalOscillation_{version}.fmu")));
        let binary = entries.iter_mut().find(|(name, _)| name.starts_with("binaries/"));
        binary.expect("an FMU holds a library").1.clone_from(&c_library);
        write_zip(&desk.path("given.fmu"), &entries);
        names(&desk.run_refused(), &["'torsion'", "library of FMU TorsionalOscillation", "fmi"]);
    }
}

#[test]
fn a_given_fmu_without_the_estimators_variables_is_refused() {
    let desk = desk_with_given_fmu();
    desk.done(&["fmu", "build", "--out", "fmus"]);
    // Knows no torsional period.
    fs::copy(desk.path("fmus/PermanentRotation_fmi3.fmu"), desk.path("given.fmu")).unwrap();
    let said = ["estimator 'torsion'", "FMU PermanentRotation", "no", "variable 'period_s'"];
    names(&desk.run_refused(), &said);
}

fn read_zip(path: &Path) -> Vec<(String, Vec<u8>)> {
    let mut zip = ZipArchive::new(File::open(path).unwrap()).unwrap();
    let mut entries = Vec::new();
    for k in 0..zip.len() {
        let mut entry = zip.by_index(k).unwrap();
        let mut content = Vec::new();
        entry.read_to_end(&mut content).unwrap();
        entries.push((entry.name().to_owned(), content));
    }
    entries
}

fn write_zip(path: &Path, entries: &[(String, Vec<u8>)]) {
    let mut zip = ZipWriter::new(File::create(path).unwrap());
    for (name, content) in entries {
        zip.start_file(name, SimpleFileOptions::default()).unwrap();
        zip.write_all(content).unwrap();
    }
    zip.finish().unwrap();
}

#[test]
fn a_place_that_cannot_be_written_is_refused_by_its_path() {
    let desk = Desk::with_scenario(DEMO, &[]);
    desk.write("taken", "mine");
    for arguments in [
        &["run", "s.toml", "--out", "taken"][..],
        &["demo", "--out", "taken"],
        &["fmu", "build", "--out", "taken"],
        &["truth", "s.toml", "--csv", "taken/t.csv"],
        &["truth", "s.toml", "--csv", "nowhere/taken.csv"],
    ] {
        let complaint = desk.refused(arguments);
        names(&complaint, &["cannot write ", "taken", "(os error", "may be written"]);
        assert_eq!(complaint.matches("(os error").count(), 1, "{complaint}");
    }
    assert_eq!(desk.text("taken"), "mine");
}

#[test]
fn the_help_of_every_command_shows_an_example() {
    let desk = Desk::new();
    for (command, example) in [
        (&[][..], "struna demo"),
        (&["demo"], "\n  struna demo --out "),
        (&["run"], "\n  struna run scenarios/demo.toml"),
        (&["truth"], "\n  struna truth scenarios/swing.toml --csv truth.csv"),
        (&["fmu"], "\n  struna fmu list"),
        (&["fmu", "build"], "\n  struna fmu build --out "),
        (&["fmu", "list"], "\n  struna fmu list"),
    ] {
        let help = desk.done(&[command, &["--help"]].concat());
        assert!(help.contains(example), "{command:?}:\n{help}");
    }
}

#[test]
fn fmu_list_names_both_models_and_their_variables() {
    let list = Desk::new().done(&["fmu", "list"]);
    for word in ["PermanentRotation ", "TorsionalOscillation ", " measured_rate_rad_s ", " nis "] {
        assert!(list.contains(word), "{word:?} not in:\n{list}");
    }
    assert_eq!(list.matches(" period_s ").count(), 1, "{list}");
}

const FMUS: [&str; 4] = [
    "PermanentRotation_fmi2.fmu",
    "PermanentRotation_fmi3.fmu",
    "TorsionalOscillation_fmi2.fmu",
    "TorsionalOscillation_fmi3.fmu",
];

#[test]
fn fmu_build_writes_both_models_for_both_versions() {
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

/// Header and rows of a CSV file, every cell a number.
fn csv(text: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header = reader.headers().expect("a header").iter().map(str::to_owned).collect();
    let numbers = |row: csv::StringRecord| {
        row.iter().map(|cell| cell.parse().unwrap_or_else(|_| panic!("{cell}"))).collect()
    };
    (header, reader.records().map(|row| numbers(row.expect("rows of one length"))).collect())
}

#[test]
fn truth_writes_the_motion_at_every_sample_instant() {
    let desk = Desk::with_scenario(SWING, &[]);
    let printed = desk.done(&["truth", "s.toml", "--csv", "truth.csv"]);
    assert!(printed.contains("601 instants") && printed.contains("truth.csv"), "{printed}");
    let (header, rows) = csv(&desk.text("truth.csv"));
    let columns = "time twist_rad twist_rate_rad_s body_rate_integral_rad omega_wb_b_x_rad_s \
                   omega_wb_b_y_rad_s omega_wb_b_z_rad_s q_wb_w q_wb_x q_wb_y q_wb_z";
    assert_eq!(header.join(" "), columns);
    // 2 s at 300 Hz, both ends included.
    assert_eq!(rows.len(), 601);
    assert!((rows[0][0], rows[300][0], rows[600][0]) == (0.0, 1.0, 2.0));
    for row in &rows {
        let norm = row[7..].iter().map(|q| q * q).sum::<f64>().sqrt();
        // Normalised in double precision: a few roundings off one.
        assert!((norm - 1.0).abs() < 1e-14, "{norm}");
    }
}

#[test]
fn a_run_writes_record_score_figure_and_fmus() {
    let desk = Desk::with_scenario(DEMO, &[]);
    let printed = desk.done(&["run", "s.toml", "--out", "results", "--seed", "7"]);
    names(
        &printed,
        &["integration", "rotation", "torsion", "600 frames sent, 600 received, 0 lost"],
    );
    let written = ["record.csv", "score.json", "figure.svg"];
    names(&printed, &["written to results"]);
    let fmus = ["fmu/PermanentRotation_fmi3.fmu", "fmu/TorsionalOscillation_fmi3.fmu"];
    let mut expected: BTreeSet<String> =
        written.iter().chain(&fmus).map(|name| format!("results/{name}")).collect();
    expected.insert("s.toml".to_owned());
    assert_eq!(desk.files(), expected);

    let (header, rows) = csv(&desk.text("results/record.csv"));
    assert_eq!((header[0].as_str(), rows.len()), ("time", 200));
    assert!(header.iter().any(|name| name == "torsion.angle_sigma_rad"), "{header:?}");
    let score = score(&desk, "results/score.json");
    assert_eq!((&score["seed"], &score["interrupted"]), (&7.into(), &false.into()));
    assert_eq!(score["estimators"].as_array().map(Vec::len), Some(3));
    let figure = desk.text("results/figure.svg");
    assert!(figure.starts_with("<svg") && figure.trim_end().ends_with("</svg>"));
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
    let mut running = Running(command.stdout(Stdio::piped()).spawn().expect("the program starts"));
    // The last FMU is built when Ctrl-C is long listened for.
    while !desk.path("out/fmu/TorsionalOscillation_fmi3.fmu").is_file() {
        assert_eq!(running.0.try_wait().expect("our child"), None, "ended by itself");
        thread::yield_now();
    }
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
    let last = rows.last().map_or(0.0, |row| row[0]);
    assert_eq!(score["recorded_until_s"], last);
    assert!(desk.text("out/figure.svg").starts_with("<svg"));
    let mut said = String::new();
    running.0.stdout.take().expect("piped").read_to_string(&mut said).expect("UTF-8");
    names(&said, &["stopped at ", " of 1000000 s", "everything until then is recorded"]);
    assert!(desk.files().iter().all(|name| !name.ends_with(".tmp")), "{:?}", desk.files());
}
