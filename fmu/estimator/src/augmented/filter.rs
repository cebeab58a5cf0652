//! The five-state filter by itself.

use super::config::AugmentedConfig;
use super::rounding::Rounding;
use super::state::{Densities, Expectation, State};
use super::transition::is_short;
use crate::checks::{check_measurement, check_span, in_range};
use crate::config::ConfigError;
use crate::state_bytes::{Reader, RestoreError, Writer};
use crate::{
    Belief, Covariance, EstimatorError, Innovation, RateEstimator, Status, step_mean_in_halves,
};

/// How far Ω² may be led from its start, either way, as a factor: a tenth of the period, or ten.
const S_SPAN: f64 = 100.0;
/// How far 2ζΩ may be led, in units of the start's Ω: below zero, and above.
const D_SPAN: (f64, f64) = (0.5, 20.0);

/// Extended Kalman filter of the torsional oscillator, augmented by its parameters and the gyro's
/// bias.
///
/// It learns period, damping and bias while it watches. It takes the model for granted: a body
/// that is struck or a measurement that lies spoils it for good. For a real rig there is
/// [`TestedFilter`](crate::TestedFilter).
#[derive(Debug, Clone)]
pub struct AugmentedFilter {
    pub(super) model: Model,
    pub(super) state: State,
}

/// All that does not evolve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Model {
    r: f64,
    q: Densities,
    /// The quantiser, where it is not dithered away.
    rounding: Option<Rounding>,
    scale_factor_variance: f64,
    /// Least expected rate, and least measured rate, that are over range.
    range_edges: (f64, f64),
    pub(super) s_bounds: (f64, f64),
    pub(super) d_bounds: (f64, f64),
}

/// What the filter has learnt besides angle and rate, each with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LearntParameters {
    /// Period of undamped torsion, s.
    pub period_s: f64,
    /// Its standard deviation, s.
    pub period_sigma_s: f64,
    /// Damping ratio ζ.
    pub damping_ratio: f64,
    /// Its standard deviation, with the period taken as known.
    pub damping_ratio_sigma: f64,
    /// Bias of the gyro, rad/s.
    pub bias_rad_s: f64,
    /// Its standard deviation, rad/s.
    pub bias_sigma_rad_s: f64,
}

impl AugmentedFilter {
    /// A filter with the given prior and noise.
    ///
    /// # Errors
    /// [`ConfigError`] names the value out of its bound.
    pub fn new(config: &AugmentedConfig) -> Result<Self, ConfigError> {
        config.validate()?;
        let state = config.start.state();
        let unusable = |_| ConfigError {
            name: "start",
            value: f64::INFINITY,
            bound: "small enough that its variances are numbers",
        };
        let state = state.judged().map_err(unusable)?;
        let (s, omega) = (state.mean.s, libm::sqrt(state.mean.s));
        let model = Model {
            r: config.dithered_variance_rad2_s2(),
            q: config.densities(),
            rounding: config.rounding(),
            scale_factor_variance: config.scale_factor_sigma * config.scale_factor_sigma,
            range_edges: config
                .range
                .map_or((f64::INFINITY, f64::INFINITY), |range| range.edges_rad_s()),
            s_bounds: (s / S_SPAN, s * S_SPAN),
            d_bounds: (-D_SPAN.0 * omega, D_SPAN.1 * omega),
        };
        Ok(Self { model, state })
    }

    /// Predicts over `span_s` and takes in a measurement valid at its end: both, or neither.
    ///
    /// # Errors
    /// What predict and update refuse; the filter is then as it was before the call.
    #[inline(always)]
    pub fn step(&mut self, span_s: f64, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        let predicted = self.model.predicted(&self.state, span_s)?;
        let (state, innovation) = self.model.updated(&predicted, rate_rad_s)?;
        self.state = state;
        Ok(innovation)
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
        let innovation = self.model.surprise(&predicted, rate_rad_s)?;
        self.state = predicted;
        Ok(innovation)
    }

    /// Sets measurement variance, rad²/s², and process noise from now on; all finite, R positive.
    pub(crate) fn set_noise(&mut self, r_rad2_s2: f64, q: Densities) {
        self.model.r = r_rad2_s2;
        self.model.q = q;
    }

