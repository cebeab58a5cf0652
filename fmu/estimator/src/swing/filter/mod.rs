//! The filter of a swinging body watched by a gyro of one axis, with roll-back.

pub(crate) mod gaussian;
pub(crate) mod model;

pub use gaussian::SWING_STATES;

use crate::augmented::history::{HistoryOf, Sample, Snapshot};
use crate::augmented::watch::Watch;
use crate::augmented::windows::{CLIP, GATE, GATED_VARIANCE, InnovationTest, Windows};
use crate::checks::{check_measurement, check_span, in_range};
use crate::config::{ConfigError, judge, not_negative};
use crate::state_bytes::{Reader, RestoreError, Writer};
use crate::swing::config::SwingConfig;
use crate::{Belief, EstimatorError, Innovation, MotionState, RateEstimator, Status};
use gaussian::{Expectation, Gaussian};
use model::Model;

/// Samples at the end of a re-run that are not gated: they may be the kick itself.
const UNGATED: u64 = 3;
/// Swing below which it need not be spoken of: 0.3°, rad.
pub(crate) const SWING_MIN_RAD: f64 = 0.3 * core::f64::consts::PI / 180.0;

/// What is believed of a swinging body and its gyro: a mean and its covariance.
///
/// Fourteen states, SI units: e₁ and e₂ of the vertical in body axes, twist, the three body rates;
/// Ω², 2ζΩ, the scales of the moments A and B and of the swing's decay; the gyro's bias, and g₁
/// and g₂ of its input axis. The first eleven stand as in
/// [`Tangents`](crate::Tangents).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SwingBelief {
    /// Mean.
    pub mean: [f64; SWING_STATES],
    /// Covariance, symmetric; the lower triangle is what counts.
    pub covariance: [[f64; SWING_STATES]; SWING_STATES],
}

impl SwingBelief {
    /// Independent states.
    #[must_use]
    pub fn independent(mean: [f64; SWING_STATES], sigmas: [f64; SWING_STATES]) -> Self {
        let Gaussian { mean, p } = Gaussian::diagonal(mean, sigmas);
        Self { mean, covariance: p }
    }

    /// Checks that every number is one, that no variance is negative, and that the body hangs at
    /// less than a right angle.
    ///
    /// # Errors
    /// [`ConfigError`] names the first value out of its bound.
    pub fn validate(&self) -> Result<(), ConfigError> {
        for mean in self.mean {
            judge("mean", mean, true, "a number")?;
        }
        for (i, row) in self.covariance.iter().enumerate() {
            not_negative("variance", row[i])?;
            for entry in row {
                judge("covariance", *entry, true, "a number")?;
            }
        }
        let [x, y, ..] = self.mean;
        let across = x * x + y * y;
        judge("e1^2 + e2^2", across, across < 1.0, "less than 1")
    }
}

/// Extended Kalman filter of the swinging body watched by one gyro, behind a gate for outliers and
/// a windowed test for kicks, with roll-back.
///
/// It must be told how the body swings: what the swing does along the gyro's axis is seen at once,
/// what it does across only through the twist, and a filter started in ignorance commits itself to
/// the wrong one of several motions. From a belief fitted to the first half period it follows the
/// swing at any amplitude.
///
/// The test is that of [`TestedFilter`](crate::TestedFilter); a kick is seen in the rate about the
/// body's axis and reckoned with in all three. What it needs, some 700 kB, is allocated once, when
/// it is made.
#[derive(Debug, Clone)]
pub struct SwingFilter {
    model: Model,
    state: Gaussian,
    windows: Windows,
    kick_floor_variance: f64,
    /// Seconds predicted since the last measurement.
    since_update_s: f64,
    history: HistoryOf<Gaussian>,
    watch: Watch,
}

