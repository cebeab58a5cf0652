//! The switch: what a sample changes in who speaks.

use super::estimator::{Clock, LiveEstimator, Phase};
use super::eye::Sight;
use super::handover::{blurred, prior_of, torsion_of, with_gain};
use super::pursuit::{News, Pursuit};
use super::tape::{Anchors, Sample};
use crate::augmented::State;
use crate::swing::SwingFilter;
use crate::{AugmentedConfig, EstimatorError, RateEstimator, StartPrior, Status};
use alloc::boxed::Box;

/// One degree, rad.
const DEG: f64 = core::f64::consts::PI / 180.0;
/// Largest swing that is reckoned with, rad.
const SWING_MAX_RAD: f64 = 1.5;
/// Lead in log-likelihood of a thread that yields, from which on it is believed.
const YIELD_LEAD: f64 = 10.0;
/// How long a thread must seem to yield, s: so long a swing may look like that.
const YIELD_DELAY_S: f64 = 5.2;
/// Alarms that a blow may raise beyond its first.
const ALARMS_OF_A_BLOW: u64 = 1;
/// How long pure torsion must explain the rates before it is believed where a swing may go unseen,
/// s. A swing of 1° and more shows itself as an alarm by then, one of 3° a hundred times as soon.
const UNTRIED_S: f64 = 10.24;
/// How wrong the twist may be once the filter that followed the swing has lost it, rad.
const LOST_RAD: f64 = 11.0 * DEG;

impl LiveEstimator {
    /// Notes a measurement that the speaker has taken in, and moves on.
    pub(super) fn note(&mut self, rate_rad_s: Option<f64>) {
        let sample = Sample { span_s: self.clock.since_update_s, rate_rad_s };
        self.clock.since_update_s = 0.0;
        self.clock.over_range_s =
            if rate_rad_s.is_some() { 0.0 } else { self.clock.over_range_s + sample.span_s };
        self.tape.push(sample);
        if self.eye.push(sample) && (self.clock.doubts || !matches!(self.phase, Phase::Torsion)) {
            self.fallback.set_swing(self.swing_size_rad(), self.eye.rate_variance_rad2_s2());
        }
        self.phase = match core::mem::replace(&mut self.phase, Phase::Torsion) {
            Phase::Torsion => self.after_torsion(sample),
            swinging => {
                self.clock.away_s += sample.span_s;
                self.after_swing(swinging)
            }
        };
    }

    /// Swing that the fallback reckons with, rad.
    ///
    /// What leaks into the rate is the swing about one axis. Until the body has had time to turn
    /// by a quarter, and where the leak has no scale, it is what the operator lets happen.
    fn swing_size_rad(&self) -> f64 {
        let declared_rad = self.setup.swing_max_rad;
        let size_rad = match self.eye.swing_rad() {
            None => declared_rad,
            Some((_, largest_rad)) if self.clock.away_s > self.quarter_s() => largest_rad,
            Some((_, largest_rad)) => largest_rad.max(declared_rad),
        };
        size_rad.min(SWING_MAX_RAD)
    }

    fn quarter_s(&self) -> f64 {
        0.25 * self.setup.torsion.start.period_s
    }

    /// The phase after a sample without swing.
    fn after_torsion(&mut self, sample: Sample) -> Phase {
        if !self.clock.doubts {
            let state = || self.torsion.filter().state();
            self.anchors.pass(sample.span_s, self.tape.last(), state);
        }
        if self.eye.sees_swing() {
            return self.begin_swing();
        }
        self.clock.torsion_s += sample.span_s;
        self.judge_thread(sample.span_s);
        self.judge_torsion(sample.span_s)
    }

    /// Whether pure torsion is to be doubted, and the fallback to speak from before that was known.
    ///
    /// The claim of a filter of pure torsion means nothing while a swing may bend it. One that has
    /// had to answer a blow goes on when that is over; one that has been refuted again and again
    /// in between starts anew from the bound.
    fn judge_torsion(&mut self, span_s: f64) -> Phase {
        let may_swing = self.may_swing_unseen();
        if !self.clock.doubts {
            if may_swing {
                self.bound_from_before();
                (self.clock.doubts, self.clock.answered) = (true, self.torsion.alarms());
            }
            return Phase::Torsion;
        }
        self.time_quiet(span_s);
        let is_refuted = self.torsion.alarms() > self.clock.answered + ALARMS_OF_A_BLOW;
        if self.clock.quiet_s > 2.0 * self.quarter_s() || (is_refuted && !may_swing) {
            return self.end_swing(self.fallback.state());
        }
        if !may_swing {
            self.clock.doubts = false;
            self.anchors = Anchors::new(self.tape.last(), self.torsion.filter().state());
        }
        Phase::Torsion
    }

