//! A folder to run the program in, and what its tests ask of texts and archives.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

pub(crate) const DEMO: &str = include_str!("../../scenarios/demo.toml");

/// Exit code of a refusal.
const REFUSED: i32 = 1;

/// A folder of its own to work in, thrown away afterwards.
pub(crate) struct Desk {
    folder: TempDir,
}

impl Desk {
    pub(crate) fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a temporary folder") }
    }

    /// A desk with `s.toml`: `text` cut to 2 s, then changed as `edits` say.
    pub(crate) fn with_scenario(text: &str, edits: &[(&str, &str)]) -> Self {
        let desk = Self::new();
        desk.write("s.toml", edited(&two_seconds(text), edits));
        desk
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).expect("a file of ours");
    }

    pub(crate) fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Every file, as a path from the desk.
    pub(crate) fn files(&self) -> BTreeSet<String> {
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

    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_struna"));
        command.current_dir(self.folder.path()).args(arguments);
        command
    }

    pub(crate) fn struna(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().expect("the program starts")
    }

    /// What a successful command prints.
    pub(crate) fn done(&self, arguments: &[&str]) -> String {
        let output = self.struna(arguments);
        let (said, complained) = (utf8(output.stdout), utf8(output.stderr));
        assert!(output.status.success(), "{arguments:?}: {}\n{complained}", output.status);
        said
    }

    /// The one line that a refused command complains with; nothing may be printed or left behind.
    #[track_caller]
    pub(crate) fn refused(&self, arguments: &[&str]) -> String {
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

    /// The complaint about `s.toml`.
    #[track_caller]
    pub(crate) fn run_refused(&self) -> String {
        self.refused(&["run", "s.toml", "--out", "out"])
    }
}

fn utf8(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes).expect("the program writes UTF-8")
}

/// `text` with the first of each `from` replaced by its `to`.
pub(crate) fn edited(text: &str, edits: &[(&str, &str)]) -> String {
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
pub(crate) fn line_of(text: &str, start: &str) -> usize {
    text.lines().position(|line| line.starts_with(start)).expect(start) + 1
}

/// Asserts that a complaint names each of `parts`, and in this order.
#[track_caller]
pub(crate) fn names(complaint: &str, parts: &[&str]) {
    let mut rest = complaint;
    for part in parts {
        let found = rest.find(part).unwrap_or_else(|| panic!("{part:?} not in {complaint:?}"));
        rest = &rest[found + part.len()..];
    }
}

pub(crate) fn read_zip(path: &Path) -> Vec<(String, Vec<u8>)> {
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

pub(crate) fn write_zip(path: &Path, entries: &[(String, Vec<u8>)]) {
    let mut zip = ZipWriter::new(File::create(path).unwrap());
    for (name, content) in entries {
        zip.start_file(name, SimpleFileOptions::default()).unwrap();
        zip.write_all(content).unwrap();
    }
    zip.finish().unwrap();
}

/// Header and rows of a CSV file, comments left out, every cell a number.
pub(crate) fn csv(text: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let header = reader.headers().expect("a header").iter().map(str::to_owned).collect();
    let numbers = |row: csv::StringRecord| {
        row.iter().map(|cell| cell.parse().unwrap_or_else(|_| panic!("{cell}"))).collect()
    };
    (header, reader.records().map(|row| numbers(row.expect("rows of one length"))).collect())
}
