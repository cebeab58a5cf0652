//! Covariance refinement: every N samples the filter's covariance is replaced by one estimated
//! from its own recent surprises.
//!
//! The papers' Table 3 defines it, and its literal text does not reproduce the papers' own
//! results: with q = x⁺ − Φ·x⁺ the estimated covariance is K·S·Kᵀ, and each insertion extinguishes
//! the gain faster. Two readings are kept and named.

use crate::checks::in_range;
use crate::{Covariance, EstimatorError};

/// How many samples are averaged before an insertion, and what is averaged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Refinement {
    /// Samples per insertion, the papers' N; 0 switches the refinement off.
    pub samples: u32,
    /// Which reading of the papers is used.
    pub reading: Reading,
}

impl Refinement {
    /// No refinement.
    pub const OFF: Self = Self { samples: 0, reading: Reading::M6 };
}

/// Readings of the papers' covariance refinement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Reading {
    /// The literal text: q = x⁺ − Φ·x⁺(previous); P ← mean(q·qᵀ).
    M0,
    /// q = (integral of the rate − predicted angle, innovation); P ← diag(mean(q·qᵀ)).
    ///
    /// An interpretation: it agrees best with what the papers show, but no line of theirs says
    /// "diagonal".
    M6,
}

/// Running sums of q·qᵀ.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Accumulator {
    pub(crate) angle_rad2: f64,
    pub(crate) cross_rad2_s: f64,
    pub(crate) rate_rad2_s2: f64,
    pub(crate) count: u32,
}

impl Accumulator {
    /// Adds one q; returns the mean of q·qᵀ and starts afresh when `samples` are in.
    ///
    /// # Errors
    /// [`EstimatorError::Overflow`] when q is too large to be squared and summed.
    #[inline]
    pub(crate) fn add(
        &mut self,
        q_angle_rad: f64,
        q_rate_rad_s: f64,
        samples: u32,
    ) -> Result<Option<Covariance>, EstimatorError> {
        self.angle_rad2 += q_angle_rad * q_angle_rad;
        self.cross_rad2_s += q_angle_rad * q_rate_rad_s;
        self.rate_rad2_s2 += q_rate_rad_s * q_rate_rad_s;
        // The two squares bound the cross term.
        in_range(self.angle_rad2 + self.rate_rad2_s2)?;
        // Restored bytes may hold any count.
        self.count = self.count.saturating_add(1);
        if self.count < samples {
            return Ok(None);
        }
        let n = f64::from(self.count);
        let mean = Covariance {
            angle_rad2: self.angle_rad2 / n,
            cross_rad2_s: self.cross_rad2_s / n,
            rate_rad2_s2: self.rate_rad2_s2 / n,
        };
        *self = Self::default();
        Ok(Some(mean))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_comes_with_the_last_sample_and_then_all_starts_afresh() {
        let mut collected = Accumulator::default();
        assert_eq!(collected.add(3.0, 1.0, 2), Ok(None));
        let mean = Covariance { angle_rad2: 5.0, cross_rad2_s: 2.5, rate_rad2_s2: 2.5 };
        assert_eq!(collected.add(1.0, 2.0, 2), Ok(Some(mean)));
        assert_eq!(collected, Accumulator::default());
    }

    #[test]
    fn a_surprise_too_large_to_be_squared_is_refused() {
        let overflow = Err(EstimatorError::Overflow);
        assert_eq!(Accumulator::default().add(1e160, 0.0, 100), overflow);
        assert_eq!(Accumulator::default().add(0.0, 1e160, 100), overflow);
    }

    #[test]
    fn a_restored_count_of_any_size_only_ends_the_collection() {
        let mut restored = Accumulator { count: u32::MAX, ..Accumulator::default() };
        assert!(restored.add(1.0, 1.0, 100).unwrap().is_some());
        assert_eq!(restored, Accumulator::default());
    }
}
