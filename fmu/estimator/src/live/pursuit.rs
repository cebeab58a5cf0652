//! From the first sign of a swing to a filter that follows it: fit, and catching up.

use super::eye::missed;
use super::tape::{Sample, Tape};
use crate::state_bytes::{Reader, RestoreError, Writer};
use crate::swing::{AcceptedFit, FitOutcome, SwingConfig, SwingFilter, SwingFit};
use crate::{ConfigError, EstimatorError, RateEstimator, StartPrior};
use alloc::boxed::Box;
use core::ops::RangeInclusive;

/// Last window of a fit: at least a minute and a quarter of the torsion's period, s.
const WINDOW_MIN_S: f64 = 60.0;
const PERIOD_SHARE: f64 = 0.25;
const WINDOW_MAX_S: f64 = 960.0;
/// Steps of the fit that an update of the filter is worth.
const UPDATE_STEPS: u32 = 10;
/// What the fit moves on by when it gives a window up, s.
const RESTART_S: f64 = 20.0;
/// How much longer than declared the torsion's period may turn out for a fit to have memory.
const PERIOD_FACTOR_MAX: f64 = 4.0;

/// Seconds that the last window of a fit holds.
pub(super) fn window_s(period_s: f64) -> f64 {
    (PERIOD_SHARE * period_s).clamp(WINDOW_MIN_S, WINDOW_MAX_S)
}

/// A fit under way, and after it the filter that catches up with the present. Allocated once: one
/// swing after the other is pursued in the same memory.
///
/// Work is dealt out per sample, never by the clock, so that the same record gives the same
/// estimate on any machine. It also makes the fit a function of the tape: saved bytes hold where
/// it began, and it is done again when they are restored.
#[derive(Debug, Clone)]
pub(super) struct Pursuit {
    prior: StartPrior,
    period_s: f64,
    work: u32,
    fit: SwingFit,
    /// Samples of the tape that the fit was given: the first one, and the last one before the
    /// work began.
    first: u64,
    begun: u64,
    /// Samples that the fit was given, missing ones included.
    given: u64,
    chase: Option<Chase>,
}

/// A filter on its way to the present.
#[derive(Debug, Clone)]
struct Chase {
    filter: Box<SwingFilter>,
    /// Number of the next sample.
    next: u64,
    /// Time to it, s, when that is not the whole span to the sample before.
    lead_s: Option<f64>,
}

impl Chase {
    fn take(&mut self, sample: Sample) -> Result<(), EstimatorError> {
        self.filter.predict(self.lead_s.take().unwrap_or(sample.span_s))?;
        match sample.rate_rad_s {
            Some(rate_rad_s) => self.filter.update(rate_rad_s)?,
            // Its value tells nothing: any will do.
            None => self.filter.update_over_range(0.0)?,
        };
        self.next += 1;
        Ok(())
    }
}

/// What a sample has brought.
#[derive(Debug)]
pub(super) enum News {
    /// The fit goes on.
    None,
    /// The filter of the swinging body stands at the last sample.
    Caught(Box<SwingFilter>),
    /// This will not come to anything.
    Lost,
}

impl Pursuit {
    /// A pursuit that is yet to [begin](Self::begin), with memory for torsions up to four times
    /// as slow as declared, or just for the declared one where that is too much.
    pub(super) fn new(
        config: &SwingConfig,
        (period_s, work): (f64, u32),
    ) -> Result<Self, ConfigError> {
        let prior = config.start;
        let fit = SwingFit::with_room(config, period_s, PERIOD_FACTOR_MAX * prior.period_s)
            .or_else(|_| SwingFit::new(config, period_s))?;
        Ok(Self { prior, period_s, work, fit, first: 1, begun: 0, given: 0, chase: None })
    }

    /// Begins a fit of the samples from the first of `given` on, before which `prior` was
    /// believed. Those in `given` it is given at once.
    pub(super) fn begin(
        &mut self,
        prior: &StartPrior,
        (tape, given): (&Tape, RangeInclusive<u64>),
    ) -> Result<(), ConfigError> {
        self.fit.restart(prior)?;
        self.prior = *prior;
        (self.first, self.begun, self.given) = (*given.start(), *given.end(), 0);
        for number in given {
            if let Some(sample) = tape.get(number) {
                self.give(number, sample);
            }
        }
        Ok(())
    }

    /// Samples that `sample` stands for on the grid of the fit.
    fn places(&self, number: u64, sample: Sample) -> u64 {
        // What went missing before the first sample is not part of the record.
        if number == self.first { 1 } else { 1 + missed(sample.span_s, self.period_s) as u64 }
    }

    fn give(&mut self, number: u64, sample: Sample) {
        let places = self.places(number, sample);
        for _ in 1..places {
            self.fit.push(f64::NAN);
        }
        self.fit.push(sample.rate_rad_s.unwrap_or(f64::NAN));
        self.given += places;
    }

    /// Goes on by sample `now` of the tape, and one sample's worth of work. The filter that is to
    /// follow the swing is taken from `spare`.
    pub(super) fn go_on(
        &mut self,
        tape: &Tape,
        now: u64,
        spare: &mut Option<Box<SwingFilter>>,
    ) -> News {
        if self.chase.is_none() {
            if let Some(sample) = tape.get(now) {
                self.give(now, sample);
            }
            self.fit.work(self.work as usize);
            match self.fit.outcome() {
                FitOutcome::Accepted(fit) => {
                    let (next, lead_s) = self.end_of(fit, tape, now);
                    let started = spare.as_mut().map(|filter| filter.restart(&fit.belief));
                    let (Some(Ok(())), Some(filter)) = (started, spare.take()) else {
                        return News::Lost;
                    };
                    self.chase = Some(Chase { filter, next, lead_s });
                }
                FitOutcome::Refused(_) => return News::Lost,
                FitOutcome::Pending { .. } => {}
            }
        }
        self.catch_up(tape, now)
    }

