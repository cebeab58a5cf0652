//! Damped torsion about a fixed axis, in closed form.

use crate::Body;

/// Twist of a body that hangs straight: C·τ″ = −k·τ − c·τ′, solved exactly.
///
/// The limit of the full equations without swing, and so the oracle of their integrators. Valid
/// for under-, over- and critically damped strings and for a string without stiffness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DampedTorsion {
    /// Ω², 1/s².
    stiffness_rate_s2: f64,
    /// Decay rate c/(2C), 1/s.
    decay_rate_s: f64,
    twist_rad: f64,
    twist_rate_rad_s: f64,
}

impl DampedTorsion {
    /// Torsion of `body` from the twist and twist rate at time zero.
    #[must_use]
    pub fn new(body: &Body, twist_rad: f64, twist_rate_rad_s: f64) -> Self {
        let axial_kg_m2 = body.params().inertia_kg_m2[2];
        Self {
            stiffness_rate_s2: body.stiffness_n_m_rad() / axial_kg_m2,
            decay_rate_s: 0.5 * body.damping_n_m_s_rad() / axial_kg_m2,
            twist_rad,
            twist_rate_rad_s,
        }
    }

    /// Twist τ at `time_s`, rad.
    #[must_use]
    pub fn twist_rad(&self, time_s: f64) -> f64 {
        let (even, odd_s) = self.modes(time_s);
        let a = self.decay_rate_s;
        self.twist_rad * (even + a * odd_s) + self.twist_rate_rad_s * odd_s
    }

    /// Twist rate τ′ at `time_s`, rad/s.
    #[must_use]
    pub fn twist_rate_rad_s(&self, time_s: f64) -> f64 {
        let (even, odd_s) = self.modes(time_s);
        let a = self.decay_rate_s;
        self.twist_rate_rad_s * (even - a * odd_s) - self.stiffness_rate_s2 * self.twist_rad * odd_s
    }

    /// e^{−at}·cos(w t) and e^{−at}·sin(w t)/w with w² = Ω² − a², continued to w² ≤ 0.
    fn modes(&self, time_s: f64) -> (f64, f64) {
        let a = self.decay_rate_s;
        let w2 = self.stiffness_rate_s2 - a * a;
        if w2 > 0.0 {
            let w = w2.sqrt();
            let (sin, cos) = (w * time_s).sin_cos();
            let envelope = (-a * time_s).exp();
            return (envelope * cos, envelope * sin / w);
        }
        let w = (-w2).sqrt();
        if w == 0.0 {
            let envelope = (-a * time_s).exp();
            return (envelope, envelope * time_s);
        }
        // w − a written without cancellation; the products never overflow, unlike cosh(w t).
        let slow = (-self.stiffness_rate_s2 / (w + a) * time_s).exp();
        let ratio_m1 = (-2.0 * w * time_s).exp_m1();
        (slow * (1.0 + 0.5 * ratio_m1), -slow * ratio_m1 / (2.0 * w))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BodyParams, Torsion, TorsionDamping, TorsionStiffness, reference::PARAMS};

    fn torsion(stiffness: TorsionStiffness, damping: TorsionDamping) -> DampedTorsion {
        let params = BodyParams { torsion: Torsion { stiffness, damping }, ..PARAMS };
        DampedTorsion::new(&Body::new(&params).unwrap(), 2.0, -0.03)
    }

    fn with_ratio(ratio: f64) -> DampedTorsion {
        torsion(TorsionStiffness::PeriodS(20.0), TorsionDamping::Ratio(ratio))
    }

    /// Derivative by five-point central differences, error h⁴/30 times the fifth derivative.
    fn slope(f: impl Fn(f64) -> f64, time_s: f64, h: f64) -> f64 {
        let odd = |h: f64| f(time_s + h) - f(time_s - h);
        (8.0 * odd(h) - odd(2.0 * h)) / (12.0 * h)
    }

    #[test]
    fn the_closed_form_satisfies_its_own_equation_in_every_regime() {
        for ratio in [0.0, 0.1, 0.999_999, 1.0, 1.000_001, 3.0, 50.0] {
            let t = with_ratio(ratio);
            let (a, k) = (t.decay_rate_s, t.stiffness_rate_s2);
            // The fastest rate in the solution, and differences fine on its scale.
            let fastest = a + (a * a - k).abs().sqrt();
            let h = 1e-2 / fastest;
            // Differences err by (h·fastest)⁴/30 = 3e-10 of the amplitude, below 2.1 rad, times
            // 5 near critical damping, where the fifth derivative of t·e^{−at} is 5a⁴ at zero.
            let tolerance = 3.5e-10 * 2.1 * 5.0 * fastest;
            for time_s in [0.0, 0.7, 13.0, 300.0] {
                let rate = t.twist_rate_rad_s(time_s);
                let twist_slope = slope(|s| t.twist_rad(s), time_s, h);
                assert!((twist_slope - rate).abs() < tolerance, "ratio {ratio}, {time_s} s");
                let bend = slope(|s| t.twist_rate_rad_s(s), time_s, h);
                let residual = bend + 2.0 * a * rate + k * t.twist_rad(time_s);
                assert!(residual.abs() < tolerance * fastest, "ratio {ratio}, {time_s} s");
            }
        }
    }

    #[test]
    fn the_start_is_met_exactly() {
        for ratio in [0.0, 0.5, 1.0, 2.0] {
            let t = with_ratio(ratio);
            assert_eq!((t.twist_rad(0.0), t.twist_rate_rad_s(0.0)), (2.0, -0.03), "{ratio}");
        }
    }

    #[test]
    fn the_regimes_join_at_critical_damping() {
        let (below, at, above) = (with_ratio(1.0 - 1e-9), with_ratio(1.0), with_ratio(1.0 + 1e-9));
        for time_s in [1.0, 5.0, 20.0] {
            // The twist changes by less than τ0·Ωt·e^{−Ωt}·1e-9 < 1e-9 rad over this change of ζ.
            assert!((below.twist_rad(time_s) - at.twist_rad(time_s)).abs() < 1e-9);
            assert!((above.twist_rad(time_s) - at.twist_rad(time_s)).abs() < 1e-9);
        }
    }

    #[test]
    fn a_string_without_stiffness_lets_the_body_coast() {
        let free =
            torsion(TorsionStiffness::ConstantNMRad(0.0), TorsionDamping::CoefficientNMSRad(0.0));
        assert!((free.twist_rad(100.0) - (2.0 - 3.0)).abs() < 1e-14);
        let braked =
            torsion(TorsionStiffness::ConstantNMRad(0.0), TorsionDamping::CoefficientNMSRad(0.012));
        // c/C = 1/s: the body stops after turning by rate · 1 s.
        assert!((braked.twist_rad(1e3) - (2.0 - 0.03)).abs() < 1e-14);
        assert!(braked.twist_rate_rad_s(1e3).abs() < 1e-300);
    }
}
