//! Friction only ever takes energy, and no strain exceeds its yield.

use crate::{FOUR, LAWS, at_s, rig};
use struna_body::ode::Rk4;
use struna_body::{
    Body, FullEquations, Integrator, StartState, TruthMotion, YieldElement, YieldLaw, reference,
};

/// States of [`FullEquations`]: rate about the body axis, turn, and the first strain.
const RATE: usize = 10;
const TURN: usize = 11;
const STRAIN: usize = 14;

#[test]
fn no_strain_ever_exceeds_its_yield() {
    for law in LAWS {
        let equations = FullEquations::new(&rig(law, &FOUR, 0.0)).unwrap();
        // Steps far too long to be accurate: the bound is the map's own, not the step's.
        for step_s in [0.3, 2.0, 7.0] {
            let mut walk = Rk4::new(step_s, equations.states(&reference::S1).unwrap()).unwrap();
            let mut highest = [0.0_f64; 4];
            for k in 0..200 {
                let y = walk.state_at(&equations, step_s * f64::from(k)).unwrap();
                for (i, (_, yield_deg)) in FOUR.iter().enumerate() {
                    let share = y[STRAIN + i].abs() / yield_deg.to_radians();
                    highest[i] = highest[i].max(share);
                }
            }
            // Sums of two rounded products: a bit or two above one at most.
            assert!(highest.iter().all(|s| *s <= 1.0 + 4.0 * f64::EPSILON), "{law:?}: {highest:?}");
            assert!(highest[..2].iter().all(|s| *s > 0.99), "they must yield: {highest:?}");
        }
    }
}

#[test]
fn a_yielding_thread_never_gains_energy() {
    for law in LAWS {
        let rig = rig(law, &FOUR, 0.0);
        let equations = FullEquations::new(&rig).unwrap();
        let mut walk = Rk4::new(0.05, equations.states(&reference::S1).unwrap()).unwrap();
        let (k, c) = (rig.body.stiffness_n_m_rad(), rig.body.params().inertia_kg_m2[2]);
        let mut energy = |time_s: f64| {
            let y = walk.state_at(&equations, time_s).unwrap();
            let strained = FOUR.iter().enumerate();
            let yielding: f64 = strained.map(|(i, (s, _))| s * k * y[STRAIN + i].powi(2)).sum();
            0.5 * (c * y[RATE].powi(2) + k * y[TURN].powi(2) + yielding)
        };
        let start_j = energy(0.0);
        let mut last_j = start_j;
        for step in 1..=12_000_i32 {
            let now_j = energy(0.05 * f64::from(step));
            // At a reversal the map forgets what lay between two steps: an overshoot of at most
            // a·h²/8 = 6e-6 rad of strain, second order in h, against strains of 0.1 rad.
            assert!(now_j <= last_j + 1e-8 * start_j, "{law:?}: gain at {step}");
            last_j = now_j;
        }
        assert!(last_j < 0.1 * start_j, "{law:?}: friction must take most of it");
    }
}

/// Slip elements followed from outside: strain, and the work that slipping has turned to heat.
struct Slip {
    element: YieldElement,
    strain_rad: f64,
    heat_j: f64,
}

impl Slip {
    fn turn(&mut self, change_rad: f64) {
        let YieldElement { stiffness_n_m_rad, yield_rad } = self.element;
        let elastic_rad = self.strain_rad + change_rad;
        self.strain_rad = elastic_rad.clamp(-yield_rad, yield_rad);
        let slipped_rad = (elastic_rad - self.strain_rad).abs();
        self.heat_j += stiffness_n_m_rad * yield_rad * slipped_rad;
    }

    fn energy_j(&self) -> f64 {
        0.5 * self.element.stiffness_n_m_rad * self.strain_rad.powi(2) + self.heat_j
    }
}

/// Largest departure of spring, motion, strains and heat from their sum at the start, J, in a run
/// of `end_s`; and the heat at its end, J.
fn imbalance_j(start: &StartState, end_s: i32) -> (f64, f64) {
    let rig = rig(YieldLaw::Slip, &FOUR, 0.0);
    let body: Body = rig.body;
    let elements = rig.hysteresis.clone().unwrap().elements;
    let mut slips: Vec<_> = elements
        .into_iter()
        .map(|element| Slip { element, strain_rad: 0.0, heat_j: 0.0 })
        .collect();
    let mut run = TruthMotion::new(rig, start, Integrator::Rk4 { step_s: 1e-3 }).unwrap();
    let first = run.motion_at(at_s(0.0)).unwrap();
    let (start_j, mut turn_rad, mut worst_j) = (body.energy_j(&first), first.twist_rad, 0.0_f64);
    for k in 1..=1000 * end_s {
        let motion = run.motion_at(at_s(1e-3 * f64::from(k))).unwrap();
        slips.iter_mut().for_each(|slip| slip.turn(motion.twist_rad - turn_rad));
        turn_rad = motion.twist_rad;
        let kept_j: f64 = slips.iter().map(Slip::energy_j).sum();
        worst_j = worst_j.max((body.energy_j(&motion) + kept_j - start_j).abs());
    }
    (worst_j, slips.iter().map(|slip| slip.heat_j).sum())
}

#[test]
fn what_the_motion_loses_is_the_heat_of_slipping() {
    for (name, start, end_s) in [("torsion", reference::S1, 300), ("swing", reference::S3, 60)] {
        let (worst_j, heat_j) = imbalance_j(&start, end_s);
        println!("{name}: {worst_j:.1e} J of {heat_j:.1e} J lost unaccounted for");
        assert!(heat_j > 1e-5, "{name}: it must slip");
        // The integrator's own drift of the swing's 15 mJ, 5e-9 of it in 480 s at this step; the
        // overshoots at reversals, a·h²/8 of strain, come to a thousandth of that.
        assert!(worst_j < 1e-6 * heat_j, "{name}: {worst_j:e} of {heat_j:e} J");
    }
}
