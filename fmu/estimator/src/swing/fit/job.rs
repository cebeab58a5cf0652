//! The fit as a job that is done piece by piece.

use super::AcceptedFit;
use super::bounded::Bounded;
use super::levenberg::{Descending, Descent, Ground};
use super::modes::prune;
use super::outcome::{FitOutcome, Progress, Rejection};
use super::pass::{Budget, Pass};
use super::plan::{
    COST_HOPELESS, DENSE_SWING, HOPELESS_CUTS, Plan, RESTART_RATE_SIGMA_RAD_S,
    RESTART_TWIST_SIGMA_RAD, STARTS_MAX, SWING_SIGMA_MIN_RAD, Stage,
};
use super::problem::{Problem, WindowStart, first_start};
use super::record::{Record, averages, mean};
use super::residuals::Inspection;
use super::starts::{Hypotheses, starts};
use super::verdict::Verdict;
use crate::StartPrior;
use crate::config::{ConfigError, judge, positive};
use crate::swing::SwingConfig;
use crate::swing::amplitude::{Leak, SWING_PRESENT_RAD, SwingMeter};

/// Standard deviations of its calibration by which a misalignment must differ from none.
const ASKEW_SIGMAS: f64 = 3.0;
/// Samples in a window, at most.
const SAMPLES_MAX: f64 = 1e6;

/// How many starts a fit makes. Fewer than all are for the comparison that shows what they are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FitStarts {
    /// 25 starts, and 73 when none of them holds.
    #[default]
    All,
    /// 25 starts and no retry.
    NoRetry,
    /// One start, in which the hidden component of the swing is zero.
    Single,
}

/// What is being done.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Phase {
    /// Samples for the first window and for the size of the swing are being collected.
    Collecting,
    /// Every start goes down to the bottom of its valley, in the window of this stage.
    Descending(usize),
    /// What the best end leaves is looked at.
    Inspecting,
    Accepted,
    Refused(Rejection),
}

/// Starts the filter of a swinging body: fits the motion to the first minute of the record.
///
/// The component of the swing that the gyro does not see enters the twist's rate quadratically, so
/// the cost has many valleys; a filter that is linearised at one point commits to one of them,
/// mostly a wrong one. The fit descends into all of them and keeps what fits; a descent that does
/// not even promise to come near the best is not finished. No claim is made
/// unless what is left passes for noise.
///
/// It is a job done in pieces: [`push`](Self::push) takes a sample and does nothing else,
/// [`work`](Self::work) does at most as many steps of the model as it is told and returns. However
/// the work is cut, the outcome is the same to the bit, as long as the work keeps up with the
/// samples to within two minutes.
///
/// What it needs, some 400 kB and 16 bytes for each sample, is allocated when it is made. Fits of
/// later swings, begun by [`restart`](Self::restart), make do with that.
#[derive(Debug, Clone, PartialEq)]
pub struct SwingFit {
    config: SwingConfig,
    period_s: f64,
    choice: FitStarts,
    plan: Plan,
    record: Record,
    start: Option<WindowStart>,
    restarts: u32,
    dense: bool,
    /// The problem of the window at hand, once the size of the swing is known.
    problem: Option<Problem>,
    /// The window at hand, averaged as its stage says.
    window: Bounded<f64>,
    /// Still to descend, the next one last, and a step of that one that is under way.
    waiting: Bounded<Descent>,
    trial: Option<Pass>,
    ends: Bounded<Descent>,
    inspection: Option<Inspection>,
    accepted: Option<AcceptedFit>,
    phase: Phase,
    rejected: Option<Rejection>,
}

impl SwingFit {
    /// A fit for a gyro that is sampled every `period_s`. The first sample is taken at the time of
    /// which the configuration's start belief speaks.
    ///
    /// A misalignment that is less than three standard deviations of its calibration is no error:
    /// the fit is then [refused](FitOutcome::Refused) from the beginning.
    ///
    /// # Errors
    /// [`ConfigError`] for a value out of its bound; for a sample period of more than half a
    /// radian of the swing, or so short that a window would hold more than a million samples.
    pub fn new(config: &SwingConfig, period_s: f64) -> Result<Self, ConfigError> {
        Self::with_room(config, period_s, config.start.period_s)
    }

