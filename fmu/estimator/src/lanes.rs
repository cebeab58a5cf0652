//! Many two-state filters advanced together, for ensembles and banks of hypotheses.

use crate::config::ConfigError;
use crate::filter::Unrefined;
use crate::passage::Passage;
use crate::wide::{InstructionSet, Job};
use crate::{Belief, Covariance, EstimatorError, Filter, Innovation, Motion, RateEstimator};

/// N independent two-state filters without refinement, advanced over the same spans.
///
/// A single filter's step is one chain in which each operation waits for the one before, and the
/// processor idles for most of it. Here the numbers of all filters lie side by side, so that their
/// chains overlap and their operations share SIMD instructions.
///
/// Every filter's numbers are, to the last bit, those that [`Filter::step`] gives: the operations
/// and their order are the same. A filter that refuses its step is left as it was, and the others
/// go on.
///
/// ```
/// # use struna_estimator::{FilterConfig, Filter, FilterLanes, Refinement};
/// # let config = FilterConfig {
/// #     angle_start_rad: 0.0, rate_start_rad_s: 0.0, angle_variance_start_rad2: 1.0,
/// #     rate_variance_start_rad2_s2: 1.0, measurement_variance_rad2_s2: 1e-6,
/// #     process_noise_rad2_s3: 0.0, refinement: Refinement::OFF,
/// # };
/// let filter = |period_s| Filter::torsional_oscillation(config, period_s);
/// let mut bank = FilterLanes::new([filter(470.0)?, filter(480.0)?, filter(490.0)?])?;
/// let all = bank.step(0.01, &[0.1, 0.1, f64::NAN]);
/// assert!(all.is_err_and(|refused| refused.of(1).is_none() && refused.of(2).is_some()));
/// assert!(bank.belief(1).rate_rad_s > 0.09);
/// # Ok::<(), struna_estimator::ConfigError>(())
/// ```
#[derive(Debug, Clone)]
pub struct FilterLanes<M, const N: usize> {
    /// Parameters, and the single filters that take over when a step is out of the ordinary. What
    /// they believe is stale in between.
    filters: [Filter<M>; N],
    /// The state and, in turn, the next one: a step that goes through is then not copied.
    states: [Lanes<N>; 2],
    /// Which of the two is the state.
    current: usize,
    constants: Constants<N>,
    /// The span that the constants are for.
    span_s: f64,
    instructions: InstructionSet,
}

/// Which filters refused a call, and why.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{} of {N} filters refuse", .errors.iter().flatten().count())]
pub struct LaneErrors<const N: usize> {
    errors: [Option<EstimatorError>; N],
}

impl<const N: usize> LaneErrors<N> {
    /// What filter `lane` refused; none if its call went through or there is no such filter.
    #[must_use]
    pub fn of(&self, lane: usize) -> Option<EstimatorError> {
        self.errors.get(lane).copied().flatten()
    }
}

impl<M: Motion, const N: usize> FilterLanes<M, N> {
    /// The filters, from where they stand now. Their motions, noises and beliefs may all differ.
    ///
    /// # Errors
    /// [`ConfigError`] when a filter refines its covariance.
    pub fn new(filters: [Filter<M>; N]) -> Result<Self, ConfigError> {
        if let Some(value) = filters.iter().map(Filter::refinement_samples).find(|n| *n != 0) {
            let (name, bound) = ("refinement_samples", "0: filters in lanes do not refine");
            return Err(ConfigError { name, value: f64::from(value), bound });
        }
        let mut state = Lanes::ZERO;
        for (lane, filter) in filters.iter().enumerate() {
            state.put(lane, &filter.unrefined());
        }
        let constants = Constants::of(&filters, 0.0);
        let instructions = InstructionSet::of_processor();
        Ok(Self { filters, states: [state; 2], current: 0, constants, span_s: 0.0, instructions })
    }

