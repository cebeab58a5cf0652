//! The classical Runge-Kutta method of order 4 on a fixed grid.

use super::{OdeError, Rhs, STEPS_MAX, check_step, within};
use crate::batch::{Work, done_fast};

/// Step sizes that make sense in simulated time, which counts nanoseconds.
const STEP_RANGE_S: (f64, f64) = (1e-9, 1e3);
/// Half a nanosecond, the rounding of the clock: instants nearer than this to the grid are on it.
const CLOCK_ROUNDING_S: f64 = 0.5e-9;

/// One step of length `step_s` from `y` at `time_s`, without projection or checks.
#[inline(always)]
pub fn rk4_step<const N: usize, R: Rhs<N>>(
    rhs: &R,
    time_s: f64,
    y: &[f64; N],
    step_s: f64,
) -> [f64; N] {
    step_and_slope(rhs, time_s, y, step_s).0
}

/// One step, and the derivative of its last stage: the slope at its end, to third order.
#[inline(always)]
fn step_and_slope<const N: usize, R: Rhs<N>>(
    rhs: &R,
    time_s: f64,
    y: &[f64; N],
    step_s: f64,
) -> ([f64; N], [f64; N]) {
    let half_s = 0.5 * step_s;
    let k1 = rhs.derivative(time_s, y);
    let k2 = rhs.derivative(time_s + half_s, &moved(y, half_s, &k1));
    let k3 = rhs.derivative(time_s + half_s, &moved(y, half_s, &k2));
    let k4 = rhs.derivative(time_s + step_s, &moved(y, step_s, &k3));
    let sixth_s = step_s / 6.0;
    let mut end = *y;
    for i in 0..N {
        end[i] += sixth_s * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
    }
    (end, k4)
}

/// `y + h*k`.
#[inline(always)]
fn moved<const N: usize>(y: &[f64; N], h: f64, k: &[f64; N]) -> [f64; N] {
    let mut out = *y;
    for i in 0..N {
        out[i] += h * k[i];
    }
    out
}

/// A walk along the grid `k*step_s` that answers at any instant.
///
/// An instant between two grid points is reached by one shortened step from the grid point before
/// it, and the walk itself goes on from that grid point. So the answer at an instant depends on
/// the instant alone: not on how often, or where else, the walk was asked.
#[derive(Debug, Clone)]
pub struct Rk4<const N: usize> {
    step_s: f64,
    /// Grid points passed; time is `index * step_s`, never a running sum.
    index: u64,
    state: [f64; N],
    /// Derivative in the last stage of the step to this grid point; none at the first.
    slope: [f64; N],
}

impl<const N: usize> Rk4<N> {
    /// A walk that starts from `state` at time zero.
    ///
    /// # Errors
    /// [`OdeError::Setting`] when `step_s` does not lie in 1 ns to 1000 s.
    pub fn new(step_s: f64, state: [f64; N]) -> Result<Self, OdeError<N>> {
        let step_s = within("step_s", step_s, STEP_RANGE_S)?;
        Ok(Self { step_s, index: 0, state, slope: [0.0; N] })
    }

    /// Starts again from `state` at time zero.
    #[inline(always)]
    pub(crate) fn restart(&mut self, state: &[f64; N]) {
        (self.index, self.state) = (0, *state);
    }

    /// The state at `time_s`, which must not lie before the grid point already reached.
    ///
    /// # Errors
    /// [`OdeError::Setting`] for an instant that has passed, [`OdeError::TooManySteps`] before
    /// any step is taken, [`OdeError::Diverged`] and [`OdeError::OutsideDomain`] on the way. The
    /// walk then stays where the call found it.
    pub fn state_at<R: Rhs<N>>(&mut self, rhs: &R, time_s: f64) -> Result<[f64; N], OdeError<N>> {
        let mut answer = self.state;
        done_fast(Carry { walk: self, rhs, time_s, answer: &mut answer })?;
        Ok(answer)
    }

