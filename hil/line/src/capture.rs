//! Raw bytes from a port for a while, with how long they took.

use crate::host_clock::monotonic_ns;
use crate::{LineError, ReadOutcome, SerialReader, StopFlag};

const NS_PER_S: f64 = 1e9;
/// Bytes that a capture holds at most: a minute at two million baud.
const BYTES_MAX: usize = 16 << 20;
const CHUNK: usize = 4096;

/// Bytes and the time from the first to the last of them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RawCapture {
    /// As they came.
    pub bytes: Vec<u8>,
    /// From the first read that brought bytes to the last, s. Divided into the bytes it gives
    /// their rate, but for the bytes of one read.
    pub duration_s: f64,
}

impl RawCapture {
    /// Reads `reader` for `seconds`; `at` hears every now and then how many have passed. Ends
    /// early when `stop` is thrown, at 16 MiB, and when the port goes after bytes have come: what
    /// came is worth looking at.
    ///
    /// # Errors
    /// [`LineError::Vanished`] when the port goes before the first byte.
    pub fn read(
        reader: &mut SerialReader,
        seconds: f64,
        stop: &StopFlag,
        at: &mut dyn FnMut(f64),
    ) -> Result<Self, LineError> {
        let (mut bytes, mut chunk) = (Vec::new(), [0; CHUNK]);
        let start_ns = monotonic_ns();
        let (mut first_ns, mut last_ns) = (None, start_ns);
        loop {
            let passed_s = seconds_between(start_ns, monotonic_ns());
            at(passed_s);
            if passed_s >= seconds || stop.is_stopped() || bytes.len() >= BYTES_MAX {
                break;
            }
            match reader.read(&mut chunk) {
                Ok(ReadOutcome::Bytes(count)) => {
                    last_ns = monotonic_ns();
                    first_ns.get_or_insert(last_ns);
                    bytes.extend_from_slice(&chunk[..count.min(BYTES_MAX - bytes.len())]);
                }
                Ok(ReadOutcome::Idle) => {}
                Err(_) if !bytes.is_empty() => break,
                Err(error) => return Err(error),
            }
        }
        let duration_s = seconds_between(first_ns.unwrap_or(last_ns), last_ns);
        Ok(Self { bytes, duration_s })
    }
}

fn seconds_between(from_ns: i64, to_ns: i64) -> f64 {
    to_ns.saturating_sub(from_ns) as f64 / NS_PER_S
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::VirtualPort;

    /// Longer than any test lasts: the captures here end when the port goes.
    const LONG_S: f64 = 600.0;

    #[test]
    fn a_capture_holds_every_byte_until_the_port_goes() {
        let stop = StopFlag::new();
        let mut port = VirtualPort::open().unwrap();
        let mut reader = SerialReader::open(port.path(), 115_200).unwrap();
        let sent: Vec<u8> = (0..20_000u32).map(|k| k.to_le_bytes()[0]).collect();
        let captured = std::thread::scope(|scope| {
            let capture = scope.spawn(|| RawCapture::read(&mut reader, LONG_S, &stop, &mut |_| {}));
            port.write_all(&sent, &stop).unwrap();
            port.drain(&stop).unwrap();
            drop(port);
            capture.join().unwrap()
        });
        assert_eq!(captured.unwrap().bytes, sent);
    }

    #[test]
    fn a_port_that_goes_before_the_first_byte_is_an_error() {
        let port = VirtualPort::open().unwrap();
        let mut reader = SerialReader::open(port.path(), 115_200).unwrap();
        drop(port);
        let captured = RawCapture::read(&mut reader, LONG_S, &StopFlag::new(), &mut |_| {});
        assert!(matches!(captured, Err(LineError::Vanished { .. })), "{captured:?}");
    }

    #[test]
    fn a_thrown_switch_ends_a_capture() {
        let port = VirtualPort::open().unwrap();
        let mut reader = SerialReader::open(port.path(), 115_200).unwrap();
        let stop = StopFlag::new();
        stop.stop();
        let captured = RawCapture::read(&mut reader, LONG_S, &stop, &mut |_| {});
        assert_eq!(captured, Ok(RawCapture::default()));
    }
}
