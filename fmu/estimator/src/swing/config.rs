//! What the filters of a swinging body are told before they start.

use crate::augmented::{GyroRange, StartPrior};
use crate::config::{ConfigError, judge, not_negative, positive};

/// One degree, rad.
const DEG: f64 = core::f64::consts::PI / 180.0;
/// How far the gyro's input axis may lie off the body's, rad: further off it is another axis.
const TILT_MAX_RAD: f64 = core::f64::consts::FRAC_PI_4;

/// The body as it is believed to be. SI units.
///
/// Body axes are the principal axes through the centre of mass; the string holds the body on its z
/// axis, `com_depth_m` above the centre of mass. Infinite string: the centre of mass moves
/// vertically and not otherwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SwingBody {
    /// Mass M, kg. Positive.
    pub mass_kg: f64,
    /// Depth d of the centre of mass below the point that the string holds, m. Positive.
    pub com_depth_m: f64,
    /// Central moments of inertia A, B, C about x, y, z, as believed, kg·m². Positive.
    pub inertia_kg_m2: [f64; 3],
    /// Acceleration of gravity, m/s². Positive.
    pub gravity_m_s2: f64,
    /// Nominal decay of the swing, 1/s: its amplitude falls as exp(−λt). Not negative.
    ///
    /// It stands for air that brakes turning about every axis alike, by the torque −(A + B)·λ·ω. A
    /// filter learns by what factor it is wrong. What the same air takes from the twist is part of
    /// 2ζΩ; see [`SwingMotion`](crate::SwingMotion).
    pub swing_damping_1_s: f64,
}

impl SwingBody {
    /// Checks every value against its bound.
    ///
    /// # Errors
    /// [`ConfigError`] names the first value out of its bound.
    pub fn validate(&self) -> Result<(), ConfigError> {
        positive("mass_kg", self.mass_kg)?;
        positive("com_depth_m", self.com_depth_m)?;
        let [a, b, c] = self.inertia_kg_m2;
        positive("inertia_a_kg_m2", a)?;
        positive("inertia_b_kg_m2", b)?;
        positive("inertia_c_kg_m2", c)?;
        positive("gravity_m_s2", self.gravity_m_s2)?;
        not_negative("swing_damping_1_s", self.swing_damping_1_s)?;
        // Products of extreme values may leave the range though each value is in it.
        let swing = self.swing_frequency_rad_s();
        let ok = (1e-6..=1e6).contains(&swing);
        judge("swing_frequency_rad_s", swing, ok, "from 1e-6 to 1e6 rad/s")
    }

    /// Angular frequency √(M·g·d/A) of the faster one of the two small swings, rad/s.
    #[must_use]
    pub fn swing_frequency_rad_s(&self) -> f64 {
        let [a, b, _] = self.inertia_kg_m2;
        libm::sqrt(self.mass_kg * self.gravity_m_s2 * self.com_depth_m / a.min(b))
    }
}

/// How the gyro sits on the body: where its input axis points, and how well that is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InputAxis {
    /// Components g₁ and g₂ of the input axis along the body's x and y axes, rad (sines; for the
    /// small angles meant here, the angles). Their root sum of squares is below sin 45°.
    pub tilt_b_rad: [f64; 2],
    /// Standard deviation of each of the two, from calibration, rad. Not negative.
    pub tilt_sigma_rad: f64,
}

impl InputAxis {
    /// An axis tilted by `tilt_rad` towards the direction `azimuth_rad` from body x towards body y.
    #[must_use]
    pub fn towards(tilt_rad: f64, azimuth_rad: f64, tilt_sigma_rad: f64) -> Self {
        let across = libm::sin(tilt_rad);
        let tilt_b_rad = [across * libm::cos(azimuth_rad), across * libm::sin(azimuth_rad)];
        Self { tilt_b_rad, tilt_sigma_rad }
    }