    /// Makes bias and rate less certain by these variances, rad²/s².
    pub(crate) fn widen(&mut self, bias: f64, rate: f64) -> Result<(), EstimatorError> {
        let bias = in_range(self.state.p.bb + bias)?;
        let rate = in_range(self.state.p.ww + rate)?;
        (self.state.p.bb, self.state.p.ww) = (bias, rate);
        Ok(())
    }

    /// Mean and covariance.
    pub(crate) fn state(&self) -> State {
        self.state
    }

    /// Takes over the belief of another filter of this kind.
    pub(crate) fn set_state(&mut self, state: State) -> Result<(), EstimatorError> {
        self.state = self.model.bounded(state).judged()?;
        Ok(())
    }

    /// Mean of (α, ω, s, d, b): −s·φ in rad/s², φ′ in rad/s, Ω² in 1/s², 2ζΩ in 1/s, the gyro's
    /// bias in rad/s.
    #[must_use]
    pub fn mean(&self) -> [f64; 5] {
        self.state.mean.entries()
    }

    /// Covariance of [`mean`](Self::mean), symmetric. The scale factor is left out of it.
    #[must_use]
    pub fn covariance(&self) -> [[f64; 5]; 5] {
        self.state.p.rows()
    }

    /// Period, damping and bias as now believed.
    #[must_use]
    pub fn learnt(&self) -> LearntParameters {
        let (mean, p) = (&self.state.mean, &self.state.p);
        let omega = libm::sqrt(mean.s);
        let period_s = core::f64::consts::TAU / omega;
        let sigma = |variance: f64| libm::sqrt(variance.max(0.0));
        LearntParameters {
            period_s,
            period_sigma_s: 0.5 * period_s * sigma(p.ss) / mean.s,
            damping_ratio: 0.5 * mean.d / omega,
            damping_ratio_sigma: 0.5 * sigma(p.dd) / omega,
            bias_rad_s: mean.bias,
            bias_sigma_rad_s: sigma(p.bb),
        }
    }
}

impl Model {
    pub(super) fn densities(&self) -> Densities {
        self.q
    }

    #[inline(always)]
    pub(super) fn predicted(&self, from: &State, span_s: f64) -> Result<State, EstimatorError> {
        check_span(span_s)?;
        from.predicted(span_s, self.q).judged_as_predicted()
    }

    #[inline(always)]
    fn updated(
        &self,
        from: &State,
        rate_rad_s: f64,
    ) -> Result<(State, Innovation), EstimatorError> {
        check_measurement(rate_rad_s)?;
        self.absorbed(from, rate_rad_s, &self.expected(from, rate_rad_s))
    }

    /// The same with the mean over the last `span_s`, which the motion hardly bends.
    #[inline(always)]
    fn updated_by_mean(
        &self,
        from: &State,
        span_s: f64,
        rate_rad_s: f64,
    ) -> Result<(State, Innovation), EstimatorError> {
        check_measurement(rate_rad_s)?;
        let plain = from.expect_mean(rate_rad_s, self.r, 0.5 * span_s);
        self.absorbed(from, rate_rad_s, &self.rounded(plain, rate_rad_s))
    }

    /// A measured rate taken in, unless it is over range.
    #[inline(always)]
    fn absorbed(
        &self,
        from: &State,
        rate_rad_s: f64,
        expected: &Expectation,
    ) -> Result<(State, Innovation), EstimatorError> {
        let innovation = self.innovation_of(expected)?;
        if self.is_over_range(rate_rad_s, expected.residual) {
            return Ok((*from, innovation));
        }
        let state = self.bounded(from.updated(expected, expected.r)).judged()?;
        Ok((state, innovation))
    }

    /// The innovation of a measurement that is not to be used.
    pub(super) fn surprise(
        &self,
        at: &State,
        rate_rad_s: f64,
    ) -> Result<Innovation, EstimatorError> {
        check_measurement(rate_rad_s)?;
        self.innovation_of(&self.expected(at, rate_rad_s))
    }

    /// How a measured rate compares with a state.
    #[inline(always)]
    pub(super) fn expected(&self, at: &State, rate_rad_s: f64) -> Expectation {
        self.rounded(at.expect(rate_rad_s, self.r), rate_rad_s)
    }

