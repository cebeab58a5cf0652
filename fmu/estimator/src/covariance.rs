//! Symmetric 2×2 covariance of (angle, rate): three numbers, so it cannot lose its symmetry.

use crate::EstimatorError;
use crate::checks::in_range;

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

    /// The covariance after a measurement of the rate with variance `r_rad2_s2`, where `inverse` is
    /// 1/S and S = c + R: P⁺ = P − P·Hᵀ·H·P/S with H = (0 1), written as
    /// P⁺ = (R/S)·P + (det P/S)·(1 0)ᵀ(1 0).
    ///
    /// With P positive semi-definite both terms are, and rounding cannot make the second less: no
    /// difference is left that could cancel below zero, as a − b²/S may. What Joseph's form gives
    /// for any gain this gives for the optimal one, with half the operations; and next to all
    /// of them can be done while the division is on its way.
    #[inline(always)]
    pub(crate) fn updated(self, r_rad2_s2: f64, inverse: f64) -> Result<Self, EstimatorError> {
        Ok(Self {
            rate_rad2_s2: in_range(self.rate_variance_updated(r_rad2_s2, inverse))?,
            cross_rad2_s: in_range(self.cross_updated(r_rad2_s2, inverse))?,
            angle_rad2: in_range(self.angle_variance_updated(r_rad2_s2, inverse))?,
        })
    }

    #[inline(always)]
    pub(crate) fn rate_variance_updated(&self, r_rad2_s2: f64, inverse: f64) -> f64 {
        self.rate_rad2_s2 * r_rad2_s2 * inverse
    }

    #[inline(always)]
    pub(crate) fn cross_updated(&self, r_rad2_s2: f64, inverse: f64) -> f64 {
        self.cross_rad2_s * r_rad2_s2 * inverse
    }

    #[inline(always)]
    pub(crate) fn angle_variance_updated(&self, r_rad2_s2: f64, inverse: f64) -> f64 {
        let square = self.cross_rad2_s * self.cross_rad2_s;
        let determinant = self.angle_rad2 * self.rate_rad2_s2 - square;
        // Not `max`, which would make a zero of NaN.
        let determinant = if 0.0 > determinant { 0.0 } else { determinant };
        (self.angle_rad2 * r_rad2_s2 + determinant) * inverse
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_update_is_the_textbooks_where_nothing_is_rounded() {
        let p = Covariance { angle_rad2: 2.0, cross_rad2_s: 1.0, rate_rad2_s2: 1.0 };
        // a − b²/S, b·R/S and c·R/S with S = 2.
        let updated = Covariance { angle_rad2: 1.5, cross_rad2_s: 0.5, rate_rad2_s2: 0.5 };
        assert_eq!(p.updated(1.0, 0.5), Ok(updated));
    }

    /// Angle and rate that go together to the last digit, and the last digit on the wrong side.
    #[test]
    fn a_determinant_rounded_below_zero_takes_nothing_off_the_angles_variance() {
        let p = Covariance { angle_rad2: 1.0, cross_rad2_s: 1.0 + 1e-15, rate_rad2_s2: 1.0 };
        let r_rad2_s2 = 1e-20;
        let updated = p.updated(r_rad2_s2, 1.0 / (1.0 + r_rad2_s2)).unwrap();
        assert_eq!(updated.angle_rad2.to_bits(), r_rad2_s2.to_bits());
    }

    #[test]
    fn a_determinant_that_is_no_number_is_refused() {
        let p = Covariance { angle_rad2: 1e200, cross_rad2_s: 1e200, rate_rad2_s2: 1e200 };
        assert_eq!(p.updated(1.0, 1e-200), Err(EstimatorError::Overflow));
    }
}
