//! When samples were taken, from when they arrived.

use super::hull::{self, Point};
use std::collections::VecDeque;
use struna_kernel::SimTime;

const NS_PER_S: f64 = 1e9;
const PPM: f64 = 1e6;
/// Blocks of a window. Of each block one point is kept, so memory and work do not grow with the
/// sample rate.
const BLOCKS: usize = 256;
/// The same number, to divide times by.
const BLOCKS_NS: i64 = 256;
/// A line that is wrong by more than this is not late: somebody has set a clock.
const STEP_NS: f64 = 0.25e9;
/// How long every sample has to be late by a step before it is taken for one. A host that was
/// held up for long reads a backlog, whose samples become less and less late.
const STEP_SEEN_NS: i64 = 2_000_000_000;

/// What a [`TimeBase`] works with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeBaseSettings {
    /// Nominal period of the samples, s. Positive.
    pub period_s: f64,
    /// How far the true period may lie from it, as a fraction.
    pub tolerance: f64,
    /// How far back arrivals are looked at.
    pub window: SimTime,
    /// Until arrivals span this, no period is estimated.
    pub settle: SimTime,
    /// The constant part of every delay, which arrivals alone cannot show.
    pub latency: SimTime,
}

impl TimeBaseSettings {
    /// A window of 60 s, settled after 5 s, no constant delay.
    ///
    /// In simulation 5 s windows leave the period wrong by some 50 ppm behind a bridge of 16 ms,
    /// 60 s ones by 2 ppm.
    #[must_use]
    pub const fn new(period_s: f64, tolerance: f64) -> Self {
        Self {
            period_s,
            tolerance,
            window: SimTime::from_ns(60_000_000_000),
            settle: SimTime::from_ns(5_000_000_000),
            latency: SimTime::ZERO,
        }
    }
}

/// How far the sensor's period is from its nominal one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Skew {
    /// Relative deviation, parts per million. Positive: the sensor is slow.
    pub ppm: f64,
    /// Standard uncertainty, parts per million: the mean height of block minima over the line,
    /// divided by the span of the points that carry it.
    pub sigma_ppm: f64,
}

/// The least delayed sample of a block.
#[derive(Debug, Clone, Copy)]
struct Arrival {
    index: u64,
    time_ns: i64,
}

/// The line `time(k)`.
#[derive(Debug, Clone, Copy)]
struct Line {
    index: u64,
    time_ns: i64,
    period_ns: f64,
}

impl Line {
    /// How long after the line `time_ns` is, ns.
    fn lateness_ns(&self, index: u64, time_ns: i64) -> f64 {
        let periods = self.periods_to(index);
        time_ns.saturating_sub(self.time_ns) as f64 - periods * self.period_ns
    }

    fn periods_to(&self, index: u64) -> f64 {
        (i128::from(index) - i128::from(self.index)) as f64
    }

    fn time_of_ns(&self, index: u64) -> i64 {
        self.time_ns.saturating_add(to_ns(self.periods_to(index) * self.period_ns))
    }
}

#[expect(clippy::cast_possible_truncation, reason = "a float-to-int cast saturates")]
fn to_ns(ns: f64) -> i64 {
    ns.round() as i64
}

/// Estimates the sensor's clock `t_k = a + k·T` from sample indices and arrival times.
///
/// Delays are one-sided: nothing arrives before it was taken. So the line that is sought runs
/// below all arrivals and touches the least delayed of them; it is the edge of their lower convex
/// hull over the middle of a sliding window. Least squares would be drawn up by every delay.
///
/// Of each 256th part of the window only the least delayed sample is kept, and the hull of those
/// is formed when a part is complete or a sample falls below the line: a bounded cost for each
/// sample, a fixed memory, nothing allocated after construction. Until arrivals span
/// [`TimeBaseSettings::settle`] the arrival itself is the best there is.
///
/// A host clock that is set forward or back is noticed by samples that all come too late, or by
/// one that comes before it can; the time base goes on by the counter then.
///
/// # Source
/// Moon, Skelly and Towsley, *Estimation and removal of clock skew from network delay
/// measurements*, 1999, for the line below all arrivals; Olson, *A passive solution to the sensor
/// synchronization problem*, 2010, for the one-sided delays of sensors.
#[derive(Debug, Clone)]
pub struct TimeBase {
    settings: TimeBaseSettings,
    blocks: VecDeque<Arrival>,
    block_ns: i64,
    /// When the newest block began.
    block_start_ns: i64,
    hull: Vec<Point>,
    line: Option<Line>,
    /// Index span of the points that carry the line.
    carried: f64,
    settled: bool,
    /// Added to arrivals since the host's clock was set.
    correction_ns: i64,
    /// Since when every sample has been late by more than a step, and the least of that.
    late: Option<(i64, f64)>,
    latest_ns: i64,
}

