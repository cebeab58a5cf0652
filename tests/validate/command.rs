//! The command as a person meets it.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

fn struna(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_struna"));
    command.current_dir(folder).arg("validate").args(arguments).output().unwrap()
}

/// Refused with code 2, with these words; nothing printed.
#[track_caller]
fn refused(folder: &Path, arguments: &[&str], words: &[&str]) {
    let output = struna(folder, arguments);
    let complaint = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{complaint}");
    assert!(output.stdout.is_empty());
    for word in words {
        assert!(complaint.contains(word), "{word}: {complaint}");
    }
}

#[test]
fn nonsense_is_refused_with_code_two_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    refused(at, &["--suite", "mood"], &["mood", "paper", "limits", "kicks", "all"]);
    refused(at, &["--runs", "0"], &["--runs", "0 is not in 1.."]);
    refused(at, &["--threads", "0"], &["--threads"]);
    refused(at, &["--seed=-1"], &["--seed"]);
    assert_eq!(fs::read_dir(at).unwrap().count(), 0);
}

#[test]
fn a_place_that_cannot_be_written_is_refused_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("taken"), "a file").unwrap();
    let words = ["cannot write", "taken", "check that its folder exists"];
    refused(folder.path(), &["--runs", "100000", "--out", "taken"], &words);
    assert_eq!(fs::read_to_string(folder.path().join("taken")).unwrap(), "a file");
}

#[test]
fn a_small_campaign_of_one_suite_writes_four_files_and_the_verdicts() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["--suite", "paper", "--runs", "2", "--out", "new/place", "--threads", "2"];
    let output = struna(folder.path(), &arguments);
    let said = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("F1 N=0") && said.contains("verdict") && said.contains("0 not met"));
    assert!(output.stderr.is_empty(), "no progress bar where there is no terminal");
    let out = folder.path().join("new/place");
    let mut names: Vec<_> =
        fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["junit.xml", "report.html", "rows.csv", "rows.parquet"]);
    let csv = fs::read_to_string(out.join("rows.csv")).unwrap();
    assert!(csv.starts_with("suite,case,estimator,run,seed,outcome,status,duration_s,period_s,"));
    // 29 estimators with a true start, 7 each with a wrong one and a bias, and those of the best N;
    // two runs, one head.
    let suite = struna::validate::Suite::named("paper").unwrap();
    let cells: Vec<usize> = suite.cases.iter().map(|case| case.estimators().len()).collect();
    assert_eq!(cells[..3], [29, 7, 7]);
    assert_eq!(csv.lines().count(), 1 + 2 * cells.iter().sum::<usize>());
}

/// Every suite, end to end. One run decides little, and nothing of it may be wrong.
#[test]
fn all_suites_run_and_one_run_decides_nothing_against_them() {
    let folder = tempfile::tempdir().unwrap();
    let output = struna(folder.path(), &["--suite", "all", "--runs", "1", "--out", "out"]);
    let said = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{said}");
    for suite in struna::validate::Suite::NAMES {
        assert!(said.contains(&format!("\n{suite}: ")) || said.starts_with(suite), "{suite}");
    }
    assert!(said.contains(" 0 not met"), "{said}");
}

#[test]
fn an_interrupted_campaign_leaves_what_it_has_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_struna"));
    command.current_dir(folder.path()).args(["validate", "--suite", "limits", "--out", "out"]);
    let child = command.args(["--runs", "100000"]).stdout(Stdio::piped()).spawn().unwrap();
    // The folder is there as soon as the program listens for Ctrl-C.
    while !folder.path().join("out").exists() {
        std::thread::yield_now();
    }
    let kill = format!("kill -INT {}", child.id());
    assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(said.contains("PARTIAL"), "{said}");
    let page = fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert!(page.contains("Partial result"));
    let junit = fs::read_to_string(folder.path().join("out/junit.xml")).unwrap();
    assert!(junit.contains("name=\"partial\" value=\"true\""));
}
