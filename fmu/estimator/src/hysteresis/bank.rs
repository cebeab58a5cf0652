//! The bank: one filter of a linear thread and four of threads that yield, weighed against each
//! other.

use super::config::YieldPrior;
use super::filter::{DahlFilter, LearntYield};
use super::member::{Seat, Taken};
use crate::augmented::watch::Watch;
use crate::checks::{check_measurement, check_span, in_range};
use crate::config::ConfigError;
use crate::state_bytes::{Reader, RestoreError, Writer};
use crate::{
    AugmentedConfig, AugmentedFilter, Belief, Covariance, EstimatorError, Innovation,
    LearntParameters, RateEstimator, Status,
};

/// Members of the bank: the linear thread first, then four that yield.
pub const MEMBERS: usize = 5;
/// Members that yield.
const YIELDING: usize = MEMBERS - 1;

/// Weights are likelihoods to this power. Innovations of neighbouring samples share whatever the
/// models lack, so their product claims more than it knows.
const TEMPER: f64 = 0.5;
/// How far a thread that yields must lead in log-likelihood to be announced.
const ANNOUNCED_LEAD: f64 = 10.0;
/// How many of its standard deviations a rate must differ from none to be motion.
const MOTION_SIGMAS: f64 = 5.0;

/// Bank of Kalman filters for a thread that may yield, and its belief their mixture.
///
/// Members see the same measurements. The belief has mean and covariance of the mixture, which the
/// disagreement of its members widens. It costs twice the error of the linear filter alone where
/// the thread does not yield: use it where [`TestedFilter`](crate::TestedFilter) doubts its model
/// and nothing visible struck the body.
///
/// Each member has a gate for outliers and may be struck: three samples in a row and on one side
/// beyond five sigma widen its rate. There is no roll-back and no test for kicks below that.
///
/// A body that has not moved yet shows nothing: until a rate is seen that differs from none, the
/// belief claims no more of the angle than was known at the start.
///
/// A member that leaves the range of floating point is dropped, and the bank goes on with the
/// others.
#[derive(Debug, Clone)]
pub struct HysteresisBank {
    linear: Seat<AugmentedFilter>,
    yielding: [Seat<DahlFilter>; YIELDING],
    /// Variance of the angle that was believed at the start, rad².
    start_variance_rad2: f64,
    has_moved: bool,
    /// Seconds predicted since the last measurement.
    since_update_s: f64,
    watch: Watch,
}

/// Runs one expression for whichever member has the given place.
macro_rules! at_place {
    ($bank:expr, $place:expr, $seat:ident => $body:expr) => {
        match $place {
            0 => {
                let $seat = &$bank.linear;
                $body
            }
            k => {
                let $seat = &$bank.yielding[k - 1];
                $body
            }
        }
    };
}

impl HysteresisBank {
    /// A bank with the standard priors of the friction.
    ///
    /// # Errors
    /// [`ConfigError`] names the value out of its bound.
    pub fn new(config: &AugmentedConfig) -> Result<Self, ConfigError> {
        Self::with_priors(config, &YieldPrior::BANK)
    }

    /// A bank with these priors of the friction, in rising order of the yield angle.
    ///
    /// # Errors
    /// [`ConfigError`] names the value out of its bound.
    pub fn with_priors(
        config: &AugmentedConfig,
        priors: &[YieldPrior; MEMBERS - 1],
    ) -> Result<Self, ConfigError> {
        let linear = AugmentedFilter::new(config)?;
        let [a, b, c, d] = priors;
        let seat = |prior| DahlFilter::new(config, prior).map(Seat::new);
        Ok(Self {
            start_variance_rad2: linear.belief().covariance.angle_rad2,
            linear: Seat::new(linear),
            yielding: [seat(a)?, seat(b)?, seat(c)?, seat(d)?],
            has_moved: false,
            since_update_s: 0.0,
            watch: Watch::default(),
        })
    }

    /// Predicts over `span_s` and takes in a measurement valid at its end.
    ///
    /// # Errors
    /// What predict and update refuse. When the measurement is refused the prediction stands.
    pub fn step(&mut self, span_s: f64, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        self.predict(span_s)?;
        self.update(rate_rad_s)
    }

    /// Weights of the members, the linear thread's first: they sum to 1; a member that was dropped
    /// has none.
    #[must_use]
    pub fn weights(&self) -> [f64; MEMBERS] {
        let likelihoods = self.log_likelihoods();
        let best = likelihoods.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let raw = likelihoods.map(|likelihood| libm::exp(TEMPER * (likelihood - best)));
        let sum: f64 = raw.iter().sum();
        raw.map(|weight| weight / sum)
    }