impl SwingFilter {
    /// A filter of the given body and gyro that starts from `belief`. Of `config.start` it takes
    /// the period alone, for the bounds of what may be learnt.
    ///
    /// # Errors
    /// [`ConfigError`] names the value out of its bound.
    pub fn new(
        config: &SwingConfig,
        test: &InnovationTest,
        belief: &SwingBelief,
    ) -> Result<Self, ConfigError> {
        config.validate()?;
        test.validate()?;
        let model = Model::new(config);
        let state = model.started(belief)?;
        Ok(Self {
            model,
            state,
            windows: Windows::new(test),
            kick_floor_variance: test.kick_floor_rad_s * test.kick_floor_rad_s,
            since_update_s: 0.0,
            history: HistoryOf::new(state),
            watch: Watch::default(),
        })
    }

    /// Starts afresh from `belief`, without allocating.
    ///
    /// # Errors
    /// [`ConfigError`] for a belief that is none; the filter is then unchanged.
    pub fn restart(&mut self, belief: &SwingBelief) -> Result<(), ConfigError> {
        self.state = self.model.started(belief)?;
        self.since_update_s = 0.0;
        self.history.reset(&self.state);
        self.watch = Watch::default();
        Ok(())
    }

    /// Predicts over `span_s` and takes in a measurement valid at its end: both, or neither.
    ///
    /// # Errors
    /// What predict and update refuse; the filter is then as it was before the call.
    pub fn step(&mut self, span_s: f64, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        let predicted = self.model.predicted(&self.state, span_s)?;
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
        let predicted = self.model.predicted(&self.state, span_s)?;
        let span_s = in_range(self.since_update_s + span_s)?;
        self.note_over_range(&predicted, span_s, rate_rad_s)
    }

    /// Mean and covariance of all that is believed. The scale factor is left out of it.
    #[must_use]
    pub fn swing_belief(&self) -> SwingBelief {
        SwingBelief { mean: self.state.mean, covariance: self.state.p }
    }

    /// Attitude and rates as now believed.
    #[must_use]
    pub fn motion(&self) -> MotionState {
        self.state.motion()
    }

    /// Largest angle of the swing as now believed, rad.
    #[must_use]
    pub fn amplitude_rad(&self) -> f64 {
        self.model.motion.amplitude_rad(&self.state.motion())
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
        predicted: &Gaussian,
        span_s: f64,
        rate_rad_s: f64,
    ) -> Result<Innovation, EstimatorError> {
        check_measurement(rate_rad_s)?;
        let expected = self.model.expected(predicted, rate_rad_s)?;
        let innovation = self.model.innovation(&expected)?;
        if self.model.is_over_range(rate_rad_s, expected.residual) {
            self.pass_over(predicted, span_s);
            return Ok(innovation);
        }
        let (r, gated) = self.gate(&innovation);
        self.state = self.model.updated(predicted, &expected, r)?;
        self.since_update_s = 0.0;
        let (residual_rad_s, variance) = (innovation.residual_rad_s, innovation.variance_rad2_s2);
        let normalised = residual_rad_s / libm::sqrt(variance);
        let sample = Sample { span_s, rate_rad_s: Some(rate_rad_s), residual_rad_s };
        self.history.push(sample, normalised.clamp(-CLIP, CLIP), &self.state);
        self.watch.used(span_s, (!gated).then_some(normalised * normalised));
        let history = &self.history;
        if self.windows.any_beyond(history.reach(), |length| history.sum_over(length)) {
            self.raise_alarm();
        }
        Ok(innovation)
    }

    /// The variance that a sample counts with, and whether it is beyond the gate.
    #[inline(always)]
    fn gate(&self, innovation: &Innovation) -> (f64, bool) {
        let gated = innovation.nis() > GATE * GATE;
        (if gated { self.model.r * GATED_VARIANCE } else { self.model.r }, gated)
    }

    /// Judges a measurement that is not to be used, and notes it.
    fn note_over_range(
        &mut self,
        predicted: &Gaussian,
        span_s: f64,
        rate_rad_s: f64,
    ) -> Result<Innovation, EstimatorError> {
        check_measurement(rate_rad_s)?;
        let innovation = self.model.innovation(&self.model.expected(predicted, rate_rad_s)?)?;
        self.pass_over(predicted, span_s);
        Ok(innovation)
    }

