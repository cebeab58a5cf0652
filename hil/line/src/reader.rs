//! The bench's end of a serial line, virtual or real.

use crate::ports::{group_with_access, ports};
use serialport::{ClearBuffer, DataBits, ErrorKind, FlowControl, Parity, SerialPort, StopBits};
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How long a read waits before it reports an idle line, so that a caller can look around.
const READ_TIMEOUT: Duration = Duration::from_millis(20);
/// Ports that an error lists at most.
const MAX_LISTED: usize = 16;

/// Why a port could not be opened or read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LineError {
    /// There is no such port.
    #[error("no port {}; {}", path.display(), remedy_of(present))]
    NotFound {
        /** The port asked for. */
        path: PathBuf,
        /** Ports that are there. */
        present: Vec<PathBuf>,
    },
    /// Somebody else has it.
    #[error("the port {} is in use; close the program that has it open", path.display())]
    Busy {
        /** The port asked for. */
        path: PathBuf,
    },
    /// The user may not open it.
    #[error("not allowed to open {}; {}", path.display(), joining(group.as_deref()))]
    PermissionDenied {
        /** The port asked for. */
        path: PathBuf,
        /** The group that may open it, if one may. */
        group: Option<String>,
    },
    /// It exists but is not a serial port, or it does not take the settings.
    #[error("{} does not work as a serial port at {baud} baud: {reason}; check path and baud \
         rate", path.display())]
    Refused {
        /** The port asked for. */
        path: PathBuf,
        /** The baud rate asked for. */
        baud: u32,
        /** What the system said. */
        reason: String,
    },
    /// It was open and stopped answering: unplugged, or the emulator ended.
    #[error("the port {} has gone ({reason}); plug the device in or start the emulator again",
         path.display())]
    Vanished {
        /** The port. */
        path: PathBuf,
        /** What the system said. */
        reason: String,
    },
}

/// What one read brought.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReadOutcome {
    /// So many bytes, at least one unless the buffer is empty.
    Bytes(usize),
    /// Nothing came for a while. The line is as good as before.
    Idle,
}

/// A serial port open for reading: 8 data bits, no parity, 1 stop bit, no flow control, raw, and
/// exclusively ours. A virtual port is opened exactly as a real one.
pub struct SerialReader {
    port: Box<dyn SerialPort>,
    path: PathBuf,
}

impl fmt::Debug for SerialReader {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SerialReader").field("path", &self.path).finish_non_exhaustive()
    }
}

impl SerialReader {
    /// Opens `path`, a device node or a link to one. Bytes that already wait there are kept.
    ///
    /// # Errors
    /// [`LineError`] naming the port and the remedy.
    pub fn open(path: &Path, baud: u32) -> Result<Self, LineError> {
        let refused = |reason: &str| LineError::Refused {
            path: path.to_owned(),
            baud,
            reason: reason.to_owned(),
        };
        let name = path.to_str().ok_or_else(|| refused("the path is not UTF-8"))?;
        if baud == 0 {
            // On a terminal, zero baud means "hang up".
            return Err(refused("no bytes pass at zero baud"));
        }
        let port = serialport::new(name, baud)
            .data_bits(DataBits::Eight)
            .parity(Parity::None)
            .stop_bits(StopBits::One)
            .flow_control(FlowControl::None)
            .timeout(READ_TIMEOUT)
            .open()
            .map_err(|error| match error.kind {
                ErrorKind::Io(io::ErrorKind::NotFound) => {
                    LineError::NotFound { path: path.to_owned(), present: present() }
                }
                ErrorKind::Io(io::ErrorKind::PermissionDenied) => {
                    let group = group_with_access(path);
                    LineError::PermissionDenied { path: path.to_owned(), group }
                }
                ErrorKind::NoDevice => LineError::Busy { path: path.to_owned() },
                _ => refused(&error.description),
            })?;
        Ok(Self { port, path: path.to_owned() })
    }

    /// Throws away what has arrived and was not read yet: bytes of the time before.
    ///
    /// # Errors
    /// [`LineError::Vanished`] when the port has gone.
    pub fn flush(&mut self) -> Result<(), LineError> {
        self.port.clear(ClearBuffer::Input).map_err(|error| self.vanished(&error.description))
    }

    /// The path it was opened by.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Reads what is there into `buffer`, waiting a short while for the first byte.
    ///
    /// # Errors
    /// [`LineError::Vanished`] once the port has gone, and at every read after that.
    pub fn read(&mut self, buffer: &mut [u8]) -> Result<ReadOutcome, LineError> {
        if buffer.is_empty() {
            return Ok(ReadOutcome::Bytes(0));
        }
        match self.port.read(buffer) {
            // A terminal that was hung up reads as ended.
            Ok(0) => Err(self.vanished("end of file")),
            Ok(received) => Ok(ReadOutcome::Bytes(received)),
            Err(error) => match error.kind() {
                io::ErrorKind::TimedOut
                | io::ErrorKind::Interrupted
                | io::ErrorKind::WouldBlock => Ok(ReadOutcome::Idle),
                _ => Err(self.vanished(&error.to_string())),
            },
        }
    }

    fn vanished(&self, reason: &str) -> LineError {
        LineError::Vanished { path: self.path.clone(), reason: reason.to_owned() }
    }
}

fn remedy_of(present: &[PathBuf]) -> String {
    if present.is_empty() {
        return "no serial port is present: plug the device in or start the emulator".to_owned();
    }
    let names: Vec<_> = present.iter().map(|path| path.display().to_string()).collect();
    format!("present are: {}", names.join(", "))
}

fn joining(group: Option<&str>) -> String {
    match group {
        Some(group) => format!(
            "its group is `{group}`: join it with `sudo usermod -aG {group} $USER` and log in again"
        ),
        None => "its owner lets nobody else in: ask for it with `sudo chmod`".to_owned(),
    }
}

/// The ports of this machine by name.
fn present() -> Vec<PathBuf> {
    ports(&[]).into_iter().map(|port| port.name).take(MAX_LISTED).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_port_names_those_that_are_there() {
        let path = PathBuf::from("/dev/ttyUSB9");
        let some = vec![PathBuf::from("/dev/ttyACM0"), PathBuf::from("/dev/ttyUSB0")];
        let error = LineError::NotFound { path: path.clone(), present: some };
        assert_eq!(
            error.to_string(),
            "no port /dev/ttyUSB9; present are: /dev/ttyACM0, /dev/ttyUSB0"
        );
        let error = LineError::NotFound { path: path.clone(), present: Vec::new() };
        assert!(error.to_string().ends_with("plug the device in or start the emulator"));
        let error = LineError::PermissionDenied { path, group: Some("dialout".to_owned()) };
        assert!(error.to_string().contains("sudo usermod -aG dialout $USER"), "{error}");
    }
}
