//! The Dormand-Prince method of order 8 with error control of orders 5 and 3 and dense output.

mod dense;
mod regime;

use super::dop853_tableau::{A, A_DENSE, B, C, D, DENSE_ROWS, E3, E5, STAGES, STAGES_ALL};
use super::{OdeError, Rhs, STEPS_MAX, all_finite, check_step, within};
use dense::Dense;

/// Hairer's error estimate behaves as h⁸, hence the exponent of the step controller.
const ERROR_EXPONENT: f64 = -1.0 / 8.0;
/// Aim below the tolerance, or every second step would be rejected.
const SAFETY: f64 = 0.9;
/// Bounds on the change of the step from one attempt to the next.
const FACTOR_MIN: f64 = 0.2;
const FACTOR_MAX: f64 = 10.0;
/// Below this many units of rounding of the clock a step no longer moves it.
const STEP_MIN_ULPS: f64 = 16.0;
const STEP_MAX_S: f64 = 1e6;
/// Below 100 roundings the error estimate measures rounding, not the method.
const RTOL_RANGE: (f64, f64) = (2.3e-14, 0.1);
const ATOL_RANGE: (f64, f64) = (1e-30, 1.0);

/// Index of the derivative at the end of the step among the stages.
const END: usize = STAGES;

/// Local error allowed in each component: `atol + rtol*|y|`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Relative part, 2.3e-14 to 0.1.
    pub rtol: f64,
    /// Absolute part, in the unit of the component, 1e-30 to 1. Never zero, because components
    /// cross zero.
    pub atol: f64,
}

impl Tolerance {
    fn scale(&self, a: f64, b: f64) -> f64 {
        self.atol + self.rtol * a.abs().max(b.abs())
    }
}

/// One step of length `step_s` from `y` at `time_s`, without projection, checks or error control.
///
/// For runs at a step known beforehand, and for measuring the method's order.
#[must_use]
pub fn dop853_step<const N: usize, R: Rhs<N>>(
    rhs: &R,
    time_s: f64,
    y: &[f64; N],
    step_s: f64,
) -> [f64; N] {
    let first = rhs.derivative(time_s, y);
    let stages = stages(rhs, time_s, y, &first, step_s);
    combined(y, step_s, &B, &stages)
}

/// `y + h * sum_j weights[j] * k[j]` over the leading stages.
pub(super) fn combined<const N: usize>(
    y: &[f64; N],
    step_s: f64,
    weights: &[f64],
    k: &[[f64; N]],
) -> [f64; N] {
    let sum = weighted(weights, k);
    let mut out = *y;
    for i in 0..N {
        out[i] += step_s * sum[i];
    }
    out
}

pub(super) fn weighted<const N: usize>(weights: &[f64], k: &[[f64; N]]) -> [f64; N] {
    let mut sum = [0.0; N];
    for (weight, stage) in weights.iter().zip(k) {
        for i in 0..N {
            sum[i] += weight * stage[i];
        }
    }
    sum
}

pub(super) fn stages<const N: usize, R: Rhs<N>>(
    rhs: &R,
    time_s: f64,
    y: &[f64; N],
    first: &[f64; N],
    step_s: f64,
) -> [[f64; N]; STAGES_ALL] {
    let mut k = [[0.0; N]; STAGES_ALL];
    k[0] = *first;
    for i in 1..STAGES {
        let start = combined(y, step_s, &A[i][..i], &k[..i]);
        k[i] = rhs.derivative(time_s + C[i] * step_s, &start);
    }
    k
}

/// A finished step and all that its dense output needs.
#[derive(Debug, Clone)]
struct Step<const N: usize> {
    start_s: f64,
    step_s: f64,
    start: [f64; N],
    /// Where the stages lead, on the polynomial that the dense output follows.
    led: [f64; N],
    /// The same, pulled back onto the manifold: where the next step starts.
    end: [f64; N],
    /// Stages of the step; the last four are filled on acceptance and on first interpolation.
    k: [[f64; N]; STAGES_ALL],
}

impl<const N: usize> Step<N> {
    fn end_s(&self) -> f64 {
        self.start_s + self.step_s
    }

