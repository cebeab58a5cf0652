//! The estimator that watches a live rig, and switches between the filters as the body demands.

use super::config::LiveConfig;
use super::doubt::Doubt;
use super::eye::{Sight, SwingEye};
use super::fallback::SwingFallback;
use super::handover::ready_of;
use super::pursuit::{Pursuit, window_s};
use super::tape::{Anchors, Tape};
use crate::checks::{check_measurement, check_span, in_range};
use crate::config::ConfigError;
use crate::hysteresis::HysteresisBank;
use crate::swing::{SwingConfig, SwingFilter};
use crate::{
    AugmentedConfig, Belief, EstimatorError, Innovation, InnovationTest, RateEstimator,
    RestoreError, Status, TestedFilter,
};
use alloc::boxed::Box;

/// How long a clipped gyro may stay silent, s.
const OVER_RANGE_MAX_S: f64 = 1.0;
/// What the tape holds beyond the last window of a fit, s: the lag of the fit, and windows that
/// were given up.
const TAPE_SLACK_S: f64 = 360.0;

/// What is wrong with the gyro as it was declared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum LiveWarning {
    /// The raw noise is below half a count. The filter of pure torsion reckons with the steps;
    /// those of a swing or of a thread that yields take R tenfold.
    QuantiserUnderDithered,
    /// A body is declared, but the gyro's axis is not known to a third of its misalignment: a
    /// swing may pass unseen, and when it is seen, or pure torsion does not explain the rates,
    /// there is no angle.
    AxisNotCalibrated,
}

impl core::fmt::Display for LiveWarning {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::QuantiserUnderDithered => {
                "quantiser under-dithered: noise below half a count; in a swing, or when the \
                 thread yields, its variance is taken tenfold"
            }
            Self::AxisNotCalibrated => {
                "the gyro's axis is not calibrated: in a swing there will be no angle"
            }
        })
    }
}

/// All that does not evolve.
#[derive(Debug, Clone, Copy)]
pub(super) struct Setup {
    pub(super) torsion: AugmentedConfig,
    pub(super) swing: Option<SwingConfig>,
    pub(super) swing_max_rad: f64,
    test: InnovationTest,
    /// Sample period, s, and steps of work in each.
    pub(super) pace: (f64, u32),
    /// What a reading is multiplied by to be the rate about the body's axis, where the swing is
    /// not reckoned with otherwise.
    pub(super) gain: f64,
    /// Least measured rate that is over range, rad/s.
    edge_rad_s: f64,
    warnings: [Option<LiveWarning>; 2],
}

impl Setup {
    /// What a swing may need, `sight` of it given.
    pub(super) fn new_spares(&self, sight: Sight) -> Result<Spares, ConfigError> {
        let new = |swing| SwingFilter::new(swing, &self.test, &ready_of(swing)).map(Box::new);
        let filter = self.swing.as_ref().map(new).transpose()?;
        // Where the swing has no size there is nothing to fit.
        let fitted = self.swing.as_ref().filter(|_| sight == Sight::Sharp);
        let pursuit = fitted.and_then(|swing| Pursuit::new(swing, self.pace).ok()).map(Box::new);
        Ok(Spares { filter, pursuit })
    }
}

/// What a swing needs, while nobody uses it: neither is ever made anew.
#[derive(Debug, Clone)]
pub(super) struct Spares {
    /// The filter of the swinging body; none without a body.
    pub(super) filter: Option<Box<SwingFilter>>,
    /// Fit and catching up; none where no fit has a meaning.
    pub(super) pursuit: Option<Box<Pursuit>>,
}

/// Who speaks.
#[derive(Debug, Clone)]
pub(super) enum Phase {
    /// The filter of pure torsion, or the bank.
    Torsion,
    /// The fallback, and a fit is under way.
    Fitting(Box<Pursuit>),
    /// The filter of the swinging body.
    Swinging(Box<SwingFilter>),
    /// The fallback, and nothing is to be hoped for while it swings.
    Unseen,
}

/// The estimator for a live rig: the tested filter of pure torsion, and in its place whatever the
/// body demands, each with a [`Status`] that says so in plain words.
///
/// It swings: a bound from [`SwingFallback`] while a fit is under way, then the filter of the
/// swinging body. The thread yields: the [`HysteresisBank`]. It has come to rest: back again.
/// While nothing of that happens the estimate is [`TestedFilter`]'s, bit for bit. Where the gyro's
/// axis may hide the swing of a declared body, that holds once pure torsion has explained the rates
/// for ten seconds and as long as it does: else the bound speaks, and nothing is claimed beyond it.
///
/// A gyro that is known to sit askew by ε sees cos ε of the rate: its readings are divided by that
/// for every filter that does not have the axis in its model, and R, bias and range are meant of
/// what was measured.
///
/// The work of a fit is dealt out over the updates, a fixed number of steps in each, so that no
/// update takes long and the same record gives the same estimate whatever the machine.
///
/// # Memory
/// A few megabytes: the samples of the last seven minutes or more, twice where a fit may need them.
/// All of it is allocated when the estimator is made; after that nothing but
/// [`restore`](RateEstimator::restore) allocates. A running fit is saved as its samples: to restore
/// it is to do its work again, some seconds at most.
#[derive(Debug, Clone)]
pub struct LiveEstimator {
    pub(super) setup: Setup,
    pub(super) torsion: TestedFilter,
    pub(super) bank: HysteresisBank,
    pub(super) fallback: SwingFallback,
    pub(super) eye: SwingEye,
    pub(super) tape: Tape,
    pub(super) anchors: Anchors,
    pub(super) phase: Phase,
    pub(super) clock: Clock,
    pub(super) doubt: Doubt,
    pub(super) spares: Spares,
    pub(super) swing_len: usize,
}

