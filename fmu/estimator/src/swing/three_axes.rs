//! The filter of a swinging body watched by gyros on all three of its axes.

use crate::augmented::history::Snapshot;
use crate::augmented::watch::Watch;
use crate::checks::{check_measurement, check_span, in_range};
use crate::config::{ConfigError, judge};
use crate::state_bytes::{Reader, RestoreError, Writer};
use crate::swing::config::SwingConfig;
use crate::swing::filter::gaussian::{GYRO, Gaussian, RATES, Row, Walks};
use crate::swing::filter::model::{Bounds, belief, bounded, bounds, innovation, is_at_a_bound};
use crate::swing::filter::swinging;
use crate::swing::motion::SwingMotion;
use crate::{Belief, EstimatorError, Innovation, MotionParameters, MotionState, Status};

/// Swing within which a body may start, rad: where sines are still angles.
const SWING_SIGMA_MAX_RAD: f64 = core::f64::consts::FRAC_PI_4;

/// Extended Kalman filter of the swinging body watched by three gyros along its axes.
///
/// The three rates show the swing at once and whole, so that it may start knowing nothing of it.
/// States: two of the tilt, twist, three rates, Ω², 2ζΩ, the scales of A, B and of the swing's
/// decay, and a bias for each gyro. Without the scales a wide swing that is not quite as believed
/// leads it astray.
///
/// It takes the model for granted: a kick or an outlier spoils it. It allocates nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThreeAxisFilter {
    motion: SwingMotion,
    r: f64,
    walks: Walks,
    bounds: Bounds,
    scale_factor_variance: f64,
    state: Gaussian,
    since_update_s: f64,
    watch: Watch,
}

impl ThreeAxisFilter {
    /// A filter of the given body and noise, of a body that swings by some `swing_sigma_rad`; too
    /// large a value costs a few seconds, too small a one may cost the track. The gyros' axes are
    /// the body's; `config.axis` and `config.range` are not looked at.
    ///
    /// # Errors
    /// [`ConfigError`] names the value out of its bound.
    pub fn new(config: &SwingConfig, swing_sigma_rad: f64) -> Result<Self, ConfigError> {
        config.validate()?;
        let ok = swing_sigma_rad > 0.0 && swing_sigma_rad <= SWING_SIGMA_MAX_RAD;
        judge("swing_sigma_rad", swing_sigma_rad, ok, "greater than 0 and at most 45 degrees")?;
        let state = started(config, swing_sigma_rad).judged().map_err(|_| ConfigError {
            name: "start",
            value: f64::INFINITY,
            bound: "small enough that its variances are numbers",
        })?;
        Ok(Self {
            motion: SwingMotion::new(&config.body),
            r: config.measurement_variance_rad2_s2,
            walks: Walks::new(config, [config.bias_walk_rad2_s3; 3]),
            bounds: bounds(config, [f64::MAX; 3]),
            scale_factor_variance: config.scale_factor_sigma * config.scale_factor_sigma,
            state,
            since_update_s: 0.0,
            watch: Watch::default(),
        })
    }

    /// Time update: carries the belief `span_s` seconds forward.
    ///
    /// # Errors
    /// [`EstimatorError::BadSpan`], [`EstimatorError::SpanTooLong`],
    /// [`EstimatorError::TiltTooLarge`] and [`EstimatorError::Overflow`]; the filter is then as it
    /// was before the call.
    pub fn predict(&mut self, span_s: f64) -> Result<(), EstimatorError> {
        check_span(span_s)?;
        let since_update_s = in_range(self.since_update_s + span_s)?;
        self.state = self.state.predicted(&self.motion, &self.walks, span_s)?;
        self.since_update_s = since_update_s;
        Ok(())
    }

    /// Measurement update with the rates about the body's axes, valid at the time of the current
    /// belief, rad/s. The innovations are those of one after the other.
    ///
    /// # Errors
    /// [`EstimatorError::BadMeasurement`], [`EstimatorError::SingularInnovation`],
    /// [`EstimatorError::TiltTooLarge`] and [`EstimatorError::Overflow`]; the filter is then as it
    /// was before the call.
    pub fn update(&mut self, rates_rad_s: [f64; 3]) -> Result<[Innovation; 3], EstimatorError> {
        let (state, innovations) = self.updated(&self.state, rates_rad_s)?;
        self.take_over(state, self.since_update_s, &innovations);
        Ok(innovations)
    }

    /// Predicts over `span_s` and takes in rates valid at its end: both, or neither.
    ///
    /// # Errors
    /// What predict and update refuse; the filter is then as it was before the call.
    pub fn step(
        &mut self,
        span_s: f64,
        rates_rad_s: [f64; 3],
    ) -> Result<[Innovation; 3], EstimatorError> {
        let predicted = self.state.predicted(&self.motion, &self.walks, span_s)?;
        let since_update_s = in_range(self.since_update_s + span_s)?;
        let (state, innovations) = self.updated(&predicted, rates_rad_s)?;
        self.take_over(state, since_update_s, &innovations);
        Ok(innovations)
    }

