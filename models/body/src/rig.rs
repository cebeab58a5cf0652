//! The whole rig: body, string, support, air and disturbances, judged together.

use crate::thread::ThreadLaw;
use crate::{Body, BodyError, Creep, Disturbances, Drag, Hysteresis, StartState, Support};
use nalgebra::Vector3;
use struna_kernel::{Bound, ParameterError};

/// Rate of the Earth against the stars, rad/s. Source: IERS Conventions (2010), table 1.1.
pub const EARTH_RATE_RAD_S: f64 = 7.292_115e-5;

/// Largest phase that the fastest mode may turn in one fixed step, rad. RK4 then errs by 5e-4 of
/// the phase; beyond it the motion is no longer followed.
const STEP_PHASE_MAX_RAD: f64 = 0.5;

/// Everything that decides how a body moves after its start.
///
/// Anything may be written here; it is judged when a motion starts. A rig made from a [`Body`]
/// alone is the ideal one: infinite string, linear thread, no air, nothing disturbs.
#[derive(Debug, Clone, PartialEq)]
pub struct Rig {
    /// The body and the spring of its string.
    pub body: Body,
    /// Length of the string, m; `None` is an infinite string.
    pub string_length_m: Option<f64>,
    /// Friction inside the thread.
    pub hysteresis: Option<Hysteresis>,
    /// Creep of the thread's neutral angle.
    pub creep: Option<Creep>,
    /// Air.
    pub drag: Drag,
    /// Motion of the string's upper end.
    pub support: Support,
    /// Noise and impulses.
    pub disturbances: Disturbances,
    /// Rate of the world frame against the stars, world components, rad/s. Gyros see it; its
    /// effect on the motion, a 1e-5 part of the swing's, is left out.
    pub earth_rate_w_rad_s: Vector3<f64>,
}

impl From<Body> for Rig {
    fn from(body: Body) -> Self {
        Self {
            body,
            string_length_m: None,
            hysteresis: None,
            creep: None,
            drag: Drag::NONE,
            support: Support::default(),
            disturbances: Disturbances::default(),
            earth_rate_w_rad_s: Vector3::zeros(),
        }
    }
}

/// The Earth's rate in a world frame with x east, y north and z up, rad/s.
#[must_use]
pub fn earth_rate_w_rad_s(latitude_rad: f64) -> Vector3<f64> {
    let (sin, cos) = latitude_rad.sin_cos();
    EARTH_RATE_RAD_S * Vector3::new(0.0, cos, sin)
}

impl Rig {
    /// Judges everything but the body, which was judged when it was made.
    ///
    /// # Errors
    /// [`BodyError::Parameter`] with name, value, bound and reason; [`BodyError::Grid`] for an
    /// unusable disturbance grid.
    pub fn check(&self) -> Result<(), BodyError> {
        if let Some(length_m) = self.string_length_m {
            let reason = "a string shorter than the body hangs nothing below its support";
            Bound::AtLeast(self.body.suspension_b_m().norm()).check(
                "string_length_m",
                length_m,
                reason,
            )?;
        }
        self.thread_law()?;
        self.drag.check()?;
        self.support.check()?;
        self.disturbances.check()?;
        struna_kernel::SampleGrid::new(struna_kernel::SimTime::ZERO, self.disturbances.grid_hz)?;
        for rate in &self.earth_rate_w_rad_s {
            Bound::Finite.check("earth_rate_w_rad_s", *rate, "the Earth turns at a rate")?;
        }
        Ok(())
    }

    /// Refuses a fixed step that is too long for the fastest mode of this rig.
    ///
    /// # Errors
    /// [`BodyError::Parameter`] with the longest step that will do.
    pub fn check_step(&self, start: &StartState, step_s: f64) -> Result<(), BodyError> {
        let limit_s = STEP_PHASE_MAX_RAD / self.fastest_rad_s(start)?;
        let reason = "the fastest mode of this body must not turn further than half a radian in it";
        Bound::Above(0.0).check("step_s", step_s, "time moves on")?;
        Bound::AtMost(limit_s).check("step_s", step_s, reason)?;
        Ok(())
    }

    /// Bound of the frequencies in the motion from `start`, rad/s, impulses and noise apart: swing
    /// with string, torsion, decay, shaking, and the rate that the energy of the start can give.
    fn fastest_rad_s(&self, start: &StartState) -> Result<f64, BodyError> {
        let (p, law) = (self.body.params(), self.thread_law()?);
        let smallest = self.body.inertia_min_kg_m2();
        let depth_m = self.body.suspension_b_m().norm();
        let weight_n = p.mass_kg * p.gravity_m_s2;
        let curvature_1_m = self.string_length_m.map_or(0.0, f64::recip);
        // The two modes of a double pendulum: the sum of their squares bounds the faster one.
        let swing_s2 = weight_n * depth_m / smallest * (1.0 + depth_m * curvature_1_m)
            + p.gravity_m_s2 * curvature_1_m;
        let torsion_s2 = law.stiffness_max_n_m_rad() / smallest;
        let energy_j = self.start_energy_j(start, law.stiffness_max_n_m_rad());
        let rate_rad_s = (2.0 * energy_j / smallest).sqrt();
        let drag = &self.drag;
        let turning = drag.rotation_n_m_s_rad + drag.rotation_quadratic_n_m_s2_rad2 * rate_rad_s;
        let decay_s =
            (law.damping_n_m_s_rad() + turning) / smallest + drag.translation_n_s_m / p.mass_kg;
        let modes = [swing_s2.sqrt(), torsion_s2.sqrt(), decay_s, rate_rad_s];
        Ok(modes.into_iter().fold(self.support.frequency_max_rad_s(), f64::max))
    }

