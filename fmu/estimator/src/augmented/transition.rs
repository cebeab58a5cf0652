//! The torsional oscillator carried over a span: its transition, how that depends on its two
//! parameters, and the noise gathered on the way.
//!
//! With constant s and d the pair (α, ω) obeys α′ = −s·ω, ω′ = α − d·ω, whose matrix A satisfies
//! A² = −d·A − s·I. Every function of A is therefore e₀·I + e₁·A: two numbers describe the
//! transition, four more its derivatives, and doubling the span is a handful of products. No sine
//! is called, and s may have either sign.

/// Largest |s|·h² for which the series to the third order serves: it then errs by
/// (|s|·h²)²/24 = 4e-10 of the amplitude in a step.
const STEP_PHASE2_MAX: f64 = 1e-4;
/// Largest |d|·h for which it does.
const STEP_DECAY_MAX: f64 = 1e-2;
/// A span halved so often is no span: 2⁻²⁰⁰⁰ s underflows.
const HALVINGS_MAX: u32 = 2000;

/// exp(A·h) = e₀·I + e₁·A over a span h, with derivatives in s and d.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Transition {
    s: f64,
    d: f64,
    e0: f64,
    /// s
    e1: f64,
    e0_by_s: f64,
    e0_by_d: f64,
    e1_by_s: f64,
    e1_by_d: f64,
    /// Covariance of (α, ω) from white angular acceleration of density 1.
    pub(crate) noise: Noise,
}

/// Symmetric 2×2 covariance of (α, ω) per unit density of white angular acceleration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Noise {
    pub(crate) aa: f64,
    pub(crate) aw: f64,
    pub(crate) ww: f64,
}

/// The transition as matrix, and its derivatives in (s, d) times a given (α, ω).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Jacobian {
    pub(crate) aa: f64,
    pub(crate) aw: f64,
    pub(crate) wa: f64,
    pub(crate) ww: f64,
    pub(crate) a_by_s: f64,
    pub(crate) a_by_d: f64,
    pub(crate) w_by_s: f64,
    pub(crate) w_by_d: f64,
}

/// Whether the motion hardly bends within a span: by a hundredth of a radian, or a hundredth of its
/// decay.
#[inline(always)]
pub(super) fn is_short(span_s: f64, s: f64, d: f64) -> bool {
    s.abs() * (span_s * span_s) <= STEP_PHASE2_MAX && d.abs() * span_s <= STEP_DECAY_MAX
}

impl Transition {
    /// The transition over `span_s`, which is finite and not negative.
    #[inline(always)]
    pub(crate) fn over(span_s: f64, s: f64, d: f64) -> Self {
        if is_short(span_s, s, d) {
            Self::series(span_s, s, d)
        } else {
            Self::by_doubling(span_s, s, d)
        }
    }

    /// Halves the span until the series serves, then doubles back: the work grows with the
    /// logarithm of the span, so that no gap is too long.
    #[cold]
    #[inline(never)]
    fn by_doubling(span_s: f64, s: f64, d: f64) -> Self {
        let (mut h, mut halvings) = (span_s, 0);
        while halvings < HALVINGS_MAX && !is_short(h, s, d) {
            h *= 0.5;
            halvings += 1;
        }
        (0..halvings).fold(Self::series(h, s, d), |half, _| half.doubled())
    }

    #[inline(always)]
    fn series(h: f64, s: f64, d: f64) -> Self {
        let h2 = h * h * 0.5;
        let h3 = h2 * h * (1.0 / 3.0);
        let bend = h2 - d * h3;
        Self {
            s,
            d,
            e0: 1.0 - s * bend,
            e1: h - d * bend - s * h3,
            e0_by_s: -bend,
            e0_by_d: s * h3,
            e1_by_s: -h3,
            e1_by_d: d * (2.0 * h3) - h2,
            noise: Noise { aa: s * s * (2.0 * h3), aw: -s * h2, ww: h },
        }
    }

