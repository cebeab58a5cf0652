//! Bad input: refused with place and remedy, and nothing left behind.

use crate::desk::{DEMO, Desk, edited, line_of, names, read_zip, write_zip};
use std::fs;

const RECORDING: &str = include_str!("../../scenarios/recording.toml");
const FRAME: &str = include_str!("../../frames/vg910d.toml");

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
        names(
            &desk.run_refused(),
            &["'torsion'", "library of FMU TorsionalOscillation", "export the FMU again"],
        );
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