    /// Predicts every filter over `span_s` and gives it its measurement valid at the end, rad/s.
    ///
    /// # Errors
    /// [`LaneErrors`] when any filter refuses what [`Filter::step`] refuses. The others have then
    /// made their step.
    #[inline]
    pub fn step(&mut self, span_s: f64, rates_rad_s: &[f64; N]) -> Result<(), LaneErrors<N>> {
        if self.constants_fit(span_s) {
            let [first, second] = &mut self.states;
            let (from, to) = if self.current == 0 { (first, second) } else { (second, first) };
            let advance = Advance { constants: &self.constants, from, span_s, rates_rad_s, to };
            if self.instructions.run(advance) {
                self.current = 1 - self.current;
                return Ok(());
            }
        }
        self.one_by_one(|filter, lane| filter.step(span_s, rates_rad_s[lane]).map(Some))
    }

    /// Predicts every filter over `span_s`, for a gap in the measurements. Not made for speed.
    ///
    /// # Errors
    /// [`LaneErrors`] when any filter refuses what its own prediction refuses. The others have then
    /// made theirs.
    pub fn predict(&mut self, span_s: f64) -> Result<(), LaneErrors<N>> {
        self.one_by_one(|filter, _| filter.predict(span_s).map(|()| None))
    }

    /// What filter `lane` believes.
    ///
    /// # Panics
    /// When there is no such filter.
    #[must_use]
    pub fn belief(&self, lane: usize) -> Belief {
        self.states[self.current].get(lane).belief
    }

    /// The innovation of filter `lane` in the last step that it did not refuse; zero before that.
    ///
    /// # Panics
    /// When there is no such filter.
    #[must_use]
    pub fn innovation(&self, lane: usize) -> Innovation {
        let state = &self.states[self.current];
        Innovation {
            residual_rad_s: state.residual_rad_s[lane],
            variance_rad2_s2: state.variance_rad2_s2[lane],
        }
    }

    /// Whether the constants are those of `span_s`, made so if it is a span at all.
    #[inline]
    fn constants_fit(&mut self, span_s: f64) -> bool {
        if self.span_s.to_bits() == span_s.to_bits() {
            return true;
        }
        self.take_span(span_s)
    }

    #[cold]
    fn take_span(&mut self, span_s: f64) -> bool {
        let sound = (0.0..f64::INFINITY).contains(&span_s);
        if sound {
            self.constants = Constants::of(&self.filters, span_s);
            self.span_s = span_s;
        }
        sound
    }

    /// Lets each filter make its step by itself.
    #[cold]
    fn one_by_one(
        &mut self,
        mut call: impl FnMut(&mut Filter<M>, usize) -> Result<Option<Innovation>, EstimatorError>,
    ) -> Result<(), LaneErrors<N>> {
        let mut errors = [None; N];
        let state = &mut self.states[self.current];
        for (lane, filter) in self.filters.iter_mut().enumerate() {
            filter.set_unrefined(&state.get(lane));
            match call(filter, lane) {
                Ok(innovation) => {
                    state.put(lane, &filter.unrefined());
                    if let Some(innovation) = innovation {
                        state.residual_rad_s[lane] = innovation.residual_rad_s;
                        state.variance_rad2_s2[lane] = innovation.variance_rad2_s2;
                    }
                }
                Err(error) => errors[lane] = Some(error),
            }
        }
        if errors.iter().all(Option::is_none) { Ok(()) } else { Err(LaneErrors { errors }) }
    }
}

/// What evolves, number by number; and the last innovations.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
struct Lanes<const N: usize> {
    angle_rad: [f64; N],
    rate_rad_s: [f64; N],
    angle_rad2: [f64; N],
    cross_rad2_s: [f64; N],
    rate_rad2_s2: [f64; N],
    since_update_s: [f64; N],
    integral_rad: [f64; N],
    residual_rad_s: [f64; N],
    variance_rad2_s2: [f64; N],
}

