//! Listening to a port that may go and come back.

use super::{ByteSource, HostClock, LineInput, LiveEvent, LiveObserver, LivePipeline, SourceRead};
use crate::PipelineError;
use struna_kernel::SimTime;

/// Bytes asked for in one read; a pseudo-terminal never gives more.
const READ_BYTES: usize = 4096;
/// First and longest wait between two attempts to open a port that has gone.
const BACK_OFF_NS: (i64, i64) = (100_000_000, 2_000_000_000);
/// Waits are cut into pieces of this, so that a stop from outside is soon noticed.
const PIECE_NS: i64 = 20_000_000;
/// How long a line may bring no frame before somebody is told what it brings instead.
const NO_FRAMES_NS: i64 = 2_000_000_000;

/// How to listen.
pub struct Listening<'a> {
    /// When to stop by the host's clock; never, without.
    pub until: Option<SimTime>,
    /// Asked between reads: whether to stop now.
    pub stop: &'a dyn Fn() -> bool,
    /// Stop when no frame comes within two seconds.
    pub strict: bool,
}

impl std::fmt::Debug for Listening<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Listening").field("until", &self.until).finish_non_exhaustive()
    }
}

/// Why listening ended, short of an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// The time was up.
    TimeUp,
    /// Stopped from outside.
    Stopped,
    /// No frame came, and that was asked to be fatal.
    NoFrames,
}

/// Feeds `pipeline` with what `source` brings until the time is up.
///
/// A port that goes is opened again by its name, after 100 ms at first and 2 s at most; what it
/// holds then is old and thrown away by the source. The caller finishes the pipeline.
///
/// # Errors
/// [`PipelineError`] when a device failed; everything up to there has been observed.
pub fn listen(
    source: &mut dyn ByteSource,
    clock: &mut dyn HostClock,
    pipeline: &mut LivePipeline,
    observer: &mut dyn LiveObserver,
    listening: &Listening<'_>,
) -> Result<Ended, PipelineError> {
    let begin = clock.now();
    Listener { source, clock, pipeline, observer, listening, begin, silent: None, told: false }
        .run()
}

struct Listener<'a> {
    source: &'a mut dyn ByteSource,
    clock: &'a mut dyn HostClock,
    pipeline: &'a mut LivePipeline,
    observer: &'a mut dyn LiveObserver,
    listening: &'a Listening<'a>,
    begin: SimTime,
    /// When the line was last seen silent. Told with the bytes that end the silence.
    silent: Option<SimTime>,
    told: bool,
}

impl Listener<'_> {
    fn run(mut self) -> Result<Ended, PipelineError> {
        let mut buffer = [0; READ_BYTES];
        loop {
            if let Some(ended) = self.ended() {
                return Ok(ended);
            }
            let read = self.source.read(&mut buffer);
            let now = self.clock.now();
            match read {
                SourceRead::Bytes(n) => self.bytes(now, &buffer[..n])?,
                SourceRead::Idle => self.silent = Some(now),
                SourceRead::Lost(reason) => {
                    if let Some(ended) = self.lost(now, reason)? {
                        return Ok(ended);
                    }
                }
            }
            self.observer.look(now, self.pipeline);
            if self.tell_without_frames(now) {
                return Ok(Ended::NoFrames);
            }
        }
    }

    fn ended(&mut self) -> Option<Ended> {
        if (self.listening.stop)() {
            return Some(Ended::Stopped);
        }
        self.listening.until.filter(|until| self.clock.now() >= *until).map(|_| Ended::TimeUp)
    }

    fn take(&mut self, time: SimTime, input: LineInput<'_>) -> Result<(), PipelineError> {
        self.observer.input(time, input);
        self.pipeline.take(time, input, self.observer)
    }

    fn bytes(&mut self, now: SimTime, bytes: &[u8]) -> Result<(), PipelineError> {
        if let Some(silent) = self.silent.take() {
            self.take(silent, LineInput::Silent)?;
        }
        self.take(now, LineInput::Bytes(bytes))
    }

    /// Waits for a lost port; an end when one was due meanwhile.
    fn lost(&mut self, now: SimTime, reason: String) -> Result<Option<Ended>, PipelineError> {
        self.silent = None;
        self.take(now, LineInput::Lost)?;
        self.observer.event(self.pipeline.time(), &LiveEvent::PortLost { reason });
        let mut back_off_ns = BACK_OFF_NS.0;
        loop {
            if let Some(ended) = self.wait(back_off_ns) {
                return Ok(Some(ended));
            }
            if self.source.reopen() {
                break;
            }
            back_off_ns = (2 * back_off_ns).min(BACK_OFF_NS.1);
        }
        let back = self.clock.now();
        let after_s = back.seconds_since(now);
        self.take(back, LineInput::Back)?;
        self.observer.event(self.pipeline.time(), &LiveEvent::PortBack { after_s });
        Ok(None)
    }

    fn wait(&mut self, span_ns: i64) -> Option<Ended> {
        let mut left_ns = span_ns;
        while left_ns > 0 {
            if let Some(ended) = self.ended() {
                return Some(ended);
            }
            self.clock.wait(SimTime::from_ns(left_ns.min(PIECE_NS)));
            let now = self.clock.now();
            self.observer.look(now, self.pipeline);
            left_ns -= PIECE_NS;
        }
        None
    }

    /// Tells once that no frame comes; true when that ends the run.
    fn tell_without_frames(&mut self, now: SimTime) -> bool {
        let looked_ns = now.as_ns().saturating_sub(self.begin.as_ns());
        if self.told || looked_ns < NO_FRAMES_NS {
            return false;
        }
        self.told = true;
        if self.pipeline.report().wire.ok > 0 {
            return false;
        }
        let seen = self.pipeline.sighting(now.seconds_since(self.begin));
        self.observer.event(SimTime::ZERO, &LiveEvent::NoFrames(seen));
        self.listening.strict
    }
}
