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
    /// Measured rates about the x and y axes of the case, whose third axis is the input axis,
    /// rad/s: means of the same gyro samples. None when the line carries one rate.
    pub cross_rates_rad_s: Option<[f64; 2]>,
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
    /// Rate, rad/s: the one that `rate_of` says.
    pub rate_rad_s: f64,
    /// Standard deviation of the angle that the estimator claims, rad; NaN when it claims none.
    pub angle_sigma_rad: f64,
    /// Standard deviation of the rate that the estimator claims, rad/s; NaN when it claims none.
    pub rate_sigma_rad_s: f64,
    /// Normalised innovation squared of the sample that led here; NaN when the estimator tells
    /// none.
    pub nis: f64,
    /// How far the estimator itself trusts its angle.
    pub status: EstimateStatus,
    /// What its rate is the rate of: always the same of one estimator.
    pub rate_of: RateOf,
}

/// Which of two true rates an estimator tells.
///
/// While the body does not swing they are one. Under a swing they differ by what the tilt adds to
/// the twist: half a degree a second at 5° and 1.5 Hz.
///
/// The numbers are part of the record format: never renumber.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RateOf {
    /// The body, about its own axis z, relative to the room: what a gyro on the axis feels.
    BodyAxis = 0,
    /// The twist of the string τ, whose rate is τ′.
    Twist = 1,
}

impl RateOf {
    /// The number in records.
    #[must_use]
    pub const fn code(self) -> i32 {
        self as i32
    }

    /// The one of that number; none of any other.
    #[must_use]
    pub fn from_code(code: i32) -> Option<Self> {
        [Self::BodyAxis, Self::Twist].into_iter().find(|rate| rate.code() == code)
    }

    /// In two words, for people and score files.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::BodyAxis => "body axis",
            Self::Twist => "twist",
        }
    }
}

/// What an estimator says of itself, without the figures that go with it.
///
/// The numbers are part of the record format and of the FMUs: never renumber.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum EstimateStatus {
    /// The claimed sigma holds.
    Nominal = 0,
    /// The body swings, the estimator follows, and the claimed sigma holds.
    Swinging = 1,
    /// The body swings, and it is not yet known how: the angle is a bound and no more.
    Fitting = 2,
    /// Struck a while ago, or innovations too large; angle and sigma have been repaired.
    Disturbed = 3,
    /// The body does not move as assumed.
    ModelDoubtful = 4,
    /// The thread yields, and the estimator reckons with that.
    ThreadYields = 5,
    /// There is no angle to speak of.
    NotObservable = 6,
    /// A number that this program does not know, from an FMU of another origin.
    Unknown = -1,
}

impl EstimateStatus {
    /// All that have a meaning, by number.
    pub const ALL: [Self; 7] = [
        Self::Nominal,
        Self::Swinging,
        Self::Fitting,
        Self::Disturbed,
        Self::ModelDoubtful,
        Self::ThreadYields,
        Self::NotObservable,
    ];
    /// Three standard deviations beyond which there is no angle to speak of: 30°, rad.
    const ANGLE_SPREAD_MAX_RAD: f64 = std::f64::consts::PI / 6.0;

    /// The number in records and FMUs.
    #[must_use]
    pub const fn code(self) -> i32 {
        self as i32
    }

    /// The status of that number.
    #[must_use]
    pub fn from_code(code: i32) -> Self {
        Self::ALL.into_iter().find(|status| status.code() == code).unwrap_or(Self::Unknown)
    }

    /// What can be said of a device that tells no status, from the deviation of the angle that it
    /// claims, rad: whether there is an angle to speak of.
    #[must_use]
    pub fn of_claim(angle_sigma_rad: f64) -> Self {
        // Squares, as the estimators judge by: they hold variances.
        let spread = 9.0 * (angle_sigma_rad * angle_sigma_rad);
        let limit = Self::ANGLE_SPREAD_MAX_RAD * Self::ANGLE_SPREAD_MAX_RAD;
        if spread > limit { Self::NotObservable } else { Self::Nominal }
    }

    /// In a word or two, for people.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Nominal => "nominal",
            Self::Swinging => "swinging",
            Self::Fitting => "fitting the swing",
            Self::Disturbed => "disturbed",
            Self::ModelDoubtful => "model doubtful",
            Self::ThreadYields => "thread yields",
            Self::NotObservable => "not observable",
            Self::Unknown => "unknown",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_status_comes_back_from_its_number_and_no_other_number_is_one() {
        for (number, status) in (0..).zip(EstimateStatus::ALL) {
            assert_eq!((status.code(), EstimateStatus::from_code(number)), (number, status));
        }
        for stranger in [-1, 7, i32::MIN, i32::MAX] {
            assert_eq!(EstimateStatus::from_code(stranger), EstimateStatus::Unknown);
        }
    }

    #[test]
    fn a_rate_comes_back_from_its_number_and_no_other_number_is_one() {
        for (number, rate) in [(0, RateOf::BodyAxis), (1, RateOf::Twist)] {
            assert_eq!((rate.code(), RateOf::from_code(number)), (number, Some(rate)));
        }
        assert_eq!([-1, 2, i32::MAX].map(RateOf::from_code), [None; 3]);
        assert_ne!(RateOf::BodyAxis.words(), RateOf::Twist.words());
    }

    #[test]
    fn a_claim_of_more_than_ten_degrees_is_no_angle() {
        let of = |deg: f64| EstimateStatus::of_claim(deg.to_radians());
        assert_eq!(
            [0.0, 9.99, 10.01].map(of),
            [EstimateStatus::Nominal, EstimateStatus::Nominal, EstimateStatus::NotObservable]
        );
        // Who claims nothing says nothing against himself.
        assert_eq!(of(f64::NAN), EstimateStatus::Nominal);
    }
}
