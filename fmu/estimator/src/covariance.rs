//! Symmetric 2×2 covariance of (angle, rate): three numbers, so it cannot lose its symmetry.

use crate::checks::in_range;
use crate::{EstimatorError, Transition};

/// Covariance P of (angle, rate).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Covariance {
    /// Variance of the angle, rad².
    pub angle_rad2: f64,
    /// Covariance of angle and rate, rad²/s.
    pub cross_rad2_s: f64,
    /// Variance of the rate, rad²/s².
    pub rate_rad2_s2: f64,
}

/// Kalman gain for a measured rate: (s, 1).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Gain {
    pub(crate) angle_s: f64,
    pub(crate) rate: f64,
}

impl Covariance {
    /// Independent angle and rate.
    #[must_use]
    pub const fn diagonal(angle_rad2: f64, rate_rad2_s2: f64) -> Self {
        Self { angle_rad2, cross_rad2_s: 0.0, rate_rad2_s2 }
    }

    /// Angle and rate known for certain.
    pub(crate) const ZERO: Self = Self::diagonal(0.0, 0.0);

    /// The sum of two.
    ///
    /// # Errors
    /// [`EstimatorError::Overflow`] when it leaves the range of floating point.
    pub(crate) fn plus(self, other: Self) -> Result<Self, EstimatorError> {
        Ok(Self {
            angle_rad2: in_range(self.angle_rad2 + other.angle_rad2)?,
            cross_rad2_s: in_range(self.cross_rad2_s + other.cross_rad2_s)?,
            rate_rad2_s2: in_range(self.rate_rad2_s2 + other.rate_rad2_s2)?,
        })
    }

    /// P⁻ = Φ·P·Φᵀ + q·Q, with Q the transition's noise for unit density.
    #[inline]
    pub(crate) fn predicted(self, t: &Transition, q_rad2_s3: f64) -> Result<Self, EstimatorError> {
        let Self { angle_rad2: a, cross_rad2_s: b, rate_rad2_s2: c } = self;
        // Rows of Φ·P, the one of the rate first, then each against the rows of Φ. The second
        // column is judged early although the sums below would show it: see `in_range`.
        let rb = in_range(t.f21 * b + t.f22 * c)?;
        let ra = t.f21 * a + t.f22 * b;
        let rate_rad2_s2 = in_range(ra * t.f21 + rb * t.f22 + q_rad2_s3 * t.q22)?;
        let tb = in_range(t.f11 * b + t.f12 * c)?;
        let ta = t.f11 * a + t.f12 * b;
        let cross_rad2_s = in_range(ta * t.f21 + tb * t.f22 + q_rad2_s3 * t.q12)?;
        let angle_rad2 = in_range(ta * t.f11 + tb * t.f12 + q_rad2_s3 * t.q11)?;
        Ok(Self { angle_rad2, cross_rad2_s, rate_rad2_s2 })
    }

    /// Measurement update in Joseph form, P⁺ = (I − K·H)·P·(I − K·H)ᵀ + K·R·Kᵀ with H = (0 1).
    ///
    /// Joseph, because it is a sum of two positive semi-definite terms and stays one under
    /// rounding, where a − b²/S may cancel below zero.
    ///
    /// # Source
    /// Bucy and Joseph, *Filtering for Stochastic Processes*, 1968.
    #[inline]
    pub(crate) fn updated(self, gain: Gain, r_rad2_s2: f64) -> Result<Self, EstimatorError> {
        let Self { angle_rad2: a, cross_rad2_s: b, rate_rad2_s2: c } = self;
        let (k1, k2) = (gain.angle_s, gain.rate);
        let mixed = b - k1 * c;
        let angle_rad2 = in_range((a - k1 * b) - k1 * mixed + k1 * r_rad2_s2 * k1)?;
        let keep = 1.0 - k2;
        let cross_rad2_s = in_range(mixed * keep + k1 * r_rad2_s2 * k2)?;
        let rate_rad2_s2 = in_range(keep * c * keep + k2 * r_rad2_s2 * k2)?;
        Ok(Self { angle_rad2, cross_rad2_s, rate_rad2_s2 })
    }

    /// Determinant ≥ 0 and diagonal ≥ 0, up to the rounding of the determinant itself.
    #[must_use]
    pub fn is_positive_semidefinite(&self) -> bool {
        let product = self.angle_rad2 * self.rate_rad2_s2;
        let determinant = product - self.cross_rad2_s * self.cross_rad2_s;
        self.angle_rad2 >= 0.0
            && self.rate_rad2_s2 >= 0.0
            && determinant >= -4.0 * f64::EPSILON * product
    }
}
