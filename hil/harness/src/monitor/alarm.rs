//! What the monitor says.

use std::fmt;
use struna_kernel::SimTime;

/// A reason to doubt the stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Detector {
    /// Bytes that belong to no frame, or a check that does not hold.
    Check,
    /// The frame counter has jumped: frames are missing.
    Gap,
    /// The frame counter stood still or went back.
    Repeat,
    /// The same counts for too long.
    Stuck,
    /// The rate is at the end of the range.
    Saturation,
    /// The rate has changed by more than a body can turn faster.
    Step,
    /// The rate is not where it was predicted.
    Innovation,
    /// The rate scatters more than declared.
    Variance,
    /// Samples do not come when the counter says they should.
    Clock,
    /// Too few or too many frames in a second, or none at all.
    Rate,
    /// The mean rate at declared rest is not zero.
    Rest,
}

impl Detector {
    /// All, in the order of tables.
    pub const ALL: [Self; 11] = [
        Self::Check,
        Self::Gap,
        Self::Repeat,
        Self::Stuck,
        Self::Saturation,
        Self::Step,
        Self::Innovation,
        Self::Variance,
        Self::Clock,
        Self::Rate,
        Self::Rest,
    ];

    /// Its word in tables and files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Check => "check",
            Self::Gap => "gap",
            Self::Repeat => "repeat",
            Self::Stuck => "stuck",
            Self::Saturation => "satur",
            Self::Step => "step",
            Self::Innovation => "innov",
            Self::Variance => "varian",
            Self::Clock => "clock",
            Self::Rate => "rate",
            Self::Rest => "rest",
        }
    }

    /// Its place in [`Self::ALL`].
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize
    }

    /// What an alarm of it means, in plain words, and the unit of its value.
    #[must_use]
    pub const fn meaning(self) -> (&'static str, &'static str) {
        match self {
            Self::Check => ("bytes were damaged on the line", "byte"),
            Self::Gap => ("frames are missing", "frame"),
            Self::Repeat => ("the frame counter stood still or went back", "frame"),
            Self::Stuck => ("the output repeats the same counts", "sample"),
            Self::Saturation => ("the rate is at the end of the range", "rad/s"),
            Self::Step => ("the rate changed faster than the body can turn", "rad/s"),
            Self::Innovation => ("the rate is not where the motion leads it", "rad/s"),
            Self::Variance => ("the rate scatters more than declared", "1"),
            Self::Clock => ("samples do not come when they are due", "s"),
            Self::Rate => ("too few or too many frames come", "frame"),
            Self::Rest => ("the rate is not zero at declared rest", "rad/s"),
        }
    }
}

/// One alarm, from the first sign to the last.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alarm {
    /// Who raised it.
    pub detector: Detector,
    /// Host time of the first sign.
    pub since: SimTime,
    /// Host time of the last sign so far.
    pub until: SimTime,
    /// The value that raised it, in the unit of [`Detector::meaning`].
    pub value: f64,
    /// The limit that it passed.
    pub limit: f64,
}

impl fmt::Display for Alarm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (meaning, unit) = self.detector.meaning();
        let Self { since, value, limit, .. } = self;
        let (name, since_s) = (self.detector.name(), since.as_s());
        write!(f, "{since_s:.3} s {name}: {meaning} ({value:.4} {unit}, limit {limit:.4})")
    }
}

/// A change in what is alarmed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AlarmChange {
    /// A new alarm.
    Raised(Alarm),
    /// An alarm that has shown no sign for some time.
    Cleared(Alarm),
}

/// Signs closer than this are one alarm.
const MERGE_NS: i64 = 300_000_000;

/// Makes alarms of signs.
#[derive(Debug, Clone, Default)]
pub(super) struct Board {
    open: [Option<Alarm>; 11],
}

impl Board {
    pub(super) fn sign(
        &mut self,
        (detector, time): (Detector, SimTime),
        (value, limit): (f64, f64),
        sink: &mut dyn FnMut(AlarmChange),
    ) {
        self.clear_old(detector, time, sink);
        match &mut self.open[detector.index()] {
            Some(alarm) => alarm.until = alarm.until.max(time),
            open => {
                let alarm = Alarm { detector, since: time, until: time, value, limit };
                *open = Some(alarm);
                sink(AlarmChange::Raised(alarm));
            }
        }
    }

    /// Clears the alarms whose last sign is too long ago.
    pub(super) fn pass(&mut self, time: SimTime, sink: &mut dyn FnMut(AlarmChange)) {
        for detector in Detector::ALL {
            self.clear_old(detector, time, sink);
        }
    }

    /// Clears every alarm.
    pub(super) fn end(&mut self, sink: &mut dyn FnMut(AlarmChange)) {
        for alarm in self.open.iter_mut().filter_map(Option::take) {
            sink(AlarmChange::Cleared(alarm));
        }
    }

    fn clear_old(&mut self, detector: Detector, time: SimTime, sink: &mut dyn FnMut(AlarmChange)) {
        let old = |alarm: &mut Alarm| time.as_ns().saturating_sub(alarm.until.as_ns()) > MERGE_NS;
        if let Some(alarm) = self.open[detector.index()].take_if(old) {
            sink(AlarmChange::Cleared(alarm));
        }
    }
}
