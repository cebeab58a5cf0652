//! A line whose bytes, silences and outages are written down beforehand, with a clock to match.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::Rc;
use struna_harness::live::{ByteSource, HostClock, SourceRead};
use struna_kernel::SimTime;
use struna_line::StopFlag;
use struna_wire::{Encoder, FrameSpec};

/// A read waits this long for the first byte.
const READ_NS: i64 = 20_000_000;
/// Sensor rate of the script, Hz: 100 ppm slow beside the frame's 300 Hz.
pub(crate) const PERIOD_NS: i64 = 3_333_667;

/// What a script does at an instant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Step {
    Bytes(Vec<u8>),
    Unplug,
    Plug,
    /// Somebody presses Ctrl-C.
    Stop,
}

/// The line.
pub(crate) struct Script {
    steps: VecDeque<(i64, Step)>,
    now_ns: Rc<Cell<i64>>,
    plugged: bool,
    stop: StopFlag,
    /// Attempts to open the port again, by their times.
    pub(crate) attempts_ns: Rc<RefCell<Vec<i64>>>,
}

/// Its clock.
pub(crate) struct ScriptClock(Rc<Cell<i64>>);

impl HostClock for ScriptClock {
    fn now(&mut self) -> SimTime {
        SimTime::from_ns(self.0.get())
    }

    fn wait(&mut self, span: SimTime) {
        self.0.set(self.0.get() + span.as_ns());
    }
}

impl Script {
    /// Plays `steps`, in order of time; presses Ctrl-C on `stop` when one says so.
    pub(crate) fn new(mut steps: Vec<(i64, Step)>, stop: &StopFlag) -> (Self, ScriptClock) {
        steps.sort_by_key(|(ns, _)| *ns);
        let now_ns = Rc::new(Cell::new(0));
        let script = Self {
            steps: steps.into(),
            now_ns: Rc::clone(&now_ns),
            plugged: true,
            stop: stop.clone(),
            attempts_ns: Rc::default(),
        };
        (script, ScriptClock(now_ns))
    }

    /// The state of the plug at the present time; bytes sent to nobody are gone.
    fn catch_up(&mut self) {
        while self.steps.front().is_some_and(|(ns, _)| *ns <= self.now_ns.get()) {
            match self.steps.pop_front() {
                Some((_, Step::Plug)) => self.plugged = true,
                Some((_, Step::Unplug)) => self.plugged = false,
                Some((_, Step::Stop)) => self.stop.stop(),
                Some((_, Step::Bytes(_))) | None => {}
            }
        }
    }
}

impl ByteSource for Script {
    fn read(&mut self, buffer: &mut [u8]) -> SourceRead {
        let deadline_ns = self.now_ns.get() + READ_NS;
        let Some((ns, _)) = self.steps.front().filter(|(ns, _)| *ns <= deadline_ns) else {
            self.now_ns.set(deadline_ns);
            return SourceRead::Idle;
        };
        self.now_ns.set((*ns).max(self.now_ns.get()));
        match self.steps.pop_front() {
            Some((_, Step::Bytes(bytes))) => {
                buffer[..bytes.len()].copy_from_slice(&bytes);
                SourceRead::Bytes(bytes.len())
            }
            Some((_, Step::Unplug)) => {
                self.plugged = false;
                SourceRead::Lost("unplugged".to_owned())
            }
            Some((_, Step::Stop)) => {
                self.stop.stop();
                SourceRead::Idle
            }
            Some((_, Step::Plug)) | None => SourceRead::Idle,
        }
    }

    fn reopen(&mut self) -> bool {
        self.catch_up();
        self.attempts_ns.borrow_mut().push(self.now_ns.get());
        self.plugged
    }
}

/// The instant at which sample `k` is complete.
pub(crate) fn complete_ns(k: i64) -> i64 {
    (k + 1) * PERIOD_NS
}

/// Frames `0..count` of a gyro that turns at `rate_rad_s`, each 1 ms after its sample, with a
/// delay of up to 0.2 ms that repeats every 7 frames.
pub(crate) fn frames(spec: &FrameSpec, count: i64, rate_rad_s: f64) -> Vec<(i64, Step)> {
    let mut encoder = Encoder::new(spec);
    let rate = spec.field_index("rate").unwrap();
    let status = spec.field_index("status").unwrap();
    let mut raw = vec![0; spec.fields().len()];
    raw[rate] = spec.fields()[rate].from_si(rate_rad_s);
    raw[status] = spec.flags()[spec.flag_index("valid").unwrap()].mask();
    let frame = |k| {
        let mut bytes = Vec::new();
        encoder.encode(&raw, &mut bytes).unwrap();
        (complete_ns(k) + 1_000_000 + (k % 7) * 30_000, Step::Bytes(bytes))
    };
    (0..count).map(frame).collect()
}

/// The rate that the frame carries for `rate_rad_s`.
pub(crate) fn carried(spec: &FrameSpec, rate_rad_s: f64) -> f64 {
    let field = &spec.fields()[spec.field_index("rate").unwrap()];
    field.to_si(field.from_si(rate_rad_s))
}
