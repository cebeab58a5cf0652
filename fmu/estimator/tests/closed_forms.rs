//! The closed-form predictions against the differential equations they solve.

use nalgebra::{Matrix2, Matrix4};
use proptest::prelude::*;
use struna_estimator::{Motion, PermanentRotation, TorsionalOscillation, Transition};

/// F of x′ = F·x for a motion with φ″ = −Ω²·φ; Ω = 0 is constant rate.
fn dynamics(omega_rad_s: f64) -> Matrix2<f64> {
    Matrix2::new(0.0, 1.0, -omega_rad_s * omega_rad_s, 0.0)
}

/// Van Loan's block exponential: (Φ, Q) for white acceleration of unit density over `h_s`.
fn van_loan(omega_rad_s: f64, h_s: f64) -> (Matrix2<f64>, Matrix2<f64>) {
    let f = dynamics(omega_rad_s);
    let mut block = Matrix4::zeros();
    block.fixed_view_mut::<2, 2>(0, 0).copy_from(&(-f * h_s));
    block[(1, 3)] = h_s;
    block.fixed_view_mut::<2, 2>(2, 2).copy_from(&(f.transpose() * h_s));
    let e = block.exp();
    let phi = e.fixed_view::<2, 2>(2, 2).transpose();
    (phi, phi * e.fixed_view::<2, 2>(0, 2))
}

fn assert_matches_van_loan(t: &Transition, omega_rad_s: f64, h_s: f64) {
    let (phi, q) = van_loan(omega_rad_s, h_s);
    let pairs = [
        ("f11", t.f11, phi[(0, 0)], 1.0),
        ("f12", t.f12, phi[(0, 1)], h_s),
        ("f21", t.f21, phi[(1, 0)], omega_rad_s.max(1e-300)),
        ("f22", t.f22, phi[(1, 1)], 1.0),
        ("q11", t.q11, q[(0, 0)], h_s * h_s * h_s),
        ("q12", t.q12, q[(0, 1)], h_s * h_s),
        ("q22", t.q22, q[(1, 1)], h_s),
    ];
    for (name, ours, theirs, scale) in pairs {
        // 1e-12 of each entry's natural size: the Padé exponential itself is good to a few 1e-14
        // per squaring, and spans up to one radian need none to a few of them.
        assert!((ours - theirs).abs() <= 1e-12 * scale, "{name}: {ours:e} against {theirs:e}");
    }
}

#[test]
fn constant_rate_matches_van_loan() {
    for h_s in [1e-3, 1e-2, 0.5, 3.0] {
        assert_matches_van_loan(&PermanentRotation.transition(h_s), 0.0, h_s);
    }
}

/// Q11 is a small difference of large terms; a series keeps it exact where Van Loan's exponential,
/// which adds the block's 1 to it, cannot judge. Here against the Taylor series of Q11 itself.
#[test]
fn the_angle_noise_keeps_its_digits_at_a_hundred_hertz() {
    let (period_s, h_s) = (480.0, 0.01_f64);
    let motion = TorsionalOscillation::with_period(period_s).unwrap();
    let omega_rad_s = motion.omega_rad_s();
    let exact = h_s.powi(3) / 3.0 * (1.0 - (omega_rad_s * h_s).powi(2) / 5.0);
    let ours = motion.transition(h_s).q11;
    // The next term of the series is (Ω·h)⁴·2/105 = 6e-18 of the whole.
    assert!((ours / exact - 1.0).abs() < 4.0 * f64::EPSILON, "{ours:e} against {exact:e}");
}

/// P′ = F·P + P·Fᵀ + diag(0, q), fourth-order Runge-Kutta with `steps` steps.
fn lyapunov(omega_rad_s: f64, q: f64, p0: Matrix2<f64>, span_s: f64, steps: u32) -> Matrix2<f64> {
    let f = dynamics(omega_rad_s);
    let noise = Matrix2::new(0.0, 0.0, 0.0, q);
    let rhs = |p: Matrix2<f64>| f * p + p * f.transpose() + noise;
    let h = span_s / f64::from(steps);
    (0..steps).fold(p0, |p, _| {
        let k1 = rhs(p);
        let k2 = rhs(p + k1 * (h / 2.0));
        let k3 = rhs(p + k2 * (h / 2.0));
        let k4 = rhs(p + k3 * h);
        p + (k1 + 2.0 * k2 + 2.0 * k3 + k4) * (h / 6.0)
    })
}

proptest! {
    #[test]
    fn torsion_matches_van_loan(period_s in 0.5_f64..1000.0, h_s in 1e-3_f64..0.08) {
        let motion = TorsionalOscillation::with_period(period_s).unwrap();
        assert_matches_van_loan(&motion.transition(h_s), motion.omega_rad_s(), h_s);
    }

    #[test]
    fn the_predicted_covariance_solves_its_differential_equation(
        omega_rad_s in 0.05_f64..3.0,
        span_s in 0.1_f64..2.0,
        (root_a, root_b, root_c) in (0.1_f64..2.0, -1.0_f64..1.0, 0.1_f64..2.0),
        q in 0.0_f64..1.0,
    ) {
        let root = Matrix2::new(root_a, root_b, 0.0, root_c);
        let p0 = root * root.transpose();
        let motion =
            TorsionalOscillation::with_period(std::f64::consts::TAU / omega_rad_s).unwrap();
        let t = motion.transition(span_s);
        let phi = Matrix2::new(t.f11, t.f12, t.f21, t.f22);
        let noise = Matrix2::new(t.q11, t.q12, t.q12, t.q22);
        let ours = phi * p0 * phi.transpose() + noise * q;
        let reference = lyapunov(omega_rad_s, q, p0, span_s, 2000);
        // RK4 at h·Ω ≤ 3e-3 is good to (h·Ω)⁴ ≈ 1e-10 of P, whose entries stay below 100.
        prop_assert!((ours - reference).abs().max() < 1e-8, "{ours} against {reference}");
    }
}
