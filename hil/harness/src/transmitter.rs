//! The emulated device as the host sees it: frames, put on a line, arriving when a line lets them.

use crate::fault::{Dispatch, FaultRecord};
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
    path: LinePath,
}

impl Transmitter {
    /// Puts what `emulator` says on `line`.
    #[must_use]
    pub fn new(emulator: Emulator, line: LineModel) -> Self {
        Self { emulator, path: LinePath::new(line) }
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
        let Self { emulator, path } = self;
        emulator.emit_to(&mut |dispatch| path.carry(dispatch, sink))
    }

    /// Ends the stream and hands over everything still on its way.
    pub fn flush(&mut self, sink: &mut dyn FnMut(SimTime, LineEvent<'_>)) {
        let Self { emulator, path } = self;
        emulator.finish(&mut |dispatch| path.carry(dispatch, sink));
        path.flush(sink);
    }

    /// What faults have done so far; complete after [`Self::flush`].
    #[must_use]
    pub fn fault_records(&self) -> &[FaultRecord] {
        self.emulator.fault_records()
    }

    /// What the emulator has done so far.
    #[must_use]
    pub fn report(&self) -> EmulatorReport {
        self.emulator.report()
    }
}

/// The way from the gyro to the host: a line that may run at a wrong rate and may be unplugged.
#[derive(Debug)]
pub struct LinePath {
    line: LineModel,
    baud_ratio: f64,
    /// Arrival times do not go back, whatever is unplugged when.
    last: SimTime,
}

impl LinePath {
    /// An idle `line`, plugged in.
    #[must_use]
    pub fn new(line: LineModel) -> Self {
        Self { line, baud_ratio: 1.0, last: SimTime::ZERO }
    }

    /// Carries what leaves the gyro; what reaches the host by then goes to `sink`. Bytes that a
    /// bridge holds when it is unplugged are lost with it.
    pub fn carry(&mut self, dispatch: Dispatch<'_>, sink: &mut dyn FnMut(SimTime, LineEvent<'_>)) {
        let Self { line, baud_ratio, last } = self;
        let mut arrived = |time: SimTime, bytes: &[u8]| {
            *last = time.max(*last);
            sink(*last, LineEvent::Bytes(bytes));
        };
        match dispatch {
            Dispatch::Bytes { ready, baud_ratio: ratio, bytes } => {
                // Compared by bits: any change counts, and only a change may touch the line.
                if ratio.to_bits() != baud_ratio.to_bits() {
                    line.set_baud_ratio(ratio);
                    *baud_ratio = ratio;
                }
                line.send(ready, bytes, &mut arrived);
            }
            Dispatch::Unplugged(time) => {
                line.advance(time, &mut arrived);
                *line = LineModel::new(line.settings());
                *baud_ratio = 1.0;
                *last = time.max(*last);
                sink(*last, LineEvent::Unplugged);
            }
            Dispatch::Plugged(time) => {
                *last = time.max(*last);
                sink(*last, LineEvent::Plugged);
            }
        }
    }

    /// Hands over everything still on its way.
    pub fn flush(&mut self, sink: &mut dyn FnMut(SimTime, LineEvent<'_>)) {
        let Self { line, last, .. } = self;
        line.flush(&mut |time, bytes| {
            *last = time.max(*last);
            sink(*last, LineEvent::Bytes(bytes));
        });
    }
}
