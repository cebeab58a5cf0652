//! What one gyro on a swinging body measures.

use crate::EstimatorError;

/// The rate that a gyro of one axis is expected to tell, h = g·ω + b, and its derivatives.
///
/// g = (g₁, g₂, √(1 − g₁² − g₂²)) is the input axis in body axes. The derivative by the bias b is
/// one, those by attitude, twist and the parameters of the motion are zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExpectedRate {
    /// The rate, rad/s.
    pub rate_rad_s: f64,
    /// Derivatives by the three body rates: the input axis itself.
    pub by_omega: [f64; 3],
    /// Derivatives by g₁ and g₂, rad/s.
    pub by_tilt: [f64; 2],
}

impl ExpectedRate {
    /// What is expected at body rates `omega_rad_s`, body axes, of a gyro with the given axis and
    /// bias.
    ///
    /// # Errors
    /// [`EstimatorError::Overflow`] when g₁ and g₂ are those of no axis that looks along z.
    #[inline(always)]
    pub fn new(
        omega_rad_s: [f64; 3],
        tilt_b_rad: [f64; 2],
        bias_rad_s: f64,
    ) -> Result<Self, EstimatorError> {
        let ([p, q, r], [x, y]) = (omega_rad_s, tilt_b_rad);
        let along = 1.0 - (x * x + y * y);
        if along.is_nan() || along <= 0.0 {
            return Err(EstimatorError::Overflow);
        }
        let z = libm::sqrt(along);
        let slope = r / z;
        Ok(Self {
            rate_rad_s: x * p + y * q + z * r + bias_rad_s,
            by_omega: [x, y, z],
            by_tilt: [p - slope * x, q - slope * y],
        })
    }
}
