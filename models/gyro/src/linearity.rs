//! How the scale bends.

use crate::{Law, Linearity};
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

/// How far a sine falls short of its tangent at a quarter turn, as a share of that: what an
/// open-loop gyro without any linearisation has, 1 − 2/π.
pub const SINE_NONLINEARITY: f64 = 1.0 - FRAC_2_PI;

/// A bent scale, ready to be applied.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bend {
    range_rad_s: f64,
    /// One over the range.
    per_range_s_rad: f64,
    /// How much of the whole law's deviation is left.
    share: f64,
    law: Law,
}

impl Bend {
    pub(crate) fn new(linearity: Linearity, range_rad_s: f64) -> Self {
        let whole = match linearity.law {
            Law::Cubic => 1.0,
            Law::Sine { .. } => SINE_NONLINEARITY,
        };
        Self {
            range_rad_s,
            // Finite of the smallest range as well.
            per_range_s_rad: range_rad_s.recip().min(f64::MAX),
            share: linearity.nonlinearity / whole,
            law: linearity.law,
        }
    }

    /// What is read of a rate, rad/s.
    #[inline]
    pub(crate) fn apply(&self, rate_rad_s: f64) -> f64 {
        let rate_rad_s = match self.law {
            Law::Sine { fold_back: true } => self.folded(rate_rad_s),
            _ => rate_rad_s,
        };
        if self.share == 0.0 {
            return rate_rad_s;
        }
        // Beyond full scale the output is clipped; there the deviation is held.
        let x = (rate_rad_s * self.per_range_s_rad).clamp(-1.0, 1.0);
        let shortfall = match self.law {
            Law::Cubic => x * x * x,
            Law::Sine { .. } => short_of_tangent(x),
        };
        rate_rad_s - self.share * self.range_rad_s * shortfall
    }

    /// The rate within the range whose phase has the same sine: a triangle of period four ranges.
    fn folded(&self, rate_rad_s: f64) -> f64 {
        let range_rad_s = self.range_rad_s;
        if rate_rad_s.abs() <= range_rad_s {
            return rate_rad_s;
        }
        let quarter_turns = rate_rad_s / range_rad_s;
        let turns = 0.25 * (quarter_turns - 1.0);
        // 0 at one quarter turn, where the triangle stands at its top.
        let into_turn = turns - turns.floor();
        range_rad_s * ((4.0 * into_turn - 2.0).abs() - 1.0)
    }
}

/// Coefficients of x − (2/π)·sin(πx/2) over x³ in powers of x², from its Taylor series: the next
/// would be 8·10⁻¹⁹.
const SHORTFALL: [f64; 10] = shortfall_series();

const fn shortfall_series() -> [f64; 10] {
    let square = FRAC_PI_2 * FRAC_PI_2;
    let mut series = [square / 6.0; 10];
    let mut k = 1;
    while k < series.len() {
        let below = (2 * k + 2) as f64;
        series[k] = -series[k - 1] * square / (below * (below + 1.0));
        k += 1;
    }
    series
}

/// How far a sine falls short of its tangent at zero, x − (2/π)·sin(πx/2), for |x| ≤ 1.
///
/// A series, because the difference of the two would lose its digits at small rates and a sine with
/// all its cases costs as much as the rest of a sample. Summed by pairs, of which a processor takes
/// several at once, instead of one term after another.
#[inline]
fn short_of_tangent(x: f64) -> f64 {
    let [c0, c1, c2, c3, c4, c5, c6, c7, c8, c9] = SHORTFALL;
    let x2 = x * x;
    let x4 = x2 * x2;
    let low = (c0 + c1 * x2) + (c2 + c3 * x2) * x4;
    let middle = (c4 + c5 * x2) + (c6 + c7 * x2) * x4;
    let high = c8 + c9 * x2;
    let x8 = x4 * x4;
    x * x2 * (low + x8 * (middle + x8 * high))
}

#[cfg(test)]
mod tests {
    use super::*;

    const RANGE_RAD_S: f64 = 3.5;

