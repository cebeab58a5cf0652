//! A port that talks whether somebody listens or not.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use proptest::prelude::*;
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use std::fs;
use std::io::Write as _;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::thread;
use struna_kernel::SimTime;
use struna_line::{
    CharacterFormat, Client, DevicePort, DeviceSettings, LineError, PortCounts, ReadOutcome,
    SerialReader, StopFlag, UartReceiver, VirtualPortError,
};

const BAUD: u32 = 115_200;
const SETTINGS: DeviceSettings = DeviceSettings {
    baud: BAUD,
    format: CharacterFormat { parity: struna_line::Parity::None, stop_bits: 1 },
};
/// Frames in these tests: as long as the default gyro's, and as far apart, ns.
const FRAME_LEN: usize = 11;
const PERIOD_NS: i64 = 3_333_333;
/// Idle reads in a row, of 20 ms each, after which a test gives a byte up for lost. Only how long a
/// failing test takes depends on it.
const IDLE_READS_MAX: usize = 1000;

/// Frame `k`: no two of the first 250 begin alike.
fn frame(k: usize) -> Vec<u8> {
    (0..FRAME_LEN).map(|at| u8::try_from((k + at * 37) % 251).unwrap()).collect()
}

fn frames(range: std::ops::Range<usize>) -> Vec<u8> {
    range.flat_map(frame).collect()
}

fn end_of(k: usize) -> SimTime {
    SimTime::from_ns((i64::try_from(k).unwrap() + 1) * PERIOD_NS)
}

/// Sends frames, each a place to come in at its first byte.
fn send(port: &mut DevicePort, range: std::ops::Range<usize>) {
    for k in range {
        port.send(end_of(k), &frame(k), Some(0)).unwrap();
    }
}

fn plugged() -> DevicePort {
    DevicePort::open(SETTINGS, None).unwrap()
}

fn open(port: &DevicePort, baud: u32) -> SerialReader {
    SerialReader::open(port.path().unwrap(), baud).expect("the port is there and free")
}

fn read_exactly(reader: &mut SerialReader, wanted: usize) -> Vec<u8> {
    let mut taken = Vec::new();
    let mut buffer = [0; 4096];
    let mut idle = 0;
    while taken.len() < wanted {
        let room = (wanted - taken.len()).min(buffer.len());
        match reader.read(&mut buffer[..room]).expect("the port stays") {
            ReadOutcome::Bytes(n) => {
                taken.extend_from_slice(&buffer[..n]);
                idle = 0;
            }
            ReadOutcome::Idle => idle += 1,
        }
        assert!(idle < IDLE_READS_MAX, "{} of {wanted} bytes came", taken.len());
    }
    taken
}

fn assert_nothing_waits(reader: &mut SerialReader) {
    assert_eq!(reader.read(&mut [0; 64]), Ok(ReadOutcome::Idle));
}

#[track_caller]
fn assert_accounted(counts: PortCounts) {
    let PortCounts { sent, passed, unheard, skipped, overrun, garbled, .. } = counts;
    assert_eq!(sent, passed + unheard + skipped + overrun + garbled, "{counts:?}");
}

#[test]
fn a_device_that_nobody_listens_to_talks_to_nobody() {
    let mut port = plugged();
    // Far more than any queue holds, and it never waits.
    for _ in 0..100 {
        send(&mut port, 0..100);
    }
    assert_eq!(port.client(), Client::Absent);
    let counts = port.counts();
    assert_eq!((counts.sent, counts.unheard, counts.clients), (110_000, 110_000, 0));

    let mut reader = open(&port, BAUD);
    assert_nothing_waits(&mut reader);
    send(&mut port, 100..103);
    assert_eq!(port.client(), Client::Present { baud: BAUD, agrees: true });
    assert_eq!(read_exactly(&mut reader, 33), frames(100..103));
    assert_eq!(port.counts().clients, 1);
    assert_accounted(port.counts());
}

#[test]
fn a_client_that_returns_starts_on_a_frame_boundary_and_finds_nothing_stale() {
    let mut port = plugged();
    let mut reader = open(&port, BAUD);
    send(&mut port, 0..10);
    assert_eq!(read_exactly(&mut reader, 20), frames(0..10)[..20]);
    drop(reader);
    send(&mut port, 10..15);
    assert_eq!(port.client(), Client::Absent);

    let mut reader = open(&port, BAUD);
    // A burst of a bridge: the end of frame 15, frame 16, the start of frame 17.
    let burst = &frames(15..18)[5..27];
    port.send(end_of(17), &burst[..6], None).unwrap();
    port.send(end_of(17), &burst[6..], Some(0)).unwrap();
    assert_eq!(read_exactly(&mut reader, 16), burst[6..]);
    assert_nothing_waits(&mut reader);
    let counts = port.counts();
    assert_eq!((counts.unheard, counts.skipped, counts.clients), (55, 6, 2));
    assert_accounted(counts);
}

