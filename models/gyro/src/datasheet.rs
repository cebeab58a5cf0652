//! Data-sheet units: °/s, °/h, °/√h and their like, converted once.

use crate::{GyroParams, preset};
use struna_kernel::RAD_PER_DEG;

/// Seconds in an hour.
pub const S_PER_H: f64 = 3600.0;
/// √s in a √h.
pub const SQRT_S_PER_SQRT_H: f64 = 60.0;

/// A rate in °/s as rad/s.
#[must_use]
pub const fn rad_s_from_deg_s(rate_deg_s: f64) -> f64 {
    rate_deg_s * RAD_PER_DEG
}

/// A rate, as biases are quoted, in °/h as rad/s.
#[must_use]
pub const fn rad_s_from_deg_h(rate_deg_h: f64) -> f64 {
    rate_deg_h * RAD_PER_DEG / S_PER_H
}

/// An angle random walk in °/√h as rad/√s.
#[must_use]
pub const fn rad_sqrt_s_from_deg_sqrt_h(walk_deg_sqrt_h: f64) -> f64 {
    walk_deg_sqrt_h * RAD_PER_DEG / SQRT_S_PER_SQRT_H
}

/// A noise density, as data sheets quote it, as the angle random walk coefficient N in the same
/// unit: the density itself when it is two-sided, and 1/√2 of it when it is one-sided, which it
/// is unless the sheet says otherwise.
#[must_use]
pub fn walk_of_density(density: f64, sided: Sided) -> f64 {
    match sided {
        Sided::One => density * std::f64::consts::FRAC_1_SQRT_2,
        Sided::Two => density,
    }
}

/// Whether a spectral density counts the power of negative frequencies apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sided {
    /// All power at positive frequencies, as spectrum analysers show it.
    One,
    /// Half the power at negative frequencies.
    Two,
}

/// The VG-910D of [`preset::vg910d`] reduced to its white noise and turn-on bias: what has closed
/// forms downstream, for tests and comparisons. Scenarios take the preset.
#[must_use]
pub fn vg910d() -> GyroParams {
    let all = preset::vg910d();
    GyroParams {
        angle_random_walk_rad_sqrt_s: all.angle_random_walk_rad_sqrt_s,
        turn_on_bias_sigma_rad_s: all.turn_on_bias_sigma_rad_s,
        ..all.without_errors()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn data_sheet_units_convert_to_radians_and_seconds() {
        // One rounding per product or quotient.
        let close = |a: f64, b: f64| (a / b - 1.0).abs() < 4.0 * f64::EPSILON;
        assert!(close(rad_s_from_deg_s(180.0), PI));
        assert!(close(rad_s_from_deg_h(648_000.0), PI));
        assert!(close(rad_sqrt_s_from_deg_sqrt_h(10_800.0), PI));
    }

    #[test]
    fn an_hour_of_random_walk_adds_up_to_the_quoted_degrees() {
        let walk_rad = rad_sqrt_s_from_deg_sqrt_h(0.07) * 3600.0_f64.sqrt();
        assert!((walk_rad / RAD_PER_DEG - 0.07).abs() < 1e-16);
    }

    #[test]
    fn a_one_sided_density_has_twice_the_power_of_a_two_sided_one() {
        let (one, two) = (walk_of_density(0.05, Sided::One), walk_of_density(0.05, Sided::Two));
        assert!((one / two - 0.5_f64.sqrt()).abs() < f64::EPSILON);
        assert_eq!(two.to_bits(), 0.05_f64.to_bits());
    }

    #[test]
    fn the_vg910d_is_sound_and_spans_its_range_in_whole_counts() {
        let params = vg910d();
        params.validate().unwrap();
        assert_eq!(params.counts_at_range(), 6_553_600);
        // 0.07 °/√h = 0.001167 °/√s, so 0.0202 °/s at 300 Hz: the unfiltered sample's 0.020.
        assert!((params.noise_sigma_rad_s() / RAD_PER_DEG - 0.0202).abs() < 5e-5);
    }
}
