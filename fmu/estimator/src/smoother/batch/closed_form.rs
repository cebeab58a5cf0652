//! Damped torsion in closed form, and how it depends on its two parameters.

use libm::{cos, cosh, exp, fabs, sin, sinh, sqrt};

/// |u|·t² below which sin(νt)/ν and its derivative are summed as series: the terms left out are
/// then 2e-15 of the first, and the quotient that they replace would lose as much to cancellation.
const SERIES_MAX: f64 = 1e-2;
/// μ·t beyond which the hyperbolic functions are one exponential to the last bit.
const HYPERBOLIC_MAX: f64 = 20.0;

/// exp(B·t) = e₀·I + e₁·B for (φ, φ′)′ = B·(φ, φ′) with B = [0, 1; −s, −d].
///
/// With σ = d/2 and u = s − σ², e₁ = exp(−σt)·S and e₀ = exp(−σt)·(C + σS), where C = cos(√u·t)
/// and S = sin(√u·t)/√u, or their hyperbolic brothers when u is negative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Response {
    s: f64,
    d: f64,
    e0: f64,
    /// s
    e1: f64,
    e0_by_s: f64,
    e0_by_d: f64,
    e1_by_s: f64,
    e1_by_d: f64,
}

/// Angle and rate, or their derivatives by one parameter.
pub(super) type Pair = (f64, f64);

impl Response {
    /// After `t` seconds, t ≥ 0, with s > 0 and s ≥ −d·|d|/4.
    pub(super) fn after(t: f64, s: f64, d: f64) -> Self {
        let sigma = 0.5 * d;
        let u = s - sigma * sigma;
        let [c, sine, sine_by_u] = damped_functions(t, u, sigma);
        let cosine_by_u = -0.5 * t * sine;
        // By d: u changes by −σ, the decay by −t/2.
        let e0 = c + sigma * sine;
        let e0_by_u = cosine_by_u + sigma * sine_by_u;
        Self {
            s,
            d,
            e0,
            e1: sine,
            e0_by_s: e0_by_u,
            e0_by_d: -0.5 * t * e0 + 0.5 * sine - sigma * e0_by_u,
            e1_by_s: sine_by_u,
            e1_by_d: -0.5 * t * sine - sigma * sine_by_u,
        }
    }

    /// Where (φ, φ′) comes to.
    pub(super) fn carried(&self, (angle, rate): Pair) -> Pair {
        let Self { s, d, e0, e1, .. } = *self;
        (e0 * angle + e1 * rate, -s * e1 * angle + (e0 - d * e1) * rate)
    }

    /// Derivatives of where it comes to, by s and by d.
    pub(super) fn by_parameters(&self, (angle, rate): Pair) -> [Pair; 2] {
        let Self { s, d, e1, e0_by_s, e0_by_d, e1_by_s, e1_by_d, .. } = *self;
        [
            (
                e0_by_s * angle + e1_by_s * rate,
                -(e1 + s * e1_by_s) * angle + (e0_by_s - d * e1_by_s) * rate,
            ),
            (
                e0_by_d * angle + e1_by_d * rate,
                -s * e1_by_d * angle + (e0_by_d - e1 - d * e1_by_d) * rate,
            ),
        ]
    }
}

