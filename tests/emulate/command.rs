//! The command as a person meets it.

use crate::{SCENARIO, edited};
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use struna_line::{LineError, ReadOutcome, SerialReader};
use tempfile::TempDir;

/// A folder with `s.toml`, and no place for links of its own.
struct Desk(TempDir);

impl Desk {
    fn new() -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        fs::write(desk.path("s.toml"), SCENARIO).unwrap();
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_struna"));
        command.current_dir(self.0.path()).env_remove("XDG_RUNTIME_DIR");
        command.args(["emulate", "s.toml"]).args(arguments);
        command
    }

    /// What a refused command complains with.
    #[track_caller]
    fn refused(&self, arguments: &[&str]) -> String {
        let output = self.command(arguments).output().unwrap();
        assert!(!output.status.success() && output.stdout.is_empty(), "{output:?}");
        String::from_utf8(output.stderr).unwrap()
    }
}

/// An emulator that runs.
struct Running {
    child: Child,
    output: BufReader<ChildStdout>,
}

impl Running {
    /// Starts it and reads its heading, up to the line that starts with `last`.
    fn start(command: &mut Command, last: &str) -> (Self, Vec<String>) {
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let output = BufReader::new(child.stdout.take().unwrap());
        let mut running = Self { child, output };
        let mut said = Vec::new();
        while !said.last().is_some_and(|line: &String| line.starts_with(last)) {
            let mut line = String::new();
            assert!(running.output.read_line(&mut line).unwrap() > 0, "ended after {said:?}");
            said.push(line.trim_end().to_owned());
        }
        (running, said)
    }

    fn interrupt(&self) {
        let pid = self.child.id().to_string();
        assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    }

    /// The exit code, and what else it said.
    fn end(mut self) -> (Option<i32>, String) {
        let mut rest = String::new();
        self.output.read_to_string(&mut rest).unwrap();
        (self.child.wait().unwrap().code(), rest)
    }
}

/// Reads until `wanted` bytes have come.
fn read(reader: &mut SerialReader, wanted: usize) -> usize {
    let (mut buffer, mut have) = ([0; 4096], 0);
    while have < wanted {
        match reader.read(&mut buffer) {
            Ok(ReadOutcome::Bytes(n)) => have += n,
            Ok(ReadOutcome::Idle) => {}
            Err(error) => panic!("{have} of {wanted} bytes: {error}"),
        }
    }
    have
}

#[test]
fn a_client_reads_the_port_by_its_link_to_the_last_frame() {
    let desk = Desk::new();
    let arguments = ["--link", "gyro", "--wait-for-client", "--log", "em.csv"];
    let (running, said) = Running::start(&mut desk.command(&arguments), "waiting");
    let node = fs::read_link(desk.path("gyro")).unwrap();
    assert_eq!(
        said,
        [
            "turning: struna/vg910d@1 at 300 Hz, 115200 baud, seed 5, truth by lagrange, rk4, \
             step 0.001 s",
            &format!("port    gyro -> {}", node.display()),
            "read    struna hil --port gyro --frame struna/vg910d@1",
            "waiting for a client",
        ]
    );
    let mut reader = SerialReader::open(&desk.path("gyro"), 115_200).unwrap();
    assert_eq!(read(&mut reader, 3300), 3300);
    // What has been read is all there is: the device goes, and its link with it.
    let gone = loop {
        match reader.read(&mut [0; 16]) {
            Ok(ReadOutcome::Idle) => {}
            Ok(ReadOutcome::Bytes(n)) => panic!("{n} bytes too many"),
            Err(error) => break error,
        }
    };
    assert!(matches!(gone, LineError::Vanished { .. }), "{gone}");
    let (code, said) = running.end();
    assert_eq!(code, Some(0), "{said}");
    for part in [
        "opened at 115200 baud\n",
        "frames  300, ",
        "bytes   3300 sent: 3300 passed, 0 unheard, 0 skipped, 0 overrun, 0 garbled\n",
        "clients 1, 0 bytes from them\n",
        "late    overrun:   ",
        "        oversleep: ",
    ] {
        assert!(said.contains(part), "{part:?} not in {said}");
    }
    assert!(fs::symlink_metadata(desk.path("gyro")).is_err(), "the link is still there");

    let log = fs::read_to_string(desk.path("em.csv")).unwrap();
    let mut rows = log.lines();
    assert_eq!(rows.next(), Some("index,sample_ns,due_ns,sent_ns"));
    let rows: Vec<Vec<i64>> =
        rows.map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), 300);
    // 110 symbols at 115200 baud from the sample to the last bit.
    assert!(rows.iter().all(|row| (row[2] - row[1] - 954_861).abs() <= 1), "{log}");
    assert!(rows.iter().all(|row| row[3] >= row[2]));
}