impl<const N: usize> Lanes<N> {
    const ZERO: Self = Self {
        angle_rad: [0.0; N],
        rate_rad_s: [0.0; N],
        angle_rad2: [0.0; N],
        cross_rad2_s: [0.0; N],
        rate_rad2_s2: [0.0; N],
        since_update_s: [0.0; N],
        integral_rad: [0.0; N],
        residual_rad_s: [0.0; N],
        variance_rad2_s2: [0.0; N],
    };

    #[inline(always)]
    fn get(&self, lane: usize) -> Unrefined {
        let covariance = Covariance {
            angle_rad2: self.angle_rad2[lane],
            cross_rad2_s: self.cross_rad2_s[lane],
            rate_rad2_s2: self.rate_rad2_s2[lane],
        };
        let (angle_rad, rate_rad_s) = (self.angle_rad[lane], self.rate_rad_s[lane]);
        Unrefined {
            belief: Belief { angle_rad, rate_rad_s, covariance },
            since_update_s: self.since_update_s[lane],
            integral_rad: self.integral_rad[lane],
        }
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, state: &Unrefined) {
        self.angle_rad[lane] = state.belief.angle_rad;
        self.rate_rad_s[lane] = state.belief.rate_rad_s;
        self.angle_rad2[lane] = state.belief.covariance.angle_rad2;
        self.cross_rad2_s[lane] = state.belief.covariance.cross_rad2_s;
        self.rate_rad2_s2[lane] = state.belief.covariance.rate_rad2_s2;
        self.since_update_s[lane] = state.since_update_s;
        self.integral_rad[lane] = state.integral_rad;
    }
}

/// What a step takes and does not change: passage over the span, R.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
struct Constants<const N: usize> {
    from_angle: [[f64; N]; 2],
    from_rate: [[f64; N]; 2],
    from_angle_variance: [[f64; N]; 3],
    from_cross: [[f64; N]; 3],
    from_rate_variance: [[f64; N]; 3],
    noise: [[f64; N]; 3],
    r_rad2_s2: [f64; N],
}

impl<const N: usize> Constants<N> {
    fn of<M: Motion>(filters: &[Filter<M>; N], span_s: f64) -> Self {
        let all = filters.each_ref().map(|filter| filter.passage_over(span_s));
        Self {
            from_angle: side_by_side(&all.map(|passage| passage.from_angle)),
            from_rate: side_by_side(&all.map(|passage| passage.from_rate)),
            from_angle_variance: side_by_side(&all.map(|passage| passage.from_angle_variance)),
            from_cross: side_by_side(&all.map(|passage| passage.from_cross)),
            from_rate_variance: side_by_side(&all.map(|passage| passage.from_rate_variance)),
            noise: side_by_side(&all.map(|passage| passage.noise)),
            r_rad2_s2: filters.each_ref().map(Filter::r),
        }
    }

    #[inline(always)]
    fn passage(&self, lane: usize) -> Passage {
        let [a, b, c] = [&self.from_angle_variance, &self.from_cross, &self.from_rate_variance];
        Passage {
            from_angle: [self.from_angle[0][lane], self.from_angle[1][lane]],
            from_rate: [self.from_rate[0][lane], self.from_rate[1][lane]],
            from_angle_variance: [a[0][lane], a[1][lane], a[2][lane]],
            from_cross: [b[0][lane], b[1][lane], b[2][lane]],
            from_rate_variance: [c[0][lane], c[1][lane], c[2][lane]],
            noise: [self.noise[0][lane], self.noise[1][lane], self.noise[2][lane]],
        }
    }
}

fn side_by_side<const K: usize, const N: usize>(rows: &[[f64; K]; N]) -> [[f64; N]; K] {
    core::array::from_fn(|k| core::array::from_fn(|lane| rows[lane][k]))
}

/// [`advance`] and what it takes.
struct Advance<'a, const N: usize> {
    constants: &'a Constants<N>,
    from: &'a Lanes<N>,
    span_s: f64,
    rates_rad_s: &'a [f64; N],
    to: &'a mut Lanes<N>,
}

