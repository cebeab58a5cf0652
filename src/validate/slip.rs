//! Torsion on a thread of any number of elements that slip: the body model has four at most.

use std::f64::consts::TAU;

/// An element that is elastic up to its yield strain and slips at constant torque then.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Slip {
    /// Stiffness over the thread's own.
    pub(super) stiffness_ratio: f64,
    /// Strain at which it slips, rad.
    pub(super) yield_rad: f64,
}

/// τ″ = −Ω²·τ − 2ζΩ·τ′ − Σ κᵢ·zᵢ by the classical Runge-Kutta method, where the strains zᵢ follow
/// the turn and are cut off at their yield.
#[derive(Debug, Clone)]
pub(super) struct SlipMotion {
    stiffness_s2: f64,
    damping_s: f64,
    /// Elements and their strains, rad.
    elements: Vec<(Slip, f64)>,
    angle_rad: f64,
    rate_rad_s: f64,
}

impl SlipMotion {
    /// From rest at an angle, rad, all elements relaxed.
    #[must_use]
    pub(super) fn new(period_s: f64, damping_ratio: f64, start_rad: f64, slips: &[Slip]) -> Self {
        let omega = TAU / period_s;
        Self {
            stiffness_s2: omega * omega,
            damping_s: 2.0 * damping_ratio * omega,
            elements: slips.iter().map(|slip| (*slip, 0.0)).collect(),
            angle_rad: start_rad,
            rate_rad_s: 0.0,
        }
    }

    fn acceleration(&self, angle_rad: f64, rate_rad_s: f64) -> f64 {
        let turn_rad = angle_rad - self.angle_rad;
        let torque = |(slip, z): &(Slip, f64)| {
            slip.stiffness_ratio * (z + turn_rad).clamp(-slip.yield_rad, slip.yield_rad)
        };
        let friction: f64 = self.elements.iter().map(torque).sum();
        -self.stiffness_s2 * (angle_rad + friction) - self.damping_s * rate_rad_s
    }

    /// Angle, rad, and rate, rad/s, a step later.
    pub(super) fn step(&mut self, h: f64) -> (f64, f64) {
        let (x, v) = (self.angle_rad, self.rate_rad_s);
        let a1 = self.acceleration(x, v);
        let v2 = v + 0.5 * h * a1;
        let a2 = self.acceleration(x + 0.5 * h * v, v2);
        let v3 = v + 0.5 * h * a2;
        let a3 = self.acceleration(x + 0.5 * h * v2, v3);
        let v4 = v + h * a3;
        let a4 = self.acceleration(x + h * v3, v4);
        let later_rad = x + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
        for (slip, z) in &mut self.elements {
            *z = (*z + later_rad - x).clamp(-slip.yield_rad, slip.yield_rad);
        }
        self.angle_rad = later_rad;
        self.rate_rad_s = v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
        (self.angle_rad, self.rate_rad_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use struna_body::{
        Body, BodyParams, Hysteresis, Integrator, Rig, StartState, Torsion, TorsionDamping,
        TorsionStiffness, TruthMotion, YieldElement, YieldLaw, reference,
    };
    use struna_kernel::{SampleGrid, SimTime};

    #[test]
    fn the_slipping_thread_is_the_body_models_where_that_has_it() {
        let slips = [(4.0, 0.01), (3.0, 0.02), (2.0, 0.05), (1.0, 0.1)]
            .map(|(stiffness_ratio, yield_rad)| Slip { stiffness_ratio, yield_rad });
        let torsion = Torsion {
            stiffness: TorsionStiffness::PeriodS(480.0),
            damping: TorsionDamping::Ratio(0.01),
        };
        let body = Body::new(&BodyParams { torsion, ..reference::PARAMS }).unwrap();
        let element = |slip: Slip| YieldElement {
            stiffness_n_m_rad: slip.stiffness_ratio * body.stiffness_n_m_rad(),
            yield_rad: slip.yield_rad,
        };
        let elements = slips.map(element).into();
        let hysteresis = Some(Hysteresis { law: YieldLaw::Slip, elements });
        let rig = Rig { hysteresis, ..Rig::from(body) };
        let start = StartState::twisted(6.0, 0.0);
        let mut theirs = TruthMotion::new(rig, &start, Integrator::Rk4 { step_s: 0.01 }).unwrap();
        let mut ours = SlipMotion::new(480.0, 0.01, 6.0, &slips);
        let grid = SampleGrid::new(SimTime::ZERO, 100.0).unwrap();
        for k in 1..=24_000 {
            let (angle_rad, rate_rad_s) = ours.step(0.01);
            let now = theirs.motion_at(grid.time_of(k)).unwrap();
            // Same method and step: rounding, and the form in which the body model keeps its twist.
            assert!((angle_rad - now.twist_rad).abs() < 1e-8, "sample {k}");
            assert!((rate_rad_s - now.twist_rate_rad_s).abs() < 1e-9, "sample {k}");
        }
    }
}
