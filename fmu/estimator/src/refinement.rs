//! Covariance refinement: every N samples the filter estimates a covariance from its own recent
//! surprises and puts it in place of the one it has.
//!
//! The papers' Table 3 defines it, and its literal text does not reproduce the papers' own
//! results: with q = x⁺ − Φ·x⁺ the estimated covariance is K·S·Kᵀ, and each insertion extinguishes
//! the gain faster. Four readings are kept and named.

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

/// Readings of the papers' covariance refinement. Q̂ is the mean of q·qᵀ over the last N updates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Reading {
    /// The literal text: q = x⁺ − Φ·x⁺(previous); P ← Q̂.
    M0,
    /// q as in M0, and Q̂ taken for process noise: P⁻ ← P⁻ + Q̂ ahead of every update, none before
    /// the first Q̂ is there. This is the usual adaptive filter; the papers' "initial conditions
    /// of the Riccati solution" speak against it.
    ///
    /// Added once for each measurement, not for each span predicted over: so it does not matter
    /// into how many spans the time between two measurements is cut.
    M1,
    /// q = (integral of the rate − angle, measured rate − rate), both after the update; P ← Q̂.
    ///
    /// At small N, Q̂ is nearly singular and the filter's angle runs away.
    M4,
    /// q = (integral of the rate − predicted angle, innovation); P ← diag(Q̂).
    ///
    /// An interpretation: it agrees best with what the papers show, but no line of theirs says
    /// "diagonal".
    M6,
}

impl Reading {
    /// All readings, in the order of their numbers.
    pub const ALL: [Self; 4] = [Self::M0, Self::M1, Self::M4, Self::M6];

    /// The number in the reading's name, which is also its value as the parameter of an FMU.
    #[must_use]
    pub const fn number(self) -> i32 {
        match self {
            Self::M0 => 0,
            Self::M1 => 1,
            Self::M4 => 4,
            Self::M6 => 6,
        }
    }

    /// The reading with this number, if there is one.
    #[must_use]
    pub fn from_number(number: i32) -> Option<Self> {
        Self::ALL.into_iter().find(|reading| reading.number() == number)
    }
}

/// One update's surprise, as (angle, rate).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Surprise {
    /// How far the update moved the belief.
    pub(crate) correction: (f64, f64),
    /// How far the integral of the rate and the rate lie from the prediction.
    pub(crate) innovation: (f64, f64),
}

impl Surprise {
    /// What `reading` takes for q.
    #[inline]
    pub(crate) fn q(&self, reading: Reading) -> (f64, f64) {
        match reading {
            Reading::M0 | Reading::M1 => self.correction,
            // What the correction has left of the innovation.
            Reading::M4 => {
                (self.innovation.0 - self.correction.0, self.innovation.1 - self.correction.1)
            }
            Reading::M6 => self.innovation,
        }
    }
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
    fn a_reading_is_known_by_its_number() {
        for reading in Reading::ALL {
            assert_eq!(Reading::from_number(reading.number()), Some(reading));
        }
        assert_eq!(Reading::from_number(3), None);
    }

    #[test]
    fn what_is_left_after_an_update_is_the_innovation_less_the_correction() {
        let surprise = Surprise { correction: (0.25, 0.5), innovation: (1.0, 4.0) };
        assert_eq!(surprise.q(Reading::M0), (0.25, 0.5));
        assert_eq!(surprise.q(Reading::M1), (0.25, 0.5));
        assert_eq!(surprise.q(Reading::M4), (0.75, 3.5));
        assert_eq!(surprise.q(Reading::M6), (1.0, 4.0));
    }

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
