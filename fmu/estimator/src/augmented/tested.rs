//! The five-state filter that tests its own innovations, and goes back when they show a kick.

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
    filter: AugmentedFilter,
    windows: Windows,
    kick_floor_variance: f64,
    /// Seconds predicted since the last measurement.
    since_update_s: f64,
    history: History,
    watch: Watch,
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
        let expected = predicted.expect(rate_rad_s);
        if model.is_over_range(rate_rad_s, expected.residual) {
            let innovation = model.innovation(expected.residual, expected.spread)?;
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
        let kick_rad_s = history.mean_residual_rad_s(length);
        // A re-run that leaves the range of floating point is given up; what stands, stands.
        if let Ok(state) = self.rerun(length, kick_rad_s) {
            self.filter.state = state;
        }
        self.history.reset(&self.filter.state);
        self.watch.alarm();
    }

    /// The state now, had a kick of about this size been reckoned with from before the window.
    fn rerun(&self, length: usize, kick_rad_s: f64) -> Result<State, EstimatorError> {
        let model = &self.filter.model;
        let (mut state, count) = self.history.way_back(length);
        let inflation = 4.0 * kick_rad_s * kick_rad_s + self.kick_floor_variance;
        let inflation = in_range(inflation / count as f64)?;
        for (k, sample) in (1..=count).zip(self.history.latest(count)) {
            state = model.predicted(&state, sample.span_s)?;
            state.p.ww += inflation;
            let Some(rate_rad_s) = sample.rate_rad_s else { continue };
            let expected = state.expect(rate_rad_s);
            if model.is_over_range(rate_rad_s, expected.residual) {
                continue;
            }
            state = if k + UNGATED > count {
                model.innovation(expected.residual, expected.spread)?;
                model.bounded(state.updated(&expected, model.r)).judged()?
            } else {
                gated_update(model, &state, &expected)?.state
            };
        }
        Ok(state)
    }
}

/// An update in which a sample beyond the gate hardly counts.
#[inline(always)]
fn gated_update(
    model: &Model,
    predicted: &State,
    expected: &Expectation,
) -> Result<Updated, EstimatorError> {
    let innovation = model.innovation(expected.residual, expected.spread)?;
    let gated = expected.residual * expected.residual > GATE * GATE * innovation.variance_rad2_s2;
    let r = if gated { model.r * GATED_VARIANCE } else { model.r };
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
        check_measurement(rate_rad_s)?;
        let expected = self.filter.state.expect(rate_rad_s);
        let innovation = self.filter.model.innovation(expected.residual, expected.spread)?;
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
        State::SAVED_LEN + 8 + Watch::SAVED_LEN + History::SAVED_LEN
    }

    fn save(&self, out: &mut [u8]) {
        let mut out = Writer::new(out);
        self.filter.state.write(&mut out);
        out.f64(self.since_update_s);
        self.watch.write(&mut out);
        self.history.write(&mut out);
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        let mut bytes = Reader::new(bytes, self.saved_len())?;
        let state = self.filter.model.bounded(State::read(&mut bytes)?);
        let since_update_s = bytes.finite("since_update_s")?;
        let watch = Watch::read(&mut bytes)?;
        self.history = History::read(&mut bytes, state)?;
        self.filter.state = state;
        self.since_update_s = since_update_s;
        self.watch = watch;
        Ok(())
    }
}
