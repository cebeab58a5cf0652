//! The most probable parameters, by Levenberg and Marquardt.

use super::normal::{Factor, Normal};
use super::trajectory::{D, FIXED, Observation, S, linearised, residuals};
use crate::augmented::Bounds;
use alloc::vec::Vec;

/// Steps after which a search is given up. From a smoothed start it takes three to six.
const STEPS_MAX: u32 = 60;
/// Expected gain in χ² below which nothing is left to gain: a hundredth of a sigma.
const GAIN_MIN: f64 = 1e-4;
const DAMPING_START: f64 = 1e-4;
const DAMPING_MAX: f64 = 1e8;

/// What is believed of one parameter beforehand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Prior {
    pub(super) mean: f64,
    /// Zero is certainty.
    pub(super) sigma: f64,
}

/// What is to be explained, and what is believed of the explanation.
#[derive(Debug)]
pub(super) struct Problem<'a> {
    pub(super) observations: &'a [Observation],
    pub(super) kicks_s: &'a [f64],
    /// One for each parameter.
    pub(super) priors: &'a [Prior],
    pub(super) variance_rad2_s2: f64,
    pub(super) bounds: Bounds,
}

/// Where a search has come to.
#[derive(Debug, Clone)]
pub(super) struct Found {
    pub(super) parameters: Vec<f64>,
    /// Row by row.
    pub(super) covariance: Vec<f64>,
}

impl Problem<'_> {
    /// Searches from `start`. None when it does not come to a rest.
    pub(super) fn solve(&self, start: Vec<f64>) -> Option<Found> {
        let mut parameters = start;
        for (parameter, prior) in parameters.iter_mut().zip(self.priors) {
            if prior.sigma <= 0.0 {
                *parameter = prior.mean;
            }
        }
        let mut cost = self.cost(&parameters)?;
        let mut damping = DAMPING_START;
        for _ in 0..STEPS_MAX {
            let normal = self.normal(&parameters);
            let factor = normal.factored(0.0)?;
            let newton = factor.solve(&normal.gradient);
            let gain: f64 = newton.iter().zip(&normal.gradient).map(|(x, g)| x * g).sum();
            if gain < GAIN_MIN {
                return Some(self.found(parameters, &factor));
            }
            let better = self.improve(&parameters, cost, &normal, &mut damping)?;
            (parameters, cost) = better;
        }
        None
    }

    /// The next better parameters, with their cost. None when there are none to be had.
    fn improve(
        &self,
        from: &[f64],
        cost: f64,
        normal: &Normal,
        damping: &mut f64,
    ) -> Option<(Vec<f64>, f64)> {
        while *damping < DAMPING_MAX {
            let step = normal.factored(*damping)?.solve(&normal.gradient);
            let trial: Vec<f64> = from.iter().zip(&step).map(|(x, step)| x + step).collect();
            match self.cost(&trial) {
                Some(better) if better < cost => {
                    *damping = (*damping * 0.1).max(1e-12);
                    return Some((trial, better));
                }
                _ => *damping *= 10.0,
            }
        }
        None
    }

    fn normal(&self, parameters: &[f64]) -> Normal {
        let weight = 1.0 / self.variance_rad2_s2;
        let mut normal = linearised(parameters, self.kicks_s, self.observations, weight);
        for (i, (parameter, prior)) in parameters.iter().zip(self.priors).enumerate() {
            if prior.sigma > 0.0 {
                normal.believe(i, prior.mean - parameter, 1.0 / (prior.sigma * prior.sigma));
            } else {
                normal.fix(i);
            }
        }
        normal
    }

    /// χ², if the parameters are those of an oscillator and the sum is a number.
    fn cost(&self, parameters: &[f64]) -> Option<f64> {
        if !self.bounds.hold(parameters[S], parameters[D]) {
            return None;
        }
        let residuals = residuals(parameters, self.kicks_s, self.observations);
        let squares: f64 = residuals
            .iter()
            .zip(self.observations)
            .map(|(r, observation)| if observation.used { r * r } else { 0.0 })
            .sum();
        let priors = parameters.iter().zip(self.priors).filter(|(_, prior)| prior.sigma > 0.0);
        let believed: f64 = priors.map(|(x, prior)| square((x - prior.mean) / prior.sigma)).sum();
        let cost = squares / self.variance_rad2_s2 + believed;
        cost.is_finite().then_some(cost)
    }

    fn found(&self, parameters: Vec<f64>, factor: &Factor) -> Found {
        let n = parameters.len();
        let mut covariance = factor.inverse();
        for (i, prior) in self.priors.iter().enumerate() {
            if prior.sigma <= 0.0 {
                covariance[i * n + i] = 0.0;
            }
        }
        Found { parameters, covariance }
    }
}

impl Found {
    /// Standard deviation of a parameter.
    pub(super) fn sigma(&self, i: usize) -> f64 {
        libm::sqrt(self.covariance[i * self.parameters.len() + i].max(0.0))
    }

    /// aᵀ·C·b of derivatives by the first parameters.
    pub(super) fn between(&self, a: &[f64], b: &[f64]) -> f64 {
        let n = self.parameters.len();
        let row = |i: usize| -> f64 {
            self.covariance[i * n..i * n + b.len()].iter().zip(b).map(|(c, b)| c * b).sum()
        };
        a.iter().enumerate().map(|(i, a)| a * row(i)).sum()
    }

    /// The kick whose size is the smallest beside its sigma, and how many sigma it has.
    pub(super) fn least_kick(&self) -> Option<(usize, f64)> {
        let sigmas = |k: usize| (self.parameters[FIXED + k] / self.sigma(FIXED + k)).abs();
        (0..self.parameters.len() - FIXED)
            .map(|k| (k, sigmas(k)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

fn square(x: f64) -> f64 {
    x * x
}
