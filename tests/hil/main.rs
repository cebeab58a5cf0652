//! Live runs: what a record holds when ports come and go, bytes are damaged, and people stop.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a failed unwrap fails the test")]

mod program;
mod script;
mod three_axes;

use script::{Script, Step, carried, complete_ns, frames};
use std::fs;
use std::path::Path;
use struna::hil::recorder::{Screen, Status};
use struna::hil::setup::{Setup, frame_text};
use struna::hil::{self, Bench, Finished};
use struna_harness::live::Ended;
use struna_kernel::SimTime;
use struna_line::StopFlag;
use struna_wire::FrameSpec;
use tempfile::TempDir;

const RATE_RAD_S: f64 = 0.25;

/// Keeps what it is told.
#[derive(Default)]
struct Notes {
    said: Vec<String>,
    shown: usize,
}

impl Screen for Notes {
    fn status(&mut self, _status: &Status<'_>) {
        self.shown += 1;
    }

    fn say(&mut self, text: &str) {
        self.said.push(text.to_owned());
    }
}

fn setup() -> Setup {
    Setup::new(Some(frame_text("struna/vg910d@1").unwrap()), None)
}

fn spec() -> FrameSpec {
    setup().plan().unwrap().frame
}

/// A finished live run and its folder.
struct Live {
    folder: TempDir,
    finished: Finished,
    said: Vec<String>,
    attempts_ns: Vec<i64>,
}

impl Live {
    /// Plays `steps` for `seconds`.
    fn play(steps: Vec<(i64, Step)>, seconds: f64, strict: bool) -> Self {
        Self::play_as(&setup(), steps, seconds, strict)
    }

    /// The same, decoded as `setup` says.
    fn play_as(setup: &Setup, steps: Vec<(i64, Step)>, seconds: f64, strict: bool) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let stop = StopFlag::new();
        let (mut source, mut clock) = Script::new(steps, &stop);
        let mut notes = Notes::default();
        let until = Some(SimTime::from_s(seconds).unwrap());
        let bench = Bench { out: folder.path(), screen: &mut notes, stop: &stop, until, strict };
        let finished = hil::run(setup, "script", &mut source, &mut clock, bench).unwrap();
        assert!(notes.shown as f64 > 5.0 * seconds.min(1.0), "shown {} times", notes.shown);
        let attempts_ns = source.attempts_ns.borrow().clone();
        Self { folder, finished, said: notes.said, attempts_ns }
    }

    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.folder.path().join(name)).unwrap()
    }

    fn report(&self) -> serde_json::Value {
        serde_json::from_str(&self.text("report.json")).unwrap()
    }

    /// Rows of the record: time, rate, over range, lost, then the integration's angle.
    fn rows(&self) -> Vec<Vec<f64>> {
        let numbers = |line: &str| line.split(',').map(|cell| cell.parse().unwrap()).collect();
        self.text("record.csv").lines().skip(1).map(numbers).collect()
    }

    fn events(&self, kind: &str) -> Vec<String> {
        let of_kind = |line: &&str| line.split(',').nth(2) == Some(kind);
        self.text("events.csv").lines().filter(of_kind).map(str::to_owned).collect()
    }

    /// The record when the bytes are decoded again.
    fn replayed(&self) -> String {
        let again = tempfile::tempdir().unwrap();
        let setup = Setup::read(&self.folder.path().join(hil::SETUP)).unwrap();
        let mut notes = Notes::default();
        hil::replay(&setup, self.folder.path(), again.path(), &mut notes).unwrap();
        fs::read_to_string(again.path().join("record.csv")).unwrap()
    }
}

fn assert_no_parts(folder: &Path) {
    for entry in fs::read_dir(folder).unwrap() {
        let name = entry.unwrap().file_name();
        assert!(!name.to_string_lossy().starts_with('.'), "{} is left", name.display());
    }
}

