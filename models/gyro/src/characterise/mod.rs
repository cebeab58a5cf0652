//! Characterisation: what noise does a gyro at rest have?
//!
//! [`characterise`] takes a [`RateRecord`] and gives the overlapping Allan deviation with
//! confidence intervals, the five classical coefficients with a [`Verdict`] each, and the statistic
//! that the 2008 laboratory used in their place, [`LabStatistic`].
//!
//! ```
//! use struna_gyro::characterise::{Options, RateRecord, Term, Verdict, characterise};
//! use struna_kernel::{Channel, RandomStream, Seed};
//!
//! // A minute at 300 Hz of white noise: N is the deviation over the root of the sample rate.
//! let (sample_rate_hz, walk_rad_sqrt_s) = (300.0_f64, 2e-5);
//! let mut noise = RandomStream::new(Seed(1), Channel::GyroAngleRandomWalk, 0);
//! let mut record = RateRecord::new(sample_rate_hz)?;
//! for _ in 0..60 * 300 {
//!     record.push(walk_rad_sqrt_s * sample_rate_hz.sqrt() * noise.standard_normal());
//! }
//! let found = characterise(&record, &Options::default())?;
//! let walk = found.verdict(Term::AngleRandomWalk);
//! let Verdict::Estimated { interval: [low, high], .. } = walk else {
//!     panic!("a minute is enough for the angle random walk");
//! };
//! assert!((low..high).contains(&walk_rad_sqrt_s));
//! // It is not enough for anything that changes more slowly.
//! assert!(matches!(found.verdict(Term::BiasInstability), Verdict::Refused { .. }));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! **Architecture Invariant:** pure. No file, no clock, no hidden randomness: the intervals of one
//! record are the same bits each time.

mod angle;
mod bootstrap;
mod curve;
mod factors;
mod fit;
mod freedom;
mod lab2008;
mod overbound;
mod record;
mod term;
mod verdict;

pub use angle::CumulativeAngle;
pub use curve::AllanPoint;
pub use factors::TauGrid;
pub use freedom::{degrees_of_freedom, variance_interval};
pub use lab2008::{LabStatistic, half_range_in_deviations};
pub use record::RateRecord;
pub use term::{NoiseModel, Term};
pub use verdict::{MISFIT_REFUSED, Reason, Verdict};

use curve::Angles;
use fit::{Candidate, Observation};
use verdict::Judge;

/// Points that a fit needs.
const POINTS_MIN: usize = 6;
/// The fit decides the degrees of freedom and what the band has taken, and they the fit; the first
/// settle in the second round, the second by a factor of ten in each.
const ROUNDS: usize = 4;

/// What is asked of a characterisation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Averaging times.
    pub grid: TauGrid,
    /// Confidence of all intervals, between 0 and 1.
    pub confidence: f64,
    /// Bandwidth of the gyro, Hz, where it is below half of the sample rate: shorter averaging
    /// times than it lets through are left out of the fit.
    pub bandwidth_hz: Option<f64>,
    /// Samples per average of the laboratory's statistic.
    pub averaging: usize,
    /// Whether to find a model that lies above the whole curve, too.
    pub overbound: bool,
}

impl Default for Options {
    /// Ten averaging times per decade, 95 %, no band, averages of ten, no bound.
    fn default() -> Self {
        Self {
            grid: TauGrid::default(),
            confidence: 0.95,
            bandwidth_hz: None,
            averaging: 10,
            overbound: false,
        }
    }
}