    /// How far the best member that yields leads the linear thread in log-likelihood. Infinite when
    /// one of the two sides has been dropped.
    #[must_use]
    pub fn yield_lead(&self) -> f64 {
        let [linear, yielding @ ..] = self.log_likelihoods();
        yielding.into_iter().fold(f64::NEG_INFINITY, f64::max) - linear
    }

    /// Place of the member with the largest likelihood, 0 for the linear thread.
    #[must_use]
    pub fn leader(&self) -> usize {
        let likelihoods = self.log_likelihoods();
        (1..MEMBERS).fold(0, |best, k| if likelihoods[k] > likelihoods[best] { k } else { best })
    }

    /// The filter of the linear thread, unless it has been dropped.
    #[must_use]
    pub fn linear_member(&self) -> Option<&AugmentedFilter> {
        self.linear.is_taken.then_some(&self.linear.filter)
    }

    /// The filters of threads that yield; none where one has been dropped.
    #[must_use]
    pub fn yielding_members(&self) -> [Option<&DahlFilter>; MEMBERS - 1] {
        self.yielding.each_ref().map(|seat| seat.is_taken.then_some(&seat.filter))
    }

    /// The friction that the best member that yields believes in, if one is left. It means nothing
    /// where the linear thread leads.
    #[must_use]
    pub fn leading_yield(&self) -> Option<LearntYield> {
        let taken = self.yielding.iter().filter(|seat| seat.is_taken);
        let best = taken.max_by(|a, b| a.log_likelihood.total_cmp(&b.log_likelihood))?;
        Some(best.filter.learnt_yield())
    }

    /// Mean and standard deviation of the yield angle over all members that yield, rad, if one is
    /// left.
    #[must_use]
    pub fn yield_angle_rad(&self) -> Option<(f64, f64)> {
        let [_, weights @ ..] = self.weights();
        let all = || {
            let taken = self.yielding.iter().zip(weights).filter(|(seat, _)| seat.is_taken);
            taken.map(|(seat, weight)| (seat.filter.learnt_yield(), weight))
        };
        let sum: f64 = all().map(|(_, weight)| weight).sum();
        if sum <= 0.0 {
            // All of them are hopeless beside the linear thread; the least hopeless one stands.
            let best = self.leading_yield()?;
            return Some((best.yield_angle_rad, best.yield_angle_sigma_rad));
        }
        let mean: f64 = all().map(|(y, weight)| y.yield_angle_rad * weight / sum).sum();
        let variance = all().map(|(y, weight)| {
            let off = y.yield_angle_rad - mean;
            (y.yield_angle_sigma_rad * y.yield_angle_sigma_rad + off * off) * weight / sum
        });
        Some((mean, libm::sqrt(variance.sum())))
    }

    /// Period, damping and bias as the leading member believes them.
    #[must_use]
    pub fn learnt(&self) -> LearntParameters {
        self.leading_linear().learnt()
    }

    /// The leader's belief as a filter of the linear thread.
    fn leading_linear(&self) -> AugmentedFilter {
        match self.leader() {
            0 => self.linear.filter.clone(),
            k => self.yielding[k - 1].filter.linear(),
        }
    }

    /// −∞ for those that were dropped.
    fn log_likelihoods(&self) -> [f64; MEMBERS] {
        core::array::from_fn(|k| {
            at_place!(self, k, seat => {
                if seat.is_taken { seat.log_likelihood } else { f64::NEG_INFINITY }
            })
        })
    }

    /// Runs `call` on every member, drops those that refuse it, and gives the leader's answer. When
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
    fn level(&mut self) {
        let best = self.log_likelihoods().into_iter().fold(f64::NEG_INFINITY, f64::max);
        self.linear.log_likelihood -= best;
        for seat in &mut self.yielding {
            seat.log_likelihood -= best;
        }
    }

    /// Whether the leading member sees a rate that differs from none.
    fn sees_motion(&self) -> bool {
        let Some(belief) = at_place!(self, self.leader(), seat => seat.belief()) else {
            return false;
        };
        let rate2 = belief.rate_rad_s * belief.rate_rad_s;
        rate2 > MOTION_SIGMAS * MOTION_SIGMAS * belief.covariance.rate_rad2_s2
    }

    fn pass_over(&mut self) {
        self.watch.over_range(self.since_update_s);
        self.since_update_s = 0.0;
    }
}

/// An update may grow variances: a member's that was struck, and the mixture's when a member that
/// disagrees gains weight.
impl RateEstimator for HysteresisBank {
    fn predict(&mut self, span_s: f64) -> Result<(), EstimatorError> {
        check_span(span_s)?;
        let since_update_s = in_range(self.since_update_s + span_s)?;
        self.each(|seat| seat.filter.predict(span_s), |seat| seat.filter.predict(span_s))?;
        self.since_update_s = since_update_s;
        Ok(())
    }

