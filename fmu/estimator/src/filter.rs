//! The two-state Kalman filter of the 2008 papers, with their formulas corrected.

use crate::checks::{check_measurement, check_span};
use crate::config::ConfigError;
use crate::covariance::Gain;
use crate::refinement::Accumulator;
use crate::state_bytes::{Reader, RestoreError, Writer};
use crate::{
    Belief, Covariance, EstimatorError, FilterConfig, Innovation, Motion, PermanentRotation,
    RateEstimator, Reading, Refinement, TorsionalOscillation, Transition,
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
    /// Transition of the last span: spans repeat, and sines are dear. Not part of the state, for
    /// it follows from the span.
    cached: (f64, Transition),
}

/// All that evolves.
#[derive(Debug, Clone, Copy, PartialEq)]
struct State {
    angle_rad: f64,
    rate_rad_s: f64,
    covariance: Covariance,
    /// Seconds predicted since the last measurement.
    since_update_s: f64,
    /// Plain integral of the measured rate, which reading M6 compares the angle with.
    integral_rad: f64,
    surprises: Accumulator,
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
        let cached = (0.0, motion.transition(0.0));
        Ok(Self {
            motion,
            measurement_variance_rad2_s2: config.measurement_variance_rad2_s2,
            process_noise_rad2_s3: config.process_noise_rad2_s3,
            refinement: config.refinement,
            state: State {
                angle_rad: config.angle_start_rad,
                rate_rad_s: config.rate_start_rad_s,
                covariance: config.covariance_start(),
                since_update_s: 0.0,
                integral_rad: config.angle_start_rad,
                surprises: Accumulator::default(),
            },
            cached,
        })
    }

    #[inline]
    fn transition(&mut self, span_s: f64) -> Transition {
        // Bit equality: the cache must give exactly what a fresh computation would.
        if self.cached.0.to_bits() != span_s.to_bits() {
            self.cached = (span_s, self.motion.transition(span_s));
        }
        self.cached.1
    }

    /// Takes `next` over, unless it has left the range of floating point.
    #[inline]
    fn commit(&mut self, next: State) -> Result<(), EstimatorError> {
        let Covariance { angle_rad2, cross_rad2_s, rate_rad2_s2 } = next.covariance;
        let sum = next.angle_rad + next.rate_rad_s + angle_rad2 + cross_rad2_s + rate_rad2_s2;
        // One test for all five: a sum is finite only if each term is.
        if !(sum + next.integral_rad).is_finite() {
            return Err(EstimatorError::Overflow);
        }
        self.state = next;
        Ok(())
    }

    /// Collects the surprise of this update and, every N samples, inserts the covariance that the
    /// surprises show.
    #[inline]
    fn refine(&self, state: &mut State, predicted_angle_rad: f64, residual_rad_s: f64, gain: Gain) {
        let Refinement { samples, reading } = self.refinement;
        if samples == 0 {
            return;
        }
        let (q_angle_rad, q_rate_rad_s) = match reading {
            Reading::M0 => (gain.angle_s * residual_rad_s, gain.rate * residual_rad_s),
            Reading::M6 => (state.integral_rad - predicted_angle_rad, residual_rad_s),
        };
        if let Some(mean) = state.surprises.add(q_angle_rad, q_rate_rad_s, samples) {
            state.covariance = match reading {
                Reading::M0 => mean,
                Reading::M6 => Covariance { cross_rad2_s: 0.0, ..mean },
            };
        }
    }
}

impl<M: Motion> RateEstimator for Filter<M> {
    #[inline]
    fn predict(&mut self, span_s: f64) -> Result<(), EstimatorError> {
        check_span(span_s)?;
        let t = self.transition(span_s);
        let mut s = self.state;
        s.angle_rad = t.f11 * self.state.angle_rad + t.f12 * self.state.rate_rad_s;
        s.rate_rad_s = t.f21 * self.state.angle_rad + t.f22 * self.state.rate_rad_s;
        s.covariance = s.covariance.predicted(&t, self.process_noise_rad2_s3);
        s.since_update_s += span_s;
        self.commit(s)
    }

