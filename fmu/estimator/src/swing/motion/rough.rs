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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SwingBody;

    #[test]
    fn rough_derivatives_stay_near_the_exact_ones_and_the_state_is_the_same() {
        let motion = SwingMotion::new(&SwingBody {
            mass_kg: 1.0,
            com_depth_m: 0.1,
            inertia_kg_m2: [0.0100, 0.0105, 0.0100],
            gravity_m_s2: 9.81,
            swing_damping_1_s: 1e-3,
        });
        let parameters = MotionParameters::as_believed(2.7e-3, 3.1e-3);
        let start = MotionState { e: [0.1, 0.0], twist_rad: 6.0, omega_rad_s: [0.1, 0.9, 0.0] };
        let (mut exact, mut rough) = (Tangents::START, Tangents::START);
        let (mut a, mut b) = (start, start);
        for _ in 0..400 {
            a = motion.step_with_tangents(&a, &parameters, 0.02, &mut exact).unwrap();
            b = motion.step_with_rough_tangents(&b, &parameters, 0.02, &mut rough).unwrap();
        }
        assert_eq!(a, b);
        for (exact, rough) in exact.0.iter().zip(&rough.0) {
            let size = exact.iter().fold(0.0_f64, |size, entry| size.max(entry.abs()));
            let apart = exact.iter().zip(rough).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // The third order loses (ωh)⁴/24 of the swing a step, 0.6e-4: 2.5 % in 400 steps.
            assert!(apart < 0.05 * size, "{apart} of {size}");
        }
    }
}