    /// The same, with the gyro's rounding in it.
    #[inline(always)]
    fn rounded(&self, plain: Expectation, rate_rad_s: f64) -> Expectation {
        match &self.rounding {
            None => plain,
            Some(rounding) => rounding.expected(&plain, rate_rad_s),
        }
    }

    /// The innovation, if a gain can be formed of it and a residual be squared.
    #[inline(always)]
    pub(super) fn innovation_of(&self, e: &Expectation) -> Result<Innovation, EstimatorError> {
        innovation(e.residual, e.spread + e.r)
    }

    #[inline(always)]
    pub(super) fn is_over_range(&self, rate_rad_s: f64, residual_rad_s: f64) -> bool {
        let expected_rad_s = rate_rad_s - residual_rad_s;
        (expected_rad_s.abs() >= self.range_edges.0) | (rate_rad_s.abs() >= self.range_edges.1)
    }

    /// Keeps the oscillator one: a wild measurement could lead Ω² below zero, where there is no
    /// angle to speak of.
    #[inline(always)]
    pub(super) fn bounded(&self, mut state: State) -> State {
        if !self.is_within_bounds(&state) {
            state.mean.s = state.mean.s.clamp(self.s_bounds.0, self.s_bounds.1);
            state.mean.d = state.mean.d.clamp(self.d_bounds.0, self.d_bounds.1);
        }
        state
    }

    #[inline(always)]
    fn is_within_bounds(&self, state: &State) -> bool {
        let within = |x: f64, (low, high): (f64, f64)| low < x && x < high;
        within(state.mean.s, self.s_bounds) & within(state.mean.d, self.d_bounds)
    }

    /// Whether a parameter has been led to the end of its bounds.
    pub(super) fn is_at_a_bound(&self, state: &State) -> bool {
        !self.is_within_bounds(state)
    }

    /// Angle and rate with what is claimed of them.
    ///
    /// φ = −α/s, its covariance by the delta method; a scale factor wrong by ε is wrong by ε·φ and
    /// ε·φ′ at once.
    pub(super) fn belief(&self, state: &State) -> Belief {
        let (mean, p) = (&state.mean, &state.p);
        let inverse = 1.0 / mean.s;
        let angle_rad = -mean.alpha * inverse;
        let rate_rad_s = mean.rate;
        let mut angle2 = (p.aa + angle_rad * (2.0 * p.as_ + angle_rad * p.ss)) * inverse * inverse;
        if self.is_at_a_bound(state) {
            // A parameter that was led to its end has lost its covariance's meaning, and φ = −α/s
            // with it: no more is known than how large it seems.
            angle2 = angle2.max(0.0) + angle_rad * angle_rad;
        }
        let cross = -(p.aw + angle_rad * p.ws) * inverse;
        let scale = self.scale_factor_variance;
        Belief {
            angle_rad,
            rate_rad_s,
            covariance: Covariance {
                // Rounding of the three terms, when the angle is known far better than α and s.
                angle_rad2: angle2.max(0.0) + scale * angle_rad * angle_rad,
                cross_rad2_s: cross + scale * angle_rad * rate_rad_s,
                rate_rad2_s2: p.ww + scale * rate_rad_s * rate_rad_s,
            },
        }
    }
}

#[inline(always)]
fn innovation(residual_rad_s: f64, variance_rad2_s2: f64) -> Result<Innovation, EstimatorError> {
    if !(variance_rad2_s2 > 0.0 && variance_rad2_s2 <= f64::MAX) {
        return Err(EstimatorError::SingularInnovation { variance_rad2_s2 });
    }
    in_range(residual_rad_s * residual_rad_s)?;
    Ok(Innovation { residual_rad_s, variance_rad2_s2 })
}

/// What the filters of threads that yield, and their bank, share with this one.
impl AugmentedFilter {
    /// The same filter with another belief, (α, ω, s, d, b) and their covariance, whose parameters
    /// are kept within bounds.
    pub(crate) fn believing(&self, mean: [f64; 5], rows: &[[f64; 5]; 5]) -> Self {
        let state = self.model.bounded(State::from_rows(mean, rows));
        Self { model: self.model, state }
    }

    /// The innovation, if a gain can be formed of it and a residual be squared.
    #[inline(always)]
    pub(crate) fn innovation(
        &self,
        residual_rad_s: f64,
        spread: f64,
    ) -> Result<Innovation, EstimatorError> {
        innovation(residual_rad_s, spread + self.model.r)
    }

