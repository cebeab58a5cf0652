//! The Dormand-Prince method of order 8 at a fixed step, for evenly spaced samples.

use super::dop853::{combined, stages, weighted};
use super::dop853_tableau::{A_DENSE, B, C, D, STAGES, STAGES_ALL};
use super::{OdeError, Rhs, STEPS_MAX, check_step, within};

/// Steps and sample periods that make sense in simulated time, which counts nanoseconds.
const PERIOD_RANGE_S: (f64, f64) = (1e-9, 1e3);
/// The interpolant is a polynomial of degree 7.
const TERMS: usize = 8;

/// Samples of `M` components at an even spacing, from steps of order 8 far longer than it.
///
/// The cheapest smooth truth: a dozen derivatives serve all samples of one step, the interpolant
/// is set up for the components asked for alone, and once for each step. A fixed step has no error
/// estimate, so check it once for a set of parameters against [`super::Dop853`]; 0.04 s holds 1e-6
/// rad over 480 s of the reference motions. Sample k lies at k·period whatever the step, and does
/// not depend on how the samples are asked for.
///
/// # Source
/// Hairer, Norsett and Wanner, *Solving Ordinary Differential Equations I*, second edition, 1993,
/// program `dop853`.
#[derive(Debug, Clone)]
pub struct Dop853Sampler<const N: usize, const M: usize> {
    step_s: f64,
    components: [usize; M],
    /// Sample period in steps.
    spacing: f64,
    /// The next sample.
    sample: u64,
    /// Steps taken.
    index: u64,
    state: [f64; N],
    /// The derivative at the state: the last of one step is the first of the next.
    slope: Option<[f64; N]>,
    /// The last step's interpolant; the start as a constant before the first step.
    piece: Piece<M>,
}

/// Coefficients of the interpolant in powers of the fraction of the step, for each component.
#[derive(Debug, Clone, Copy)]
struct Piece<const M: usize>([[f64; M]; TERMS]);

impl<const M: usize> Piece<M> {
    #[inline(always)]
    fn at(&self, x: f64) -> [f64; M] {
        let mut sum = self.0[TERMS - 1];
        for power in (0..TERMS - 1).rev() {
            for (sum, term) in sum.iter_mut().zip(&self.0[power]) {
                *sum = *sum * x + term;
            }
        }
        sum
    }

    /// From Hairer's nested form, y = r₀ + x(r₁ + (1−x)(r₂ + x(r₃ + …))).
    fn of_nested(rows: &[[f64; M]; TERMS]) -> Self {
        let mut powers = [[0.0; M]; TERMS];
        for (depth, row) in rows.iter().enumerate().rev() {
            // What is inside the bracket, times x or 1−x, and the row before it.
            let by_x = depth % 2 == 0;
            let mut below = [0.0; M];
            for here in &mut powers {
                for (here, below) in here.iter_mut().zip(&mut below) {
                    let product = if by_x { *below } else { *here - *below };
                    *below = std::mem::replace(here, product);
                }
            }
            for (constant, row) in powers[0].iter_mut().zip(row) {
                *constant += row;
            }
        }
        Self(powers)
    }
}

impl<const N: usize, const M: usize> Dop853Sampler<N, M> {
    /// Samples of `components` of the motion that starts from `state` at time zero, every
    /// `period_s`, the first at the start.
    ///
    /// # Errors
    /// [`OdeError::Setting`] when step or period do not lie in 1 ns to 1000 s, or a component is
    /// none of the `N`.
    pub fn new(
        step_s: f64,
        period_s: f64,
        components: [usize; M],
        state: [f64; N],
    ) -> Result<Self, OdeError<N>> {
        within("step_s", step_s, PERIOD_RANGE_S)?;
        within("period_s", period_s, PERIOD_RANGE_S)?;
        for component in components {
            within("component", component as f64, (0.0, N as f64 - 1.0))?;
        }
        let mut constant = [[0.0; M]; TERMS];
        constant[0] = components.map(|component| state[component]);
        Ok(Self {
            step_s,
            components,
            spacing: period_s / step_s,
            sample: 0,
            index: 0,
            state,
            slope: None,
            piece: Piece(constant),
        })
    }

