//! The samples that cross crate borders, one type for each stage of the chain.

use crate::SimTime;
use nalgebra::{UnitQuaternion, Vector3};

/// True motion of the body at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyMotion {
    /// The instant.
    pub time: SimTime,
    /// Attitude: carries body components into world components.
    pub q_wb: UnitQuaternion<f64>,
    /// Rate of body relative to world, in body components, rad/s.
    pub omega_wb_b_rad_s: Vector3<f64>,
    /// Twist of the string τ, rad: unwrapped, zero at equilibrium. What the thread's torque sees.
    pub twist_rad: f64,
    /// Rate of the twist τ′, rad/s.
    pub twist_rate_rad_s: f64,
    /// Integral of the body z rate since the twist was zero, rad: what a perfect gyro on the axis
    /// integrates. Differs from the twist by the solid angle that the body axis has swept.
    pub spin_rad: f64,
    /// Rate of body relative to inertial space in body components, rad/s: the rate above and the
    /// Earth's.
    pub omega_ib_b_rad_s: Vector3<f64>,
    /// Integral of `omega_ib_b_rad_s` from the start, rad: what a perfect triad of gyros adds up.
    /// Not an attitude, because rotations do not add.
    pub inertial_angle_b_rad: Vector3<f64>,
    /// Rate of change of `omega_wb_b_rad_s`, rad/s².
    pub angular_acceleration_b_rad_s2: Vector3<f64>,
    /// Centre of mass, m, from the place where the string holds the body in equilibrium.
    pub com_position_w_m: Vector3<f64>,
    /// Velocity of the centre of mass, m/s.
    pub com_velocity_w_m_s: Vector3<f64>,
    /// Acceleration of the centre of mass, m/s².
    pub com_acceleration_w_m_s2: Vector3<f64>,
}

/// A gyro's raw output code.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub struct Counts(pub i32);

/// What a gyro says about a sample besides its counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[expect(clippy::struct_excessive_bools, reason = "independent bits of a status word")]
pub struct ReadingFlags {
    /// The gyro considers the sample usable.
    pub valid: bool,
    /// The measured rate lay beyond the gyro's range; the counts are clipped.
    pub over_range: bool,
    /// The bias has not settled since the gyro was switched on.
    pub warm_up: bool,
    /// The reported temperature is usable.
    pub temperature_valid: bool,
}

/// One emitted gyro sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GyroReading {
    /// Output code.
    pub counts: Counts,
    /// Case temperature, °C (data sheets and frames speak °C; nothing computes with it).
    pub temperature_deg_c: f64,
    /// Status bits.
    pub flags: ReadingFlags,
}

/// One decoded rate sample on its way to an estimator: the mean rate from `from` to `time`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RateSample {
    /// Sensor time of the start of the averaging span.
    pub from: SimTime,
    /// Sensor time of the end of the averaging span, when the sample is complete.
    pub time: SimTime,
    /// Measured rate about the gyro's input axis, rad/s.
    pub rate_rad_s: f64,
    /// At least one gyro sample in the span was marked over range.
    pub over_range: bool,
    /// Gyro samples lost between the previous `RateSample` and this one.
    pub lost_before: u64,
}

impl RateSample {
    /// Length of the averaging span, s.
    #[must_use]
    pub fn span_s(&self) -> f64 {
        self.time.seconds_since(self.from)
    }
}

/// What an estimator believes at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AngleEstimate {
    /// The instant.
    pub time: SimTime,
    /// Angle from equilibrium, rad.
    pub angle_rad: f64,
    /// Rate, rad/s.
    pub rate_rad_s: f64,
    /// Standard deviation of the angle that the estimator claims, rad; NaN when it claims none.
    pub angle_sigma_rad: f64,
    /// Standard deviation of the rate that the estimator claims, rad/s; NaN when it claims none.
    pub rate_sigma_rad_s: f64,
}
