//! The most probable undisturbed motion behind a whole record.

mod closed_form;
mod kicks;
mod levenberg;
mod normal;
mod trajectory;
mod verdict;

pub use verdict::{FitRefusal, Verdict};

use super::forward::{Forward, Kick};
use super::record::RateRecord;
use super::rts::smooth_back;
use crate::augmented::{AugmentedFilter, Bounds, GATE, Trace};
use crate::{
    AugmentedConfig, Belief, ConfigError, Covariance, InnovationTest, LearntParameters, StartPrior,
};
use alloc::vec::Vec;
use levenberg::{Found, Prior, Problem};
use trajectory::{BIAS, D, FIXED, Observation, S, residuals, walk};
use verdict::Residuals;

/// Most kicks of a record.
const KICKS_MAX: usize = 64;
/// Usable samples for each parameter that a fit needs at least.
const SAMPLES_PER_PARAMETER: usize = 4;
/// Rounds of fitting, gating and moving kicks.
const ROUNDS_MAX: u32 = 24;
/// A kick that is not this many of its own sigmas is a false alarm.
const KICK_SIGMAS_MIN: f64 = 3.0;
/// By how much χ² must fall with the motion for there to be one. Noise alone yields four or so,
/// one for each parameter, and thirty once in 10⁵ records.
const MOTION_GAIN_MIN: f64 = 30.0;
/// Relative sigma of the period beyond which it is unknown.
const PERIOD_SIGMA_MAX: f64 = 0.1;

/// Fits the closed form of damped torsion to a whole record: start angle and rate, Ω², 2ζΩ, bias,
/// and the size of each kick.
///
/// With four or five numbers for a record it is the best that can be done in hindsight, as long as
/// the body does nothing but swing back and get struck. Kicks are taken from the alarms of the
/// tested filter, moved to where they explain the record best, and left out again if they are less
/// than three of their own sigmas. A kick acts at the sample that shows it; that it may have come
/// up to a step earlier is not counted.
///
/// # Source
/// Levenberg (1944) and Marquardt (1963) for the search; the maximum a posteriori estimate with
/// normal priors for what is sought.
#[derive(Debug, Clone)]
pub struct BatchFit {
    config: AugmentedConfig,
    test: InnovationTest,
}

/// The most probable motion, and how sure it is.
#[derive(Debug, Clone)]
pub struct BatchEstimate {
    /// Angle and rate at each sample.
    pub beliefs: Vec<Belief>,
    /// Most probable (angle, rate) at the start, Ω², 2ζΩ, and bias: rad, rad/s, 1/s², 1/s, rad/s.
    pub parameters: [f64; 5],
    /// Covariance of them.
    pub covariance: [[f64; 5]; 5],
    /// Period, damping and bias.
    pub learnt: LearntParameters,
    /// The kicks, with their sizes.
    pub kicks: Vec<Kick>,
    /// Mean square of the residuals over R, of the samples used.
    pub chi_square_per_sample: f64,
    /// Largest mean residual over any window, as a share of what chance allows.
    pub residual_run: f64,
    /// Samples used.
    pub used: usize,
    /// Samples beyond the gate of 5σ.
    pub rejected: usize,
    /// Samples over range.
    pub over_range: usize,
    /// Whether all this is to be believed.
    pub verdict: Verdict,
}

/// What changes from round to round.
#[derive(Debug)]
struct Search<'a> {
    fit: &'a BatchFit,
    record: &'a RateRecord<'a>,
    bounds: Bounds,
    observations: Vec<Observation>,
    /// Observation that first shows each kick.
    kicks: Vec<usize>,
    /// When each kick acts, s since the start.
    kicks_s: Vec<f64>,
    priors: Vec<Prior>,
}

impl BatchFit {
    /// A fit with the given prior, noise and test. Process noise is for the filter that the fit
    /// starts from; the fit itself knows of none.
    ///
    /// # Errors
    /// [`ConfigError`] names the value out of its bound.
    pub fn new(config: &AugmentedConfig, test: &InnovationTest) -> Result<Self, ConfigError> {
        config.validate()?;
        let config = config.without_quantiser();
        AugmentedFilter::new(&config)?;
        test.validate()?;
        Ok(Self { config, test: *test })
    }

    /// Fits a record, with kicks where the tested filter finds them.
    ///
    /// # Errors
    /// [`FitRefusal`] when the record does not say enough, or cannot be read at all.
    pub fn fit(&self, record: &RateRecord<'_>) -> Result<BatchEstimate, FitRefusal> {
        self.run(record, None)
    }

