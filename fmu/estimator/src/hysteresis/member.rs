//! The members of the bank: each with its gate and its likelihood, and all of them together.

use super::config::YieldPrior;
use super::filter::DahlFilter;
use crate::augmented::windows::{GATE, GATED_VARIANCE};
use crate::config::ConfigError;
use crate::state_bytes::{Reader, RestoreError, Writer};
use crate::{AugmentedConfig, AugmentedFilter, Belief, EstimatorError, Innovation, RateEstimator};

/// Members of the bank: the linear thread first, then four that yield.
pub const MEMBERS: usize = 5;
/// Members that yield.
pub(super) const YIELDING: usize = MEMBERS - 1;

/// What the bank asks of a filter besides the common contract.
pub(super) trait Member: RateEstimator {
    /// How a measured rate compares with the belief, if a gain can be formed of that.
    fn judge(&self, rate_rad_s: f64) -> Result<Innovation, EstimatorError>;
    /// Takes a rate in with `variance_factor` times R: all of it, or nothing.
    fn absorb(&mut self, rate_rad_s: f64, variance_factor: f64) -> Result<(), EstimatorError>;
    /// Own part of a saved bank.
    fn write(&self, out: &mut Writer<'_>);
    /// Reads it back.
    fn read(&mut self, bytes: &mut Reader<'_>) -> Result<(), RestoreError>;
}

/// Both kinds of filter have these as methods of their own.
macro_rules! member {
    ($filter:ty) => {
        impl Member for $filter {
            #[inline]
            fn judge(&self, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
                Self::judge(self, rate_rad_s)
            }

            #[inline]
            fn absorb(&mut self, rate_rad_s: f64, factor: f64) -> Result<(), EstimatorError> {
                Self::absorb(self, rate_rad_s, factor)
            }

            fn write(&self, out: &mut Writer<'_>) {
                Self::write(self, out);
            }

            fn read(&mut self, bytes: &mut Reader<'_>) -> Result<(), RestoreError> {
                Self::read(self, bytes)
            }
        }
    };
}

member!(AugmentedFilter);
member!(DahlFilter);

/// A member with what the bank keeps of it.
#[derive(Debug, Clone)]
pub(super) struct Seat<F> {
    pub(super) filter: F,
    /// False once the filter has refused a call that another took.
    pub(super) is_taken: bool,
    /// Logarithm of the likelihood, up to a constant common to all members.
    pub(super) log_likelihood: f64,
}

/// What a measurement was to a member.
#[derive(Debug, Clone, Copy)]
pub(super) struct Taken {
    pub(super) innovation: Innovation,
    pub(super) gated: bool,
}

impl<F: Member> Seat<F> {
    fn new(filter: F) -> Self {
        Self { filter, is_taken: true, log_likelihood: 0.0 }
    }

    /// Takes a measurement in. Beyond the gate it counts with a millionth of its weight; towards
    /// the likelihood it counts as one at the gate, the same for every member that it surprises.
    #[inline]
    fn update(&mut self, rate_rad_s: f64, has_gate: bool) -> Result<Taken, EstimatorError> {
        let innovation = self.filter.judge(rate_rad_s)?;
        let nis = innovation.nis();
        let gated = has_gate && nis > GATE * GATE;
        self.filter.absorb(rate_rad_s, if gated { GATED_VARIANCE } else { 1.0 })?;
        let surprise = libm::log(innovation.variance_rad2_s2) + nis.min(GATE * GATE);
        self.log_likelihood -= 0.5 * surprise;
        Ok(Taken { innovation, gated })
    }

    fn write(&self, out: &mut Writer<'_>) {
        out.u64(u64::from(self.is_taken));
        out.f64(self.log_likelihood);
        self.filter.write(out);
    }

    fn read(&mut self, bytes: &mut Reader<'_>) -> Result<(), RestoreError> {
        self.is_taken = bytes.u64() != 0;
        self.log_likelihood = bytes.finite("log likelihood")?;
        self.filter.read(bytes)
    }
}

/// All members.
#[derive(Debug, Clone)]
pub(super) struct Seats {
    pub(super) linear: Seat<AugmentedFilter>,
    pub(super) yielding: [Seat<DahlFilter>; YIELDING],
}

/// Runs one expression for whichever member has the given place.
macro_rules! at_place {
    ($seats:expr, $place:expr, $seat:ident => $body:expr) => {
        match $place {
            0 => {
                let $seat = &$seats.linear;
                $body
            }
            k => {
                let $seat = &$seats.yielding[k - 1];
                $body
            }
        }
    };
}

impl Seats {
    pub(super) fn new(
        config: &AugmentedConfig,
        priors: &[YieldPrior; YIELDING],
    ) -> Result<Self, ConfigError> {
        // All weigh a rate alike: the members whose threads yield know of no rounding.
        config.validate()?;
        let config = config.without_quantiser();
        let [a, b, c, d] = priors;
        let seat = |prior| DahlFilter::new(&config, prior).map(Seat::new);
        Ok(Self {
            linear: Seat::new(AugmentedFilter::new(&config)?),
            yielding: [seat(a)?, seat(b)?, seat(c)?, seat(d)?],
        })
    }

    /// −∞ for those that were dropped.
    #[inline]
    pub(super) fn log_likelihoods(&self) -> [f64; MEMBERS] {
        core::array::from_fn(|k| {
            at_place!(self, k, seat => {
                if seat.is_taken { seat.log_likelihood } else { f64::NEG_INFINITY }
            })
        })
    }

    /// Place of the member with the largest likelihood.
    #[inline]
    pub(super) fn leader(&self) -> usize {
        let likelihoods = self.log_likelihoods();
        (1..MEMBERS).fold(0, |best, k| if likelihoods[k] > likelihoods[best] { k } else { best })
    }

    pub(super) fn belief(&self, place: usize) -> Option<Belief> {
        at_place!(self, place, seat => seat.is_taken.then(|| seat.filter.belief()))
    }

    /// How a measured rate compares with the leader's belief, and whether it holds it to be out of
    /// the gyro's range.
    pub(super) fn judge(&self, rate_rad_s: f64) -> Result<(Innovation, bool), EstimatorError> {
        at_place!(self, self.leader(), seat => {
            let innovation = seat.filter.judge(rate_rad_s)?;
            let residual_rad_s = innovation.residual_rad_s;
            Ok((innovation, seat.filter.is_over_range(rate_rad_s, residual_rad_s)))
        })
    }

    /// Predicts with every member: see [`each`](Self::each).
    pub(super) fn predict(&mut self, span_s: f64) -> Result<(), EstimatorError> {
        self.each(|seat| seat.filter.predict(span_s), |seat| seat.filter.predict(span_s))
    }

    /// Updates every member: see [`each`](Self::each).
    #[inline]
    pub(super) fn update(
        &mut self,
        rate_rad_s: f64,
        has_gate: bool,
    ) -> Result<Taken, EstimatorError> {
        let taken = self.each(
            |seat| seat.update(rate_rad_s, has_gate),
            |seat| seat.update(rate_rad_s, has_gate),
        )?;
        self.level();
        Ok(taken)
    }

    pub(super) fn widen_rates(&mut self, variance: f64) {
        self.linear.filter.widen_rate(variance);
        for seat in &mut self.yielding {
            seat.filter.widen_rate(variance);
        }
    }

    /// Runs a call on every member, drops those that refuse it, and gives the leader's answer. When
    /// all refuse, none is dropped.
    #[inline]
    fn each<T: Copy>(
        &mut self,
        mut linear: impl FnMut(&mut Seat<AugmentedFilter>) -> Result<T, EstimatorError>,
        mut yielding: impl FnMut(&mut Seat<DahlFilter>) -> Result<T, EstimatorError>,
    ) -> Result<T, EstimatorError> {
        let leader = self.leader();
        let mut answers = [None; MEMBERS];
        if self.linear.is_taken {
            answers[0] = Some(linear(&mut self.linear));
        }
        for (seat, answer) in self.yielding.iter_mut().zip(&mut answers[1..]) {
            if seat.is_taken {
                *answer = Some(yielding(seat));
            }
        }
        let answered = answers.iter().flatten().any(Result::is_ok);
        if answered {
            let holds = |answer: &Option<Result<T, _>>| matches!(answer, Some(Ok(_)));
            self.linear.is_taken = holds(&answers[0]);
            for (seat, answer) in self.yielding.iter_mut().zip(&answers[1..]) {
                seat.is_taken = holds(answer);
            }
        }
        let first = answers.iter().flatten().find(|answer| answer.is_ok() == answered);
        match answers[leader] {
            Some(Ok(answer)) => Ok(answer),
            _ => *first.unwrap_or(&Err(EstimatorError::Overflow)),
        }
    }

    /// Keeps the largest log-likelihood at zero, so that their differences never drown.
    #[inline]
    fn level(&mut self) {
        let best = self.log_likelihoods().into_iter().fold(f64::NEG_INFINITY, f64::max);
        self.linear.log_likelihood -= best;
        for seat in &mut self.yielding {
            seat.log_likelihood -= best;
        }
    }

    pub(super) fn saved_len(&self) -> usize {
        let yielding: usize = self.yielding.iter().map(|seat| seat.filter.saved_len()).sum();
        16 * MEMBERS + self.linear.filter.saved_len() + yielding
    }

    pub(super) fn write(&self, out: &mut Writer<'_>) {
        self.linear.write(out);
        for seat in &self.yielding {
            seat.write(out);
        }
    }

    pub(super) fn read(&mut self, bytes: &mut Reader<'_>) -> Result<(), RestoreError> {
        self.linear.read(bytes)?;
        for seat in &mut self.yielding {
            seat.read(bytes)?;
        }
        let is_empty = self.log_likelihoods().iter().all(|l| *l == f64::NEG_INFINITY);
        if is_empty { Err(RestoreError::Impossible) } else { Ok(()) }
    }
}
