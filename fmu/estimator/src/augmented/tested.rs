//! The five-state filter that tests its own innovations, and goes back when they show a kick.

use super::alarm::Alarm;
use super::config::AugmentedConfig;
use super::filter::{AugmentedFilter, Model};
use super::history::{History, Sample};
use super::state::{Expectation, State};
use super::watch::Watch;
use super::windows::{CLIP, GATE, GATED_VARIANCE, InnovationTest, Windows};
use crate::checks::{check_measurement, check_span, in_range};
use crate::config::ConfigError;
use crate::state_bytes::{Reader, RestoreError, Writer};
use crate::{Belief, EstimatorError, Innovation, RateEstimator, Status};

/// Samples at the end of a re-run that are not gated: they may be the kick itself.
const UNGATED: u64 = 3;

/// [`AugmentedFilter`] behind a gate for outliers and a windowed test for kicks, with roll-back.
///
/// A kick of the body leads the innovations astray for as long as the filter does not believe it.
/// After every sample the mean of the innovations over twelve windows, from 3 to 2048 samples, is
/// held against its threshold. On an alarm the filter goes back to before the kick, makes its rate
/// as uncertain as the kick was large, and runs to the present again; the past that was published
/// stays published. No size of the kick is assumed, and a false alarm costs little.
///
/// What it needs for that, some 200 kB, is allocated once, when it is made.
///
/// # Source
/// A generalised likelihood ratio test in the manner of Willsky and Jones (1976), with clipped
/// innovations and roll-back instead of a compensation of the state.
#[derive(Debug, Clone)]
pub struct TestedFilter {
    pub(super) filter: AugmentedFilter,
    windows: Windows,
    kick_floor_variance: f64,
    /// Seconds predicted since the last measurement.
    since_update_s: f64,
    pub(super) history: History,
    watch: Watch,
    /// Zeros before the first.
    alarm: Alarm,
}

/// A state and what a measurement was to the one before, not yet taken over.
#[derive(Debug, Clone, Copy)]
struct Updated {
    state: State,
    innovation: Innovation,
    gated: bool,
}

impl TestedFilter {
    /// A filter with the given prior, noise and test.
    ///
    /// # Errors
    /// [`ConfigError`] names the value out of its bound.
    pub fn new(config: &AugmentedConfig, test: &InnovationTest) -> Result<Self, ConfigError> {
        test.validate()?;
        let filter = AugmentedFilter::new(config)?;
        Ok(Self {
            windows: Windows::new(test),
            kick_floor_variance: test.kick_floor_rad_s * test.kick_floor_rad_s,
            since_update_s: 0.0,
            history: History::new(filter.state),
            watch: Watch::default(),
            alarm: Alarm::default(),
            filter,
        })
    }

    /// Predicts over `span_s` and takes in a measurement valid at its end: both, or neither.
    ///
    /// # Errors
    /// What predict and update refuse; the filter is then as it was before the call.
    #[inline(always)]
    pub fn step(&mut self, span_s: f64, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        let predicted = self.filter.model.predicted(&self.filter.state, span_s)?;
        let span_s = in_range(self.since_update_s + span_s)?;
        self.absorb(&predicted, span_s, rate_rad_s)
    }

    /// Predicts over `span_s` and notes a measurement that the gyro flags as over range: both, or
    /// neither.
    ///
    /// # Errors
    /// What predict and update refuse; the filter is then as it was before the call.
    pub fn step_over_range(
        &mut self,
        span_s: f64,
        rate_rad_s: f64,
    ) -> Result<Innovation, EstimatorError> {
        let predicted = self.filter.model.predicted(&self.filter.state, span_s)?;
        let span_s = in_range(self.since_update_s + span_s)?;
        let innovation = self.filter.model.surprise(&predicted, rate_rad_s)?;
        self.filter.state = predicted;
        self.pass_over(span_s);
        Ok(innovation)
    }

    /// The filter behind the test.
    #[must_use]
    pub fn filter(&self) -> &AugmentedFilter {
        &self.filter
    }