    /// For how long nothing new has spoken against pure torsion. What a thread that yields has once
    /// explained better it leads by for good, though the swing that it explained has died away.
    fn time_quiet(&mut self, span_s: f64) {
        // Infinite or no number where a side has been dropped; what is kept must be a number.
        let lead = self.bank.yield_lead();
        let lead = if lead.is_nan() { 0.0 } else { lead.clamp(f64::MIN, f64::MAX) };
        let clock = &mut self.clock;
        if self.torsion.status() == Status::Nominal && lead < clock.lead + YIELD_LEAD {
            clock.quiet_s += span_s;
        } else {
            (clock.quiet_s, clock.lead) = (0.0, lead);
        }
    }

    /// Whether the thread yields: the test for kicks fires and fires, or has never fired at all,
    /// and a thread that yields explains the record far better.
    ///
    /// A blow may lend a yielding thread likelihood for good; one that the test has answered and
    /// got over is no sign of it. Where a swing may go unseen it is the likelier reason.
    fn judge_thread(&mut self, span_s: f64) {
        if self.hides_swing() {
            return;
        }
        let lead = self.bank.yield_lead();
        let clock = &mut self.clock;
        if clock.yields {
            clock.yields = lead > 0.0;
            return;
        }
        let open = self.torsion.status() == Status::ModelDoubtful || self.torsion.alarms() == 0;
        let seems = lead > YIELD_LEAD && open && !self.eye.is_suspicious();
        clock.yields_s = if seems { clock.yields_s + span_s } else { 0.0 };
        clock.yields = clock.yields_s > YIELD_DELAY_S;
    }

    /// Whether a thread that yields explains the record far better, though the test for kicks has
    /// been content since it last fired. A small blow may look like that, and so does a thread
    /// that has only slipped one way: what is claimed may be wrong.
    pub(super) fn is_thread_suspect(&self) -> bool {
        self.torsion.alarms() > 0 && self.bank.yield_lead() > YIELD_LEAD
    }

    /// Whether the gyro's axis may hide the swing of a declared body: it is not calibrated, or it
    /// is the body's own.
    fn hides_swing(&self) -> bool {
        self.setup.swing.is_some() && self.eye.sight() != Sight::Sharp
    }

    /// Whether pure torsion does not explain the rates, or has not done so for long, and the reason
    /// may be a swing that the axis does not show. There is no telling then what the angle is.
    fn may_swing_unseen(&self) -> bool {
        // What has been doubted is so until nothing at all speaks against it.
        let lead = if self.clock.doubts { 0.0 } else { YIELD_LEAD };
        self.hides_swing()
            && (self.clock.torsion_s < UNTRIED_S
                || self.torsion.status() != Status::Nominal
                || self.bank.yield_lead() > lead)
    }

    /// A swing has been seen: the fallback takes over from before it began.
    fn begin_swing(&mut self) -> Phase {
        let is_bounded = self.clock.doubts;
        self.clock = Clock { over_range_s: self.clock.over_range_s, ..Clock::default() };
        // A bound that speaks already goes back further than one that would begin now.
        if !is_bounded {
            self.bound_from_before();
        }
        let anchor = self.anchors.oldest();
        let from_start = self.eye.has_never_been_calm() && self.tape.oldest() == 1;
        let declared = self.setup.swing.filter(|_| from_start);
        if let Some(swing) = declared {
            return self.pursue(swing.start, 1);
        }
        self.pursue(self.measured_prior(anchor.state), self.tape.last())
    }

    /// The fallback's belief with the parameters of `learnt`, as it is of what the gyro measures.
    fn measured_prior(&self, learnt: State) -> StartPrior {
        let measured = |state| with_gain(state, 1.0 / self.setup.gain);
        prior_of(&measured(self.fallback.state()), &measured(learnt))
    }

    /// What the filter of the swinging body believes of the torsion, as it is of the rate about the
    /// body's axis.
    fn torsion_of(&self, filter: &SwingFilter) -> Result<State, EstimatorError> {
        torsion_of(&filter.swing_belief()).map(|state| with_gain(state, self.setup.gain))
    }

    /// Starts the fallback from a belief of now. One that it refuses leaves it where it stood.
    fn begin_fallback(&mut self, from: State) {
        let (swing_rad, variance) = (self.swing_size_rad(), self.eye.rate_variance_rad2_s2());
        let mut fallback = self.fallback.clone();
        if fallback.begin(from, swing_rad, variance).is_ok() {
            self.fallback = fallback;
        }
    }

