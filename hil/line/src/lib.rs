//! The serial line: a virtual port that software cannot tell from a real one, a reader for both,
//! and pacing to real time.
//!
//! The emulated gyro writes into a virtual port; the bench reads its device node with a
//! [`SerialReader`], exactly as it would read `/dev/ttyUSB0`. There are two such ports. A
//! [`VirtualPort`] waits for its reader and loses nothing: it joins the two halves of one run. A
//! [`DevicePort`] talks whether somebody listens or not, as a device does: it stands in for one.
//! A pseudo-terminal has no baud rate of its own: a [`LineModel`] says when bytes arrive, a
//! [`UartReceiver`] what a client at a wrong rate reads, and a [`Pacer`] sets the tempo when a run
//! is to look like real time. Linux only, for the pseudo-terminal and the pacer.
//!
//! **Architecture Invariant:** the line knows bytes, not frames. Nothing here may reach the wire
//! format, a gyro or an estimator.
//!
//! **Architecture Invariant:** what passes does not depend on the clock. Lateness is measured and
//! reported and decides nothing. What a [`DevicePort`] loses depends on its client alone.

mod capture;
mod device;
mod host_clock;
mod lateness;
mod link;
mod model;
mod pacer;
mod port;
mod ports;
mod pty;
mod reader;
mod realtime;
mod receiver;
mod stop;

pub use capture::RawCapture;
pub use device::{Client, DevicePort, DeviceSettings, PortCounts};
pub use host_clock::{MonotonicClock, monotonic_ns};
pub use lateness::{Delays, Lateness};
pub use model::{Bridge, LineModel, LineSettings};
pub use pacer::{Pacer, Waited};
pub use port::{VirtualPort, VirtualPortError};
pub use ports::{PortAccess, PortInfo, PortKind, link_directory, port_at, ports};
pub use reader::{LineError, ReadOutcome, SerialReader};
pub use realtime::RealTime;
pub use receiver::{CharacterFormat, Parity, ReceiverErrors, UartReceiver};
pub use stop::StopFlag;