    /// The same with memory for every period of the torsion up to `longest_s` that a
    /// [`restart`](Self::restart) may name.
    ///
    /// # Errors
    /// [`ConfigError`] as [`new`](Self::new), for the longer one of the two periods.
    pub fn with_room(
        config: &SwingConfig,
        period_s: f64,
        longest_s: f64,
    ) -> Result<Self, ConfigError> {
        config.validate()?;
        positive("period_s", period_s)?;
        positive("longest_s", longest_s)?;
        let swing_rad_s = config.body.swing_frequency_rad_s();
        let step_rad = swing_rad_s * period_s;
        judge("period_s", period_s, step_rad <= 0.5, "half a radian of swing at most")?;
        let plan = Plan::new(longest_s.max(config.start.period_s), swing_rad_s, period_s);
        let ok = plan.capacity as f64 <= SAMPLES_MAX;
        judge("period_s", period_s, ok, "long enough for a million samples in all")?;
        // Where nothing will be fitted there is nothing to keep.
        let room = |count| if refusal(config).is_none() { count } else { 0 };
        let mut fit = Self {
            config: *config,
            period_s,
            choice: FitStarts::All,
            record: Record::new(room(plan.capacity)),
            window: Bounded::new(room(plan.longest)),
            plan,
            start: None,
            restarts: 0,
            dense: false,
            problem: None,
            waiting: Bounded::new(room(STARTS_MAX)),
            trial: None,
            ends: Bounded::new(room(STARTS_MAX)),
            inspection: None,
            accepted: None,
            phase: Phase::Collecting,
            rejected: None,
        };
        fit.restart(&config.start)?;
        Ok(fit)
    }

    /// Begins again with another start belief and no samples, without allocating.
    ///
    /// # Errors
    /// [`ConfigError`] for a belief out of its bounds, or for a period of the torsion longer than
    /// there is memory for; the fit is then unchanged.
    pub fn restart(&mut self, start: &StartPrior) -> Result<(), ConfigError> {
        start.validate()?;
        let refused = refusal(&self.config);
        let swing_rad_s = self.config.body.swing_frequency_rad_s();
        let plan = Plan::new(start.period_s, swing_rad_s, self.period_s);
        let capacity = if refused.is_none() { plan.capacity } else { 0 };
        let fits = self.record.restart(capacity);
        judge("period_s", start.period_s, fits, "no longer than there is memory for")?;
        (self.config.start, self.plan) = (*start, plan);
        (self.start, self.restarts, self.rejected, self.accepted) = (None, 0, None, None);
        self.collect(false);
        self.phase = refused.map_or(Phase::Collecting, Phase::Refused);
        Ok(())
    }

    /// The same fit with fewer starts: it fails more often, and says so.
    #[must_use]
    pub fn with_starts(mut self, choice: FitStarts) -> Self {
        self.choice = choice;
        self
    }

    /// Takes the next sample, rad/s; one that is not finite is missing. Constant time, apart from
    /// a move of the record when the work has lagged behind by two minutes.
    pub fn push(&mut self, rate_rad_s: f64) {
        if matches!(self.phase, Phase::Refused(_)) {
            return;
        }
        if self.record.is_full() {
            self.move_on(Rejection::Starved);
        }
        self.record.push(rate_rad_s);
    }

    /// Does at most `steps` steps of the model, with its derivatives, and what lies between them.
    pub fn work(&mut self, steps: usize) -> Progress {
        let mut budget = Budget(steps);
        loop {
            let progress = match self.phase {
                Phase::Collecting => self.begin(),
                Phase::Descending(stage) => self.descend(stage, &mut budget),
                Phase::Inspecting => self.inspect(&mut budget),
                Phase::Accepted | Phase::Refused(_) => Some(Progress::Done),
            };
            if let Some(progress) = progress {
                return progress;
            }
        }
    }

