//! The two-state Kalman filter of the 2008 papers, with their formulas corrected.

use crate::checks::{check_measurement, check_span, in_range};
use crate::config::ConfigError;
use crate::passage::Passage;
use crate::refinement::{Accumulator, Surprise};
use crate::state_bytes::{Reader, RestoreError, Writer};
use crate::{
    Belief, Covariance, EstimatorError, FilterConfig, Innovation, Motion, PermanentRotation,
    RateEstimator, Reading, Refinement, TorsionalOscillation,
};

/// Kalman filter of (angle, rate) under an assumed [`Motion`], fed with measured rates.
///
/// Generic over the motion, so that both filters of the papers are one algorithm and cannot drift
/// apart.
#[derive(Debug, Clone)]
pub struct Filter<M> {
    motion: M,
    measurement_variance_rad2_s2: f64,
    process_noise_rad2_s3: f64,
    refinement: Refinement,
    state: State,
    /// Passages of the last two lengths of a span: spans repeat, sines are dear, and a period that
    /// is no whole number of nanoseconds is told in two lengths by turns. Not part of the state,
    /// for they follow from the span.
    cached: [(f64, Passage); 2],
    /// Whether the second of them is that of the last span.
    is_second: bool,
}

/// All that evolves.
#[derive(Debug, Clone, Copy, PartialEq)]
struct State {
    carried: Carried,
    /// Plain integral of the measured rate, which readings M4 and M6 compare the angle with.
    integral_rad: f64,
    surprises: Accumulator,
    /// What reading M1 adds ahead of every update; zero in the others.
    added: Covariance,
}

impl Filter<PermanentRotation> {
    /// The filter that assumes a constant rate.
    ///
    /// # Errors
    /// [`ConfigError`] names the value out of its bound.
    pub fn permanent_rotation(config: FilterConfig) -> Result<Self, ConfigError> {
        Self::new(config, PermanentRotation)
    }
}

impl Filter<TorsionalOscillation> {
    /// The filter that assumes undamped torsion with period `period_s`.
    ///
    /// # Errors
    /// [`ConfigError`] names the value out of its bound.
    pub fn torsional_oscillation(config: FilterConfig, period_s: f64) -> Result<Self, ConfigError> {
        Self::new(config, TorsionalOscillation::with_period(period_s)?)
    }
}

impl<M: Motion> Filter<M> {
    /// A filter that assumes `motion`.
    ///
    /// # Errors
    /// [`ConfigError`] names the value out of its bound.
    pub fn new(config: FilterConfig, motion: M) -> Result<Self, ConfigError> {
        config.validate()?;
        let passage = Passage::new(&motion.transition(0.0), config.process_noise_rad2_s3);
        let cached = (0.0, passage);
        Ok(Self {
            motion,
            measurement_variance_rad2_s2: config.measurement_variance_rad2_s2,
            process_noise_rad2_s3: config.process_noise_rad2_s3,
            refinement: config.refinement,
            state: State {
                carried: Carried {
                    belief: Belief {
                        angle_rad: config.angle_start_rad,
                        rate_rad_s: config.rate_start_rad_s,
                        covariance: config.covariance_start(),
                    },
                    since_update_s: 0.0,
                },
                integral_rad: config.angle_start_rad,
                surprises: Accumulator::default(),
                added: Covariance::ZERO,
            },
            cached: [cached; 2],
            is_second: false,
        })
    }

    /// The papers' N.
    pub(crate) fn refinement_samples(&self) -> u32 {
        self.refinement.samples
    }

    /// R, rad²/s².
    pub(crate) fn r(&self) -> f64 {
        self.measurement_variance_rad2_s2
    }

    /// What a span does to the belief.
    pub(crate) fn passage_over(&self, span_s: f64) -> Passage {
        Passage::new(&self.motion.transition(span_s), self.process_noise_rad2_s3)
    }

