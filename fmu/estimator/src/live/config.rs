//! What the live estimator is told before it starts.

use super::fallback::SwingScale;
use crate::config::{ConfigError, judge, positive};
use crate::{
    AugmentedConfig, GyroRange, InnovationTest, InputAxis, Quantiser, StartPrior, SwingConfig,
};

/// One degree, rad.
const DEG: f64 = core::f64::consts::PI / 180.0;
/// Samples of half a period, and of what comes on top, that may be kept at most.
const SAMPLES_MAX: f64 = 1e6;

/// Start belief, noise, body and budget of the [`LiveEstimator`](crate::LiveEstimator). SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiveConfig {
    /// What is believed of twist, period, damping and bias, and of the noise.
    pub torsion: AugmentedConfig,
    /// The test of the innovations.
    pub test: InnovationTest,
    /// The body and the gyro's axis on it; none when nobody has declared them, and then a swing
    /// leaves no angle. Start belief, R, bias walk, scale factor and range are taken from
    /// `torsion`, whatever stands here; R tenfold when the quantiser is under-dithered.
    pub swing: Option<SwingConfig>,
    /// Largest swing that the operator lets happen, rad. It stands for the swing where that cannot
    /// be measured: without a declared body, or with an axis not calibrated. From 0 to 1.5.
    pub swing_max_rad: f64,
    /// What a swing does to the twist of a body that nobody has declared.
    pub undeclared: SwingScale,
    /// Time from one measurement to the next when none is lost, s. Positive.
    pub sample_period_s: f64,
    /// Steps of work that a fit may do in each update. A step moves one body and its fourteen
    /// neighbours by one sample, about a microsecond. A fit takes some 10⁵ to 10⁶. Positive.
    pub work_per_sample: u32,
}

impl LiveConfig {
    /// No body declared, 5° of swing at most, the standard test, and 400 steps of work per sample.
    #[must_use]
    pub const fn new(torsion: AugmentedConfig, sample_period_s: f64) -> Self {
        Self {
            torsion,
            test: InnovationTest::STANDARD,
            swing: None,
            swing_max_rad: 5.0 * DEG,
            undeclared: SwingScale::UNKNOWN,
            sample_period_s,
            work_per_sample: 400,
        }
    }

    /// Checks every value against its bound.
    ///
    /// # Errors
    /// [`ConfigError`] names the first value out of its bound.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.torsion.validate()?;
        self.test.validate()?;
        if let Some(swing) = self.swing() {
            swing.validate()?;
        }
        let ok = (0.0..=1.5).contains(&self.swing_max_rad);
        judge("swing_max_rad", self.swing_max_rad, ok, "from 0 to 1.5 rad")?;
        self.undeclared.validate()?;
        positive("sample_period_s", self.sample_period_s)?;
        let samples = self.torsion.start.period_s / self.sample_period_s;
        let bound = "such that a period of the torsion holds from 100 to 1e6 samples";
        let ok = (100.0..=SAMPLES_MAX).contains(&samples);
        judge("sample_period_s", self.sample_period_s, ok, bound)?;
        judge(
            "work_per_sample",
            f64::from(self.work_per_sample),
            self.work_per_sample > 0,
            "positive",
        )
    }

    /// The filter of pure torsion, told of the rate about the body's axis.
    pub(super) fn torsion(&self) -> AugmentedConfig {
        about_body(&self.torsion, self.gain())
    }

    /// Rate about the body's axis over the rate that the gyro measures of it, one over the cosine
    /// of the misalignment. Of an axis not calibrated nothing better than one is known.
    pub(super) fn gain(&self) -> f64 {
        self.swing.filter(|swing| is_calibrated(&swing.axis)).map_or(1.0, |swing| {
            let [x, y] = swing.axis.tilt_b_rad;
            1.0 / libm::sqrt(1.0 - x * x - y * y)
        })
    }

    /// The noise and the start belief of what is measured, for those who know of no rounding.
    pub(super) fn measured(&self) -> AugmentedConfig {
        self.torsion.without_quantiser()
    }

    /// The filter of the swinging body, in agreement with that of pure torsion.
    pub(super) fn swing(&self) -> Option<SwingConfig> {
        let torsion = self.measured();
        self.swing.map(|swing| SwingConfig {
            start: torsion.start,
            measurement_variance_rad2_s2: torsion.measurement_variance_rad2_s2,
            bias_walk_rad2_s3: torsion.bias_walk_rad2_s3,
            scale_factor_sigma: torsion.scale_factor_sigma,
            range: torsion.range,
            ..swing
        })
    }

    /// What a swing does to the twist.
    pub(super) fn scale(&self) -> SwingScale {
        self.swing.map_or(self.undeclared, |swing| {
            let [a, b, c] = swing.body.inertia_kg_m2;
            SwingScale {
                swing_rad_s: swing.body.swing_frequency_rad_s(),
                inertia_split: ((a - b).abs() / c).min(1.0),
            }
        })
    }
}

/// Misalignment over its own standard deviation below which the axis is not calibrated.
pub(super) const CALIBRATED_SIGMAS: f64 = 3.0;

/// Whether the misalignment is known well enough to reckon with.
pub(super) fn is_calibrated(axis: &InputAxis) -> bool {
    let tilt_rad = axis.tilt_rad();
    tilt_rad > 0.0 && tilt_rad >= CALIBRATED_SIGMAS * axis.tilt_sigma_rad
}

/// The same belief, noise and range of readings that have been multiplied by `gain`.
fn about_body(config: &AugmentedConfig, gain: f64) -> AugmentedConfig {
    let (start, gain2) = (config.start, gain * gain);
    let range = config.range.map(|range| GyroRange {
        limit_rad_s: gain * range.limit_rad_s,
        margin_rad_s: gain * range.margin_rad_s,
    });
    AugmentedConfig {
        start: StartPrior {
            bias_rad_s: gain * start.bias_rad_s,
            bias_sigma_rad_s: gain * start.bias_sigma_rad_s,
            ..start
        },
        measurement_variance_rad2_s2: gain2 * config.measurement_variance_rad2_s2,
        bias_walk_rad2_s3: gain2 * config.bias_walk_rad2_s3,
        range,
        quantiser: config.quantiser.map(|quantiser| Quantiser {
            step_rad_s: gain * quantiser.step_rad_s,
            raw_sigma_rad_s: gain * quantiser.raw_sigma_rad_s,
            ..quantiser
        }),
        ..*config
    }
}