    /// Works until a fit is accepted or the samples are used up.
    ///
    /// # Errors
    /// [`Rejection`]: why the last window was given up, or that there are too few samples.
    pub fn run_to_end(&mut self) -> Result<&AcceptedFit, Rejection> {
        while self.work(usize::MAX) == Progress::Working {}
        let need = self.record.given_up() + self.needed() as u64;
        let have = self.record.given_up() + self.record.samples().len() as u64;
        match self.outcome() {
            FitOutcome::Accepted(fit) => Ok(fit),
            FitOutcome::Refused(rejection) => Err(rejection),
            FitOutcome::Pending { rejected } => {
                Err(rejected.unwrap_or(Rejection::TooShort { have, need }))
            }
        }
    }

    /// What the fit has come to so far.
    #[must_use]
    pub fn outcome(&self) -> FitOutcome<'_> {
        match (self.phase, &self.accepted) {
            (Phase::Accepted, Some(fit)) => FitOutcome::Accepted(fit),
            (Phase::Refused(rejection), _) => FitOutcome::Refused(rejection),
            _ => FitOutcome::Pending { rejected: self.rejected },
        }
    }

    /// The samples that came after the window of an accepted fit, oldest first, missing ones as
    /// NaN: what the filter that takes over has to catch up with. Empty before.
    #[must_use]
    pub fn samples_after(&self) -> &[f64] {
        let FitOutcome::Accepted(fit) = self.outcome() else {
            return &[];
        };
        let used = usize::try_from(fit.samples - self.record.given_up()).unwrap_or(usize::MAX);
        self.record.samples().get(used..).unwrap_or_default()
    }

    /// How many windows were given up.
    #[must_use]
    pub fn restarts(&self) -> u32 {
        self.restarts
    }

    /// Samples that the record must hold before more can be done.
    fn needed(&self) -> usize {
        match self.phase {
            Phase::Descending(stage) => {
                self.plan.stage(stage, self.dense).map_or(0, |stage| stage.samples)
            }
            _ => self.meter().map_or(0, |meter| meter.samples_to_fill()),
        }
    }

    fn meter(&self) -> Option<SwingMeter> {
        let body = &self.config.body;
        let askew_rad = self.config.axis.tilt_rad();
        SwingMeter::new(body.swing_frequency_rad_s(), askew_rad, self.period_s).ok()
    }

    /// Starts on a window when there are samples enough.
    fn begin(&mut self) -> Option<Progress> {
        let Some(mut meter) = self.meter() else {
            return self.give_up(Rejection::NoMotion);
        };
        let Some(seen) = self.record.samples().get(..meter.samples_to_fill()) else {
            return Some(Progress::NeedsSamples);
        };
        for sample in seen {
            meter.push(*sample);
        }
        let believed_rad_s = self.config.body.swing_frequency_rad_s();
        let first = seen.get(..self.plan.leak).unwrap_or(seen);
        let Some(leak) = Leak::scan(first, self.period_s, believed_rad_s) else {
            return self.give_up(Rejection::NoMotion);
        };
        let swing_rad = meter.largest_rad();
        let spread_rad = if self.dense { DENSE_SWING * swing_rad } else { swing_rad };
        let spread_rad = spread_rad.clamp(SWING_SIGMA_MIN_RAD, 1.0);
        let start = self.start.unwrap_or_else(|| first_start(&self.config, spread_rad));
        let problem = Problem::new(&self.config, self.period_s, &start, spread_rad);
        let starts = starts(&problem, &leak, swing_rad, self.hypotheses(swing_rad)).rev();
        self.waiting.extend(starts.map(|u| Descent::new(&problem, u)));
        self.enter(0, problem)
    }

    fn hypotheses(&self, swing_rad: f64) -> Hypotheses {
        match (self.choice, self.dense) {
            (FitStarts::Single, _) => Hypotheses::NONE,
            (_, true) => Hypotheses::DENSE,
            (_, false) if swing_rad < SWING_PRESENT_RAD => Hypotheses::NONE,
            (_, false) => Hypotheses::STANDARD,
        }
    }

    /// Sets out in the window of a stage with those that are waiting.
    fn enter(&mut self, index: usize, problem: Problem) -> Option<Progress> {
        let Some(&stage) = self.plan.stage(index, self.dense) else {
            return self.give_up(Rejection::NoMotion);
        };
        self.problem = Some(problem.averaging(&self.config, self.period_s, stage.averaged));
        self.phase = Phase::Descending(index);
        None
    }

    /// Averages the window of a stage, once it is there.
    fn fill(&mut self, stage: &Stage) -> bool {
        if self.window.len() * stage.averaged == stage.samples {
            return true;
        }
        self.window.clear();
        let samples = self.record.samples().get(..stage.samples);
        self.window.extend(samples.into_iter().flat_map(|all| averages(all, stage.averaged)));
        samples.is_some()
    }

    fn descend(&mut self, index: usize, budget: &mut Budget) -> Option<Progress> {
        let Some(&stage) = self.plan.stage(index, self.dense) else {
            return self.give_up(Rejection::NoMotion);
        };
        if !self.fill(&stage) {
            return Some(Progress::NeedsSamples);
        }
        let Some(problem) = &self.problem else {
            return self.give_up(Rejection::NoMotion);
        };
        while let Some(descent) = self.waiting.last_mut() {
            let hopeless = hopeless(&self.ends, &stage);
            let (samples, patience) = (&*self.window, stage.patience);
            let ground = Ground { problem, samples, patience, hopeless };
            match descent.advance(&mut self.trial, &ground, budget) {
                Descending::Budget => return Some(Progress::Working),
                Descending::Done => self.ends.extend(self.waiting.pop().into_iter()),
                Descending::Lost => drop(self.waiting.pop()),
            }
        }
        prune(&mut self.ends, &mut self.waiting, stage.cut);
        core::mem::swap(&mut self.ends, &mut self.waiting);
        self.after(index, &stage)
    }

    /// What comes after a window, its ends pruned: a longer one, the inspection, or another try.
    fn after(&mut self, index: usize, stage: &Stage) -> Option<Progress> {
        let (Some(best), Some(problem)) = (self.ends.first(), &self.problem) else {
            return self.give_up(Rejection::NoMotion);
        };
        let cost_per_sample = best.best().cost() / self.window.len() as f64;
        if stage.is_last {
            let u = best.best().unknowns();
            self.inspection = Some(Inspection::new(problem, u, self.period_s));
            self.phase = Phase::Inspecting;
            return None;
        }
        if index > 0 && cost_per_sample > COST_HOPELESS {
            return self.give_up(Rejection::Cost { cost_per_sample });
        }
        let next = self.plan.stage(index + 1, self.dense);
        if next.is_some_and(|next| next.averaged != stage.averaged) {
            let ends = self.ends.drain().rev();
            self.waiting.extend(ends.map(|end| Descent::new(problem, *end.best().unknowns())));
            let problem = problem.clone();
            return self.enter(index + 1, problem);
        }
        self.ends.iter_mut().for_each(Descent::again);
        self.waiting.extend(self.ends.drain().rev());
        self.phase = Phase::Descending(index + 1);
        None
    }

    fn inspect(&mut self, budget: &mut Budget) -> Option<Progress> {
        let last = (0..).map_while(|k| self.plan.stage(k, self.dense)).last();
        let (Some(stage), Some(problem), Some(inspection)) =
            (last, &self.problem, &mut self.inspection)
        else {
            return self.give_up(Rejection::NoMotion);
        };
        let Some(leftover) = inspection.advance(problem, &self.window, budget) else {
            return Some(Progress::Working);
        };
        let samples = self.record.given_up() + stage.samples as u64;
        let verdict = Verdict { problem, ends: &self.ends, leftover, window: stage.samples };
        match verdict.fit(samples, self.restarts, self.dense) {
            Ok(fit) => (self.accepted, self.phase) = (Some(fit), Phase::Accepted),
            Err(rejection) => return self.give_up(rejection),
        }
        None
    }

    /// Begins with the samples there are: nothing is left of what was done with others.
    fn collect(&mut self, dense: bool) {
        (self.dense, self.phase) = (dense, Phase::Collecting);
        (self.problem, self.trial, self.inspection) = (None, None, None);
        self.window.clear();
        self.waiting.clear();
        self.ends.clear();
    }

    /// Gives the try up: the denser starts come next, and after them a later window. Where the cost
    /// is that of noise, or samples are missing, other starts would find the same.
    fn give_up(&mut self, rejection: Rejection) -> Option<Progress> {
        let is_no_valley =
            matches!(rejection, Rejection::Leftover { .. } | Rejection::TooManyMissing { .. });
        if self.dense || self.choice != FitStarts::All || is_no_valley {
            self.move_on(rejection);
        } else {
            self.rejected = Some(rejection);
            self.collect(true);
        }
        None
    }

    /// Moves the window on. The twist is carried there by plain integration.
    fn move_on(&mut self, rejection: Rejection) {
        let start = self.start.unwrap_or_else(|| first_start(&self.config, 0.0));
        let bias_rad_s = self.config.start.bias_rad_s;
        let skipped = self.record.samples().get(..self.plan.restart).unwrap_or_default();
        let turned_rad = mean(skipped)
            .map_or(0.0, |rate| (rate - bias_rad_s) * self.period_s * skipped.len() as f64);
        self.record.give_up(self.plan.restart);
        let now = self.record.samples();
        let rate = mean(now.get(..self.plan.restart_rate).unwrap_or(now)).unwrap_or(bias_rad_s);
        self.start = Some(WindowStart {
            twist_rad: (
                start.twist_rad.0 + turned_rad,
                libm::hypot(start.twist_rad.1, RESTART_TWIST_SIGMA_RAD),
            ),
            rate_rad_s: (rate - bias_rad_s, RESTART_RATE_SIGMA_RAD_S),
        });
        self.restarts = self.restarts.saturating_add(1);
        self.rejected = Some(rejection);
        self.collect(false);
    }
}

