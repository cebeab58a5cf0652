//! Wall time, in bursts that take turns.

#![expect(clippy::disallowed_methods, reason = "a bench measures wall time")]

use anyhow::Result;
use std::time::Instant;

/// Does some work and tells how long one unit of it took, s.
pub(crate) type Burst<'a> = Box<dyn FnMut() -> Result<f64> + 'a>;

/// Wall time of `units` units of `work` per unit, s.
pub(crate) fn time_per_unit(units: usize, work: impl FnOnce() -> Result<()>) -> Result<f64> {
    let start = Instant::now();
    work()?;
    Ok(start.elapsed().as_secs_f64() / units as f64)
}

/// How long the sides go on taking turns, s. Whatever else the machine does comes and goes in
/// seconds, and a few quiet milliseconds among them are enough.
const CONTEST_S: f64 = 5.0;

/// Turns at least: a burst of half a second needs as many to fall into a quiet one.
const TURNS_MIN: u32 = 25;

/// The best burst of each side, s per unit. The sides take turns.
pub(crate) fn best_in_turns<const N: usize>(mut sides: [Burst<'_>; N]) -> Result<[f64; N]> {
    let mut best = [f64::INFINITY; N];
    let start = Instant::now();
    let mut turns = 0;
    while turns < TURNS_MIN || start.elapsed().as_secs_f64() < CONTEST_S {
        for (best, side) in best.iter_mut().zip(&mut sides) {
            *best = best.min(side()?);
        }
        turns += 1;
    }
    Ok(best)
}
