//! One run: emulator and pipeline, joined by a pseudo-terminal.

use crate::fault::{Dispatch, FaultRecord};
use crate::{
    Emulator, EmulatorError, EmulatorReport, Pacing, Pipeline, PipelineError, PipelineReport,
    Reference, SourceError,
};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{self, ScopedJoinHandle};
use struna_kernel::{AngleEstimate, RateSample, SimTime};
use struna_line::{
    Lateness, LineError, Pacer, ReadOutcome, SerialReader, StopFlag, VirtualPort, VirtualPortError,
    Waited,
};

/// Bytes per write when nobody waits for single frames.
const BLOCK: usize = 4096;
/// Idle reads in a row, of 20 ms each, after which bytes still missing are given up. The kernel
/// hands bytes over within microseconds; only a defect or a stopped machine takes seconds.
const IDLE_READS_MAX: u32 = 500;

/// Sees each averaged sample, the truth beside it and what was made of it.
pub trait Observer {
    /// `estimates` are in the order of the devices.
    fn observe(
        &mut self,
        sample: &RateSample,
        reference: Option<&Reference>,
        estimates: &[AngleEstimate],
    );
}

/// Why a run ended early.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The line.
    #[error(transparent)]
    Line(#[from] LineError),
    /// The emulated gyro's end of it.
    #[error(transparent)]
    VirtualPort(#[from] VirtualPortError),
    /// Bytes that were sent never came.
    #[error("{received} of {sent} bytes came through the virtual port and then no more")]
    BytesMissing {
        /** Bytes sent. */
        sent: u64,
        /** Bytes received. */
        received: u64,
    },
    /// Left of the line.
    #[error(transparent)]
    Emulator(#[from] EmulatorError),
    /// Right of the line.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// A defect of this program.
    #[error("the emulator thread panicked; this is a defect in struna")]
    EmulatorPanicked,
}

/// What happened in a run.
#[derive(Debug, Clone, PartialEq)]
pub struct RunReport {
    /// Left of the line.
    pub emulator: EmulatorReport,
    /// Right of the line.
    pub pipeline: PipelineReport,
    /// What faults did; the truth to judge detectors by.
    pub faults: Vec<FaultRecord>,
    /// How late frames were, when paced.
    pub late: Option<Lateness>,
    /// The run was stopped from outside before its end.
    pub interrupted: bool,
    /// Why the motion ended before the run did.
    pub stopped: Option<SourceError>,
}

/// Runs `frames` frames of `emulator` through a pseudo-terminal into `pipeline`.
///
/// The reader opens its end by path, as it would open real hardware. The line has flow control and
/// the reader waits for the last byte, so nothing is lost and the result does not depend on the
/// speed of either side. `stop` ends the run early, and so does a motion that cannot be carried on:
/// what was sent until then is still received.
///
/// # Errors
/// [`RunError`] from whichever side failed first; the observer has seen everything up to there.
pub fn run(
    emulator: Emulator,
    frames: u64,
    pacing: Pacing,
    pipeline: &mut Pipeline,
    observer: &mut dyn Observer,
    stop: &StopFlag,
) -> Result<RunReport, RunError> {
    let port = VirtualPort::open()?;
    let reader = SerialReader::open(port.path(), pipeline.baud())?;
    let sent = AtomicU64::new(0);
    // A flag of its own: a reader that fails must end the writer, not look like an interruption.
    let halt = StopFlag::new();
    let (references, received) = channel();
    thread::scope(|scope| {
        let writer = Writer { emulator, port, references, sent: &sent, stop, halt: &halt };
        let writer = scope.spawn(move || writer.run(frames, pacing));
        let read =
            Reader { reader, received, latest: None }.run(&writer, &sent, pipeline, observer);
        if read.is_err() {
            halt.stop();
        }
        // The writer's end of the line lives until here: closing it would discard unread bytes.
        let written = writer.join().map_err(|_| RunError::EmulatorPanicked)?;
        let Written { emulator, faults, late, stopped, port: _port } = match (written, read) {
            (Ok(written), Ok(())) => written,
            // A failed writer hangs up, which the reader sees as an error of the line: the cause
            // comes first.
            (Err(cause), _) | (Ok(_), Err(cause)) => return Err(cause),
        };
        let interrupted = emulator.frames < frames && stopped.is_none();
        let pipeline = pipeline.finish();
        Ok(RunReport { emulator, pipeline, faults, late, interrupted, stopped })
    })
}

/// The truth at a sample, under the time that the gyro's own clock gives it: all that the decoded
/// sample can be found by.
type Stamped = (SimTime, Reference);

/// The emulator's thread.
struct Writer<'a> {
    emulator: Emulator,
    port: VirtualPort,
    references: Sender<Stamped>,
    sent: &'a AtomicU64,
    stop: &'a StopFlag,
    halt: &'a StopFlag,
}

/// What the writer hands back, its port included.
struct Written {
    emulator: EmulatorReport,
    faults: Vec<FaultRecord>,
    late: Option<Lateness>,
    stopped: Option<SourceError>,
    port: VirtualPort,
}

impl Writer<'_> {
    fn run(mut self, frames: u64, pacing: Pacing) -> Result<Written, RunError> {
        let mut pacer = (pacing == Pacing::RealTime).then(Pacer::start);
        let mut block = Vec::with_capacity(2 * BLOCK);
        let mut stopped = None;
        for _ in 0..frames {
            if self.stop.is_stopped() || self.halt.is_stopped() {
                break;
            }
            if let Some(pacer) = &mut pacer
                && pacer.wait_until(self.emulator.next_time(), self.stop) == Waited::Stopped
            {
                break;
            }
            let sensor_time = self.emulator.next_sensor_time();
            let reference = match self.emulator.emit(&mut block) {
                Ok(reference) => reference,
                Err(EmulatorError::Source(reason)) => {
                    stopped = Some(reason);
                    break;
                }
                Err(error) => return Err(error.into()),
            };
            // A reader that has gone needs no truth; its own error tells why it went.
            let _ = self.references.send((sensor_time, reference));
            if pacer.is_some() || block.len() >= BLOCK {
                self.flush(&mut block)?;
            }
        }
        self.emulator.finish(&mut |dispatch| {
            if let Dispatch::Bytes { bytes, .. } = dispatch {
                block.extend_from_slice(bytes);
            }
        });
        self.flush(&mut block)?;
        let late = pacer.map(|pacer| pacer.lateness().clone());
        let faults = self.emulator.fault_records().to_vec();
        Ok(Written { emulator: self.emulator.report(), faults, late, stopped, port: self.port })
    }

    fn flush(&mut self, block: &mut Vec<u8>) -> Result<(), RunError> {
        match self.port.write_all(block, self.halt) {
            Ok(()) => {
                self.sent.fetch_add(block.len() as u64, Ordering::Release);
                block.clear();
                Ok(())
            }
            // The reader failed and asked for this end; its error is the one to report.
            Err(VirtualPortError::Stopped { .. }) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }
}

/// The calling thread's side.
struct Reader {
    reader: SerialReader,
    received: Receiver<Stamped>,
    latest: Option<Stamped>,
}

impl Reader {
    fn run(
        mut self,
        writer: &ScopedJoinHandle<'_, Result<Written, RunError>>,
        sent: &AtomicU64,
        pipeline: &mut Pipeline,
        observer: &mut dyn Observer,
    ) -> Result<(), RunError> {
        let mut buffer = [0; BLOCK];
        let mut bytes: u64 = 0;
        let mut idle = 0;
        loop {
            // Asked before reading: what was sent before the writer ended is then all there is.
            let ended = writer.is_finished();
            let sent = sent.load(Ordering::Acquire);
            if ended && bytes >= sent {
                return Ok(());
            }
            if ended && idle > IDLE_READS_MAX {
                return Err(RunError::BytesMissing { sent, received: bytes });
            }
            let ReadOutcome::Bytes(n) = self.reader.read(&mut buffer)? else {
                idle += 1;
                continue;
            };
            idle = 0;
            bytes += n as u64;
            let Self { received, latest, .. } = &mut self;
            pipeline.push(&buffer[..n], &mut |sample, estimates| {
                let reference = reference_for(sample, received, latest);
                observer.observe(sample, reference.as_ref(), estimates);
            })?;
        }
    }
}

/// The truth at the end of `sample`, if the source has told it.
fn reference_for(
    sample: &RateSample,
    received: &Receiver<Stamped>,
    latest: &mut Option<Stamped>,
) -> Option<Reference> {
    while latest.is_none_or(|(sensor_time, _)| sensor_time < sample.time) {
        *latest = Some(received.try_recv().ok()?);
    }
    let (_, reference) = latest.filter(|(sensor_time, _)| *sensor_time == sample.time)?;
    Some(reference)
}