    /// Starts the fallback from before what has just been noticed.
    fn bound_from_before(&mut self) {
        let anchor = self.anchors.oldest();
        if self.fallback_from(anchor.number, anchor.state).is_err() {
            self.begin_fallback(self.torsion.filter().state());
        }
    }

    /// Runs the fallback from a belief of some seconds ago to the present: a thousand small steps.
    fn fallback_from(&mut self, number: u64, state: State) -> Result<(), EstimatorError> {
        let mut fallback = self.fallback.clone();
        fallback.begin(state, self.swing_size_rad(), self.eye.rate_variance_rad2_s2())?;
        for number in number + 1..=self.tape.last() {
            let Some(sample) = self.tape.get(number) else { continue };
            fallback.predict(sample.span_s)?;
            if let Some(rate_rad_s) = sample.rate_rad_s {
                fallback.update(self.setup.gain * rate_rad_s)?;
            }
        }
        self.fallback = fallback;
        Ok(())
    }

    /// A fit of the samples from `first` on, where a fit has a meaning.
    fn pursue(&mut self, prior: StartPrior, first: u64) -> Phase {
        let Some(mut pursuit) = self.spares.pursuit.take() else { return Phase::Unseen };
        if pursuit.begin(&prior, (&self.tape, first..=self.tape.last())).is_ok() {
            return Phase::Fitting(pursuit);
        }
        self.spares.pursuit = Some(pursuit);
        Phase::Unseen
    }

    /// Takes back what a pursuit has had, when it is over.
    fn give_back(&mut self, mut pursuit: Box<Pursuit>) {
        self.spares.filter = pursuit.give_back().or(self.spares.filter.take());
        self.spares.pursuit = Some(pursuit);
    }

    /// A fit from now on, from the fallback's belief.
    pub(super) fn pursue_afresh(&mut self) -> Phase {
        let prior = self.measured_prior(self.anchors.oldest().state);
        self.pursue(prior, self.tape.last() + 1)
    }

    /// The phase after a sample while it swings.
    fn after_swing(&mut self, phase: Phase) -> Phase {
        match phase {
            Phase::Swinging(filter) => self.after_following(filter),
            Phase::Fitting(pursuit) if self.eye.is_calm() => {
                self.give_back(pursuit);
                self.end_swing(self.fallback.state())
            }
            Phase::Fitting(pursuit) => self.after_fitting(pursuit),
            _ if self.eye.is_calm() => self.end_swing(self.fallback.state()),
            other => other,
        }
    }

    fn after_fitting(&mut self, mut pursuit: Box<Pursuit>) -> Phase {
        match pursuit.go_on(&self.tape, self.tape.last(), &mut self.spares.filter) {
            News::Caught(filter) => {
                self.give_back(pursuit);
                self.doubt = super::doubt::Doubt::default();
                Phase::Swinging(filter)
            }
            News::None if !pursuit.outgrows(&self.tape) => Phase::Fitting(pursuit),
            News::None | News::Lost => {
                self.give_back(pursuit);
                self.pursue_afresh()
            }
        }
    }

    fn after_following(&mut self, filter: Box<SwingFilter>) -> Phase {
        if self.eye.is_calm() && filter.amplitude_rad() < self.eye.gone_rad() {
            let state = self.torsion_of(&filter);
            self.spares.filter = Some(filter);
            // What is no belief of a filter of pure torsion leaves the bound.
            return self.end_swing(state.unwrap_or_else(|_| self.fallback.state()));
        }
        if self.doubt.is_lost() {
            self.fall_back(filter);
            return self.pursue_afresh();
        }
        Phase::Swinging(filter)
    }

    /// The filter of the swinging body has lost the motion: what it believed of the twist is where
    /// the fallback starts, less certain by what it may be wrong.
    pub(super) fn fall_back(&mut self, filter: Box<SwingFilter>) {
        let from = self.torsion_of(&filter).map(|state| blurred(state, LOST_RAD));
        self.spares.filter = Some(filter);
        self.begin_fallback(from.unwrap_or_else(|_| self.torsion.filter().state()));
    }

    /// Back to pure torsion from a belief of now.
    fn end_swing(&mut self, state: State) -> Phase {
        if self.torsion.restart(state, self.clock.away_s).is_err() {
            return Phase::Unseen;
        }
        let state = self.torsion.filter().state();
        self.anchors = Anchors::new(self.tape.last(), state);
        let config = AugmentedConfig { start: prior_of(&state, &state), ..self.setup.torsion };
        // A start belief that it refuses leaves the bank as it was before the swing.
        let _ = self.bank.restart(&config);
        self.clock = Clock { over_range_s: self.clock.over_range_s, ..Clock::default() };
        Phase::Torsion
    }
}