    fn bend(law: Law, nonlinearity: f64) -> Bend {
        Bend::new(Linearity { law, nonlinearity }, RANGE_RAD_S)
    }

    #[test]
    fn an_uncorrected_open_loop_reads_the_sine_of_the_phase_and_folds_back() {
        let sine = bend(Law::Sine { fold_back: true }, SINE_NONLINEARITY);
        for k in -300..=300 {
            let x = f64::from(k) / 50.0;
            let expected = RANGE_RAD_S * FRAC_2_PI * (FRAC_PI_2 * x).sin();
            let read = sine.apply(x * RANGE_RAD_S);
            // Six ranges are three half turns: their reduction costs a few roundings.
            assert!((read - expected).abs() < 1e-14 * RANGE_RAD_S, "{x}: {read} {expected}");
        }
    }

    #[test]
    fn a_linearised_open_loop_folds_back_in_a_triangle() {
        let folding = bend(Law::Sine { fold_back: true }, 0.0);
        // In ranges: quarters are exact in binary, ranges of 3.5 as well.
        for (rate, read) in
            [(0.5, 0.5), (1.0, 1.0), (1.25, 0.75), (2.0, 0.0), (3.0, -1.0), (4.5, 0.5)]
        {
            for sign in [1.0, -1.0] {
                let got = folding.apply(sign * rate * RANGE_RAD_S);
                assert_eq!(got.to_bits(), (sign * read * RANGE_RAD_S + 0.0).to_bits(), "{rate}");
            }
        }
    }

    #[test]
    fn nonlinearity_is_what_full_scale_falls_short_and_small_rates_are_true() {
        for law in [Law::Cubic, Law::Sine { fold_back: false }] {
            let (size, bent) = (0.001, bend(law, 0.001));
            let short = |x: f64| x - bent.apply(x * RANGE_RAD_S) / RANGE_RAD_S;
            // Values at one are rounded to some last bits.
            assert!((short(1.0) - size).abs() < 1e-15, "{law:?}: {}", short(1.0));
            assert!((short(-1.0) + size).abs() < 1e-15, "odd");
            assert!((short(1.5) - size).abs() < 1e-15, "held beyond");
            let most = (0..=1000).map(|k| short(f64::from(k) * 1e-3).abs()).fold(0.0, f64::max);
            assert!(most <= size + 1e-15, "{law:?}: {most}");
            // Of third order: at a hundredth of the range at most (π²/24)·(1e-2)³/(1 − 2/π) of it,
            // 1.1e-6.
            assert!(short(0.01).abs() < 1.2e-6 * size, "{law:?}: {}", short(0.01));
        }
    }

    #[test]
    fn the_series_is_the_difference_of_tangent_and_sine() {
        for k in -1000..=1000 {
            let x = f64::from(k) * 1e-3;
            let expected = x - FRAC_2_PI * (FRAC_PI_2 * x).sin();
            // Argument, sine, its factor and the difference are rounded: at most five halves of x.
            let off = short_of_tangent(x) - expected;
            assert!(off.abs() <= 2.5 * f64::EPSILON * x.abs(), "{x}: off by {off}");
        }
        // The last coefficient is 1.6e-16; at one, two roundings are half of an epsilon.
        assert!((short_of_tangent(1.0) - SINE_NONLINEARITY).abs() <= 0.5 * f64::EPSILON);
        // Where the difference has no digits left, the first term alone.
        let x: f64 = 1e-6;
        let first = FRAC_PI_2 * FRAC_PI_2 / 6.0 * x.powi(3);
        assert!((short_of_tangent(x) / first - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_smallest_range_bends_no_rate_into_none() {
        let linearity = Linearity { law: Law::Cubic, nonlinearity: 0.1 };
        let smallest = Bend::new(linearity, f64::MIN_POSITIVE / 16.0);
        assert!(smallest.apply(0.0) == 0.0);
    }

    #[test]
    fn a_straight_scale_changes_no_bit() {
        for rate in [0.0, 0.1, -7.3, 1e9] {
            assert_eq!(bend(Law::Cubic, 0.0).apply(rate).to_bits(), f64::to_bits(rate));
        }
    }
}
