//! Torsion on a thread of any number of elements that slip: the body model has four at most.

use crate::rig::{START_DEG, body_motion, body_rig};
use std::f64::consts::TAU;
use struna_body::YieldLaw;
use struna_kernel::{RAD_PER_DEG, SampleGrid, SimTime};

/// τ″ = −Ω²·τ − 2ζΩ·τ′ − Σ κᵢ·zᵢ by the classical Runge-Kutta method, where the strains zᵢ follow
/// the turn and are cut off at their yield.
pub(crate) struct SlipMotion {
    stiffness_s2: f64,
    damping_s: f64,
    /// Stiffness κ, 1/s², yield strain and strain, rad.
    elements: Vec<(f64, f64, f64)>,
    angle_rad: f64,
    rate_rad_s: f64,
}

impl SlipMotion {
    /// From rest and relaxed; elements as stiffness over the thread's and yield strain, deg.
    pub(crate) fn new(period_s: f64, damping_ratio: f64, elements: &[(f64, f64)]) -> Self {
        let omega = TAU / period_s;
        let element = |&(ratio, yield_deg): &(f64, f64)| {
            (ratio * omega * omega, yield_deg * RAD_PER_DEG, 0.0)
        };
        Self {
            stiffness_s2: omega * omega,
            damping_s: 2.0 * damping_ratio * omega,
            elements: elements.iter().map(element).collect(),
            angle_rad: START_DEG * RAD_PER_DEG,
            rate_rad_s: 0.0,
        }
    }

    fn acceleration(&self, angle_rad: f64, rate_rad_s: f64) -> f64 {
        let turn_rad = angle_rad - self.angle_rad;
        let torque =
            |(kappa, limit, z): &(f64, f64, f64)| kappa * (z + turn_rad).clamp(-limit, *limit);
        let friction: f64 = self.elements.iter().map(torque).sum();
        -self.stiffness_s2 * angle_rad - self.damping_s * rate_rad_s - friction
    }

    /// Changes the rate at once.
    pub(crate) fn kick(&mut self, change_rad_s: f64) {
        self.rate_rad_s += change_rad_s;
    }

    /// Angle and rate a step later.
    pub(crate) fn step(&mut self, h: f64) -> (f64, f64) {
        let (x, v) = (self.angle_rad, self.rate_rad_s);
        let a1 = self.acceleration(x, v);
        let v2 = v + 0.5 * h * a1;
        let a2 = self.acceleration(x + 0.5 * h * v, v2);
        let v3 = v + 0.5 * h * a2;
        let a3 = self.acceleration(x + 0.5 * h * v2, v3);
        let v4 = v + h * a3;
        let a4 = self.acceleration(x + h * v3, v4);
        let later_rad = x + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
        for (_, limit, z) in &mut self.elements {
            *z = (*z + later_rad - x).clamp(-*limit, *limit);
        }
        self.angle_rad = later_rad;
        self.rate_rad_s = v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
        (self.angle_rad, self.rate_rad_s)
    }
}

#[test]
fn the_slipping_thread_is_the_body_models_where_that_has_it() {
    let elements = [(4.0, 0.5), (3.0, 1.2), (2.0, 2.5), (1.0, 5.0)];
    let mut ours = SlipMotion::new(480.0, 0.01, &elements);
    let mut theirs = body_motion(body_rig(480.0, 0.01, YieldLaw::Slip, &elements));
    let grid = SampleGrid::new(SimTime::ZERO, 100.0).unwrap();
    for k in 1..=24_000 {
        let (angle_rad, rate_rad_s) = ours.step(0.01);
        let motion = theirs.motion_at(grid.time_of(k)).unwrap();
        // Same method and step: rounding, and the form in which the body model keeps its twist.
        assert!((angle_rad - motion.twist_rad).abs() < 1e-8, "sample {k}");
        assert!((rate_rad_s - motion.twist_rate_rad_s).abs() < 1e-9, "sample {k}");
    }
}
