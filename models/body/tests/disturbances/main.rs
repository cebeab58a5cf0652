//! What disturbs the motion, each effect against its closed form.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod air;
mod clamp;
mod impulses;
mod noise;

use struna_body::{
    Body, BodyParams, Integrator, Rig, StartState, Torsion, TorsionDamping, TorsionStiffness,
    TruthMotion, reference,
};
use struna_kernel::{BodyMotion, SimTime};

const RK4_1MS: Integrator = Integrator::Rk4 { step_s: 1e-3 };
const RECORD: Integrator = Integrator::Dop853 { rtol: 1e-12, atol: 1e-12 };

/// The reference body on a string with this torsion period and damping ratio.
fn damped(period_s: f64, ratio: f64) -> Body {
    let torsion = Torsion {
        stiffness: TorsionStiffness::PeriodS(period_s),
        damping: TorsionDamping::Ratio(ratio),
    };
    Body::new(&BodyParams { torsion, ..reference::PARAMS }).unwrap()
}

/// The reference body on a string that does not resist twist.
fn limp() -> Body {
    let torsion = Torsion {
        stiffness: TorsionStiffness::ConstantNMRad(0.0),
        damping: TorsionDamping::CoefficientNMSRad(0.0),
    };
    Body::new(&BodyParams { torsion, ..reference::PARAMS }).unwrap()
}

fn run(rig: &Rig, start: &StartState, integrator: Integrator) -> TruthMotion {
    TruthMotion::new(rig.clone(), start, integrator).unwrap()
}

fn at_s(seconds: f64) -> SimTime {
    SimTime::from_s(seconds).unwrap()
}

fn difference_rad(a: &BodyMotion, b: &BodyMotion) -> f64 {
    // Not `angle_to`: its arc cosine loses half the digits near zero.
    2.0 * (a.q_wb.inverse() * b.q_wb).imag().norm().asin()
}
