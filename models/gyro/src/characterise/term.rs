//! The five straight slopes of an Allan variance.

use std::f64::consts::{LN_2, PI};

/// A kind of gyro noise, known by its slope in the Allan variance.
///
/// Coefficients follow one convention: power spectral densities are two-sided, so that white rate
/// noise of density N² has the Allan variance N²/τ.
///
/// # Source
/// IEEE Std 952, *Specification Format Guide and Test Procedure for Single-Axis Interferometric
/// Fiber Optic Gyros*, 1997; the formulas are checked against simulated noise in `tests/`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Term {
    /// Rounding of the angle: Q, rad.
    Quantisation,
    /// White noise of the rate: N, rad/√s.
    AngleRandomWalk,
    /// Flicker of the rate: B, rad/s. The flat part of the Allan deviation lies at 0.664 B.
    BiasInstability,
    /// The rate as random walk: K, rad/s/√s.
    RateRandomWalk,
    /// A steady change of the rate: R, rad/s².
    RateRamp,
}

impl Term {
    /// All of them, from the steepest fall to the steepest rise.
    pub const ALL: [Self; 5] = [
        Self::Quantisation,
        Self::AngleRandomWalk,
        Self::BiasInstability,
        Self::RateRandomWalk,
        Self::RateRamp,
    ];

    /// Its place in [`Self::ALL`].
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize
    }

    /// The letter of its coefficient.
    #[must_use]
    pub const fn symbol(self) -> char {
        match self {
            Self::Quantisation => 'Q',
            Self::AngleRandomWalk => 'N',
            Self::BiasInstability => 'B',
            Self::RateRandomWalk => 'K',
            Self::RateRamp => 'R',
        }
    }

    /// What it is called in words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Quantisation => "quantisation",
            Self::AngleRandomWalk => "angle random walk",
            Self::BiasInstability => "bias instability",
            Self::RateRandomWalk => "rate random walk",
            Self::RateRamp => "rate ramp",
        }
    }

    /// Allan variance of a unit coefficient at the averaging time `tau_s`.
    #[must_use]
    pub fn unit_variance(self, tau_s: f64) -> f64 {
        match self {
            Self::Quantisation => 3.0 / (tau_s * tau_s),
            Self::AngleRandomWalk => 1.0 / tau_s,
            Self::BiasInstability => 2.0 * LN_2 / PI,
            Self::RateRandomWalk => tau_s / 3.0,
            Self::RateRamp => 0.5 * tau_s * tau_s,
        }
    }
}

/// Squares of the five coefficients, in the order of [`Term::ALL`]: an Allan variance as a sum.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct NoiseModel {
    squares: [f64; 5],
}

impl NoiseModel {
    /// From squared coefficients in the order of [`Term::ALL`].
    #[must_use]
    pub fn from_squares(squares: [f64; 5]) -> Self {
        Self { squares }
    }

    /// From coefficients in the order of [`Term::ALL`].
    #[must_use]
    pub fn from_coefficients(coefficients: [f64; 5]) -> Self {
        Self { squares: coefficients.map(|c| c * c) }
    }

    /// The coefficient of `term`, in the unit that [`Term`] names.
    #[must_use]
    pub fn coefficient(&self, term: Term) -> f64 {
        self.squares[term.index()].sqrt()
    }

    /// Squares in the order of [`Term::ALL`].
    #[must_use]
    pub fn squares(&self) -> [f64; 5] {
        self.squares
    }

    /// Whether the term is part of the model.
    #[must_use]
    pub fn has(&self, term: Term) -> bool {
        self.squares[term.index()] > 0.0
    }

    /// What `term` adds to the Allan variance at `tau_s`.
    #[must_use]
    pub fn share(&self, term: Term, tau_s: f64) -> f64 {
        self.squares[term.index()] * term.unit_variance(tau_s)
    }

    /// Allan variance at `tau_s`.
    #[must_use]
    pub fn variance(&self, tau_s: f64) -> f64 {
        Term::ALL.iter().map(|term| self.share(*term, tau_s)).sum()
    }

    /// The term that makes most of the variance at `tau_s`, unless none makes two thirds of it.
    #[must_use]
    pub fn dominant(&self, tau_s: f64) -> Option<Term> {
        let enough = self.variance(tau_s) * 2.0 / 3.0;
        Term::ALL.into_iter().find(|term| self.has(*term) && self.share(*term, tau_s) >= enough)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_stand_at_their_own_index() {
        for (k, term) in Term::ALL.into_iter().enumerate() {
            assert_eq!(term.index(), k);
        }
    }

    #[test]
    fn the_flat_part_lies_at_two_thirds_of_the_bias_instability() {
        let model = NoiseModel::from_coefficients([0.0, 0.0, 3.0, 0.0, 0.0]);
        assert!((model.variance(100.0).sqrt() - 3.0 * 0.664).abs() < 1e-3);
    }

    #[test]
    fn a_term_dominates_where_the_others_add_up_to_half_of_it() {
        let model = NoiseModel::from_coefficients([0.0, 1.0, 0.0, 0.0, 1.0]);
        // 1/τ and τ²/2 are equal at τ = 2^(1/3).
        assert_eq!(model.dominant(0.5), Some(Term::AngleRandomWalk));
        assert_eq!(model.dominant(1.26), None);
        assert_eq!(model.dominant(5.0), Some(Term::RateRamp));
        assert_eq!(NoiseModel::default().dominant(1.0), None);
    }
}
