//! Mean and covariance of the eight states, and the two steps of the extended Kalman filter.

use super::config::DEG;
use crate::EstimatorError;
use crate::augmented::transition::{Noise, Transition};
use crate::checks::in_range;
use crate::state_bytes::{Reader, RestoreError, Writer};

/// Number of states.
pub(super) const N: usize = 8;
/// The first states are those of the linear thread's filter.
pub(super) const LINEAR: usize = 5;
// Places of the states.
pub(super) const ALPHA: usize = 0;
pub(super) const RATE: usize = 1;
pub(super) const S: usize = 2;
pub(super) const D: usize = 3;
pub(super) const BIAS: usize = 4;
pub(super) const U: usize = 5;
pub(super) const LN_KH: usize = 6;
pub(super) const LN_F: usize = 7;

/// States that a prediction moves; the other rows of its Jacobian are those of the identity.
const MOVED: [usize; 3] = [ALPHA, RATE, U];

/// Largest phase of the stiffest spring in one step, rad, and largest decay. The midpoint rule then
/// errs by a 24th of the cube, 5e-6 of the amplitude.
const STEP_PHASE_MAX: f64 = 0.05;
/// Steps in one prediction at most. A gap that would take more, some eighty periods of a stiff
/// thread, is walked in longer steps: the walk of the friction has by then taken away the angle.
const STEPS_MAX: u32 = 4096;

/// What Dahl's law may leave out: a change of the friction by δ adds a variance of LAW²·f·|δ|, so a
/// full reversal 0.28·f. Real threads approach their yield differently, and where friction does not
/// change there is nothing to be wrong about. A noise in time that covers a thread of six slipping
/// elements as well claims a quarter more and errs by a third more.
const LAW: f64 = 0.2;

/// Mean and covariance of (α, ω, s, d, b, u, ln k_h, ln f).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DahlState {
    pub(super) mean: [f64; N],
    /// Symmetric to the last bit: see [`DahlState::updated`].
    pub(super) p: [[f64; N]; N],
}

/// What belongs to the thread and does not evolve. All of it scales with Ω₀, so that a thread of
/// another period is the same thread in slow motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Friction {
    /// Square of the rate below which the friction's direction is not told from the rate, rad²/s².
    pub(super) slow2: f64,
    /// Densities of the noise.
    pub(super) q: FrictionNoise,
    /// Bounds of ln k_h and of ln f.
    pub(super) ln_kh_bounds: (f64, f64),
    pub(super) ln_f_bounds: (f64, f64),
}

/// Process noise densities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FrictionNoise {
    /// White angular acceleration, rad²/s³.
    pub(super) acceleration: f64,
    /// Random walk of the bias, rad²/s³.
    pub(super) bias: f64,
    /// Random walk of the friction, rad²/s⁵.
    pub(super) torque: f64,
    /// Random walk of both logarithms, 1/s.
    pub(super) logarithms: f64,
}

/// What a measurement is to a state before it is taken in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Expectation8 {
    /// Measured minus expected rate, rad/s.
    pub(super) residual: f64,
    /// H·P·Hᵀ, rad²/s².
    pub(super) spread: f64,
    /// P·Hᵀ.
    columns: [f64; N],
}

impl Friction {
    /// The friction's constants for a thread of about this Ω₀, rad/s, where the linear filter
    /// reckons with these densities, rad²/s³.
    pub(super) fn of(omega: f64, acceleration: f64, bias: f64) -> Self {
        let s = omega * omega;
        let period_s = core::f64::consts::TAU / omega;
        // 0.01 °/s, 1e-8 (°/s²)²/Hz, (0.5°·Ω²)² in half a minute and 1e-7 per second at 480 s.
        let slow = 0.764 * DEG * omega;
        let shaking = 0.0668 * DEG;
        let wandering = 0.5 * DEG * s;
        Self {
            slow2: slow * slow,
            q: FrictionNoise {
                acceleration: acceleration.max(shaking * shaking * s * omega),
                bias,
                torque: 2.0 * wandering * wandering / (0.125 * period_s),
                logarithms: 4.8e-5 / period_s,
            },
            ln_kh_bounds: (libm::log(0.2 * s), libm::log(2000.0 * s)),
            ln_f_bounds: (libm::log(6e-4 * s), libm::log(40.0 * s)),
        }
    }
}

