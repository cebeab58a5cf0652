//! Where the descents start: what of the swing is seen, and guesses at what is not.

use super::problem::{EX, G1, G2, P, Problem, Unknowns};
use crate::swing::amplitude::Leak;
use core::f64::consts::TAU;

/// Guesses at the hidden component of the swing: sizes as shares of the swing, and phases of each.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hypotheses {
    pub(super) levels: &'static [f64],
    pub(super) phases: usize,
}

impl Hypotheses {
    /// 25 starts with the zero one.
    pub(super) const STANDARD: Self = Self { levels: &[0.25, 0.6, 1.0], phases: 8 };
    /// 73 starts with the zero one.
    pub(super) const DENSE: Self = Self { levels: &[0.1, 0.25, 0.5, 0.75, 1.0, 1.3], phases: 12 };
    /// The zero one alone.
    pub(super) const NONE: Self = Self { levels: &[], phases: 0 };

    /// Starts, with the zero one.
    pub(super) const fn count(self) -> usize {
        1 + self.levels.len() * self.phases
    }

    /// Guess `k` of those that are not zero, of a swing of this size and frequency.
    fn hidden(self, k: usize, swing_rad: f64, frequency_rad_s: f64) -> Amplitude {
        let level = self.levels.get(k / self.phases).copied().unwrap_or_default();
        let rate = level * swing_rad * frequency_rad_s;
        let angle = TAU * (k % self.phases) as f64 / self.phases as f64;
        Amplitude { re: rate * libm::cos(angle), im: rate * libm::sin(angle) }
    }
}

/// A complex amplitude C, for the oscillation Re(C·exp(iωt)).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Amplitude {
    re: f64,
    im: f64,
}

impl Amplitude {
    /// Re(C/(iω)): the oscillation's integral at time zero.
    fn integral(self, frequency_rad_s: f64) -> f64 {
        self.im / frequency_rad_s
    }
}

/// The starts, as scaled unknowns.
///
/// The rate along the direction m in which the gyro sits askew is the leak over ε: C_m. That along
/// o, a quarter turn from m, is hidden: C_o is guessed. The vertical follows from e′ = R₉₀·ω, so
/// e = Re(C_m/iω)·o − Re(C_o/iω)·m.
pub(super) fn starts<'a>(
    problem: &'a Problem,
    leak: &Leak,
    swing_rad: f64,
    hypotheses: Hypotheses,
) -> impl DoubleEndedIterator<Item = Unknowns> + use<'a> {
    let [g1, g2] = [problem.mean[G1], problem.mean[G2]];
    let askew = libm::hypot(g1, g2);
    let m = [g1 / askew, g2 / askew];
    let [c, s] = leak.coefficients_rad_s;
    let seen = Amplitude { re: c / askew, im: -s / askew };
    let frequency = leak.frequency_rad_s;
    let none = Amplitude { re: 0.0, im: 0.0 };
    (0..hypotheses.count()).map(move |k| {
        let hidden = k.checked_sub(1).map_or(none, |k| hypotheses.hidden(k, swing_rad, frequency));
        start(problem, m, frequency, seen, hidden)
    })
}

fn start(
    problem: &Problem,
    m: [f64; 2],
    frequency_rad_s: f64,
    seen: Amplitude,
    hidden: Amplitude,
) -> Unknowns {
    let o = [-m[1], m[0]];
    let (along_o, along_m) = (seen.integral(frequency_rad_s), -hidden.integral(frequency_rad_s));
    // Everything else, the rate about the body's axis too, is as believed.
    let mut x = problem.mean;
    for axis in 0..2 {
        x[EX + axis] = along_o * o[axis] + along_m * m[axis];
        x[P + axis] = seen.re * m[axis] + hidden.re * o[axis];
    }
    problem.within_bounds(problem.u(&x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::swing::fit::problem::tests::{config, problem};
    use crate::swing::fit::walk::Walk;
    use std::vec::Vec;

    /// The rates that a start predicts, without torsion and bias.
    fn predicted(problem: &Problem, u: &Unknowns) -> Vec<f64> {
        let mut walk = Walk::new(problem, u);
        (0..200)
            .map(|_| {
                let rate = walk.rate_rad_s();
                assert!(walk.step(problem));
                rate
            })
            .collect()
    }

    #[test]
    fn every_start_shows_the_leak_that_was_seen() {
        let config = config();
        let problem = problem();
        let frequency = config.body.swing_frequency_rad_s();
        // 0.1° of swing: coning and the moments' difference are far below a percent of its leak.
        let swing_rad = 1.7e-3;
        let (c, s) = (0.6, -0.8);
        let size = config.axis.tilt_rad() * frequency * swing_rad;
        let leak = Leak { frequency_rad_s: frequency, coefficients_rad_s: [c * size, s * size] };
        let all: Vec<_> = starts(&problem, &leak, swing_rad, Hypotheses::STANDARD).collect();
        assert_eq!(all.len(), 25);
        for u in &all {
            for (k, rate) in predicted(&problem, u).into_iter().enumerate() {
                let phase = frequency * 0.01 * k as f64;
                let seen = size * (c * phase.cos() + s * phase.sin());
                assert!((rate - seen).abs() < 0.02 * size, "{k}: {rate:e} for {seen:e}");
            }
        }
    }

    #[test]
    fn what_is_hidden_differs_from_start_to_start() {
        let problem = problem();
        let leak = Leak { frequency_rad_s: 9.9, coefficients_rad_s: [1e-3, 0.0] };
        let all: Vec<_> = starts(&problem, &leak, 0.1, Hypotheses::DENSE).collect();
        assert_eq!(all.len(), 73);
        for (i, a) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|b| a.map(f64::to_bits) != b.map(f64::to_bits)), "{i}");
        }
        assert_eq!(starts(&problem, &leak, 0.1, Hypotheses::NONE).count(), 1);
    }
}