/// Times that the switch goes by, s.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Clock {
    /// Since the last measurement.
    pub(super) since_update_s: f64,
    /// For which the gyro has been over range.
    pub(super) over_range_s: f64,
    /// Since the filter of pure torsion was last given a measurement.
    pub(super) away_s: f64,
    /// For which the thread has seemed to yield.
    pub(super) yields_s: f64,
    pub(super) yields: bool,
    /// Whether pure torsion is doubted: its filters run on, and the fallback speaks.
    pub(super) doubts: bool,
    /// For which the filter of pure torsion has run since it began or began anew.
    pub(super) torsion_s: f64,
    /// Alarms of the filter of pure torsion when it was first doubted.
    pub(super) answered: u64,
    /// For which nothing has spoken against it while it is doubted, and the lead of a thread that
    /// yields when that began.
    pub(super) quiet_s: f64,
    pub(super) lead: f64,
}

impl LiveEstimator {
    /// An estimator with everything that it may need.
    ///
    /// # Errors
    /// [`ConfigError`] names the value out of its bound.
    pub fn new(config: &LiveConfig) -> Result<Self, ConfigError> {
        config.validate()?;
        let (torsion, swing) = (config.torsion(), config.swing());
        let filter = TestedFilter::new(&torsion, &config.test)?;
        let r_rad2_s2 = config.measured().measurement_variance_rad2_s2;
        let eye = SwingEye::new(swing.as_ref(), r_rad2_s2, config.sample_period_s)?;
        let tape_s = window_s(torsion.start.period_s) + TAPE_SLACK_S;
        let samples = libm::ceil(tape_s / config.sample_period_s).clamp(1.0, 1e8);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let tape = Tape::new(samples as usize);
        let under_dithered = config.torsion.quantiser.is_some_and(|q| q.is_under_dithered());
        let blurred = swing.is_some() && eye.sight() != Sight::Sharp;
        let setup = Setup {
            torsion,
            swing,
            swing_max_rad: config.swing_max_rad,
            test: config.test,
            pace: (config.sample_period_s, config.work_per_sample),
            gain: config.gain(),
            edge_rad_s: config.torsion.range.map_or(f64::INFINITY, |range| range.edges_rad_s().1),
            warnings: [
                under_dithered.then_some(LiveWarning::QuantiserUnderDithered),
                blurred.then_some(LiveWarning::AxisNotCalibrated),
            ],
        };
        let spares = setup.new_spares(eye.sight())?;
        Ok(Self {
            setup,
            doubt: Doubt::default(),
            swing_len: spares.filter.as_ref().map_or(0, |filter| filter.saved_len()),
            spares,
            anchors: Anchors::new(0, filter.filter().state()),
            torsion: filter,
            bank: HysteresisBank::new(&torsion)?,
            fallback: SwingFallback::new(&torsion, config.scale())?,
            eye,
            tape,
            phase: Phase::Torsion,
            clock: Clock::default(),
        })
    }

    /// What is wrong with the gyro as it was declared.
    pub fn warnings(&self) -> impl Iterator<Item = LiveWarning> + '_ {
        self.setup.warnings.iter().flatten().copied()
    }

    /// The filter of pure torsion. While the body swings it stands still.
    #[must_use]
    pub fn torsion(&self) -> &TestedFilter {
        &self.torsion
    }

    /// Swing in the last window of 2.56 s, rad; none where it cannot be measured.
    #[must_use]
    pub fn swing_rad(&self) -> Option<f64> {
        self.eye.swing_rad().map(|(last_rad, _)| last_rad)
    }
}

impl LiveEstimator {
    /// One call on whoever speaks, and on whoever listens while it speaks.
    fn ask(&mut self, call: Call) -> Result<Option<Innovation>, EstimatorError> {
        let gain = self.setup.gain;
        match &mut self.phase {
            Phase::Torsion => {
                let call = call.scaled(gain)?;
                let answer = call.on(&mut self.torsion)?;
                // The bank goes on with the members that are left; without any it stands still. So
                // does the fallback with what it refuses.
                let of_bank = call.on(&mut self.bank);
                if self.clock.doubts {
                    return Ok(call.on(&mut self.fallback).unwrap_or(answer));
                }
                Ok(if self.clock.yields { of_bank.unwrap_or(answer) } else { answer })
            }
            Phase::Fitting(_) | Phase::Unseen => call.scaled(gain)?.on(&mut self.fallback),
            Phase::Swinging(filter) => match call.on(filter.as_mut()) {
                Err(EstimatorError::TiltTooLarge | EstimatorError::SpanTooLong { .. }) => {
                    self.ask_fallback(call.scaled(gain)?)
                }
                answer => {
                    if let Ok(Some(innovation)) = &answer {
                        self.doubt.push(innovation);
                    }
                    answer
                }
            },
        }
    }

