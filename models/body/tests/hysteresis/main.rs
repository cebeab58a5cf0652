//! The yielding thread against an independent reference, and against what friction may do.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod convergence;
mod energy;
mod split;
mod turning;

use split::Yielding;
use struna_body::{
    Body, BodyParams, Hysteresis, Rig, Torsion, TorsionDamping, TorsionStiffness, YieldElement,
    YieldLaw, reference,
};
use struna_kernel::SimTime;

/// One element, or four that share ten times the thread's stiffness as 4 : 3 : 2 : 1.
const ONE: [(f64, f64); 1] = [(10.0, 25.0)];
const FOUR: [(f64, f64); 4] = [(4.0, 5.0), (3.0, 12.0), (2.0, 25.0), (1.0, 50.0)];
const LAWS: [YieldLaw; 2] = [YieldLaw::Slip, YieldLaw::Dahl];

/// The reference body with elements given as stiffness over the thread's and yield in degrees.
fn rig(law: YieldLaw, elements: &[(f64, f64)], damping_ratio: f64) -> Rig {
    let torsion = Torsion {
        stiffness: TorsionStiffness::PeriodS(480.0),
        damping: TorsionDamping::Ratio(damping_ratio),
    };
    let body = Body::new(&BodyParams { torsion, ..reference::PARAMS }).unwrap();
    let element = |(share, yield_deg): &(f64, f64)| YieldElement {
        stiffness_n_m_rad: share * body.stiffness_n_m_rad(),
        yield_rad: yield_deg.to_radians(),
    };
    let elements: Vec<_> = elements.iter().map(element).collect();
    let hysteresis = (!elements.is_empty()).then_some(Hysteresis { law, elements });
    Rig { hysteresis, ..Rig::from(body) }
}

/// The same torsion for the reference.
fn yielding(law: YieldLaw, elements: &[(f64, f64)]) -> Yielding {
    let stiffness_s2 = (std::f64::consts::TAU / 480.0).powi(2);
    let element = |(share, yield_deg): &(f64, f64)| split::Element {
        stiffness_s2: share * stiffness_s2,
        yield_rad: yield_deg.to_radians(),
    };
    let elements = elements.iter().map(element).collect();
    Yielding { stiffness_s2, dahl: law == YieldLaw::Dahl, elements }
}

fn at_s(seconds: f64) -> SimTime {
    SimTime::from_s(seconds).unwrap()
}

/// Slope of log |error| against log step by least squares.
fn order(errors: &[(f64, f64)]) -> f64 {
    let n = errors.len() as f64;
    let logs: Vec<_> = errors.iter().map(|(h, e)| (h.log2(), e.abs().log2())).collect();
    let (mean_h, mean_e) = logs.iter().fold((0.0, 0.0), |(a, b), (h, e)| (a + h / n, b + e / n));
    let over: f64 = logs.iter().map(|(h, e)| (h - mean_h) * (e - mean_e)).sum();
    over / logs.iter().map(|(h, _)| (h - mean_h).powi(2)).sum::<f64>()
}
