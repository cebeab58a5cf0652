//! The program itself, on a pseudo-terminal that speaks the frame in real time.

use crate::script::{Step, frames};
use crate::{spec, three_axes};
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::thread::{self, JoinHandle};
use struna_kernel::SimTime;
use struna_line::{Pacer, StopFlag, VirtualPort, Waited};
use tempfile::TempDir;

const STRUNA: &str = env!("CARGO_BIN_EXE_struna");
/// Long enough for any run here; the gyro stops with its test.
const FRAMES: i64 = 300 * 60;

/// A gyro behind a link, until dropped.
struct Gyro {
    folder: TempDir,
    stop: StopFlag,
    thread: Option<JoinHandle<()>>,
}

impl Gyro {
    fn new() -> Self {
        Self::playing(frames(&spec(), FRAMES, crate::RATE_RAD_S))
    }

    /// A gyro that sends these.
    fn playing(steps: Vec<(i64, Step)>) -> Self {
        let folder = tempfile::tempdir().unwrap();
        // Where `XDG_RUNTIME_DIR` is looked into.
        let links = folder.path().join("struna");
        fs::create_dir(&links).unwrap();
        let mut port = VirtualPort::open().unwrap();
        port.link_at(&links.join("vg910d")).unwrap();
        let stop = StopFlag::new();
        let stopped = stop.clone();
        let thread = thread::spawn(move || {
            let mut pacer = Pacer::start();
            for (ns, step) in steps {
                let Step::Bytes(bytes) = step else { continue };
                let waited = pacer.wait_until(SimTime::from_ns(ns), &stopped);
                if waited == Waited::Stopped || port.write_all(&bytes, &stopped).is_err() {
                    return;
                }
            }
        });
        Self { folder, stop, thread: Some(thread) }
    }

    fn link(&self) -> PathBuf {
        self.folder.path().join("struna/vg910d")
    }

    fn out(&self) -> PathBuf {
        self.folder.path().join("out")
    }

    /// The program, told where the gyro's link is.
    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(STRUNA);
        command.args(arguments).env("XDG_RUNTIME_DIR", self.folder.path());
        command.current_dir(self.folder.path());
        command
    }

    fn hil(&self, port: &str, more: &[&str]) -> Command {
        let out = self.out();
        let mut command = self.command(&["hil", "--port", port, "--frame", "struna/vg910d@1"]);
        command.arg("--out").arg(out).args(more);
        command
    }
}

impl Drop for Gyro {
    fn drop(&mut self) {
        self.stop.stop();
        if let Some(thread) = self.thread.take() {
            // A gyro that panicked has failed its test already.
            drop(thread.join());
        }
    }
}

