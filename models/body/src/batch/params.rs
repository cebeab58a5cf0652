//! What a batch is told of its bodies, and the one place that judges it.

use super::BatchError;
use super::step::SLIP_ELEMENTS_MAX;
use crate::{Body, StartState};
use struna_kernel::{Bound, ParameterError, Seed};

/// One body of a batch. Anything may be written here; [`super::Batch::new`] judges it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BatchBody {
    /// The body on its string.
    pub body: Body,
    /// How its motion starts.
    pub start: StartState,
    /// The body's number in its campaign: the key of its random torque, so that a body moves the
    /// same way in any company.
    pub run: u64,
    /// Constant torque in body components besides gravity and string, N·m.
    pub torque_b_n_m: [f64; 3],
    /// √S of the random torque about each body axis, N·m/√Hz, S its two-sided spectral density.
    pub torque_noise_b_n_m_sqrt_hz: [f64; 3],
    /// Hysteresis of the thread; unused places hold [`SlipElement::NONE`].
    // A literal for SLIP_ELEMENTS_MAX: rustc 1.95 breaks off with an internal error where another
    // crate's closure captures this field, if its length is a named constant.
    pub thread: [SlipElement; 4],
}

/// A Maxwell-slip element of the thread: a spring in parallel to the thread's own that slips at
/// its yield. Its torque on the twist is −kh·z, with elastic twist z within ±yield.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlipElement {
    /// Stiffness kh, N·m/rad.
    pub stiffness_n_m_rad: f64,
    /// Elastic twist at which the element slips, rad.
    pub yield_rad: f64,
    /// Elastic twist at the start, rad; at most the yield in size. A thread wound up from rest by
    /// more than the yield starts at it.
    pub elastic_start_rad: f64,
}

impl SlipElement {
    /// No element at all.
    pub const NONE: Self = Self { stiffness_n_m_rad: 0.0, yield_rad: 0.0, elastic_start_rad: 0.0 };

    fn check(&self) -> Result<(), ParameterError> {
        let spring = "a spring never drives the twist away from where it is slack";
        Bound::AtLeast(0.0).check("slip.stiffness_n_m_rad", self.stiffness_n_m_rad, spring)?;
        Bound::AtLeast(0.0).check("slip.yield_rad", self.yield_rad, "it is a size")?;
        let slipped = "an element slips before it is twisted beyond its yield";
        let elastic_rad = self.elastic_start_rad.abs();
        Bound::AtMost(self.yield_rad).check("|slip.elastic_start_rad|", elastic_rad, slipped)?;
        Ok(())
    }
}

impl BatchBody {
    /// A body by itself: run 0, no torque, no hysteresis.
    #[must_use]
    pub const fn new(body: Body, start: StartState) -> Self {
        Self {
            body,
            start,
            run: 0,
            torque_b_n_m: [0.0; 3],
            torque_noise_b_n_m_sqrt_hz: [0.0; 3],
            thread: [SlipElement::NONE; SLIP_ELEMENTS_MAX],
        }
    }

    /// Judges all but body and start, which judge themselves.
    pub(super) fn check(&self) -> Result<(), ParameterError> {
        for torque in self.torque_b_n_m {
            Bound::Finite.check("torque_b_n_m", torque, "the body cannot follow it")?;
        }
        for density in self.torque_noise_b_n_m_sqrt_hz {
            let power = "a density is the root of a power";
            Bound::AtLeast(0.0).check("torque_noise_b_n_m_sqrt_hz", density, power)?;
        }
        self.thread.iter().try_for_each(SlipElement::check)
    }

    /// How many places of the thread must be evaluated.
    pub(super) fn elements(&self) -> usize {
        let used = |element: &SlipElement| *element != SlipElement::NONE;
        self.thread.iter().rposition(used).map_or(0, |last| last + 1)
    }

    pub(super) fn is_noisy(&self) -> bool {
        self.torque_noise_b_n_m_sqrt_hz.iter().any(|density| *density > 0.0)
    }
}

/// The grid in time on which random torques are held: cell i covers `steps_per_cell` steps from
/// step i·`steps_per_cell` on.
///
/// The grid belongs to the scenario and the step to the integrator: halve the step, double
/// `steps_per_cell`, and every body keeps its path to the error of the integrator. Tying the noise
/// to the step instead would give another path for each step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NoiseGrid {
    /// The campaign's seed.
    pub seed: Seed,
    /// Steps of the integrator in one cell of the noise.
    pub steps_per_cell: u32,
}

/// Shortest step in simulated time, which counts nanoseconds.
const STEP_MIN_S: f64 = 1e-9;
/// Longest step: already far too long for a swing of any laboratory body.
const STEP_MAX_S: f64 = 1.0;

pub(super) fn check(bodies: &[BatchBody], step_s: f64, grid: &NoiseGrid) -> Result<(), BatchError> {
    Bound::AtLeast(1.0).check("bodies", bodies.len() as f64, "an empty batch has no motion")?;
    Bound::AtLeast(STEP_MIN_S).check("step_s", step_s, "time counts nanoseconds")?;
    Bound::AtMost(STEP_MAX_S).check("step_s", step_s, "a swing is faster than that")?;
    let held = "a torque is held for whole steps";
    Bound::AtLeast(1.0).check("steps_per_cell", f64::from(grid.steps_per_cell), held)?;
    bodies.iter().try_for_each(BatchBody::check)?;
    if let Some(body) = bodies.iter().find(|body| !body.body.is_aligned()) {
        return Err(BatchError::NotAligned { run: body.run });
    }
    Ok(())
}
