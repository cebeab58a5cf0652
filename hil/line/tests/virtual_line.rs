//! Bytes through a pseudo-terminal, read with the code that reads a real port.

use std::fs;
use std::io::Write as _;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::thread;
use struna_line::{LineError, ReadOutcome, SerialReader, StopFlag, VirtualPort, VirtualPortError};

/// Byte `k` of a stream whose every stretch of eight is different for longer than any test.
fn byte(k: usize) -> u8 {
    (k as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15).to_be_bytes()[0]
}

fn bytes(range: std::ops::Range<usize>) -> Vec<u8> {
    range.map(byte).collect()
}

fn open(path: &Path) -> SerialReader {
    SerialReader::open(path, 115_200).expect("the port is there and free")
}

/// Idle reads in a row, of 20 ms each, after which a test gives a byte up for lost. Only how long a
/// failing test takes depends on it.
const IDLE_READS_MAX: usize = 1000;

/// Reads exactly `wanted` bytes, in pieces of at most `piece(k)`.
fn read_exactly(
    reader: &mut SerialReader,
    wanted: usize,
    piece: impl Fn(usize) -> usize,
) -> Vec<u8> {
    let mut taken = Vec::new();
    let mut buffer = [0; 4096];
    let mut idle = 0;
    for k in 0.. {
        let room = (wanted - taken.len()).min(piece(k));
        if room == 0 {
            break;
        }
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

#[test]
fn every_byte_value_passes_unchanged_both_ways() {
    let mut port = VirtualPort::open().unwrap();
    let stop = StopFlag::new();
    let mut reader = open(port.path());
    // Twice over, so that pairs such as CR LF and a doubled 0xFF are met as well.
    let all: Vec<u8> = (0..=255).chain((0..=255).rev()).collect();
    port.write_all(&all, &stop).unwrap();
    assert_eq!(read_exactly(&mut reader, all.len(), |_| 64), all);
    assert_nothing_waits(&mut reader);

    let mut device = fs::OpenOptions::new().write(true).open(port.path());
    if let Ok(device) = &mut device {
        device.write_all(&all).unwrap();
    } else {
        // An exclusive port refuses a second opening to all but the superuser.
        drop(reader);
        fs::OpenOptions::new().write(true).open(port.path()).unwrap().write_all(&all).unwrap();
    }
    let mut received = vec![0; all.len()];
    let mut have = 0;
    while have < all.len() {
        have += port.receive(&mut received[have..], &stop).unwrap();
    }
    assert_eq!(received, all);
}

#[test]
fn what_is_read_is_not_echoed_back() {
    let mut port = VirtualPort::open().unwrap();
    let stop = StopFlag::new();
    port.write_all(b"ping\r\n", &stop).unwrap();
    assert_eq!(read_exactly(&mut open(port.path()), 6, |_| 6), b"ping\r\n");
    stop.stop();
    let outcome = port.receive(&mut [0; 8], &stop);
    assert!(matches!(outcome, Err(VirtualPortError::Stopped { done: 0 })), "{outcome:?}");
}

#[test]
fn a_slow_reader_loses_nothing() {
    const TOTAL: usize = 4_000_000;
    let mut port = VirtualPort::open().unwrap();
    let path = port.path().to_owned();
    thread::scope(|scope| {
        scope.spawn(move || {
            let stop = StopFlag::new();
            // Frame-sized writes and large ones.
            let mut sent = 0;
            for size in [11, 4096, 1, 62, 100_000].into_iter().cycle() {
                let end = (sent + size).min(TOTAL);
                port.write_all(&bytes(sent..end), &stop).unwrap();
                sent = end;
                if sent == TOTAL {
                    break;
                }
            }
            // Dropping the port discards what is unread, so this is part of the promise.
            port.drain(&stop).unwrap();
        });
        let mut reader = open(&path);
        let taken = read_exactly(&mut reader, TOTAL, |k| 1 + k % 100);
        assert_eq!(taken.len(), TOTAL);
        let wrong = taken.iter().enumerate().find(|(k, taken)| **taken != byte(*k));
        assert_eq!(wrong, None);
    });
}

#[test]
fn bytes_sent_before_the_reader_opens_wait_for_it() {
    let mut port = VirtualPort::open().unwrap();
    let stop = StopFlag::new();
    port.write_all(&bytes(0..1000), &stop).unwrap();
    let mut reader = open(port.path());
    assert_eq!(read_exactly(&mut reader, 400, |_| 400), bytes(0..400));
    drop(reader);
    port.write_all(&bytes(1000..1500), &stop).unwrap();
    assert_eq!(read_exactly(&mut open(port.path()), 1100, |_| 77), bytes(400..1500));
}

#[test]
fn draining_ends_only_when_everything_is_taken() {
    // Many short rounds, because a drain that ends early does so in a window of microseconds.
    for round in 0..300 {
        let mut port = VirtualPort::open().unwrap();
        let path = port.path().to_owned();
        let count = 9000 + round * 37;
        let taken = thread::scope(|scope| {
            let reading = scope.spawn(move || {
                let mut reader = open(&path);
                let mut taken = Vec::new();
                let mut buffer = [0; 4096];
                loop {
                    match reader.read(&mut buffer) {
                        Ok(ReadOutcome::Bytes(n)) => taken.extend_from_slice(&buffer[..n]),
                        Ok(ReadOutcome::Idle) => {}
                        Err(_) => return taken,
                    }
                }
            });
            let stop = StopFlag::new();
            port.write_all(&bytes(0..count), &stop).unwrap();
            port.drain(&stop).unwrap();
            drop(port);
            reading.join().unwrap()
        });
        assert_eq!(taken.len(), count, "round {round}");
        assert_eq!(taken, bytes(0..count));
    }
}

#[test]
fn a_writer_without_a_reader_can_be_stopped() {
    let mut port = VirtualPort::open().unwrap();
    let stopped = StopFlag::new();
    stopped.stop();
    // More than any terminal queue holds: it fills the line, and would wait.
    let Err(VirtualPortError::Stopped { done }) = port.write_all(&bytes(0..1 << 20), &stopped)
    else {
        panic!("a megabyte passed with nobody reading");
    };
    assert!(done > 0 && done < 1 << 20, "{done} bytes");

    // The line is full now, so that this one has to wait.
    let stop = StopFlag::new();
    let (mut port, outcome) = thread::scope(|scope| {
        let switch = stop.clone();
        let writing = scope.spawn(move || {
            let outcome = port.write_all(&bytes(0..1 << 20), &switch);
            (port, outcome)
        });
        stop.stop();
        writing.join().unwrap()
    });
    let Err(VirtualPortError::Stopped { done: more }) = outcome else {
        panic!("a full line took a megabyte: {outcome:?}");
    };
    let outcome = port.drain(&stop);
    assert!(matches!(outcome, Err(VirtualPortError::Stopped { .. })), "{outcome:?}");

    // What was reported as passed is there, in order, and nothing else.
    let expected: Vec<u8> = bytes(0..done).into_iter().chain(bytes(0..more)).collect();
    let mut reader = open(port.path());
    assert_eq!(read_exactly(&mut reader, expected.len(), |_| 4096), expected);
    assert_nothing_waits(&mut reader);
    port.drain(&StopFlag::new()).unwrap();
}

#[test]
fn an_unplugged_port_is_a_clean_error_for_ever() {
    let port = VirtualPort::open().unwrap();
    let path = port.path().to_owned();
    let mut reader = open(&path);
    assert_nothing_waits(&mut reader);
    drop(port);
    for _ in 0..3 {
        let error = reader.read(&mut [0; 64]).unwrap_err();
        assert!(matches!(&error, LineError::Vanished { path: gone, .. } if *gone == path));
        assert!(error.to_string().contains("has gone"), "{error}");
    }
}

#[test]
fn a_second_reader_is_refused() {
    let port = VirtualPort::open().unwrap();
    let first = open(port.path());
    let error = SerialReader::open(port.path(), 115_200).unwrap_err();
    assert_eq!(error, LineError::Busy { path: port.path().to_owned() });
    drop(first);
    open(port.path());
}

#[test]
fn what_is_no_port_is_refused_with_the_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("ttyNone");
    let error = SerialReader::open(&missing, 115_200).unwrap_err();
    assert!(matches!(error, LineError::NotFound { .. }), "{error:?}");
    assert!(error.to_string().contains("ttyNone"), "{error}");

    let file = folder.path().join("file");
    fs::write(&file, "text").unwrap();
    let error = SerialReader::open(&file, 115_200).unwrap_err();
    assert!(matches!(error, LineError::Refused { .. }), "{error:?}");
    assert_eq!(fs::read(&file).unwrap(), b"text");

    let port = VirtualPort::open().unwrap();
    let error = SerialReader::open(port.path(), 0).unwrap_err();
    assert!(matches!(error, LineError::Refused { baud: 0, .. }), "{error:?}");
}

#[test]
fn any_baud_rate_opens() {
    let mut port = VirtualPort::open().unwrap();
    let stop = StopFlag::new();
    for baud in [
        1200, 9600, 12_345, 38_400, 57_600, 115_200, 230_400, 250_000, 460_800, 500_000, 614_400,
        921_600, 1_000_000, 3_000_000,
    ] {
        let mut reader = SerialReader::open(port.path(), baud).unwrap();
        port.write_all(&bytes(0..32), &stop).unwrap();
        assert_eq!(read_exactly(&mut reader, 32, |_| 32), bytes(0..32), "{baud} baud");
    }
}

#[test]
fn a_port_is_opened_by_its_link_and_the_link_goes_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("vg910d");
    // A link that a crashed run has left behind.
    symlink("/dev/pts/does-not-exist", &link).unwrap();
    let mut port = VirtualPort::open().unwrap();
    port.link_at(&link).unwrap();
    port.write_all(&bytes(0..10), &StopFlag::new()).unwrap();
    let mut reader = open(&link);
    assert_eq!(reader.path(), link);
    assert_eq!(read_exactly(&mut reader, 10, |_| 10), bytes(0..10));
    drop(port);
    assert!(fs::symlink_metadata(&link).is_err(), "the link is still there");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "something was left behind");
}

#[test]
fn a_link_pointed_elsewhere_meanwhile_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("vg910d");
    let mut old = VirtualPort::open().unwrap();
    let new = VirtualPort::open().unwrap();
    old.link_at(&link).unwrap();
    fs::remove_file(&link).unwrap();
    symlink(new.path(), &link).unwrap();
    drop(old);
    assert_eq!(fs::read_link(&link).unwrap(), new.path());
}

#[test]
fn a_link_replaces_nothing_but_dangling_links() {
    let folder = tempfile::tempdir().unwrap();
    let mut port = VirtualPort::open().unwrap();
    let file = folder.path().join("precious");
    fs::write(&file, "text").unwrap();
    let other = VirtualPort::open().unwrap();
    let taken = folder.path().join("taken");
    symlink(other.path(), &taken).unwrap();
    let missing = folder.path().join("no/such/folder");
    for path in [file.as_path(), &taken, folder.path(), &missing, "/".as_ref()] {
        let error = port.link_at(path).unwrap_err();
        assert!(matches!(error, VirtualPortError::Link { .. }), "{error:?}");
    }
    assert_eq!(fs::read(&file).unwrap(), b"text");
    assert_eq!(fs::read_link(&taken).unwrap(), other.path());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "something was left behind");
}
