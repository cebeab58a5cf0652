//! One step of the motion with derivatives that are good enough to go downhill by.

use super::equations::Coefficients;
use super::step::{combined, judged, moved};
use super::{MotionParameters, MotionState, SwingMotion, Tangents};
use crate::EstimatorError;

impl SwingMotion {
    /// As [`step`](Self::step), and bit for bit the same state; `tangents` are carried along with
    /// the Jacobian of the middle of the step, as exp(hJ) to third order. Half the work of exact
    /// ones: a fit that weighs its residuals with them ends near the bottom and not at it. They
    /// are not judged.
    ///
    /// # Errors
    /// Those of [`step`](Self::step), but for the span, which is not judged.
    #[inline]
    pub(in crate::swing) fn step_with_rough_tangents(
        &self,
        state: &MotionState,
        parameters: &MotionParameters,
        span_s: f64,
        tangents: &mut Tangents,
    ) -> Result<MotionState, EstimatorError> {
        let coefficients = Coefficients::new(self, parameters);
        let (x, half_s) = (state.entries(), 0.5 * span_s);
        let k1 = coefficients.rates(&x)?;
        let (k2, jacobian) = coefficients.rates_and_jacobian(&moved(&x, half_s, &k1))?;
        let k3 = coefficients.rates(&moved(&x, half_s, &k2))?;
        let k4 = coefficients.rates(&moved(&x, span_s, &k3))?;
        let first = jacobian.apply(tangents);
        let second = jacobian.apply(&tangents.moved(span_s / 3.0, &first));
        let third = jacobian.apply(&tangents.moved(half_s, &second));
        let state = judged(combined(&x, span_s, [&k1, &k2, &k3, &k4]))?;
        tangents.add(span_s, &third);
        Ok(state)
    }
}