    /// The same over twice the span: the square, differentiated as such.
    fn doubled(&self) -> Self {
        let Self { s, d, e0, e1, .. } = *self;
        // Over the second half the noise of the first is carried on.
        let first = self.carried(self.noise);
        let noise = Noise {
            aa: first.aa + self.noise.aa,
            aw: first.aw + self.noise.aw,
            ww: first.ww + self.noise.ww,
        };
        let e0_by = |e0_by: f64, e1_by: f64| 2.0 * (e0 * e0_by - s * e1 * e1_by);
        let e1_by = |e0_by: f64, e1_by: f64| 2.0 * (e0_by * e1 + e0 * e1_by - d * e1 * e1_by);
        Self {
            s,
            d,
            e0: e0 * e0 - s * e1 * e1,
            e1: 2.0 * e0 * e1 - d * e1 * e1,
            e0_by_s: e0_by(self.e0_by_s, self.e1_by_s) - e1 * e1,
            e0_by_d: e0_by(self.e0_by_d, self.e1_by_d),
            e1_by_s: e1_by(self.e0_by_s, self.e1_by_s),
            e1_by_d: e1_by(self.e0_by_d, self.e1_by_d) - e1 * e1,
            noise,
        }
    }

    /// Φ·Q·Φᵀ.
    fn carried(&self, q: Noise) -> Noise {
        let (f11, f12, f21, f22) = self.matrix();
        let (ra, rw) = (f11 * q.aa + f12 * q.aw, f11 * q.aw + f12 * q.ww);
        let (ta, tw) = (f21 * q.aa + f22 * q.aw, f21 * q.aw + f22 * q.ww);
        Noise { aa: ra * f11 + rw * f12, aw: ra * f21 + rw * f22, ww: ta * f21 + tw * f22 }
    }

    #[inline(always)]
    fn matrix(&self) -> (f64, f64, f64, f64) {
        (self.e0, -self.s * self.e1, self.e1, self.e0 - self.d * self.e1)
    }

    /// Where (α, ω) comes to.
    #[inline(always)]
    pub(crate) fn apply(&self, alpha: f64, rate: f64) -> (f64, f64) {
        let (f11, f12, f21, f22) = self.matrix();
        (f11 * alpha + f12 * rate, f21 * alpha + f22 * rate)
    }