    /// [`Self::state_at`] into `answer`, which an error leaves alone; for those who are compiled
    /// for the extension themselves.
    #[inline(always)]
    pub(crate) fn carry_on<R: Rhs<N>>(
        &mut self,
        rhs: &R,
        time_s: f64,
        answer: &mut [f64; N],
    ) -> Result<(), OdeError<N>> {
        let index = self.index_before(time_s)?;
        let (mut state, mut slope) = (self.state, self.slope);
        for k in self.index..index {
            (state, slope) = self.checked_step(rhs, k, &state, self.step_s)?;
        }
        let rest_s = time_s - self.time_of(index);
        if rest_s.abs() > 2.0 * CLOCK_ROUNDING_S {
            *answer = self.checked_step(rhs, index, &state, rest_s)?.0;
        } else if index == 0 {
            *answer = moved(&state, rest_s, &rhs.derivative(0.0, &state));
        } else {
            // Within the rounding of the clock a straight line is exact, its error y″·(1 ns)²/2
            // below that of `f64`, and that of the slope below the step's own. So grids that match
            // the step need no derivative besides.
            *answer = moved(&state, rest_s, &slope);
        }
        (self.index, self.state, self.slope) = (index, state, slope);
        Ok(())
    }

    #[inline(always)]
    fn time_of(&self, index: u64) -> f64 {
        index as f64 * self.step_s
    }

    /// The last grid point at or before `time_s`, to the rounding of the clock.
    #[inline(always)]
    fn index_before(&self, time_s: f64) -> Result<u64, OdeError<N>> {
        let reached_s = self.time_of(self.index);
        let latest_s = reached_s + self.step_s * STEPS_MAX as f64;
        within("time_s", time_s, (reached_s - CLOCK_ROUNDING_S, f64::MAX))?;
        if time_s > latest_s {
            return Err(OdeError::TooManySteps { time_s: reached_s, state: self.state });
        }
        let steps = (time_s + CLOCK_ROUNDING_S) / self.step_s;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "whole steps are meant, and at most STEPS_MAX above the index already reached"
        )]
        let index = steps as u64;
        Ok(index.max(self.index))
    }

    /// A full or shortened step from grid point `k`, and the slope at its end.
    #[inline(always)]
    fn checked_step<R: Rhs<N>>(
        &self,
        rhs: &R,
        k: u64,
        from: &[f64; N],
        step_s: f64,
    ) -> Result<([f64; N], [f64; N]), OdeError<N>> {
        let time_s = self.time_of(k);
        let (mut state, slope) = step_and_slope(rhs, time_s, from, step_s);
        rhs.project(&mut state);
        check_step(rhs, (time_s, from), (step_s, &state))?;
        Ok((state, slope))
    }
}

/// A call of [`Rk4::state_at`].
struct Carry<'a, const N: usize, R> {
    walk: &'a mut Rk4<N>,
    rhs: &'a R,
    time_s: f64,
    answer: &'a mut [f64; N],
}

