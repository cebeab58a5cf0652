//! What a fault does to a gyro while it lasts.

/// A disturbance of one sample, as a fault would cause it. The default does nothing.
///
/// Whatever it holds, a sample draws the random numbers it would have drawn without: after the
/// fault the gyro reads to the bit as if there had been none, except that louder noise which arose
/// before a filter dies out in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Upset {
    /// Multiplies the sensed rate; 1 does nothing.
    pub scale_factor: f64,
    /// Added to the rate, rad/s; 0 does nothing.
    pub bias_rad_s: f64,
    /// Multiplies the white noise; 1 does nothing.
    pub noise_factor: f64,
    /// The last counts are repeated.
    pub stuck: bool,
    /// The output is clipped at the range, with its flag up, whatever the rate.
    pub railed: Option<Rail>,
}

/// One end of the output range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rail {
    /// The largest count.
    Positive,
    /// The smallest count.
    Negative,
}

impl Default for Upset {
    fn default() -> Self {
        Self { scale_factor: 1.0, bias_rad_s: 0.0, noise_factor: 1.0, stuck: false, railed: None }
    }
}
