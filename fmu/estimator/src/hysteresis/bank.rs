//! The bank: one filter of a linear thread and four of threads that yield, weighed against each
//! other.

use super::config::YieldPrior;
use super::filter::{DahlFilter, LearntYield};
use super::member::{MEMBERS, Seats, Taken};
use super::memory::{Memory, Sample};
use crate::augmented::watch::Watch;
use crate::augmented::windows::{CLIP, InnovationTest, Windows};
use crate::checks::{check_measurement, check_span, in_range};
use crate::config::ConfigError;
use crate::state_bytes::{Reader, RestoreError, Writer};
use crate::{
    AugmentedConfig, AugmentedFilter, Belief, Covariance, EstimatorError, Innovation,
    LearntParameters, RateEstimator, Status,
};

/// Weights are likelihoods to this power. Innovations of neighbouring samples share whatever the
/// models lack, so their product claims more than it knows.
const TEMPER: f64 = 0.5;
/// How far a thread that yields must lead in log-likelihood to be announced.
const ANNOUNCED_LEAD: f64 = 10.0;
/// How many of its standard deviations a rate must differ from none to be motion.
const MOTION_SIGMAS: f64 = 5.0;
/// Samples at the end of a re-run that are not gated: they may be the kick itself.
const UNGATED: u64 = 3;

