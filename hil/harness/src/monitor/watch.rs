//! All detectors together.

use super::alarm::Board;
use super::clock::{ClockWatch, RateWatch};
use super::frames::{Step, Tracker};
use super::innovation::{Follower, Gains, VarianceSum};
use super::{AlarmChange, Declared, Detector, Limits};
use struna_kernel::{ParameterError, SimTime};
use struna_wire::Counters;

/// Steps up to which the follower carries its slope over a gap.
const CARRIED_STEPS: u64 = 3;

/// Watches one gyro.
///
/// Per chunk of bytes: [`Self::line`] with the decoder's counters after it, then [`Self::frame`]
/// for each frame that it completed, all with the chunk's arrival time; [`Self::pass`] while
/// nothing comes. [`super::Listener`] does that. Times do not go back. Nothing here allocates after
/// construction.
#[derive(Debug, Clone)]
pub struct Monitor {
    limits: Limits,
    gains: Gains,
    board: Board,
    tracker: Tracker,
    follower: Follower,
    variance: VarianceSum,
    clock: ClockWatch,
    rate: RateWatch,
    rest: Option<RestMean>,
    rest_quarter: u32,
    /// Counters at the last look.
    seen: Counters,
    last_bytes: Option<SimTime>,
    last_raw: Option<i64>,
    run: u32,
    last_rate_rad_s: Option<f64>,
}

/// Where signs go.
type Sink<'a> = &'a mut dyn FnMut(AlarmChange);