    /// Fits a record with kicks at the given times, s, and at no others.
    ///
    /// # Errors
    /// [`FitRefusal`] when the record does not say enough, or cannot be read at all.
    pub fn fit_with_kicks(
        &self,
        record: &RateRecord<'_>,
        kick_times_s: &[f64],
    ) -> Result<BatchEstimate, FitRefusal> {
        self.run(record, Some(kick_times_s))
    }

    fn run(
        &self,
        record: &RateRecord<'_>,
        given_s: Option<&[f64]>,
    ) -> Result<BatchEstimate, FitRefusal> {
        let Forward { model, mut traces, kicks, .. } =
            Forward::over(&self.config, &self.test, record)?;
        smooth_back(&model, &mut traces);
        let mut search = Search::new(self, record, &model, &traces);
        match given_s {
            Some(times_s) => search.give_kicks(times_s)?,
            None => search.take_kicks(&kicks),
        }
        search.check_counts()?;
        search.check_motion()?;
        let found = search.settle(start_of(&traces[0]), given_s.is_none())?;
        search.estimate(&found)
    }
}

/// The parameters that the smoother says at the start.
fn start_of(trace: &Trace) -> [f64; FIXED] {
    let [alpha, rate, s, d, bias] = trace.mean();
    [-alpha / s, rate, s, d, bias]
}

fn priors(start: &StartPrior) -> [Prior; FIXED] {
    let omega = core::f64::consts::TAU / start.period_s;
    let s = omega * omega;
    let prior = |mean, sigma| Prior { mean, sigma };
    [
        prior(start.angle_rad, start.angle_sigma_rad),
        prior(start.rate_rad_s, start.rate_sigma_rad_s),
        prior(s, 2.0 * s * start.period_sigma_s / start.period_s),
        prior(2.0 * omega * start.damping_ratio, 2.0 * omega * start.damping_ratio_sigma),
        prior(start.bias_rad_s, start.bias_sigma_rad_s),
    ]
}

impl<'a> Search<'a> {
    fn new(
        fit: &'a BatchFit,
        record: &'a RateRecord<'a>,
        model: &AugmentedFilter,
        smoothed: &[Trace],
    ) -> Self {
        let observations = record.samples.iter().zip(&smoothed[1..]).map(|(sample, trace)| {
            let mean = trace.mean();
            let residual = sample.rate_rad_s - mean[1] - mean[4];
            let over_range = sample.over_range || model.is_over_range(sample.rate_rad_s, residual);
            Observation {
                time_s: sample.time_s - record.start_time_s,
                rate_rad_s: sample.rate_rad_s,
                used: !over_range && residual.abs() <= fit.gate_rad_s(),
                over_range,
            }
        });
        Self {
            fit,
            record,
            bounds: model.bounds(),
            observations: observations.collect(),
            kicks: Vec::new(),
            kicks_s: Vec::new(),
            priors: priors(&fit.config.start).to_vec(),
        }
    }

    fn give_kicks(&mut self, times_s: &[f64]) -> Result<(), FitRefusal> {
        let end_s = self.observations.last().map_or(0.0, |last| last.time_s);
        let mut times_s = times_s.to_vec();
        times_s.sort_by(f64::total_cmp);
        for time_s in times_s {
            let since_s = time_s - self.record.start_time_s;
            if !(0.0..=end_s).contains(&since_s) {
                return Err(FitRefusal::BadKick { time_s });
            }
            self.kicks.push(self.observations.partition_point(|o| o.time_s < since_s));
            self.kicks_s.push(since_s);
        }
        Ok(())
    }

    fn take_kicks(&mut self, kicks: &[Kick]) {
        self.kicks = kicks.iter().map(|kick| kick.sample).collect();
        self.kicks.sort_unstable();
        self.kicks.dedup();
        self.time_kicks();
    }

    fn time_kicks(&mut self) {
        self.kicks_s = self.kicks.iter().map(|&k| self.observations[k].time_s).collect();
    }

    fn check_counts(&self) -> Result<(), FitRefusal> {
        let kicks = self.kicks.len();
        if kicks > KICKS_MAX {
            return Err(FitRefusal::TooManyKicks { kicks, most: KICKS_MAX });
        }
        let used = self.observations.iter().filter(|observation| observation.used).count();
        let parameters = FIXED + kicks;
        let need = SAMPLES_PER_PARAMETER * parameters;
        if used < need {
            return Err(FitRefusal::TooFewSamples { used, parameters, need });
        }
        Ok(())
    }