/// Cost of a bottom that would not be kept beside these ends. In the last window rivals of the best
/// end decide whether it is taken: none is given up.
fn hopeless(ends: &[Descent], stage: &Stage) -> f64 {
    if stage.is_last {
        return f64::INFINITY;
    }
    let least = ends.iter().map(|end| end.best().cost()).fold(f64::INFINITY, f64::min);
    least + HOPELESS_CUTS * stage.cut.cost
}

/// Why nothing can be fitted, whatever is measured; none when it can.
fn refusal(config: &SwingConfig) -> Option<Rejection> {
    let (tilt_rad, tilt_sigma_rad) = (config.axis.tilt_rad(), config.axis.tilt_sigma_rad);
    let is_askew = tilt_rad > 0.0 && tilt_rad >= ASKEW_SIGMAS * tilt_sigma_rad;
    (!is_askew).then_some(Rejection::NotObservable { tilt_rad, tilt_sigma_rad })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::swing::fit::problem::tests::config;

    /// 20 s at 0.1 rad/s above the bias turn the body by 2 rad, and leave it known to 11° less.
    #[test]
    fn a_window_that_is_given_up_carries_the_twist_to_the_next_one() {
        let start = StartPrior { bias_rad_s: 0.01, ..StartPrior::released(6.0, 120.0) };
        let mut fit = SwingFit::new(&SwingConfig { start, ..config() }, 0.01).unwrap();
        for sigma_rad in
            [1, 2].map(|given_up: u8| libm::sqrt(f64::from(given_up)) * RESTART_TWIST_SIGMA_RAD)
        {
            (0..2_000 + 128).for_each(|_| fit.push(0.11));
            let before = fit.start.unwrap_or_else(|| first_start(&fit.config, 0.0));
            fit.move_on(Rejection::NoMotion);
            let WindowStart { twist_rad, rate_rad_s } = fit.start.unwrap();
            // Sums of two thousand numbers.
            assert!((twist_rad.0 - before.twist_rad.0 - 2.0).abs() < 1e-9, "{twist_rad:?}");
            assert!((rate_rad_s.0 - 0.1).abs() < 1e-12, "{rate_rad_s:?}");
            let sigma_rad = libm::hypot(start.angle_sigma_rad, sigma_rad);
            assert!((twist_rad.1 / sigma_rad - 1.0).abs() < 1e-12, "{twist_rad:?}");
        }
        assert_eq!((fit.restarts(), fit.record.given_up()), (2, 4_000));
    }
}
