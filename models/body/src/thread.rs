//! The string as a thread: what its twist does beyond a linear spring.

use crate::Body;
use struna_kernel::{Bound, ParameterError};

/// Most yield elements that one thread may have.
pub const YIELD_ELEMENTS_MAX: usize = 4;

/// How a yield element passes from sticking to slipping.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum YieldLaw {
    /// Maxwell-slip: elastic up to the yield strain, then slipping at constant torque.
    Slip,
    /// Dahl: approaches the yield torque exponentially, as many small slips do.
    Dahl,
}

/// A spring that yields, in parallel with the thread's own stiffness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct YieldElement {
    /// Stiffness before yielding, N·m/rad.
    pub stiffness_n_m_rad: f64,
    /// Strain at which it yields, rad; its torque never exceeds stiffness times this.
    pub yield_rad: f64,
}

/// Rate-independent friction inside the thread: amplitude then falls linearly instead of
/// geometrically, and the body comes to rest anywhere in a wide zone about its equilibrium.
///
/// # Source
/// Dahl, P. R., *A solid friction model*, 1968; the Maxwell-slip model after Iwan, W. D., 1966.
#[derive(Debug, Clone, PartialEq)]
pub struct Hysteresis {
    /// How elements yield.
    pub law: YieldLaw,
    /// One to [`YIELD_ELEMENTS_MAX`] elements.
    pub elements: Vec<YieldElement>,
}

/// Slow drift of the neutral angle after the angle at which the thread is held, as of a standard
/// linear solid: τ₀′ = (share·τ − τ₀)/time. A share of the stiffness relaxes, the rest stays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Creep {
    /// Time constant, s.
    pub time_s: f64,
    /// Share of the stiffness that creeps, k₁/k, 0 to 1.
    pub share: f64,
}

/// What a yielding thread remembers from one completed step to the next.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Memory {
    /// Turn of the thread at the last commitment, rad.
    pub(crate) turn_rad: f64,
    /// Strain of each element then, rad.
    pub(crate) strain_rad: [f64; YIELD_ELEMENTS_MAX],
}

/// The thread's torque as a function of its turn, ready for the hot path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ThreadLaw {
    stiffness_n_m_rad: f64,
    damping_n_m_s_rad: f64,
    creep_rate_s: f64,
    creep_share: f64,
    law: YieldLaw,
    elements: [YieldElement; YIELD_ELEMENTS_MAX],
    count: usize,
}

impl ThreadLaw {
    /// Judges what the thread adds to the spring of `body`.
    pub(crate) fn new(
        body: &Body,
        hysteresis: Option<&Hysteresis>,
        creep: Option<&Creep>,
    ) -> Result<Self, ParameterError> {
        let none = YieldElement { stiffness_n_m_rad: 0.0, yield_rad: 1.0 };
        let mut law = Self {
            stiffness_n_m_rad: body.stiffness_n_m_rad(),
            damping_n_m_s_rad: body.damping_n_m_s_rad(),
            creep_rate_s: 0.0,
            creep_share: 0.0,
            law: YieldLaw::Slip,
            elements: [none; YIELD_ELEMENTS_MAX],
            count: 0,
        };
        if let Some(hysteresis) = hysteresis {
            law.add(hysteresis)?;
        }
        if let Some(creep) = creep {
            check_creep(creep)?;
            (law.creep_rate_s, law.creep_share) = (creep.time_s.recip(), creep.share);
        }
        Ok(law)
    }

    fn add(&mut self, hysteresis: &Hysteresis) -> Result<(), ParameterError> {
        let count = hysteresis.elements.len();
        let reason = "so many yield elements are kept in a body's state";
        Bound::AtLeast(1.0).check("yield_elements", count as f64, reason)?;
        Bound::AtMost(YIELD_ELEMENTS_MAX as f64).check("yield_elements", count as f64, reason)?;
        for (kept, element) in self.elements.iter_mut().zip(&hysteresis.elements) {
            let stiff = "an element that yields is a spring before";
            Bound::Above(0.0).check("yield_stiffness_n_m_rad", element.stiffness_n_m_rad, stiff)?;
            let yields = "an element that yields at no strain exerts no torque";
            Bound::Above(0.0).check("yield_rad", element.yield_rad, yields)?;
            *kept = *element;
        }
        (self.law, self.count) = (hysteresis.law, count);
        Ok(())
    }