/// Bank of Kalman filters for a thread that may yield, and its belief their mixture.
///
/// Members see the same measurements. The belief has mean and covariance of the mixture, which the
/// disagreement of its members widens. It costs twice the error of the linear filter alone where
/// the thread does not yield: use it where [`TestedFilter`](crate::TestedFilter) doubts its model
/// and nothing visible struck the body.
///
/// Each member has a gate for outliers, and the leading one's innovations are tested for kicks as
/// those of [`TestedFilter`](crate::TestedFilter) are, over windows up to 256 samples. On an alarm
/// all members go back to before the kick and run again, their rates as uncertain as the kick was
/// large. What that takes, some 50 kB, is allocated once, when the bank is made.
///
/// A body that has not moved yet shows nothing: until a rate is seen that differs from none, the
/// belief claims no more of the angle than was known at the start.
///
/// A member that leaves the range of floating point is dropped, and the bank goes on with the
/// others.
#[derive(Debug, Clone)]
pub struct HysteresisBank {
    priors: [YieldPrior; MEMBERS - 1],
    seats: Seats,
    windows: Windows,
    kick_floor_variance: f64,
    /// Variance of the angle that was believed at the start, rad².
    start_variance_rad2: f64,
    has_moved: bool,
    /// Seconds predicted since the last measurement.
    since_update_s: f64,
    memory: Memory,
    watch: Watch,
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
        let test = InnovationTest::STANDARD;
        let seats = Seats::new(config, priors)?;
        Ok(Self {
            priors: *priors,
            windows: Windows::new(&test),
            kick_floor_variance: test.kick_floor_rad_s * test.kick_floor_rad_s,
            start_variance_rad2: seats.linear.filter.belief().covariance.angle_rad2,
            has_moved: false,
            since_update_s: 0.0,
            memory: Memory::new(&seats),
            watch: Watch::default(),
            seats,
        })
    }

    /// Starts afresh with another start belief and noise, as a [new](Self::with_priors) bank with
    /// the same priors of the friction would, without allocating.
    ///
    /// # Errors
    /// [`ConfigError`] names the value out of its bound; the bank is then unchanged.
    pub fn restart(&mut self, config: &AugmentedConfig) -> Result<(), ConfigError> {
        let seats = Seats::new(config, &self.priors)?;
        self.start_variance_rad2 = seats.linear.filter.belief().covariance.angle_rad2;
        (self.has_moved, self.since_update_s) = (false, 0.0);
        self.memory.clear(&seats);
        self.watch = Watch::default();
        self.seats = seats;
        Ok(())
    }

    /// Predicts over `span_s` and takes in a measurement valid at its end: both, or neither.
    ///
    /// # Errors
    /// What predict and update refuse; the bank is then as it was before the call.
    pub fn step(&mut self, span_s: f64, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        let before = (self.seats.clone(), self.since_update_s);
        self.predict(span_s)?;
        // An update that is refused changes nothing, so the prediction alone is taken back.
        let updated = self.update(rate_rad_s);
        if updated.is_err() {
            (self.seats, self.since_update_s) = before;
        }
        updated
    }

    /// Weights of the members, the linear thread's first: they sum to 1; a member that was dropped
    /// has none.
    #[must_use]
    pub fn weights(&self) -> [f64; MEMBERS] {
        let likelihoods = self.seats.log_likelihoods();
        let best = likelihoods.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let raw = likelihoods.map(|likelihood| libm::exp(TEMPER * (likelihood - best)));
        let sum: f64 = raw.iter().sum();
        raw.map(|weight| weight / sum)
    }

    /// How far the best member that yields leads the linear thread in log-likelihood. Infinite when
    /// one of the two sides has been dropped.
    #[must_use]
    pub fn yield_lead(&self) -> f64 {
        let [linear, yielding @ ..] = self.seats.log_likelihoods();
        yielding.into_iter().fold(f64::NEG_INFINITY, f64::max) - linear
    }

    /// Place of the member with the largest likelihood, 0 for the linear thread.
    #[must_use]
    pub fn leader(&self) -> usize {
        self.seats.leader()
    }

    /// Alarms of the innovation test so far.
    #[must_use]
    pub fn alarms(&self) -> u64 {
        self.watch.alarms()
    }

    /// The filter of the linear thread, unless it has been dropped.
    #[must_use]
    pub fn linear_member(&self) -> Option<&AugmentedFilter> {
        let seat = &self.seats.linear;
        seat.is_taken.then_some(&seat.filter)
    }

    /// The filters of threads that yield; none where one has been dropped.
    #[must_use]
    pub fn yielding_members(&self) -> [Option<&DahlFilter>; MEMBERS - 1] {
        self.seats.yielding.each_ref().map(|seat| seat.is_taken.then_some(&seat.filter))
    }

    /// The friction that the best member that yields believes in, if one is left. It means nothing
    /// where the linear thread leads.
    #[must_use]
    pub fn leading_yield(&self) -> Option<LearntYield> {
        let taken = self.seats.yielding.iter().filter(|seat| seat.is_taken);
        let best = taken.max_by(|a, b| a.log_likelihood.total_cmp(&b.log_likelihood))?;
        Some(best.filter.learnt_yield())
    }

    /// Mean and standard deviation of the yield angle over all members that yield, rad, if one is
    /// left.
    #[must_use]
    pub fn yield_angle_rad(&self) -> Option<(f64, f64)> {
        let [_, weights @ ..] = self.weights();
        let all = || {
            let taken = self.seats.yielding.iter().zip(weights).filter(|(seat, _)| seat.is_taken);
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
            0 => self.seats.linear.filter.clone(),
            k => self.seats.yielding[k - 1].filter.linear(),
        }
    }

    /// Whether the leading member sees a rate that differs from none.
    fn sees_motion(&self) -> bool {
        let Some(belief) = self.seats.belief(self.leader()) else {
            return false;
        };
        let rate2 = belief.rate_rad_s * belief.rate_rad_s;
        rate2 > MOTION_SIGMAS * MOTION_SIGMAS * belief.covariance.rate_rad2_s2
    }

    /// Notes a measurement that is not used.
    fn pass_over(&mut self) {
        let span_s = core::mem::take(&mut self.since_update_s);
        let sample = Sample { span_s, rate_rad_s: None, residual_rad_s: 0.0 };
        self.memory.push(sample, 0.0, &self.seats);
        self.watch.over_range(span_s);
    }

    /// Goes back, runs again, and starts afresh from there.
    #[cold]
    #[inline(never)]
    fn raise_alarm(&mut self) {
        let memory = &self.memory;
        let length = self.windows.furthest(memory.reach(), |length| memory.sum_over(length));
        // A re-run that leaves the range of floating point is given up; what stands, stands.
        if let Ok(seats) = self.rerun(length) {
            self.seats = seats;
        }
        self.memory.reset(&self.seats);
        self.watch.alarm();
    }

    /// The members now, had a kick as large as the window shows been reckoned with from before it.
    fn rerun(&self, length: usize) -> Result<Seats, EstimatorError> {
        let kick_rad_s = self.memory.mean_residual_rad_s(length);
        let way = self.memory.way_back(length);
        let inflation = 4.0 * kick_rad_s * kick_rad_s + self.kick_floor_variance;
        let inflation = in_range(inflation / way.doubted as f64)?;
        let mut seats = way.seats.clone();
        for (k, sample) in (1..=way.count).zip(self.memory.latest(way.count)) {
            seats.predict(sample.span_s)?;
            if k + way.doubted > way.count {
                seats.widen_rates(inflation);
            }
            if let Some(rate_rad_s) = sample.rate_rad_s {
                seats.update(rate_rad_s, k + UNGATED <= way.count)?;
            }
        }
        Ok(seats)
    }
}

