//! One step of the motion in any lanes: the fast form of the equations, and RK4 on them.

use super::lanes::Num;
use crate::Body;

/// States of the fast form: γ (x, y, z), ω (x, y, z), twist, spin.
pub const FAST_STATES: usize = 8;
/// Place of the twist among the states.
pub(super) const TWIST: usize = 6;
/// Most elements of a thread's hysteresis.
pub const SLIP_ELEMENTS_MAX: usize = 4;

/// What the equations need of a body, combined once.
#[derive(Debug, Clone, Copy)]
pub(super) struct Coefficients<N> {
    /// 1/A, 1/B, 1/C.
    pub(super) inverse_inertia: [N; 3],
    /// (C−B)/A, (A−C)/B, (B−A)/C: Euler's equations divided by the moments.
    pub(super) gyroscopic: [N; 3],
    /// M d², kg·m².
    pub(super) sway: N,
    /// M d²/A and M d²/B.
    pub(super) sway_ratio: [N; 2],
    /// M g d, N·m.
    pub(super) pendulum: N,
    /// k, N·m/rad.
    pub(super) stiffness: N,
    /// c, N·m·s/rad.
    pub(super) damping: N,
}

impl Coefficients<f64> {
    pub(super) fn of(body: &Body) -> Self {
        let p = body.params();
        let [a, b, c] = p.inertia_kg_m2;
        let sway = p.mass_kg * p.com_depth_m * p.com_depth_m;
        Self {
            inverse_inertia: [1.0 / a, 1.0 / b, 1.0 / c],
            gyroscopic: [(c - b) / a, (a - c) / b, (b - a) / c],
            sway,
            sway_ratio: [sway / a, sway / b],
            pendulum: p.mass_kg * p.gravity_m_s2 * p.com_depth_m,
            stiffness: body.stiffness_n_m_rad(),
            damping: body.damping_n_m_s_rad(),
        }
    }
}

impl<N: Num> Coefficients<N> {
    /// `one` in every lane.
    pub(super) fn splat(one: &Coefficients<f64>) -> Self {
        Self {
            inverse_inertia: splat(&one.inverse_inertia),
            gyroscopic: splat(&one.gyroscopic),
            sway: N::splat(one.sway),
            sway_ratio: splat(&one.sway_ratio),
            pendulum: N::splat(one.pendulum),
            stiffness: N::splat(one.stiffness),
            damping: N::splat(one.damping),
        }
    }

    pub(super) fn set_lane(&mut self, lane: usize, one: &Coefficients<f64>) {
        set_lane(&mut self.inverse_inertia, lane, &one.inverse_inertia);
        set_lane(&mut self.gyroscopic, lane, &one.gyroscopic);
        self.sway.set_lane(lane, one.sway);
        set_lane(&mut self.sway_ratio, lane, &one.sway_ratio);
        self.pendulum.set_lane(lane, one.pendulum);
        self.stiffness.set_lane(lane, one.stiffness);
        self.damping.set_lane(lane, one.damping);
    }

    /// The derivative of the states under a body torque, N·m, and what the thread's hysteresis
    /// adds to the restoring torque of the twist, N·m; and the pull of the string times d, N·m.
    /// One division, and no library function.
    #[inline(always)]
    pub(super) fn derivative(
        &self,
        y: &[N; FAST_STATES],
        torque: &[N; 3],
        drag: N,
    ) -> ([N; FAST_STATES], N) {
        let [g1, g2, g3, w1, w2, w3, twist, _spin] = *y;
        let one = N::splat(1.0);
        let upright = one + g3;
        let [ma, mb] = self.sway_ratio;
        let reaction = ma.times_plus(g2 * g2, mb.times_plus(g1 * g1, one));
        let inverse = one / (upright * reaction);
        let (inverse_upright, inverse_reaction) = (reaction * inverse, upright * inverse);

        let g1_rate = g3.times_from(w2, g2 * w3);
        let g2_rate = g1.times_from(w3, g3 * w1);
        let g3_rate = g2.times_from(w1, g1 * w2);
        let fall = g2_rate.times_from(w1, g1_rate * w2);
        let weight = self.sway.times_from(fall, self.pendulum);

        let twist_rate = w3.times_plus(upright, w2.times_plus(g2, w1 * g1)) * inverse_upright;
        let restoring = self.stiffness.times_plus(twist, self.damping.times_plus(twist_rate, drag));
        let string = restoring * inverse_upright;

        let [ia, ib, ic] = self.inverse_inertia;
        let [e1, e2, e3] = self.gyroscopic;
        // J⁻¹ times everything on the right, as if the string's force did not react.
        let n1 = weight.times_from(g2, string.times_from(g1, torque[0]));
        let n2 = weight.times_plus(g1, string.times_from(g2, torque[1]));
        let n3 = string.times_from(upright, torque[2]);
        let j1 = e1.times_from(w2 * w3, ia * n1);
        let j2 = e2.times_from(w3 * w1, ib * n2);
        let j3 = e3.times_from(w1 * w2, ic * n3);
        // Sherman-Morrison takes the reaction of the string's force out again.
        let s = self.sway * g2.times_from(j1, g1 * j2) * inverse_reaction;
        let (w1_rate, w2_rate) = (g2.times_plus(ia * s, j1), g1.times_from(ib * s, j2));
        let rates = [g1_rate, g2_rate, g3_rate, w1_rate, w2_rate, j3, twist_rate, w3];
        (rates, weight - s)
    }
}

