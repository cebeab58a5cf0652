//! The motion on which detectors are tried: rest, then turning to and fro.

use std::f64::consts::TAU;
use struna_kernel::RAD_PER_DEG;

/// One period: rest first.
const PERIOD_S: f64 = 30.0;
const REST_S: f64 = 10.0;
/// Detectors are told of rest this much later and that much less long than it is, so that no
/// sample of the motion is taken for rest.
const MARGIN_S: f64 = 0.2;
/// Amplitude, deg/s, and frequency, Hz, of the two tones.
const TONES: [(f64, f64); 2] = [(120.0, 0.23), (19.0, 0.61)];

/// 10 s of rest, 20 s of two tones that swell and fade. Its acceleration stays within
/// [`TestMotion::ACCELERATION_MAX_RAD_S2`], its rate within 140 deg/s.
#[derive(Debug, Clone, Copy, Default)]
pub struct TestMotion;

impl TestMotion {
    /// What is declared of it: 240 deg/s².
    pub const ACCELERATION_MAX_RAD_S2: f64 = 240.0 * RAD_PER_DEG;

    /// The rate at `time_s`, rad/s.
    #[must_use]
    pub fn rate_rad_s(self, time_s: f64) -> f64 {
        let into_s = time_s.rem_euclid(PERIOD_S) - REST_S;
        if into_s <= 0.0 {
            return 0.0;
        }
        let swell = 0.5 - 0.5 * (TAU * into_s / (PERIOD_S - REST_S)).cos();
        let tones = TONES.map(|(rate_deg_s, hz)| rate_deg_s * (TAU * hz * into_s).sin());
        swell * tones.iter().sum::<f64>() * RAD_PER_DEG
    }

    /// The angle turned since time 0, rad: the integral of the rate in closed form.
    #[must_use]
    pub fn angle_rad(self, time_s: f64) -> f64 {
        let turns = time_s.div_euclid(PERIOD_S);
        let into_s = (time_s.rem_euclid(PERIOD_S) - REST_S).max(0.0);
        turns * turned_rad(PERIOD_S - REST_S) + turned_rad(into_s)
    }

    /// Whether rest is declared at `time_s`.
    #[must_use]
    pub fn is_declared_rest(self, time_s: f64) -> bool {
        let into_s = time_s.rem_euclid(PERIOD_S);
        (MARGIN_S..REST_S - MARGIN_S).contains(&into_s)
    }
}

/// The angle turned `into_s` after the end of rest. Swell times tone is three tones.
fn turned_rad(into_s: f64) -> f64 {
    let one_minus_cos = |hz: f64| (1.0 - (TAU * hz * into_s).cos()) / (TAU * hz);
    let swell_hz = 1.0 / (PERIOD_S - REST_S);
    let tone = |(rate_deg_s, hz): (f64, f64)| {
        let sides = one_minus_cos(hz + swell_hz) + one_minus_cos(hz - swell_hz);
        rate_deg_s * (0.5 * one_minus_cos(hz) - 0.25 * sides)
    };
    TONES.map(tone).iter().sum::<f64>() * RAD_PER_DEG
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_angle_is_the_integral_of_the_rate() {
        let step_s = 1e-3;
        for k in (0..70_000).step_by(37) {
            let time_s = f64::from(k) * step_s;
            let mean = TestMotion.angle_rad(time_s + step_s) - TestMotion.angle_rad(time_s);
            let middle = TestMotion.rate_rad_s(time_s + 0.5 * step_s);
            // A step's mean differs from its middle by the curvature, T^2/24 of at most 10 rad/s^3.
            assert!((mean / step_s - middle).abs() < 1e-6, "{time_s} s");
        }
    }

    #[test]
    fn the_motion_keeps_within_what_is_declared_of_it_and_nearly_reaches_it() {
        let step_s = 1e-3;
        let rates: Vec<f64> =
            (0..30_000).map(|k| TestMotion.rate_rad_s(f64::from(k) * step_s)).collect();
        let sharpest = rates.windows(2).map(|w| (w[1] - w[0]).abs() / step_s).fold(0.0, f64::max);
        let share = sharpest / TestMotion::ACCELERATION_MAX_RAD_S2;
        assert!((0.9..1.0).contains(&share), "{share}");
        let fastest = rates.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        assert!(fastest < 140.0 * RAD_PER_DEG, "{}", fastest / RAD_PER_DEG);
    }
}
