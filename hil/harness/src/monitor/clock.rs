//! When samples come: against their counter, and how many in a second.

use std::collections::VecDeque;
use struna_kernel::SimTime;

const NS_PER_S: i64 = 1_000_000_000;
/// Least arrivals are kept for cells of a quarter of a second.
const CELL_NS: i64 = NS_PER_S / 4;
/// The present: the last second.
const PRESENT_CELLS: i64 = 4;
/// And the eleven seconds before it.
const CELLS: i64 = 48;
/// The same as a length.
const CELLS_KEPT: usize = 48;

/// Compares the least delay of the last second with the least of the eleven before.
///
/// A frame never comes early, so the least of arrival − k·T over some time is free of queues,
/// bridges and schedulers: the lower hull of the arrivals. A constant delay cancels.
#[derive(Debug, Clone)]
pub(super) struct ClockWatch {
    period_ns: f64,
    cells: [Option<(i64, f64)>; CELLS_KEPT],
    /// The present cell and the least of what lies before the present.
    now: i64,
    before_ns: Option<f64>,
    since: Option<i64>,
}

impl ClockWatch {
    pub(super) fn new(period_s: f64) -> Self {
        let period_ns = period_s * NS_PER_S as f64;
        Self { period_ns, cells: [None; CELLS_KEPT], now: i64::MIN, before_ns: None, since: None }
    }

    /// Forgets everything: the count is no longer known.
    pub(super) fn reset(&mut self) {
        *self = Self::new(self.period_ns / NS_PER_S as f64);
    }

    /// Takes sample `index`, come at `arrival`; returns how far the least delay has moved, s, once
    /// there are two seconds to compare.
    pub(super) fn arrive(&mut self, index: u64, arrival: SimTime) -> Option<f64> {
        let delay_ns = arrival.as_ns() as f64 - index as f64 * self.period_ns;
        let cell = arrival.as_ns().div_euclid(CELL_NS);
        self.since = self.since.or(Some(cell));
        if cell != self.now {
            self.now = cell;
            self.before_ns = self.least(cell - CELLS + 1, cell - PRESENT_CELLS);
        }
        match &mut self.cells[place(cell)] {
            Some((found, least)) if *found == cell => *least = least.min(delay_ns),
            slot => *slot = Some((cell, delay_ns)),
        }
        // Both sides need a whole second, or a lucky start is compared with an unlucky second.
        if self.since.is_none_or(|since| cell < since + 2 * PRESENT_CELLS) {
            return None;
        }
        let present_ns = self.least(cell - PRESENT_CELLS + 1, cell)?;
        Some((present_ns - self.before_ns?) / NS_PER_S as f64)
    }

    fn least(&self, from: i64, to: i64) -> Option<f64> {
        let cells = (from..=to).filter_map(|cell| {
            self.cells[place(cell)].filter(|(found, _)| *found == cell).map(|(_, least)| least)
        });
        cells.reduce(f64::min)
    }
}

fn place(cell: i64) -> usize {
    usize::try_from(cell.rem_euclid(CELLS)).unwrap_or(0)
}

/// Counts the frames of the last second.
#[derive(Debug, Clone)]
pub(super) struct RateWatch {
    expected: f64,
    /// Instants with frames, and how many; as many as there can be at twice the rate.
    arrivals: VecDeque<(i64, u32)>,
    frames: u32,
    since: Option<i64>,
}

impl RateWatch {
    pub(super) fn new(sample_rate_hz: f64) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a declared rate is positive and at most 1e5 Hz"
        )]
        let most = (2.0 * sample_rate_hz) as usize + 16;
        let arrivals = VecDeque::with_capacity(most);
        Self { expected: sample_rate_hz, arrivals, frames: 0, since: None }
    }

    /// Takes a frame.
    pub(super) fn arrive(&mut self, time: SimTime) {
        let ns = time.as_ns();
        self.since = self.since.or(Some(ns));
        match self.arrivals.back_mut() {
            Some((last, frames)) if *last == ns => *frames += 1,
            _ => {
                if self.arrivals.len() == self.arrivals.capacity() {
                    self.drop_oldest();
                }
                self.arrivals.push_back((ns, 1));
            }
        }
        self.frames += 1;
    }

    /// Frames of the last second beside those expected, once it is whole.
    pub(super) fn judge(&mut self, time: SimTime) -> Option<(f64, f64)> {
        let from = time.as_ns().saturating_sub(NS_PER_S);
        while self.arrivals.front().is_some_and(|(ns, _)| *ns <= from) {
            self.drop_oldest();
        }
        let whole = self.since.is_some_and(|since| since <= from);
        whole.then(|| (f64::from(self.frames), self.expected))
    }

    fn drop_oldest(&mut self) {
        if let Some((_, frames)) = self.arrivals.pop_front() {
            self.frames -= frames;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How far the clock is said to have moved at each of 100 samples a second that come late by
    /// `late_ms` of their second.
    fn moved_s(late_ms: impl Fn(u64) -> i64, samples: u64) -> Vec<f64> {
        let mut watch = ClockWatch::new(0.01);
        let arrive = |k: u64| {
            let due_ms = i64::try_from(k * 10).expect("small");
            watch.arrive(k, SimTime::from_ns((due_ms + late_ms(k)) * 1_000_000))
        };
        (0..samples).filter_map(arrive).collect()
    }

    #[test]
    fn queues_that_come_and_go_do_not_move_the_clock() {
        let moved = moved_s(|k| i64::try_from(k % 7).expect("small") * 3, 3000);
        assert!(moved.len() > 2700);
        assert!(moved.iter().all(|moved| moved.abs() < 1e-9));
    }

    #[test]
    fn a_delay_shows_after_a_second_and_is_the_norm_after_twelve() {
        let moved = moved_s(|k| if k >= 1500 { 30 } else { 0 }, 3000);
        let first = moved.iter().position(|moved| moved.abs() > 1e-9).expect("it shows");
        let count = moved.iter().filter(|moved| (**moved - 0.03).abs() < 1e-9).count();
        // The first 200 samples make no comparison. Cells are quarters of a second: the present is
        // all late when three have passed, which the delay itself brings nearer by three samples.
        assert_eq!(first + 200, 1500 + 75 - 3);
        assert!((1075..=1125).contains(&count), "{count}");
    }

    #[test]
    fn a_second_without_a_tenth_of_its_frames_counts_as_that() {
        let mut watch = RateWatch::new(100.0);
        let mut judged = Vec::new();
        for k in 0..400_i64 {
            let time = SimTime::from_ns(k * 10_000_000);
            if !(200..210).contains(&k) {
                watch.arrive(time);
                judged.push(watch.judge(time));
            }
        }
        assert_eq!(judged[50], None);
        assert_eq!(judged[150], Some((100.0, 100.0)));
        assert_eq!(judged[205], Some((90.0, 100.0)));
        assert_eq!(judged[380], Some((100.0, 100.0)));
    }
}
