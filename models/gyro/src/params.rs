//! Parameters of one gyro axis, and the one place that judges them.

use struna_kernel::{Bound, ParameterError};

/// Longest pure delay, in samples.
pub(crate) const DELAY_SAMPLES_MAX: f64 = 250.0;
/// Fastest response, in natural frequencies per sample rate: one that is faster changes nothing.
const RESPONSE_MAX: f64 = 100.0;

/// Error-model parameters of one gyro axis, SI units only.
///
/// Data sheets speak °/h and °/√h; [`crate::datasheet`] and [`crate::preset`] convert once, at the
/// edge. Anything may be written here; [`crate::Gyro::new`] judges it. [`Self::exact`] is a gyro
/// whose every error is off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GyroParams {
    /// Samples per second f, Hz. Positive.
    pub sample_rate_hz: f64,
    /// What of the rate goes into a sample.
    pub sampling: Sampling,
    /// How the rate is smoothed and delayed before it is measured.
    pub response: Response,
    /// How far counts per rate are off.
    pub scale: ScaleFactor,
    /// How far the scale bends.
    pub linearity: Linearity,
    /// Constant bias, rad/s.
    pub bias_rad_s: f64,
    /// Turn-on bias, 1σ of its run-to-run spread, rad/s. Non-negative.
    pub turn_on_bias_sigma_rad_s: f64,
    /// What the surroundings add to the bias.
    pub bias_effects: BiasEffects,
    /// Angle random walk coefficient N, rad/√s. Non-negative.
    ///
    /// N² is the *two-sided* power spectral density of the rate noise, so a sample at rate f has
    /// the standard deviation N·√f and the integrated angle grows as N·√t. A data sheet's noise
    /// density is usually one-sided: divide it by √2.
    pub angle_random_walk_rad_sqrt_s: f64,
    /// How the bias wanders during a run.
    pub drift: DriftParams,
    /// Full-scale rate, rad/s: beyond it the output saturates. At least half an LSB.
    pub rate_max_rad_s: f64,
    /// Rate of one output count, rad/s. Positive.
    pub lsb_rad_s: f64,
    /// Largest magnitude of the output code. Positive; the full-scale rate must fit into it.
    pub counts_max: i32,
    /// What is rounded to counts.
    pub rounding: Rounding,
    /// Temperature at which scale factor and bias are as given, °C.
    pub reference_temperature_deg_c: f64,
    /// How well the gyro keeps its sample rate.
    pub clock: ClockParams,
}

/// What of the rate about its input axis a gyro puts into a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sampling {
    /// The mean over the sample interval: a perfect gyro's samples then add up to the true angle
    /// whatever its sample rate. Of a gyro with a band limit, the mean of what the filter passes.
    #[default]
    Mean,
    /// The rate at the instant of the sample: half an interval ahead of the mean. Of a gyro with a
    /// band limit, the filter's output at that instant.
    Instantaneous,
}

/// What is rounded to whole counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Rounding {
    /// Each rate by itself: the error of the integrated angle walks.
    #[default]
    Rate,
    /// The angle: what rounding leaves of one sample goes into the next, so that the sum of all
    /// counts is never off by more than half a count. Quantisation noise Q = LSB·T/√12.
    Angle,
}

/// How the rate is smoothed and delayed: ωₙ²/(s² + 2ζωₙs + ωₙ²)·e^(−s·delay).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Natural frequency ωₙ/2π, Hz; at ζ = 1/√2 the −3 dB bandwidth. 0: no band limit.
    pub natural_frequency_hz: f64,
    /// Damping ratio ζ, 0.1 to 10.
    pub damping_ratio: f64,
    /// Pure delay on top of the filter's own 2ζ/ωₙ, s.
    pub delay_s: f64,
    /// The white noise arises before the filter and is smoothed by it; otherwise behind it.
    pub noise_before_filter: bool,
}