    /// Checks every value against its bound.
    ///
    /// # Errors
    /// [`ConfigError`] names the first value out of its bound.
    pub fn validate(&self) -> Result<(), ConfigError> {
        let ok = self.tilt_rad() < TILT_MAX_RAD;
        judge("tilt_b_rad[0]", self.tilt_b_rad[0], ok, "with the other one below 45 degrees")?;
        judge("tilt_b_rad[1]", self.tilt_b_rad[1], ok, "with the other one below 45 degrees")?;
        not_negative("tilt_sigma_rad", self.tilt_sigma_rad)
    }

    /// Angle between the input axis and the body's z axis, rad.
    #[must_use]
    pub fn tilt_rad(&self) -> f64 {
        let [x, y] = self.tilt_b_rad;
        libm::asin(libm::hypot(x, y))
    }
}

/// Body, gyro, start belief and noise of the filters of a swinging body. SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SwingConfig {
    /// The body.
    pub body: SwingBody,
    /// The gyro on it. A filter of three axes takes no notice: its gyros are the body axes.
    pub axis: InputAxis,
    /// What is believed of twist, period, damping and bias at the start, as for the filters that
    /// know of no swing.
    pub start: StartPrior,
    /// Variance R of one measured rate, rad²/s². Positive.
    pub measurement_variance_rad2_s2: f64,
    /// Relative standard deviation of the moments A and B. Not negative.
    pub inertia_sigma: f64,
    /// Relative standard deviation of the swing's decay. Not negative.
    pub swing_damping_sigma: f64,
    /// Root density of the random walk of the swing's rates per radian of its amplitude, s^(−3/2):
    /// what the model leaves out grows with the swing. Not negative.
    pub swing_walk_s_m3_2: f64,
    /// Density of the random walk of the rate about the body's axis, rad²/s³. Not negative.
    pub rate_walk_rad2_s3: f64,
    /// Density of the random walk of the bias, rad²/s³. Not negative.
    pub bias_walk_rad2_s3: f64,
    /// Standard deviation of the gyro's scale factor, relative. Not negative. It widens what is
    /// claimed and nothing else.
    pub scale_factor_sigma: f64,
    /// Range of the gyro; none when it cannot clip.
    pub range: Option<GyroRange>,
}

impl SwingConfig {
    /// A quiet laboratory and a body measured with care: moments to 2 %, decay of the swing to
    /// 50 %; walks of 0.001 s^(−3/2) of the swing's amplitude, (0.001 °/s)² and (1e-6 °/s)² per
    /// second.
    #[must_use]
    pub const fn quiet(
        body: SwingBody,
        axis: InputAxis,
        start: StartPrior,
        measurement_variance_rad2_s2: f64,
    ) -> Self {
        Self {
            body,
            axis,
            start,
            measurement_variance_rad2_s2,
            inertia_sigma: 0.02,
            swing_damping_sigma: 0.5,
            swing_walk_s_m3_2: 1e-3,
            rate_walk_rad2_s3: 1e-6 * DEG * DEG,
            bias_walk_rad2_s3: 1e-12 * DEG * DEG,
            scale_factor_sigma: 0.0,
            range: None,
        }
    }

    /// Checks every value against its bound.
    ///
    /// # Errors
    /// [`ConfigError`] names the first value out of its bound.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.body.validate()?;
        self.axis.validate()?;
        self.start.validate()?;
        positive("measurement_variance_rad2_s2", self.measurement_variance_rad2_s2)?;
        not_negative("inertia_sigma", self.inertia_sigma)?;
        not_negative("swing_damping_sigma", self.swing_damping_sigma)?;
        not_negative("swing_walk_s_m3_2", self.swing_walk_s_m3_2)?;
        not_negative("rate_walk_rad2_s3", self.rate_walk_rad2_s3)?;
        not_negative("bias_walk_rad2_s3", self.bias_walk_rad2_s3)?;
        not_negative("scale_factor_sigma", self.scale_factor_sigma)?;
        self.range.map_or(Ok(()), |range| range.validate())
    }
}
