//! The filter with friction in the thread by itself.

use super::config::YieldPrior;
use super::dahl::{D, DahlState, Friction, LINEAR, LN_F, LN_KH, N, RATE, S, U};
use crate::checks::{check_measurement, check_span};
use crate::config::ConfigError;
use crate::state_bytes::{Reader, RestoreError, Writer};
use crate::{
    AugmentedConfig, AugmentedFilter, Belief, EstimatorError, Innovation, RateEstimator, Status,
};

/// Extended Kalman filter of a torsional oscillator on a thread with Dahl's friction: angle, rate,
/// the oscillator's two parameters, the gyro's bias, and friction torque, stiffness and size.
///
/// States are (α, ω, s, d, b, u, ln k_h, ln f), with α = −s·φ as in [`AugmentedFilter`], the
/// friction u and its largest value f = s·ζ_y as angular accelerations, and its stiffness k_h over
/// the moment of inertia: ω′ = α − d·ω − u, u′ = k_h·(ω − |ω|·u/f).
///
/// It finds the yield angle only from near it. From elsewhere it may settle on a wrong one and
/// claim it: [`HysteresisBank`](crate::HysteresisBank) has several.
///
/// # Source
/// Dahl, P. R., *A solid friction model*, 1968.
#[derive(Debug, Clone)]
pub struct DahlFilter {
    /// The linear thread's filter as it started: its model is this one's too.
    linear: AugmentedFilter,
    friction: Friction,
    pub(super) state: DahlState,
}

/// What a filter has learnt of the friction in the thread.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LearntYield {
    /// Yield angle ζ_y, rad: the largest friction torque over the thread's stiffness.
    pub yield_angle_rad: f64,
    /// Its standard deviation, rad.
    pub yield_angle_sigma_rad: f64,
    /// Stiffness of the friction before it yields over that of the thread.
    pub stiffness_ratio: f64,
    /// Its standard deviation.
    pub stiffness_ratio_sigma: f64,
}

impl DahlFilter {
    /// A filter with the prior and noise of the linear thread's filter, and a prior of friction.
    ///
    /// # Errors
    /// [`ConfigError`] names the value out of its bound.
    pub fn new(config: &AugmentedConfig, prior: &YieldPrior) -> Result<Self, ConfigError> {
        prior.validate()?;
        config.validate()?;
        let config = config.without_quantiser();
        let linear = AugmentedFilter::new(&config)?;
        let omega = core::f64::consts::TAU / config.start.period_s;
        let friction = Friction::of(omega, config.process_noise_rad2_s3, config.bias_walk_rad2_s3);
        let state = started(&linear, prior);
        let unusable = |_| ConfigError {
            name: "yield prior",
            value: f64::INFINITY,
            bound: "small enough that its variances are numbers",
        };
        let state = state.judged().map_err(unusable)?;
        Ok(Self { linear, friction, state })
    }

    /// Predicts over `span_s` and takes in a measurement valid at its end: both, or neither.
    ///
    /// # Errors
    /// What predict and update refuse; the filter is then as it was before the call.
    pub fn step(&mut self, span_s: f64, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        let before = self.state;
        self.predict(span_s)?;
        self.update(rate_rad_s).inspect_err(|_| self.state = before)
    }

    /// Mean of (α, ω, s, d, b, u, ln k_h, ln f): −s·φ in rad/s², φ′ in rad/s, Ω² in 1/s², 2ζΩ in
    /// 1/s, the gyro's bias in rad/s, the friction in rad/s², logarithms of its stiffness in 1/s²
    /// and of its largest value in rad/s².
    #[must_use]
    pub fn mean(&self) -> [f64; N] {
        self.state.mean
    }

    /// Covariance of [`mean`](Self::mean), symmetric. The scale factor is left out of it.
    #[must_use]
    pub fn covariance(&self) -> [[f64; N]; N] {
        self.state.p
    }

    /// The friction as now believed, by the delta method.
    #[must_use]
    pub fn learnt_yield(&self) -> LearntYield {
        let (mean, p) = (&self.state.mean, &self.state.p);
        let inverse = 1.0 / mean[S];
        let over_s = |ln: usize| {
            let value = libm::exp(mean[ln]) * inverse;
            let variance = p[ln][ln] + inverse * (p[S][S] * inverse - 2.0 * p[ln][S]);
            (value, value * libm::sqrt(variance.max(0.0)))
        };
        let (yield_angle_rad, yield_angle_sigma_rad) = over_s(LN_F);
        let (stiffness_ratio, stiffness_ratio_sigma) = over_s(LN_KH);
        LearntYield {
            yield_angle_rad,
            yield_angle_sigma_rad,
            stiffness_ratio,
            stiffness_ratio_sigma,
        }
    }

