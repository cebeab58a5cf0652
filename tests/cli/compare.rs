//! `struna compare`: what two files differ by, and which files it refuses.

use crate::desk::{Desk, csv, names};

const SWING: &str = include_str!("../../scenarios/swing.toml");

/// Exit code of a tolerance that was exceeded.
const EXCEEDED: i32 = 1;

/// A desk with the truth of `s.toml` in `a.csv`, and in `b.csv` that of `s.toml` after `edits`.
fn desk_with_truths(edits: &[(&str, &str)]) -> Desk {
    let desk = Desk::with_scenario(SWING, &[]);
    desk.done(&["truth", "s.toml", "--csv", "a.csv"]);
    desk.write("b.toml", crate::desk::edited(&desk.text("s.toml"), edits));
    desk.done(&["truth", "b.toml", "--csv", "b.csv"]);
    desk
}

/// A desk with two files of these contents.
fn desk_with(a: &str, b: &str) -> Desk {
    let desk = Desk::new();
    desk.write("a.csv", a);
    desk.write("b.csv", b);
    desk
}

fn compared(desk: &Desk) -> String {
    desk.done(&["compare", "a.csv", "b.csv"])
}

/// The words of the row of `column`.
#[track_caller]
fn row<'a>(table: &'a str, column: &str) -> Vec<&'a str> {
    let row = table.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    row.into_iter().find(|words| words.first() == Some(&column)).expect(column)
}

#[test]
fn the_table_tells_size_and_place_of_the_largest_differences() {
    let desk = desk_with_truths(&[("step_s = 1e-3", "step_s = 5e-3")]);
    let table = compared(&desk);
    names(&table, &["601 common instants, 0 s to 2 s"]);
    let ((header, a), (_, b)) = (csv(&desk.text("a.csv")), csv(&desk.text("b.csv")));
    // Each column by hand, as far as the columns are not an attitude.
    for (at, name) in header.iter().enumerate().take(7).skip(1) {
        let apart = |k: usize| (a[k][at] - b[k][at]).abs();
        let k = (0..a.len()).rev().max_by(|j, k| apart(*j).total_cmp(&apart(*k))).unwrap();
        let rms = ((0..a.len()).map(|k| apart(k).powi(2)).sum::<f64>() / a.len() as f64).sqrt();
        let unit = if name.ends_with("_rad") { "rad" } else { "rad/s" };
        let expected = [
            format!("{:.3e}", apart(k)),
            format!("{rms:.3e}"),
            unit.to_owned(),
            a[k][0].to_string(),
            format!("{:.3e}", apart(k).to_degrees()),
            format!("{:.3e}", rms.to_degrees()),
            unit.replace("rad", "deg"),
        ];
        let words: Vec<_> = row(&table, name).into_iter().skip(1).filter(|w| *w != "*").collect();
        assert_eq!(words, expected, "{name}:\n{table}");
    }
    // RK4 at 5 ms is off by some 1e-8 rad after 2 s of a swing at 1.5 Hz, which moves every
    // component of the quaternion; none is shown by itself.
    let attitude: f64 = row(&table, "attitude")[1].parse().unwrap();
    assert!((1e-9..1e-6).contains(&attitude), "{table}");
    assert!(!table.contains("q_wb_w"), "{table}");
    assert_eq!(
        table.matches(" * ").count(),
        4,
        "one mark for rad, rad/s, m and m/s each:\n{table}"
    );
}

#[test]
fn the_heads_of_both_files_are_shown() {
    let turned_over = ("[0.0, 19.3, 0.0]", "[2000.0, 0.0, 0.0]");
    let desk = Desk::with_scenario(SWING, &[turned_over]);
    desk.struna(&["truth", "s.toml", "--csv", "b.csv"]);
    desk.write("a.csv", "# struna truth\n# backend: mine\n\"time\",\"twist_rad\"\n0.0,1.0\n");
    names(
        &compared(&desk),
        &[
            "A  a.csv\n   struna truth\n   backend: mine\nB  b.csv\n   struna truth\n",
            "   scenario: swing\n   backend: lagrange, rk4, step 0.001 s\n   seed: 1\n",
            "   stopped: at 0.064331719 s the string went slack",
            "\n1 common instants, 0 s to 0 s\n19 more in B after them\nonly in B: twist_rate_rad_s",
        ],
    );
}

#[test]
fn attitudes_differ_by_the_angle_between_them() {
    let header = "time,q_wb_x,q_wb_y,q_wb_z,q_wb_w\n";
    // A third of a turn about (1, 1, 1), the same attitude with its sign turned, and none known.
    let a = format!("{header}0,0,0,0,1\n1,0.5,0.5,0.5,0.5\n2,NaN,0,0,1\n");
    let b = format!("{header}0,0.5,0.5,0.5,0.5\n1,-0.5,-0.5,-0.5,-0.5\n2,NaN,0,0,1\n");
    let table = compared(&desk_with(&a, &b));
    let expected = "attitude 2.094e0 * 1.481e0 rad 0 1.200e2 8.485e1 deg";
    assert_eq!(row(&table, "attitude").join(" "), expected, "{table}");
}