/// Why a record cannot be characterised.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CharacteriseError {
    /// Samples do not follow each other in time.
    #[error("a sample rate of {sample_rate_hz} Hz is none; it must be positive and finite")]
    SampleRate {
        /** The rate. */
        sample_rate_hz: f64,
    },
    /// A bandwidth that is none.
    #[error("a bandwidth of {bandwidth_hz} Hz is none; it must be positive and finite")]
    Bandwidth {
        /** The bandwidth. */
        bandwidth_hz: f64,
    },
    /// A confidence that is none.
    #[error("a confidence of {confidence} is none; it must lie between 0 and 1")]
    Confidence {
        /** The confidence. */
        confidence: f64,
    },
    /// Not enough samples in a row.
    #[error(
        "{longest} samples without loss at most, and at least {needed} are needed; record longer"
    )]
    TooShort {
        /** Samples in the longest stretch. */
        longest: usize,
        /** How many there must be. */
        needed: usize,
    },
    /// Nothing is left beyond the averaging times that the gyro's band hides.
    #[error(
        "the band of {bandwidth_hz} Hz hides averaging times below {hidden_s:.3} s, and the record \
         can be trusted up to {trusted_s:.3} s only; record longer"
    )]
    Filtered {
        /** The bandwidth. */
        bandwidth_hz: f64,
        /** Averaging times below this are hidden, s. */
        hidden_s: f64,
        /** Longest trusted averaging time, s. */
        trusted_s: f64,
    },
    /// All samples are the same, or differ in a pattern that averages to nothing.
    #[error("the rate does not change over the record, so there is no noise to characterise")]
    Constant,
    /// Squares of such numbers are not finite.
    #[error("the rates are so large that their squares overflow")]
    Overflow,
}

/// The noise of a gyro, as far as a record shows it.
#[derive(Debug, Clone, PartialEq)]
pub struct Characterisation {
    /// The curve, in ascending averaging time.
    pub points: Vec<AllanPoint>,
    /// The terms that explain it, by the Akaike criterion. Includes terms that a verdict refuses:
    /// they keep what they explain out of the others.
    pub model: NoiseModel,
    /// One verdict for each of [`Term::ALL`].
    pub verdicts: [Verdict; 5],
    /// Mean squared deviation of the curve from the model, in variances that its scatter explains:
    /// about one when the model is good.
    pub misfit: f64,
    /// Akaike's criterion, corrected for few points, and the Bayesian one.
    pub criteria: [f64; 2],
    /// Allan over Hadamard deviation at the longest trusted averaging time.
    pub drift_ratio: Option<f64>,
    /// N, B and K whose Allan deviation lies nowhere below the upper end of the intervals, when
    /// asked for.
    pub overbound: Option<NoiseModel>,
    /// The laboratory's statistic of single samples and of averages.
    pub laboratory: [Option<LabStatistic>; 2],
}

impl Characterisation {
    /// What the record says about `term`.
    #[must_use]
    pub fn verdict(&self, term: Term) -> Verdict {
        self.verdicts[term.index()]
    }

    /// Longest averaging time that is trusted, s.
    #[must_use]
    pub fn trusted_s(&self) -> f64 {
        self.points.iter().rfind(|point| point.trusted).map_or(0.0, |point| point.tau_s)
    }
}

/// Characterises the noise of `record`, which must be that of a gyro at rest.
///
/// # Errors
/// [`CharacteriseError`] when the record or an option allows no answer at all.
pub fn characterise(
    record: &RateRecord,
    options: &Options,
) -> Result<Characterisation, CharacteriseError> {
    options.check()?;
    let angles = Angles::of(record);
    let mut points = angles.curve(options.grid, options.bandwidth_hz);
    check(record, options, &points)?;
    let lag_s = options.bandwidth_hz.map_or(0.0, curve::white_lag_s);
    let mut observations = observations(&points, |point| point.adev_rad_s);
    let mut best = None;
    for _ in 0..ROUNDS {
        let fitted = fit(&observations)?;
        angles.match_noise(&mut points, &fitted.model, options.confidence);
        observations = self::observations(&points, |point| point.adev_rad_s);
        give_back(&mut observations, &fitted.model, lag_s);
        best = Some(fitted);
    }
    let best = best.ok_or(CharacteriseError::Constant)?;
    let step_s = 1.0 / record.sample_rate_hz();
    let duration_s = record.duration_s();
    let scatter = bootstrap::scatter(&observations, &best.model, duration_s, step_s);
    let drift_ratio = verdict::drift_ratio(&points);
    let judge = Judge {
        observations: &observations,
        best: &best,
        scatter: &scatter,
        trusted_s: points.iter().rfind(|point| point.trusted).map_or(0.0, |point| point.tau_s),
        drift_ratio,
        confidence: options.confidence,
        misfit: misfit(&observations, &best.model),
    };
    let upper = || overbound::overbound(&self::observations(&points, |p| p.interval_rad_s[1]));
    Ok(Characterisation {
        verdicts: Term::ALL.map(|term| judge.verdict(term)),
        model: best.model,
        misfit: judge.misfit,
        criteria: [best.aicc, best.bic],
        drift_ratio,
        overbound: options.overbound.then(upper).flatten(),
        laboratory: [1, options.averaging].map(|m| LabStatistic::of(record, m)),
        points,
    })
}