/// Maxwell-slip elements of a thread: springs in parallel to its own, each of which slips at its
/// yield.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slip<N> {
    /// kh, N·m/rad.
    pub(super) stiffness: [N; SLIP_ELEMENTS_MAX],
    /// Largest elastic twist, rad.
    pub(super) yield_twist: [N; SLIP_ELEMENTS_MAX],
    /// Elastic twist now, rad.
    pub(super) elastic: [N; SLIP_ELEMENTS_MAX],
}

impl<N: Num> Slip<N> {
    /// Elastic twist of one element after the twist has moved by `change`: the return map. It
    /// cannot overshoot the yield, whatever the step.
    #[inline(always)]
    fn mapped(&self, element: usize, change: N) -> N {
        let limit = self.yield_twist[element];
        let least = N::splat(0.0) - limit;
        (self.elastic[element] + change).min(limit).max(least)
    }

    /// Restoring torque of the first `M` elements after the twist has moved by `change`.
    #[inline(always)]
    fn torque<const M: usize>(&self, change: N) -> N {
        let mut sum = N::splat(0.0);
        for element in 0..M {
            sum = self.stiffness[element].times_plus(self.mapped(element, change), sum);
        }
        sum
    }

    #[inline(always)]
    fn commit<const M: usize>(&mut self, change: N) {
        for element in 0..M {
            self.elastic[element] = self.mapped(element, change);
        }
    }
}

/// A step's length and the fractions of it that RK4 uses, s.
#[derive(Debug, Clone, Copy)]
pub(super) struct StepLength {
    full_s: f64,
    half_s: f64,
    sixth_s: f64,
}

impl StepLength {
    pub(super) fn new(step_s: f64) -> Self {
        Self { full_s: step_s, half_s: 0.5 * step_s, sixth_s: step_s / 6.0 }
    }

    pub(super) fn full_s(&self) -> f64 {
        self.full_s
    }
}

/// One RK4 step under a held torque, with the first `M` slip elements evaluated by their return
/// map inside the stages and committed once. The arithmetic is that of [`crate::ode::rk4_step`] to
/// the bit. Gives the pull of the string times d at the start of the step, N·m.
#[inline(always)]
pub(super) fn step<N: Num, const M: usize>(
    body: &Coefficients<N>,
    slip: &mut Slip<N>,
    y: &mut [N; FAST_STATES],
    torque: &[N; 3],
    length: &StepLength,
) -> N {
    let (full, half) = (N::splat(length.full_s), N::splat(length.half_s));
    let (sixth, two) = (N::splat(length.sixth_s), N::splat(2.0));
    let from = *y;
    let (k1, pull) = body.derivative(&from, torque, slip.torque::<M>(N::splat(0.0)));
    let at = moved(&from, half, &k1);
    let (k2, _) = body.derivative(&at, torque, slip.torque::<M>(at[TWIST] - from[TWIST]));
    let at = moved(&from, half, &k2);
    let (k3, _) = body.derivative(&at, torque, slip.torque::<M>(at[TWIST] - from[TWIST]));
    let at = moved(&from, full, &k3);
    let (k4, _) = body.derivative(&at, torque, slip.torque::<M>(at[TWIST] - from[TWIST]));
    for i in 0..FAST_STATES {
        let sum = two.times_plus(k2[i] + k3[i], k1[i]) + k4[i];
        y[i] = sixth.times_plus(sum, from[i]);
    }
    slip.commit::<M>(y[TWIST] - from[TWIST]);
    rescale(y);
    pull
}

/// `y + reach·slope`.
#[inline(always)]
fn moved<N: Num>(y: &[N; 8], reach: N, slope: &[N; 8]) -> [N; 8] {
    let mut out = *y;
    for i in 0..FAST_STATES {
        out[i] = reach.times_plus(slope[i], y[i]);
    }
    out
}

/// Pulls γ back to unit length by one Newton step of the inverse root: exact to the square of the
/// deviation, and free of root and division.
#[inline(always)]
pub(super) fn rescale<N: Num>(y: &mut [N; FAST_STATES]) {
    let scale = N::splat(0.5).times_from(norm2(y), N::splat(1.5));
    for component in &mut y[..3] {
        *component = *component * scale;
    }
}

/// |γ|².
#[inline(always)]
pub(super) fn norm2<N: Num>(y: &[N; FAST_STATES]) -> N {
    y[2].times_plus(y[2], y[1].times_plus(y[1], y[0] * y[0]))
}

#[inline(always)]
pub(super) fn splat<N: Num, const K: usize>(one: &[f64; K]) -> [N; K] {
    one.map(N::splat)
}

pub(super) fn set_lane<N: Num, const K: usize>(all: &mut [N; K], lane: usize, one: &[f64; K]) {
    for (all, one) in all.iter_mut().zip(one) {
        all.set_lane(lane, *one);
    }
}

pub(super) fn lane<N: Num, const K: usize>(all: &[N; K], lane: usize) -> [f64; K] {
    let mut one = [0.0; K];
    for (one, all) in one.iter_mut().zip(all) {
        *one = all.lane(lane);
    }
    one
}
