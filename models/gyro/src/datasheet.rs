//! Data sheets: the only place that speaks °/s, °/h and °/√h.

use crate::GyroParams;
use struna_kernel::RAD_PER_DEG;

const S_PER_H: f64 = 3600.0;
const SQRT_S_PER_SQRT_H: f64 = 60.0;

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

/// The VG-910D fibre-optic gyro as this bench assumes it.
///
/// | value | | provenance |
/// |---|---|---|
/// | sample rate | 300 Hz | laboratory description, 2008; clock tolerance not modelled |
/// | range | ±200 °/s | laboratory description, 2008 |
/// | output code | 24 bits, two's complement | laboratory description, 2008 |
/// | LSB | 2⁻¹⁵ °/s | **invented**: exact in binary, ±200 °/s is ±6 553 600 counts |
/// | N | 0.07 °/√h, two-sided | **derived**, see below |
/// | turn-on bias σ | 5 °/h | **unverified**: of the order usual for the class |
/// | constant bias | 0 | quoted nowhere |
/// | temperature | 25 °C | **invented**: reported only |
///
/// N follows from the half ranges that the laboratory's manual prints for averages of 15 and 25
/// samples, divided by the half range that Gaussian noise has in records of 300 to 1000 values;
/// anything from 0.053 to 0.094 °/√h fits them.
///
/// No data sheet of this model was found; treat every line that is not from the laboratory's own
/// description as a scenario's choice.
#[must_use]
pub const fn vg910d() -> GyroParams {
    GyroParams {
        sample_rate_hz: 300.0,
        angle_random_walk_rad_sqrt_s: rad_sqrt_s_from_deg_sqrt_h(0.07),
        bias_rad_s: 0.0,
        turn_on_bias_sigma_rad_s: rad_s_from_deg_h(5.0),
        rate_max_rad_s: rad_s_from_deg_s(200.0),
        lsb_rad_s: rad_s_from_deg_s(1.0 / 32_768.0),
        counts_max: (1 << 23) - 1,
        temperature_deg_c: 25.0,
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
    fn the_vg910d_is_sound_and_spans_its_range_in_whole_counts() {
        let params = vg910d();
        params.validate().unwrap();
        assert_eq!(params.counts_at_range(), 6_553_600);
        // 0.07 °/√h = 0.001167 °/√s, so 0.0202 °/s at 300 Hz: the unfiltered sample's 0.020.
        assert!((params.noise_sigma_rad_s() / RAD_PER_DEG - 0.0202).abs() < 5e-5);
    }
}
