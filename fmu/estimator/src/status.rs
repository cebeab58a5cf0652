//! How far an estimate may be trusted, in words.

use core::fmt;

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
    Fitting {
        /// Seconds of the swing that have been collected for the fit.
        collected_s: f64,
        /// Seconds that the fit needs.
        needed_s: f64,
    },
    /// Something struck the body less than a quarter of a period ago, or the innovations are too
    /// large. Angle and sigma have been repaired.
    Disturbed {
        /// Seconds since the last sign of it.
        since_s: f64,
    },
    /// More than three alarms in half a period, or a thread that yields explains the record far
    /// better: the body does not move as assumed. Without visible shocks, suspect the thread.
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
            Self::Fitting { .. } => 2,
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

/// One degree, rad.
const DEG: f64 = core::f64::consts::PI / 180.0;

/// Plain words for who watches the rig: what is the matter, and where the angle comes from.
impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Nominal => f.write_str("nominal"),
            Self::Swinging { amplitude_rad } => {
                let amplitude_deg = amplitude_rad / DEG;
                write!(f, "swinging, {amplitude_deg:.1} deg; angle from the 5-DOF filter")
            }
            Self::Fitting { collected_s, needed_s } if collected_s < needed_s => write!(
                f,
                "swinging: angle not yet available, {collected_s:.0} s of {needed_s:.0} s collected"
            ),
            Self::Fitting { collected_s, .. } => write!(
                f,
                "swinging: angle not yet available, {collected_s:.0} s collected, fit under way"
            ),
            Self::Disturbed { since_s } => write!(f, "disturbed {since_s:.0} s ago"),
            Self::ModelDoubtful => f.write_str(
                "model doubtful: alarm after alarm, or a motion that a yielding thread explains \
                 better; check for shocks, then the thread",
            ),
            Self::ThreadYields { yield_angle_rad } => {
                let yield_deg = yield_angle_rad / DEG;
                write!(f, "thread yields at {yield_deg:.0} deg; angle from the hysteresis filters")
            }
            Self::NotObservable => f.write_str("not observable: the angle is a guess"),
        }
    }
}

/// Whether so large a variance of the angle, rad², leaves no angle to speak of.
pub(crate) fn is_unseen(angle_variance_rad2: f64) -> bool {
    9.0 * angle_variance_rad2 > ANGLE_SPREAD_MAX_RAD * ANGLE_SPREAD_MAX_RAD
}
