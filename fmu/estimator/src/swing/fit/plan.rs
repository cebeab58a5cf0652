//! Windows, cuts and limits of a fit, as counts of samples.

use super::levenberg::Patience;
use super::modes::Cut;
use super::problem::DEG;
use super::starts::Hypotheses;

/// Lengths of the windows, s; later ones double.
const WINDOWS_S: [f64; 4] = [8.0, 16.0, 30.0, 60.0];
/// First window of the dense retry, s.
const DENSE_WINDOW_S: f64 = 4.0;
/// Least share of the torsion's period in the last window: the body must have turned by about a
/// quarter of a turn for the hidden component of the swing to show.
const PERIOD_SHARE: f64 = 0.25;
/// Longest window, s.
const WINDOW_MAX_S: f64 = 960.0;
/// What is kept of a window: nearly everything distinct of the first ones, then less and less. In
/// the first one few have come to the bottom of their valley.
const CUTS: [Cut; 4] = [
    Cut { cost: 2000.0, count: 25 },
    Cut { cost: 400.0, count: 25 },
    Cut { cost: 400.0, count: 10 },
    Cut { cost: 60.0, count: 4 },
];
/// Fall of the cost that ends a descent, in all windows but the last and in the last, and steps.
const FALL: (f64, f64) = (1.0, 0.001);
const STEPS: u32 = 20;
/// Largest phase of the swing in one averaged sample, rad. The average is then 0.2 % less than the
/// rate at its middle, and a step of the model that long errs by 1e-5 of the phase: enough to tell
/// valleys apart.
const AVERAGED_RAD: f64 = 0.2;
/// How long the fit may lag behind the samples, s.
const LAG_S: f64 = 120.0;

/// A window is moved on by this when its fit is given up, s.
pub(super) const RESTART_S: f64 = 20.0;
/// What the twist wanders per restart at least: coning that plain integration does not see, rad.
pub(super) const RESTART_TWIST_SIGMA_RAD: f64 = 11.0 * DEG;
/// Length of the mean that is the rate at a restart, s, and its spread, rad/s.
pub(super) const RESTART_RATE_S: f64 = 1.28;
pub(super) const RESTART_RATE_SIGMA_RAD_S: f64 = 3.0 * DEG;
/// Length of the record in which the visible component is sought, s.
pub(super) const LEAK_S: f64 = 4.0;
/// Least spread of the swing, rad.
pub(super) const SWING_SIGMA_MIN_RAD: f64 = 0.1 * DEG;
/// What the spread is raised by for the dense retry.
pub(super) const DENSE_SWING: f64 = 1.5;

/// How many times the cut above the best end a descent must promise to stay to be given up on its
/// way: what it promises holds for a bowl, and a valley bends.
pub(super) const HOPELESS_CUTS: f64 = 4.0;
/// Largest cost per sample of a fit that is taken.
pub(super) const COST_MAX: f64 = 1.12;
/// Cost per sample of the best end of a window beyond which longer windows cannot mend it.
pub(super) const COST_HOPELESS: f64 = 2.0;
/// Largest mean of what is left, and excess of its mean square, standard deviations.
pub(super) const LEFTOVER_MEAN_MAX: f64 = 5.2;
pub(super) const LEFTOVER_SQUARE_MAX: f64 = 5.0;
/// Costs closer than this do not decide between two motions.
pub(super) const COST_UNDECIDED: f64 = 25.0;
/// Twists further apart than this are different, standard deviations.
pub(super) const TWIST_APART: f64 = 3.0;

/// Starts of a fit at most.
pub(super) const STARTS_MAX: usize = Hypotheses::DENSE.count();
/// Windows of a fit at most: the dense retry's, three short ones, those that double from 60 s to
/// 480 s, and the longest one twice.
const STAGES_MAX: usize = 10;

/// One window of a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stage {
    /// Samples of the record that the window takes.
    pub(super) samples: usize,
    /// How many of them are averaged into one.
    pub(super) averaged: usize,
    pub(super) cut: Cut,
    pub(super) patience: Patience,
    pub(super) is_last: bool,
}