    /// The mixed error norm of orders 5 and 3; at most 1 means acceptable.
    fn error_norm(&self, tolerance: &Tolerance) -> f64 {
        let (fifth, third) = (weighted(&E5, &self.k), weighted(&E3, &self.k));
        let (mut sum5, mut sum3) = (0.0, 0.0);
        for i in 0..N {
            let scale = tolerance.scale(self.start[i], self.end[i]);
            sum5 += (fifth[i] / scale).powi(2);
            sum3 += (third[i] / scale).powi(2);
        }
        if sum5 == 0.0 {
            return 0.0;
        }
        self.step_s * sum5 / ((sum5 + 0.01 * sum3) * N as f64).sqrt()
    }

    /// The interpolating polynomial of degree 7 through this step.
    fn dense<R: Rhs<N>>(&mut self, rhs: &R) -> Dense<N> {
        let h = self.step_s;
        for (row, weights) in A_DENSE.iter().enumerate() {
            let i = END + 1 + row;
            let start = combined(&self.start, h, &weights[..i], &self.k[..i]);
            self.k[i] = rhs.derivative(self.start_s + C[i] * h, &start);
        }
        let mut rows = [[0.0; N]; 3 + DENSE_ROWS];
        let [rise, start_gap, end_gap, ..] = &mut rows;
        for i in 0..N {
            rise[i] = self.led[i] - self.start[i];
            start_gap[i] = h * self.k[0][i] - rise[i];
            end_gap[i] = 2.0 * rise[i] - h * (self.k[END][i] + self.k[0][i]);
        }
        for (row, weights) in D.iter().enumerate() {
            rows[3 + row] = weighted(weights, &self.k).map(|v| h * v);
        }
        Dense { start_s: self.start_s, step_s: h, start: self.start, rows }
    }
}

/// An adaptive integration that answers at any instant.
///
/// Steps are chosen from the motion alone and run ahead of the instants asked for; answers come
/// from the dense output of order 7, so they do not depend on how often it is asked.
///
/// # Source
/// Hairer, Norsett and Wanner, *Solving Ordinary Differential Equations I*, second edition, 1993,
/// program `dop853`.
#[derive(Debug, Clone)]
pub struct Dop853<const N: usize> {
    tolerance: Tolerance,
    time_s: f64,
    state: [f64; N],
    /// Length that the controller proposes for the next step; none before the first.
    proposal_s: Option<f64>,
    step_max_s: f64,
    last: Option<Step<N>>,
    dense: Option<Dense<N>>,
}

impl<const N: usize> Dop853<N> {
    /// An integration that starts from `state` at time zero.
    ///
    /// # Errors
    /// [`OdeError::Setting`] when a tolerance is out of range.
    pub fn new(tolerance: Tolerance, state: [f64; N]) -> Result<Self, OdeError<N>> {
        within("rtol", tolerance.rtol, RTOL_RANGE)?;
        within("atol", tolerance.atol, ATOL_RANGE)?;
        let (proposal_s, step_max_s, last, dense) = (None, STEP_MAX_S, None, None);
        Ok(Self { tolerance, time_s: 0.0, state, proposal_s, step_max_s, last, dense })
    }

    /// The same integration with no step longer than `step_max_s`: for equations that change with
    /// time in ways that the states do not show beforehand.
    #[must_use]
    pub fn with_step_max(mut self, step_max_s: f64) -> Self {
        self.step_max_s = step_max_s.min(STEP_MAX_S);
        self
    }

    /// The state at `time_s`, which must not lie before the start of the last step taken.
    ///
    /// # Errors
    /// [`OdeError::Setting`] for an instant that has passed; [`OdeError::TooManySteps`],
    /// [`OdeError::StepTooSmall`], [`OdeError::Diverged`] and [`OdeError::OutsideDomain`] on the
    /// way. The integration then stays where the call found it.
    pub fn state_at<R: Rhs<N>>(&mut self, rhs: &R, time_s: f64) -> Result<[f64; N], OdeError<N>> {
        let earliest_s = self.last.as_ref().map_or(self.time_s, |step| step.start_s);
        within("time_s", time_s, (earliest_s, f64::MAX))?;
        if self.time_s < time_s {
            // Walk ahead on a copy, or a failure would leave the integration past instants that
            // can still be answered.
            let mut ahead = self.clone();
            ahead.run_past(rhs, time_s)?;
            *self = ahead;
        }
        Ok(self.interpolated(rhs, time_s))
    }

