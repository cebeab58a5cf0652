//! The emulated device as the host sees it: frames, put on a line, arriving when a line lets them.

use crate::{Emulator, EmulatorError, EmulatorReport, Reference};
use struna_kernel::SimTime;
use struna_line::LineModel;

/// What happens at the host's end of the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineEvent<'a> {
    /// These bytes have arrived.
    Bytes(&'a [u8]),
    /// The device has been unplugged: its port is gone.
    Unplugged,
    /// The device is back.
    Plugged,
}

/// Emulator and line in a row, in simulated time.
///
/// Nothing here knows whether the events are played into a pseudo-terminal at their times or
/// decoded at once, so both see the same bytes at the same times.
#[derive(Debug)]
pub struct Transmitter {
    emulator: Emulator,
    line: LineModel,
    frame: Vec<u8>,
}

impl Transmitter {
    /// Puts what `emulator` says on `line`.
    #[must_use]
    pub fn new(emulator: Emulator, line: LineModel) -> Self {
        Self { emulator, line, frame: Vec::with_capacity(64) }
    }

    /// Instant of the next sample.
    #[must_use]
    pub fn next_time(&self) -> SimTime {
        self.emulator.next_time()
    }

    /// Emits the next frame; what reaches the host by then goes to `sink`, with arrival times
    /// that never go back. Returns the motion at the sample's instant.
    ///
    /// # Errors
    /// [`EmulatorError`] when the motion cannot be carried on; nothing was sent then.
    pub fn emit(
        &mut self,
        sink: &mut dyn FnMut(SimTime, LineEvent<'_>),
    ) -> Result<Reference, EmulatorError> {
        self.frame.clear();
        let reference = self.emulator.emit(&mut self.frame)?;
        self.line.send(reference.time, &self.frame, &mut |time, bytes| {
            sink(time, LineEvent::Bytes(bytes));
        });
        Ok(reference)
    }

    /// Hands over everything still on its way.
    pub fn flush(&mut self, sink: &mut dyn FnMut(SimTime, LineEvent<'_>)) {
        self.line.flush(&mut |time, bytes| sink(time, LineEvent::Bytes(bytes)));
    }

    /// What the emulator has done so far.
    #[must_use]
    pub fn report(&self) -> EmulatorReport {
        self.emulator.report()
    }
}
