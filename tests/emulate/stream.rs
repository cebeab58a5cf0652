//! What passes through the port is what the emulator says, at whatever times.

use crate::{SCENARIO, edited, mems};
use std::path::{Path, PathBuf};
use std::thread;
use struna::emulate::{Device, Emission, Emulation, Entry, Status, Summary, Watcher};
use struna::scenario::Scenario;
use struna_harness::LineEvent;
use struna_line::{DevicePort, Pacer, ReadOutcome, SerialReader, StopFlag};
use struna_wire::Decoder;

/// Idle reads in a row, of 20 ms each, after which a test gives a byte up for lost. Only how long a
/// failing test takes depends on it.
const IDLE_READS_MAX: u32 = 1000;

fn scenario(text: &str) -> Scenario {
    Scenario::parse(text, Path::new("s.toml")).unwrap_or_else(|error| panic!("{error}"))
}

/// The bytes of a run that looks at no clock.
fn unpaced(scenario: &Scenario) -> Vec<u8> {
    let mut transmitter = Device::new(scenario).unwrap().transmitter;
    let mut bytes = Vec::new();
    let mut take = |_, event: LineEvent<'_>| {
        if let LineEvent::Bytes(arrived) = event {
            bytes.extend_from_slice(arrived);
        }
    };
    for _ in 0..Device::frames(scenario, scenario.duration).unwrap() {
        transmitter.emit(&mut take).unwrap();
    }
    transmitter.flush(&mut take);
    bytes
}

/// Remembers what it is told.
#[derive(Default)]
struct Notes {
    emissions: Vec<Emission>,
}

impl Watcher for Notes {
    fn status(&mut self, _: &Status<'_>) {}

    fn emitted(&mut self, emission: Emission) -> anyhow::Result<()> {
        self.emissions.push(emission);
        Ok(())
    }
}

/// Plays `scenario` in real time to a client that reads by path until it has `wanted` bytes.
fn played(scenario: &Scenario, entry: Entry, wanted: usize) -> (Vec<u8>, Summary, Notes) {
    let device = Device::new(scenario).unwrap();
    let frames = Device::frames(scenario, scenario.duration).unwrap();
    let mut port = DevicePort::open(device.settings, None).unwrap();
    let (path, baud) = (port.path().unwrap().to_owned(), device.settings.baud);
    let reading = thread::spawn(move || read(path, baud, wanted));
    let stop = StopFlag::new();
    assert!(port.wait_for_client(&stop).unwrap());
    let pacer = Pacer::start();
    let mut notes = Notes::default();
    let emulation = Emulation { device, port, pacer, entry, stop: &stop };
    let summary = emulation.play(frames, &mut notes).unwrap();
    (reading.join().unwrap(), summary, notes)
}

fn read(path: PathBuf, baud: u32, wanted: usize) -> Vec<u8> {
    let mut reader = SerialReader::open(&path, baud).unwrap();
    let (mut bytes, mut buffer, mut idle) = (Vec::new(), [0; 4096], 0);
    while bytes.len() < wanted && idle < IDLE_READS_MAX {
        match reader.read(&mut buffer) {
            Ok(ReadOutcome::Bytes(n)) => {
                bytes.extend_from_slice(&buffer[..n]);
                idle = 0;
            }
            Ok(ReadOutcome::Idle) => idle += 1,
            Err(_) => break,
        }
    }
    bytes
}

/// All frames of a second in real time: fewer bytes than a terminal holds, so that a reader loses
/// none even if it sleeps all the while.
#[track_caller]
fn every_frame_passes(text: &str, rate_hz: u64) {
    let scenario = scenario(text);
    let sent = unpaced(&scenario);
    let (read, summary, notes) = played(&scenario, Entry::FrameBoundary, sent.len());
    assert!(read == sent, "{} of {} bytes came, or other ones", read.len(), sent.len());
    assert_eq!((summary.frames, summary.interrupted), (rate_hz, false));
    let counts = summary.counts;
    assert_eq!((counts.sent, counts.passed), (sent.len() as u64, sent.len() as u64));

    let mut decoder = Decoder::new(scenario.frame.clone());
    let mut next = 0;
    decoder.push(&read, &mut |frame| {
        assert_eq!(frame.index, next, "in order");
        next += 1;
    });
    let wire = decoder.finish();
    assert_eq!((wire.ok, wire.lost, wire.bad_check, wire.skipped_bytes), (rate_hz, 0, 0, 0));

    // Nothing arrives before its time, and every frame is told of, in order.
    let mut last_ns = i64::MIN;
    for (index, emission) in (0..).zip(&notes.emissions) {
        let Emission { index: told, sample_ns, due_ns, sent_ns } = *emission;
        assert_eq!(told, index);
        assert!(sample_ns < due_ns && due_ns <= sent_ns && last_ns <= sent_ns, "{emission:?}");
        last_ns = sent_ns;
    }
    assert_eq!(notes.emissions.len() as u64, rate_hz);
}

#[test]
fn a_300_hz_gyro_in_real_time_sends_the_bytes_of_an_unpaced_run() {
    every_frame_passes(SCENARIO, 300);
}

#[test]
fn a_1400_hz_gyro_in_real_time_sends_the_bytes_of_an_unpaced_run() {
    every_frame_passes(&mems(), 1400);
}

#[test]
fn a_usb_bridge_changes_when_bytes_arrive_and_not_which() {
    let bridged = edited(SCENARIO, &[("[line]", "[line]\nbridge = \"ftdi\"")]);
    let scenario = scenario(&bridged);
    let plain = unpaced(&self::scenario(SCENARIO));
    assert!(unpaced(&scenario) == plain);
    let (read, _, notes) = played(&scenario, Entry::FrameBoundary, plain.len());
    assert!(read == plain);
    // 3300 bytes in a second never fill a packet within 16 ms: a burst for each timer period.
    let mut bursts: Vec<_> = notes.emissions.iter().map(|emission| emission.due_ns).collect();
    bursts.dedup();
    assert!((61..=64).contains(&bursts.len()), "{} bursts", bursts.len());
}

#[test]
fn a_client_let_in_within_a_frame_loses_that_frame_alone() {
    let scenario = scenario(SCENARIO);
    let sent = unpaced(&scenario);
    let (read, summary, _) = played(&scenario, Entry::MidFrame, sent.len() - 5);
    assert!(read == sent[5..], "{} bytes", read.len());
    assert_eq!((summary.counts.skipped, summary.counts.overrun), (5, 0));
    let mut decoder = Decoder::new(scenario.frame.clone());
    let mut frames = 0;
    decoder.push(&read, &mut |_| frames += 1);
    assert_eq!((frames, decoder.finish().skipped_bytes), (299, 6));
}

#[test]
fn a_line_that_cannot_carry_the_frames_is_refused() {
    let gyro = "preset = \"vg910d\"\nsample_rate_hz = 1400.0";
    let scenario = scenario(&edited(SCENARIO, &[("preset = \"vg910d\"", gyro)]));
    let error = Device::new(&scenario).unwrap_err().to_string();
    let said = "1400 frames of struna/vg910d@1 per second need 154000 baud and the line has \
                115200; raise `baud` in [line] or lower `sample_rate_hz` in [gyro]";
    assert_eq!(error, said);
}
