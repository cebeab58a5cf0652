//! How a motion starts.

use crate::{Body, BodyError, TILT_MAX_RAD};
use nalgebra::{Quaternion, UnitQuaternion};
use struna_kernel::{AddressedRandom, Bound, Channel, Seed};

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

/// How far the starts of a campaign scatter about the one intended, as standard deviations.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StartErrors {
    /// Of the twist, rad.
    pub twist_sigma_rad: f64,
    /// Of the tilt, rad.
    pub tilt_sigma_rad: f64,
    /// Of the rate about each body axis, rad/s.
    pub rate_sigma_rad_s: f64,
}

impl StartErrors {
    /// Every start exactly as intended.
    pub const NONE: Self =
        Self { twist_sigma_rad: 0.0, tilt_sigma_rad: 0.0, rate_sigma_rad_s: 0.0 };
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

    /// The start of run `run` of the campaign `seed`: this one, missed by `errors`.
    ///
    /// The tilt is missed in the direction of its azimuth. Each error has an address of its own,
    /// so setting one to zero leaves the others alone. Whether the result is possible is judged
    /// when a motion starts from it.
    #[must_use]
    pub fn disturbed(&self, errors: &StartErrors, seed: Seed, run: u64) -> Self {
        let mut random = AddressedRandom::new(seed, Channel::StartError, run);
        let mut miss = |index, sigma: f64| sigma * random.standard_normal(index);
        let mut start = *self;
        start.twist_rad += miss(0, errors.twist_sigma_rad);
        start.tilt_rad += miss(1, errors.tilt_sigma_rad);
        for (index, rate_rad_s) in (2..).zip(&mut start.omega_wb_b_rad_s) {
            *rate_rad_s += miss(index, errors.rate_sigma_rad_s);
        }
        start
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::S3;

    const ERRORS: StartErrors =
        StartErrors { twist_sigma_rad: 0.1, tilt_sigma_rad: 0.02, rate_sigma_rad_s: 0.3 };

    /// How far run `run` misses S3: twist, tilt, three rates, in standard deviations.
    fn missed(errors: &StartErrors, seed: u64, run: u64) -> [f64; 5] {
        let start = S3.disturbed(errors, Seed(seed), run);
        let rate = |axis: usize| {
            (start.omega_wb_b_rad_s[axis] - S3.omega_wb_b_rad_s[axis]) / ERRORS.rate_sigma_rad_s
        };
        [
            (start.twist_rad - S3.twist_rad) / ERRORS.twist_sigma_rad,
            (start.tilt_rad - S3.tilt_rad) / ERRORS.tilt_sigma_rad,
            rate(0),
            rate(1),
            rate(2),
        ]
    }

    #[test]
    fn without_errors_every_run_starts_as_intended() {
        for run in 0..10 {
            assert_eq!(S3.disturbed(&StartErrors::NONE, Seed(7), run), S3);
        }
    }

    #[test]
    fn a_start_depends_on_seed_and_run_alone() {
        let start = S3.disturbed(&ERRORS, Seed(7), 3);
        assert_eq!(start, S3.disturbed(&ERRORS, Seed(7), 3));
        assert_ne!(start, S3.disturbed(&ERRORS, Seed(7), 4));
        assert_ne!(start, S3.disturbed(&ERRORS, Seed(8), 3));
    }

    #[test]
    fn each_error_has_an_address_of_its_own() {
        let all = missed(&ERRORS, 7, 3);
        for (k, one) in all.iter().enumerate() {
            assert!(!all[..k].iter().any(|other| (one - other).abs() < 1e-9), "{all:?}");
        }
        let steady = StartErrors { twist_sigma_rad: 0.0, tilt_sigma_rad: 0.0, ..ERRORS };
        let rates_alone = missed(&steady, 7, 3);
        assert_eq!(rates_alone[..2], [0.0; 2]);
        assert_eq!(rates_alone[2..], all[2..]);
    }

    #[test]
    fn errors_over_many_runs_have_the_deviations_asked_for_and_no_correlation() {
        let runs = 4000_u32;
        let all: Vec<_> = (0..u64::from(runs)).map(|run| missed(&ERRORS, 1, run)).collect();
        let n = f64::from(runs);
        let mean_of = |product: &dyn Fn(&[f64; 5]) -> f64| all.iter().map(product).sum::<f64>() / n;
        for a in 0..5 {
            // Four standard errors: 1/√n of a mean and a correlation, √(2/n) of a variance.
            let mean = mean_of(&|missed| missed[a]);
            assert!(mean.abs() < 4.0 / n.sqrt(), "mean of {a}: {mean}");
            let variance = mean_of(&|missed| missed[a].powi(2));
            assert!((variance - 1.0).abs() < 4.0 * (2.0 / n).sqrt(), "variance of {a}: {variance}");
            for b in 0..a {
                let correlation = mean_of(&|missed| missed[a] * missed[b]);
                assert!(correlation.abs() < 4.0 / n.sqrt(), "{a} with {b}: {correlation}");
            }
        }
    }
}
