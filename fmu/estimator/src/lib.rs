//! Estimators of the twist angle and its rate from one gyro axis.
//!
//! Three of them are those of the 2008 experiment, in the order in which it used them:
//! [`PlainIntegration`] of the measured rate, and two Kalman filters that share one algorithm
//! ([`Filter`]) and differ in the motion they assume: [`PermanentRotation`] (constant rate) and
//! [`TorsionalOscillation`] (undamped torsion of known period). The fourth learns period, damping
//! and bias while it watches ([`AugmentedFilter`]), and with a test of its own innovations it also
//! survives kicks and outliers ([`TestedFilter`]). On a thread that yields none of them is right,
//! and a bank of filters with friction in the thread takes over ([`HysteresisBank`]);
//! [`SwingFilter`] follows a body that swings while it turns. What a live rig runs is none of them
//! alone but [`LiveEstimator`], which switches between them and says so. All meet the contract of
//! [`RateEstimator`]; [`ThreeAxisFilter`], which takes three rates at once, meets its like.
//!
//! **Architecture Invariant:** pure arithmetic. No input or output, no clock, no FMI, and no path
//! to truth: an estimator cannot cheat, because neither the body nor the gyro can be reached from
//! here. Nothing on the predict and update path allocates or panics. No standard library, so that
//! the filters run on a microcontroller: those with a roll-back, and a [`SwingFit`], need an
//! allocator when they are made.

#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

mod augmented;
mod checks;
mod config;
mod covariance;
mod filter;
mod hysteresis;
mod integration;
mod lanes;
mod live;
mod motion;
mod passage;
mod refinement;
mod rest;
mod smoother;
mod state_bytes;
mod status;
mod swing;
mod wide;

pub use augmented::{
    Alarm, AugmentedConfig, AugmentedFilter, GyroRange, InnovationTest, LearntParameters,
    Quantiser, StartPrior, TestedFilter,
};
pub use config::{ConfigError, FilterConfig};
pub use covariance::Covariance;
pub use filter::Filter;
pub use hysteresis::{DahlFilter, HysteresisBank, LearntYield, MEMBERS, YieldPrior};
pub use integration::PlainIntegration;
pub use lanes::{FilterLanes, LaneErrors};
pub use live::{LiveConfig, LiveEstimator, LiveWarning, SwingFallback, SwingScale};
pub use motion::{Motion, PermanentRotation, TorsionalOscillation, Transition};
pub use refinement::{Reading, Refinement};
pub use rest::{RestError, half_range_squared, measurement_variance_from_rest};
pub use smoother::{
    BatchEstimate, BatchFit, FitRefusal, FixedLag, Kick, LaggedFilter, RateRecord, RateSample,
    SmoothError, Smoothed, Verdict, smooth,
};
pub use state_bytes::RestoreError;
pub use status::Status;
pub use swing::{
    AcceptedFit, ExpectedRate, FitOutcome, FitStarts, InputAxis, MOTION_PARAMETERS, MOTION_STATES,
    MOTION_TANGENTS, MotionParameters, MotionState, Progress, Rejection, SWING_PRESENT_RAD,
    SWING_STATES, SwingBelief, SwingBody, SwingConfig, SwingFilter, SwingFit, SwingMeter,
    SwingMotion, Tangents, ThreeAxisFilter,
};

/// What an estimator believes: the mean and covariance of (angle, rate).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Belief {
    /// Mean angle from equilibrium, rad.
    pub angle_rad: f64,
    /// Mean rate, rad/s.
    pub rate_rad_s: f64,
    /// Covariance of the two.
    pub covariance: Covariance,
}

/// The surprise in one measurement: what came minus what was expected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Innovation {
    /// Measured minus predicted rate, rad/s.
    pub residual_rad_s: f64,
    /// Variance that the estimator expected of the residual, S = H·P·Hᵀ + R, rad²/s².
    pub variance_rad2_s2: f64,
}

impl Innovation {
    /// Normalised innovation squared; 1 on average when the estimator is consistent.
    #[must_use]
    pub fn nis(&self) -> f64 {
        self.residual_rad_s * self.residual_rad_s / self.variance_rad2_s2
    }
}