    /// Energy of a start against hanging straight at rest, J, at most.
    fn start_energy_j(&self, start: &StartState, stiffness_n_m_rad: f64) -> f64 {
        let p = self.body.params();
        let rate = Vector3::from(start.omega_wb_b_rad_s);
        let depth_m = self.body.suspension_b_m().norm();
        let [x, y] = start.suspension_w_m;
        let lean_m2 = x * x + y * y;
        let rise_m = self.string_length_m.map_or(0.0, |length_m| lean_m2 / length_m)
            + depth_m * (1.0 - start.tilt_rad.cos());
        let [vx, vy] = start.com_velocity_w_m_s;
        // The centre of mass falls no faster than turning moves it about the suspension point.
        let falling_m_s = rate.cross(&self.body.suspension_b_m()).norm();
        let speed2 = vx * vx + vy * vy + falling_m_s * falling_m_s;
        let turn_rad = start.twist_rad.abs() + self.support.clamp_rad.abs();
        0.5 * rate.dot(&(self.body.inertia_b_kg_m2() * rate))
            + 0.5 * p.mass_kg * speed2
            + p.mass_kg * p.gravity_m_s2 * rise_m
            + 0.5 * stiffness_n_m_rad * turn_rad * turn_rad
    }

    pub(crate) fn thread_law(&self) -> Result<ThreadLaw, ParameterError> {
        ThreadLaw::new(&self.body, self.hysteresis.as_ref(), self.creep.as_ref())
    }