/// What a sample did to the time base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Observed {
    /// It was taken in.
    Usual,
    /// The host's clock was set by so much, s; arrivals are corrected by it from here on.
    ClockSet(f64),
}

impl TimeBase {
    /// A time base that has seen nothing.
    #[must_use]
    pub fn new(settings: TimeBaseSettings) -> Self {
        // One more than a window holds, and the one that begins.
        let kept = BLOCKS + 2;
        Self {
            settings,
            blocks: VecDeque::with_capacity(kept),
            block_ns: (settings.window.as_ns() / BLOCKS_NS).max(1),
            block_start_ns: 0,
            hull: Vec::with_capacity(kept),
            line: None,
            carried: 0.0,
            settled: false,
            correction_ns: 0,
            late: None,
            latest_ns: i64::MIN,
        }
    }

    /// Whether the period is estimated; until then arrivals are passed on as they are.
    #[must_use]
    pub const fn is_settled(&self) -> bool {
        self.settled
    }

    /// The period of the samples as far as it is known, s.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        match self.line {
            Some(line) if self.settled => line.period_ns / NS_PER_S,
            _ => self.settings.period_s,
        }
    }

    /// How much later than by the line so far sample `index` arrived, s; zero before there is one.
    #[must_use]
    pub fn lateness_s(&self, index: u64, arrival: SimTime) -> f64 {
        let time_ns = arrival.as_ns().saturating_add(self.correction_ns);
        self.line.map_or(0.0, |line| line.lateness_ns(index, time_ns) / NS_PER_S)
    }

    /// When sample `index`, which has just arrived, was taken, by the host's clock as it was at
    /// the start, less the declared constant delay.
    #[must_use]
    pub fn time_of(&self, index: u64, arrival: SimTime) -> SimTime {
        let time_ns = match self.line {
            Some(line) if self.settled => line.time_of_ns(index),
            _ => arrival.as_ns().saturating_add(self.correction_ns),
        };
        SimTime::from_ns(time_ns.saturating_sub(self.settings.latency.as_ns()))
    }

    /// The skew, once the period is estimated.
    #[must_use]
    pub fn skew(&self) -> Option<Skew> {
        let line = self.line.filter(|_| self.settled && self.carried > 0.0)?;
        let late = |block: &Arrival| line.lateness_ns(block.index, block.time_ns).max(0.0);
        let mean_ns = self.blocks.iter().map(late).sum::<f64>() / self.blocks.len().max(1) as f64;
        let nominal_ns = self.settings.period_s * NS_PER_S;
        Some(Skew {
            ppm: (line.period_ns / nominal_ns - 1.0) * PPM,
            sigma_ppm: mean_ns / (self.carried * nominal_ns) * PPM,
        })
    }

    /// Takes the arrival of sample `index`. Indices must increase; one that does not is ignored.
    pub fn observe(&mut self, index: u64, arrival: SimTime) -> Observed {
        let mut time_ns = arrival.as_ns().saturating_add(self.correction_ns);
        let Some(line) = self.line else {
            self.begin(index, time_ns, self.settings.period_s * NS_PER_S);
            return Observed::Usual;
        };
        if self.blocks.back().is_some_and(|newest| index <= newest.index) {
            return Observed::Usual;
        }
        let mut lateness_ns = line.lateness_ns(index, time_ns);
        let mut observed = Observed::Usual;
        if let Some(set_ns) = self.clock_set(time_ns, lateness_ns) {
            self.correction_ns = self.correction_ns.saturating_sub(set_ns);
            time_ns = time_ns.saturating_sub(set_ns);
            lateness_ns = line.lateness_ns(index, time_ns);
            self.blocks.clear();
            self.late = None;
            observed = Observed::ClockSet(set_ns as f64 / NS_PER_S);
        }
        self.latest_ns = time_ns;
        if self.late.is_some() {
            // As late as this it tells nothing about the line, and if a clock was set it would
            // push what does out of the window.
            return observed;
        }
        let complete = self.note(Arrival { index, time_ns }, lateness_ns);
        if complete || lateness_ns < 0.0 {
            self.fit();
        }
        observed
    }

    /// Starts anew with sample `index`, keeping the period: the sensor paused, or its counter
    /// started again.
    pub fn restart(&mut self, index: u64, arrival: SimTime) {
        let time_ns = arrival.as_ns().saturating_add(self.correction_ns);
        let nominal_ns = self.settings.period_s * NS_PER_S;
        self.begin(index, time_ns, self.line.map_or(nominal_ns, |line| line.period_ns));
    }

    fn begin(&mut self, index: u64, time_ns: i64, period_ns: f64) {
        self.line = Some(Line { index, time_ns, period_ns });
        self.late = None;
        self.latest_ns = time_ns;
        self.blocks.clear();
        self.note(Arrival { index, time_ns }, 0.0);
    }

    /// By how much the host's clock has been set, if this sample shows it.
    fn clock_set(&mut self, time_ns: i64, lateness_ns: f64) -> Option<i64> {
        let unsure = if self.settled { 1e-3 } else { self.settings.tolerance };
        let silent_ns = time_ns.saturating_sub(self.latest_ns).max(0) as f64;
        if lateness_ns < -(STEP_NS + unsure * silent_ns) {
            return Some(to_ns(lateness_ns));
        }
        if lateness_ns < STEP_NS || !self.settled {
            self.late = None;
            return None;
        }
        let (since_ns, least_ns) = self.late.unwrap_or((time_ns, lateness_ns));
        let least_ns = least_ns.min(lateness_ns);
        self.late = Some((since_ns, least_ns));
        (time_ns.saturating_sub(since_ns) >= STEP_SEEN_NS).then(|| to_ns(least_ns))
    }

    /// Keeps `arrival` if it is the least late of its block; true when a block is complete.
    fn note(&mut self, arrival: Arrival, lateness_ns: f64) -> bool {
        let begins = self.blocks.is_empty()
            || arrival.time_ns.saturating_sub(self.block_start_ns) >= self.block_ns;
        if begins {
            self.block_start_ns = arrival.time_ns;
            self.drop_old(arrival.time_ns);
            self.blocks.push_back(arrival);
            return self.blocks.len() > 1;
        }
        let line = self.line;
        if let Some(newest) = self.blocks.back_mut()
            && line.is_none_or(|line| lateness_ns <= line.lateness_ns(newest.index, newest.time_ns))
        {
            *newest = arrival;
        }
        false
    }

    fn drop_old(&mut self, now_ns: i64) {
        let window_ns = self.settings.window.as_ns();
        let is_old = |block: &Arrival| now_ns.saturating_sub(block.time_ns) > window_ns;
        while self.blocks.front().is_some_and(is_old) || self.blocks.len() > BLOCKS {
            self.blocks.pop_front();
        }
    }

    /// Lays the line below the arrivals of the window.
    fn fit(&mut self) {
        let (Some(line), Some(first), Some(last)) =
            (self.line, self.blocks.front(), self.blocks.back())
        else {
            return;
        };
        let span_ns = last.time_ns.saturating_sub(first.time_ns);
        if span_ns < self.settings.settle.as_ns() {
            // Too short for a period: keep the one there is, below all arrivals.
            self.lower();
            return;
        }
        // Heights over the line so far are small numbers, whatever the time of day.
        self.hull.clear();
        for block in &self.blocks {
            let height_s = line.lateness_ns(block.index, block.time_ns) / NS_PER_S;
            let point = Point { index: (block.index - first.index) as f64, arrival_s: height_s };
            hull::extend(&mut self.hull, point);
        }
        let middle = (last.index - first.index) as f64 / 2.0;
        let Some((a, b)) = hull::edge_over(&self.hull, middle) else { return };
        let tilt_ns = (b.arrival_s - a.arrival_s) / (b.index - a.index) * NS_PER_S;
        let height_ns = a.arrival_s * NS_PER_S - a.index * tilt_ns;
        let index = first.index;
        let time_ns = line.time_of_ns(index).saturating_add(to_ns(height_ns));
        self.line = Some(Line { index, time_ns, period_ns: line.period_ns + tilt_ns });
        self.carried = b.index - a.index;
        self.settled = true;
    }

    /// Moves the line, its period as it is, until it touches the arrivals from below.
    fn lower(&mut self) {
        let Some(line) = self.line else { return };
        let late = |block: &Arrival| line.lateness_ns(block.index, block.time_ns);
        let least_ns = self.blocks.iter().map(late).fold(f64::INFINITY, f64::min);
        if least_ns.is_finite() {
            let time_ns = line.time_ns.saturating_add(to_ns(least_ns));
            self.line = Some(Line { time_ns, ..line });
        }
    }
}