#[test]
fn what_a_client_leaves_unread_the_next_one_does_not_find() {
    // A few bytes, a page of the line discipline, and the queue behind it full.
    for unread in [1, 400, 3000] {
        let mut port = plugged();
        let reader = open(&port, BAUD);
        send(&mut port, 0..unread);
        drop(reader);
        assert_eq!(port.look().unwrap(), Client::Absent);
        let mut reader = open(&port, BAUD);
        send(&mut port, 200..202);
        assert_eq!(read_exactly(&mut reader, 22), frames(200..202));
        assert_nothing_waits(&mut reader);
    }
}

#[test]
fn a_client_may_be_let_in_within_a_frame() {
    let mut port = plugged();
    let mut reader = open(&port, BAUD);
    port.send(end_of(0), &frame(0), Some(4)).unwrap();
    // Inside once, it gets everything, whatever the entry says.
    port.send(end_of(1), &frame(1), Some(4)).unwrap();
    port.send(end_of(2), &frame(2), None).unwrap();
    assert_eq!(read_exactly(&mut reader, 29), frames(0..3)[4..]);
    // An entry beyond the end lets in after it.
    let mut port = plugged();
    let mut reader = open(&port, BAUD);
    port.send(end_of(0), &frame(0), Some(400)).unwrap();
    port.send(end_of(1), &frame(1), None).unwrap();
    assert_eq!(read_exactly(&mut reader, 11), frame(1));
    assert_accounted(port.counts());
}

#[test]
fn a_client_that_does_not_read_loses_the_newest_bytes() {
    let mut port = plugged();
    let mut reader = open(&port, BAUD);
    let (mut sent, mut passed) = (0, Vec::new());
    while port.counts().overrun < 1000 {
        let before = port.counts().passed;
        send(&mut port, sent..sent + 1);
        // The system may make room again, when it moves what it holds nearer to the reader.
        let room = usize::try_from(port.counts().passed - before).unwrap();
        passed.extend_from_slice(&frame(sent)[..room]);
        sent += 1;
        assert!(sent < 100_000, "the queue has no end");
    }
    assert!(passed.len() >= 4095, "a terminal holds a page, not {} bytes", passed.len());
    assert_accounted(port.counts());
    // Of each frame what there was room for: its first bytes, and none counted that did not come.
    assert!(read_exactly(&mut reader, passed.len()) == passed, "other bytes than those counted");
    assert_nothing_waits(&mut reader);
    send(&mut port, 7..9);
    assert_eq!(read_exactly(&mut reader, 22), frames(7..9));
}

/// What a receiver at `baud` reads of frames sent one period apart, by the pure function.
fn garbled(baud: u32, range: std::ops::Range<usize>) -> Vec<u8> {
    let mut receiver =
        UartReceiver::new(CharacterFormat::default(), f64::from(BAUD), f64::from(baud));
    let mut out = Vec::new();
    let first = range.start;
    for k in range {
        let period_ns = if k == first { end_of(k).as_ns() } else { PERIOD_NS };
        let period_symbols = period_ns as f64 * f64::from(BAUD) / 1e9;
        receiver.receive(period_symbols - 110.0, &frame(k), &mut out);
    }
    out
}

#[test]
fn a_client_at_a_wrong_baud_rate_reads_what_its_receiver_makes_of_the_line() {
    for baud in [9600, 57_600, 100_000, 230_400, 921_600] {
        let mut port = plugged();
        let mut reader = open(&port, baud);
        send(&mut port, 0..200);
        assert_eq!(port.client(), Client::Present { baud, agrees: false });
        let expected = garbled(baud, 0..200);
        assert!(expected.len() > 100, "{} bytes at {baud} baud", expected.len());
        assert_eq!(read_exactly(&mut reader, expected.len()), expected, "{baud} baud");
        assert_nothing_waits(&mut reader);
        let counts = port.counts();
        assert_eq!((counts.garbled, counts.garbage), (2200, expected.len() as u64));
        // No frame of eleven bytes survives in it.
        let intact = |k: &usize| expected.windows(FRAME_LEN).any(|bytes| bytes == frame(*k));
        assert_eq!((0..200).find(intact), None, "{baud} baud");
        assert_accounted(counts);
    }
}