    /// Fits until gate and kicks stay as they are.
    fn settle(&mut self, start: [f64; FIXED], kicks_move: bool) -> Result<Found, FitRefusal> {
        let mut found = self.solve(&start)?;
        for _ in 0..ROUNDS_MAX {
            let moved = kicks_move && self.move_kicks(&found);
            let regated = self.gate(&found);
            let settled = !(moved || regated);
            if settled && !(kicks_move && self.drop_a_kick(&found)) {
                break;
            }
            self.check_counts()?;
            let from = core::array::from_fn(|i| found.parameters[i]);
            found = self.solve(&from)?;
        }
        Ok(found)
    }

    /// The most probable parameters with this gate and these kicks, from here or from the start
    /// belief.
    fn solve(&mut self, from: &[f64; FIXED]) -> Result<Found, FitRefusal> {
        // Kicks are free; a prior this wide only keeps one that no sample shows from being
        // anything at all.
        let sigma_rad_s = 1e4 * self.fit.gate_rad_s();
        self.priors.resize(FIXED, Prior { mean: 0.0, sigma: 0.0 });
        self.priors.resize(FIXED + self.kicks_s.len(), Prior { mean: 0.0, sigma: sigma_rad_s });
        let problem = Problem {
            observations: &self.observations,
            kicks_s: &self.kicks_s,
            priors: &self.priors,
            variance_rad2_s2: self.fit.config.measurement_variance_rad2_s2,
            bounds: self.bounds,
        };
        let starting = |with: &[f64]| {
            let mut start = with.to_vec();
            start.resize(self.priors.len(), 0.0);
            problem.solve(start)
        };
        let believed: Vec<f64> = self.priors.iter().map(|prior| prior.mean).collect();
        starting(from).or_else(|| starting(&believed)).ok_or(FitRefusal::NotConverged)
    }

    fn residuals(&self, found: &Found) -> Vec<f64> {
        residuals(&found.parameters, &self.kicks_s, &self.observations)
    }

    /// Judges every sample anew; whether the judgement of any has changed.
    fn gate(&mut self, found: &Found) -> bool {
        let gate_rad_s = self.fit.gate_rad_s();
        let residuals = self.residuals(found);
        let mut changed = false;
        for (observation, residual) in self.observations.iter_mut().zip(residuals) {
            let used = !observation.over_range && residual.abs() <= gate_rad_s;
            changed |= used != observation.used;
            observation.used = used;
        }
        changed
    }

    /// Moves each kick to where it explains the record best; whether any was moved.
    fn move_kicks(&mut self, found: &Found) -> bool {
        let residuals = self.residuals(found);
        let before = self.kicks.clone();
        for k in 0..before.len() {
            let least = if k > 0 { self.kicks[k - 1] + 1 } else { 0 };
            let most = before.get(k + 1).map_or(self.observations.len(), |next| *next) - 1;
            self.kicks[k] = kicks::better_place(
                &self.observations,
                &residuals,
                before[k],
                found.parameters[FIXED + k],
                self.fit.gate_rad_s(),
                (least, most),
            );
        }
        self.time_kicks();
        self.kicks != before
    }

    /// Drops the least kick if it is none; whether it did.
    fn drop_a_kick(&mut self, found: &Found) -> bool {
        match found.least_kick() {
            Some((k, sigmas)) if sigmas < KICK_SIGMAS_MIN => {
                self.kicks.remove(k);
                self.time_kicks();
                true
            }
            _ => false,
        }
    }

    fn estimate(&self, found: &Found) -> Result<BatchEstimate, FitRefusal> {
        let residuals = self.residuals(found);
        let variance = self.fit.config.measurement_variance_rad2_s2;
        let all = Residuals::of(&self.observations, &residuals, variance);
        self.check_period(found, &all)?;
        let covariance = core::array::from_fn(|i| {
            core::array::from_fn(|j| found.covariance[i * found.parameters.len() + j])
        });
        Ok(BatchEstimate {
            beliefs: self.beliefs(found),
            parameters: core::array::from_fn(|i| found.parameters[i]),
            covariance,
            learnt: learnt(found),
            kicks: self.kicks_found(found),
            chi_square_per_sample: all.chi_square,
            residual_run: all.run,
            used: all.used,
            rejected: all.rejected,
            over_range: all.over_range,
            verdict: all.verdict(&found.parameters, &self.priors),
        })
    }

