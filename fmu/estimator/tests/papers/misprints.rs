//! Formulas of the papers as printed and as they must be, against the differential equations.
//!
//! Each printed form is shown to miss by far more than the corrected one, so that nobody corrects
//! it back. State x = (φ, ω), covariance P = (a, b; b, c), both given at t₀.

use std::f64::consts::{PI, TAU};
use struna_estimator::{Motion, PermanentRotation, TorsionalOscillation, Transition};

const FROM_S: f64 = 1.3;
const TO_S: f64 = 3.1;
const OMEGA_RAD_S: f64 = 0.9;
/// (φ, ω) at the start.
const STATE: [f64; 2] = [0.7, -1.1];
/// (a, b, c) at the start: positive definite.
const COVARIANCE: [f64; 3] = [0.8, -0.3, 0.5];
/// Of x′ = F·x and of P′ = F·P + P·Fᵀ by 2000 Runge-Kutta steps of 1e-3: the error of each is some
/// (Ω·h)⁴ = 1e-12, and what is compared is of order 1.
const EXACT: f64 = 1e-11;

fn runge_kutta<const N: usize>(start: [f64; N], slope: impl Fn([f64; N]) -> [f64; N]) -> [f64; N] {
    let steps = 2000;
    let h = (TO_S - FROM_S) / f64::from(steps);
    let along = |x: [f64; N], k: [f64; N], h: f64| std::array::from_fn(|i| x[i] + h * k[i]);
    (0..steps).fold(start, |x, _| {
        let k1 = slope(x);
        let k2 = slope(along(x, k1, h / 2.0));
        let k3 = slope(along(x, k2, h / 2.0));
        let k4 = slope(along(x, k3, h));
        std::array::from_fn(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]))
    })
}

/// (φ, ω) at the end, with φ″ = −s·φ.
fn true_state(s: f64) -> [f64; 2] {
    runge_kutta(STATE, |[angle, rate]| [rate, -s * angle])
}

/// (a, b, c) at the end. Without a measurement's term this is a Lyapunov equation, not Riccati's.
fn true_covariance(s: f64) -> [f64; 3] {
    runge_kutta(COVARIANCE, |[a, b, c]| [2.0 * b, c - s * a, -2.0 * s * b])
}

