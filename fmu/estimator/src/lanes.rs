//! Many two-state filters advanced together, for ensembles and banks of hypotheses.

use crate::config::ConfigError;
use crate::filter::Unrefined;
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
        Ok(Self { filters, states: [state; 2], current: 0, constants, span_s: 0.0 })
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
            if advance(&self.constants, from, span_s, rates_rad_s, to) {
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

/// What a step takes and does not change: transition, noise over the span, R.
#[derive(Debug, Clone, Copy)]
struct Constants<const N: usize> {
    f11: [f64; N],
    f12: [f64; N],
    f21: [f64; N],
    f22: [f64; N],
    q11_rad2: [f64; N],
    q12_rad2_s: [f64; N],
    q22_rad2_s2: [f64; N],
    r_rad2_s2: [f64; N],
}

impl<const N: usize> Constants<N> {
    fn of<M: Motion>(filters: &[Filter<M>; N], span_s: f64) -> Self {
        let all = filters.each_ref().map(|filter| filter.transition_over(span_s));
        let (q, r) = (filters.each_ref().map(Filter::noise), filters.each_ref().map(Filter::r));
        let noise = |of: fn(&crate::Transition) -> f64| {
            core::array::from_fn(|lane| q[lane] * of(&all[lane]))
        };
        Self {
            f11: all.map(|t| t.f11),
            f12: all.map(|t| t.f12),
            f21: all.map(|t| t.f21),
            f22: all.map(|t| t.f22),
            q11_rad2: noise(|t| t.q11),
            q12_rad2_s: noise(|t| t.q12),
            q22_rad2_s2: noise(|t| t.q22),
            r_rad2_s2: r,
        }
    }
}

/// Writes what a step makes of `from` to `to`. False if any filter might have to refuse: what was
/// written is then worth nothing, and [`Filter`] itself must judge.
///
/// Kept free of branches and calls, so that the loop is vectorised: whatever leaves the range of
/// floating point stays out of it through sums and products, so one sum judges all.
#[inline]
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
        let p = predicted(constants, lane, &from.get(lane), span_s);
        let Covariance { angle_rad2: a, cross_rad2_s: b, rate_rad2_s2: c } = p.belief.covariance;
        let variance = c + r;
        let inverse = 1.0 / variance;
        let (k1, k2) = (b * inverse, c * inverse);
        let residual = z - p.belief.rate_rad_s;
        let (mixed, keep) = (b - k1 * c, 1.0 - k2);
        let covariance = Covariance {
            angle_rad2: (a - k1 * b) - k1 * mixed + k1 * r * k1,
            cross_rad2_s: mixed * keep + k1 * r * k2,
            rate_rad2_s2: keep * c * keep + k2 * r * k2,
        };
        let angle_rad = p.belief.angle_rad + k1 * residual;
        let rate_rad_s = p.belief.rate_rad_s + k2 * residual;
        let integral_rad = p.integral_rad + z * p.since_update_s;
        let covariances = covariance.angle_rad2 + covariance.cross_rad2_s + covariance.rate_rad2_s2;
        let means = (p.belief.angle_rad + p.belief.rate_rad_s) + (angle_rad + rate_rad_s);
        let judged = covariances + variance + (means + integral_rad);
        sound &= judged.is_finite() & (variance > 0.0);
        let belief = Belief { angle_rad, rate_rad_s, covariance };
        to.put(lane, &Unrefined { belief, since_update_s: 0.0, integral_rad });
        to.residual_rad_s[lane] = residual;
        to.variance_rad2_s2[lane] = variance;
    }
    sound
}

/// The operations of [`Covariance::predicted`], unjudged.
#[inline(always)]
fn predicted<const N: usize>(
    constants: &Constants<N>,
    lane: usize,
    from: &Unrefined,
    span_s: f64,
) -> Unrefined {
    let Belief { angle_rad, rate_rad_s, covariance } = from.belief;
    let Covariance { angle_rad2: a, cross_rad2_s: b, rate_rad2_s2: c } = covariance;
    let (f11, f12) = (constants.f11[lane], constants.f12[lane]);
    let (f21, f22) = (constants.f21[lane], constants.f22[lane]);
    let (ra, rb) = (f21 * a + f22 * b, f21 * b + f22 * c);
    let (ta, tb) = (f11 * a + f12 * b, f11 * b + f12 * c);
    Unrefined {
        belief: Belief {
            angle_rad: f11 * angle_rad + f12 * rate_rad_s,
            rate_rad_s: f21 * angle_rad + f22 * rate_rad_s,
            covariance: Covariance {
                angle_rad2: ta * f11 + tb * f12 + constants.q11_rad2[lane],
                cross_rad2_s: ta * f21 + tb * f22 + constants.q12_rad2_s[lane],
                rate_rad2_s2: ra * f21 + rb * f22 + constants.q22_rad2_s2[lane],
            },
        },
        since_update_s: from.since_update_s + span_s,
        integral_rad: from.integral_rad,
    }
}