/// How far counts per rate are off: by the factor 1 + error ± asymmetry/2 for positive and
/// negative rates.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ScaleFactor {
    /// Constant error.
    pub error: f64,
    /// 1σ of the run-to-run spread. Non-negative.
    pub turn_on_sigma: f64,
    /// Error for positive rates less that for negative ones.
    pub asymmetry: f64,
    /// Change with temperature, 1/°C.
    pub per_deg_c: f64,
}

/// How far the scale bends away from the straight line that small rates follow.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Linearity {
    /// The law of the bend.
    pub law: Law,
    /// By how much the reading at full scale falls short of the line, as a share of it.
    pub nonlinearity: f64,
}

/// The law by which a scale bends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Law {
    /// Of vibrating gyros: a cubic.
    #[default]
    Cubic,
    /// Of open-loop fibre-optic gyros: what linearisation leaves of the sine of the phase, which
    /// is π/2 at full scale.
    Sine {
        /// Beyond full scale the phase folds back, so that the reading falls again and no flag
        /// tells: the ambiguity of an open loop.
        fold_back: bool,
    },
}

/// What the surroundings add to the bias.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BiasEffects {
    /// Of temperature above the reference, rad/s per °C.
    pub per_deg_c_rad_s: f64,
    /// Of the temperature's rate, rad/s per °C/s, that is rad/°C.
    pub per_temperature_rate_rad_deg_c: f64,
    /// Of specific force along the axes of the case, rad/s per m/s².
    pub per_specific_force_s_m: [f64; 3],
    /// Of the magnetic field, rad/s per T.
    pub per_magnetic_field_rad_s_t: f64,
    /// At switch-on, rad/s, on top of the settled bias; dies out exponentially.
    pub warm_up_rad_s: f64,
    /// Time constant of that, s. Positive unless there is no warm-up.
    pub warm_up_time_s: f64,
    /// How long the gyro has been on when a run starts, s. Non-negative.
    pub on_before_s: f64,
}

/// How the bias wanders during a run. All of it is zero at the start: what a run starts with is
/// the turn-on bias.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DriftParams {
    /// Bias instability B, rad/s: the Allan deviation's floor is 0.664·B. Non-negative.
    pub bias_instability_rad_s: f64,
    /// Correlation time of a single Gauss-Markov process whose Allan deviation peaks at that
    /// floor, s; 0: flicker noise, a sum of such processes over the decades from 0.1 s to 10⁴ s.
    pub correlation_time_s: f64,
    /// Rate random walk coefficient K, rad/s/√s. Non-negative.
    pub rate_random_walk_rad_s_sqrt_s: f64,
    /// Rate ramp R, rad/s².
    pub rate_ramp_rad_s2: f64,
}

/// How well the gyro keeps its sample rate.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ClockParams {
    /// Constant relative error of the sample rate, positive when it is fast. Up to a tenth.
    pub offset: f64,
    /// 1σ of its run-to-run spread, at most a hundredth.
    pub turn_on_sigma: f64,
    /// Its steady change, 1/s; at most 10⁻⁸ in size.
    pub drift_per_s: f64,
    /// Standard deviation of each sample instant, s. At most a tenth of the interval.
    pub jitter_s: f64,
}

impl Default for Response {
    /// None at all.
    fn default() -> Self {
        Self {
            natural_frequency_hz: 0.0,
            damping_ratio: std::f64::consts::FRAC_1_SQRT_2,
            delay_s: 0.0,
            noise_before_filter: false,
        }
    }
}