/// The windows of a fit, the dense retry's first one in front.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plan {
    stages: [Option<Stage>; STAGES_MAX],
    /// Samples of the longest window.
    pub(super) longest: usize,
    pub(super) leak: usize,
    pub(super) restart: usize,
    pub(super) restart_rate: usize,
    pub(super) capacity: usize,
}

impl Plan {
    /// The plan for a torsion of `torsion_s` and a swing of `swing_rad_s`, sampled every
    /// `period_s`.
    ///
    /// All windows are walked over with samples averaged, as far as the swing allows; the longest
    /// one is then walked over once more with every sample.
    pub(super) fn new(torsion_s: f64, swing_rad_s: f64, period_s: f64) -> Self {
        let averaged = count(libm::floor(AVERAGED_RAD / (swing_rad_s * period_s)));
        let samples = |seconds: f64| count(seconds / period_s);
        let stage = |seconds: f64, cut: Cut, is_last| Stage {
            samples: samples(seconds) / averaged * averaged,
            averaged: if is_last { 1 } else { averaged },
            cut,
            patience: Patience { fall: if is_last { FALL.1 } else { FALL.0 }, steps: STEPS },
            is_last,
        };
        let last_s = (PERIOD_SHARE * torsion_s).clamp(WINDOWS_S[3], WINDOW_MAX_S);
        let dense = stage(DENSE_WINDOW_S, Cut { count: STARTS_MAX, ..CUTS[0] }, false);
        let short = WINDOWS_S.into_iter().zip(CUTS).take(3);
        let short = short.map(|(seconds, cut)| stage(seconds, cut, false));
        let doubling = core::iter::successors(Some(WINDOWS_S[3]), |seconds| Some(2.0 * seconds));
        let doubling = doubling.take_while(|seconds| *seconds < last_s);
        let averaging = (averaged > 1).then_some(last_s);
        let long = doubling.chain(averaging).map(|seconds| stage(seconds, CUTS[3], false));
        let last = stage(last_s, CUTS[3], true);
        let mut all = core::iter::once(dense).chain(short).chain(long).chain([last]);
        Self {
            stages: core::array::from_fn(|_| all.next()),
            longest: last.samples,
            leak: samples(LEAK_S),
            restart: samples(RESTART_S),
            restart_rate: samples(RESTART_RATE_S),
            capacity: samples(last_s + LAG_S),
        }
    }

    /// The windows, with or without the dense retry's first one.
    pub(super) fn stage(&self, index: usize, dense: bool) -> Option<&Stage> {
        self.stages.get(index + usize::from(!dense))?.as_ref()
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "at most 1080 s at a megahertz, and no less than one"
)]
fn count(samples: f64) -> usize {
    libm::round(samples).clamp(1.0, 2e9) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn windows_s(torsion_s: f64) -> Vec<f64> {
        let plan = Plan::new(torsion_s, 19.0, 0.01);
        (0..).map_while(|k| plan.stage(k, false)).map(|s| s.samples as f64 * 0.01).collect()
    }

    #[test]
    fn the_last_window_is_a_minute_or_a_quarter_of_the_period() {
        assert_eq!(windows_s(120.0), [8.0, 16.0, 30.0, 60.0]);
        assert_eq!(windows_s(480.0), [8.0, 16.0, 30.0, 60.0, 120.0]);
        assert_eq!(windows_s(600.0), [8.0, 16.0, 30.0, 60.0, 120.0, 150.0]);
        // Nor is one left out of those that take the most stages.
        assert_eq!(windows_s(1e12), [8.0, 16.0, 30.0, 60.0, 120.0, 240.0, 480.0, 960.0]);
        let averaged = Plan::new(1e12, 9.9, 0.01);
        let all: Vec<Stage> = (0..).map_while(|k| averaged.stage(k, true)).copied().collect();
        assert_eq!(all.len(), STAGES_MAX);
        assert!(all[STAGES_MAX - 1].is_last);
    }

    #[test]
    fn only_the_last_window_is_the_last() {
        let plan = Plan::new(480.0, 9.9, 0.01);
        let last: Vec<bool> = (0..).map_while(|k| plan.stage(k, true)).map(|s| s.is_last).collect();
        assert_eq!(last, [false, false, false, false, false, false, true]);
        assert_eq!(plan.stage(0, true).unwrap().samples, 400);
    }
}