/// An update may grow variances: all of them when it raises an alarm, and the mixture's when a
/// member that disagrees gains weight.
impl RateEstimator for HysteresisBank {
    fn predict(&mut self, span_s: f64) -> Result<(), EstimatorError> {
        check_span(span_s)?;
        let since_update_s = in_range(self.since_update_s + span_s)?;
        self.seats.predict(span_s)?;
        self.since_update_s = since_update_s;
        Ok(())
    }

    /// The innovation is the leading member's. A rate that it holds to be out of the gyro's range
    /// is judged, and then left out.
    fn update(&mut self, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        check_measurement(rate_rad_s)?;
        if let Ok((innovation, true)) = self.seats.judge(rate_rad_s) {
            self.pass_over();
            return Ok(innovation);
        }
        let Taken { innovation, gated } = self.seats.update(rate_rad_s, true)?;
        let span_s = core::mem::take(&mut self.since_update_s);
        let residual_rad_s = innovation.residual_rad_s;
        let normalised = residual_rad_s / libm::sqrt(innovation.variance_rad2_s2);
        let sample = Sample { span_s, rate_rad_s: Some(rate_rad_s), residual_rad_s };
        self.memory.push(sample, normalised.clamp(-CLIP, CLIP), &self.seats);
        self.watch.used(span_s, (!gated).then_some(normalised * normalised));
        let memory = &self.memory;
        if self.windows.any_beyond(memory.reach(), |length| memory.sum_over(length)) {
            self.raise_alarm();
        }
        self.has_moved = self.has_moved || self.sees_motion();
        Ok(innovation)
    }

    /// It is judged by the leading member, and left out.
    fn update_over_range(&mut self, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        check_measurement(rate_rad_s)?;
        let (innovation, _) = self.seats.judge(rate_rad_s)?;
        self.pass_over();
        Ok(innovation)
    }

    fn belief(&self) -> Belief {
        let weights = self.weights();
        let beliefs: [Option<Belief>; MEMBERS] = core::array::from_fn(|k| self.seats.belief(k));
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
        self.seats.saved_len() + 8 + 8 + Watch::SAVED_LEN + self.memory.saved_len()
    }

    fn save(&self, out: &mut [u8]) {
        let mut out = Writer::new(out);
        self.seats.write(&mut out);
        out.u64(u64::from(self.has_moved));
        out.f64(self.since_update_s);
        self.watch.write(&mut out);
        self.memory.write(&mut out);
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        let mut bytes = Reader::new(bytes, self.saved_len())?;
        let mut bank = self.clone();
        bank.seats.read(&mut bytes)?;
        bank.has_moved = bytes.u64() != 0;
        bank.since_update_s = bytes.finite("since_update_s")?;
        bank.watch = Watch::read(&mut bytes)?;
        bank.memory.read(&mut bytes)?;
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