/// One step of the means, with the rows of its Jacobian that are not those of the identity.
struct Step {
    mean: [f64; N],
    rows: [[f64; N]; 3],
    noise: Noise,
    /// Largest friction, rad/s².
    f: f64,
}

impl DahlState {
    /// The state `span_s` later.
    #[inline]
    pub(super) fn predicted(&self, span_s: f64, friction: &Friction) -> Self {
        if span_s == 0.0 {
            return *self;
        }
        let steps = self.steps_in(span_s);
        let step_s = span_s / f64::from(steps);
        let mut state = self.stepped(step_s, friction);
        for _ in 1..steps {
            state = state.stepped(step_s, friction);
        }
        state
    }

    /// Steps that a span takes.
    #[inline]
    fn steps_in(&self, span_s: f64) -> u32 {
        let stiffness = self.mean[S] + libm::exp(self.mean[LN_KH]);
        let phase = (libm::sqrt(stiffness) + self.mean[D].abs()) * span_s;
        let steps = libm::ceil(phase / STEP_PHASE_MAX).clamp(1.0, f64::from(STEPS_MAX));
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let steps = steps as u32;
        steps
    }

    #[inline]
    fn stepped(&self, h: f64, friction: &Friction) -> Self {
        let step = self.step(h, friction.slow2);
        let mut p = carried(&self.p, &step.rows);
        let q = &friction.q;
        p[ALPHA][ALPHA] += q.acceleration * step.noise.aa;
        p[ALPHA][RATE] += q.acceleration * step.noise.aw;
        p[RATE][ALPHA] = p[ALPHA][RATE];
        p[RATE][RATE] += q.acceleration * step.noise.ww;
        p[BIAS][BIAS] += q.bias * h;
        let change = (step.mean[U] - self.mean[U]).abs();
        p[U][U] += q.torque * h + LAW * LAW * step.f * change;
        p[LN_KH][LN_KH] += q.logarithms * h;
        p[LN_F][LN_F] += q.logarithms * h;
        Self { mean: step.mean, p }
    }

    /// One step of the midpoint rule.
    ///
    /// The friction follows the turn at the rate of mid-step, and exactly: u′ = k_h·(ω − |ω|·u/f)
    /// is linear in u while ω is held, and no step overshoots f however small f is. The rest then
    /// moves under the mean of the friction before and after, which is a shift of α.
    fn step(&self, h: f64, slow2: f64) -> Step {
        let [alpha, rate, s, d, bias, u, ln_kh, ln_f] = self.mean;
        let (kh, f) = (libm::exp(ln_kh), libm::exp(ln_f));
        let mid = rate + 0.5 * h * (alpha - u - d * rate);
        let smooth2 = mid * mid + slow2;
        let inverse = 1.0 / libm::sqrt(smooth2);
        let sense = mid * inverse;
        let by_turn = kh * h / f;
        let left = libm::exp(-by_turn * mid.abs());
        let gap = u - f * sense;
        let u_later = f * sense + gap * left;

        // ∂u⁺ by mid-step rate, ln k_h and ln f; by u itself it is `left`.
        let used = gap * left * by_turn;
        let sense_by_mid = slow2 * inverse / smooth2;
        let by_mid = f * sense_by_mid * (1.0 - left) - used * sign(mid);
        let by_ln_kh = -used * mid.abs();
        let by_ln_f = f * sense * (1.0 - left) - by_ln_kh;
        let mut u_row = [0.0; N];
        u_row[ALPHA] = by_mid * 0.5 * h;
        u_row[RATE] = by_mid * (1.0 - 0.5 * h * d);
        u_row[D] = by_mid * (-0.5 * h * rate);
        u_row[U] = left - by_mid * 0.5 * h;
        u_row[LN_KH] = by_ln_kh;
        u_row[LN_F] = by_ln_f;

        let mean_u = 0.5 * (u + u_later);
        let mut mean_u_row = u_row.map(|by| 0.5 * by);
        mean_u_row[U] += 0.5;

        let t = Transition::over(h, s, d);
        let shifted = alpha - mean_u;
        let (shifted_later, rate_later) = t.apply(shifted, rate);
        let j = t.jacobian(shifted, rate);
        let mut alpha_row = mean_u_row.map(|by| (1.0 - j.aa) * by);
        let mut rate_row = mean_u_row.map(|by| -j.wa * by);
        for (row, by) in [
            (&mut alpha_row, [j.aa, j.aw, j.a_by_s, j.a_by_d]),
            (&mut rate_row, [j.wa, j.ww, j.w_by_s, j.w_by_d]),
        ] {
            for (entry, by) in row.iter_mut().zip(by) {
                *entry += by;
            }
        }
        Step {
            mean: [shifted_later + mean_u, rate_later, s, d, bias, u_later, ln_kh, ln_f],
            rows: [alpha_row, rate_row, u_row],
            noise: t.noise,
            f,
        }
    }