impl Monitor {
    /// A monitor with the limits that follow from `declared`.
    ///
    /// # Errors
    /// [`ParameterError`] for the first value refused.
    pub fn new(declared: &Declared) -> Result<Self, ParameterError> {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a declared rate is positive and at most 1e5 Hz"
        )]
        let rest_quarter = (declared.sample_rate_hz / 4.0).ceil().max(1.0) as u32;
        Ok(Self {
            limits: Limits::of(declared)?,
            gains: Gains::of(declared),
            board: Board::default(),
            tracker: Tracker::new(declared),
            follower: Follower::default(),
            variance: VarianceSum::default(),
            clock: ClockWatch::new(declared.period_s()),
            rate: RateWatch::new(declared.sample_rate_hz),
            rest: None,
            rest_quarter,
            seen: Counters::default(),
            last_bytes: None,
            last_raw: None,
            run: 1,
            last_rate_rad_s: None,
        })
    }

    /// The limits in force.
    #[must_use]
    pub const fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Declares that the body is at rest from now on, or no longer.
    pub fn declare_rest(&mut self, at_rest: bool) {
        if at_rest != self.rest.is_some() {
            self.rest = at_rest.then(RestMean::default);
        }
    }

    /// Takes the decoder's counters after a chunk of bytes that came at `arrival`.
    pub fn line(&mut self, arrival: SimTime, counters: &Counters, sink: Sink<'_>) {
        self.pass(arrival, sink);
        let seen = std::mem::replace(&mut self.seen, *counters);
        if self.last_bytes.replace(arrival).is_none_or(|last| self.is_silence(last, arrival))
            && !self.tracker.counts()
        {
            // How many frames never came is not known, so neither is when the next is due.
            self.clock.reset();
        }
        let skipped = counters.skipped_bytes - seen.skipped_bytes;
        // What comes before the first frame is the tail of one that began before us.
        if skipped > 0 && seen.ok > 0 {
            self.tracker.skip(skipped);
            self.board.sign((Detector::Check, arrival), (skipped as f64, 0.0), sink);
        }
        let repeats = |counters: &Counters| counters.duplicates + counters.backward;
        let repeated = repeats(counters) - repeats(&seen);
        if repeated > 0 {
            self.board.sign((Detector::Repeat, arrival), (repeated as f64, 0.0), sink);
        }
    }

    /// Takes a frame that came at `arrival`: its index by the decoder, the raw rate and its value.
    pub fn frame(
        &mut self,
        arrival: SimTime,
        index: u64,
        raw: i64,
        rate_rad_s: f64,
        sink: Sink<'_>,
    ) {
        let steps = match self.tracker.arrive(index, arrival) {
            Step::Back => {
                self.board.sign((Detector::Repeat, arrival), (1.0, 0.0), sink);
                return;
            }
            Step::First => 1,
            Step::Forward { steps, missing } => {
                if missing > 0 {
                    self.board.sign((Detector::Gap, arrival), (missing as f64, 0.0), sink);
                }
                steps
            }
        };
        self.watch_time(arrival, sink);
        self.watch_counts(arrival, raw, rate_rad_s, sink);
        self.watch_motion(arrival, steps, rate_rad_s, sink);
        self.watch_rest(arrival, rate_rad_s, sink);
    }

    /// Lets time pass without bytes.
    pub fn pass(&mut self, now: SimTime, sink: Sink<'_>) {
        if self.last_bytes.is_some_and(|last| self.is_silence(last, now)) {
            let limit = self.rate_limit();
            self.board.sign((Detector::Rate, now), (0.0, limit), sink);
        }
        self.board.pass(now, sink);
    }

    /// Ends the stream and clears what is still alarmed.
    pub fn finish(&mut self, sink: Sink<'_>) {
        self.board.end(sink);
    }

    fn is_silence(&self, last: SimTime, now: SimTime) -> bool {
        now.seconds_since(last) > self.limits.silence_s
    }

    fn rate_limit(&self) -> f64 {
        self.limits.rate_share
    }

    fn watch_time(&mut self, arrival: SimTime, sink: Sink<'_>) {
        if let Some(moved_s) = self.clock.arrive(self.tracker.index(), arrival)
            && moved_s.abs() > self.limits.clock_s
        {
            self.board.sign((Detector::Clock, arrival), (moved_s, self.limits.clock_s), sink);
        }
        self.rate.arrive(arrival);
        if let Some((frames, expected)) = self.rate.judge(arrival)
            && (frames / expected - 1.0).abs() > self.limits.rate_share
        {
            let off = self.limits.rate_share * expected;
            self.board.sign((Detector::Rate, arrival), (frames, expected - off), sink);
        }
    }

    fn watch_counts(&mut self, arrival: SimTime, raw: i64, rate_rad_s: f64, sink: Sink<'_>) {
        self.run =
            if self.last_raw.replace(raw) == Some(raw) { self.run.saturating_add(1) } else { 1 };
        if let Some(limit) = self.limits.stuck_samples.filter(|limit| self.run >= *limit) {
            let pair = (f64::from(self.run), f64::from(limit));
            self.board.sign((Detector::Stuck, arrival), pair, sink);
        }
        let limit = self.limits.saturation_rad_s;
        if rate_rad_s.abs() >= limit {
            self.board.sign((Detector::Saturation, arrival), (rate_rad_s, limit), sink);
        }
    }

    fn watch_motion(&mut self, arrival: SimTime, steps: u64, rate_rad_s: f64, sink: Sink<'_>) {
        let Limits { step_rad_s, step_per_gap_rad_s, innovation_rad_s: gate, .. } = self.limits;
        if let Some(last) = self.last_rate_rad_s.replace(rate_rad_s) {
            let limit = step_rad_s + (steps - 1) as f64 * step_per_gap_rad_s;
            let step = rate_rad_s - last;
            if step.abs() > limit {
                self.board.sign((Detector::Step, arrival), (step, limit), sink);
            }
        }
        self.follower.carry(steps.min(CARRIED_STEPS + 1), CARRIED_STEPS);
        let Some(innovation) = self.follower.follow(rate_rad_s, &self.gains, gate) else { return };
        if innovation.abs() > gate {
            self.board.sign((Detector::Innovation, arrival), (innovation, gate), sink);
        }
        let limit = self.limits.variance;
        let sum = self.variance.add(innovation / self.limits.innovation_sigma_rad_s, limit);
        if sum > limit {
            self.board.sign((Detector::Variance, arrival), (sum, limit), sink);
        }
    }

    fn watch_rest(&mut self, arrival: SimTime, rate_rad_s: f64, sink: Sink<'_>) {
        let Some(rest) = &mut self.rest else { return };
        let limit = self.limits.rest_rad_s;
        if let Some(mean) = rest.add(rate_rad_s, self.rest_quarter)
            && mean.abs() > limit
        {
            self.board.sign((Detector::Rest, arrival), (mean, limit), sink);
        }
    }
}

/// Mean over the last second, four times in a second.
#[derive(Debug, Clone, Copy, Default)]
struct RestMean {
    sum: f64,
    count: u32,
    quarters: [f64; 4],
    filled: u32,
}

impl RestMean {
    fn add(&mut self, rate_rad_s: f64, per_quarter: u32) -> Option<f64> {
        self.sum += rate_rad_s;
        self.count += 1;
        if self.count < per_quarter {
            return None;
        }
        self.quarters.rotate_left(1);
        self.quarters[3] = self.sum / f64::from(self.count);
        (self.sum, self.count) = (0.0, 0);
        self.filled = (self.filled + 1).min(4);
        (self.filled == 4).then(|| self.quarters.iter().sum::<f64>() / 4.0)
    }
}