#[test]
fn a_client_that_corrects_its_baud_rate_reads_the_stream() {
    let mut port = plugged();
    let name = port.path().unwrap().to_str().unwrap().to_owned();
    let builder = serialport::new(name, 57_600).timeout(std::time::Duration::from_millis(20));
    let mut client = builder.open().unwrap();
    send(&mut port, 0..3);
    let wrong = port.client();
    assert_eq!(wrong, Client::Present { baud: 57_600, agrees: false });
    let errors = port.counts().errors;
    assert!(errors.framing > 0, "{errors:?}");

    client.set_baud_rate(BAUD).unwrap();
    client.clear(serialport::ClearBuffer::Input).unwrap();
    send(&mut port, 3..6);
    assert_eq!(port.client(), Client::Present { baud: BAUD, agrees: true });
    let mut taken = [0; 33];
    client.read_exact(&mut taken).unwrap();
    assert_eq!(taken, *frames(3..6));
    // Errors of a receiver that is no more stay counted.
    assert_eq!(port.counts().errors, errors);
    // Within two per cent there is nothing to correct.
    client.set_baud_rate(116_500).unwrap();
    send(&mut port, 6..7);
    assert_eq!(port.client(), Client::Present { baud: 116_500, agrees: true });
    assert_accounted(port.counts());
}

#[test]
fn the_output_speed_is_the_one_that_counts() {
    // Older interfaces set no other, and drivers of real ports look at no other.
    let mut port = plugged();
    let client = fs::File::open(port.path().unwrap()).unwrap();
    let mut termios = tcgetattr(&client).unwrap();
    termios.set_output_speed(9600).unwrap();
    tcsetattr(&client, OptionalActions::Now, &termios).unwrap();
    assert_eq!(port.look().unwrap(), Client::Present { baud: 9600, agrees: false });
}

#[test]
fn an_unplugged_device_fails_its_reader_and_returns_under_the_same_link() {
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("vg910d");
    let mut port = DevicePort::open(SETTINGS, Some(&link)).unwrap();
    let mut reader = SerialReader::open(&link, BAUD).unwrap();
    send(&mut port, 0..2);
    assert_eq!(read_exactly(&mut reader, 22), frames(0..2));

    port.unplug();
    assert_eq!((port.client(), port.path()), (Client::Unplugged, None));
    assert!(matches!(reader.read(&mut [0; 64]), Err(LineError::Vanished { .. })));
    assert!(fs::symlink_metadata(&link).is_err(), "the link is still there");
    assert!(matches!(SerialReader::open(&link, BAUD), Err(LineError::NotFound { .. })));
    send(&mut port, 2..4);

    port.plug().unwrap();
    assert_eq!(port.client(), Client::Absent);
    // The old reader stays cut off although its old number may be in use again.
    assert!(matches!(reader.read(&mut [0; 64]), Err(LineError::Vanished { .. })));
    let mut reader = SerialReader::open(&link, BAUD).unwrap();
    assert_eq!(fs::read_link(&link).unwrap(), port.path().unwrap());
    port.plug().unwrap();
    send(&mut port, 4..6);
    assert_eq!(read_exactly(&mut reader, 22), frames(4..6));
    let counts = port.counts();
    assert_eq!((counts.unheard, counts.clients), (22, 2));
    assert_accounted(counts);
    drop(port);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "something was left behind");
}

#[test]
fn a_link_that_is_taken_while_unplugged_keeps_the_device_out() {
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("vg910d");
    let mut port = DevicePort::open(SETTINGS, Some(&link)).unwrap();
    port.unplug();
    fs::write(&link, "text").unwrap();
    let error = port.plug().unwrap_err();
    assert!(matches!(error, VirtualPortError::Link { .. }), "{error:?}");
    assert_eq!((port.client(), port.path()), (Client::Unplugged, None));
    fs::remove_file(&link).unwrap();
    port.plug().unwrap();
    assert!(link.exists());
}