    /// How a measured rate compares with the state, z = ω + b + noise.
    #[inline]
    pub(super) fn expect(&self, rate_rad_s: f64) -> Expectation8 {
        let columns: [f64; N] = core::array::from_fn(|i| self.p[RATE][i] + self.p[BIAS][i]);
        Expectation8 {
            residual: rate_rad_s - (self.mean[RATE] + self.mean[BIAS]),
            spread: columns[RATE] + columns[BIAS],
            columns,
        }
    }

    /// Measurement update in Joseph form, as the five-state filter's, written so that entries (i,
    /// j) and (j, i) are the same sums of the same products.
    #[inline]
    pub(super) fn updated(&self, e: &Expectation8, r: f64) -> Self {
        let inverse = 1.0 / (e.spread + r);
        let c = e.columns;
        let k = c.map(|column| column * inverse);
        let rest: [f64; N] = core::array::from_fn(|i| c[i] - k[i] * e.spread - r * k[i]);
        let mut state = *self;
        for i in 0..N {
            state.mean[i] += k[i] * e.residual;
            for j in 0..N {
                let rounding = 0.5 * (rest[i] * k[j] + rest[j] * k[i]);
                state.p[i][j] -= c[i] * c[j] * inverse + rounding;
            }
        }
        state
    }

    /// Mean and covariance of the states that the linear thread's filter has too.
    pub(super) fn leading(&self) -> ([f64; LINEAR], [[f64; LINEAR]; LINEAR]) {
        let rows = core::array::from_fn(|i| core::array::from_fn(|j| self.p[i][j]));
        (core::array::from_fn(|i| self.mean[i]), rows)
    }

    /// Keeps the friction within what can be computed with.
    #[inline]
    pub(super) fn bound_friction(&mut self, friction: &Friction) {
        let clamp = |x: &mut f64, (low, high): (f64, f64)| *x = x.clamp(low, high);
        clamp(&mut self.mean[LN_KH], friction.ln_kh_bounds);
        clamp(&mut self.mean[LN_F], friction.ln_f_bounds);
    }

    /// Itself, unless a number has left the range of floating point.
    #[inline]
    pub(super) fn judged(self) -> Result<Self, EstimatorError> {
        // A sum is finite only if every term is.
        let mut sums = self.mean;
        for row in &self.p {
            for (sum, entry) in sums.iter_mut().zip(row) {
                *sum += entry;
            }
        }
        in_range(sums.iter().sum())?;
        Ok(self)
    }

    /// Eight means and the upper triangle.
    pub(super) const SAVED_LEN: usize = (N + N * (N + 1) / 2) * 8;

    pub(super) fn write(&self, out: &mut Writer<'_>) {
        for number in self.mean {
            out.f64(number);
        }
        for (i, row) in self.p.iter().enumerate() {
            for &entry in &row[i..] {
                out.f64(entry);
            }
        }
    }

    pub(super) fn read(bytes: &mut Reader<'_>) -> Result<Self, RestoreError> {
        let mut state = Self { mean: [0.0; N], p: [[0.0; N]; N] };
        for mean in &mut state.mean {
            *mean = bytes.finite("mean")?;
        }
        for i in 0..N {
            for j in i..N {
                let entry = bytes.finite("covariance")?;
                (state.p[i][j], state.p[j][i]) = (entry, entry);
            }
        }
        Ok(state)
    }
}

