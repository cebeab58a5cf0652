//! The filter of a swinging body watched by gyros on all three of its axes.

mod gauge;
mod model;
mod past;

use crate::augmented::history::Snapshot;
use crate::augmented::watch::Watch;
use crate::augmented::windows::{CLIP, InnovationTest, Windows};
use crate::checks::{check_span, in_range};
use crate::config::{ConfigError, judge};
use crate::state_bytes::{Reader, RestoreError, Writer};
use crate::swing::config::SwingConfig;
use crate::swing::filter::gaussian::{GYRO, Gaussian, TWIST};
use crate::swing::filter::swinging;
use crate::{Belief, EstimatorError, Innovation, MotionParameters, MotionState, Status};
use gauge::{BLOCK, Gauge};
use model::{Gate, Model, Updated};
use past::{Past, Taken};

/// Swing within which a body may start, rad: where sines are still angles.
const SWING_SIGMA_MAX_RAD: f64 = core::f64::consts::FRAC_PI_4;

/// The standard test of the innovations, its false alarms dealt out over three axes.
const TEST: InnovationTest = InnovationTest {
    false_alarms: InnovationTest::STANDARD.false_alarms / 3.0,
    ..InnovationTest::STANDARD
};
/// How far before the window a re-run starts at least, samples.
const LEAD_MIN: usize = 20;
/// Samples at the start that are hardly gated and not judged: a filter that knows nothing of a
/// wide swing linearises about the wrong one, which looks like a kick.
const START: u64 = 300;
/// Samples at the end of a re-run that are not gated: they may be the kick itself.
const UNGATED: u64 = 3;

