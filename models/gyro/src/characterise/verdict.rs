//! What a record says about each coefficient, and what it cannot say.

use super::bootstrap::Scatter;
use super::fit::{Candidate, MODEL_ERROR, Observation, deviance, reweighted};
use super::{AllanPoint, NoiseModel, Term};
use std::fmt;

/// What a record says about one coefficient, in the unit that its [`Term`] names.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Verdict {
    /// It shows, and lies within the interval with the confidence asked for.
    Estimated {
        /** Best estimate. */
        value: f64,
        /** Lower and upper end. */
        interval: [f64; 2],
    },
    /// It does not show; more than this would, with 95 % confidence.
    AtMost {
        /** The bound. */
        bound: f64,
        /** Why there is no more than a bound. */
        reason: Reason,
    },
    /// The record cannot say anything about it.
    Refused {
        /** Why. */
        reason: Reason,
    },
}

/// Why a coefficient is not estimated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reason {
    /// The curve is explained as well without it.
    Hidden,
    /// The curve asks for it, but records of such noise give it as anything down to zero.
    Loose,
    /// The Allan deviation rises as by a ramp, but the Hadamard deviation, which no ramp reaches,
    /// rises with it.
    NotARamp,
    /// The curve is no sum of the five slopes: the gyro moved or was vibrated, or its band hides
    /// more than was said.
    NoSlopes {
        /** Squared deviation of curve from fit, in variances that chance explains. */
        misfit: f64,
    },
    /// The record is too short.
    TooShort {
        /** Longest averaging time that it can be trusted at, s. */
        trusted_s: f64,
        /** Averaging time that the coefficient shows at, at the earliest, s. */
        needed_s: f64,
    },
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Hidden => write!(f, "not identifiable: the curve is explained without it"),
            Self::Loose => write!(f, "not identifiable: the record is too short to tell it apart"),
            Self::NotARamp => {
                write!(f, "not identifiable: the Hadamard deviation rises too, so it is no ramp")
            }
            Self::NoSlopes { misfit } => write!(
                f,
                "the curve misses every sum of the five slopes by {misfit:.0} times what chance \
                 explains; the gyro moved or was vibrated, or its band is narrower than said"
            ),
            Self::TooShort { trusted_s, needed_s } => {
                let minutes = (needed_s * 9.0 / 60.0).ceil();
                write!(
                    f,
                    "the record supports averaging up to {trusted_s:.3} s and this needs \
                     {needed_s} s; record {minutes} min without loss"
                )
            }
        }
    }
}

/// A ramp makes the Allan deviation rise away from the Hadamard deviation; a random walk of the
/// rate, by √2 only.
const RAMP_RATIO: f64 = 2.0;
/// A curve that misses the fit by so many times what chance explains is not described by it at all.
pub const MISFIT_REFUSED: f64 = 10.0;
/// An interval wider than this factor is a bound.
const INTERVAL_RATIO_MAX: f64 = 10.0;
/// Rise of the deviance at a bound that holds with 95 % confidence: χ² with one degree of freedom,
/// one side.
const BOUND_DEVIANCE: f64 = 2.705_543_454_095_404;
/// Halvings of the bracket around a bound.
const HALVINGS: u32 = 60;

/// Averaging time that must be trusted before a term can be told from white noise, s. Bias
/// instability of gyros shows after tens of seconds, what drives it further after minutes.
fn needed_s(term: Term) -> f64 {
    match term {
        Term::Quantisation | Term::AngleRandomWalk => 0.0,
        Term::BiasInstability => 30.0,
        Term::RateRandomWalk | Term::RateRamp => 100.0,
    }
}

/// Judges one term.
pub(super) struct Judge<'a> {
    pub observations: &'a [Observation],
    pub best: &'a Candidate,
    pub scatter: &'a Scatter,
    /// Longest trusted averaging time, s.
    pub trusted_s: f64,
    /// Allan over Hadamard deviation there.
    pub drift_ratio: Option<f64>,
    pub confidence: f64,
    pub misfit: f64,
}

impl Judge<'_> {
    pub(super) fn verdict(&self, term: Term) -> Verdict {
        if self.misfit > MISFIT_REFUSED {
            return Verdict::Refused { reason: Reason::NoSlopes { misfit: self.misfit } };
        }
        let needed_s = needed_s(term);
        if self.trusted_s < needed_s {
            let trusted_s = self.trusted_s;
            return Verdict::Refused { reason: Reason::TooShort { trusted_s, needed_s } };
        }
        let reason = match (self.interval(term), self.best.model.has(term)) {
            _ if term == Term::RateRamp && self.is_no_ramp() => Reason::NotARamp,
            (Some(interval), _) => {
                let value = self.best.model.coefficient(term);
                return Verdict::Estimated { value, interval };
            }
            (None, true) => Reason::Loose,
            (None, false) => Reason::Hidden,
        };
        Verdict::AtMost { bound: self.bound(term), reason }
    }

    fn is_no_ramp(&self) -> bool {
        self.best.model.has(Term::RateRamp) && self.drift_ratio.is_none_or(|r| r < RAMP_RATIO)
    }

    /// The interval that contains the coefficient, from the scatter of estimates about it, and
    /// wider by what straight slopes are off from any gyro: half of it in a deviation.
    fn interval(&self, term: Term) -> Option<[f64; 2]> {
        let tail = 0.5 * (1.0 - self.confidence);
        let value = self.best.model.coefficient(term);
        let [low, high] = [tail, 1.0 - tail].map(|p| self.scatter.quantile(term, p));
        let (low, high) = (low?, high?);
        let slack = 1.0 + 0.5 * MODEL_ERROR;
        (low > 0.0 && high / low < INTERVAL_RATIO_MAX)
            .then(|| [value / (high * slack), value * slack / low])
    }

    /// The largest coefficient that the curve tolerates, whatever the others are.
    fn bound(&self, term: Term) -> f64 {
        let others: Vec<Term> = Term::ALL.into_iter().filter(|other| *other != term).collect();
        let deviance_at = |square: f64| {
            let mut squares = [0.0; 5];
            squares[term.index()] = square;
            let fixed = NoiseModel::from_squares(squares);
            reweighted(self.observations, &others, &fixed)
                .map_or(f64::INFINITY, |model| deviance(self.observations, &model))
        };
        let all = reweighted(self.observations, &Term::ALL, &NoiseModel::default());
        let least = all.map_or(f64::INFINITY, |model| deviance(self.observations, &model));
        let tolerated = least.min(self.best.deviance) + BOUND_DEVIANCE;
        // A term that alone makes a hundred times the variance everywhere is never tolerated, one
        // that makes a millionth anywhere always.
        let shares = self.observations.iter().map(|o| o.variance / term.unit_variance(o.tau_s));
        let (least, most) = shares.fold((f64::INFINITY, 0.0_f64), |(a, b), s| (a.min(s), b.max(s)));
        let (mut low, mut high) = ((1e-6 * least).ln(), (1e2 * most).ln());
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if deviance_at(middle.exp()) <= tolerated { low = middle } else { high = middle }
        }
        (0.5 * high).exp()
    }
}

/// Allan over Hadamard deviation at the longest trusted averaging time.
pub(super) fn drift_ratio(points: &[AllanPoint]) -> Option<f64> {
    let last = points.iter().rfind(|point| point.trusted)?;
    last.hdev_rad_s.filter(|hdev| *hdev > 0.0).map(|hdev| last.adev_rad_s / hdev)
}