    pub(crate) fn unrefined(&self) -> Unrefined {
        let Carried { belief, since_update_s } = self.state.carried;
        Unrefined { belief, since_update_s, integral_rad: self.state.integral_rad }
    }

    pub(crate) fn set_unrefined(&mut self, state: &Unrefined) {
        let Unrefined { belief, since_update_s, integral_rad } = *state;
        self.state.carried = Carried { belief, since_update_s };
        self.state.integral_rad = integral_rad;
    }

    /// The passage over `span_s`, if that can be predicted over.
    #[inline(always)]
    fn passage(&mut self, span_s: f64) -> Result<&Passage, EstimatorError> {
        // Bit equality: the cache must give exactly what a fresh computation would.
        let is_cached = |cached: &(f64, Passage)| cached.0.to_bits() == span_s.to_bits();
        if !is_cached(&self.cached[usize::from(self.is_second)]) {
            self.is_second = !self.is_second;
            if !is_cached(&self.cached[usize::from(self.is_second)]) {
                self.cache_passage(span_s)?;
            }
        }
        Ok(&self.cached[usize::from(self.is_second)].1)
    }

    /// Kept out of line, so that what happens in every step is short enough to be inlined.
    #[cold]
    fn cache_passage(&mut self, span_s: f64) -> Result<(), EstimatorError> {
        check_span(span_s)?;
        self.cached[usize::from(self.is_second)] = (span_s, self.passage_over(span_s));
        Ok(())
    }

    /// Predicts over `span_s` and takes in a measurement valid at its end: both, or neither.
    ///
    /// Gives the very bits that [`predict`](RateEstimator::predict) and then
    /// [`update`](RateEstimator::update) would, and spares callers whose step must be all or
    /// nothing a copy to go back to.
    ///
    /// # Errors
    /// What predict and update refuse; the filter is then as it was before the call.
    #[inline(always)]
    pub fn step(&mut self, span_s: f64, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        let predicted = self.predicted(span_s)?;
        let updated = self.updated(&predicted, rate_rad_s)?;
        Ok(self.take_over(updated))
    }

    /// The belief `span_s` later; nothing is taken over yet.
    #[inline(always)]
    fn predicted(&mut self, span_s: f64) -> Result<Carried, EstimatorError> {
        let Carried { belief, since_update_s } = self.state.carried;
        let passage = self.passage(span_s)?;
        let belief = Belief {
            angle_rad: passage.angle(&belief),
            rate_rad_s: passage.rate(&belief),
            covariance: passage.covariance(&belief.covariance)?,
        };
        in_range(belief.angle_rad + belief.rate_rad_s)?;
        let since_update_s = in_range(since_update_s + span_s)?;
        Ok(Carried { belief, since_update_s })
    }

    /// What an update makes of a belief; nothing is taken over yet.
    ///
    /// # Source
    /// Ivanov and Ovchinnikov, KIAM preprint, 2008, with P⁺ = (…, b·R/S, c·R/S) where the text
    /// prints b/S and c/S: the printed form has the wrong units and a gain that never falls.
    #[inline(always)]
    fn updated(&self, from: &Carried, rate_rad_s: f64) -> Result<Updated, EstimatorError> {
        check_measurement(rate_rad_s)?;
        let r = self.measurement_variance_rad2_s2;
        let mut predicted = from.belief;
        if self.adds_at_every_update() {
            let Covariance { angle_rad2, cross_rad2_s, rate_rad2_s2 } = predicted.covariance;
            predicted.covariance = self.with_added(angle_rad2, cross_rad2_s, rate_rad2_s2)?;
        }
        let variance_rad2_s2 = predicted.covariance.rate_rad2_s2 + r;
        if !(variance_rad2_s2 > 0.0 && variance_rad2_s2 <= f64::MAX) {
            return Err(EstimatorError::SingularInnovation { variance_rad2_s2 });
        }
        let inverse = 1.0 / variance_rad2_s2;
        let gain = (
            predicted.covariance.cross_rad2_s * inverse,
            predicted.covariance.rate_rad2_s2 * inverse,
        );
        let residual_rad_s = rate_rad_s - predicted.rate_rad_s;
        let correction = (gain.0 * residual_rad_s, gain.1 * residual_rad_s);
        let integral_rad = self.state.integral_rad + rate_rad_s * from.since_update_s;
        let mut belief = Belief {
            angle_rad: predicted.angle_rad + correction.0,
            rate_rad_s: predicted.rate_rad_s + correction.1,
            covariance: predicted.covariance.updated(r, inverse)?,
        };
        let innovation = (integral_rad - predicted.angle_rad, residual_rad_s);
        let refined = self.refine(&mut belief.covariance, &Surprise { correction, innovation })?;
        in_range(belief.angle_rad + belief.rate_rad_s + integral_rad)?;
        let innovation = Innovation { residual_rad_s, variance_rad2_s2 };
        Ok(Updated { belief, integral_rad, refined, innovation })
    }