    fn run_past<R: Rhs<N>>(&mut self, rhs: &R, time_s: f64) -> Result<(), OdeError<N>> {
        for _ in 0..STEPS_MAX {
            self.step(rhs)?;
            if self.time_s >= time_s {
                return Ok(());
            }
        }
        Err(OdeError::TooManySteps { time_s: self.time_s, state: self.state })
    }

    fn interpolated<R: Rhs<N>>(&mut self, rhs: &R, time_s: f64) -> [f64; N] {
        let Some(step) = &mut self.last else { return self.state };
        self.dense.get_or_insert_with(|| step.dense(rhs)).at(time_s)
    }

    /// Takes one accepted step, however many attempts it needs.
    fn step<R: Rhs<N>>(&mut self, rhs: &R) -> Result<(), OdeError<N>> {
        let first = match &self.last {
            Some(step) => step.k[END],
            None => rhs.derivative(self.time_s, &self.state),
        };
        let mut step_s = match self.proposal_s {
            Some(step_s) => step_s,
            None => self.first_step_s(rhs, &first)?,
        };
        let mut growth_max = FACTOR_MAX;
        loop {
            self.refuse_tiny(step_s)?;
            let attempt = self.attempt(rhs, &first, step_s);
            let error = attempt.error_norm(&self.tolerance);
            // A NaN error compares false: the attempt is rejected and the step shrinks.
            if error <= 1.0 {
                self.proposal_s =
                    Some((step_s * step_factor(error, growth_max)).min(self.step_max_s));
                let step = self.within_regime(rhs, &first, attempt);
                return self.accept(rhs, step);
            }
            step_s *= step_factor(error, 1.0);
            growth_max = 1.0;
        }
    }

    fn attempt<R: Rhs<N>>(&self, rhs: &R, first: &[f64; N], step_s: f64) -> Step<N> {
        // The step that the clock really makes, or time and state would part by rounding.
        let step_s = (self.time_s + step_s) - self.time_s;
        let k = stages(rhs, self.time_s, &self.state, first, step_s);
        let led = combined(&self.state, step_s, &B, &k);
        let mut end = led;
        rhs.project(&mut end);
        Step { start_s: self.time_s, step_s, start: self.state, led, end, k }
    }

    fn accept<R: Rhs<N>>(&mut self, rhs: &R, mut step: Step<N>) -> Result<(), OdeError<N>> {
        check_step(rhs, (step.start_s, &step.start), (step.step_s, &step.end))?;
        step.k[END] = rhs.derivative(step.end_s(), &step.end);
        if !all_finite(&step.k[END]) {
            let Step { start_s: time_s, step_s, start: state, .. } = step;
            return Err(OdeError::Diverged { time_s, step_s, state });
        }
        (self.time_s, self.state) = (step.end_s(), step.end);
        self.dense = None;
        self.last = Some(step);
        Ok(())
    }

    fn refuse_tiny(&self, step_s: f64) -> Result<(), OdeError<N>> {
        // NaN fails the comparison as well.
        if step_s >= STEP_MIN_ULPS * f64::EPSILON * self.time_s.abs().max(1.0) {
            return Ok(());
        }
        Err(OdeError::StepTooSmall { time_s: self.time_s, step_s, state: self.state })
    }

