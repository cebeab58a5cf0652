//! How far estimates scatter: records of the fitted noise, made and fitted again.

use super::fit::{Observation, reweighted};
use super::freedom::degrees_of_freedom;
use super::{CumulativeAngle, NoiseModel, Term};
use std::f64::consts::PI;
use struna_kernel::{Channel, RandomStream, Seed};

/// Records that are made.
const REPLICAS: u16 = 200;
/// Samples of the record that stands for the whole time, and of those for shorter spans.
const LONG: usize = 4096;
const SHORT: usize = 2048;
/// A span serves averaging times from this many of its samples up to as many times more, then the
/// next shorter span takes over.
const ZOOM: usize = 8;
/// Gauss-Markov processes per decade of correlation time that make up flicker.
const PER_DECADE: f64 = 1.5;
/// One seed for all: the same record has the same intervals, always.
const SEED: Seed = Seed(0x57_52_55_4e_41);

/// Scatter of each coefficient: fitted over true, sorted ascending; empty for terms that the model
/// does not have.
pub(super) struct Scatter {
    ratios: [Vec<f64>; 5],
}

impl Scatter {
    /// The share `probability` of all ratios lies below this.
    pub(super) fn quantile(&self, term: Term, probability: f64) -> Option<f64> {
        let ratios = &self.ratios[term.index()];
        let last = ratios.len().checked_sub(1)?;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a probability times a length"
        )]
        let at = (probability.clamp(0.0, 1.0) * last as f64).round() as usize;
        Some(ratios[at])
    }
}

/// Makes records of `model` as long as the observed one, and fits `terms` to each.
///
/// A whole record at the full sample rate would be far too long to be made hundreds of times. So
/// each averaging time is simulated at a rate that suits it, in a span that is shorter the shorter
/// the averaging time; the scatter of its Allan variance is then scaled to the degrees of freedom
/// that the observed record has. Averaging times of one span keep the correlation that their common
/// samples give them.
pub(super) fn scatter(
    observations: &[Observation],
    model: &NoiseModel,
    duration_s: f64,
    step_s: f64,
) -> Scatter {
    let spans = Span::cover(observations, duration_s, step_s);
    let terms: Vec<Term> = Term::ALL.into_iter().filter(|term| model.has(*term)).collect();
    let mut replicas: Vec<Vec<f64>> = (0..REPLICAS)
        .map(|run| {
            // The stream is keyed by seed and run; no gyro is ever emulated with this seed.
            let mut stream = RandomStream::new(SEED, Channel::GyroAngleRandomWalk, run.into());
            spans.iter().flat_map(|span| span.ratios(observations, model, &mut stream)).collect()
        })
        .collect();
    centre(&mut replicas, observations.len());
    let mut ratios = [const { Vec::new() }; 5];
    for replica in replicas {
        let drawn = drawn(observations, model, &replica);
        let Some(fitted) = reweighted(&drawn, &terms, &NoiseModel::default()) else { continue };
        for term in &terms {
            ratios[term.index()].push(fitted.coefficient(*term) / model.coefficient(*term));
        }
    }
    ratios.iter_mut().for_each(|ratios| ratios.sort_by(f64::total_cmp));
    Scatter { ratios }
}

/// Divides each averaging time's ratios by their mean: what the simulated noise misses of the
/// model is no scatter.
fn centre(replicas: &mut [Vec<f64>], points: usize) {
    for k in 0..points {
        let mean = replicas.iter().map(|ratios| ratios[k]).sum::<f64>() / replicas.len() as f64;
        replicas.iter_mut().for_each(|ratios| ratios[k] /= mean);
    }
}

fn drawn(observations: &[Observation], model: &NoiseModel, ratios: &[f64]) -> Vec<Observation> {
    let draw = |(o, ratio): (&Observation, &f64)| Observation {
        variance: model.variance(o.tau_s) * ratio,
        ..*o
    };
    observations.iter().zip(ratios).map(draw).collect()
}

/// A span of simulated time with the observations that it serves, the longest span last.
struct Span {
    step_s: f64,
    samples: usize,
    /// First observation and its end.
    served: std::ops::Range<usize>,
}

impl Span {
    fn cover(observations: &[Observation], duration_s: f64, step_s: f64) -> Vec<Self> {
        let mut spans = Vec::new();
        let mut end = observations.len();
        let mut step = (duration_s / LONG as f64).max(step_s);
        let mut samples = steps(duration_s, step).clamp(ZOOM, LONG);
        while end > 0 {
            let least_s = if step > step_s { ZOOM as f64 * step } else { 0.0 };
            let start = observations[..end].partition_point(|o| o.tau_s < least_s);
            spans.push(Self { step_s: step, samples, served: start..end });
            end = start;
            step = (step / ZOOM as f64).max(step_s);
            samples = SHORT;
        }
        spans.reverse();
        spans
    }

    /// Allan variance of one simulated record over that of the model, for each observation served.
    fn ratios(
        &self,
        observations: &[Observation],
        model: &NoiseModel,
        stream: &mut RandomStream,
    ) -> Vec<f64> {
        let rates = noise(model, self.step_s, self.samples, stream);
        let angle = CumulativeAngle::of(&rates, 0.0);
        let served = observations[self.served.clone()].iter();
        served.map(|o| self.ratio(&angle, model, o)).collect()
    }