    #[inline(always)]
    fn take_over(&mut self, updated: Updated) -> Innovation {
        self.state.carried = Carried { belief: updated.belief, since_update_s: 0.0 };
        self.state.integral_rad = updated.integral_rad;
        if let Some(refined) = updated.refined {
            self.state.surprises = refined.surprises;
            if let Some(added) = refined.added {
                self.state.added = added;
            }
        }
        updated.innovation
    }

    #[inline]
    fn adds_at_every_update(&self) -> bool {
        self.refinement.reading == Reading::M1 && self.refinement.samples != 0
    }

    /// Out of line and cold: were the sums in line, they might become part of the path that every
    /// other reading's step waits for. By number, for a struct would be handed over in memory.
    #[cold]
    #[inline(never)]
    fn with_added(&self, a: f64, b: f64, c: f64) -> Result<Covariance, EstimatorError> {
        let covariance = Covariance { angle_rad2: a, cross_rad2_s: b, rate_rad2_s2: c };
        covariance.plus(self.state.added)
    }

    /// Collects the surprise of this update and, every N samples, puts the covariance that the
    /// surprises show to use as the reading says. Gives what to keep once the update has gone
    /// through; none when the refinement is off.
    #[inline]
    fn refine(
        &self,
        covariance: &mut Covariance,
        surprise: &Surprise,
    ) -> Result<Option<Refined>, EstimatorError> {
        let Refinement { samples, reading } = self.refinement;
        if samples == 0 {
            return Ok(None);
        }
        let (q_angle_rad, q_rate_rad_s) = surprise.q(reading);
        let mut refined = Refined { surprises: self.state.surprises, added: None };
        if let Some(mean) = refined.surprises.add(q_angle_rad, q_rate_rad_s, samples)? {
            match reading {
                Reading::M0 | Reading::M4 => *covariance = mean,
                Reading::M1 => refined.added = Some(mean),
                Reading::M6 => *covariance = Covariance { cross_rad2_s: 0.0, ..mean },
            }
        }
        Ok(Some(refined))
    }
}

/// What evolves in a filter without refinement.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Unrefined {
    pub(crate) belief: Belief,
    /// Seconds predicted since the last measurement.
    pub(crate) since_update_s: f64,
    /// Plain integral of the measured rate.
    pub(crate) integral_rad: f64,
}

/// A belief, and how far it has been carried without a measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Carried {
    belief: Belief,
    /// Seconds predicted since the last measurement.
    since_update_s: f64,
}

/// What an update comes to, before it is taken over.
#[derive(Debug, Clone, Copy)]
struct Updated {
    belief: Belief,
    integral_rad: f64,
    /// None when the refinement is off.
    refined: Option<Refined>,
    innovation: Innovation,
}

/// What the refinement keeps of an update.
#[derive(Debug, Clone, Copy)]
struct Refined {
    surprises: Accumulator,
    /// What is to be added from now on, if that has changed.
    added: Option<Covariance>,
}

