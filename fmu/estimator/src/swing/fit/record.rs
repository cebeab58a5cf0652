//! The samples that a fit works on.

use super::bounded::Bounded;

/// A record of fixed capacity whose front can be given up.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Record {
    samples: Bounded<f64>,
    capacity: usize,
    /// Samples given up in front.
    given_up: u64,
}

impl Record {
    /// An empty record with room for so many samples.
    pub(super) fn new(room: usize) -> Self {
        Self { samples: Bounded::new(room), capacity: room, given_up: 0 }
    }

    /// Starts afresh with a capacity that there is room for; false, and nothing done, when there
    /// is none.
    pub(super) fn restart(&mut self, capacity: usize) -> bool {
        let fits = capacity <= self.samples.room();
        if fits {
            self.samples.clear();
            (self.capacity, self.given_up) = (capacity, 0);
        }
        fits
    }

    /// What is kept, oldest first.
    pub(super) fn samples(&self) -> &[f64] {
        &self.samples
    }

    /// Samples ever pushed before the first one kept.
    pub(super) fn given_up(&self) -> u64 {
        self.given_up
    }

    pub(super) fn is_full(&self) -> bool {
        self.samples.len() >= self.capacity
    }

    /// Keeps a sample; whoever pushes makes room first.
    pub(super) fn push(&mut self, sample: f64) {
        let kept = self.samples.push(sample);
        debug_assert!(kept, "room was made");
    }

    /// Gives up the oldest `count` samples, or all there are.
    pub(super) fn give_up(&mut self, count: usize) {
        let count = count.min(self.samples.len());
        self.samples.give_up(count);
        self.given_up += count as u64;
    }
}

/// Means of `count` samples at a time; of those where one is missing, none.
pub(super) fn averages(samples: &[f64], count: usize) -> impl Iterator<Item = f64> {
    let share = 1.0 / count.max(1) as f64;
    samples.chunks_exact(count.max(1)).map(move |few| few.iter().sum::<f64>() * share)
}

/// Mean of the samples that are there; none when none are.
pub(super) fn mean(samples: &[f64]) -> Option<f64> {
    let there = || samples.iter().filter(|sample| sample.is_finite());
    let count = there().count();
    (count > 0).then(|| there().sum::<f64>() / count as f64)
}