    fn updated(
        &self,
        from: &Gaussian,
        rates_rad_s: [f64; 3],
    ) -> Result<(Gaussian, [Innovation; 3]), EstimatorError> {
        for rate_rad_s in rates_rad_s {
            check_measurement(rate_rad_s)?;
        }
        let mut state = *from;
        let none = Innovation { residual_rad_s: 0.0, variance_rad2_s2: 1.0 };
        let mut innovations = [none; 3];
        for (axis, rate_rad_s) in rates_rad_s.into_iter().enumerate() {
            let mut row = Row { by_omega: [0.0; 3], by_gyro: [0.0; 3] };
            (row.by_omega[axis], row.by_gyro[axis]) = (1.0, 1.0);
            let expected_rad_s = state.mean[RATES + axis] + state.mean[GYRO + axis];
            let expected = state.expect(rate_rad_s - expected_rad_s, &row);
            innovations[axis] = innovation(expected.residual, expected.spread + self.r)?;
            state = state.updated(&expected, self.r);
        }
        Ok((bounded(state, &self.bounds).judged()?, innovations))
    }

    fn take_over(&mut self, state: Gaussian, span_s: f64, innovations: &[Innovation; 3]) {
        self.state = state;
        let nis: f64 = innovations.iter().map(Innovation::nis).sum();
        self.watch.used(span_s, Some(nis / 3.0));
        self.since_update_s = 0.0;
    }

    /// The twist of the string and its rate.
    #[must_use]
    pub fn belief(&self) -> Belief {
        belief(&self.state, self.scale_factor_variance)
    }

    /// Attitude and rates as now believed.
    #[must_use]
    pub fn motion(&self) -> MotionState {
        self.state.motion()
    }

    /// What has been learnt of the motion.
    #[must_use]
    pub fn parameters(&self) -> MotionParameters {
        self.state.parameters()
    }

    /// Bias of each gyro as now believed, rad/s.
    #[must_use]
    pub fn biases_rad_s(&self) -> [f64; 3] {
        core::array::from_fn(|axis| self.state.mean[GYRO + axis])
    }

    /// Largest angle of the swing as now believed, rad.
    #[must_use]
    pub fn amplitude_rad(&self) -> f64 {
        self.motion.amplitude_rad(&self.state.motion())
    }

    /// How far the belief may be trusted; swinging from 0.3° on, when nothing worse is to be said.
    #[must_use]
    pub fn status(&self) -> Status {
        let period_s = core::f64::consts::TAU / libm::sqrt(self.state.parameters().stiffness_1_s2);
        let at_bound = is_at_a_bound(&self.state, &self.bounds);
        let claim = self.belief().covariance.angle_rad2;
        swinging(self.watch.status(claim, period_s, at_bound), self.amplitude_rad())
    }

    /// How many bytes [`save`](Self::save) writes.
    #[must_use]
    pub fn saved_len(&self) -> usize {
        Gaussian::SAVED_LEN + 8 + Watch::SAVED_LEN
    }

    /// Writes the state, parameters of the configuration excluded, into the first
    /// [`saved_len`](Self::saved_len) bytes.
    ///
    /// # Panics
    /// When `out` is shorter than [`saved_len`](Self::saved_len).
    pub fn save(&self, out: &mut [u8]) {
        let mut out = Writer::new(out);
        self.state.write(&mut out);
        out.f64(self.since_update_s);
        self.watch.write(&mut out);
    }

    /// Takes over a state written by [`save`](Self::save) of an equally configured filter.
    ///
    /// # Errors
    /// [`RestoreError`] when the bytes cannot be such a state; the filter is then unchanged.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        let mut bytes = Reader::new(bytes, self.saved_len())?;
        let state = bounded(Gaussian::read(&mut bytes)?, &self.bounds);
        let since_update_s = bytes.finite("since_update_s")?;
        self.watch = Watch::read(&mut bytes)?;
        self.state = state;
        self.since_update_s = since_update_s;
        Ok(())
    }
}

/// The belief at the start: hanging straight and at rest, give or take the swing.
fn started(config: &SwingConfig, swing_sigma_rad: f64) -> Gaussian {
    let start = &config.start;
    let omega = core::f64::consts::TAU / start.period_s;
    let stiffness = omega * omega;
    let bias = start.bias_rad_s;
    let swing_rate_sigma = swing_sigma_rad * config.body.swing_frequency_rad_s();
    let rate_sigma = libm::hypot(start.rate_sigma_rad_s, swing_sigma_rad * swing_rate_sigma);
    let states = [
        (0.0, swing_sigma_rad),
        (0.0, swing_sigma_rad),
        (start.angle_rad, start.angle_sigma_rad),
        (0.0, swing_rate_sigma),
        (0.0, swing_rate_sigma),
        // The rate about the body's axis is that of the twist, less what the swing winds up.
        (start.rate_rad_s, rate_sigma),
        (stiffness, 2.0 * stiffness * start.period_sigma_s / start.period_s),
        (2.0 * start.damping_ratio * omega, 2.0 * omega * start.damping_ratio_sigma),
        (1.0, config.inertia_sigma),
        (1.0, config.inertia_sigma),
        (1.0, config.swing_damping_sigma),
        (bias, start.bias_sigma_rad_s),
        (bias, start.bias_sigma_rad_s),
        (bias, start.bias_sigma_rad_s),
    ];
    Gaussian::diagonal(states.map(|state| state.0), states.map(|state| state.1))
}
