//! The smoother of a whole record.

use super::backward::BackwardMap;
use super::forward::{Forward, Kick};
use super::record::{RateRecord, SmoothError};
use crate::augmented::{AugmentedFilter, Trace};
use crate::{AugmentedConfig, Belief, InnovationTest, LearntParameters, RateEstimator, Status};
use alloc::vec::Vec;

/// A record as it looks in hindsight: at each sample what all samples say, later ones too.
#[derive(Debug, Clone)]
pub struct Smoothed {
    model: AugmentedFilter,
    /// At the start, and after each sample.
    traces: Vec<Trace>,
    kicks: Vec<Kick>,
    status: Status,
}

/// Smooths a whole record: [`TestedFilter`](crate::TestedFilter) forward, then back from the end.
///
/// The way back takes the filter's steps as it took them in the end: with gated samples hardly
/// counted, and with the re-run past where an alarm sent it back to reckon with a kick. It
/// allocates 176 bytes for each sample.
///
/// # Errors
/// [`SmoothError`] when the model is unusable, or with the first sample that cannot be taken in.
pub fn smooth(
    config: &AugmentedConfig,
    test: &InnovationTest,
    record: &RateRecord<'_>,
) -> Result<Smoothed, SmoothError> {
    let Forward { model, mut traces, kicks, status } = Forward::over(config, test, record)?;
    smooth_back(&model, &mut traces);
    Ok(Smoothed { model, traces, kicks, status })
}

/// From filtered to smoothed, in place and from the end.
pub(super) fn smooth_back(model: &AugmentedFilter, traces: &mut [Trace]) {
    for k in (1..traces.len()).rev() {
        let (from, later) = (traces[k - 1], traces[k]);
        // What the later trace was before it was smoothed is of no account: the map needs its span
        // alone, and predicts for itself.
        let map = BackwardMap::between(model, &from, &later);
        traces[k - 1] = map.smoothed(&from, &later.mean(), &later.covariance());
    }
}

impl Smoothed {
    /// How many samples there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.traces.len() - 1
    }

    /// Whether there is none; there is always one.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The filter as it would stand after sample `k`, from 0, had it known the whole record:
    /// belief, learnt parameters, and all five states.
    #[must_use]
    pub fn at(&self, k: usize) -> Option<AugmentedFilter> {
        Some(self.model.standing_at(self.traces.get(k.checked_add(1)?)?))
    }

    /// The same for the start, before the first sample.
    #[must_use]
    pub fn at_start(&self) -> AugmentedFilter {
        self.model.standing_at(&self.traces[0])
    }

    /// Angle and rate at each sample.
    pub fn beliefs(&self) -> impl ExactSizeIterator<Item = Belief> {
        self.traces[1..].iter().map(|trace| self.model.standing_at(trace).belief())
    }

    /// Period, damping, and the bias at the end of the record.
    #[must_use]
    pub fn learnt(&self) -> LearntParameters {
        let last = self.traces.last().map(|trace| self.model.standing_at(trace));
        last.unwrap_or_else(|| self.at_start()).learnt()
    }

    /// What raised an alarm, in the order in which it did. Sizes are those seen at the alarm,
    /// without a sigma.
    #[must_use]
    pub fn kicks(&self) -> &[Kick] {
        &self.kicks
    }

    /// [`Status::ModelDoubtful`] if the filter ever was, else its status at the end.
    #[must_use]
    pub fn status(&self) -> Status {
        self.status
    }
}
