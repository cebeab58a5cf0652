//! The true motion of the body, at any instant.

use crate::disturbance::Timeline;
use crate::lagrange::{BodyEquations, FULL_STATES, FullEquations, Lagrange, STATES};
use crate::{Body, BodyError, MountedMotion, Mounting, RapierMotion, Rig, StartState};
use nalgebra::Vector3;
use std::fmt;
use struna_kernel::{BodyMotion, Bound, SimTime};

/// How the Lagrange equations are integrated.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Integrator {
    /// Fixed steps, for live runs and held torques. 1 ms holds 1e-7 rad over 480 s of the
    /// reference motions.
    Rk4 {
        /** Step, s. */
        step_s: f64,
    },
    /// Adaptive steps with dense output, the truth of record. 1e-12 holds 1e-9 rad over 480 s.
    Dop853 {
        /** Relative tolerance. */
        rtol: f64,
        /** Absolute tolerance, rad and rad/s. */
        atol: f64,
    },
}

/// Which of the two implementations of the mechanics moves the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Backend {
    /// The Lagrange equations, integrated here.
    Lagrange(Integrator),
    /// The rigid-body engine rapier, at a fixed step.
    Rapier {
        /** Step, s. */
        step_s: f64,
    },
}

impl From<Integrator> for Backend {
    fn from(integrator: Integrator) -> Self {
        Self::Lagrange(integrator)
    }
}

impl fmt::Display for Backend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lagrange(Integrator::Rk4 { step_s }) => {
                write!(f, "lagrange, rk4, step {step_s} s")
            }
            Self::Lagrange(Integrator::Dop853 { rtol, atol }) => {
                write!(
                    f,
                    "lagrange, dop853, relative tolerance {rtol:e}, absolute tolerance {atol:e}"
                )
            }
            Self::Rapier { step_s } => {
                write!(f, "rapier, rapier3d-f64 {}, step {step_s} s", crate::RAPIER_VERSION)
            }
        }
    }
}

#[derive(Debug, Clone)]
#[expect(clippy::large_enum_variant, reason = "the plain form, the fast one, stays in line")]
enum Mechanics {
    Plain(Lagrange<STATES, BodyEquations>),
    Full(Box<Lagrange<FULL_STATES, FullEquations>>),
    Rapier(Box<RapierMotion>),
}

impl Mechanics {
    fn start(rig: &Rig, start: &StartState, backend: Backend) -> Result<Self, BodyError> {
        let integrator = match backend {
            Backend::Lagrange(integrator) => integrator,
            Backend::Rapier { step_s } => {
                return Ok(Self::Rapier(Box::new(RapierMotion::new(rig, start, step_s)?)));
            }
        };
        let timeline = Timeline::new(&rig.disturbances)?;
        if rig.is_plain() {
            let form = BodyEquations::new(&rig.body, start, Vector3::zeros());
            let states = BodyEquations::states(start);
            return Ok(Self::Plain(Lagrange::new(form, states, integrator, timeline)?));
        }
        let form = FullEquations::new(rig)?;
        let states = form.states(start)?;
        Ok(Self::Full(Box::new(Lagrange::new(form, states, integrator, timeline)?)))
    }

    fn set_torque(&mut self, torque_b_n_m: Vector3<f64>) -> Result<(), BodyError> {
        match self {
            Self::Plain(plain) => plain.set_torque(torque_b_n_m),
            Self::Full(full) => full.set_torque(torque_b_n_m),
            Self::Rapier(rapier) => rapier.set_torque(torque_b_n_m),
        }
    }
}

/// The motion of a rig from its start at [`SimTime::ZERO`] on.
///
/// The motion at an instant does not depend on which other instants are asked for: steps end at
/// every change of torque and nowhere else because of a question, and instants between steps are
/// answered by one shortened step that leaves the steps alone, by dense output, or by
/// interpolation, as the engine has it.
#[derive(Debug, Clone)]
pub struct TruthMotion {
    rig: Rig,
    backend: Backend,
    mechanics: Mechanics,
    /// Torque commanded from outside, body components, N·m.
    torque_b_n_m: Vector3<f64>,
    reached: SimTime,
}