    /// Notes a measurement that is not used, `span_s` after the last one.
    fn pass_over(&mut self, predicted: &Gaussian, span_s: f64) {
        self.state = *predicted;
        let sample = Sample { span_s, rate_rad_s: None, residual_rad_s: 0.0 };
        self.history.push(sample, 0.0, &self.state);
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
            self.state = state;
        }
        self.history.reset(&self.state);
        self.watch.alarm();
    }

    /// The state now, had a kick of about this size been reckoned with from before the window.
    fn rerun(&self, length: usize, kick_rad_s: f64) -> Result<Gaussian, EstimatorError> {
        let (mut state, count) = self.history.way_back(length);
        let inflation = 4.0 * kick_rad_s * kick_rad_s + self.kick_floor_variance;
        let inflation = in_range(inflation / count as f64)?;
        for (k, sample) in (1..=count).zip(self.history.latest(count)) {
            state = self.model.predicted(&state, sample.span_s)?;
            state.inflate_rates(inflation);
            if let Some(rate_rad_s) = sample.rate_rad_s {
                state = self.retaken(&state, rate_rad_s, k + UNGATED > count)?;
            }
        }
        Ok(state)
    }

    /// A measurement taken in again, with the gate or without.
    fn retaken(
        &self,
        from: &Gaussian,
        rate_rad_s: f64,
        ungated: bool,
    ) -> Result<Gaussian, EstimatorError> {
        let expected: Expectation = self.model.expected(from, rate_rad_s)?;
        if self.model.is_over_range(rate_rad_s, expected.residual) {
            return Ok(*from);
        }
        let innovation = self.model.innovation(&expected)?;
        let r = if ungated { self.model.r } else { self.gate(&innovation).0 };
        self.model.updated(from, &expected, r)
    }
}

/// An update that raises an alarm may grow variances: that is what a roll-back is for.
impl RateEstimator for SwingFilter {
    fn predict(&mut self, span_s: f64) -> Result<(), EstimatorError> {
        check_span(span_s)?;
        let since_update_s = in_range(self.since_update_s + span_s)?;
        self.state = self.model.predicted(&self.state, span_s)?;
        self.since_update_s = since_update_s;
        Ok(())
    }

    fn update(&mut self, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        let predicted = self.state;
        self.absorb(&predicted, self.since_update_s, rate_rad_s)
    }

    /// It is noted and not used.
    fn update_over_range(&mut self, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        let predicted = self.state;
        self.note_over_range(&predicted, self.since_update_s, rate_rad_s)
    }

    /// The twist of the string and its rate.
    fn belief(&self) -> Belief {
        self.model.belief(&self.state)
    }

    /// Swinging from 0.3° on, when nothing worse is to be said.
    fn status(&self) -> Status {
        let period_s = core::f64::consts::TAU / libm::sqrt(self.state.parameters().stiffness_1_s2);
        let at_bound = self.model.is_at_a_bound(&self.state);
        let claim = self.belief().covariance.angle_rad2;
        swinging(self.watch.status(claim, period_s, at_bound), self.amplitude_rad())
    }

    fn saved_len(&self) -> usize {
        Gaussian::SAVED_LEN + 8 + Watch::SAVED_LEN + HistoryOf::<Gaussian>::SAVED_LEN
    }

    fn save(&self, out: &mut [u8]) {
        let mut out = Writer::new(out);
        self.state.write(&mut out);
        out.f64(self.since_update_s);
        self.watch.write(&mut out);
        self.history.write(&mut out);
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        let mut bytes = Reader::new(bytes, self.saved_len())?;
        let state = self.model.bounded(Gaussian::read(&mut bytes)?);
        let since_update_s = bytes.finite("since_update_s")?;
        let watch = Watch::read(&mut bytes)?;
        self.history = HistoryOf::read(&mut bytes, state)?;
        self.state = state;
        self.since_update_s = since_update_s;
        self.watch = watch;
        Ok(())
    }
}

/// `status`, with a swing that is wide enough to speak of spoken of.
pub(crate) fn swinging(status: Status, amplitude_rad: f64) -> Status {
    if status == Status::Nominal && amplitude_rad > SWING_MIN_RAD {
        Status::Swinging { amplitude_rad }
    } else {
        status
    }
}
