//! The samples that a fit works on.

use alloc::vec::Vec;

/// A record of fixed capacity whose front can be given up.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Record {
    samples: Vec<f64>,
    capacity: usize,
    /// Samples given up in front.
    given_up: u64,
}

impl Record {
    pub(super) fn new(capacity: usize) -> Self {
        Self { samples: Vec::with_capacity(capacity), capacity, given_up: 0 }
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
        self.samples.len() == self.capacity
    }

    /// Keeps a sample; whoever pushes makes room first.
    pub(super) fn push(&mut self, sample: f64) {
        debug_assert!(!self.is_full(), "room was made");
        self.samples.push(sample);
    }

    /// Gives up the oldest `count` samples and returns the sum of those that were there, and how
    /// many.
    pub(super) fn give_up(&mut self, count: usize) -> usize {
        let count = count.min(self.samples.len());
        self.samples.drain(..count);
        self.given_up += count as u64;
        count
    }
}

/// Means of `count` samples at a time; of those where one is missing, none.
pub(super) fn averages(samples: &[f64], count: usize) -> Vec<f64> {
    let share = 1.0 / count.max(1) as f64;
    samples.chunks_exact(count.max(1)).map(|few| few.iter().sum::<f64>() * share).collect()
}

/// Mean of the samples that are there; none when none are.
pub(super) fn mean(samples: &[f64]) -> Option<f64> {
    let there = || samples.iter().filter(|sample| sample.is_finite());
    let count = there().count();
    (count > 0).then(|| there().sum::<f64>() / count as f64)
}