impl TruthMotion {
    /// A motion of `rig` from `start`, without commanded torque. A [`Body`] alone is an ideal
    /// rig; an [`Integrator`] alone is the Lagrange backend.
    ///
    /// # Errors
    /// [`BodyError::Parameter`] for an impossible start or effect, for an unusable step or
    /// tolerance, and for a step too long for the fastest mode;
    /// [`BodyError::Unsupported`] for what the backend cannot do.
    pub fn new(
        rig: impl Into<Rig>,
        start: &StartState,
        backend: impl Into<Backend>,
    ) -> Result<Self, BodyError> {
        let (rig, backend) = (rig.into(), backend.into());
        rig.check()?;
        start.check()?;
        if let Backend::Lagrange(Integrator::Rk4 { step_s }) | Backend::Rapier { step_s } = backend
        {
            rig.check_step(start, step_s)?;
        }
        let mechanics = Mechanics::start(&rig, start, backend)?;
        let (torque_b_n_m, reached) = (Vector3::zeros(), SimTime::ZERO);
        Ok(Self { rig, backend, mechanics, torque_b_n_m, reached })
    }

    /// The body that moves.
    #[must_use]
    pub fn body(&self) -> &Body {
        &self.rig.body
    }

    /// The rig that moves.
    #[must_use]
    pub fn rig(&self) -> &Rig {
        &self.rig
    }

    /// What moves it.
    #[must_use]
    pub fn backend(&self) -> Backend {
        self.backend
    }

    /// The motion at `time`, which must not lie before an instant already answered.
    ///
    /// # Errors
    /// [`BodyError::TimeReversal`] for an earlier instant; [`BodyError::Stopped`] with time, state
    /// and reason when the motion cannot be carried that far. It then stays stopped; the answers
    /// given stand.
    pub fn motion_at(&mut self, time: SimTime) -> Result<BodyMotion, BodyError> {
        if time < self.reached {
            return Err(BodyError::TimeReversal { asked: time, reached: self.reached });
        }
        // A motion is large, and asked for with every sample: it is made where it is returned.
        match &mut self.mechanics {
            Mechanics::Plain(plain) => {
                plain.carry_to(time)?;
                self.reached = time;
                Ok(plain.motion())
            }
            Mechanics::Full(full) => {
                full.carry_to(time)?;
                self.reached = time;
                Ok(full.motion())
            }
            Mechanics::Rapier(rapier) => {
                let motion = rapier.motion_at(time)?;
                self.reached = time;
                Ok(motion)
            }
        }
    }

    /// What a gyro in `mounting` has of the motion at `time`: [`Self::motion_at`] at a lower price,
    /// for those who ask with every sample.
    ///
    /// # Errors
    /// As [`Self::motion_at`].
    pub fn mounted_at(
        &mut self,
        time: SimTime,
        mounting: &Mounting,
    ) -> Result<MountedMotion, BodyError> {
        if let Mechanics::Plain(plain) = &mut self.mechanics
            && time >= self.reached
        {
            plain.carry_to(time)?;
            self.reached = time;
            return Ok(plain.mounted(mounting));
        }
        let motion = self.motion_at(time)?;
        Ok(mounting.mounted(&motion, &self.rig.body))
    }

    /// Applies a torque in body components from the last answered instant on, until changed.
    ///
    /// The integration restarts at that instant, so that no step spans the jump; with
    /// [`Integrator::Rk4`] the step grid then counts from there. rapier keeps its grid and takes
    /// the torque up within one and a half steps. Setting the torque that already acts changes
    /// nothing.
    ///
    /// # Errors
    /// [`BodyError::Parameter`] for a torque that is not finite.
    pub fn set_torque(&mut self, torque_b_n_m: Vector3<f64>) -> Result<(), BodyError> {
        for torque in &torque_b_n_m {
            Bound::Finite.check("torque_b_n_m", *torque, "the body cannot follow it")?;
        }
        if torque_b_n_m == self.torque_b_n_m {
            return Ok(());
        }
        self.torque_b_n_m = torque_b_n_m;
        self.mechanics.set_torque(torque_b_n_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_backend_is_named_with_what_decides_its_error() {
        let rk4 = Backend::from(Integrator::Rk4 { step_s: 1e-3 });
        assert_eq!(rk4.to_string(), "lagrange, rk4, step 0.001 s");
        let record = Backend::from(Integrator::Dop853 { rtol: 1e-12, atol: 1e-11 });
        let expected = "lagrange, dop853, relative tolerance 1e-12, absolute tolerance 1e-11";
        assert_eq!(record.to_string(), expected);
        let rapier = Backend::Rapier { step_s: 2e-4 };
        assert_eq!(rapier.to_string(), "rapier, rapier3d-f64 0.36.1, step 0.0002 s");
    }

    #[test]
    fn the_version_named_is_the_version_pinned() {
        let manifest = include_str!("../../../Cargo.toml");
        let pin = format!("version = \"={}\"", crate::RAPIER_VERSION);
        assert!(manifest.lines().any(|l| l.starts_with("rapier3d-f64") && l.contains(&pin)));
    }
}