    /// Hairer's guess of the first step from the size of y, y′ and y″.
    fn first_step_s<R: Rhs<N>>(&self, rhs: &R, first: &[f64; N]) -> Result<f64, OdeError<N>> {
        let (size, slope) = (self.norm(&self.state), self.norm(first));
        let probe_s = if size < 1e-5 || slope < 1e-5 { 1e-6 } else { 0.01 * size / slope };
        let mut probe = self.state;
        for i in 0..N {
            probe[i] += probe_s * first[i];
        }
        let mut bend = rhs.derivative(self.time_s + probe_s, &probe);
        for i in 0..N {
            bend[i] = (bend[i] - first[i]) / probe_s;
        }
        let steepest = slope.max(self.norm(&bend));
        let guess_s = if steepest <= 1e-15 {
            probe_s.max(1e-6)
        } else {
            (0.01 / steepest).powf(-ERROR_EXPONENT)
        };
        if all_finite(&bend) && guess_s.is_finite() {
            return Ok(guess_s.min(100.0 * probe_s).min(self.step_max_s));
        }
        Err(OdeError::Diverged { time_s: self.time_s, step_s: probe_s, state: self.state })
    }

    /// Root mean square in units of the tolerance.
    fn norm(&self, v: &[f64; N]) -> f64 {
        let mut sum = 0.0;
        for (v, y) in v.iter().zip(&self.state) {
            sum += (v / self.tolerance.scale(*y, *y)).powi(2);
        }
        (sum / N as f64).sqrt()
    }
}

