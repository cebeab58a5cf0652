//! A serial port and the clock of this machine, for a live run.

use std::path::{Path, PathBuf};
use struna_harness::live::{ByteSource, HostClock, SourceRead};
use struna_kernel::SimTime;
use struna_line::{LineError, MonotonicClock, ReadOutcome, SerialReader, ports};

/// A port that is opened again by its name when it has gone.
#[derive(Debug)]
pub struct SerialSource {
    reader: Option<SerialReader>,
    /// The name that stays the same when the device is plugged in again.
    name: PathBuf,
    baud: u32,
}

impl SerialSource {
    /// Opens `path`; what has arrived before is thrown away.
    ///
    /// # Errors
    /// [`LineError`] naming the port and the remedy.
    pub fn open(path: &Path, baud: u32) -> Result<Self, LineError> {
        let reader = fresh(path, baud)?;
        Ok(Self { reader: Some(reader), name: stable_name(path), baud })
    }

    /// The name by which it is opened again.
    #[must_use]
    pub fn name(&self) -> &Path {
        &self.name
    }
}

fn fresh(path: &Path, baud: u32) -> Result<SerialReader, LineError> {
    let mut reader = SerialReader::open(path, baud)?;
    reader.flush()?;
    Ok(reader)
}

/// The name under which the port at `path` will come back: for `/dev/ttyUSB0` one that names the
/// adapter, since the next one may become `/dev/ttyUSB1`.
fn stable_name(path: &Path) -> PathBuf {
    let of_device = |port: &struna_line::PortInfo| port.device == path;
    ports(&[]).into_iter().find(of_device).map_or_else(|| path.to_owned(), |port| port.name)
}

impl ByteSource for SerialSource {
    fn read(&mut self, buffer: &mut [u8]) -> SourceRead {
        let Some(reader) = &mut self.reader else {
            return SourceRead::Lost("it is not open".to_owned());
        };
        match reader.read(buffer) {
            Ok(ReadOutcome::Bytes(n)) => SourceRead::Bytes(n),
            Ok(ReadOutcome::Idle) => SourceRead::Idle,
            Err(error) => {
                // Closed at once: an open descriptor would keep the device's name taken.
                self.reader = None;
                SourceRead::Lost(error.to_string())
            }
        }
    }

    fn reopen(&mut self) -> bool {
        self.reader = fresh(&self.name, self.baud).ok();
        self.reader.is_some()
    }
}

/// The clock of this machine.
#[derive(Debug)]
pub struct WallClock(MonotonicClock);

impl WallClock {
    /// Starts it.
    #[must_use]
    pub fn start() -> Self {
        Self(MonotonicClock::start())
    }
}

impl HostClock for WallClock {
    fn now(&mut self) -> SimTime {
        self.0.now()
    }

    fn wait(&mut self, span: SimTime) {
        self.0.wait(span);
    }
}