#[test]
fn a_quaternion_of_which_a_file_has_only_a_part_is_compared_by_columns() {
    let table = compared(&desk_with(
        "time,q_wb_w,q_wb_x,q_wb_y,q_wb_z\n0,1,0,0,0\n",
        "time,q_wb_w\n0,0.75\n",
    ));
    assert_eq!(row(&table, "q_wb_w")[1], "2.500e-1", "{table}");
    names(&table, &["only in A: q_wb_x, q_wb_y, q_wb_z"]);
}

#[test]
fn the_denser_file_is_compared_at_the_instants_of_the_other() {
    let desk = desk_with_truths(&[
        ("preset = \"vg910d\"", "preset = \"vg910d\"\nsample_rate_hz = 100.0"),
        ("duration_s = 2.0", "duration_s = 3.0"),
    ]);
    let table = compared(&desk);
    // The motion of a model does not depend on how it is sampled.
    let said = ["201 common instants, 0 s to 2 s", "400 more in A between", "100 more in B after"];
    names(&table, &said);
    names(&table, &["nothing differs"]);
    let turned = desk.done(&["compare", "b.csv", "a.csv"]);
    names(&turned, &["201 common", "100 more in A after", "400 more in B between", "nothing"]);
}

#[test]
fn instants_within_half_a_nanosecond_are_one() {
    let (a, b) = ("time,x\n0,1\n1,1\n2,1\n", "time,x\n0,1\n1.0000000004,2\n2,2\n");
    let table = compared(&desk_with(a, b));
    names(&table, &["3 common instants, 0 s to 2 s"]);
    assert_eq!(
        row(&table, "x")[1..],
        ["1.000e0", "*", "8.165e-1", "1"],
        "the first of the largest"
    );
    let apart = desk_with("time,x\n0,1\n1,1\n2,1\n", "time,x\n0,1\n1.000000001,2\n2,1\n");
    let places =
        ["'time'", "1 s in a.csv, line 3", "1.000000001 s in b.csv, line 3", "`sample_rate_hz`"];
    names(&apart.refused(&["compare", "a.csv", "b.csv"]), &places);
}

#[test]
fn values_that_neither_file_knows_do_not_differ() {
    let table = compared(&desk_with(
        "time,x_rad,y_rad,z_rad\n0,NaN,NaN,1\n1,NaN,2,1\n",
        "time,x_rad,y_rad,z_rad\n0,NaN,NaN,1\n1,NaN,1.5,NaN\n",
    ));
    assert_eq!(row(&table, "x_rad").join(" "), "x_rad no value");
    assert_eq!(row(&table, "y_rad")[1..5], ["5.000e-1", "5.000e-1", "rad", "1"]);
    assert_eq!(row(&table, "z_rad")[1..3], ["inf", "*"], "known in one file alone:\n{table}");
}

#[test]
fn records_are_compared_like_truths() {
    // A clock that is off by the same in both runs: truths are recorded when samples are taken.
    let preset = "preset = \"vg910d\"";
    let one_clock = format!("{preset}\nclock_offset_sigma_ppm = 0");
    let desk = Desk::with_scenario(SWING, &[(preset, &one_clock)]);
    desk.done(&["run", "s.toml", "--out", "a"]);
    desk.done(&["run", "s.toml", "--out", "b", "--seed", "2"]);
    let table = desk.done(&["compare", "a/record.csv", "b/record.csv"]);
    assert_eq!(row(&table, "truth.twist_rad").join(" "), "truth.twist_rad 0 0 rad");
    assert_ne!(row(&table, "torsion.angle_rad")[1], "0", "other noise, other estimate:\n{table}");
}

#[test]
fn a_tolerance_decides_the_exit_code_by_the_widest_angle() {
    let truths = "time,twist_rad,twist_rate_rad_s\n0,1,1\n2,";
    let desk = desk_with(&format!("{truths}3,4\n"), &format!("{truths}3.25,9\n"));
    let judged = |tolerance_rad| {
        desk.struna(&["compare", "a.csv", "b.csv", "--tolerance-rad", tolerance_rad])
    };
    // The rate is off by 5 rad/s, and is no angle.
    assert!(judged("0.25").status.success());
    let exceeded = judged("0.2499");
    assert_eq!(exceeded.status.code(), Some(EXCEEDED));
    assert!(String::from_utf8(exceeded.stdout).unwrap().contains("twist_rate_rad_s"));
    assert_eq!(
        String::from_utf8(exceeded.stderr).unwrap(),
        "struna: twist_rad differs by 2.5e-1 rad at 2 s, more than the tolerated 2.499e-1 rad\n"
    );
    for nonsense in ["-1", "nan", "inf", "small"] {
        let said = String::from_utf8(judged(nonsense).stderr).unwrap();
        assert!(said.contains(nonsense) && said.contains("at least 0"), "{said}");
    }
}

#[test]
fn a_tolerance_without_an_angle_to_judge_is_refused() {
    let desk = desk_with("time,x_m\n0,1\n", "time,x_m\n0,1\n");
    let complaint = desk.refused(&["compare", "a.csv", "b.csv", "--tolerance-rad", "1"]);
    names(&complaint, &["no angle", "leave --tolerance-rad away"]);
}

