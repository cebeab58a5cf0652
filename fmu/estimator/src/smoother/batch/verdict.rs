//! Whether a record is what the closed form says, and what the fit says when it is not.

use super::levenberg::Prior;
use super::trajectory::Observation;
use crate::InnovationTest;
use crate::augmented::{CLIP, LENGTHS};
use crate::smoother::record::SmoothError;
use alloc::vec::Vec;

/// Mean square of the residuals, in units of R, beyond which they are not the gyro's noise. Fits
/// of clean records reach 1.06.
const CHI_SQUARE_MAX: f64 = 1.12;
/// Share of samples beyond the gate that outliers may make up.
const REJECTED_MAX: f64 = 0.05;
/// False alarms of the residual test per window and record: a refusal must be rarer than a repair.
const FALSE_ALARMS: f64 = 1e-4;
/// Distance from the start belief that is no chance, standard deviations.
const PRIOR_SIGMAS_MAX: f64 = 6.0;

/// Whether the fit is to be believed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Verdict {
    /// The residuals are the gyro's noise, and the start belief holds.
    Accepted,
    /// The residuals hold more than the gyro's noise: random torque, a thread that yields, a kick
    /// that was not found. [`smooth`](crate::smooth) with process noise is then the right tool,
    /// and what the fit claims of itself is too little.
    RecordExceedsModel,
    /// The record and the start belief contradict each other.
    AgainstStartBelief {
        /// Which number of the belief.
        quantity: &'static str,
        /** By how many of its standard deviations. */
        sigmas: f64,
    },
}

/// Why there is no fit.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitRefusal {
    /// The record or the model is unusable.
    #[error(transparent)]
    Unusable(#[from] SmoothError),
    /// A kick that is no number, or outside of the record.
    #[error("a kick at {time_s} s is not in the record")]
    BadKick {
        /** Its time, s. */
        time_s: f64,
    },
    /// Too few samples are left to fit anything to.
    #[error("too few samples: {used} usable ones for {parameters} parameters, at least {need}")]
    TooFewSamples {
        /** Samples neither over range nor beyond the gate. */
        used: usize,
        /** Parameters, one for each kick included. */
        parameters: usize,
        /** Samples needed. */
        need: usize,
    },
    /// A constant rate explains the record.
    #[error(
        "period not identifiable from this record: no motion (a constant rate leaves χ² = \
         {chi_square_per_sample:.2} a sample)"
    )]
    NoMotion {
        /** Mean square of what a constant rate leaves, over R. */
        chi_square_per_sample: f64,
    },
    /// The record is too short, or the motion too small, to tell the period.
    #[error(
        "period not identifiable from this record: {period_s:.1} s with a sigma of {sigma_s:.1} s"
    )]
    PeriodUnknown {
        /** Most probable period, s. */
        period_s: f64,
        /** Its standard deviation, s. */
        sigma_s: f64,
    },
    /// More kicks than a torsion pendulum is struck.
    #[error("{kicks} kicks found, at most {most}: the body does not move as assumed")]
    TooManyKicks {
        /** Alarms of the filter, or times given. */
        kicks: usize,
        /** The limit. */
        most: usize,
    },
    /// The search for the most probable parameters came to no rest.
    #[error("the fit did not converge")]
    NotConverged,
}

/// What the residuals come to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Residuals {
    pub(super) used: usize,
    pub(super) rejected: usize,
    pub(super) over_range: usize,
    /// Mean square of those used over R.
    pub(super) chi_square: f64,
    /// Largest mean over a window beside what chance allows; beyond 1 they are not white.
    pub(super) run: f64,
}

impl Residuals {
    pub(super) fn of(observations: &[Observation], residuals: &[f64], variance: f64) -> Self {
        let mut all = Self { used: 0, rejected: 0, over_range: 0, chi_square: 0.0, run: 0.0 };
        let mut sums = Vec::with_capacity(observations.len() + 1);
        let (mut sum, mut squares) = (0.0, 0.0);
        sums.push(sum);
        for (observation, residual) in observations.iter().zip(residuals) {
            if observation.over_range {
                all.over_range += 1;
                continue;
            }
            sum += (residual / libm::sqrt(variance)).clamp(-CLIP, CLIP);
            sums.push(sum);
            if observation.used {
                all.used += 1;
                squares += residual * residual / variance;
            } else {
                all.rejected += 1;
            }
        }
        all.chi_square = squares / all.used.max(1) as f64;
        all.run = longest_run(&sums);
        all
    }

    /// Whether they are noise and nothing else.
    pub(super) fn are_noise(&self) -> bool {
        let n = self.used.max(1) as f64;
        let most = CHI_SQUARE_MAX.max(1.0 + 6.0 * libm::sqrt(2.0 / n));
        let judged = (self.used + self.rejected) as f64;
        self.chi_square < most
            && self.run < 1.0
            && (self.rejected as f64) < REJECTED_MAX * judged + 3.0
    }

    pub(super) fn verdict(&self, parameters: &[f64], priors: &[Prior]) -> Verdict {
        if !self.are_noise() {
            return Verdict::RecordExceedsModel;
        }
        let names = ["angle", "rate", "period", "damping", "bias"];
        let sigmas = |(x, prior): (&f64, &Prior)| {
            if prior.sigma > 0.0 { (x - prior.mean).abs() / prior.sigma } else { 0.0 }
        };
        names
            .into_iter()
            .zip(parameters.iter().zip(priors).map(sigmas))
            .find(|(_, sigmas)| *sigmas > PRIOR_SIGMAS_MAX)
            .map_or(Verdict::Accepted, |(quantity, sigmas)| Verdict::AgainstStartBelief {
                quantity,
                sigmas,
            })
    }
}

/// The largest mean over the windows of the innovation test, as a share of its threshold.
fn longest_run(sums: &[f64]) -> f64 {
    let samples = u32::try_from(sums.len()).unwrap_or(u32::MAX);
    let test = InnovationTest {
        false_alarms: FALSE_ALARMS,
        horizon_samples: samples.max(2048),
        ..InnovationTest::STANDARD
    };
    let mut longest: f64 = 0.0;
    for length in LENGTHS {
        let limit = test.threshold(length) * libm::sqrt(f64::from(length));
        let length = usize::from(length);
        let pairs = sums.iter().zip(sums.iter().skip(length));
        let largest = pairs.map(|(a, b)| (b - a).abs()).fold(0.0, f64::max);
        longest = longest.max(largest / limit);
    }
    longest
}