    /// # Source
    /// Ivanov and Ovchinnikov, KIAM preprint, 2008, with P⁺ = (…, b·R/S, c·R/S) where the text
    /// prints b/S and c/S: the printed form has the wrong units and a gain that never falls.
    #[inline]
    fn update(&mut self, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        check_measurement(rate_rad_s)?;
        let r = self.measurement_variance_rad2_s2;
        let mut s = self.state;
        let variance_rad2_s2 = s.covariance.rate_rad2_s2 + r;
        if !(variance_rad2_s2 > 0.0 && variance_rad2_s2 < f64::INFINITY) {
            return Err(EstimatorError::SingularInnovation { variance_rad2_s2 });
        }
        let inverse = 1.0 / variance_rad2_s2;
        let gain = Gain {
            angle_s: s.covariance.cross_rad2_s * inverse,
            rate: s.covariance.rate_rad2_s2 * inverse,
        };
        let predicted_angle_rad = s.angle_rad;
        let residual_rad_s = rate_rad_s - s.rate_rad_s;
        s.angle_rad += gain.angle_s * residual_rad_s;
        s.rate_rad_s += gain.rate * residual_rad_s;
        s.covariance = s.covariance.updated(gain, r);
        s.integral_rad += rate_rad_s * s.since_update_s;
        s.since_update_s = 0.0;
        self.refine(&mut s, predicted_angle_rad, residual_rad_s, gain);
        self.commit(s)?;
        Ok(Innovation { residual_rad_s, variance_rad2_s2 })
    }

    #[inline]
    fn belief(&self) -> Belief {
        let s = &self.state;
        Belief { angle_rad: s.angle_rad, rate_rad_s: s.rate_rad_s, covariance: s.covariance }
    }

    fn saved_len(&self) -> usize {
        State::SAVED_LEN
    }

    fn save(&self, out: &mut [u8]) {
        self.state.write(&mut Writer::new(out));
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        let mut reader = Reader::new(bytes, State::SAVED_LEN)?;
        self.state = State::read(&mut reader)?;
        Ok(())
    }
}

impl State {
    /// Ten numbers and a counter.
    const SAVED_LEN: usize = 10 * 8 + 4;

    fn write(&self, out: &mut Writer<'_>) {
        out.f64(self.angle_rad);
        out.f64(self.rate_rad_s);
        out.f64(self.covariance.angle_rad2);
        out.f64(self.covariance.cross_rad2_s);
        out.f64(self.covariance.rate_rad2_s2);
        out.f64(self.since_update_s);
        out.f64(self.integral_rad);
        out.f64(self.surprises.angle_rad2);
        out.f64(self.surprises.cross_rad2_s);
        out.f64(self.surprises.rate_rad2_s2);
        out.u32(self.surprises.count);
    }

    fn read(bytes: &mut Reader<'_>) -> Result<Self, RestoreError> {
        Ok(Self {
            angle_rad: bytes.finite("angle_rad")?,
            rate_rad_s: bytes.finite("rate_rad_s")?,
            covariance: Covariance {
                angle_rad2: bytes.finite("angle variance")?,
                cross_rad2_s: bytes.finite("angle-rate covariance")?,
                rate_rad2_s2: bytes.finite("rate variance")?,
            },
            since_update_s: bytes.finite("since_update_s")?,
            integral_rad: bytes.finite("integral_rad")?,
            surprises: Accumulator {
                angle_rad2: bytes.finite("angle surprise")?,
                cross_rad2_s: bytes.finite("cross surprise")?,
                rate_rad2_s2: bytes.finite("rate surprise")?,
                count: bytes.u32(),
            },
        })
    }
}
