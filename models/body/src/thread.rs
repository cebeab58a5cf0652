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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::PARAMS;
    use proptest::prelude::*;

    fn element(stiffness_n_m_rad: f64, yield_rad: f64) -> YieldElement {
        YieldElement { stiffness_n_m_rad, yield_rad }
    }

    fn law(law: YieldLaw, elements: &[YieldElement]) -> Result<ThreadLaw, ParameterError> {
        let hysteresis = Hysteresis { law, elements: elements.to_vec() };
        ThreadLaw::new(&Body::new(&PARAMS).unwrap(), Some(&hysteresis), None)
    }

    fn pair(kind: YieldLaw) -> ThreadLaw {
        law(kind, &[element(2e-6, 0.1), element(1e-6, 0.5)]).unwrap()
    }

    /// Strains after turning through these changes one after another.
    fn followed(law: &ThreadLaw, changes: &[f64]) -> Memory {
        changes.iter().fold(Memory::default(), |memory, change| {
            let turn_rad = memory.turn_rad + change;
            Memory { turn_rad, strain_rad: law.strained(&memory, turn_rad) }
        })
    }

    fn either() -> impl Strategy<Value = YieldLaw> {
        prop_oneof![Just(YieldLaw::Slip), Just(YieldLaw::Dahl)]
    }

    proptest! {
        #[test]
        fn no_history_strains_an_element_beyond_its_yield(
            kind in either(),
            changes in proptest::collection::vec(-3.0..3.0_f64, 1..40),
        ) {
            let strain = followed(&pair(kind), &changes).strain_rad;
            // Dahl's sum of two products rounds; slip's bound is exact.
            prop_assert!(strain[0].abs() <= 0.1 * (1.0 + f64::EPSILON));
            prop_assert!(strain[1].abs() <= 0.5 * (1.0 + f64::EPSILON));
            prop_assert_eq!(&strain[2..], &[0.0, 0.0], "elements that do not exist");
        }

        #[test]
        fn a_monotone_turn_may_be_cut_anywhere(
            kind in either(),
            history in proptest::collection::vec(-1.0..1.0_f64, 0..10),
            (first, second) in (0.0..1.0_f64, 0.0..1.0_f64),
            sense in prop_oneof![Just(1.0), Just(-1.0)],
        ) {
            let law = pair(kind);
            let mut cut = history.clone();
            cut.extend([sense * first, sense * second]);
            let mut whole = history;
            whole.push(sense * (first + second));
            let (cut, whole) = (followed(&law, &cut), followed(&law, &whole));
            for i in 0..2 {
                // Turns up to 12 rad in sums of a different order.
                prop_assert!((cut.strain_rad[i] - whole.strain_rad[i]).abs() < 1e-14);
            }
        }

        #[test]
        fn turning_takes_at_least_the_work_that_is_stored(
            kind in either(),
            history in proptest::collection::vec(-1.0..1.0_f64, 0..10),
            turn in -1.0..1.0_f64,
        ) {
            let law = pair(kind);
            let mut memory = followed(&law, &history);
            let stored_j = |m: &Memory| {
                let of = |i: usize| law.elements[i].stiffness_n_m_rad * m.strain_rad[i].powi(2);
                0.5 * (law.stiffness_n_m_rad * m.turn_rad.powi(2) + of(0) + of(1))
            };
            let (before_j, mut work_j) = (stored_j(&memory), 0.0);
            let step = turn / 2000.0;
            for _ in 0..2000 {
                let turn_rad = memory.turn_rad + step;
                let next = Memory { turn_rad, strain_rad: law.strained(&memory, turn_rad) };
                let torque = |m: &Memory| law.torque_n_m(m.turn_rad, 0.0, 0.0, m);
                work_j -= 0.5 * step * (torque(&memory) + torque(&next));
                memory = next;
            }
            // Trapezia on a torque that bends by k/y² = 2e-4 N·m/rad²: (5e-4)²/12 of it.
            prop_assert!(work_j - (stored_j(&memory) - before_j) > -5e-12, "{work_j}");
        }
    }

    #[test]
    fn a_strain_follows_small_turns_and_saturates_at_large_ones() {
        for (kind, after_a_fifth) in
            [(YieldLaw::Slip, 0.02), (YieldLaw::Dahl, 0.1 * (1.0 - (-0.2_f64).exp()))]
        {
            let law = pair(kind);
            for sense in [1.0, -1.0] {
                let strain = followed(&law, &[sense * 0.02]).strain_rad[0];
                assert!((strain - sense * after_a_fifth).abs() < 1e-16, "{kind:?}");
                let strain = followed(&law, &[sense * 100.0]).strain_rad[0];
                assert!((strain - sense * 0.1).abs() < 1e-16, "{kind:?}");
            }
        }
    }

    #[test]
    fn a_turn_of_nothing_changes_no_strain() {
        for kind in [YieldLaw::Slip, YieldLaw::Dahl] {
            let law = pair(kind);
            for history in [[0.03, 0.0], [1.0, -0.02], [-2.0, 0.7]] {
                let memory = followed(&law, &history);
                let again = law.strained(&memory, memory.turn_rad);
                for (a, b) in again.iter().zip(&memory.strain_rad) {
                    assert!((a - b).abs() <= f64::EPSILON * b.abs(), "{kind:?}: {a} {b}");
                }
            }
        }
    }

    #[test]
    fn the_regime_tells_direction_and_slip() {
        let law = pair(YieldLaw::Slip);
        let stuck = followed(&law, &[0.05]);
        let slipping = followed(&law, &[0.2]);
        let of = |memory: &Memory, rate| law.regime(memory.turn_rad, rate, memory);
        let all = [of(&stuck, 1.0), of(&stuck, -1.0), of(&slipping, 1.0)];
        assert!(all[0] != all[1] && all[0] != all[2] && all[1] != all[2], "{all:?}");
        assert_eq!(of(&slipping, -1.0), of(&stuck, -1.0), "turned back, every element sticks");
        let ahead = |turn_rad| law.regime(turn_rad, 1.0, &stuck);
        assert_eq!(ahead(0.099), ahead(0.05));
        assert_ne!(ahead(0.101), ahead(0.05), "the first element yields at 0.1");
        let dahl = pair(YieldLaw::Dahl);
        assert_eq!(dahl.regime(9.0, 1.0, &stuck), dahl.regime(0.0, 1.0, &stuck));
    }

    #[test]
    fn the_stiffest_slope_is_that_of_the_torque_on_an_elastic_thread() {
        let law = pair(YieldLaw::Slip);
        let torque = |turn_rad| law.torque_n_m(turn_rad, 0.0, 0.3, &Memory::default());
        let slope = (torque(0.04) - torque(0.02)) / 0.02;
        // Linear below the first yield at 0.1, so exact but for roundings of 1e-6 N·m / 0.02.
        assert!((slope + law.stiffness_max_n_m_rad()).abs() < 1e-18, "{slope}");
        let linear = ThreadLaw::new(&Body::new(&PARAMS).unwrap(), None, None).unwrap();
        assert!(law.yields() && !linear.yields());
        let small = law.stiffness_max_n_m_rad() - linear.stiffness_max_n_m_rad();
        assert!((small - 3e-6).abs() < 1e-20, "{small}");
    }

    #[test]
    fn the_neutral_angle_of_a_held_thread_goes_to_its_share() {
        let creep = Creep { time_s: 10.0, share: 0.4 };
        let law = ThreadLaw::new(&Body::new(&PARAMS).unwrap(), None, Some(&creep)).unwrap();
        let held_rad = 2.0;
        let neutral_rad = (0..5000).fold(0.0, |neutral_rad, _| {
            law.neutral_after_rad(neutral_rad, (held_rad, held_rad), 0.01)
        });
        let expected_rad = 0.4 * held_rad * (1.0 - (-5.0_f64).exp());
        // The trapezoidal rule errs by (h/T)²·t/12T = 4e-7 of what is left, 0.8 e⁻⁵ rad.
        assert!((neutral_rad - expected_rad).abs() < 1e-8, "{neutral_rad}");
        assert!((law.neutral_rate_rad_s(held_rad, 0.1) - 0.07).abs() < 1e-16);
    }

    #[test]
    fn threads_that_cannot_be_are_refused_by_name_and_bound() {
        let refusal = |elements: &[YieldElement]| {
            let refused = law(YieldLaw::Slip, elements).unwrap_err();
            assert!(!refused.reason.is_empty());
            (refused.name, refused.bound)
        };
        let good = element(1e-6, 0.1);
        assert_eq!(refusal(&[]), ("yield_elements", Bound::AtLeast(1.0)));
        assert_eq!(refusal(&[good; 5]), ("yield_elements", Bound::AtMost(4.0)));
        assert!(law(YieldLaw::Slip, &[good; 4]).is_ok());
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let positive = Bound::Above(0.0);
            assert_eq!(refusal(&[good, element(bad, 0.1)]), ("yield_stiffness_n_m_rad", positive));
            assert_eq!(refusal(&[good, element(1e-6, bad)]), ("yield_rad", positive));
        }
    }

    #[test]
    fn creeps_that_cannot_be_are_refused_by_name_and_bound() {
        let body = Body::new(&PARAMS).unwrap();
        let refusal = |time_s: f64, share: f64| {
            let refused = ThreadLaw::new(&body, None, Some(&Creep { time_s, share })).unwrap_err();
            (refused.name, refused.bound)
        };
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(refusal(bad, 0.5), ("creep_time_s", Bound::Above(0.0)));
        }
        assert_eq!(refusal(10.0, -0.1), ("creep_share", Bound::AtLeast(0.0)));
        assert_eq!(refusal(10.0, f64::NAN), ("creep_share", Bound::AtLeast(0.0)));
        assert_eq!(refusal(10.0, 1.1), ("creep_share", Bound::AtMost(1.0)));
        let creep = Creep { time_s: 10.0, share: 0.5 };
        let law = ThreadLaw::new(&body, None, Some(&creep)).unwrap();
        assert!(!law.yields());
        assert!((law.neutral_rate_rad_s(2.0, 0.4) - 0.06).abs() < 1e-16);
    }
}