impl GyroParams {
    /// A gyro that clips and rounds and has no other error.
    #[must_use]
    pub fn exact(
        sample_rate_hz: f64,
        rate_max_rad_s: f64,
        lsb_rad_s: f64,
        counts_max: i32,
    ) -> Self {
        Self {
            sample_rate_hz,
            sampling: Sampling::default(),
            response: Response::default(),
            scale: ScaleFactor::default(),
            linearity: Linearity::default(),
            bias_rad_s: 0.0,
            turn_on_bias_sigma_rad_s: 0.0,
            bias_effects: BiasEffects::default(),
            angle_random_walk_rad_sqrt_s: 0.0,
            drift: DriftParams::default(),
            rate_max_rad_s,
            lsb_rad_s,
            counts_max,
            rounding: Rounding::default(),
            reference_temperature_deg_c: crate::ROOM_TEMPERATURE_DEG_C,
            clock: ClockParams::default(),
        }
    }

    /// The same sample rate, range, output code and way of sampling with every error off.
    #[must_use]
    pub fn without_errors(&self) -> Self {
        let exact =
            Self::exact(self.sample_rate_hz, self.rate_max_rad_s, self.lsb_rad_s, self.counts_max);
        Self { sampling: self.sampling, rounding: self.rounding, ..exact }
    }