/// How much longer the next step may be, given the error of this one.
fn step_factor(error: f64, growth_max: f64) -> f64 {
    let factor = SAFETY * error.powf(ERROR_EXPONENT);
    // Not `clamp`: a NaN error must shrink the step, and `max` drops the NaN.
    factor.max(FACTOR_MIN).min(growth_max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// y′ = y cos t, so y = y0 exp(sin t): nonlinear in time, which exercises the nodes.
    struct Swell;

    impl Rhs<1> for Swell {
        fn derivative(&self, time_s: f64, y: &[f64; 1]) -> [f64; 1] {
            [y[0] * time_s.cos()]
        }
    }

    /// y′ = y², which reaches infinity at t = 1/y0.
    struct Explosion;

    impl Rhs<1> for Explosion {
        fn derivative(&self, _time_s: f64, y: &[f64; 1]) -> [f64; 1] {
            [y[0] * y[0]]
        }
    }

    const TIGHT: Tolerance = Tolerance { rtol: 1e-12, atol: 1e-12 };

    fn swell(time_s: f64) -> f64 {
        time_s.sin().exp()
    }

    #[test]
    fn halving_the_step_divides_the_error_by_two_to_the_eighth() {
        let error = |steps: u32| {
            let h = 4.0 / f64::from(steps);
            let step = |y: [f64; 1], k: u32| dop853_step(&Swell, f64::from(k) * h, &y, h);
            ((0..steps).fold([1.0], step)[0] - swell(4.0)).abs()
        };
        let order = (error(8) / error(16)).log2();
        // At 16 steps the error is still 1e5 roundings; the next power of h shows within 0.5.
        assert!((order - 8.0).abs() < 0.5, "observed {order:.3}");
    }

    #[test]
    fn the_interpolant_of_one_step_errs_by_the_eighth_power_of_its_length() {
        let error = |h: f64| {
            let mut run = Dop853::new(TIGHT, [swell(0.0)]).unwrap();
            let first = Swell.derivative(0.0, &run.state);
            let step = run.attempt(&Swell, &first, h);
            run.accept(&Swell, step).unwrap();
            let worst = |worst: f64, k: u32| {
                let time_s = h * f64::from(k) / 20.0;
                worst.max((run.state_at(&Swell, time_s).unwrap()[0] - swell(time_s)).abs())
            };
            (1..20).fold(0.0, worst)
        };
        let order = (error(0.5) / error(0.25)).log2();
        // Degree 7: error h⁸, with the next power still visible at these lengths.
        assert!((order - 8.0).abs() < 0.6, "observed {order:.3}");
    }

    #[test]
    fn the_interpolant_meets_both_ends_of_its_step() {
        let mut run = Dop853::new(TIGHT, [1.0]).unwrap();
        run.state_at(&Swell, 1.0).unwrap();
        let step = run.last.clone().unwrap();
        for (time_s, state) in [(step.start_s, step.start), (step.end_s(), step.end)] {
            let y = run.interpolated(&Swell, time_s);
            // Two roundings: the rise is subtracted and added again.
            assert!((y[0] - state[0]).abs() <= 4.0 * f64::EPSILON, "{time_s}");
        }
    }

    #[test]
    fn the_global_error_is_that_of_an_independent_implementation() {
        // Worst error over this grid of SciPy 1.17 `solve_ivp(method="DOP853", dense_output=True)`
        // with equal tolerances; it follows the same published step control.
        let scipy = [(1e-6, 7.372_16e-6), (1e-9, 2.025_28e-8), (1e-12, 1.519_56e-10)];
        for (rtol, expected) in scipy {
            let mut run = Dop853::new(Tolerance { rtol, atol: rtol }, [1.0]).unwrap();
            let mut worst = 0.0_f64;
            for k in 0..=200_u32 {
                let time_s = f64::from(k) * 0.1;
                let y = run.state_at(&Swell, time_s).unwrap()[0];
                worst = worst.max((y - swell(time_s)).abs());
            }
            // Equal algorithms part only by rounding, 1e-15 of a worst error of at least 1e-10.
            assert!((worst / expected - 1.0).abs() < 1e-4, "rtol {rtol:e}: {worst:e}");
        }
    }

    #[test]
    fn a_blow_up_is_an_error_that_carries_time_and_state() {
        let mut run = Dop853::new(TIGHT, [1.0]).unwrap();
        let (time_s, state) = match run.state_at(&Explosion, 2.0) {
            Err(OdeError::StepTooSmall { time_s, state, .. }) => (time_s, state),
            Err(OdeError::Diverged { time_s, state, .. }) => (time_s, state),
            other => panic!("{other:?}"),
        };
        // y = 1/(1−t): the pole lies at one second, and nothing may be integrated across it.
        assert!((time_s - 1.0).abs() < 1e-9, "{time_s}");
        assert!(state[0].is_finite() && state[0] > 1e9, "{state:?}");
    }

    #[test]
    fn a_start_without_a_derivative_is_refused() {
        struct Hole;
        impl Rhs<1> for Hole {
            fn derivative(&self, _time_s: f64, _y: &[f64; 1]) -> [f64; 1] {
                [f64::NAN]
            }
        }
        let mut run = Dop853::new(TIGHT, [1.0]).unwrap();
        assert!(matches!(run.state_at(&Hole, 1.0), Err(OdeError::Diverged { .. })));
    }

    #[test]
    fn no_step_is_longer_than_the_longest_allowed() {
        let mut run = Dop853::new(TIGHT, [1.0]).unwrap().with_step_max(0.01);
        for k in 0..100_u32 {
            run.state_at(&Swell, 0.04 * f64::from(k)).unwrap();
            // The clock rounds a step by half of its last bit.
            assert!(run.last.iter().all(|step| step.step_s < 0.01 + 1e-15), "{k}");
        }
    }

    #[test]
    fn steps_without_end_are_an_error() {
        // A tone of 1 GHz needs about 1e9 steps for a second of it.
        struct Hum;
        impl Rhs<2> for Hum {
            fn derivative(&self, _time_s: f64, y: &[f64; 2]) -> [f64; 2] {
                [6e9 * y[1], -6e9 * y[0]]
            }
        }
        let mut run = Dop853::new(Tolerance { rtol: 1e-6, atol: 1e-6 }, [1.0, 0.0]).unwrap();
        assert!(matches!(run.state_at(&Hum, 1.0), Err(OdeError::TooManySteps { .. })));
    }

    #[test]
    fn unusable_tolerances_and_instants_are_refused() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 2.0] {
            for tolerance in [Tolerance { rtol: bad, ..TIGHT }, Tolerance { atol: bad, ..TIGHT }] {
                assert!(matches!(Dop853::new(tolerance, [1.0]), Err(OdeError::Setting { .. })));
            }
        }
        let mut run = Dop853::new(TIGHT, [1.0]).unwrap();
        run.state_at(&Swell, 5.0).unwrap();
        for time_s in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let answer = run.state_at(&Swell, time_s);
            assert!(matches!(answer, Err(OdeError::Setting { .. })), "{time_s}");
        }
    }
}