    /// The innovation is the leading member's. A rate that it holds to be out of the gyro's range
    /// is judged, and then left out.
    fn update(&mut self, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        check_measurement(rate_rad_s)?;
        let judged = at_place!(self, self.leader(), seat => {
            let judged = seat.filter.judge(rate_rad_s);
            judged.map(|i| (i, seat.filter.is_over_range(rate_rad_s, i.residual_rad_s)))
        });
        if let Ok((innovation, true)) = judged {
            self.pass_over();
            return Ok(innovation);
        }
        let taken = self.each(|seat| seat.update(rate_rad_s), |seat| seat.update(rate_rad_s))?;
        let Taken { innovation, gated, struck } = taken;
        self.level();
        self.watch.used(self.since_update_s, (!gated).then(|| innovation.nis()));
        if struck {
            self.watch.alarm();
        }
        self.since_update_s = 0.0;
        self.has_moved = self.has_moved || self.sees_motion();
        Ok(innovation)
    }

    /// It is judged by the leading member, and left out.
    fn update_over_range(&mut self, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        check_measurement(rate_rad_s)?;
        let innovation = at_place!(self, self.leader(), seat => seat.filter.judge(rate_rad_s))?;
        self.pass_over();
        Ok(innovation)
    }

    fn belief(&self) -> Belief {
        let weights = self.weights();
        let beliefs: [Option<Belief>; MEMBERS] =
            core::array::from_fn(|k| at_place!(self, k, seat => seat.belief()));
        let mut belief = mixture(&beliefs, &weights);
        if !self.has_moved {
            let variance = &mut belief.covariance.angle_rad2;
            *variance = variance.max(self.start_variance_rad2);
        }
        belief
    }

    fn status(&self) -> Status {
        let linear = self.leading_linear();
        let (at_bound, period_s) = (linear.is_at_a_bound(), linear.learnt().period_s);
        match self.watch.status(self.belief().covariance.angle_rad2, period_s, at_bound) {
            Status::Nominal if self.yield_lead() > ANNOUNCED_LEAD => {
                self.leading_yield().map_or(Status::Nominal, |y| Status::ThreadYields {
                    yield_angle_rad: y.yield_angle_rad,
                })
            }
            other => other,
        }
    }

    fn saved_len(&self) -> usize {
        let yielding: usize = self.yielding.iter().map(Seat::saved_len).sum();
        self.linear.saved_len() + yielding + 8 + 8 + Watch::SAVED_LEN
    }

    fn save(&self, out: &mut [u8]) {
        let mut out = Writer::new(out);
        self.linear.write(&mut out);
        for seat in &self.yielding {
            seat.write(&mut out);
        }
        out.u64(u64::from(self.has_moved));
        out.f64(self.since_update_s);
        self.watch.write(&mut out);
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        let mut bytes = Reader::new(bytes, self.saved_len())?;
        let mut bank = self.clone();
        bank.linear.read(&mut bytes)?;
        for seat in &mut bank.yielding {
            seat.read(&mut bytes)?;
        }
        bank.has_moved = bytes.u64() != 0;
        bank.since_update_s = bytes.finite("since_update_s")?;
        bank.watch = Watch::read(&mut bytes)?;
        if bank.log_likelihoods().iter().all(|likelihood| *likelihood == f64::NEG_INFINITY) {
            return Err(RestoreError::Impossible);
        }
        *self = bank;
        Ok(())
    }
}

/// Mean and covariance of a mixture.
fn mixture(beliefs: &[Option<Belief>; MEMBERS], weights: &[f64; MEMBERS]) -> Belief {
    let all = || beliefs.iter().zip(weights).filter_map(|(b, w)| b.map(|b| (b, *w)));
    let angle_rad: f64 = all().map(|(b, w)| w * b.angle_rad).sum();
    let rate_rad_s: f64 = all().map(|(b, w)| w * b.rate_rad_s).sum();
    let mut covariance = Covariance::diagonal(0.0, 0.0);
    for (b, w) in all() {
        let (off, off_rate) = (b.angle_rad - angle_rad, b.rate_rad_s - rate_rad_s);
        covariance.angle_rad2 += w * (b.covariance.angle_rad2 + off * off);
        covariance.cross_rad2_s += w * (b.covariance.cross_rad2_s + off * off_rate);
        covariance.rate_rad2_s2 += w * (b.covariance.rate_rad2_s2 + off_rate * off_rate);
    }
    Belief { angle_rad, rate_rad_s, covariance }
}