fn off<const N: usize>(x: [f64; N], y: [f64; N]) -> f64 {
    x.iter().zip(y).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

/// The filter's own prediction of (a, b, c).
fn predicted(t: &Transition) -> [f64; 3] {
    let [a, b, c] = COVARIANCE;
    let (ta, tb) = (t.f11 * a + t.f12 * b, t.f11 * b + t.f12 * c);
    let (ra, rb) = (t.f21 * a + t.f22 * b, t.f21 * b + t.f22 * c);
    [ta * t.f11 + tb * t.f12, ta * t.f21 + tb * t.f22, ra * t.f21 + rb * t.f22]
}

#[test]
fn the_state_at_constant_rate_has_c1_for_its_rate() {
    let (c1, c2) = (STATE[1], STATE[0] - STATE[1] * FROM_S);
    let (printed, corrected) = ([c1 * TO_S + c2, c2], [c1 * TO_S + c2, c1]);
    assert!(off(corrected, true_state(0.0)) < EXACT);
    assert!(off(printed, true_state(0.0)) > 1.0, "{printed:?}");
}

#[test]
fn the_covariance_at_constant_rate_is_right_as_printed() {
    let [a0, b0, c0] = COVARIANCE;
    let h = TO_S - FROM_S;
    let printed = [a0 + 2.0 * b0 * h + c0 * h * h, b0 + c0 * h, c0];
    assert!(off(printed, true_covariance(0.0)) < EXACT);
    assert!(off(printed, predicted(&PermanentRotation.transition(h))) < EXACT);
}

#[test]
fn the_torsional_state_is_right_as_printed() {
    let w = OMEGA_RAD_S;
    let (sin0, cos0) = (w * FROM_S).sin_cos();
    let c1 = STATE[0] * cos0 - STATE[1] / w * sin0;
    let c2 = STATE[0] * sin0 + STATE[1] / w * cos0;
    let (sin, cos) = (w * TO_S).sin_cos();
    let printed = [c1 * cos + c2 * sin, -w * c1 * sin + w * c2 * cos];
    assert!(off(printed, true_state(w * w)) < EXACT);
}

/// (a, b, c) at the end from C₁, C₂, C₃ with `factor` before C₂ in a and c.
fn torsional_covariance([c1, c2, c3]: [f64; 3], factor: f64) -> [f64; 3] {
    let w = OMEGA_RAD_S;
    let (sin, cos) = (2.0 * w * TO_S).sin_cos();
    [
        c1 / w * sin - factor * c2 / w * cos + c3,
        c1 * cos + c2 * sin,
        -c1 * w * sin + factor * c2 * w * cos + w * w * c3,
    ]
}

#[test]
fn the_torsional_covariance_needs_both_its_corrections() {
    let w = OMEGA_RAD_S;
    let [a0, b0, c0] = COVARIANCE;
    let (sin0, cos0) = (2.0 * w * FROM_S).sin_cos();
    let c1 = a0 * w / 2.0 * sin0 + b0 * cos0 - c0 / (2.0 * w) * sin0;
    let c3 = a0 / 2.0 + c0 / (2.0 * w * w);
    let printed_c2 = -a0 * w / 2.0 * sin0 + b0 * cos0 + c0 / (2.0 * w) * sin0;
    let c2 = -a0 * w / 2.0 * cos0 + b0 * sin0 + c0 / (2.0 * w) * cos0;
    let truth = true_covariance(w * w);
    let motion = TorsionalOscillation::with_period(TAU / w).unwrap();
    let corrected = torsional_covariance([c1, c2, c3], 1.0);
    assert!(off(corrected, truth) < EXACT, "{corrected:?} {truth:?}");
    assert!(off(corrected, predicted(&motion.transition(TO_S - FROM_S))) < EXACT);
    for (c2, factor) in [(printed_c2, 2.0), (printed_c2, 1.0), (c2, 2.0)] {
        let missed = off(torsional_covariance([c1, c2, c3], factor), truth);
        assert!(missed > 0.1, "{missed}");
    }
}

/// b/(c + R) and c/(c + R) are a gain, not a covariance, and as one they never fall: with them the
/// filter follows the raw rate for ever, while the papers' own plots fall to zero.
#[test]
fn the_updated_covariance_is_r_times_the_gain() {
    let [a, b, c] = COVARIANCE;
    let r = 4e-4;
    let s = c + r;
    let keep = nalgebra::Matrix2::new(1.0, -b / s, 0.0, 1.0 - c / s);
    let optimal = keep * nalgebra::Matrix2::new(a, b, b, c);
    let corrected = [a - b * b / s, b * r / s, c * r / s];
    let from_matrix = [optimal[(0, 0)], optimal[(0, 1)], optimal[(1, 1)]];
    // Cancellation of terms of order 1.
    assert!(off(corrected, from_matrix) < 1e-15);
    assert!(off([a - b * b / s, b / s, c / s], from_matrix) > 0.1);
    let (mut printed, mut right) = (1.0_f64, 1.0_f64);
    for _ in 0..1000 {
        printed /= printed + r;
        right *= r / (right + r);
    }
    assert!((printed - (1.0 - r)).abs() < 1e-12, "{printed}");
    assert!((right * (1000.0 + r) / r - 1.0).abs() < 1e-12, "{right}");
}

/// The diameters said to be for a safety factor of 1.5 are those for 2.
#[test]
fn the_strings_diameters_are_for_a_safety_factor_of_two() {
    let (mass_kg, g_m_s2) = (1.0, 9.81);
    let least_mm = |factor: f64, strength_pa: f64| {
        1e3 * (4.0 * factor * mass_kg * g_m_s2 / (PI * strength_pa)).sqrt()
    };
    for (strength_pa, printed_mm, at_1_5_mm) in [(200e6, 0.35, 0.306), (900e6, 0.17, 0.144)] {
        // Half of the last digit given.
        assert!((least_mm(2.0, strength_pa) - printed_mm).abs() < 0.005);
        assert!((least_mm(1.5, strength_pa) - at_1_5_mm).abs() < 0.0005);
    }
}