    fn ratio(&self, angle: &CumulativeAngle, model: &NoiseModel, o: &Observation) -> f64 {
        let factor = steps(o.tau_s, self.step_s).clamp(1, self.samples / 3);
        let tau_s = factor as f64 * self.step_s;
        let Some(variance) = angle.allan_variance(factor) else { return 1.0 };
        let noise = model.dominant(o.tau_s).unwrap_or(Term::BiasInstability);
        let own = degrees_of_freedom(noise, angle.points(), factor);
        // As a power, so that more scatter than was simulated cannot make a variance negative.
        (variance / model.variance(tau_s)).powf((own / o.edf).sqrt())
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a positive number of steps; casts of floats saturate"
)]
fn steps(time_s: f64, step_s: f64) -> usize {
    (time_s / step_s).round() as usize
}

/// Mean rates over `samples` steps of noise as `model` has it, rad/s.
fn noise(model: &NoiseModel, step_s: f64, samples: usize, stream: &mut RandomStream) -> Vec<f64> {
    let coefficient = |term| model.coefficient(term);
    let white = coefficient(Term::AngleRandomWalk) / step_s.sqrt();
    let walk = coefficient(Term::RateRandomWalk) * step_s.sqrt();
    let rounding = coefficient(Term::Quantisation) / step_s;
    let ramp = coefficient(Term::RateRamp) * step_s;
    let mut flicker = Flicker::new(model, step_s, samples, stream);
    let (mut walked, mut rounded) = (0.0, rounding * stream.standard_normal());
    let mut rate = |k: usize| {
        walked += walk * stream.standard_normal();
        let rounded_before = std::mem::replace(&mut rounded, rounding * stream.standard_normal());
        let white = white * stream.standard_normal();
        white + walked + (rounded - rounded_before) + ramp * k as f64 + flicker.next(stream)
    };
    (0..samples).map(&mut rate).collect()
}

/// Flicker as a sum of Gauss-Markov processes of equal variance, evenly spaced in the logarithm of
/// their correlation times.
///
/// Each has the two-sided density 2σ²τ/(1 + (2πfτ)²). At spacing Δ of ln τ they add up to
/// σ²/(2fΔ), which is B²/(2πf) for σ² = B²Δ/π.
struct Flicker {
    /// State, decay over a step and deviation of the step.
    processes: Vec<[f64; 3]>,
}

impl Flicker {
    fn new(model: &NoiseModel, step_s: f64, samples: usize, stream: &mut RandomStream) -> Self {
        let spacing = std::f64::consts::LN_10 / PER_DECADE;
        let sigma = model.coefficient(Term::BiasInstability) * (spacing / PI).sqrt();
        if sigma <= 0.0 {
            return Self { processes: Vec::new() };
        }
        let longest = 3.0 * samples as f64;
        let corners = (0..).map(|k: i32| 0.3 * (spacing * f64::from(k)).exp());
        let processes = corners.take_while(|corner| *corner < longest).map(|corner| {
            let decay = (-1.0 / corner).exp();
            [sigma * stream.standard_normal(), decay, sigma * (1.0 - decay * decay).sqrt()]
        });
        debug_assert!(step_s > 0.0);
        Self { processes: processes.collect() }
    }

    fn next(&mut self, stream: &mut RandomStream) -> f64 {
        self.processes.iter_mut().fold(0.0, |sum, [state, decay, step]| {
            *state = *decay * *state + *step * stream.standard_normal();
            sum + *state
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn simulated_noise_has_the_allan_variance_of_its_model() {
        // Each term alone; the flicker of Gauss-Markov processes ripples.
        for (term, tolerance) in [
            (Term::Quantisation, 0.02),
            (Term::AngleRandomWalk, 0.02),
            (Term::BiasInstability, 0.06),
            (Term::RateRandomWalk, 0.05),
            (Term::RateRamp, 1e-9),
        ] {
            let mut coefficients = [0.0; 5];
            coefficients[term.index()] = 0.7;
            let model = NoiseModel::from_coefficients(coefficients);
            let runs = 200;
            for factor in [8, 24, 64] {
                let mean = (0..runs)
                    .map(|run| {
                        let channel = Channel::GyroAngleRandomWalk;
                        let mut stream = RandomStream::new(SEED, channel, run);
                        let rates = noise(&model, 0.5, 2048, &mut stream);
                        CumulativeAngle::of(&rates, 0.0).allan_variance(factor).unwrap()
                    })
                    .sum::<f64>()
                    / runs as f64;
                let ratio = mean / model.variance(0.5 * factor as f64);
                // 200 records of 32 or more independent averages: some 1.4 % at one deviation;
                // the walk, sampled, is too large by 1/(2·factor²).
                assert!((ratio - 1.0).abs() < tolerance + 0.02, "{term:?}, {factor}: {ratio}");
            }
        }
    }

    #[test]
    fn spans_serve_every_observation_once() {
        for (duration_s, step_s) in [(3600.0, 1.0 / 300.0), (60.0, 0.01), (5.0, 0.1)] {
            let points: Vec<_> = (0..60)
                .map(|k| step_s * 1.2_f64.powi(k))
                .take_while(|tau_s| *tau_s < duration_s / 9.0)
                .map(|tau_s| (tau_s, 1.0, 10.0))
                .collect();
            let observations = Observation::of(&points);
            let spans = Span::cover(&observations, duration_s, step_s);
            let served: Vec<usize> = spans.iter().flat_map(|span| span.served.clone()).collect();
            assert_eq!(served, (0..observations.len()).collect::<Vec<_>>());
            assert!(spans.iter().all(|span| span.samples <= LONG && span.step_s >= step_s));
        }
    }
}