#[test]
fn a_steady_gyro_gives_a_steady_record() {
    let live = Live::play(frames(&spec(), 9000, RATE_RAD_S), 31.0, false);
    let rows = live.rows();
    assert_eq!(rows.len(), 3000);
    let last = &rows[2999];
    // The time starts with the first sample and runs by the gyro's clock as the host sees it. The
    // first arrivals are up to 0.18 ms more delayed than the least delayed ones.
    let true_s = complete_ns(8999) as f64 / 1e9;
    assert!((last[0] - true_s).abs() < 2e-4, "{} for {true_s}", last[0]);
    assert!((last[4] - last[0] * carried(&spec(), RATE_RAD_S)).abs() < 1e-9, "{last:?}");
    let report = live.report();
    assert_eq!(report["line"]["frames_ok"], 9000);
    assert_eq!(report["line"]["samples_lost_on_line"], 0);
    let skew = report["skew_ppm"].as_f64().unwrap();
    // The script's period is 3333667 ns for 1/300 s.
    assert!((skew - 100.1).abs() < 1.0, "{skew} ppm");
    assert_eq!(live.finished.ended, Ended::TimeUp);
    assert_no_parts(live.folder.path());
    assert_eq!(live.replayed(), live.text("record.csv"));
}

/// 20 s of frames; the plug is out from 8.0 s to 11.3 s.
fn with_outage() -> Vec<(i64, Step)> {
    let mut steps = frames(&spec(), 6000, RATE_RAD_S);
    steps.retain(|(ns, _)| !(8_000_000_000..11_300_000_000).contains(ns));
    steps.push((8_000_000_000, Step::Unplug));
    steps.push((11_300_000_000, Step::Plug));
    steps
}

#[test]
fn a_port_that_goes_and_comes_back_is_one_gap() {
    let live = Live::play(with_outage(), 21.0, false);
    assert_eq!(live.events("gap").len(), 1, "{}", live.text("events.csv"));
    assert_eq!((live.events("port-lost").len(), live.events("port-back").len()), (1, 1));
    // 0.1, 0.3, 0.7, 1.5, 3.1 s after the loss, and 2 s later, not 3.2 s.
    let after: Vec<_> =
        live.attempts_ns.iter().map(|ns| (ns - 8_000_000_000) as f64 / 1e9).collect();
    let expected = [0.1, 0.3, 0.7, 1.5, 3.1, 5.1];
    assert_eq!(after.len(), expected.len(), "{after:?}");
    // Waits are cut into pieces, of which the last is a whole one.
    assert!(after.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.1), "{after:?}");

    let rows = live.rows();
    let last = &rows[rows.len() - 1];
    let true_s = complete_ns(5999) as f64 / 1e9;
    assert!((last[0] - true_s).abs() < 2e-4, "{} for {true_s}", last[0]);
    // The rate never changed, so the angle carried over the gap is right too.
    assert!((last[4] - last[0] * carried(&spec(), RATE_RAD_S)).abs() < 1e-9, "{last:?}");
    let steps: Vec<_> = rows.windows(2).map(|pair| pair[1][0] - pair[0][0]).collect();
    let gaps = steps.iter().filter(|step| **step > 0.02).count();
    assert!(gaps == 1 && steps.iter().all(|step| *step > 0.0), "{gaps} gaps");
    let lost: f64 = rows.iter().map(|row| row[3]).sum();
    let report = live.report();
    assert_eq!(report["line"]["samples_lost_with_port"].as_f64(), Some(lost));
    assert_eq!(report["line"]["samples_lost_on_line"], 0);
    let ok = report["line"]["frames_ok"].as_f64().unwrap();
    assert!((ok + lost - 6000.0).abs() < f64::EPSILON, "{ok} good, {lost} lost");
    assert_eq!(live.replayed(), live.text("record.csv"));
}