    /// Stiffness against small and fast turns, N·m/rad.
    pub(crate) fn stiffness_max_n_m_rad(&self) -> f64 {
        let yielding = self.elements[..self.count].iter().map(|e| e.stiffness_n_m_rad);
        self.stiffness_n_m_rad + yielding.sum::<f64>()
    }

    /// Damping coefficient, N·m·s/rad.
    pub(crate) fn damping_n_m_s_rad(&self) -> f64 {
        self.damping_n_m_s_rad
    }

    /// Whether the torque depends on where the turn has been.
    #[inline(always)]
    pub(crate) fn yields(&self) -> bool {
        self.count > 0
    }

    /// Torque on the twist, N·m, at a turn that has not left the direction it took since `memory`.
    #[inline(always)]
    pub(crate) fn torque_n_m(
        &self,
        turn_rad: f64,
        turn_rate_rad_s: f64,
        neutral_rad: f64,
        memory: &Memory,
    ) -> f64 {
        let elastic = self.stiffness_n_m_rad * (turn_rad - neutral_rad);
        let mut torque = -(elastic + self.damping_n_m_s_rad * turn_rate_rad_s);
        if self.count > 0 {
            torque -= self.yielding_n_m(&self.strained(memory, turn_rad));
        }
        torque
    }

    /// Torque of the yield elements at these strains, N·m.
    #[inline(always)]
    fn yielding_n_m(&self, strain_rad: &[f64; YIELD_ELEMENTS_MAX]) -> f64 {
        let of = |(e, z): (&YieldElement, &f64)| e.stiffness_n_m_rad * z;
        self.elements[..self.count].iter().zip(strain_rad).map(of).sum()
    }

    /// Strains after the thread has turned from where `memory` was committed to `turn_rad`: the
    /// return map of each element. No strain is integrated, so none can overshoot its yield.
    #[inline(always)]
    pub(crate) fn strained(&self, memory: &Memory, turn_rad: f64) -> [f64; YIELD_ELEMENTS_MAX] {
        let change = turn_rad - memory.turn_rad;
        let mut strain = memory.strain_rad;
        for (z, element) in strain.iter_mut().zip(&self.elements[..self.count]) {
            let limit = element.yield_rad;
            *z = match self.law {
                YieldLaw::Slip => (*z + change).max(-limit).min(limit),
                YieldLaw::Dahl => {
                    let end = limit.copysign(change);
                    end + (*z - end) * libm::exp(-change.abs() / limit)
                }
            };
        }
        strain
    }

    /// The direction of the turn and the elements that slip, as bits: the torque is smooth while
    /// they stay the same.
    pub(crate) fn regime(&self, turn_rad: f64, turn_rate_rad_s: f64, memory: &Memory) -> u32 {
        let forwards = turn_rate_rad_s > 0.0;
        let mut bits = u32::from(forwards);
        if self.law == YieldLaw::Slip {
            let change = turn_rad - memory.turn_rad;
            for (z, element) in memory.strain_rad.iter().zip(&self.elements[..self.count]) {
                let strain = if forwards { z + change } else { -(z + change) };
                bits = 2 * bits + u32::from(strain >= element.yield_rad);
            }
        }
        bits
    }

    /// Rate of the neutral angle, rad/s.
    #[inline(always)]
    pub(crate) fn neutral_rate_rad_s(&self, turn_rad: f64, neutral_rad: f64) -> f64 {
        self.creep_rate_s * (self.creep_share * turn_rad - neutral_rad)
    }

    /// The neutral angle a step later, while the thread turns evenly from `from_rad` to `to_rad`:
    /// the trapezoidal rule of its linear equation, solved for the end.
    pub(crate) fn neutral_after_rad(
        &self,
        neutral_rad: f64,
        (from_rad, to_rad): (f64, f64),
        step_s: f64,
    ) -> f64 {
        let half = 0.5 * self.creep_rate_s * step_s;
        let pulled = half * self.creep_share * (from_rad + to_rad);
        (neutral_rad * (1.0 - half) + pulled) / (1.0 + half)
    }
}

fn check_creep(creep: &Creep) -> Result<(), ParameterError> {
    Bound::Above(0.0).check("creep_time_s", creep.time_s, "creep takes time")?;
    let share = "it is a share of the stiffness";
    Bound::AtLeast(0.0).check("creep_share", creep.share, share)?;
    Bound::AtMost(1.0).check("creep_share", creep.share, share)?;
    Ok(())
}
