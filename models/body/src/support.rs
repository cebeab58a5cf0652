//! Motion of the string's upper end.

use nalgebra::Vector3;
use std::f64::consts::TAU;
use struna_kernel::{Bound, ParameterError};

/// Most vibrations that one support may add up.
pub const VIBRATIONS_MAX: usize = 16;

/// One harmonic of the support's displacement: amplitude·sin(2π·frequency·t + phase).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vibration {
    /// Amplitude along the world axes, m.
    pub amplitude_w_m: [f64; 3],
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Phase at the start, rad.
    pub phase_rad: f64,
}

/// One harmonic of the clamp's rotation about the vertical.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClampSwing {
    /// Amplitude, rad.
    pub amplitude_rad: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Phase at the start, rad.
    pub phase_rad: f64,
}

/// How the upper end of the string moves: the point shakes, the clamp turns.
///
/// Horizontal shaking reaches the body through a string of finite length only; the pull of an
/// infinite one stays vertical.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Support {
    /// Displacement of the point, a sum of harmonics.
    pub vibrations: Vec<Vibration>,
    /// Angle of the clamp at the start, rad.
    pub clamp_rad: f64,
    /// Steady rotation of the clamp, rad/s.
    pub clamp_rate_rad_s: f64,
    /// Oscillation of the clamp, a sum of harmonics.
    pub clamp_swings: Vec<ClampSwing>,
}

/// The support at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SupportState {
    pub(crate) position_w_m: Vector3<f64>,
    pub(crate) velocity_w_m_s: Vector3<f64>,
    pub(crate) acceleration_w_m_s2: Vector3<f64>,
    pub(crate) clamp_rad: f64,
    pub(crate) clamp_rate_rad_s: f64,
}

impl Support {
    /// Whether it stands still with the clamp at zero.
    pub(crate) fn is_still(&self) -> bool {
        *self == Self::default()
    }

    /// Highest frequency at which it moves, rad/s.
    pub(crate) fn frequency_max_rad_s(&self) -> f64 {
        let shaken = self.vibrations.iter().map(|v| v.frequency_hz);
        let turned = self.clamp_swings.iter().map(|v| v.frequency_hz);
        shaken.chain(turned).fold(0.0, f64::max) * TAU
    }

    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        let count = self.vibrations.len().max(self.clamp_swings.len()) as f64;
        Bound::AtMost(VIBRATIONS_MAX as f64).check("vibrations", count, "each costs time")?;
        let turn = "the clamp has an angle";
        Bound::Finite.check("clamp_rad", self.clamp_rad, turn)?;
        Bound::Finite.check("clamp_rate_rad_s", self.clamp_rate_rad_s, turn)?;
        for v in &self.vibrations {
            for amplitude_m in v.amplitude_w_m {
                let reason = "the support stays in the room";
                Bound::Finite.check("support_amplitude_w_m", amplitude_m, reason)?;
            }
            check_harmonic(v.frequency_hz, v.phase_rad)?;
        }
        for v in &self.clamp_swings {
            Bound::Finite.check("clamp_amplitude_rad", v.amplitude_rad, turn)?;
            check_harmonic(v.frequency_hz, v.phase_rad)?;
        }
        Ok(())
    }

    #[inline(always)]
    pub(crate) fn at(&self, time_s: f64) -> SupportState {
        let zero = Vector3::zeros();
        let mut state = SupportState {
            position_w_m: zero,
            velocity_w_m_s: zero,
            acceleration_w_m_s2: zero,
            clamp_rad: self.clamp_rad + self.clamp_rate_rad_s * time_s,
            clamp_rate_rad_s: self.clamp_rate_rad_s,
        };
        for v in &self.vibrations {
            let (w, sin, cos) = harmonic(v.frequency_hz, v.phase_rad, time_s);
            let amplitude = Vector3::from(v.amplitude_w_m);
            state.position_w_m += amplitude * sin;
            state.velocity_w_m_s += amplitude * (w * cos);
            state.acceleration_w_m_s2 -= amplitude * (w * w * sin);
        }
        for v in &self.clamp_swings {
            let (w, sin, cos) = harmonic(v.frequency_hz, v.phase_rad, time_s);
            state.clamp_rad += v.amplitude_rad * sin;
            state.clamp_rate_rad_s += v.amplitude_rad * w * cos;
        }
        state
    }
}

fn check_harmonic(frequency_hz: f64, phase_rad: f64) -> Result<(), ParameterError> {
    Bound::Above(0.0).check("frequency_hz", frequency_hz, "an oscillation takes time")?;
    Bound::Finite.check("phase_rad", phase_rad, "it is an angle")?;
    Ok(())
}

