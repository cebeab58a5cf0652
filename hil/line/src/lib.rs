//! The serial line: a virtual port that software cannot tell from a real one, a reader for both,
//! and pacing to real time.
//!
//! The emulated gyro writes into a [`VirtualPort`]; the bench reads its device node with a
//! [`SerialReader`], exactly as it would read `/dev/ttyUSB0`. A pseudo-terminal has no baud rate
//! of its own: bytes pass as fast as the reader takes them, and a [`Pacer`] sets the tempo when a
//! run is to look like real time. Linux only, for the pseudo-terminal and the pacer.
//!
//! **Architecture Invariant:** the line knows bytes, not frames. Nothing here may reach the wire
//! format, a gyro or an estimator.
//!
//! **Architecture Invariant:** what passes does not depend on the clock. The writer waits for the
//! reader; lateness is measured and reported and decides nothing.

mod capture;
mod link;
mod pacer;
mod port;
mod reader;
mod stop;

pub use capture::RawCapture;
pub use pacer::{Lateness, Pacer};
pub use port::{VirtualPort, VirtualPortError};
pub use reader::{LineError, ReadOutcome, SerialReader};
pub use stop::StopFlag;
