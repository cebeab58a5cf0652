//! House rules that a machine can check, over every tracked Rust file.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::fs;
use std::path::{Path, PathBuf};

const FILE_LINES_MAX: usize = 500;
const COLUMNS_MAX: usize = 100;
const FOLDERS: [&str; 6] = ["src", "models", "hil", "fmu", "tests", "benches"];
/// Crates and corners that may hold unsafe code.
const UNSAFE_ALLOWED: [&str; 4] =
    ["fmu/export/", "fmu/import/", "fmu/library/", "models/body/src/batch/vector.rs"];

fn rust_files() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut open: Vec<PathBuf> = FOLDERS.iter().map(|folder| root.join(folder)).collect();
    let mut files = Vec::new();
    while let Some(path) = open.pop() {
        if path.is_dir() {
            open.extend(fs::read_dir(&path).unwrap().map(|entry| entry.unwrap().path()));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    assert!(files.len() > 30, "only {} Rust files found", files.len());
    files.sort();
    files
}

fn relative(path: &Path) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    path.strip_prefix(root).unwrap().display().to_string()
}

/// Every line of every file that breaks `rule`, as "file:line: reason".
fn offences(rule: impl Fn(&str, &str) -> Option<String>) -> Vec<String> {
    let mut found = Vec::new();
    for path in rust_files() {
        let name = relative(&path);
        for (k, line) in fs::read_to_string(&path).unwrap().lines().enumerate() {
            if let Some(reason) = rule(&name, line) {
                found.push(format!("{name}:{}: {reason}", k + 1));
            }
        }
    }
    found
}

#[test]
fn files_are_short_and_open_with_what_they_are() {
    let mut found = Vec::new();
    for path in rust_files() {
        let (name, text) = (relative(&path), fs::read_to_string(&path).unwrap());
        let lines = text.lines().count();
        if lines > FILE_LINES_MAX {
            found.push(format!("{name}: {lines} lines, at most {FILE_LINES_MAX}"));
        }
        if !text.starts_with("//!") {
            found.push(format!("{name}: does not open with a //! line"));
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn lines_are_at_most_100_columns_and_have_no_trailing_blanks() {
    let found = offences(|_, line| {
        let columns = line.chars().count();
        if columns > COLUMNS_MAX {
            return Some(format!("{columns} columns"));
        }
        (line.trim_end() != line).then(|| "trailing blanks".to_owned())
    });
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn no_test_is_skipped_or_expected_to_panic() {
    // Put together here, so that this file does not offend itself.
    let banned = [concat!("#[", "ignore"), concat!("#[should", "_panic"), concat!("todo", "!(")];
    let found = offences(|_, line| {
        banned.iter().find(|word| line.contains(**word)).map(|word| format!("holds {word}"))
    });
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn unsafe_code_stays_where_it_is_allowed() {
    let word = concat!("unsafe", " ");
    let mut found = Vec::new();
    for path in rust_files() {
        let (name, text) = (relative(&path), fs::read_to_string(&path).unwrap());
        let allowed = UNSAFE_ALLOWED.iter().any(|folder| name.starts_with(folder));
        let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
        if !allowed && code.into_iter().any(|line| line.contains(word)) {
            found.push(name);
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn no_profile_aborts_on_panic() {
    let manifest =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml")).unwrap();
    let manifest: toml::Table = manifest.parse().unwrap();
    for (name, profile) in manifest["profile"].as_table().unwrap() {
        assert!(profile.get("panic").is_none(), "profile {name} sets panic");
    }
}
