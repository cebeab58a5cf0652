//! What has to be known about gyro and motion before anything can be called wrong.

use struna_kernel::{Bound, ParameterError};

/// What is declared about a gyro, its line and the motion, SI units.
///
/// Every limit follows from these; see [`super::Limits`]. A motion sharper than declared will be
/// called a fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Declared {
    /// Samples per second, Hz.
    pub sample_rate_hz: f64,
    /// Bytes of a frame.
    pub frame_len: usize,
    /// The frame counter runs below this; none without a counter.
    pub counter_modulus: Option<u64>,
    /// Full scale, rad/s.
    pub rate_max_rad_s: f64,
    /// One count, rad/s.
    pub lsb_rad_s: f64,
    /// Standard deviation of the noise of one sample, rad/s.
    pub noise_sigma_rad_s: f64,
    /// Bandwidth of the noise, Hz, when it is not white: a second-order low-pass.
    pub noise_bandwidth_hz: Option<f64>,
    /// Largest angular acceleration of the body about the input axis, rad/s².
    pub acceleration_max_rad_s2: f64,
    /// Largest bias of a sound gyro, rad/s.
    pub bias_max_rad_s: f64,
}

impl Declared {
    /// Judges every value.
    ///
    /// # Errors
    /// [`ParameterError`] for the first one refused.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let (positive, non_negative) = (Bound::Above(0.0), Bound::AtLeast(0.0));
        positive.check("sample_rate_hz", self.sample_rate_hz, "samples follow each other")?;
        let fast = "arrival times are kept for one second";
        Bound::AtMost(1e5).check("sample_rate_hz", self.sample_rate_hz, fast)?;
        Bound::AtLeast(1.0).check("frame_len", self.frame_len as f64, "a frame has bytes")?;
        let modulus = self.counter_modulus.unwrap_or(16) as f64;
        let steps = "a step back must differ from a step forward";
        Bound::AtLeast(16.0).check("counter_modulus", modulus, steps)?;
        positive.check("rate_max_rad_s", self.rate_max_rad_s, "a gyro has a range")?;
        positive.check("lsb_rad_s", self.lsb_rad_s, "counts stand for rates")?;
        let deviation = "it is a standard deviation";
        non_negative.check("noise_sigma_rad_s", self.noise_sigma_rad_s, deviation)?;
        let bandwidth_hz = self.noise_bandwidth_hz.unwrap_or(1.0);
        // Narrower noise hardly changes from sample to sample and needs ever longer sums.
        let slow = Bound::AtLeast(1e-4 * self.sample_rate_hz);
        slow.check("noise_bandwidth_hz", bandwidth_hz, "noise that stands still is a bias")?;
        let sharp = "without a limit nothing is too sudden";
        positive.check("acceleration_max_rad_s2", self.acceleration_max_rad_s2, sharp)?;
        non_negative.check("bias_max_rad_s", self.bias_max_rad_s, "it is a magnitude")?;
        Ok(())
    }

    /// The noise of one sample with that of rounding, rad/s; never zero.
    #[must_use]
    pub fn total_sigma_rad_s(&self) -> f64 {
        self.noise_sigma_rad_s.hypot(self.rounding_sigma_rad_s())
    }

    /// Standard deviation of rounding to counts, rad/s.
    #[must_use]
    pub fn rounding_sigma_rad_s(&self) -> f64 {
        self.lsb_rad_s / 12.0_f64.sqrt()
    }

    /// Spacing of the samples, s.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        1.0 / self.sample_rate_hz
    }
}