#[track_caller]
fn link_refused(link: &Path, said: &str) {
    let error = DevicePort::open(SETTINGS, Some(link)).unwrap_err();
    assert!(matches!(error, VirtualPortError::Link { .. }), "{error:?}");
    let message = error.to_string();
    let remedy = "give a free path in an existing directory that you may write";
    for part in [link.to_str().unwrap(), said, remedy] {
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn a_link_is_refused_where_it_would_replace_something() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "text").unwrap();
    link_refused(&file, "not a symbolic link");
    assert_eq!(fs::read(&file).unwrap(), b"text");
    link_refused(folder.path(), "not a symbolic link");
    link_refused(&folder.path().join("no/such/folder"), "No such file");

    let link = folder.path().join("vg910d");
    let first = DevicePort::open(SETTINGS, Some(&link)).unwrap();
    let device = first.path().unwrap().to_str().unwrap();
    link_refused(&link, &format!("a link to {device} is there; end the emulator that made it"));
    assert_eq!(fs::read_link(&link).unwrap(), Path::new(device));
    drop(first);
    // What a crashed emulator leaves behind is in nobody's way.
    symlink("/dev/pts/does-not-exist", &link).unwrap();
    DevicePort::open(SETTINGS, Some(&link)).unwrap();
}

#[test]
fn a_device_waits_for_its_client_until_stopped() {
    let mut port = plugged();
    let stopped = StopFlag::new();
    stopped.stop();
    assert!(!port.wait_for_client(&stopped).unwrap());
    let path = port.path().unwrap().to_owned();
    let reader = thread::spawn(move || SerialReader::open(&path, BAUD).unwrap());
    assert!(port.wait_for_client(&StopFlag::new()).unwrap());
    drop(reader.join().unwrap());
    assert!(!port.wait_for_client(&stopped).unwrap());
}

#[test]
fn what_a_client_sends_is_taken_and_counted() {
    let mut port = plugged();
    let mut device = fs::OpenOptions::new().write(true).open(port.path().unwrap()).unwrap();
    let mut commands = 0;
    // Many times what a line holds: were it not taken, this would never end.
    for _ in 0..100 {
        device.write_all(&[0x5A; 1000]).unwrap();
        commands += 1000;
        while port.counts().commands < commands {
            port.look().unwrap();
        }
    }
    assert_eq!((port.counts().commands, port.counts().sent), (100_000, 0));
}

#[test]
fn a_lingering_device_lets_its_client_read_to_the_end() {
    for round in 0..50 {
        let mut port = plugged();
        let count = 200 + round;
        let path = port.path().unwrap().to_owned();
        let taken = thread::scope(|scope| {
            let reading = scope.spawn(move || {
                let mut reader = SerialReader::open(&path, BAUD).unwrap();
                read_exactly(&mut reader, count * FRAME_LEN)
            });
            assert!(port.wait_for_client(&StopFlag::new()).unwrap());
            send(&mut port, 0..count);
            port.linger(&StopFlag::new()).unwrap();
            drop(port);
            reading.join().unwrap()
        });
        assert_eq!(taken, frames(0..count), "round {round}");
    }
}

/// What may happen to a port.
#[derive(Debug, Clone, Copy)]
enum Turn {
    Open(u32),
    Close,
    Send(usize, Option<usize>),
    Read,
    Unplug,
    Plug,
}

fn turn() -> impl Strategy<Value = Turn> {
    prop_oneof![
        2 => prop_oneof![Just(BAUD), Just(9600), Just(116_000)].prop_map(Turn::Open),
        1 => Just(Turn::Close),
        8 => (0..300_usize, proptest::option::of(0..300_usize))
            .prop_map(|(len, entry)| Turn::Send(len, entry)),
        2 => Just(Turn::Read),
        1 => Just(Turn::Unplug),
        2 => Just(Turn::Plug),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]
    #[test]
    fn every_byte_is_accounted_for_whatever_happens(
        turns in proptest::collection::vec(turn(), 1..60),
    ) {
        let mut port = plugged();
        let mut reader = None;
        let mut sent = 0;
        for (k, turn) in turns.into_iter().enumerate() {
            match turn {
                Turn::Open(baud) => {
                    drop(reader.take());
                    reader = port.path().map(|path| SerialReader::open(path, baud).unwrap());
                }
                Turn::Close => reader = None,
                Turn::Send(len, entry) => {
                    sent += len as u64;
                    port.send(end_of(k), &vec![0x35; len], entry).unwrap();
                }
                // An unplugged port is an error to its reader and nothing to us.
                Turn::Read => drop(reader.as_mut().map(|reader| reader.read(&mut [0; 999]))),
                Turn::Unplug => port.unplug(),
                Turn::Plug => port.plug().unwrap(),
            }
            prop_assert_eq!(port.counts().sent, sent);
            assert_accounted(port.counts());
        }
    }
}