/// exp(−σt) times C, S and ∂S/∂u.
fn damped_functions(t: f64, u: f64, sigma: f64) -> [f64; 3] {
    let x = u * t * t;
    let decay = exp(-sigma * t);
    if fabs(x) < SERIES_MAX {
        let c = 1.0 - x / 2.0 * (1.0 - x / 12.0 * (1.0 - x / 30.0 * (1.0 - x / 56.0)));
        let s = 1.0 - x / 6.0 * (1.0 - x / 20.0 * (1.0 - x / 42.0 * (1.0 - x / 72.0)));
        let by_x =
            -1.0 / 6.0 + x / 60.0 - x * x / 1680.0 + x * x * x / 90_720.0 - x * x * x * x / 7.98e6;
        return [decay * c, decay * t * s, decay * t * t * t * by_x];
    }
    let (c, s) = if u > 0.0 {
        let nu = sqrt(u);
        (decay * cos(nu * t), decay * sin(nu * t) / nu)
    } else {
        let mu = sqrt(-u);
        if mu * t > HYPERBOLIC_MAX {
            let slow = 0.5 * exp((mu - sigma) * t);
            (slow, slow / mu)
        } else {
            (decay * cosh(mu * t), decay * sinh(mu * t) / mu)
        }
    };
    [c, s, (t * c - s) / (2.0 * u)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Under-, near-critically, over-critically damped, and driven.
    const CASES: [(f64, f64); 7] = [
        (1.7e-4, 8e-4),
        (0.3, 0.0),
        (0.3, 1.095_445_115),
        (0.3, 1.0954),
        (0.3, 1.3),
        (0.01, 3.0),
        (0.3, -0.05),
    ];
    const TIMES_S: [f64; 5] = [0.0, 0.01, 0.7, 13.0, 480.0];

    /// (φ, φ′) by many small steps of the classical Runge-Kutta method.
    fn integrated(t: f64, s: f64, d: f64, start: Pair) -> Pair {
        let steps = 20_000;
        let h = t / f64::from(steps);
        let f = |(angle, rate): Pair| (rate, -s * angle - d * rate);
        let add = |(a, w): Pair, h: f64, (da, dw): Pair| (a + h * da, w + h * dw);
        (0..steps).fold(start, |x, _| {
            let k1 = f(x);
            let k2 = f(add(x, h / 2.0, k1));
            let k3 = f(add(x, h / 2.0, k2));
            let k4 = f(add(x, h, k3));
            let mean = |a, b, c, d| (a + 2.0 * b + 2.0 * c + d) / 6.0;
            add(x, h, (mean(k1.0, k2.0, k3.0, k4.0), mean(k1.1, k2.1, k3.1, k4.1)))
        })
    }

    #[test]
    fn it_solves_the_equation_of_motion() {
        for (s, d) in CASES {
            for t in TIMES_S {
                let got = Response::after(t, s, d).carried((6.0, -0.3));
                let want = integrated(t, s, d, (6.0, -0.3));
                let size = if d < 0.0 { exp(-0.5 * d * t) } else { 1.0 };
                let off = fabs(got.0 - want.0) + fabs(got.1 - want.1);
                // (h·λ)⁴/120 a step at the stiffest, 480 s at λ = 3, is 2e-7 of the amplitude 6.
                assert!(off < 2e-6 * size, "s {s}, d {d}, t {t}: {got:?} {want:?}");
            }
        }
    }

    #[test]
    fn its_derivatives_are_those_of_where_it_comes_to() {
        let start = (6.0, -0.3);
        for (s, d) in CASES {
            for t in TIMES_S {
                let at = |s: f64, d: f64| Response::after(t, s, d).carried(start);
                let got = Response::after(t, s, d).by_parameters(start);
                let (ds, dd) = (1e-5 * s, 1e-5 * (fabs(d) + sqrt(s)));
                let ratio = |(a, b): (Pair, Pair), h: f64| {
                    ((a.0 - b.0) / (2.0 * h), (a.1 - b.1) / (2.0 * h))
                };
                let want = [
                    ratio((at(s + ds, d), at(s - ds, d)), ds),
                    ratio((at(s, d + dd), at(s, d - dd)), dd),
                ];
                for (got, want) in got.into_iter().zip(want) {
                    let size = (fabs(want.0) + fabs(want.1)) + 6.0 * t * t;
                    let off = fabs(got.0 - want.0) + fabs(got.1 - want.1);
                    // Central differences err by (1e-5·phase)², and by rounding over 1e-5.
                    assert!(off <= 1e-5 * size, "s {s}, d {d}, t {t}: {got:?} {want:?}");
                }
            }
        }
    }

    #[test]
    fn no_time_is_too_long() {
        for (s, d) in [(1.7e-4, 8e-4), (0.01, 3.0), (0.3, 1.095_445_115)] {
            let response = Response::after(1e9, s, d);
            let (angle, rate) = response.carried((6.0, 1.0));
            assert!(fabs(angle) + fabs(rate) < 1e-200, "{angle} {rate}");
            let finite = |(a, w): Pair| a.is_finite() && w.is_finite();
            assert!(response.by_parameters((6.0, 1.0)).into_iter().all(finite));
        }
    }
}