/// Angular frequency, sine and cosine of a harmonic.
fn harmonic(frequency_hz: f64, phase_rad: f64, time_s: f64) -> (f64, f64, f64) {
    let w = TAU * frequency_hz;
    let (sin, cos) = libm::sincos(w * time_s + phase_rad);
    (w, sin, cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shaken() -> Support {
        Support {
            vibrations: vec![
                Vibration { amplitude_w_m: [0.02, -0.01, 0.0], frequency_hz: 0.3, phase_rad: 0.4 },
                Vibration { amplitude_w_m: [0.0, 0.01, 0.002], frequency_hz: 1.0, phase_rad: -2.0 },
            ],
            clamp_rad: 0.3,
            clamp_rate_rad_s: -0.02,
            clamp_swings: vec![
                ClampSwing { amplitude_rad: 0.1, frequency_hz: 0.5, phase_rad: 1.0 },
                ClampSwing { amplitude_rad: -0.2, frequency_hz: 0.1, phase_rad: 0.0 },
            ],
        }
    }

    #[test]
    fn velocity_and_acceleration_are_the_slopes_of_position_and_velocity() {
        let (support, h) = (shaken(), 1e-4);
        for time_s in [0.0, 0.37, 5.1, 100.0] {
            let [before, now, after] = [time_s - h, time_s, time_s + h].map(|t| support.at(t));
            let velocity = (after.position_w_m - before.position_w_m) / (2.0 * h);
            let acceleration = (after.velocity_w_m_s - before.velocity_w_m_s) / (2.0 * h);
            let clamp_rate = (after.clamp_rad - before.clamp_rad) / (2.0 * h);
            // Central differences err by h²/6·w³·amplitude, 4e-9 m/s and 3e-8 m/s² at 1 Hz, and
            // roundings of 100 s of phase leave 1e-14·0.02/1e-4.
            assert!((velocity - now.velocity_w_m_s).norm() < 1e-8, "{time_s} s");
            assert!((acceleration - now.acceleration_w_m_s2).norm() < 1e-7, "{time_s} s");
            assert!((clamp_rate - now.clamp_rate_rad_s).abs() < 1e-8, "{time_s} s");
        }
    }

    #[test]
    fn the_start_shows_amplitude_times_the_sine_of_the_phase() {
        let start = shaken().at(0.0);
        let expected = [
            0.02 * 0.4_f64.sin(),
            -0.01 * 0.4_f64.sin() - 0.01 * 2.0_f64.sin(),
            -0.002 * 2.0_f64.sin(),
        ];
        assert!((start.position_w_m - Vector3::from(expected)).norm() < 1e-17);
        assert!((start.clamp_rad - (0.3 + 0.1 * 1.0_f64.sin())).abs() < 1e-16);
    }

    #[test]
    fn a_support_knows_whether_and_how_fast_it_moves() {
        let still = Support::default();
        assert!(still.is_still());
        assert!(still.frequency_max_rad_s() == 0.0);
        let mut support = shaken();
        assert!(!support.is_still());
        assert!((support.frequency_max_rad_s() - TAU).abs() < 1e-15);
        support.clamp_swings[1].frequency_hz = 3.0;
        assert!((support.frequency_max_rad_s() - 3.0 * TAU).abs() < 1e-14);
    }

    #[test]
    fn supports_that_cannot_be_are_refused_by_name_and_bound() {
        let refusal = |change: &dyn Fn(&mut Support)| {
            let mut support = shaken();
            change(&mut support);
            let refused = support.check().unwrap_err();
            assert!(!refused.reason.is_empty());
            (refused.name, refused.bound)
        };
        assert!(shaken().check().is_ok());
        let finite = Bound::Finite;
        for bad in [f64::NAN, f64::INFINITY] {
            assert_eq!(refusal(&|s| s.clamp_rad = bad), ("clamp_rad", finite));
            assert_eq!(refusal(&|s| s.clamp_rate_rad_s = bad), ("clamp_rate_rad_s", finite));
            let amplitude = ("support_amplitude_w_m", finite);
            assert_eq!(refusal(&|s| s.vibrations[1].amplitude_w_m[2] = bad), amplitude);
            assert_eq!(refusal(&|s| s.vibrations[1].phase_rad = bad), ("phase_rad", finite));
            let swing = ("clamp_amplitude_rad", finite);
            assert_eq!(refusal(&|s| s.clamp_swings[1].amplitude_rad = bad), swing);
            assert_eq!(refusal(&|s| s.clamp_swings[0].phase_rad = bad), ("phase_rad", finite));
        }
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let frequency = ("frequency_hz", Bound::Above(0.0));
            assert_eq!(refusal(&|s| s.vibrations[0].frequency_hz = bad), frequency);
            assert_eq!(refusal(&|s| s.clamp_swings[0].frequency_hz = bad), frequency);
        }
        let many = ("vibrations", Bound::AtMost(16.0));
        assert_eq!(refusal(&|s| s.vibrations = vec![s.vibrations[0]; 17]), many);
        assert_eq!(refusal(&|s| s.clamp_swings = vec![s.clamp_swings[0]; 17]), many);
    }
}