/// The sign of `x`, and zero for zero.
fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

/// F·P·Fᵀ, where all but the rows [`MOVED`] of F are those of the identity.
#[inline]
fn carried(p: &[[f64; N]; N], rows: &[[f64; N]; 3]) -> [[f64; N]; N] {
    let mut later = *p;
    let mut moved = [[0.0; N]; 3];
    for (product, row) in moved.iter_mut().zip(rows) {
        for (by, p_row) in row.iter().zip(p) {
            for (sum, entry) in product.iter_mut().zip(p_row) {
                *sum += by * entry;
            }
        }
    }
    for (product, i) in moved.iter().zip(MOVED) {
        for j in 0..N {
            (later[i][j], later[j][i]) = (product[j], product[j]);
        }
    }
    for (product, i) in moved.iter().zip(MOVED) {
        for (row, j) in rows.iter().zip(MOVED) {
            if j >= i {
                let entry = product.iter().zip(row).map(|(a, b)| a * b).sum();
                (later[i][j], later[j][i]) = (entry, entry);
            }
        }
    }
    later
}

#[cfg(test)]
mod tests {
    use super::*;

    const OMEGA: f64 = 0.013;

    /// States in which the friction is slack, taut, reversing, slow, and its law very steep.
    fn cases() -> impl Iterator<Item = (f64, [f64; N])> {
        let s = OMEGA * OMEGA;
        let state = move |angle: f64, rate: f64, load: f64, yields: f64, ratio: f64| {
            let f = s * yields;
            let u = load * f;
            let logarithms = (libm::log(ratio * s), libm::log(f));
            [-s * angle, rate, s, 0.02 * OMEGA, 1e-3, u, logarithms.0, logarithms.1]
        };
        [0.01, 0.3].into_iter().flat_map(move |h| {
            [
                state(6.0, 0.05, 0.0, 0.4, 10.0),
                state(3.0, -0.08, -0.9, 0.9, 10.0),
                state(-2.0, 0.03, -1.0, 0.2, 14.0),
                state(1.0, 1e-4, 0.3, 0.4, 10.0),
                state(0.2, -2e-5, 1.1, 0.05, 10.0),
                state(5.0, 0.08, 1.0, 1e-3, 500.0),
            ]
            .map(|mean| (h, mean))
        })
    }

    #[test]
    fn the_jacobian_is_the_derivative_of_the_step() {
        let slow2 = Friction::of(OMEGA, 0.0, 0.0).slow2;
        let at = |mean: [f64; N], h: f64| DahlState { mean, p: [[0.0; N]; N] }.step(h, slow2);
        for (case, (h, mean)) in cases().enumerate() {
            let rows = at(mean, h).rows;
            // Sizes of the states, and of what they do to the moved ones.
            let f = libm::exp(mean[LN_F]);
            let rate = mean[RATE].abs().max(1e-2 * OMEGA);
            let size = [f.max(mean[ALPHA].abs()), rate, mean[S], OMEGA, 1.0, f, 1.0, 1.0];
            for k in 0..N {
                let small = 1e-5 * size[k].min(if k == RATE { slow2.sqrt() } else { f64::MAX });
                let moved = |by: f64| {
                    let mut mean = mean;
                    mean[k] += by;
                    at(mean, h).mean
                };
                let (up, down) = (moved(small), moved(-small));
                for (row, i) in rows.iter().zip(MOVED) {
                    let numeric = (up[i] - down[i]) / (2.0 * small);
                    let off = (row[k] - numeric).abs() * size[k] / size[i];
                    // Differences err by 1e-10 of the third derivative, and by rounding of
                    // numbers up to 2e3 sizes large over 2e-5 of a size; the linear part's series
                    // by s·h² and d·h of its smallest entries.
                    assert!(off < 1e-6, "case {case}: row {i}, column {k}: {} {numeric}", row[k]);
                }
            }
        }
    }

