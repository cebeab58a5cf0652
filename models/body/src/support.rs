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
