//! How far an estimate may be trusted, in words.

/// Three standard deviations of the angle beyond which there is no angle to speak of: 30°, rad.
const ANGLE_SPREAD_MAX_RAD: f64 = core::f64::consts::PI / 6.0;

/// How far the angle may be trusted.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Status {
    /// Tests are quiet: the claimed sigma holds.
    Nominal,
    /// The body swings, and the estimator follows the swing: the claimed sigma holds.
    Swinging {
        /// Largest angle of the body's axis from the vertical, rad.
        amplitude_rad: f64,
    },
    /// The body swings, and it is not yet known how: the angle is a bound and no more.
    Fitting,
    /// Something struck the body less than a quarter of a period ago, or the innovations are too
    /// large. Angle and sigma have been repaired.
    Disturbed {
        /// Seconds since the last sign of it.
        since_s: f64,
    },
    /// More than three alarms in half a period: the body does not move as assumed. Without visible
    /// shocks, suspect a thread that yields.
    ModelDoubtful,
    /// The thread yields: it loses energy to hysteresis, and the estimator reckons with that.
    ThreadYields {
        /// Angle at which it does, rad.
        yield_angle_rad: f64,
    },
    /// The claimed three sigma exceed 30°, a parameter has run to the end of its bounds, or the
    /// gyro has been over range for a second: there is no angle.
    NotObservable,
}

impl Status {
    /// The number of this status in records and FMUs, without the figures that go with it. Part of
    /// their formats: never renumber.
    #[must_use]
    pub const fn code(&self) -> i32 {
        match self {
            Self::Nominal => 0,
            Self::Swinging { .. } => 1,
            Self::Fitting => 2,
            Self::Disturbed { .. } => 3,
            Self::ModelDoubtful => 4,
            Self::ThreadYields { .. } => 5,
            Self::NotObservable => 6,
        }
    }

    /// What can be said from a claimed variance of the angle alone, rad².
    pub(crate) fn of_claim(angle_variance_rad2: f64) -> Self {
        if is_unseen(angle_variance_rad2) { Self::NotObservable } else { Self::Nominal }
    }
}

/// Whether so large a variance of the angle, rad², leaves no angle to speak of.
pub(crate) fn is_unseen(angle_variance_rad2: f64) -> bool {
    9.0 * angle_variance_rad2 > ANGLE_SPREAD_MAX_RAD * ANGLE_SPREAD_MAX_RAD
}