impl<const N: usize, R: Rhs<N>> Work for Carry<'_, N, R> {
    type Outcome = Result<(), OdeError<N>>;

    #[inline(always)]
    fn done(self) -> Self::Outcome {
        self.walk.carry_on(self.rhs, self.time_s, self.answer)
    }
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

    fn swell_error(step_s: f64) -> f64 {
        let end = Rk4::new(step_s, [1.0]).unwrap().state_at(&Swell, 4.0).unwrap();
        (end[0] - 4.0_f64.sin().exp()).abs()
    }

    #[test]
    fn halving_the_step_cuts_the_error_sixteenfold() {
        let order = (swell_error(1.0 / 64.0) / swell_error(1.0 / 128.0)).log2();
        // The next term of the error expansion is of relative size h: 0.1 covers it here.
        assert!((order - 4.0).abs() < 0.1, "observed order {order:.3}");
    }

    #[test]
    fn an_answer_depends_on_its_instant_alone() {
        let sparse = Rk4::new(0.01, [1.0]).unwrap().state_at(&Swell, 1.2345).unwrap();
        let mut walk = Rk4::new(0.01, [1.0]).unwrap();
        let mut last = [0.0];
        for k in 0..=2469_u32 {
            last = walk.state_at(&Swell, f64::from(k) * 5e-4).unwrap();
        }
        assert_eq!(sparse[0].to_bits(), last[0].to_bits());
    }

    #[test]
    fn a_sample_on_the_grid_costs_one_step_however_the_clock_rounds_it() {
        struct Counted(std::cell::Cell<u32>);
        impl Rhs<1> for Counted {
            fn derivative(&self, time_s: f64, y: &[f64; 1]) -> [f64; 1] {
                self.0.set(self.0.get() + 1);
                Swell.derivative(time_s, y)
            }
        }
        let counted = Counted(std::cell::Cell::new(0));
        let mut walk = Rk4::new(1.0 / 1400.0, [1.0]).unwrap();
        for k in 1..=1400_u32 {
            let rounded_s = (f64::from(k) / 1400.0 * 1e9).round() / 1e9;
            let value = walk.state_at(&counted, rounded_s).unwrap()[0];
            // RK4 errs by 3e-15 a second at this step, and 1400 roundings of 1e-16 add up.
            assert!((value - rounded_s.sin().exp()).abs() < 1e-13, "sample {k}");
        }
        assert_eq!(counted.0.get(), 4 * 1400);
    }

    #[test]
    fn a_walk_that_starts_again_is_a_new_one() {
        let mut walk = Rk4::new(0.01, [1.0]).unwrap();
        walk.state_at(&Swell, 0.5).unwrap();
        walk.restart(&[2.0]);
        for time_s in [3e-10, 0.1 + 3e-10, 0.123] {
            let fresh = Rk4::new(0.01, [2.0]).unwrap().state_at(&Swell, time_s).unwrap();
            assert_eq!(walk.state_at(&Swell, time_s).unwrap()[0].to_bits(), fresh[0].to_bits());
        }
    }

    #[test]
    fn a_sample_rounded_to_the_nanosecond_stays_on_its_grid_point() {
        let mut walk = Rk4::new(1.0 / 300.0, [1.0]).unwrap();
        // 1/300 s rounds down to 3 333 333 ns, a third of a nanosecond before the grid point.
        let rounded_s = 3_333_333e-9;
        let value = walk.state_at(&Swell, rounded_s).unwrap()[0];
        assert_eq!(walk.index, 1);
        // RK4's own error at this step is h^5/120 = 3e-15.
        assert!((value - rounded_s.sin().exp()).abs() < 1e-14);
    }

    #[test]
    fn a_diverging_motion_is_an_error_that_carries_time_and_state() {
        let mut walk = Rk4::new(0.01, [1.0]).unwrap();
        let good = walk.state_at(&Explosion, 0.5).unwrap();
        match walk.state_at(&Explosion, 3.0) {
            Err(OdeError::Diverged { time_s, state, .. }) => {
                assert!((0.9..1.5).contains(&time_s), "{time_s}");
                assert!(state[0].is_finite());
            }
            other => panic!("{other:?}"),
        }
        let again = walk.state_at(&Explosion, 0.5).unwrap();
        assert_eq!(again[0].to_bits(), good[0].to_bits(), "a failed call changes nothing");
    }

    #[test]
    fn unusable_steps_and_instants_are_refused() {
        for step_s in [0.0, -1e-3, f64::NAN, f64::INFINITY, 1e-12] {
            assert!(matches!(Rk4::new(step_s, [1.0]), Err(OdeError::Setting { .. })), "{step_s}");
        }
        let mut walk = Rk4::new(1e-3, [1.0]).unwrap();
        walk.state_at(&Swell, 1.0).unwrap();
        for time_s in [0.5, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(walk.state_at(&Swell, time_s), Err(OdeError::Setting { .. })));
        }
        assert!(matches!(walk.state_at(&Swell, 1e5), Err(OdeError::TooManySteps { .. })));
    }
}