    #[test]
    fn friction_never_passes_its_largest_value() {
        let friction = Friction::of(OMEGA, 0.0, 0.0);
        for (_, mut mean) in cases() {
            let f = libm::exp(mean[LN_F]);
            mean[U] = mean[U].clamp(-f, f);
            for h in [1e-3, 0.01, 1.0, 100.0] {
                let later = DahlState { mean, p: [[0.0; N]; N] }.step(h, friction.slow2).mean;
                // A sum of two products rounds.
                assert!(later[U].abs() <= f * (1.0 + 4.0 * f64::EPSILON), "{h} {}", later[U] / f);
            }
        }
    }

    #[test]
    fn covariances_stay_symmetric_to_the_last_bit_and_positive() {
        let friction = Friction::of(OMEGA, 1e-12, 1e-16);
        for (h, mean) in cases() {
            let f = libm::exp(mean[LN_F]);
            let sigma = [1e-4, 1e-3, 1e-6, 1e-4, 1e-3, 0.3 * f, 0.7, 0.6];
            let mut state = DahlState { mean, p: [[0.0; N]; N] };
            for (i, sigma) in sigma.into_iter().enumerate() {
                state.p[i][i] = sigma * sigma;
            }
            for k in 0..500 {
                state = state.predicted(h, &friction);
                let wobble = 8e-4 * libm::sin(f64::from(k));
                state = state.updated(&state.expect(mean[RATE] + wobble), 6e-7);
                state.bound_friction(&friction);
            }
            for i in 0..N {
                for j in 0..N {
                    assert_eq!(state.p[i][j].to_bits(), state.p[j][i].to_bits(), "{i} {j}");
                }
            }
            let scale: [f64; N] = core::array::from_fn(|i| state.p[i][i].sqrt());
            let correlation = nalgebra::SMatrix::<f64, N, N>::from_fn(|i, j| {
                state.p[i][j] / (scale[i] * scale[j])
            });
            assert!(correlation.cholesky().is_some(), "{correlation}");
        }
    }

    #[test]
    fn each_state_becomes_less_certain_by_its_own_walk_and_the_friction_by_its_law() {
        let friction = Friction::of(OMEGA, 1e-12, 1e-16);
        let (q, h) = (&friction.q, 10.0);
        let (s, f) = (OMEGA * OMEGA, 0.4 * OMEGA * OMEGA);
        let ln = [libm::log(10.0 * s), libm::log(f)];
        // All is known, and the thread is in balance: nothing moves.
        let still = [0.3 * f, 0.0, s, 0.0, 1e-3, 0.3 * f, ln[0], ln[1]];
        let at = |mean| DahlState { mean, p: [[0.0; N]; N] }.stepped(h, &friction);
        let grown = at(still).p;
        let walks = [(BIAS, q.bias), (U, q.torque), (LN_KH, q.logarithms), (LN_F, q.logarithms)];
        for (state, density) in walks {
            assert!((grown[state][state] / (density * h) - 1.0).abs() < 1e-12, "state {state}");
        }
        // The rate walks by the acceleration, ∫cos² Ωt over the tenth of a radian.
        let share = grown[RATE][RATE] / (q.acceleration * h);
        assert!((0.99..1.0).contains(&share), "{share}");
        // It turns, and the friction changes.
        let later = at([0.0, 0.01, s, 0.0, 0.0, 0.0, ln[0], ln[1]]);
        let change = later.mean[U].abs();
        assert!(change > 0.1 * f, "{change}");
        let law = 0.04 * f * change;
        assert!(((later.p[U][U] - q.torque * h) / law - 1.0).abs() < 1e-9, "{}", later.p[U][U]);
    }

    #[test]
    fn a_span_may_be_walked_in_any_number_of_calls() {
        let friction = Friction::of(OMEGA, 1e-12, 1e-16);
        for (_, mean) in cases() {
            let start = DahlState { mean, p: [[0.0; N]; N] };
            let whole = start.predicted(40.0, &friction).mean;
            let cut = (0..4000).fold(start, |state, _| state.predicted(0.01, &friction)).mean;
            let turned = (whole[RATE] - cut[RATE]).abs() / (OMEGA * 6.0);
            // Dozens of steps of a twentieth of a radian; reversals in them cost the most.
            assert!(turned < 2e-3, "off by {turned}");
        }
    }
}
