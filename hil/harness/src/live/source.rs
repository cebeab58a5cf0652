//! What a live run needs of the world: bytes and a clock.

use struna_kernel::SimTime;

/// What one read brought.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SourceRead {
    /// So many bytes, at least one.
    Bytes(usize),
    /// Nothing came for a while.
    Idle,
    /// The port has gone, for this reason.
    Lost(String),
}

/// Where bytes come from: a serial port, or a script in a test.
pub trait ByteSource {
    /// Reads what is there, waiting a short while for the first byte.
    fn read(&mut self, buffer: &mut [u8]) -> SourceRead;

    /// Tries once to get back a port that has gone; what waits in it then is thrown away. True
    /// when it is back.
    fn reopen(&mut self) -> bool;
}

/// The host's clock.
pub trait HostClock {
    /// The time since the run began. Never goes back.
    fn now(&mut self) -> SimTime;

    /// Waits for `span`.
    fn wait(&mut self, span: SimTime);
}