impl<const N: usize> Job for Advance<'_, N> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        advance(self.constants, self.from, self.span_s, self.rates_rad_s, self.to)
    }
}

/// Writes what a step makes of `from` to `to`. False if any filter might have to refuse: what was
/// written is then worth nothing, and [`Filter`] itself must judge.
///
/// Kept free of branches and calls, so that the loop is vectorised: whatever leaves the range of
/// floating point stays out of it through sums and products, so one sum judges all. With
/// references as arguments, not in a struct: the compiler then knows that they do not overlap.
#[inline(always)]
fn advance<const N: usize>(
    constants: &Constants<N>,
    from: &Lanes<N>,
    span_s: f64,
    rates_rad_s: &[f64; N],
    to: &mut Lanes<N>,
) -> bool {
    let mut sound = true;
    for (lane, &z) in rates_rad_s.iter().enumerate() {
        let r = constants.r_rad2_s2[lane];
        let passage = constants.passage(lane);
        let before = from.get(lane);
        let p = passage.covariance_unjudged(&before.belief.covariance);
        let predicted_rad = passage.angle(&before.belief);
        let predicted_rad_s = passage.rate(&before.belief);
        let variance = p.rate_rad2_s2 + r;
        let inverse = 1.0 / variance;
        let covariance = Covariance {
            rate_rad2_s2: p.rate_variance_updated(r, inverse),
            cross_rad2_s: p.cross_updated(r, inverse),
            angle_rad2: p.angle_variance_updated(r, inverse),
        };
        let residual = z - predicted_rad_s;
        let angle_rad = predicted_rad + p.cross_rad2_s * inverse * residual;
        let rate_rad_s = predicted_rad_s + p.rate_rad2_s2 * inverse * residual;
        let integral_rad = before.integral_rad + z * (before.since_update_s + span_s);
        // The covariance of two numbers is within range where their variances are.
        let variances = covariance.angle_rad2 + covariance.rate_rad2_s2 + variance;
        let means = (predicted_rad + predicted_rad_s) + (angle_rad + rate_rad_s);
        let judged = variances + (means + integral_rad);
        sound &= judged.is_finite() & (variance > 0.0);
        let belief = Belief { angle_rad, rate_rad_s, covariance };
        to.put(lane, &Unrefined { belief, since_update_s: 0.0, integral_rad });
        to.residual_rad_s[lane] = residual;
        to.variance_rad2_s2[lane] = variance;
    }
    sound
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FilterConfig, PermanentRotation, Refinement};

    /// Of a processor without wider registers this tests nothing.
    #[test]
    fn the_bits_do_not_depend_on_the_instruction_set() {
        let config = FilterConfig {
            angle_start_rad: 6.0,
            rate_start_rad_s: 0.0,
            angle_variance_start_rad2: 0.04,
            rate_variance_start_rad2_s2: 0.01,
            measurement_variance_rad2_s2: 6e-7,
            process_noise_rad2_s3: 1e-8,
            refinement: Refinement::OFF,
        };
        let filter = || Filter::new(config, PermanentRotation).unwrap();
        let wide: [_; 11] = core::array::from_fn(|_| filter());
        let mut wide = FilterLanes::new(wide).unwrap();
        let mut narrow = FilterLanes { instructions: InstructionSet::baseline(), ..wide.clone() };
        for k in 0..1000 {
            let rates_rad_s = core::array::from_fn(|lane| (f64::from(k) * lane as f64).sin());
            wide.step(0.01, &rates_rad_s).unwrap();
            narrow.step(0.01, &rates_rad_s).unwrap();
            for lane in 0..rates_rad_s.len() {
                assert_eq!(wide.belief(lane), narrow.belief(lane), "step {k}, lane {lane}");
                assert_eq!(wide.innovation(lane), narrow.innovation(lane), "step {k}, lane {lane}");
            }
        }
    }
}