    /// All first derivatives of where (α, ω) comes to.
    #[inline(always)]
    pub(crate) fn jacobian(&self, alpha: f64, rate: f64) -> Jacobian {
        let Self { s, d, e1, e0_by_s, e0_by_d, e1_by_s, e1_by_d, .. } = *self;
        let (aa, aw, wa, ww) = self.matrix();
        Jacobian {
            aa,
            aw,
            wa,
            ww,
            a_by_s: e0_by_s * alpha - (e1 + s * e1_by_s) * rate,
            a_by_d: e0_by_d * alpha - s * e1_by_d * rate,
            w_by_s: e1_by_s * alpha + (e0_by_s - d * e1_by_s) * rate,
            w_by_d: e1_by_d * alpha + (e0_by_d - e1 - d * e1_by_d) * rate,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, Matrix4};

    /// Spans from a sample to several periods, damping from none to over-critical, s < 0 too.
    fn cases() -> impl Iterator<Item = (f64, f64, f64)> {
        [0.01, 0.3, 7.0, 60.0].into_iter().flat_map(|h| {
            [(0.3, 0.05), (0.3, 0.0), (0.02, 0.5), (1.7e-4, 8e-4), (-1e-4, 0.01)]
                .map(|(s, d)| (h, s, d))
        })
    }

    /// Φ and Q by Van Loan's block exponential.
    fn van_loan(h: f64, s: f64, d: f64) -> (Matrix2<f64>, Matrix2<f64>) {
        let a = Matrix2::new(0.0, -s, 1.0, -d);
        let mut block = Matrix4::zeros();
        block.fixed_view_mut::<2, 2>(0, 0).copy_from(&(-a * h));
        block[(1, 3)] = h;
        block.fixed_view_mut::<2, 2>(2, 2).copy_from(&(a.transpose() * h));
        let e = block.exp();
        let phi = e.fixed_view::<2, 2>(2, 2).transpose();
        (phi, phi * e.fixed_view::<2, 2>(0, 2))
    }

    #[test]
    fn the_transition_is_the_matrix_exponential() {
        for (h, s, d) in cases() {
            let (f11, f12, f21, f22) = Transition::over(h, s, d).matrix();
            let (phi, _) = van_loan(h, s, d);
            let omega = s.abs().sqrt();
            // Each halving leaves at most 4e-10 of the amplitude, and there are (phase or decay)
            // / 0.005 steps at most.
            let steps = 1.0 + (omega * h + d * h) / 0.005;
            let tolerance = 4.2e-10 * steps * phi.abs().max().max(1.0);
            let pairs = [
                (f11, phi[(0, 0)], 1.0),
                (f12, phi[(0, 1)], omega),
                (f21, phi[(1, 0)], 1.0 / omega),
                (f22, phi[(1, 1)], 1.0),
            ];
            for (ours, theirs, scale) in pairs {
                let off = (ours - theirs).abs() / scale;
                assert!(off < tolerance, "h {h}, s {s}, d {d}: off by {off:e}");
            }
        }
    }

    #[test]
    fn the_noise_is_van_loans() {
        for (h, s, d) in cases() {
            let q = Transition::over(h, s, d).noise;
            let (_, theirs) = van_loan(h, s, d);
            // In each small step the noise is that of the undamped, straight path: it errs by a
            // share of d·h + s·h², at most 1e-2.
            let (aa, ww) = (theirs[(0, 0)], theirs[(1, 1)]);
            assert!((q.ww / ww - 1.0).abs() < 1.1e-2, "h {h}, s {s}, d {d}: {} {ww}", q.ww);
            assert!((q.aa / aa - 1.0).abs() < 1.1e-2, "h {h}, s {s}, d {d}: {} {aa}", q.aa);
            let cross = (q.aw - theirs[(0, 1)]).abs();
            assert!(cross < 1.1e-2 * (aa * ww).sqrt(), "h {h}, s {s}, d {d}: off by {cross:e}");
        }
    }

    #[test]
    fn the_jacobian_is_the_derivative_of_the_prediction() {
        let (alpha, rate) = (-1e-3, 0.07);
        for (h, s, d) in cases() {
            let at = |s: f64, d: f64| Transition::over(h, s, d).apply(alpha, rate);
            let j = Transition::over(h, s, d).jacobian(alpha, rate);
            // Steps small beside 1/h², so that neither curvature nor a change in the number of
            // halvings shows.
            let (ds, dd) = (1e-4 * s.abs(), 1e-4 * (d.abs() + s.abs().sqrt()));
            let by_s = (
                (at(s + ds, d).0 - at(s - ds, d).0) / (2.0 * ds),
                (at(s + ds, d).1 - at(s - ds, d).1) / (2.0 * ds),
            );
            let by_d = (
                (at(s, d + dd).0 - at(s, d - dd).0) / (2.0 * dd),
                (at(s, d + dd).1 - at(s, d - dd).1) / (2.0 * dd),
            );
            let pairs = [
                (j.a_by_s, by_s.0, by_s.0.abs() + by_s.1.abs() * s.abs().sqrt()),
                (j.w_by_s, by_s.1, by_s.1.abs() + by_s.0.abs() / s.abs().sqrt()),
                (j.a_by_d, by_d.0, by_d.0.abs() + by_d.1.abs() * s.abs().sqrt()),
                (j.w_by_d, by_d.1, by_d.1.abs() + by_d.0.abs() / s.abs().sqrt()),
            ];
            for (k, (ours, numeric, scale)) in pairs.into_iter().enumerate() {
                // Central differences err by (1e-4·phase)²/6; the series' own derivative by its
                // next term, d·h or Ω·h of a small step.
                let off = (ours - numeric).abs() / scale;
                assert!(off < 1e-4, "entry {k} at h {h}, s {s}, d {d}: {ours:e} {numeric:e}");
            }
        }
    }

    #[test]
    fn no_span_is_too_long() {
        let settled = Transition::over(1e15, 1e-4, 1e-3).apply(1.0, 1.0);
        assert_eq!(settled, (0.0, 0.0), "damped out");
    }
}