    /// Number of the first sample behind the fit's window, and the time to it unless that is the
    /// whole span to the sample before: a window may end within a gap.
    fn end_of(&self, fit: &AcceptedFit, tape: &Tape, now: u64) -> (u64, Option<f64>) {
        let mut passed = 0;
        for number in self.first..=now {
            let Some(sample) = tape.get(number) else { continue };
            let places = self.places(number, sample);
            passed += places;
            if passed > fit.samples {
                let ahead = passed - fit.samples;
                return (number, (ahead < places).then_some(ahead as f64 * self.period_s));
            }
        }
        (now + 1, None)
    }

    fn catch_up(&mut self, tape: &Tape, now: u64) -> News {
        let Some(chase) = &mut self.chase else { return News::None };
        // At least two, or it would never arrive.
        for _ in 0..(self.work / UPDATE_STEPS).max(2) {
            if chase.next > now {
                break;
            }
            let taken = tape.get(chase.next).map(|sample| chase.take(sample));
            if !matches!(taken, Some(Ok(()))) {
                return News::Lost;
            }
        }
        if chase.next <= now {
            return News::None;
        }
        self.chase.take().map_or(News::None, |chase| News::Caught(chase.filter))
    }

    /// Gives back the filter that was to follow.
    pub(super) fn give_back(&mut self) -> Option<Box<SwingFilter>> {
        self.chase.take().map(|chase| chase.filter)
    }

    /// Seconds of the window at hand that have been collected, and that it takes.
    pub(super) fn progress_s(&self) -> (f64, f64) {
        let given_s = self.given as f64 * self.period_s;
        let collected_s = given_s - RESTART_S * f64::from(self.fit.restarts());
        let needed_s = window_s(self.prior.period_s);
        (collected_s.clamp(0.0, needed_s), needed_s)
    }

    /// Whether the tape soon no longer holds all that the fit was given.
    pub(super) fn outgrows(&self, tape: &Tape) -> bool {
        tape.oldest() + 1 >= self.first && tape.oldest() > 1
    }

    pub(super) const SAVED_LEN: usize = 2 * 8 + PRIOR * 8;

    pub(super) fn write(&self, out: &mut Writer<'_>) {
        out.u64(self.first);
        out.u64(self.begun);
        prior_numbers(&self.prior).iter().for_each(|number| out.f64(*number));
    }
}

/// Where a saved pursuit began.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Beginning {
    first: u64,
    begun: u64,
    prior: StartPrior,
}

impl Beginning {
    pub(super) fn read(bytes: &mut Reader<'_>) -> Result<Self, RestoreError> {
        let (first, begun) = (bytes.u64(), bytes.u64());
        let mut numbers = [0.0; PRIOR];
        for number in &mut numbers {
            *number = bytes.finite("prior of a fit")?;
        }
        Ok(Self { first, begun, prior: prior_of(numbers) })
    }

    /// Brings `pursuit` as far as the one that began so had come at the end of the tape.
    pub(super) fn again(
        &self,
        pursuit: &mut Pursuit,
        tape: &Tape,
        spare: &mut Option<Box<SwingFilter>>,
    ) -> Result<(), RestoreError> {
        let possible = self.first >= tape.oldest() && self.begun <= tape.last();
        if !possible || self.first > self.begun + 1 {
            return Err(RestoreError::Impossible);
        }
        let given = (tape, self.first..=self.begun);
        pursuit.begin(&self.prior, given).map_err(|_| RestoreError::Impossible)?;
        for now in self.begun + 1..=tape.last() {
            // A saved pursuit was still one at the last sample.
            if !matches!(pursuit.go_on(tape, now, spare), News::None) {
                return Err(RestoreError::Impossible);
            }
        }
        Ok(())
    }
}

const PRIOR: usize = 10;

fn prior_numbers(prior: &StartPrior) -> [f64; PRIOR] {
    [
        prior.angle_rad,
        prior.angle_sigma_rad,
        prior.rate_rad_s,
        prior.rate_sigma_rad_s,
        prior.period_s,
        prior.period_sigma_s,
        prior.damping_ratio,
        prior.damping_ratio_sigma,
        prior.bias_rad_s,
        prior.bias_sigma_rad_s,
    ]
}

fn prior_of(numbers: [f64; PRIOR]) -> StartPrior {
    let [
        angle,
        angle_sigma,
        rate,
        rate_sigma,
        period,
        period_sigma,
        ratio,
        ratio_sigma,
        bias,
        last,
    ] = numbers;
    StartPrior {
        angle_rad: angle,
        angle_sigma_rad: angle_sigma,
        rate_rad_s: rate,
        rate_sigma_rad_s: rate_sigma,
        period_s: period,
        period_sigma_s: period_sigma,
        damping_ratio: ratio,
        damping_ratio_sigma: ratio_sigma,
        bias_rad_s: bias,
        bias_sigma_rad_s: last,
    }
}
