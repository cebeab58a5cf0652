//! How the scale bends.

use crate::{Law, Linearity};
use std::f64::consts::FRAC_PI_2;

/// Largest deviation of a sine from the line through its quarter turn, as a share of it: what an
/// open-loop gyro without any linearisation has. √(1 − 4/π²) − (2/π)·arccos(2/π).
pub const SINE_NONLINEARITY: f64 = 0.210_513_662_353_018_6;
/// The same of x − x³: 2/(3√3) at 1/√3.
const CUBIC_BEND: f64 = 0.384_900_179_459_750_5;

/// A bent scale, ready to be applied.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bend {
    range_rad_s: f64,
    /// How much of the whole law's deviation is left.
    share: f64,
    law: Law,
}

impl Bend {
    pub(crate) fn new(linearity: Linearity, range_rad_s: f64) -> Self {
        let whole = match linearity.law {
            Law::Cubic => CUBIC_BEND,
            Law::Sine { .. } => SINE_NONLINEARITY,
        };
        Self { range_rad_s, share: linearity.nonlinearity / whole, law: linearity.law }
    }

    /// What is read of a rate, rad/s.
    pub(crate) fn apply(&self, rate_rad_s: f64) -> f64 {
        let rate_rad_s = match self.law {
            Law::Sine { fold_back: true } => self.folded(rate_rad_s),
            _ => rate_rad_s,
        };
        if self.share == 0.0 {
            return rate_rad_s;
        }
        // Beyond full scale the output is clipped; there the deviation is held at none.
        let x = (rate_rad_s / self.range_rad_s).clamp(-1.0, 1.0);
        let deviation = match self.law {
            Law::Cubic => x - x * x * x,
            Law::Sine { .. } => libm::sin(FRAC_PI_2 * x) - x,
        };
        rate_rad_s + self.share * self.range_rad_s * deviation
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_2_PI;

    const RANGE_RAD_S: f64 = 3.5;

    /// Where in the range the sine law deviates most: arccos(2/π) of a quarter turn of π/2.
    fn sine_bend_at() -> f64 {
        FRAC_2_PI.acos() * FRAC_2_PI
    }

    fn bend(law: Law, nonlinearity: f64) -> Bend {
        Bend::new(Linearity { law, nonlinearity }, RANGE_RAD_S)
    }

    #[test]
    fn an_uncorrected_open_loop_reads_the_sine_of_the_phase_and_folds_back() {
        let sine = bend(Law::Sine { fold_back: true }, SINE_NONLINEARITY);
        for k in -300..=300 {
            let x = f64::from(k) / 50.0;
            let expected = RANGE_RAD_S * (FRAC_PI_2 * x).sin();
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
    fn nonlinearity_is_the_largest_deviation_and_zero_at_both_ends() {
        for (law, place) in
            [(Law::Cubic, 1.0 / 3.0_f64.sqrt()), (Law::Sine { fold_back: false }, sine_bend_at())]
        {
            let (size, bent) = (0.001, bend(law, 0.001));
            let off = |x: f64| bent.apply(x * RANGE_RAD_S) / RANGE_RAD_S - x;
            let most = (0..=10_000).map(|k| off(f64::from(k) * 1e-4).abs()).fold(0.0, f64::max);
            // A grid of 1e-4 misses a flat top by 1e-8 of it; each value is rounded at one.
            assert!((most / size - 1.0).abs() < 1e-7, "{law:?}: {most}");
            assert!((off(place) / size - 1.0).abs() < 1e-12, "{law:?}: {}", off(place));
            assert!((off(-place) + off(place)).abs() < 1e-15, "odd");
            for end in [0.0, 1.0, -1.0, 1.5] {
                assert!(off(end).abs() < 1e-15, "{law:?} at {end}: {}", off(end));
            }
        }
    }

    #[test]
    fn a_straight_scale_changes_no_bit() {
        for rate in [0.0, 0.1, -7.3, 1e9] {
            assert_eq!(bend(Law::Cubic, 0.0).apply(rate).to_bits(), f64::to_bits(rate));
        }
    }
}
