//! What a gyro feels.

/// Standard acceleration of gravity, m/s².
pub const STANDARD_GRAVITY_M_S2: f64 = 9.806_65;
/// Temperature of an input that names none, °C.
pub const ROOM_TEMPERATURE_DEG_C: f64 = 25.0;

/// All that acts on a gyro during one sample.
///
/// A number alone is a rate: `gyro.sample(0.08)`. The rest is then a laboratory's, an upright gyro
/// at rest at 25 °C without a magnetic field. No time is among it: a gyro ages by its own samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GyroInput {
    /// Inertial rate about the input axis, rad/s: the mean over the sample interval, or the rate at
    /// its end for a gyro without a band limit that samples instantaneously, see
    /// [`crate::Gyro::takes_means`].
    pub rate_rad_s: f64,
    /// Specific force along the axes of the case, m/s²; the third is the input axis. (0, 0, g)
    /// for a gyro that stands upright.
    pub specific_force_s_m_s2: [f64; 3],
    /// Temperature, °C.
    pub temperature_deg_c: f64,
    /// Rate of change of the temperature, °C/s.
    pub temperature_rate_deg_c_s: f64,
    /// Magnetic field along the sensitive axis, T.
    pub magnetic_field_t: f64,
}

impl From<f64> for GyroInput {
    /// A rate in rad/s in a quiet laboratory.
    fn from(rate_rad_s: f64) -> Self {
        Surroundings::default().input_at(0.0, rate_rad_s, None)
    }
}

/// What surrounds a gyro besides the motion, over a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surroundings {
    /// Temperature at the start, °C.
    pub temperature_deg_c: f64,
    /// Its steady rise, °C/s.
    pub temperature_rate_deg_c_s: f64,
    /// Magnetic field along the sensitive axis, T.
    pub magnetic_field_t: f64,
}

impl Default for Surroundings {
    fn default() -> Self {
        Self {
            temperature_deg_c: ROOM_TEMPERATURE_DEG_C,
            temperature_rate_deg_c_s: 0.0,
            magnetic_field_t: 0.0,
        }
    }
}

impl Surroundings {
    /// The input `time_s` seconds after the start. Without a specific force the gyro stands
    /// upright under standard gravity.
    #[must_use]
    pub fn input_at(
        &self,
        time_s: f64,
        rate_rad_s: f64,
        specific_force_s_m_s2: Option<[f64; 3]>,
    ) -> GyroInput {
        GyroInput {
            rate_rad_s,
            specific_force_s_m_s2: specific_force_s_m_s2.unwrap_or([
                0.0,
                0.0,
                STANDARD_GRAVITY_M_S2,
            ]),
            temperature_deg_c: self.temperature_deg_c + self.temperature_rate_deg_c_s * time_s,
            temperature_rate_deg_c_s: self.temperature_rate_deg_c_s,
            magnetic_field_t: self.magnetic_field_t,
        }
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values handed through unchanged")]
mod tests {
    use super::*;

    #[test]
    fn a_number_alone_is_a_rate_in_a_quiet_laboratory() {
        let input = GyroInput::from(0.5);
        assert_eq!(input.rate_rad_s.to_bits(), 0.5_f64.to_bits());
        assert_eq!(input.specific_force_s_m_s2, [0.0, 0.0, STANDARD_GRAVITY_M_S2]);
        assert_eq!(input, Surroundings::default().input_at(1e3, 0.5, None));
    }

    #[test]
    fn a_ramp_of_temperature_rises_with_time_and_says_how_fast() {
        let warming = Surroundings {
            temperature_deg_c: 20.0,
            temperature_rate_deg_c_s: 0.5,
            magnetic_field_t: 5e-5,
        };
        let input = warming.input_at(8.0, 0.0, Some([1.0, 2.0, 3.0]));
        // Halves and whole numbers: exact in binary.
        assert_eq!(input.temperature_deg_c.to_bits(), 24.0_f64.to_bits());
        assert_eq!(input.temperature_rate_deg_c_s.to_bits(), 0.5_f64.to_bits());
        assert_eq!(input.specific_force_s_m_s2, [1.0, 2.0, 3.0]);
    }
}
