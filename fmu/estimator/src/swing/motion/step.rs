//! One step of the motion, with its exact derivatives.

use super::equations::Coefficients;
use super::{MOTION_PARAMETERS, MOTION_STATES, MotionParameters, MotionState, SwingMotion};
use crate::EstimatorError;
use crate::checks::{check_span, in_range};

/// Directions of differentiation: the six start states, then the five parameters.
pub const MOTION_TANGENTS: usize = MOTION_STATES + MOTION_PARAMETERS;

/// Derivatives of the state by the state at the start and the parameters: row i, column j is
/// ∂(entry i of the state)/∂(entry j of start and parameters), both in the order of their
/// `entries`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tangents(pub [[f64; MOTION_TANGENTS]; MOTION_STATES]);

impl Tangents {
    /// Those of a state that is the start itself.
    pub const START: Self = {
        let mut rows = [[0.0; MOTION_TANGENTS]; MOTION_STATES];
        let mut i = 0;
        while i < MOTION_STATES {
            rows[i][i] = 1.0;
            i += 1;
        }
        Self(rows)
    };

    pub(super) const ZERO: Self = Self([[0.0; MOTION_TANGENTS]; MOTION_STATES]);

    /// self + share·rates.
    #[inline(always)]
    pub(super) fn moved(&self, share: f64, rates: &Self) -> Self {
        let mut moved = Self::ZERO;
        for ((row, from), by) in moved.0.iter_mut().zip(&self.0).zip(&rates.0) {
            for ((entry, from), by) in row.iter_mut().zip(from).zip(by) {
                *entry = from + share * by;
            }
        }
        moved
    }

    #[inline(always)]
    pub(super) fn add(&mut self, share: f64, rates: &Self) {
        for (row, by) in self.0.iter_mut().zip(&rates.0) {
            for (entry, by) in row.iter_mut().zip(by) {
                *entry += share * by;
            }
        }
    }
}

/// x + share·rates.
#[inline(always)]
pub(super) fn moved(
    x: &[f64; MOTION_STATES],
    share: f64,
    rates: &[f64; MOTION_STATES],
) -> [f64; MOTION_STATES] {
    core::array::from_fn(|i| x[i] + share * rates[i])
}

/// Itself, if its numbers are ones and the body hangs at less than a right angle.
#[inline(always)]
pub(super) fn judged(entries: [f64; MOTION_STATES]) -> Result<MotionState, EstimatorError> {
    in_range(entries.iter().sum())?;
    let state = MotionState::from_entries(entries);
    state.e3().ok_or(EstimatorError::TiltTooLarge)?;
    Ok(state)
}

impl SwingMotion {
    /// The state `span_s` later, by one step of the classical Runge-Kutta method of fourth order.
    ///
    /// # Errors
    /// [`EstimatorError::BadSpan`] for a span that is negative or not finite,
    /// [`EstimatorError::TiltTooLarge`] when the body comes to hang at a right angle, and
    /// [`EstimatorError::Overflow`].
    #[inline]
    pub fn step(
        &self,
        state: &MotionState,
        parameters: &MotionParameters,
        span_s: f64,
    ) -> Result<MotionState, EstimatorError> {
        check_span(span_s)?;
        let coefficients = Coefficients::new(self, parameters);
        let (x, half_s) = (state.entries(), 0.5 * span_s);
        let k1 = coefficients.rates(&x)?;
        let k2 = coefficients.rates(&moved(&x, half_s, &k1))?;
        let k3 = coefficients.rates(&moved(&x, half_s, &k2))?;
        let k4 = coefficients.rates(&moved(&x, span_s, &k3))?;
        judged(combined(&x, span_s, [&k1, &k2, &k3, &k4]))
    }

    /// As [`step`](Self::step), and bit for bit the same state; `tangents` are carried along: from
    /// derivatives of `state` they become those of the state returned. A refused step leaves them
    /// as they were.
    ///
    /// # Errors
    /// Those of [`step`](Self::step).
    #[inline]
    pub fn step_with_tangents(
        &self,
        state: &MotionState,
        parameters: &MotionParameters,
        span_s: f64,
        tangents: &mut Tangents,
    ) -> Result<MotionState, EstimatorError> {
        check_span(span_s)?;
        let coefficients = Coefficients::new(self, parameters);
        let (x, half_s, sixth_s) = (state.entries(), 0.5 * span_s, span_s / 6.0);
        let (k1, jacobian) = coefficients.rates_and_jacobian(&x)?;
        let t1 = jacobian.apply(tangents);
        let mut later = tangents.moved(sixth_s, &t1);
        let (k2, jacobian) = coefficients.rates_and_jacobian(&moved(&x, half_s, &k1))?;
        let t2 = jacobian.apply(&tangents.moved(half_s, &t1));
        later.add(2.0 * sixth_s, &t2);
        let (k3, jacobian) = coefficients.rates_and_jacobian(&moved(&x, half_s, &k2))?;
        let t3 = jacobian.apply(&tangents.moved(half_s, &t2));
        later.add(2.0 * sixth_s, &t3);
        let (k4, jacobian) = coefficients.rates_and_jacobian(&moved(&x, span_s, &k3))?;
        let t4 = jacobian.apply(&tangents.moved(span_s, &t3));
        later.add(sixth_s, &t4);
        let state = judged(combined(&x, span_s, [&k1, &k2, &k3, &k4]))?;
        in_range(later.0.iter().flatten().sum())?;
        *tangents = later;
        Ok(state)
    }

    /// The state `span_s` later, in as many steps as follow the swing, and `tangents` with it; see
    /// [`step_with_tangents`](Self::step_with_tangents). A refused call leaves them as they were.
    ///
    /// # Errors
    /// [`EstimatorError::SpanTooLong`] beyond 65 536 steps, about a quarter of an hour, and those
    /// of [`step`](Self::step).
    #[inline]
    pub fn advance_with_tangents(
        &self,
        state: &MotionState,
        parameters: &MotionParameters,
        span_s: f64,
        tangents: &mut Tangents,
    ) -> Result<MotionState, EstimatorError> {
        let steps = self.steps_within_limit(span_s)?;
        if steps == 1 {
            return self.step_with_tangents(state, parameters, span_s, tangents);
        }
        let (mut state, mut carried) = (*state, *tangents);
        let step_s = span_s / f64::from(steps);
        for _ in 0..steps {
            state = self.step_with_tangents(&state, parameters, step_s, &mut carried)?;
        }
        *tangents = carried;
        Ok(state)
    }

    /// [`steps_in`](Self::steps_in) a span that is one and not too long.
    #[inline(always)]
    pub(crate) fn steps_within_limit(&self, span_s: f64) -> Result<u32, EstimatorError> {
        check_span(span_s)?;
        let steps = self.steps_in(span_s);
        if steps > STEPS_MAX {
            let limit_s = f64::from(STEPS_MAX) * self.step_max_s();
            return Err(EstimatorError::SpanTooLong { span_s, limit_s });
        }
        Ok(steps)
    }
}

/// Steps of integration in one call at most: a tenth of a second of work.
const STEPS_MAX: u32 = 1 << 16;

#[inline(always)]
pub(super) fn combined(
    x: &[f64; MOTION_STATES],
    span_s: f64,
    [k1, k2, k3, k4]: [&[f64; MOTION_STATES]; 4],
) -> [f64; MOTION_STATES] {
    let sixth_s = span_s / 6.0;
    core::array::from_fn(|i| x[i] + sixth_s * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]))
}
