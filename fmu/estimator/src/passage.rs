//! What a span of time does to the belief of a two-state filter.

use crate::checks::in_range;
use crate::{Belief, Covariance, EstimatorError, Transition};

/// A transition and its noise, worked out as far as they go without the belief: spans repeat.
///
/// The numbers of Φ·P·Φᵀ + q·Q are written as sums over those of P, so that a covariance waits for
/// one product and two sums, where Φ·P ahead of ·Φᵀ would make it wait for twice as much.
///
/// By what contributes, not by what it contributes to: the factors of one sum then do not lie side
/// by side, where the compiler would pack them into SIMD registers and unpack the sum again, with
/// the next step waiting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Passage {
    /// From the mean angle to (angle, rate).
    pub(crate) from_angle: [f64; 2],
    pub(crate) from_rate: [f64; 2],
    /// From the variance of the angle to (rate variance, cross covariance, angle variance).
    pub(crate) from_angle_variance: [f64; 3],
    pub(crate) from_cross: [f64; 3],
    pub(crate) from_rate_variance: [f64; 3],
    pub(crate) noise: [f64; 3],
}

impl Passage {
    /// With process noise of density `q_rad2_s3`.
    pub(crate) fn new(t: &Transition, q_rad2_s3: f64) -> Self {
        let Transition { f11, f12, f21, f22, q11, q12, q22 } = *t;
        Self {
            from_angle: [f11, f21],
            from_rate: [f12, f22],
            from_angle_variance: [f21 * f21, f11 * f21, f11 * f11],
            from_cross: [2.0 * f21 * f22, f11 * f22 + f12 * f21, 2.0 * f11 * f12],
            from_rate_variance: [f22 * f22, f12 * f22, f12 * f12],
            noise: [q22, q12, q11].map(|noise| q_rad2_s3 * noise),
        }
    }

    /// Mean angle at the end, rad.
    #[inline(always)]
    pub(crate) fn angle(&self, belief: &Belief) -> f64 {
        self.from_angle[0] * belief.angle_rad + self.from_rate[0] * belief.rate_rad_s
    }

    /// Mean rate at the end, rad/s.
    #[inline(always)]
    pub(crate) fn rate(&self, belief: &Belief) -> f64 {
        self.from_angle[1] * belief.angle_rad + self.from_rate[1] * belief.rate_rad_s
    }

    /// Covariance at the end.
    ///
    /// # Errors
    /// [`EstimatorError::Overflow`] when it leaves the range of floating point.
    #[inline(always)]
    pub(crate) fn covariance(&self, p: &Covariance) -> Result<Covariance, EstimatorError> {
        // In this order, and judged in between: see `in_range`.
        let rate_rad2_s2 = in_range(self.carried::<0>(p))?;
        let cross_rad2_s = in_range(self.carried::<1>(p))?;
        let angle_rad2 = in_range(self.carried::<2>(p))?;
        Ok(Covariance { angle_rad2, cross_rad2_s, rate_rad2_s2 })
    }

    /// The covariance unjudged: if it has left the range of floating point, some number shows it.
    #[inline(always)]
    pub(crate) fn covariance_unjudged(&self, p: &Covariance) -> Covariance {
        Covariance {
            angle_rad2: self.carried::<2>(p),
            cross_rad2_s: self.carried::<1>(p),
            rate_rad2_s2: self.carried::<0>(p),
        }
    }

    /// One number of the covariance at the end.
    #[inline(always)]
    fn carried<const K: usize>(&self, p: &Covariance) -> f64 {
        (self.from_rate_variance[K] * p.rate_rad2_s2 + self.noise[K])
            + (self.from_cross[K] * p.cross_rad2_s + self.from_angle_variance[K] * p.angle_rad2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Φ = [2, 3; 5, 7], P = [11, 13; 13, 17], x = (1, 2), q·Q = 2·[1, 2; 2, 3]; by hand.
    #[test]
    fn a_passage_is_the_product_of_matrices() {
        let t = Transition { f11: 2.0, f12: 3.0, f21: 5.0, f22: 7.0, q11: 1.0, q12: 2.0, q22: 3.0 };
        let passage = Passage::new(&t, 2.0);
        let p = Covariance { angle_rad2: 11.0, cross_rad2_s: 13.0, rate_rad2_s2: 17.0 };
        let belief = Belief { angle_rad: 1.0, rate_rad_s: 2.0, covariance: p };
        let later = Covariance { angle_rad2: 355.0, cross_rad2_s: 848.0, rate_rad2_s2: 2024.0 };
        assert_eq!(passage.covariance(&p), Ok(later));
        assert_eq!(passage.covariance_unjudged(&p), later);
        assert_eq!((passage.angle(&belief), passage.rate(&belief)), (8.0, 19.0));
    }

    #[test]
    fn a_covariance_that_leaves_the_range_is_refused_by_any_of_its_numbers() {
        let still =
            Transition { f11: 1.0, f12: 0.0, f21: 0.0, f22: 1.0, q11: 0.0, q12: 0.0, q22: 0.0 };
        let p = Covariance { angle_rad2: 1.0, cross_rad2_s: 0.0, rate_rad2_s2: 1.0 };
        let noises = [
            Transition { q11: f64::INFINITY, ..still },
            Transition { q12: f64::INFINITY, ..still },
            Transition { q22: f64::INFINITY, ..still },
        ];
        assert_eq!(Passage::new(&still, 1.0).covariance(&p), Ok(p));
        for noise in noises {
            let refused = Passage::new(&noise, 1.0).covariance(&p);
            assert_eq!(refused, Err(EstimatorError::Overflow), "{noise:?}");
        }
    }
}