    /// Starts afresh from another belief, `passed_s` after the last measurement that came here:
    /// alarms of before do not count any more.
    pub(crate) fn restart(&mut self, state: State, passed_s: f64) -> Result<(), EstimatorError> {
        self.filter.set_state(state)?;
        self.history.reset(&self.filter.state);
        self.watch.restart(passed_s);
        self.since_update_s = 0.0;
        Ok(())
    }

    /// Alarms so far.
    #[must_use]
    pub fn alarms(&self) -> u64 {
        self.watch.alarms()
    }

    /// The last alarm: when, and what was made of it.
    #[must_use]
    pub fn last_alarm(&self) -> Option<Alarm> {
        (self.alarms() > 0).then_some(self.alarm)
    }

    /// Takes a measurement into `predicted`, `span_s` after the last one.
    #[inline(always)]
    fn absorb(
        &mut self,
        predicted: &State,
        span_s: f64,
        rate_rad_s: f64,
    ) -> Result<Innovation, EstimatorError> {
        check_measurement(rate_rad_s)?;
        let model = &self.filter.model;
        let expected = model.expected(predicted, rate_rad_s);
        if model.is_over_range(rate_rad_s, expected.residual) {
            let innovation = model.innovation_of(&expected)?;
            self.filter.state = *predicted;
            self.pass_over(span_s);
            return Ok(innovation);
        }
        let Updated { state, innovation, gated } = gated_update(model, predicted, &expected)?;
        self.filter.state = state;
        self.since_update_s = 0.0;
        let (residual_rad_s, variance) = (innovation.residual_rad_s, innovation.variance_rad2_s2);
        let normalised = residual_rad_s / libm::sqrt(variance);
        let sample = Sample { span_s, rate_rad_s: Some(rate_rad_s), residual_rad_s };
        self.history.push(sample, normalised.clamp(-CLIP, CLIP), &state);
        self.watch.used(span_s, (!gated).then_some(normalised * normalised));
        let history = &self.history;
        if self.windows.any_beyond(history.reach(), |length| history.sum_over(length)) {
            self.raise_alarm();
        }
        Ok(innovation)
    }

    /// Notes a measurement that is not used, `span_s` after the last one.
    fn pass_over(&mut self, span_s: f64) {
        let sample = Sample { span_s, rate_rad_s: None, residual_rad_s: 0.0 };
        self.history.push(sample, 0.0, &self.filter.state);
        self.watch.over_range(span_s);
        self.since_update_s = 0.0;
    }

    /// Goes back, runs again, and starts afresh from there.
    #[cold]
    #[inline(never)]
    fn raise_alarm(&mut self) {
        let history = &self.history;
        let length = self.windows.furthest(history.reach(), |length| history.sum_over(length));
        let (state, samples) = history.way_back(length);
        self.alarm = Alarm {
            time_s: self.watch.elapsed_s(),
            window_samples: Alarm::count(length as u64),
            kick_rad_s: history.mean_residual_rad_s(length),
            rerun_samples: Alarm::count(samples),
        };
        // A re-run that leaves the range of floating point is given up; what stands, stands.
        match self.rerun(state, |_, _| {}) {
            Ok(state) => self.filter.state = state,
            Err(_) => self.alarm.rerun_samples = 0,
        }
        self.history.reset(&self.filter.state);
        self.watch.alarm();
    }

    /// Variance of the rate that the last alarm adds in each sample that is run again, rad²/s².
    pub(super) fn inflation(&self) -> Result<f64, EstimatorError> {
        let Alarm { kick_rad_s, rerun_samples, .. } = self.alarm;
        let inflation = 4.0 * kick_rad_s * kick_rad_s + self.kick_floor_variance;
        in_range(inflation / f64::from(rerun_samples.max(1)))
    }