/// Extended Kalman filter of the swinging body watched by three gyros along its axes, behind a gate
/// for outliers, a windowed test for kicks with roll-back, and a gauge of the noise.
///
/// The three rates show the swing at once and whole, so that it may start knowing nothing of it.
/// States: two of the tilt, twist, three rates, Ω², 2ζΩ, the scales of A, B and of the swing's
/// decay, and a bias for each gyro. Without the scales a wide swing that is not quite as believed
/// leads it astray.
///
/// Gate and windows are those of [`SwingFilter`](crate::SwingFilter), for each axis, the windows up
/// to 256 samples; a kick is reckoned with in all three rates. Where the innovations are too large
/// for a second, but of no one sign, the measurements are noisier than declared: they are taken in
/// again with as much more R, and R stays so until they are quiet. What it needs, some 100 kB, is
/// allocated once, when it is made.
#[derive(Debug, Clone, PartialEq)]
pub struct ThreeAxisFilter {
    model: Model,
    state: Gaussian,
    windows: Windows,
    gauge: Gauge,
    since_update_s: f64,
    past: Past,
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
            model: Model::new(config),
            state,
            windows: Windows::new(&TEST),
            gauge: Gauge::NEW,
            since_update_s: 0.0,
            past: Past::new(state),
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
        self.state = self.model.predicted(&self.state, span_s)?;
        self.since_update_s = since_update_s;
        Ok(())
    }

    /// Measurement update with the rates about the body's axes, valid at the time of the current
    /// belief, rad/s. The innovations are those of one after the other. One that raises an alarm
    /// may grow variances: that is what a roll-back is for.
    ///
    /// # Errors
    /// [`EstimatorError::BadMeasurement`], [`EstimatorError::SingularInnovation`],
    /// [`EstimatorError::TiltTooLarge`] and [`EstimatorError::Overflow`]; the filter is then as it
    /// was before the call.
    pub fn update(&mut self, rates_rad_s: [f64; 3]) -> Result<[Innovation; 3], EstimatorError> {
        let predicted = self.state;
        self.absorb(&predicted, self.since_update_s, rates_rad_s)
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
        let predicted = self.model.predicted(&self.state, span_s)?;
        let since_update_s = in_range(self.since_update_s + span_s)?;
        self.absorb(&predicted, since_update_s, rates_rad_s)
    }

    /// Takes rates into `predicted`, `span_s` after the last ones.
    fn absorb(
        &mut self,
        predicted: &Gaussian,
        span_s: f64,
        rates_rad_s: [f64; 3],
    ) -> Result<[Innovation; 3], EstimatorError> {
        let factor = self.gauge.factor;
        let Updated { state, innovations, gated } =
            self.model.updated(predicted, rates_rad_s, factor, self.gate())?;
        self.state = state;
        self.since_update_s = 0.0;
        let normalised = innovations.map(|i| i.residual_rad_s / libm::sqrt(i.variance_rad2_s2));
        let residuals_rad_s = innovations.map(|innovation| innovation.residual_rad_s);
        let taken = Taken::new(span_s, rates_rad_s, residuals_rad_s);
        self.past.push(taken, normalised.map(|n| n.clamp(-CLIP, CLIP)), &state);
        let nis = innovations.iter().map(Innovation::nis).sum::<f64>() / 3.0;
        self.watch.used(span_s, (!gated.contains(&true)).then_some(nis));
        self.judge(normalised);
        Ok(innovations)
    }

    /// At the start what is far off shows the swing, unless it is further off than any; and what is
    /// so four times in a row is no outlier.
    fn gate(&self) -> Gate {
        const IN_A_ROW: usize = 4;
        // A millionth for the rounding of the sums.
        let all_clipped = CLIP * IN_A_ROW as f64 - 1e-6;
        let is_far = |axis| self.past.sum_over(axis, IN_A_ROW).abs() > all_clipped;
        match self.past.samples() {
            START.. => Gate::Narrow,
            _ if self.past.reach() >= IN_A_ROW && (0..3).any(is_far) => Gate::Open,
            _ => Gate::Wide,
        }
    }

    /// Looks for kicks and for noise, and repairs what they have done.
    fn judge(&mut self, normalised: [f64; 3]) {
        if self.past.samples() < START {
            return;
        }
        if self.past.samples() == START {
            self.past.reset(&self.state);
        }
        let is_noisy = self.gauge.is_large(normalised);
        if is_noisy {
            self.watch.large_block();
        }
        if (0..3).any(|axis| self.is_beyond(axis)) {
            self.raise_alarm();
        } else if is_noisy {
            self.take_again();
        }
    }

    fn is_beyond(&self, axis: usize) -> bool {
        self.windows.any_beyond(self.past.reach(), |length| self.past.sum_over(axis, length))
    }

    /// Length of the window that is furthest beyond what chance leaves, of all axes.
    fn furthest(&self) -> usize {
        let mut furthest = (0.0, 1);
        for axis in 0..3 {
            let sum_over = |length| self.past.sum_over(axis, length);
            let length = self.windows.furthest(self.past.reach(), sum_over);
            let sigmas = sum_over(length).abs() / libm::sqrt(length as f64);
            if sigmas > furthest.0 {
                furthest = (sigmas, length);
            }
        }
        furthest.1
    }

    /// Goes back, runs again with a kick reckoned with, and starts afresh from there.
    #[cold]
    #[inline(never)]
    fn raise_alarm(&mut self) {
        let length = self.furthest();
        let kick2 = self.past.mean_residuals_rad_s(length).iter().map(|d| d * d).sum::<f64>();
        let floor = TEST.kick_floor_rad_s;
        self.run_again(length + LEAD_MIN.max(length / 2), 4.0 * kick2 + floor * floor);
        self.watch.alarm();
    }

    /// Goes back over a block that was too noisy, and runs it again with the noise that it had.
    #[cold]
    #[inline(never)]
    fn take_again(&mut self) {
        self.run_again(BLOCK as usize, 0.0);
    }

    /// The state now, had the last `back` samples been taken in with R as it is now and a kick of
    /// so much variance been reckoned with. Where the model refuses that, the body has been thrown
    /// about, and nothing is known of its twist within half a turn.
    fn run_again(&mut self, back: usize, kick_rad2_s2: f64) {
        match self.rerun(back as u64, kick_rad2_s2) {
            Ok(state) => self.state = state,
            Err(_) => self.lose(kick_rad2_s2),
        }
        self.past.reset(&self.state);
    }

    fn lose(&mut self, kick_rad2_s2: f64) {
        const HALF_TURN_RAD: f64 = core::f64::consts::PI;
        let mut lost = self.state;
        lost.p[TWIST][TWIST] += HALF_TURN_RAD * HALF_TURN_RAD;
        lost.inflate_rates(kick_rad2_s2);
        // A kick that leaves the range of floating point leaves the belief.
        self.state = lost.judged().unwrap_or(self.state);
    }

    fn rerun(&self, back: u64, kick_rad2_s2: f64) -> Result<Gaussian, EstimatorError> {
        let (mut state, count) = self.past.way_back(back);
        let inflation = in_range(kick_rad2_s2 / count as f64)?;
        for (k, taken) in (1..=count).zip(self.past.latest(count)) {
            state = self.model.predicted(&state, taken.span_s)?;
            state.inflate_rates(inflation);
            let is_kick = kick_rad2_s2 > 0.0 && k + UNGATED > count;
            let gate = if is_kick { Gate::Open } else { Gate::Narrow };
            state = self.model.updated(&state, taken.rates_rad_s, self.gauge.factor, gate)?.state;
        }
        Ok(state)
    }

    /// The twist of the string and its rate.
    #[must_use]
    pub fn belief(&self) -> Belief {
        self.model.belief(&self.state)
    }

    /// What it would believe in `span_s` seconds if it heard nothing more.
    ///
    /// # Errors
    /// What [`predict`](Self::predict) refuses.
    pub fn belief_ahead(&self, span_s: f64) -> Result<Belief, EstimatorError> {
        check_span(span_s)?;
        Ok(self.model.belief(&self.model.predicted(&self.state, span_s)?))
    }

    /// Alarms so far: kicks, as far as it can tell.
    #[must_use]
    pub fn alarms(&self) -> u64 {
        self.watch.alarms()
    }

    /// What the declared variance R is multiplied by now, at least 1: more where the measurements
    /// have been noisier than declared for a second.
    #[must_use]
    pub fn noise_factor(&self) -> f64 {
        self.gauge.factor
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
        self.model.motion.amplitude_rad(&self.state.motion())
    }

    /// How far the belief may be trusted; swinging from 0.3° on, when nothing worse is to be said.
    #[must_use]
    pub fn status(&self) -> Status {
        let period_s = core::f64::consts::TAU / libm::sqrt(self.state.parameters().stiffness_1_s2);
        let at_bound = self.model.is_at_a_bound(&self.state);
        let claim = self.belief().covariance.angle_rad2;
        swinging(self.watch.status(claim, period_s, at_bound), self.amplitude_rad())
    }

    /// How many bytes [`save`](Self::save) writes.
    #[must_use]
    pub fn saved_len(&self) -> usize {
        Gaussian::SAVED_LEN + 8 + Watch::SAVED_LEN + Gauge::SAVED_LEN + Past::SAVED_LEN
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
        self.gauge.write(&mut out);
        self.past.write(&mut out);
    }

    /// Takes over a state written by [`save`](Self::save) of an equally configured filter.
    ///
    /// # Errors
    /// [`RestoreError`] when the bytes cannot be such a state; the filter is then unchanged.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        let mut bytes = Reader::new(bytes, self.saved_len())?;
        let state = self.model.bounded(Gaussian::read(&mut bytes)?);
        let since_update_s = bytes.finite("since_update_s")?;
        let watch = Watch::read(&mut bytes)?;
        let gauge = Gauge::read(&mut bytes)?;
        self.past = Past::read(&mut bytes, state)?;
        (self.watch, self.gauge) = (watch, gauge);
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