    /// Fills `samples` with the next ones.
    ///
    /// # Errors
    /// [`OdeError::TooManySteps`] before any step is taken; [`OdeError::Diverged`] and
    /// [`OdeError::OutsideDomain`] on the way. The sampler then stays where the call found it.
    pub fn fill<R: Rhs<N>>(
        &mut self,
        rhs: &R,
        samples: &mut [[f64; M]],
    ) -> Result<(), OdeError<N>> {
        let last = self.sample.saturating_add(samples.len() as u64);
        if last as f64 * self.spacing > (self.index + STEPS_MAX) as f64 {
            let time_s = self.index as f64 * self.step_s;
            return Err(OdeError::TooManySteps { time_s, state: self.state });
        }
        let mut ahead = self.clone();
        let mut rest = samples;
        while !rest.is_empty() {
            let done = ahead.interpolate(rest);
            rest = &mut rest[done..];
            if !rest.is_empty() {
                ahead.step(rhs)?;
            }
        }
        *self = ahead;
        Ok(())
    }

    /// Fills the samples that lie in the last step; gives how many.
    #[inline(always)]
    fn interpolate(&mut self, samples: &mut [[f64; M]]) -> usize {
        let (end, start) = (self.index as f64, self.index.saturating_sub(1) as f64);
        let mut done = 0;
        for sample in samples {
            let place = (self.sample + done) as f64 * self.spacing;
            if place > end {
                break;
            }
            *sample = self.piece.at(place - start);
            done += 1;
        }
        self.sample += done;
        #[expect(clippy::cast_possible_truncation, reason = "at most the length of the slice")]
        return done as usize;
    }

    #[inline(never)]
    fn step<R: Rhs<N>>(&mut self, rhs: &R) -> Result<(), OdeError<N>> {
        let (h, time_s) = (self.step_s, self.index as f64 * self.step_s);
        let first = self.slope.unwrap_or_else(|| rhs.derivative(time_s, &self.state));
        let mut k = stages(rhs, time_s, &self.state, &first, h);
        let mut end = combined(&self.state, h, &B, &k);
        rhs.project(&mut end);
        check_step(rhs, (time_s, &self.state), (time_s + h, &end))?;
        k[STAGES] = rhs.derivative(time_s + h, &end);
        for (row, weights) in A_DENSE.iter().enumerate() {
            let i = STAGES + 1 + row;
            let start = combined(&self.state, h, &weights[..i], &k[..i]);
            k[i] = rhs.derivative(time_s + C[i] * h, &start);
        }
        self.piece = self.piece_to(&end, &k);
        (self.state, self.slope) = (end, Some(k[STAGES]));
        self.index += 1;
        Ok(())
    }