    /// The state now, had the kick of the last alarm been reckoned with since `state`; `each` is
    /// shown every sample on the way and the state after it.
    pub(super) fn rerun(
        &self,
        mut state: State,
        mut each: impl FnMut(&Sample, &State),
    ) -> Result<State, EstimatorError> {
        let inflation = self.inflation()?;
        let count = u64::from(self.alarm.rerun_samples);
        for (k, sample) in (1..=count).zip(self.history.latest(count)) {
            state = self.filter.model.predicted(&state, sample.span_s)?;
            state.p.ww += inflation;
            if let Some(rate_rad_s) = sample.rate_rad_s {
                state = self.retaken(&state, rate_rad_s, k + UNGATED > count)?;
            }
            each(sample, &state);
        }
        Ok(state)
    }

    /// A measurement taken in again, with the gate or without.
    fn retaken(&self, from: &State, rate: f64, ungated: bool) -> Result<State, EstimatorError> {
        let model = &self.filter.model;
        let expected = model.expected(from, rate);
        if model.is_over_range(rate, expected.residual) {
            return Ok(*from);
        }
        if !ungated {
            return Ok(gated_update(model, from, &expected)?.state);
        }
        model.innovation_of(&expected)?;
        model.bounded(from.updated(&expected, expected.r)).judged()
    }
}

/// An update in which a sample beyond the gate hardly counts.
#[inline(always)]
fn gated_update(
    model: &Model,
    predicted: &State,
    expected: &Expectation,
) -> Result<Updated, EstimatorError> {
    let innovation = model.innovation_of(expected)?;
    let gated = expected.residual * expected.residual > GATE * GATE * innovation.variance_rad2_s2;
    let r = if gated { expected.r * GATED_VARIANCE } else { expected.r };
    let state = model.bounded(predicted.updated(expected, r)).judged()?;
    Ok(Updated { state, innovation, gated })
}

/// An update that raises an alarm may grow variances: that is what a roll-back is for.
impl RateEstimator for TestedFilter {
    #[inline(always)]
    fn predict(&mut self, span_s: f64) -> Result<(), EstimatorError> {
        check_span(span_s)?;
        let since_update_s = in_range(self.since_update_s + span_s)?;
        self.filter.predict(span_s)?;
        self.since_update_s = since_update_s;
        Ok(())
    }

    #[inline(always)]
    fn update(&mut self, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        let predicted = self.filter.state;
        self.absorb(&predicted, self.since_update_s, rate_rad_s)
    }

    /// It is noted and not used.
    fn update_over_range(&mut self, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        let innovation = self.filter.model.surprise(&self.filter.state, rate_rad_s)?;
        self.pass_over(self.since_update_s);
        Ok(innovation)
    }

    fn belief(&self) -> Belief {
        self.filter.belief()
    }

    fn status(&self) -> Status {
        let state = &self.filter.state;
        let period_s = core::f64::consts::TAU / libm::sqrt(state.mean.s);
        let at_bound = self.filter.model.is_at_a_bound(state);
        self.watch.status(self.belief().covariance.angle_rad2, period_s, at_bound)
    }

    fn saved_len(&self) -> usize {
        State::SAVED_LEN + 8 + Watch::SAVED_LEN + Alarm::SAVED_LEN + History::SAVED_LEN
    }

    fn save(&self, out: &mut [u8]) {
        let mut out = Writer::new(out);
        self.filter.state.write(&mut out);
        out.f64(self.since_update_s);
        self.watch.write(&mut out);
        self.alarm.write(&mut out);
        self.history.write(&mut out);
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        let mut bytes = Reader::new(bytes, self.saved_len())?;
        let state = self.filter.model.bounded(State::read(&mut bytes)?);
        let since_update_s = bytes.finite("since_update_s")?;
        let watch = Watch::read(&mut bytes)?;
        let alarm = Alarm::read(&mut bytes)?;
        self.history = History::read(&mut bytes, state)?;
        self.filter.state = state;
        self.since_update_s = since_update_s;
        self.watch = watch;
        self.alarm = alarm;
        Ok(())
    }
}