    /// What a constant rate leaves of every observation, and the mean square of it where used,
    /// over R.
    fn beside_a_constant(&self) -> (Vec<f64>, f64) {
        let used = || self.observations.iter().filter(|observation| observation.used);
        let n = used().count().max(1) as f64;
        let mean = used().map(|observation| observation.rate_rad_s).sum::<f64>() / n;
        let left: Vec<f64> = self.observations.iter().map(|o| o.rate_rad_s - mean).collect();
        let squares: f64 =
            left.iter().zip(&self.observations).filter(|(_, o)| o.used).map(|(r, _)| r * r).sum();
        (left, squares / (n * self.fit.config.measurement_variance_rad2_s2))
    }

    /// Refuses a record that a constant rate explains: there is nothing to fit, and the search
    /// would wander.
    fn check_motion(&self) -> Result<(), FitRefusal> {
        let (left, chi_square_per_sample) = self.beside_a_constant();
        let variance = self.fit.config.measurement_variance_rad2_s2;
        if Residuals::of(&self.observations, &left, variance).are_noise() {
            return Err(FitRefusal::NoMotion { chi_square_per_sample });
        }
        Ok(())
    }

    /// Refuses a fit whose motion is hardly more than a constant rate, or that cannot tell the
    /// period.
    fn check_period(&self, found: &Found, all: &Residuals) -> Result<(), FitRefusal> {
        let (_, chi_square_per_sample) = self.beside_a_constant();
        let gain = (chi_square_per_sample - all.chi_square) * all.used as f64;
        if gain.is_nan() || gain < MOTION_GAIN_MIN {
            return Err(FitRefusal::NoMotion { chi_square_per_sample });
        }
        let LearntParameters { period_s, period_sigma_s: sigma_s, .. } = learnt(found);
        if sigma_s > PERIOD_SIGMA_MAX * period_s {
            return Err(FitRefusal::PeriodUnknown { period_s, sigma_s });
        }
        Ok(())
    }

    fn beliefs(&self, found: &Found) -> Vec<Belief> {
        let scale = self.fit.config.scale_factor_sigma * self.fit.config.scale_factor_sigma;
        let mut beliefs = Vec::with_capacity(self.observations.len());
        walk(&found.parameters, &self.kicks_s, &self.observations, |_, point, active| {
            let (angle, rate) = (&point.angle_by[..active], &point.rate_by[..active]);
            let (angle_rad, rate_rad_s) = (point.angle, point.rate);
            beliefs.push(Belief {
                angle_rad,
                rate_rad_s,
                covariance: Covariance {
                    angle_rad2: found.between(angle, angle) + scale * angle_rad * angle_rad,
                    cross_rad2_s: found.between(angle, rate) + scale * angle_rad * rate_rad_s,
                    rate_rad2_s2: found.between(rate, rate) + scale * rate_rad_s * rate_rad_s,
                },
            });
        });
        beliefs
    }

    fn kicks_found(&self, found: &Found) -> Vec<Kick> {
        let kick = |(k, (&sample, &since_s)): (usize, (&usize, &f64))| Kick {
            sample,
            time_s: since_s + self.record.start_time_s,
            size_rad_s: found.parameters[FIXED + k],
            size_sigma_rad_s: found.sigma(FIXED + k),
        };
        self.kicks.iter().zip(&self.kicks_s).enumerate().map(kick).collect()
    }
}

impl BatchFit {
    fn gate_rad_s(&self) -> f64 {
        GATE * libm::sqrt(self.config.measurement_variance_rad2_s2)
    }
}

fn learnt(found: &Found) -> LearntParameters {
    let [s, d] = [found.parameters[S], found.parameters[D]];
    let omega = libm::sqrt(s);
    let period_s = core::f64::consts::TAU / omega;
    // ζ = d/2√s.
    let mut by = [0.0; FIXED];
    (by[S], by[D]) = (-0.25 * d / (s * omega), 0.5 / omega);
    LearntParameters {
        period_s,
        period_sigma_s: 0.5 * period_s * found.sigma(S) / s,
        damping_ratio: 0.5 * d / omega,
        damping_ratio_sigma: libm::sqrt(found.between(&by, &by).max(0.0)),
        bias_rad_s: found.parameters[BIAS],
        bias_sigma_rad_s: found.sigma(BIAS),
    }
}