    /// Judges every value.
    ///
    /// # Errors
    /// [`ParameterError`] with name, value, bound and reason for the first one refused.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let (positive, non_negative) = (Bound::Above(0.0), Bound::AtLeast(0.0));
        let samples = "samples follow each other in time";
        positive.check("sample_rate_hz", self.sample_rate_hz, samples)?;
        self.validate_response()?;
        self.scale.validate()?;
        self.linearity.validate()?;
        Bound::Finite.check("bias_rad_s", self.bias_rad_s, "it is added to every rate")?;
        let spread = self.turn_on_bias_sigma_rad_s;
        non_negative.check("turn_on_bias_sigma_rad_s", spread, DEVIATION)?;
        self.bias_effects.validate()?;
        let walk = self.angle_random_walk_rad_sqrt_s;
        non_negative.check("angle_random_walk_rad_sqrt_s", walk, DEVIATION)?;
        let noise = "the noise of one sample overflows";
        Bound::Finite.check("noise_sigma_rad_s", self.noise_sigma_rad_s(), noise)?;
        self.drift.validate()?;
        let reference = self.reference_temperature_deg_c;
        let finite = Bound::Finite;
        finite.check("reference_temperature_deg_c", reference, "temperatures count from it")?;
        self.validate_output()?;
        self.validate_clock()
    }

    fn validate_response(&self) -> Result<(), ParameterError> {
        let Response { natural_frequency_hz, damping_ratio, delay_s, .. } = self.response;
        let name = "response.natural_frequency_hz";
        Bound::AtLeast(0.0).check(name, natural_frequency_hz, "0 stands for no band limit")?;
        let fastest = Bound::AtMost(RESPONSE_MAX * self.sample_rate_hz);
        fastest.check(
            name,
            natural_frequency_hz,
            "so fast a filter changes nothing; leave it out",
        )?;
        let damping = "the filter should settle within a few of its periods";
        Bound::AtLeast(0.1).check("response.damping_ratio", damping_ratio, damping)?;
        Bound::AtMost(10.0).check("response.damping_ratio", damping_ratio, damping)?;
        Bound::AtLeast(0.0).check("response.delay_s", delay_s, "no gyro foresees")?;
        let samples = delay_s * self.sample_rate_hz;
        let longest = Bound::AtMost(DELAY_SAMPLES_MAX);
        longest.check(
            "response.delay_s * sample_rate_hz",
            samples,
            "longer delays are not kept",
        )?;
        Ok(())
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

    fn validate_clock(&self) -> Result<(), ParameterError> {
        let ClockParams { offset, turn_on_sigma, drift_per_s, jitter_s } = self.clock;
        let rate = "a clock that far off is another sample rate";
        Bound::AtMost(0.1).check("|clock.offset|", offset.abs(), rate)?;
        Bound::AtLeast(0.0).check("clock.turn_on_sigma", turn_on_sigma, DEVIATION)?;
        Bound::AtMost(0.01).check("clock.turn_on_sigma", turn_on_sigma, rate)?;
        Bound::AtMost(1e-8).check("|clock.drift_per_s|", drift_per_s.abs(), rate)?;
        Bound::AtLeast(0.0).check("clock.jitter_s", jitter_s, DEVIATION)?;
        let order = "samples must not overtake each other";
        Bound::AtMost(0.1).check("clock.jitter_s * sample_rate_hz", self.jitter_share(), order)?;
        Ok(())
    }

    /// Jitter as a share of the sample interval.
    fn jitter_share(&self) -> f64 {
        self.clock.jitter_s * self.sample_rate_hz
    }

    /// Standard deviation of the white noise of one sample, N·√f, rad/s: behind the filter, or
    /// before it where [`Response::noise_before_filter`] says so.
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

const DEVIATION: &str = "it is a standard deviation";

impl ScaleFactor {
    fn validate(&self) -> Result<(), ParameterError> {
        let factor = "it is part of a factor";
        Bound::Finite.check("scale.error", self.error, factor)?;
        Bound::AtLeast(0.0).check("scale.turn_on_sigma", self.turn_on_sigma, DEVIATION)?;
        Bound::Finite.check("scale.asymmetry", self.asymmetry, factor)?;
        Bound::Finite.check("scale.per_deg_c", self.per_deg_c, factor)?;
        Ok(())
    }
}

impl Linearity {
    fn validate(&self) -> Result<(), ParameterError> {
        let most = match self.law {
            Law::Cubic => 0.3,
            Law::Sine { .. } => crate::SINE_NONLINEARITY,
        };
        let bend = "beyond that the scale is not monotonic, or bends more than a sine";
        let size = self.nonlinearity.abs();
        Bound::AtMost(most).check("|linearity.nonlinearity|", size, bend)?;
        Ok(())
    }
}

impl BiasEffects {
    fn validate(&self) -> Result<(), ParameterError> {
        let added = "it is added to every rate";
        let finite = |name, value| Bound::Finite.check(name, value, added);
        finite("bias_effects.per_deg_c_rad_s", self.per_deg_c_rad_s)?;
        let per_rate = self.per_temperature_rate_rad_deg_c;
        finite("bias_effects.per_temperature_rate_rad_deg_c", per_rate)?;
        for per_force in self.per_specific_force_s_m {
            finite("bias_effects.per_specific_force_s_m", per_force)?;
        }
        finite("bias_effects.per_magnetic_field_rad_s_t", self.per_magnetic_field_rad_s_t)?;
        finite("bias_effects.warm_up_rad_s", self.warm_up_rad_s)?;
        let time = "warming up takes time";
        Bound::AtLeast(0.0).check("bias_effects.warm_up_time_s", self.warm_up_time_s, time)?;
        if self.warm_up_rad_s != 0.0 {
            Bound::Above(0.0).check("bias_effects.warm_up_time_s", self.warm_up_time_s, time)?;
        }
        Bound::AtLeast(0.0).check("bias_effects.on_before_s", self.on_before_s, time)?;
        Ok(())
    }
}

impl DriftParams {
    fn validate(&self) -> Result<(), ParameterError> {
        let non_negative = Bound::AtLeast(0.0);
        let floor = self.bias_instability_rad_s;
        non_negative.check("drift.bias_instability_rad_s", floor, DEVIATION)?;
        let time = "0 stands for flicker noise";
        non_negative.check("drift.correlation_time_s", self.correlation_time_s, time)?;
        let walk = self.rate_random_walk_rad_s_sqrt_s;
        non_negative.check("drift.rate_random_walk_rad_s_sqrt_s", walk, DEVIATION)?;
        let ramp = self.rate_ramp_rad_s2;
        Bound::Finite.check("drift.rate_ramp_rad_s2", ramp, "it adds up over the run")?;
        Ok(())
    }
}

#[cfg(test)]
mod tests;