    /// How a measured rate compares with the belief, if a gain can be formed of that.
    #[inline(always)]
    pub(crate) fn judge(&self, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        self.model.innovation_of(&self.model.expected(&self.state, rate_rad_s))
    }

    /// Takes a rate in with `variance_factor` times R: all of it, or nothing.
    #[inline(always)]
    pub(crate) fn absorb(
        &mut self,
        rate_rad_s: f64,
        variance_factor: f64,
    ) -> Result<(), EstimatorError> {
        let expected = self.model.expected(&self.state, rate_rad_s);
        let state = self.state.updated(&expected, variance_factor * expected.r);
        self.state = self.model.bounded(state).judged()?;
        Ok(())
    }

    /// Makes the rate more uncertain.
    pub(crate) fn widen_rate(&mut self, variance: f64) {
        self.state.p.ww += variance;
    }

    /// Whether a gyro of this range would have spoilt the sample, by what was expected of it.
    pub(crate) fn is_over_range(&self, rate_rad_s: f64, residual_rad_s: f64) -> bool {
        self.model.is_over_range(rate_rad_s, residual_rad_s)
    }

    pub(crate) fn is_at_a_bound(&self) -> bool {
        self.model.is_at_a_bound(&self.state)
    }

    /// Variance R of one measured rate, rad²/s².
    pub(crate) fn measurement_variance(&self) -> f64 {
        self.model.r
    }

    pub(crate) fn write(&self, out: &mut Writer<'_>) {
        self.state.write(out);
    }

    pub(crate) fn read(&mut self, bytes: &mut Reader<'_>) -> Result<(), RestoreError> {
        self.state = self.model.bounded(State::read(bytes)?);
        Ok(())
    }

    /// s and d brought within their bounds.
    #[inline(always)]
    pub(crate) fn parameters_within_bounds(&self, s: f64, d: f64) -> (f64, f64) {
        let ((s_low, s_high), (d_low, d_high)) = (self.model.s_bounds, self.model.d_bounds);
        (s.clamp(s_low, s_high), d.clamp(d_low, d_high))
    }
}

impl RateEstimator for AugmentedFilter {
    #[inline(always)]
    fn predict(&mut self, span_s: f64) -> Result<(), EstimatorError> {
        self.state = self.model.predicted(&self.state, span_s)?;
        Ok(())
    }

    /// A rate out of the gyro's range is judged, and then left out.
    #[inline(always)]
    fn update(&mut self, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        let (state, innovation) = self.model.updated(&self.state, rate_rad_s)?;
        self.state = state;
        Ok(innovation)
    }

    fn step(&mut self, span_s: f64, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        self.step(span_s, rate_rad_s)
    }

    /// In one update where the motion hardly bends within the span.
    fn step_mean(&mut self, span_s: f64, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        let predicted = self.model.predicted(&self.state, span_s)?;
        if !is_short(span_s, predicted.mean.s, predicted.mean.d) {
            return step_mean_in_halves(self, span_s, rate_rad_s);
        }
        let (state, innovation) = self.model.updated_by_mean(&predicted, span_s, rate_rad_s)?;
        self.state = state;
        Ok(innovation)
    }

    /// It is judged, and left out.
    fn update_over_range(&mut self, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        self.model.surprise(&self.state, rate_rad_s)
    }

    fn belief(&self) -> Belief {
        self.model.belief(&self.state)
    }

    fn status(&self) -> Status {
        self.report().1
    }

    fn report(&self) -> (Belief, Status) {
        let belief = self.belief();
        let status = if self.model.is_at_a_bound(&self.state) {
            Status::NotObservable
        } else {
            Status::of_claim(belief.covariance.angle_rad2)
        };
        (belief, status)
    }

    fn saved_len(&self) -> usize {
        State::SAVED_LEN
    }

    fn save(&self, out: &mut [u8]) {
        self.state.write(&mut Writer::new(out));
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        let state = State::read(&mut Reader::new(bytes, State::SAVED_LEN)?)?;
        // Hostile bytes may hold any number; those of a running filter are within bounds already.
        self.state = self.model.bounded(state);
        Ok(())
    }
}