/// Each step waits for the covariance of the step before, so what counts is that path alone. Hence
/// no copy of the state (only what changes is written, each number once), one division, no check
/// on the path, and inlining into the caller's loop.
impl<M: Motion> RateEstimator for Filter<M> {
    #[inline(always)]
    fn predict(&mut self, span_s: f64) -> Result<(), EstimatorError> {
        self.state.carried = self.predicted(span_s)?;
        Ok(())
    }

    #[inline(always)]
    fn update(&mut self, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        let updated = self.updated(&self.state.carried, rate_rad_s)?;
        Ok(self.take_over(updated))
    }

    fn step(&mut self, span_s: f64, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        self.step(span_s, rate_rad_s)
    }

    /// As published: the mean over the step is taken for the rate at its end, and its integral for
    /// the angle turned.
    fn step_mean(&mut self, span_s: f64, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        self.step(span_s, rate_rad_s)
    }

    #[inline]
    fn belief(&self) -> Belief {
        self.state.carried.belief
    }

    /// Reading M1 alone has more to save.
    fn saved_len(&self) -> usize {
        State::SAVED_LEN + if self.adds_at_every_update() { State::ADDED_LEN } else { 0 }
    }

    fn save(&self, out: &mut [u8]) {
        let mut writer = Writer::new(out);
        self.state.write(&mut writer);
        if self.adds_at_every_update() {
            write_covariance(&mut writer, &self.state.added);
        }
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        let mut reader = Reader::new(bytes, self.saved_len())?;
        let mut state = State::read(&mut reader)?;
        if self.adds_at_every_update() {
            state.added = read_covariance(&mut reader)?;
        }
        self.state = state;
        Ok(())
    }
}

impl State {
    /// Ten numbers and a counter.
    const SAVED_LEN: usize = 10 * 8 + 4;
    /// Three numbers more.
    const ADDED_LEN: usize = 3 * 8;

    fn write(&self, out: &mut Writer<'_>) {
        let Belief { angle_rad, rate_rad_s, covariance } = self.carried.belief;
        out.f64(angle_rad);
        out.f64(rate_rad_s);
        write_covariance(out, &covariance);
        out.f64(self.carried.since_update_s);
        out.f64(self.integral_rad);
        out.f64(self.surprises.angle_rad2);
        out.f64(self.surprises.cross_rad2_s);
        out.f64(self.surprises.rate_rad2_s2);
        out.u32(self.surprises.count);
    }

    fn read(bytes: &mut Reader<'_>) -> Result<Self, RestoreError> {
        Ok(Self {
            carried: Carried {
                belief: Belief {
                    angle_rad: bytes.finite("angle_rad")?,
                    rate_rad_s: bytes.finite("rate_rad_s")?,
                    covariance: read_covariance(bytes)?,
                },
                since_update_s: bytes.finite("since_update_s")?,
            },
            integral_rad: bytes.finite("integral_rad")?,
            surprises: Accumulator {
                angle_rad2: bytes.finite("angle surprise")?,
                cross_rad2_s: bytes.finite("cross surprise")?,
                rate_rad2_s2: bytes.finite("rate surprise")?,
                count: bytes.u32(),
            },
            added: Covariance::ZERO,
        })
    }
}

fn write_covariance(out: &mut Writer<'_>, covariance: &Covariance) {
    out.f64(covariance.angle_rad2);
    out.f64(covariance.cross_rad2_s);
    out.f64(covariance.rate_rad2_s2);
}

fn read_covariance(bytes: &mut Reader<'_>) -> Result<Covariance, RestoreError> {
    Ok(Covariance {
        angle_rad2: bytes.finite("angle variance")?,
        cross_rad2_s: bytes.finite("angle-rate covariance")?,
        rate_rad2_s2: bytes.finite("rate variance")?,
    })
}