    /// The interpolant between the state and the `end` of the step with stages `k`.
    fn piece_to(&self, end: &[f64; N], k: &[[f64; N]; STAGES_ALL]) -> Piece<M> {
        let h = self.step_s;
        let k = k.map(|stage| self.components.map(|component| stage[component]));
        let mut rows = [[0.0; M]; TERMS];
        for (i, component) in self.components.into_iter().enumerate() {
            let rise = end[component] - self.state[component];
            rows[0][i] = self.state[component];
            rows[1][i] = rise;
            rows[2][i] = h * k[0][i] - rise;
            rows[3][i] = 2.0 * rise - h * (k[STAGES][i] + k[0][i]);
        }
        for (row, weights) in D.iter().enumerate() {
            rows[4 + row] = weighted(weights, &k).map(|v| h * v);
        }
        Piece::of_nested(&rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ode::{Dop853, Tolerance};

    /// y′ = y cos t, so y = y0 exp(sin t), and its integral as a second state.
    struct Swell;

    impl Rhs<2> for Swell {
        fn derivative(&self, time_s: f64, y: &[f64; 2]) -> [f64; 2] {
            [y[0] * time_s.cos(), y[0]]
        }
    }

    fn swell(step_s: f64, period_s: f64, samples: usize) -> Vec<[f64; 1]> {
        let mut sampler = Dop853Sampler::new(step_s, period_s, [0], [1.0, 0.0]).unwrap();
        let mut out = vec![[0.0]; samples];
        sampler.fill(&Swell, &mut out).unwrap();
        out
    }

    fn worst(step_s: f64) -> f64 {
        let off = |(k, y): (usize, &[f64; 1])| (y[0] - (k as f64 * 0.01).sin().exp()).abs();
        swell(step_s, 0.01, 401).iter().enumerate().map(off).fold(0.0, f64::max)
    }

    #[test]
    fn halving_the_step_divides_the_error_of_all_samples_by_two_to_the_eighth() {
        let order = (worst(0.5) / worst(0.25)).log2();
        // Degree 7 between the steps: error h⁸, with the next power still visible.
        assert!((order - 8.0).abs() < 0.6, "observed {order:.3}");
    }

    #[test]
    fn samples_do_not_depend_on_how_they_are_asked_for() {
        let all = swell(0.1, 0.03, 100);
        let mut sampler = Dop853Sampler::new(0.1, 0.03, [0], [1.0, 0.0]).unwrap();
        let mut pieces = vec![[0.0]; 100];
        let (mut rest, mut length) = (&mut pieces[..], 1);
        while !rest.is_empty() {
            let (now, later) = rest.split_at_mut(length.min(rest.len()));
            sampler.fill(&Swell, now).unwrap();
            (rest, length) = (later, length % 7 + 1);
        }
        assert_eq!(all, pieces);
    }

    #[test]
    fn samples_may_be_further_apart_than_steps() {
        for (k, y) in swell(0.1, 0.75, 9).iter().enumerate() {
            // Eight-order steps of 0.1 s err by 1e-11 here.
            assert!((y[0] - (k as f64 * 0.75).sin().exp()).abs() < 1e-10, "sample {k}");
        }
    }

    #[test]
    fn the_interpolant_is_that_of_the_adaptive_method() {
        let tolerance = Tolerance { rtol: 1e-12, atol: 1e-12 };
        let mut record = Dop853::new(tolerance, [1.0, 0.0]).unwrap();
        let mut sampler = Dop853Sampler::new(0.05, 0.01, [1, 0], [1.0, 0.0]).unwrap();
        let mut samples = [[0.0; 2]; 300];
        sampler.fill(&Swell, &mut samples).unwrap();
        for (k, [integral, y]) in samples.iter().enumerate() {
            let expected = record.state_at(&Swell, k as f64 * 0.01).unwrap();
            // Both meet the same motion, to the adaptive method's tolerance a few times over.
            assert!((y - expected[0]).abs() < 1e-10, "sample {k}");
            assert!((integral - expected[1]).abs() < 1e-10, "sample {k}");
        }
    }

    #[test]
    fn a_failed_call_leaves_the_sampler_where_it_was() {
        /// y′ = y², which reaches infinity at t = 1/y0.
        struct Explosion;
        impl Rhs<1> for Explosion {
            fn derivative(&self, _time_s: f64, y: &[f64; 1]) -> [f64; 1] {
                [y[0] * y[0]]
            }
            fn admissible(&self, _time_s: f64, y: &[f64; 1]) -> bool {
                y[0] > 0.0
            }
        }
        let mut sampler = Dop853Sampler::new(0.01, 0.01, [0], [1.0]).unwrap();
        let mut twin = sampler.clone();
        assert!(sampler.fill(&Explosion, &mut [[0.0]; 300]).is_err());
        let (mut after, mut fresh) = ([[0.0]; 50], [[0.0]; 50]);
        sampler.fill(&Explosion, &mut after).unwrap();
        twin.fill(&Explosion, &mut fresh).unwrap();
        assert_eq!(after, fresh);
    }

    #[test]
    fn unusable_settings_are_refused() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-12] {
            for (step_s, period_s) in [(bad, 0.1), (0.1, bad)] {
                let sampler = Dop853Sampler::new(step_s, period_s, [0], [1.0]);
                assert!(matches!(sampler, Err(OdeError::Setting { .. })), "{bad}");
            }
        }
        let sampler = Dop853Sampler::new(0.1, 0.1, [2], [1.0, 0.0]);
        assert!(matches!(sampler, Err(OdeError::Setting { name: "component", .. })));
        let mut long = Dop853Sampler::new(1e-9, 1.0, [0], [1.0, 0.0]).unwrap();
        let answer = long.fill(&Swell, &mut [[0.0]; 2]);
        assert!(matches!(answer, Err(OdeError::TooManySteps { .. })));
    }
}