    /// The filter of the swinging body cannot follow the call; the fallback can.
    #[cold]
    fn ask_fallback(&mut self, call: Call) -> Result<Option<Innovation>, EstimatorError> {
        let Phase::Swinging(filter) = core::mem::replace(&mut self.phase, Phase::Unseen) else {
            return Ok(None);
        };
        let before = self.fallback.clone();
        self.fall_back(filter);
        let answer = call.on(&mut self.fallback);
        if answer.is_err() {
            self.fallback = before;
            self.phase = self.spares.filter.take().map_or(Phase::Unseen, Phase::Swinging);
        } else {
            self.phase = self.pursue_afresh();
        }
        answer
    }
}

/// A call on an estimator.
#[derive(Debug, Clone, Copy)]
enum Call {
    Predict(f64),
    Update(f64),
    UpdateOverRange(f64),
}

impl Call {
    /// The same with a reading multiplied by `gain`.
    #[inline(always)]
    fn scaled(self, gain: f64) -> Result<Self, EstimatorError> {
        Ok(match self {
            Self::Predict(span_s) => Self::Predict(span_s),
            Self::Update(rate_rad_s) => Self::Update(in_range(gain * rate_rad_s)?),
            Self::UpdateOverRange(rate_rad_s) => {
                Self::UpdateOverRange(in_range(gain * rate_rad_s)?)
            }
        })
    }

    #[inline(always)]
    fn on(self, estimator: &mut impl RateEstimator) -> Result<Option<Innovation>, EstimatorError> {
        match self {
            Self::Predict(span_s) => estimator.predict(span_s).map(|()| None),
            Self::Update(rate_rad_s) => estimator.update(rate_rad_s).map(Some),
            Self::UpdateOverRange(rate_rad_s) => estimator.update_over_range(rate_rad_s).map(Some),
        }
    }
}

/// Updates may grow variances: what a roll-back, a swing or a yielding thread demands.
impl RateEstimator for LiveEstimator {
    fn predict(&mut self, span_s: f64) -> Result<(), EstimatorError> {
        check_span(span_s)?;
        let since_update_s = in_range(self.clock.since_update_s + span_s)?;
        if span_s > 0.0 {
            self.ask(Call::Predict(span_s))?;
            self.clock.since_update_s = since_update_s;
        }
        Ok(())
    }

    /// The innovation is that of the filter that spoke before.
    fn update(&mut self, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        check_measurement(rate_rad_s)?;
        let innovation = self.ask(Call::Update(rate_rad_s))?;
        let is_over = rate_rad_s.abs() >= self.setup.edge_rad_s;
        self.note((!is_over).then_some(rate_rad_s));
        innovation.ok_or(EstimatorError::Overflow)
    }

    fn update_over_range(&mut self, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        check_measurement(rate_rad_s)?;
        let innovation = self.ask(Call::UpdateOverRange(rate_rad_s))?;
        self.note(None);
        innovation.ok_or(EstimatorError::Overflow)
    }

    fn belief(&self) -> Belief {
        match &self.phase {
            Phase::Torsion if self.clock.doubts => self.fallback.belief(),
            Phase::Torsion if self.clock.yields => self.bank.belief(),
            Phase::Torsion => self.torsion.belief(),
            Phase::Fitting(_) | Phase::Unseen => self.fallback.belief(),
            Phase::Swinging(filter) => filter.belief(),
        }
    }

    fn status(&self) -> Status {
        match &self.phase {
            Phase::Torsion if self.clock.doubts => Status::NotObservable,
            Phase::Torsion if self.clock.yields => match self.bank.status() {
                Status::NotObservable => Status::NotObservable,
                _ => self.bank.leading_yield().map_or(Status::ModelDoubtful, |learnt| {
                    Status::ThreadYields { yield_angle_rad: learnt.yield_angle_rad }
                }),
            },
            Phase::Torsion => match self.torsion.status() {
                Status::Nominal if self.is_thread_suspect() => Status::ModelDoubtful,
                status => status,
            },
            Phase::Unseen => Status::NotObservable,
            _ if self.clock.over_range_s > OVER_RANGE_MAX_S => Status::NotObservable,
            Phase::Fitting(pursuit) => {
                let (collected_s, needed_s) = pursuit.progress_s();
                Status::Fitting { collected_s, needed_s }
            }
            Phase::Swinging(filter) => filter.status(),
        }
    }

    fn saved_len(&self) -> usize {
        self.whole_len()
    }

    fn save(&self, out: &mut [u8]) {
        self.write_all(out);
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        let need = self.whole_len();
        if bytes.len() != need {
            return Err(RestoreError::Length { need, got: bytes.len() });
        }
        self.read_all(bytes)
    }
}
