//! How a motion starts.

use crate::{Body, BodyError, TILT_MAX_RAD};
use nalgebra::{Quaternion, UnitQuaternion};
use struna_kernel::Bound;

/// Largest twist a start may have, rad. Beyond it the attitude, which repeats every turn, would no
/// longer follow from the twist to a nanoradian in `f64`.
pub const TWIST_MAX_RAD: f64 = 1e6;

/// Attitude and rate of the body at the start of a run.
///
/// The body first turns by `twist_rad` about its own axis, then swings by `tilt_rad` about the
/// horizontal world axis at `tilt_azimuth_rad`. Swing and twist do not mix, so the twist that the
/// string feels is exactly `twist_rad`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StartState {
    /// Angle between the body axis and the vertical, rad; |tilt| at most [`TILT_MAX_RAD`].
    pub tilt_rad: f64,
    /// Direction of the horizontal axis of the swing, from world x towards world y, rad.
    pub tilt_azimuth_rad: f64,
    /// Twist of the string, rad, whole turns included; |twist| at most [`TWIST_MAX_RAD`].
    pub twist_rad: f64,
    /// Rate of body relative to world in body components, rad/s.
    pub omega_wb_b_rad_s: [f64; 3],
    /// Where the string holds the body, x and y from below the support, m. An infinite string
    /// follows anywhere.
    pub suspension_w_m: [f64; 2],
    /// Horizontal velocity of the centre of mass, x and y, m/s.
    pub com_velocity_w_m_s: [f64; 2],
}

impl StartState {
    /// Hanging straight, untwisted, at rest.
    pub const AT_REST: Self = Self {
        tilt_rad: 0.0,
        tilt_azimuth_rad: 0.0,
        twist_rad: 0.0,
        omega_wb_b_rad_s: [0.0; 3],
        suspension_w_m: [0.0; 2],
        com_velocity_w_m_s: [0.0; 2],
    };

    /// Hanging straight, twisted and turning about the vertical: pure torsion.
    #[must_use]
    pub const fn twisted(twist_rad: f64, twist_rate_rad_s: f64) -> Self {
        Self { twist_rad, omega_wb_b_rad_s: [0.0, 0.0, twist_rate_rad_s], ..Self::AT_REST }
    }

    /// The attitude: swing after twist.
    #[must_use]
    pub fn attitude(&self) -> UnitQuaternion<f64> {
        let (half_sin, half_cos) = (0.5 * self.tilt_rad).sin_cos();
        let (axis_y, axis_x) = self.tilt_azimuth_rad.sin_cos();
        let (twist_sin, twist_cos) = (0.5 * self.twist_rad).sin_cos();
        let swing = Quaternion::new(half_cos, half_sin * axis_x, half_sin * axis_y, 0.0);
        let twist = Quaternion::new(twist_cos, 0.0, 0.0, twist_sin);
        UnitQuaternion::from_quaternion(swing * twist)
    }

    /// Horizontal position of the centre of mass, x and y, m.
    pub(crate) fn com_offset_w_m(&self, body: &Body) -> [f64; 2] {
        let below = self.attitude() * -body.suspension_b_m();
        [self.suspension_w_m[0] + below.x, self.suspension_w_m[1] + below.y]
    }

    /// Judges the start.
    ///
    /// # Errors
    /// [`BodyError::Parameter`] for a value that is not finite, a tilt near upside down or a twist
    /// too large to resolve.
    pub fn check(&self) -> Result<(), BodyError> {
        let tilt = "the twist of a string is undefined on a body upside down";
        Bound::AtMost(TILT_MAX_RAD).check("|tilt_rad|", self.tilt_rad.abs(), tilt)?;
        let azimuth = "it is a direction";
        Bound::Finite.check("tilt_azimuth_rad", self.tilt_azimuth_rad, azimuth)?;
        let twist = "a larger twist no longer resolves the attitude";
        Bound::AtMost(TWIST_MAX_RAD).check("|twist_rad|", self.twist_rad.abs(), twist)?;
        for rate in self.omega_wb_b_rad_s {
            Bound::Finite.check("omega_wb_b_rad_s", rate, "the body moves at a rate")?;
        }
        for position in self.suspension_w_m {
            Bound::Finite.check("suspension_w_m", position, "the body is in a place")?;
        }
        for velocity in self.com_velocity_w_m_s {
            Bound::Finite.check("com_velocity_w_m_s", velocity, "the body moves at a rate")?;
        }
        Ok(())
    }
}