#[test]
fn ctrl_c_ends_it_with_the_summary() {
    let desk = Desk::new();
    let (running, _) = Running::start(&mut desk.command(&["--duration", "3600"]), "read");
    running.interrupt();
    let (code, said) = running.end();
    assert_eq!(code, Some(130), "{said}");
    assert!(said.contains(" (interrupted)\n") && said.contains("0 passed"), "{said}");

    let arguments = ["--link", "gyro", "--wait-for-client", "--log", "em.csv"];
    let (running, _) = Running::start(&mut desk.command(&arguments), "waiting");
    running.interrupt();
    assert_eq!(running.end(), (Some(130), String::new()));
    assert!(fs::symlink_metadata(desk.path("gyro")).is_err(), "the link is still there");
}

#[test]
fn the_usual_place_of_a_link_is_the_runtime_folder() {
    let desk = Desk::new();
    let link = desk.path("struna/turning");
    // What a crashed emulator leaves behind is replaced.
    fs::create_dir(desk.path("struna")).unwrap();
    symlink("/dev/pts/does-not-exist", &link).unwrap();
    let mut command = desk.command(&["--wait-for-client"]);
    let (running, said) = Running::start(command.env("XDG_RUNTIME_DIR", desk.0.path()), "waiting");
    assert!(said[1].starts_with(&format!("port    {} -> /dev/pts/", link.display())), "{said:?}");
    assert!(link.exists());
    running.interrupt();
    running.end();
    assert!(fs::symlink_metadata(&link).is_err(), "the link is still there");

    let (running, said) = Running::start(&mut desk.command(&["--wait-for-client"]), "waiting");
    let node = said[1].strip_prefix("port    ").unwrap().split(' ').next().unwrap();
    assert!(Path::new(node).exists() && said[1].ends_with("(for a lasting name: --link PATH)"));
    running.interrupt();
    running.end();
}

#[test]
fn links_that_would_replace_something_are_refused() {
    let desk = Desk::new();
    fs::write(desk.path("file"), "text").unwrap();
    for (link, why) in
        [("no/such/folder", "No such file"), ("file", "something that is not a symbolic link")]
    {
        let complaint = desk.refused(&["--link", link]);
        let remedy = "give a free path in an existing directory that you may write";
        for part in ["struna: cannot make the link", link, why, remedy] {
            assert!(complaint.contains(part), "{part} not in {complaint}");
        }
    }
    assert_eq!(fs::read(desk.path("file")).unwrap(), b"text");

    let arguments = ["--link", "gyro", "--wait-for-client"];
    let (running, _) = Running::start(&mut desk.command(&arguments), "waiting");
    let complaint = desk.refused(&arguments);
    assert!(complaint.contains("a link to /dev/pts/"), "{complaint}");
    assert!(complaint.contains("end the emulator that made it"), "{complaint}");
    running.interrupt();
    running.end();
}

#[test]
fn scenarios_and_numbers_that_cannot_be_used_are_refused() {
    let desk = Desk::new();
    let slow = edited(SCENARIO, &[("[line]", "[line]\nbaud = 1200")]);
    fs::write(desk.path("s.toml"), slow).unwrap();
    let complaint = desk.refused(&[]);
    assert!(complaint.contains("`line.baud` = 1200"), "{complaint}");
    assert!(complaint.contains("at least 33000"), "{complaint}");
    fs::write(desk.path("s.toml"), SCENARIO).unwrap();
    for (option, value, remedy) in [
        ("--duration", "0", "greater than 0"),
        ("--duration", "nan", "greater than 0"),
        ("--speed", "0", "from 0.001 to 1000"),
        ("--speed", "inf", "from 0.001 to 1000"),
    ] {
        let complaint = desk.refused(&[option, value]);
        assert!(complaint.contains(remedy), "{complaint}");
    }
    let complaint = desk.refused(&["--log", "no/such/em.csv", "--link", "gyro"]);
    assert!(complaint.contains("cannot write no/such/em.csv"), "{complaint}");
}

#[test]
fn faults_act_on_the_port_and_their_truth_is_kept() {
    let desk = Desk::new();
    let faults = "\n[[fault]]\nkind = \"port-loss\"\nat_s = 1.0\nduration_s = 0.2\n\n[[fault]]\n\
                  kind = \"bit-flip\"\nrate_per_byte = 1e-2\n";
    fs::write(desk.path("s.toml"), format!("{SCENARIO}{faults}")).unwrap();
    let link = desk.path("gyro");
    let emulate = |faults: &str| {
        let link = link.to_str().unwrap();
        let arguments = [
            "--link",
            link,
            "--speed",
            "1000",
            "--duration",
            "2",
            "--faults",
            faults,
            "--seed",
            "3",
        ];
        let output = desk.command(&arguments).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stdout).unwrap()
    };
    let said = emulate("a.csv");
    for line in ["unplugged", "plugged in as /dev/pts/", "written to a.csv"] {
        assert!(said.contains(line), "{line}\n{said}");
    }
    let truth = fs::read_to_string(desk.path("a.csv")).unwrap();
    assert!(truth.starts_with("id,fault,kind,stage,start_s,end_s,"), "{truth}");
    assert_eq!(truth.matches(",port-loss,").count(), 1);
    assert!(truth.matches(",bit-flip,").count() > 20, "6600 bytes at 1e-2:\n{truth}");
    emulate("b.csv");
    assert_eq!(fs::read_to_string(desk.path("b.csv")).unwrap(), truth);
}