fn text_of(output: &Output) -> String {
    let (out, err) = (&output.stdout, &output.stderr);
    format!("{}{}", String::from_utf8_lossy(out), String::from_utf8_lossy(err))
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

#[test]
fn a_live_run_and_its_replay_give_the_same_record() {
    let gyro = Gyro::new();
    let link = gyro.link().display().to_string();
    let run = gyro.hil(&link, &["--duration", "1.5"]).output().unwrap();
    assert!(run.status.success(), "{}", text_of(&run));
    let record = read(&gyro.out().join("record.csv"));
    assert!(record.lines().count() > 10, "{record}");
    assert!(text_of(&run).contains("0 bad checks"), "{}", text_of(&run));
    let out = gyro.out().display().to_string();
    let again = gyro.command(&["hil", "--replay", &out]).output().unwrap();
    assert!(again.status.success(), "{}", text_of(&again));
    assert_eq!(read(&gyro.out().join("replay/record.csv")), record);
    let onto_itself = gyro.command(&["hil", "--replay", &out, "--out", &out]).output().unwrap();
    assert_eq!(onto_itself.status.code(), Some(1));
    assert_eq!(read(&gyro.out().join("record.csv")), record);
}

#[test]
fn three_rates_are_heard_on_a_port() {
    let gyro = Gyro::playing(three_axes::frames(10.0));
    let link = gyro.link().display().to_string();
    let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/three-axes.toml");
    let out = gyro.out().display().to_string();
    let run = gyro
        .command(&["hil", "--port", &link, "--duration", "1.5", "--out", &out, "--scenario"])
        .arg(scenario)
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", text_of(&run));
    let record = read(&gyro.out().join("record.csv"));
    assert!(record.starts_with(three_axes::COLUMNS), "{record}");
    assert!(record.lines().count() > 10, "{record}");
    let again = gyro.command(&["hil", "--replay", &out]).output().unwrap();
    assert!(again.status.success(), "{}", text_of(&again));
    assert_eq!(read(&gyro.out().join("replay/record.csv")), record);
}

#[test]
fn the_only_port_is_found_by_itself_and_ctrl_c_keeps_the_record() {
    let gyro = Gyro::new();
    let mut child =
        gyro.hil("auto", &[]).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    let said = lines.next().unwrap().unwrap();
    assert!(said.contains("listening to") && said.contains("vg910d"), "{said}");
    let pid = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    for name in ["record.csv", "events.csv", "raw.bin", "raw.csv", "report.json", "setup.json"] {
        assert!(gyro.out().join(name).exists(), "no {name}");
    }
    assert!(read(&gyro.out().join("report.json")).contains("\"interrupted\": true"));
}

#[test]
fn a_full_disk_keeps_what_fitted() {
    let gyro = Gyro::new();
    let link = gyro.link().display().to_string();
    let hil = gyro.hil(&link, &["--duration", "30"]);
    // Files may grow to 8 KiB; a write beyond is refused, as on a full disk.
    let mut limited = Command::new("bash");
    limited.args(["-c", "trap '' XFSZ; ulimit -f 8; exec \"$@\"", "bash", STRUNA]);
    limited.args(hil.get_args()).env("XDG_RUNTIME_DIR", gyro.folder.path());
    let run = limited.output().unwrap();
    assert_eq!(run.status.code(), Some(1), "{}", text_of(&run));
    let said = text_of(&run);
    assert!(said.contains("recorded so far in") && said.contains("cannot write"), "{said}");
    let record = read(&gyro.out().join("record.csv"));
    let columns = record.lines().next().unwrap().split(',').count();
    assert!(record.lines().count() > 20 && record.ends_with('\n'), "{record}");
    assert!(record.lines().all(|line| line.split(',').count() == columns), "{record}");
    crate::assert_no_parts(&gyro.out());
}

#[test]
fn ports_are_listed_with_who_has_them() {
    let gyro = Gyro::new();
    let listed = gyro.command(&["ports", "--json"]).output().unwrap();
    let listed: serde_json::Value = serde_json::from_slice(&listed.stdout).unwrap();
    let link = gyro.link().display().to_string();
    let port = listed.as_array().unwrap().iter().find(|port| port["name"] == link).unwrap();
    assert_eq!((&port["kind"], &port["access"]), (&"virtual".into(), &"free".into()));
    let mut child = gyro.hil(&link, &[]).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    assert!(lines.next().unwrap().unwrap().contains("listening"));
    let taken = text_of(&gyro.command(&["ports"]).output().unwrap());
    assert!(taken.contains(&format!("in use by struna (process {})", child.id())), "{taken}");
    let second = gyro.hil(&link, &[]).output().unwrap();
    assert_eq!(second.status.code(), Some(1));
    assert!(text_of(&second).contains("in use"), "{}", text_of(&second));
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn what_cannot_be_listened_to_is_refused_with_what_is_there() {
    let gyro = Gyro::new();
    let link = gyro.link().display().to_string();
    let refused = |arguments: &[&str]| {
        let output = gyro.command(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{}", text_of(&output));
        text_of(&output)
    };
    let hil = |port: &str, frame: &str| refused(&["hil", "--port", port, "--frame", frame]);
    let missing = hil("/dev/ttyUSB99", "struna/vg910d@1");
    assert!(missing.contains("no port /dev/ttyUSB99") && missing.contains(&link), "{missing}");
    let frame = hil(&link, "struna/unknown@1");
    assert!(frame.contains("struna/vg910d@1"), "{frame}");
    let nothing = refused(&["hil", "--port", &link]);
    assert!(nothing.contains("--frame"), "{nothing}");
    let no_run = refused(&["hil", "--replay", "nowhere"]);
    assert!(no_run.contains("nowhere/setup.json"), "{no_run}");
}