impl Options {
    fn check(&self) -> Result<(), CharacteriseError> {
        let Self { confidence, bandwidth_hz, .. } = *self;
        if !(confidence > 0.0 && confidence < 1.0) {
            return Err(CharacteriseError::Confidence { confidence });
        }
        match bandwidth_hz {
            Some(bandwidth_hz) if !(bandwidth_hz.is_normal() && bandwidth_hz > 0.0) => {
                Err(CharacteriseError::Bandwidth { bandwidth_hz })
            }
            _ => Ok(()),
        }
    }
}

/// Whether the curve allows a fit.
fn check(
    record: &RateRecord,
    options: &Options,
    points: &[AllanPoint],
) -> Result<(), CharacteriseError> {
    let trusted: Vec<_> = points.iter().filter(|point| point.trusted).collect();
    if trusted.len() < POINTS_MIN {
        let needed = 9 * options.grid.factors(usize::from(u16::MAX))[POINTS_MIN - 1];
        return Err(CharacteriseError::TooShort { longest: record.longest_stretch(), needed });
    }
    if points.iter().any(|point| !point.adev_rad_s.is_finite()) {
        return Err(CharacteriseError::Overflow);
    }
    if points.iter().all(|point| point.adev_rad_s <= 0.0) {
        return Err(CharacteriseError::Constant);
    }
    let open = trusted.iter().filter(|point| !point.filtered).count();
    match options.bandwidth_hz {
        Some(bandwidth_hz) if open < POINTS_MIN => Err(CharacteriseError::Filtered {
            bandwidth_hz,
            hidden_s: curve::filtered_below_s(bandwidth_hz),
            trusted_s: trusted.last().map_or(0.0, |point| point.tau_s),
        }),
        _ => Ok(()),
    }
}

fn observations(points: &[AllanPoint], deviation: impl Fn(&AllanPoint) -> f64) -> Vec<Observation> {
    let usable = points.iter().filter(|point| point.is_usable());
    let rows: Vec<_> = usable.map(|p| (p.tau_s, deviation(p).powi(2), p.edf)).collect();
    Observation::of(&rows)
}

/// Adds what the gyro's band has taken from white noise, N²·lag/τ², so that slopes fit.
fn give_back(observations: &mut [Observation], model: &NoiseModel, lag_s: f64) {
    for observation in observations {
        let white = model.share(Term::AngleRandomWalk, observation.tau_s);
        observation.variance += white * lag_s / observation.tau_s;
    }
}

fn fit(observations: &[Observation]) -> Result<Candidate, CharacteriseError> {
    // Deviations above zero whose squares are not: as good as constant.
    let candidates = fit::candidates(observations, &Term::ALL);
    candidates.first().copied().ok_or(CharacteriseError::Constant)
}

fn misfit(observations: &[Observation], model: &NoiseModel) -> f64 {
    let parameters = Term::ALL.iter().filter(|term| model.has(**term)).count();
    let free = (fit::independent_points(observations) - parameters as f64).max(1.0);
    fit::deviance(observations, model) / free
}