    /// Whether the plain equations describe it: principal axes, ideal infinite string, at most
    /// torque noise, nothing else.
    pub(crate) fn is_plain(&self) -> bool {
        self.body.is_aligned()
            && self.string_length_m.is_none()
            && self.hysteresis.is_none()
            && self.creep.is_none()
            && self.drag == Drag::NONE
            && self.support.is_still()
            && self.disturbances.is_noise_at_most()
            && self.earth_rate_w_rad_s == Vector3::zeros()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::{PARAMS, S2};
    use crate::{Creep, Impulse, TorqueNoise, Vibration, YieldElement, YieldLaw};
    use struna_kernel::SimTime;

    fn rig() -> Rig {
        Rig::from(Body::new(&PARAMS).unwrap())
    }

    fn refusal(rig: &Rig) -> (&'static str, Bound) {
        match rig.check() {
            Err(BodyError::Parameter(refused)) => (refused.name, refused.bound),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn each_part_of_a_rig_is_judged_with_it() {
        assert!(rig().check().is_ok());
        for bad in [0.099, 0.0, -1.0, f64::NAN, f64::INFINITY] {
            let short = Rig { string_length_m: Some(bad), ..rig() };
            assert_eq!(refusal(&short), ("string_length_m", Bound::AtLeast(0.1)), "{bad}");
        }
        let hysteresis = Some(Hysteresis { law: YieldLaw::Dahl, elements: Vec::new() });
        assert_eq!(refusal(&Rig { hysteresis, ..rig() }).0, "yield_elements");
        let creep = Some(Creep { time_s: 0.0, share: 0.0 });
        assert_eq!(refusal(&Rig { creep, ..rig() }).0, "creep_time_s");
        let drag = Drag { translation_n_s_m: -1.0, ..Drag::NONE };
        assert_eq!(refusal(&Rig { drag, ..rig() }).0, "drag_translation_n_s_m");
        let support = Support { clamp_rad: f64::NAN, ..Support::default() };
        assert_eq!(refusal(&Rig { support, ..rig() }).0, "clamp_rad");
        let noise = Some(TorqueNoise { density_b_n_m_sqrt_hz: [-1.0; 3] });
        let disturbances = Disturbances { noise, ..Disturbances::default() };
        assert_eq!(refusal(&Rig { disturbances, ..rig() }).0, "torque_noise_n_m_sqrt_hz");
        let earth_rate_w_rad_s = Vector3::new(0.0, f64::NAN, 0.0);
        let turned = Rig { earth_rate_w_rad_s, ..rig() };
        assert_eq!(refusal(&turned), ("earth_rate_w_rad_s", Bound::Finite));
    }

    #[test]
    fn a_disturbance_grid_that_is_none_is_refused() {
        for grid_hz in [0.0, -1.0, f64::NAN, 1e10] {
            let disturbances = Disturbances { grid_hz, ..Disturbances::default() };
            let refused = Rig { disturbances, ..rig() }.check();
            assert!(matches!(refused, Err(BodyError::Grid(_))), "{grid_hz}: {refused:?}");
        }
    }

    #[test]
    fn the_longest_step_turns_the_fastest_mode_by_half_a_radian() {
        // Each rig makes another mode the fastest; rates in rad/s from the formulas of those
        // modes: √(Mgd/A), √(Mgd/A·(1 + d/L) + g/L), √(Σk/A), c/A + b/M, and the shaking itself.
        let swing = 98.1_f64;
        let stiff = Hysteresis {
            law: YieldLaw::Slip,
            elements: vec![YieldElement { stiffness_n_m_rad: 4.0, yield_rad: 1e-9 }],
        };
        let k = rig().body.stiffness_n_m_rad();
        let thick = Drag { rotation_n_m_s_rad: 0.2, translation_n_s_m: 3.0, ..Drag::NONE };
        let vibration = Vibration { amplitude_w_m: [0.0; 3], frequency_hz: 5.0, phase_rad: 0.0 };
        let shaken = Support { vibrations: vec![vibration], ..Support::default() };
        let fastest = [
            (rig(), swing.sqrt()),
            (Rig { string_length_m: Some(0.5), ..rig() }, (swing * 1.2 + 19.62).sqrt()),
            (Rig { hysteresis: Some(stiff), ..rig() }, ((4.0 + k) / 0.01).sqrt()),
            (Rig { drag: thick, ..rig() }, 23.0),
            (Rig { support: shaken, ..rig() }, 10.0 * std::f64::consts::PI),
        ];
        for (rig, rate_rad_s) in fastest {
            let longest_s = 0.5 / rate_rad_s;
            assert!(rig.check_step(&S2, longest_s * (1.0 - 1e-12)).is_ok(), "{rate_rad_s}");
            match rig.check_step(&S2, longest_s * (1.0 + 1e-12)) {
                Err(BodyError::Parameter(ParameterError { name, bound, .. })) => {
                    assert_eq!(name, "step_s");
                    assert!(
                        matches!(bound, Bound::AtMost(s) if (s / longest_s - 1.0).abs() < 1e-12)
                    );
                }
                other => panic!("{rate_rad_s}: {other:?}"),
            }
        }
    }

    #[test]
    fn a_wild_start_shortens_the_longest_step() {
        let start = StartState { omega_wb_b_rad_s: [0.0, 0.0, 100.0], ..StartState::AT_REST };
        // Half of C·ω² put into the smallest moment A.
        let limit_s = 0.5 / (0.012_f64 * 1e4 / 0.01).sqrt();
        assert!(rig().check_step(&start, limit_s * 1.001).is_err());
        assert!(rig().check_step(&start, limit_s * 0.999).is_ok());
    }

    #[test]
    fn whatever_is_added_but_torque_noise_leaves_the_plain_equations() {
        assert!(rig().is_plain());
        let element = YieldElement { stiffness_n_m_rad: 1e-6, yield_rad: 0.1 };
        let hysteresis = Some(Hysteresis { law: YieldLaw::Slip, elements: vec![element] });
        let impulse =
            Impulse { time: SimTime::ZERO, angular_b_n_m_s: [0.0; 3], linear_w_n_s: [0.0; 3] };
        let struck = Disturbances { impulses: vec![impulse], ..Disturbances::default() };
        let noise = Some(TorqueNoise { density_b_n_m_sqrt_hz: [0.0; 3] });
        let noisy = Disturbances { noise, ..Disturbances::default() };
        assert!(Rig { disturbances: noisy, ..rig() }.is_plain());
        let others = [
            Rig { string_length_m: Some(1e6), ..rig() },
            Rig { hysteresis, ..rig() },
            Rig { creep: Some(Creep { time_s: 1.0, share: 0.0 }), ..rig() },
            Rig { drag: Drag { rotation_n_m_s_rad: 1e-9, ..Drag::NONE }, ..rig() },
            Rig { support: Support { clamp_rad: 0.1, ..Support::default() }, ..rig() },
            Rig { disturbances: struck, ..rig() },
            Rig { earth_rate_w_rad_s: earth_rate_w_rad_s(0.5), ..rig() },
        ];
        for other in others {
            assert!(!other.is_plain(), "{other:?}");
        }
    }

    #[test]
    fn the_earth_turns_up_at_the_pole_and_north_at_the_equator() {
        let [pole, equator] = [std::f64::consts::FRAC_PI_2, 0.0].map(earth_rate_w_rad_s);
        assert!((pole - Vector3::z() * EARTH_RATE_RAD_S).norm() < 1e-20);
        assert_eq!(equator, Vector3::y() * EARTH_RATE_RAD_S);
    }
}
