//! Parameters of one gyro axis, and the one place that judges them.

use struna_kernel::{Bound, ParameterError};

/// Error-model parameters of one gyro axis, SI units only.
///
/// Data sheets speak °/h and °/√h; [`crate::datasheet`] converts once, at the edge. Anything may be
/// written here; [`crate::Gyro::new`] judges it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GyroParams {
    /// Samples per second f, Hz. Positive.
    pub sample_rate_hz: f64,
    /// Angle random walk coefficient N, rad/√s. Non-negative.
    ///
    /// N² is the *two-sided* power spectral density of the rate noise, so a sample at rate f has
    /// the standard deviation N·√f and the integrated angle grows as N·√t. A data sheet's noise
    /// density is usually one-sided: divide it by √2.
    pub angle_random_walk_rad_sqrt_s: f64,
    /// Constant bias, rad/s.
    pub bias_rad_s: f64,
    /// Turn-on bias, 1σ of its run-to-run spread, rad/s. Non-negative.
    pub turn_on_bias_sigma_rad_s: f64,
    /// Full-scale rate, rad/s: beyond it the output saturates. At least half an LSB.
    pub rate_max_rad_s: f64,
    /// Rate of one output count, rad/s. Positive.
    pub lsb_rad_s: f64,
    /// Largest magnitude of the output code. Positive; the full-scale rate must fit into it.
    pub counts_max: i32,
    /// Case temperature to report, °C. Nothing is computed from it.
    pub temperature_deg_c: f64,
}

impl GyroParams {
    /// Judges every value.
    ///
    /// # Errors
    /// [`ParameterError`] with name, value, bound and reason for the first one refused.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let (positive, non_negative) = (Bound::Above(0.0), Bound::AtLeast(0.0));
        let samples = "samples follow each other in time";
        positive.check("sample_rate_hz", self.sample_rate_hz, samples)?;
        let walk = self.angle_random_walk_rad_sqrt_s;
        let deviation = "it is a standard deviation";
        non_negative.check("angle_random_walk_rad_sqrt_s", walk, deviation)?;
        let noise = "the noise of one sample overflows";
        Bound::Finite.check("noise_sigma_rad_s", self.noise_sigma_rad_s(), noise)?;
        Bound::Finite.check("bias_rad_s", self.bias_rad_s, "it is added to every rate")?;
        let spread = self.turn_on_bias_sigma_rad_s;
        non_negative.check("turn_on_bias_sigma_rad_s", spread, deviation)?;
        let temperature = self.temperature_deg_c;
        Bound::Finite.check(
            "temperature_deg_c",
            temperature,
            "it is reported with every sample",
        )?;
        self.validate_output()
    }

    fn validate_output(&self) -> Result<(), ParameterError> {
        let positive = Bound::Above(0.0);
        positive.check("lsb_rad_s", self.lsb_rad_s, "counts stand for rates")?;
        let codes = "the output needs at least the codes -1, 0 and 1";
        Bound::AtLeast(1.0).check("counts_max", f64::from(self.counts_max), codes)?;
        let range = "a gyro whose range is below half a count only ever reads zero";
        let half_count = Bound::AtLeast(0.5 * self.lsb_rad_s);
        half_count.check("rate_max_rad_s", self.rate_max_rad_s, range)?;
        // Compared in counts and after rounding, as the output is.
        let at_range = (self.rate_max_rad_s / self.lsb_rad_s).round();
        let fits = Bound::AtMost(f64::from(self.counts_max));
        fits.check("rate_max_rad_s / lsb_rad_s", at_range, "the range exceeds the output code")?;
        Ok(())
    }

    /// Standard deviation of the white noise of one sample, N·√f, rad/s.
    #[must_use]
    pub fn noise_sigma_rad_s(&self) -> f64 {
        self.angle_random_walk_rad_sqrt_s * self.sample_rate_hz.sqrt()
    }

    /// Output code at full scale; later codes never exceed it. Call on validated parameters.
    pub(crate) fn counts_at_range(&self) -> i32 {
        #[expect(clippy::cast_possible_truncation, reason = "validated: at most counts_max")]
        let counts = (self.rate_max_rad_s / self.lsb_rad_s).round() as i32;
        counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::datasheet::vg910d;

    fn name_of_refused(change: impl Fn(&mut GyroParams)) -> String {
        let mut params = vg910d();
        change(&mut params);
        match params.validate() {
            Err(refused) => {
                assert!(!refused.reason.is_empty());
                refused.name.to_owned()
            }
            Ok(()) => "accepted".to_owned(),
        }
    }

    #[test]
    fn numbers_that_are_none_are_refused_by_name() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(name_of_refused(|p| p.sample_rate_hz = bad), "sample_rate_hz");
            let walk = name_of_refused(|p| p.angle_random_walk_rad_sqrt_s = bad);
            assert_eq!(walk, "angle_random_walk_rad_sqrt_s");
            assert_eq!(name_of_refused(|p| p.bias_rad_s = bad), "bias_rad_s");
            let spread = name_of_refused(|p| p.turn_on_bias_sigma_rad_s = bad);
            assert_eq!(spread, "turn_on_bias_sigma_rad_s");
            assert_eq!(name_of_refused(|p| p.rate_max_rad_s = bad), "rate_max_rad_s");
            assert_eq!(name_of_refused(|p| p.lsb_rad_s = bad), "lsb_rad_s");
            assert_eq!(name_of_refused(|p| p.temperature_deg_c = bad), "temperature_deg_c");
        }
    }

    #[test]
    fn values_beyond_their_bounds_are_refused_by_name() {
        for bad in [0.0, -1.0] {
            assert_eq!(name_of_refused(|p| p.sample_rate_hz = bad), "sample_rate_hz");
            assert_eq!(name_of_refused(|p| p.lsb_rad_s = bad), "lsb_rad_s");
            assert_eq!(name_of_refused(|p| p.rate_max_rad_s = bad), "rate_max_rad_s");
        }
        let walk = name_of_refused(|p| p.angle_random_walk_rad_sqrt_s = -1e-9);
        assert_eq!(walk, "angle_random_walk_rad_sqrt_s");
        let spread = name_of_refused(|p| p.turn_on_bias_sigma_rad_s = -1e-9);
        assert_eq!(spread, "turn_on_bias_sigma_rad_s");
        for bad in [0, -1, i32::MIN] {
            assert_eq!(name_of_refused(|p| p.counts_max = bad), "counts_max");
        }
        let loud = name_of_refused(|p| {
            p.angle_random_walk_rad_sqrt_s = 1e300;
            p.sample_rate_hz = 1e300;
        });
        assert_eq!(loud, "noise_sigma_rad_s");
    }

    #[test]
    fn a_range_must_fit_into_the_output_code() {
        let limit = 6_553_600;
        assert_eq!(name_of_refused(|p| p.counts_max = limit), "accepted");
        let narrow = name_of_refused(|p| p.counts_max = limit - 1);
        assert_eq!(narrow, "rate_max_rad_s / lsb_rad_s");
        assert_eq!(name_of_refused(|p| p.lsb_rad_s = 1e-300), "rate_max_rad_s / lsb_rad_s");
    }

    #[test]
    fn a_refusal_names_value_bound_and_reason() {
        let error = GyroParams { lsb_rad_s: -2.0, ..vg910d() }.validate().unwrap_err();
        assert_eq!(
            error.to_string(),
            "lsb_rad_s = -2 is refused: it must be finite and above 0, because counts stand for \
             rates"
        );
    }
}