    /// The filter of a linear thread with the same belief, as far as it has the same states.
    pub(super) fn linear(&self) -> AugmentedFilter {
        let (mean, rows) = self.state.leading();
        self.linear.believing(mean, &rows)
    }

    /// How a measured rate compares with the belief, if a gain can be formed of that.
    pub(super) fn judge(&self, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        let expected = self.state.expect(rate_rad_s);
        self.linear.innovation(expected.residual, expected.spread)
    }

    /// Takes a rate in with `variance_factor` times R: all of it, or nothing.
    pub(super) fn absorb(
        &mut self,
        rate_rad_s: f64,
        variance_factor: f64,
    ) -> Result<(), EstimatorError> {
        let r = variance_factor * self.linear.measurement_variance();
        let mut state = self.state.updated(&self.state.expect(rate_rad_s), r);
        self.keep_within_bounds(&mut state);
        self.state = state.judged()?;
        Ok(())
    }

    /// Makes the rate more uncertain.
    pub(super) fn widen_rate(&mut self, variance: f64) {
        self.state.p[RATE][RATE] += variance;
    }

    pub(super) fn is_over_range(&self, rate_rad_s: f64, residual_rad_s: f64) -> bool {
        self.linear.is_over_range(rate_rad_s, residual_rad_s)
    }

    pub(super) fn write(&self, out: &mut Writer<'_>) {
        self.state.write(out);
    }

    /// Takes over a saved state. Hostile bytes may hold any number; those of a running filter are
    /// within bounds already.
    pub(super) fn read(&mut self, bytes: &mut Reader<'_>) -> Result<(), RestoreError> {
        let mut state = DahlState::read(bytes)?;
        self.keep_within_bounds(&mut state);
        self.state = state;
        Ok(())
    }

    fn keep_within_bounds(&self, state: &mut DahlState) {
        let (s, d) = self.linear.parameters_within_bounds(state.mean[S], state.mean[D]);
        (state.mean[S], state.mean[D]) = (s, d);
        state.bound_friction(&self.friction);
    }
}

/// The start belief: the linear filter's, and friction independent of it.
fn started(linear: &AugmentedFilter, prior: &YieldPrior) -> DahlState {
    let mut state = DahlState { mean: [0.0; N], p: [[0.0; N]; N] };
    state.mean[..LINEAR].copy_from_slice(&linear.mean());
    for (row, linear_row) in state.p.iter_mut().zip(linear.covariance()) {
        row[..LINEAR].copy_from_slice(&linear_row);
    }
    let f = state.mean[S] * prior.yield_angle_rad;
    state.mean[LN_F] = libm::log(f);
    state.mean[LN_KH] = libm::log(state.mean[S] * prior.stiffness_ratio);
    let square = |sigma: f64| sigma * sigma;
    state.p[U][U] = square(prior.preload_sigma * f);
    state.p[LN_KH][LN_KH] = square(prior.stiffness_ratio_log_sigma);
    state.p[LN_F][LN_F] = square(prior.yield_angle_log_sigma);
    state
}

impl RateEstimator for DahlFilter {
    /// A span is walked in steps of a twentieth of the stiffest spring's radian at most.
    fn predict(&mut self, span_s: f64) -> Result<(), EstimatorError> {
        check_span(span_s)?;
        self.state = self.state.predicted(span_s, &self.friction).judged()?;
        Ok(())
    }

    /// A rate out of the gyro's range is judged, and then left out.
    fn update(&mut self, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        check_measurement(rate_rad_s)?;
        let innovation = self.judge(rate_rad_s)?;
        if !self.linear.is_over_range(rate_rad_s, innovation.residual_rad_s) {
            self.absorb(rate_rad_s, 1.0)?;
        }
        Ok(innovation)
    }

    /// It is judged, and left out.
    fn update_over_range(&mut self, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        check_measurement(rate_rad_s)?;
        self.judge(rate_rad_s)
    }

    fn belief(&self) -> Belief {
        self.linear().belief()
    }

    fn status(&self) -> Status {
        match self.linear().status() {
            Status::Nominal => {
                Status::ThreadYields { yield_angle_rad: self.learnt_yield().yield_angle_rad }
            }
            other => other,
        }
    }

    fn saved_len(&self) -> usize {
        DahlState::SAVED_LEN
    }

    fn save(&self, out: &mut [u8]) {
        self.write(&mut Writer::new(out));
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        self.read(&mut Reader::new(bytes, DahlState::SAVED_LEN)?)
    }
}