const GOOD: &str = "time,x_rad\n0,1\n1,1\n";

/// The complaint about a comparison of `bad` with a good file, from either side.
#[track_caller]
fn complains(bad: impl AsRef<[u8]>, parts: &[&str]) {
    let desk = desk_with(GOOD, "");
    desk.write("b.csv", bad);
    names(&desk.refused(&["compare", "a.csv", "b.csv"]), parts);
    names(&desk.refused(&["compare", "b.csv", "a.csv"]), parts);
}

#[test]
fn a_file_that_is_not_there_or_is_none_is_refused_by_its_path() {
    let desk = desk_with(GOOD, GOOD);
    let missing = desk.refused(&["compare", "a.csv", "nowhere.csv"]);
    names(&missing, &["nowhere.csv", "No such file", "check the path"]);
    let advice = ["is not a file", "`struna truth`"];
    names(&desk.refused(&["compare", ".", "b.csv"]), &advice);
    names(&desk.refused(&["compare", "/dev/zero", "b.csv"]), &advice);
}

#[test]
fn a_file_without_header_or_rows_is_refused() {
    complains("", &["b.csv ends at line 0 without a header", "write the file again"]);
    complains("# struna truth\n\n", &["b.csv ends at line 2 without a header"]);
    complains("time,x_rad\n", &["b.csv ends at line 1 without rows", "write the file again"]);
}

#[test]
fn a_header_that_fits_no_signals_is_refused() {
    complains("x_rad,time\n1,0\n", &["b.csv, line 1", "'x_rad' and not 'time'", "name a CSV"]);
    complains("\"time\",x,x\n", &["b.csv, line 1", "'x' is there twice", "rename or remove"]);
    complains("time,y_rad\n0,1\n", &["no column in common", "compare files of one kind"]);
}

#[test]
fn a_bad_row_is_refused_by_line_column_and_value() {
    let remedy = "repair or remove the line";
    complains("time,x_rad\n0,1\n1,2O\n", &["b.csv, line 3: '2O' in column 'x_rad'", remedy]);
    complains("time,x_rad\n0,1\n1,\n", &["b.csv, line 3: '' in column 'x_rad'", remedy]);
    complains("time,x_rad\n0,inf\n", &["b.csv, line 2: 'inf' in column 'x_rad'", remedy]);
    complains("time,x_rad\nNaN,1\n", &["b.csv, line 2: 'NaN' in column 'time'", remedy]);
    complains("time,x_rad\n0\n", &["b.csv, line 2: 1 values", "2 columns", remedy]);
    complains("time,x_rad\n0,1\n1,2,3\n", &["b.csv, line 3: 3 values", "2 columns", remedy]);
    complains(b"time,x_rad\n0,\xff\n", &["b.csv, line 2: not UTF-8", remedy]);
    let endless = format!("time,x_rad\n0,{}\n", "1".repeat(100_000));
    complains(endless, &["b.csv, line 2: longer than 65536 bytes", remedy]);
    // Also below the last row of the other file, and where lines end as on other systems.
    complains("time,x_rad\n0,1\n1,1\n2,1\n3,?\n", &["b.csv, line 5: '?'", remedy]);
    complains("# a\r\ntime,x_rad\r\n\r\n0,1\r\n1,?\r\n", &["b.csv, line 5: '?'", remedy]);
}

#[test]
fn time_that_does_not_go_on_is_refused() {
    let places = ["b.csv, line 4: 1 s in column 'time'", "not later than the 1 s", "sort or"];
    complains("time,x_rad\n0,1\n1,1\n1,1\n", &places);
}

#[test]
fn numbers_that_are_no_attitude_are_refused() {
    let header = "time,q_wb_w,q_wb_x,q_wb_y,q_wb_z\n";
    let desk = desk_with(&format!("{header}0,1,0,0,0\n"), &format!("{header}0,0.5,0,0,0\n"));
    let places = ["b.csv, line 2: [0.5, 0.0, 0.0, 0.0]", "'q_wb_w'", "no attitude", "0.25"];
    names(&desk.refused(&["compare", "a.csv", "b.csv"]), &places);
}

#[test]
fn files_of_different_grids_or_times_are_refused_by_their_first_mismatch() {
    let places = ["'time'", "1 s in a.csv, line 3", "0.5 s in b.csv, line 3", "same `sample_rate"];
    let desk = desk_with(GOOD, "time,x_rad\n0,1\n0.5,1\n0.9,1\n1.5,1\n");
    names(&desk.refused(&["compare", "a.csv", "b.csv"]), &places);
    let desk = desk_with(GOOD, "time,x_rad\n5,1\n6,1\n");
    let places = ["1 s in a.csv, line 3 ends", "5 s in b.csv, line 2 begins", "the same time"];
    names(&desk.refused(&["compare", "a.csv", "b.csv"]), &places);
    names(&desk.refused(&["compare", "b.csv", "a.csv"]), &places);
}
