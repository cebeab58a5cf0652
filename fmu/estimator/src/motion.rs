//! The motions that the filters assume, as exact transitions over a span of time.

use crate::config::{ConfigError, positive};

/// Transition Φ of (angle, rate) over a span, and the covariance Q that white angular
/// acceleration of unit density adds over it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transition {
    /// Angle from angle.
    pub f11: f64,
    /// Angle from rate, s.
    pub f12: f64,
    /// Rate from angle, 1/s.
    pub f21: f64,
    /// Rate from rate.
    pub f22: f64,
    /// Angle variance per unit density, s³.
    pub q11: f64,
    /// Covariance per unit density, s².
    pub q12: f64,
    /// Rate variance per unit density, s.
    pub q22: f64,
}

/// A linear time-invariant motion of (angle, rate).
pub trait Motion {
    /// The exact transition over `span_s` seconds.
    fn transition(&self, span_s: f64) -> Transition;
}

/// Constant rate: the papers' "permanent rotation", φ″ = 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PermanentRotation;

/// Undamped torsion of known period: φ″ = −Ω²·φ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TorsionalOscillation {
    omega_rad_s: f64,
}

impl TorsionalOscillation {
    /// Torsion with the given period, s.
    ///
    /// # Errors
    /// [`ConfigError`] when the period is not finite and positive.
    pub fn with_period(period_s: f64) -> Result<Self, ConfigError> {
        positive("period_s", period_s)?;
        let omega_rad_s = core::f64::consts::TAU / period_s;
        // A period so short or long that Ω² leaves the floating-point range is no motion either.
        if omega_rad_s * omega_rad_s * omega_rad_s == 0.0
            || !(omega_rad_s * omega_rad_s * omega_rad_s).is_finite()
        {
            let bound = "between 1e-100 and 1e100 s";
            return Err(ConfigError { name: "period_s", value: period_s, bound });
        }
        Ok(Self { omega_rad_s })
    }

    /// Ω, rad/s.
    #[must_use]
    pub fn omega_rad_s(&self) -> f64 {
        self.omega_rad_s
    }
}

impl Motion for PermanentRotation {
    #[inline]
    fn transition(&self, span_s: f64) -> Transition {
        let h = span_s;
        Transition {
            f11: 1.0,
            f12: h,
            f21: 0.0,
            f22: 1.0,
            q11: h * h * h / 3.0,
            q12: h * h / 2.0,
            q22: h,
        }
    }
}

impl Motion for TorsionalOscillation {
    /// # Source
    /// Φ is the solution of φ″ = −Ω²φ; Q = ∫Φ·(0 1)ᵀ(0 1)·Φᵀ dt, checked against Van Loan's
    /// matrix exponential in the tests.
    #[inline]
    fn transition(&self, span_s: f64) -> Transition {
        let omega = self.omega_rad_s;
        let (sin, cos) = libm::sincos(omega * span_s);
        Transition {
            f11: cos,
            f12: sin / omega,
            f21: -omega * sin,
            f22: cos,
            q11: twice_angle_deficit(omega, span_s) / (2.0 * omega * omega),
            q12: sin * sin / (2.0 * omega * omega),
            q22: (span_s + libm::sin(2.0 * omega * span_s) / (2.0 * omega)) / 2.0,
        }
    }
}

/// h − sin(2Ωh)/(2Ω), s, without the cancellation that the plain form suffers when Ω·h is small:
/// at Ω·h = 1e-4 it would keep only half of its digits.
fn twice_angle_deficit(omega_rad_s: f64, h_s: f64) -> f64 {
    let u = 2.0 * omega_rad_s * h_s;
    if u.abs() > 0.5 {
        return h_s - libm::sin(u) / (2.0 * omega_rad_s);
    }
    // u − sin u = u³/3!·(1 − u²/(4·5)·(1 − u²/(6·7)·(…))); ten factors reach 1e-17 at u = 0.5.
    let mut series = 1.0;
    for k in (1..=9).rev() {
        let n = f64::from(2 * k + 2);
        series = 1.0 - u * u / (n * (n + 1.0)) * series;
    }
    u * u * u / 6.0 * series / (2.0 * omega_rad_s)
}