#[test]
fn a_port_that_never_comes_back_leaves_its_gap_and_the_record_so_far() {
    let mut steps = frames(&spec(), 3000, RATE_RAD_S);
    steps.push((8_000_000_000, Step::Unplug));
    let live = Live::play(steps, 12.0, false);
    assert_eq!(live.events("gap").len(), 1);
    assert!(live.rows().len() > 790);
    assert_no_parts(live.folder.path());
    assert_eq!(live.replayed(), live.text("record.csv"));
}

/// Damages every `every`-th frame, and puts noise with sync bytes in before it.
fn damaged(every: usize) -> (Vec<(i64, Step)>, u64) {
    let mut steps = frames(&spec(), 6000, RATE_RAD_S);
    let mut lost = 0;
    for (k, (_, step)) in steps.iter_mut().enumerate().skip(every) {
        let Step::Bytes(bytes) = step else { continue };
        if k % every == 0 {
            bytes[5] ^= 1 << (k / every % 8);
            bytes.splice(0..0, [0xA5, 0x5A, 0xA5, 0x00]);
            lost += 1;
        }
    }
    (steps, lost)
}

#[test]
fn damaged_frames_are_lost_frames_and_nothing_else_is() {
    let (steps, lost) = damaged(83);
    let live = Live::play(steps, 21.0, false);
    let report = live.report();
    assert_eq!(report["line"]["samples_lost_on_line"], lost);
    assert_eq!(report["line"]["frames_ok"], 6000 - lost);
    // Each is a gap of its own, of one sample.
    assert_eq!(live.events("gap").len() as u64, lost);
    assert_eq!(report["gaps"][0]["gaps"], lost);
    let rate = &report["frame_error_rate"];
    let bound = |key: &str| rate[key].as_f64().unwrap();
    assert!(bound("low") < 1.0 / 83.0 && 1.0 / 83.0 < bound("high"), "{rate}");
    let rows = live.rows();
    assert_eq!(rows.len(), 2000, "a thinned group is still a row");
    assert_eq!(live.replayed(), live.text("record.csv"));
}

#[test]
fn a_silence_longer_than_the_counter_is_counted_by_time() {
    let mut steps = frames(&spec(), 6000, RATE_RAD_S);
    // 1234 frames: four turns of the counter and 210.
    let silent = complete_ns(3000)..complete_ns(4234);
    steps.retain(|(ns, _)| !silent.contains(ns));
    let live = Live::play(steps, 21.0, false);
    let gaps = live.events("gap");
    assert_eq!(gaps.len(), 1, "{gaps:?}");
    assert!(gaps[0].contains("1234 samples") && gaps[0].contains("counter and time"), "{gaps:?}");
    assert_eq!(live.replayed(), live.text("record.csv"));
}

#[test]
fn a_stop_from_outside_keeps_everything() {
    let mut steps = frames(&spec(), 6000, RATE_RAD_S);
    steps.push((7_000_000_000, Step::Stop));
    let live = Live::play(steps, 21.0, false);
    assert_eq!(live.finished.ended, Ended::Stopped);
    assert_eq!(live.report()["interrupted"], true);
    // 7 s at a little less than 300 Hz, averaged by three.
    assert_eq!(live.rows().len(), 699);
    assert_no_parts(live.folder.path());
    assert_eq!(live.replayed(), live.text("record.csv"));
}

#[test]
fn another_device_is_told_once_and_ends_a_strict_run() {
    let noise = |k: i64| (k * 10_000_000, Step::Bytes(vec![(k % 251).to_le_bytes()[0]; 33]));
    let steps: Vec<_> = (0..400).map(noise).collect();
    let patient = Live::play(steps.clone(), 4.0, false);
    assert_eq!((patient.finished.ended, patient.events("no-frames").len()), (Ended::TimeUp, 1));
    assert!(patient.said.iter().any(|said| said.contains("probably another frame")));
    let strict = Live::play(steps, 4.0, true);
    assert_eq!(strict.finished.ended, Ended::NoFrames);
    assert!(strict.rows().is_empty());
    let silent = Live::play(Vec::new(), 4.0, true);
    assert!(silent.said[0].contains("nothing is sent"), "{:?}", silent.said);
}