/// Why an estimator refused a call. The estimate is left as it was before the call.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EstimatorError {
    /// Asked to predict over a span that is negative or not finite.
    #[error("cannot predict over {span_s} s: the span must be finite and not negative")]
    BadSpan {
        /** The rejected span, s. */
        span_s: f64,
    },
    /// The measurement is not finite.
    #[error("measured rate {rate_rad_s} rad/s is not finite")]
    BadMeasurement {
        /** The rejected rate, rad/s. */
        rate_rad_s: f64,
    },
    /// The body would hang at a right angle or beyond, where the motion has no coordinates.
    #[error("the body's axis would leave the vertical by 90° or more")]
    TiltTooLarge,
    /// Asked to predict over a span that would take too many steps of integration.
    #[error(
        "cannot predict over {span_s} s: this motion is integrated in steps, {limit_s} s at most"
    )]
    SpanTooLong {
        /** The rejected span, s. */
        span_s: f64,
        /** The longest span, s. */
        limit_s: f64,
    },
    /// The call would push the belief out of the range of floating point.
    #[error("the belief would leave the range of floating point")]
    Overflow,
    /// The innovation variance is not positive: R is zero or the covariance has been corrupted.
    #[error("innovation variance {variance_rad2_s2:e} rad²/s² is not positive")]
    SingularInnovation {
        /** The rejected variance S, rad²/s². */
        variance_rad2_s2: f64,
    },
}

/// A recursive estimator of (angle, rate) from measurements of the rate.
///
/// The contract, tested for every implementation: predicting over zero seconds changes nothing; a
/// refused call changes nothing; an update of a filter, insertions of a refined covariance and
/// roll-backs aside, never grows a variance, though the mixture of a bank may; restored bytes
/// continue bit for bit as the saved estimator would have.
pub trait RateEstimator {
    /// Time update: carries the belief `span_s` seconds forward.
    ///
    /// # Errors
    /// [`EstimatorError::BadSpan`] when `span_s` is negative or not finite.
    fn predict(&mut self, span_s: f64) -> Result<(), EstimatorError>;

    /// Measurement update with a rate valid at the time of the current belief, rad/s.
    ///
    /// # Errors
    /// [`EstimatorError::BadMeasurement`] when the rate is not finite,
    /// [`EstimatorError::SingularInnovation`] when the gain cannot be formed.
    fn update(&mut self, rate_rad_s: f64) -> Result<Innovation, EstimatorError>;

    /// Predicts over `span_s` and updates with a rate valid at its end: to the bit what
    /// [`predict`](Self::predict) and [`update`](Self::update) give, where one call is shorter.
    ///
    /// # Errors
    /// What they refuse; when the rate is refused, the prediction may have been made.
    fn step(&mut self, span_s: f64, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        self.predict(span_s)?;
        self.update(rate_rad_s)
    }

    /// Predicts over `span_s` and takes in the mean rate over them, which is the rate at their
    /// middle: predict over half of them, [`update`](Self::update), predict over the rest.
    ///
    /// Taken for the rate at its end it would be late by half of them: 0.02 °/s at 10 ms, for a
    /// body that turns by 360° either way with a period of a minute. The filters of 2008 take it
    /// so, by their own text.
    ///
    /// # Errors
    /// What predict and update refuse; the first half of the prediction may have been made.
    fn step_mean(&mut self, span_s: f64, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        step_mean_in_halves(self, span_s, rate_rad_s)
    }

    /// Measurement update with a rate that the gyro itself flags as over range. An estimator that
    /// knows of no range, as those of 2008, takes it for what it says.
    ///
    /// # Errors
    /// As [`update`](Self::update).
    fn update_over_range(&mut self, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        self.update(rate_rad_s)
    }

    /// The current belief.
    fn belief(&self) -> Belief;

    /// How far the belief may be trusted, as far as the estimator itself can tell.
    fn status(&self) -> Status {
        Status::of_claim(self.belief().covariance.angle_rad2)
    }

    /// [`belief`](Self::belief) and [`status`](Self::status), where one call is shorter.
    fn report(&self) -> (Belief, Status) {
        (self.belief(), self.status())
    }

    /// How many bytes [`save`](Self::save) writes.
    fn saved_len(&self) -> usize;

    /// Writes the state, parameters excluded, into the first [`saved_len`](Self::saved_len) bytes.
    ///
    /// # Panics
    /// When `out` is shorter than [`saved_len`](Self::saved_len).
    fn save(&self, out: &mut [u8]);

    /// Takes over a state written by [`save`](Self::save) of an equally configured estimator.
    ///
    /// # Errors
    /// [`RestoreError`] when the bytes cannot be such a state; the estimator is then unchanged.
    fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError>;
}

fn step_mean_in_halves<E: RateEstimator + ?Sized>(
    estimator: &mut E,
    span_s: f64,
    rate_rad_s: f64,
) -> Result<Innovation, EstimatorError> {
    let half_s = 0.5 * span_s;
    estimator.predict(half_s)?;
    let innovation = estimator.update(rate_rad_s)?;
    estimator.predict(span_s - half_s)?;
    Ok(innovation)
}
