//! Simulated time: whole nanoseconds, and grids of evenly spaced instants.

use std::fmt;

const NS_PER_S: f64 = 1e9;
/// A grid repeats exactly after this long, so rates are resolved to 1 mHz.
const GRID_INTERVAL_NS: u64 = 1_000_000_000_000;
const GRID_INTERVAL_S: f64 = 1e3;

/// A point in simulated time, in whole nanoseconds since the start of the run.
///
/// An integer, because summing 1 ms steps in `f64` drifts and two paths to the same instant would
/// no longer compare equal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct SimTime(i64);

/// Why a number cannot be a time or a rate.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TimeError {
    /// Not finite, or outside the ±292 years that fit in 64 bits of nanoseconds.
    #[error("{seconds} s is not a time: it must be finite and within ±9.2e9 s")]
    OutOfRange {
        /** The rejected value. */
        seconds: f64,
    },
    /// Not a usable sample rate.
    #[error("{rate_hz} Hz is not a sample rate: it must lie in 0.001 to 1e9 Hz")]
    BadRate {
        /** The rejected value. */
        rate_hz: f64,
    },
}

impl SimTime {
    /// The start of the run.
    pub const ZERO: Self = Self(0);

    /// The instant `ns` nanoseconds after the start.
    #[must_use]
    pub const fn from_ns(ns: i64) -> Self {
        Self(ns)
    }

    /// Nanoseconds since the start.
    #[must_use]
    pub const fn as_ns(self) -> i64 {
        self.0
    }

    /// The instant nearest to `seconds` after the start.
    ///
    /// # Errors
    /// [`TimeError::OutOfRange`] when `seconds` is not finite or does not fit.
    pub fn from_s(seconds: f64) -> Result<Self, TimeError> {
        let ns = (seconds * NS_PER_S).round();
        if ns.is_finite() && ns.abs() < 9.2e18 {
            #[expect(clippy::cast_possible_truncation, reason = "range checked just above")]
            return Ok(Self(ns as i64));
        }
        Err(TimeError::OutOfRange { seconds })
    }

    /// Seconds since the start.
    #[must_use]
    pub fn as_s(self) -> f64 {
        // Exact to 2^53 ns (104 days); beyond that to the nearest representable second fraction.
        self.0 as f64 / NS_PER_S
    }

    /// Seconds from `earlier` to `self`; negative when `earlier` is later.
    #[must_use]
    pub fn seconds_since(self, earlier: Self) -> f64 {
        // Sums of 128 bits are functions, and this is asked for in every step of everything.
        let span_ns = match self.0.checked_sub(earlier.0) {
            Some(span_ns) => span_ns as f64,
            None => (i128::from(self.0) - i128::from(earlier.0)) as f64,
        };
        span_ns / NS_PER_S
    }
}

impl fmt::Display for SimTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} s", self.as_s())
    }
}

/// Evenly spaced instants `origin + k/rate`, computed from the integer `k`.
///
/// 300 Hz has no whole number of nanoseconds per period; each instant is rounded by itself, so the
/// grid never drifts however long it runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SampleGrid {
    origin: SimTime,
    samples_per_interval: i64,
}

impl SampleGrid {
    /// A grid starting at `origin` with `rate_hz` instants per second, resolved to 1 mHz.
    ///
    /// # Errors
    /// [`TimeError::BadRate`] outside 0.001 Hz to 1 GHz.
    pub fn new(origin: SimTime, rate_hz: f64) -> Result<Self, TimeError> {
        let samples = (rate_hz * GRID_INTERVAL_S).round();
        if !(1.0..=1e12).contains(&samples) {
            return Err(TimeError::BadRate { rate_hz });
        }
        #[expect(clippy::cast_possible_truncation, reason = "range checked just above")]
        Ok(Self { origin, samples_per_interval: samples as i64 })
    }

    /// The `k`-th instant, rounded to the nanosecond; saturates at the end of time.
    #[must_use]
    pub fn time_of(&self, k: u64) -> SimTime {
        self.time_in_64_bits(k).unwrap_or_else(|| self.time_in_128_bits(k))
    }

    /// Whole intervals and the rest by themselves: the same number, wherever it can be formed.
    #[inline]
    fn time_in_64_bits(&self, k: u64) -> Option<SimTime> {
        let n = self.samples_per_interval.cast_unsigned();
        let rest_ns = ((k % n).checked_mul(GRID_INTERVAL_NS)?.checked_add(n / 2)?) / n;
        let offset_ns = (k / n).checked_mul(GRID_INTERVAL_NS)?.checked_add(rest_ns)?;
        Some(SimTime(self.origin.0.checked_add_unsigned(offset_ns)?))
    }

    #[cold]
    fn time_in_128_bits(&self, k: u64) -> SimTime {
        let n = i128::from(self.samples_per_interval);
        let offset_ns = (i128::from(k) * i128::from(GRID_INTERVAL_NS) + n / 2) / n;
        let ns = i128::from(self.origin.0).saturating_add(offset_ns);
        SimTime(i64::try_from(ns).unwrap_or(i64::MAX))
    }

    /// The rate, Hz.
    #[must_use]
    pub fn rate_hz(&self) -> f64 {
        self.samples_per_interval as f64 / GRID_INTERVAL_S
    }

    /// The spacing of the instants, s.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        GRID_INTERVAL_S / self.samples_per_interval as f64
    }

    /// How many instants after the origin lie at or before `end`.
    #[must_use]
    pub fn periods_until(&self, end: SimTime) -> u64 {
        let span_ns = i128::from(end.0) - i128::from(self.origin.0);
        // Half a nanosecond of slack, because `time_of` rounds each instant.
        let n = i128::from(self.samples_per_interval);
        let k = (span_ns * n + n / 2) / i128::from(GRID_INTERVAL_NS);
        u64::try_from(k).unwrap_or(0)
    }
}

/// A grid that is asked for one instant after the other.
///
/// It gives the very instants of [`SampleGrid::time_of`], in whatever order they are asked for.
/// Those a few places ahead of the last one cost an addition each, where the grid itself divides
/// twice.
#[derive(Debug, Clone, Copy)]
pub struct GridWalk {
    grid: SampleGrid,
    at: u64,
    /// Quotient and remainder of the place's rounded offset; the greatest number for a quotient
    /// that does not fit.
    offset_ns: u64,
    rest: u64,
    /// The same of one period.
    period_ns: u64,
    period_rest: u64,
    now: SimTime,
}

/// Places that are walked; those farther away are jumped to.
const WALK_MAX: u64 = 8;

impl GridWalk {
    /// A walk that begins at the origin of `grid`.
    #[must_use]
    pub const fn new(grid: SampleGrid) -> Self {
        let n = grid.samples_per_interval.cast_unsigned();
        let (period_ns, period_rest) = (GRID_INTERVAL_NS / n, GRID_INTERVAL_NS % n);
        let (at, offset_ns, rest, now) = (0, 0, n / 2, grid.origin);
        Self { grid, at, offset_ns, rest, period_ns, period_rest, now }
    }

    /// The grid.
    #[must_use]
    pub const fn grid(&self) -> SampleGrid {
        self.grid
    }

    /// The `k`-th instant of the grid.
    #[inline]
    #[must_use]
    pub fn time_of(&mut self, k: u64) -> SimTime {
        match k.checked_sub(self.at) {
            Some(0) => {}
            Some(1..=WALK_MAX) => {
                while self.at < k {
                    self.step();
                }
            }
            _ => self.jump(k),
        }
        self.now
    }

    #[inline]
    fn step(&mut self) {
        let n = self.grid.samples_per_interval.cast_unsigned();
        let rest = self.rest + self.period_rest;
        let (carry, rest) = if rest >= n { (1, rest - n) } else { (0, rest) };
        match self.offset_ns.checked_add(self.period_ns + carry) {
            Some(offset_ns) => {
                (self.at, self.offset_ns, self.rest) = (self.at + 1, offset_ns, rest);
                self.now = SimTime(self.grid.origin.0.saturating_add_unsigned(offset_ns));
            }
            None => self.jump(self.at + 1),
        }
    }

    #[cold]
    fn jump(&mut self, k: u64) {
        let n = u128::from(self.grid.samples_per_interval.cast_unsigned());
        let exact = u128::from(k) * u128::from(GRID_INTERVAL_NS) + n / 2;
        self.at = k;
        self.offset_ns = u64::try_from(exact / n).unwrap_or(u64::MAX);
        self.rest =
            u64::try_from(exact % n).expect("a remainder is less than a divisor of 64 bits");
        self.now = self.grid.time_of(k);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_300_hz_grid_meets_every_whole_second_exactly() {
        let grid = SampleGrid::new(SimTime::ZERO, 300.0).unwrap();
        for second in [1_i64, 2, 480, 86_400] {
            let k = u64::try_from(second).unwrap() * 300;
            assert_eq!(grid.time_of(k), SimTime::from_ns(second * 1_000_000_000));
        }
    }

    #[test]
    fn a_rate_that_is_no_rate_is_refused() {
        for rate_hz in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9, 1e13] {
            assert!(SampleGrid::new(SimTime::ZERO, rate_hz).is_err(), "{rate_hz}");
        }
        for seconds in [f64::NAN, f64::INFINITY, -1e12] {
            assert!(SimTime::from_s(seconds).is_err(), "{seconds}");
        }
    }

    proptest! {
        #[test]
        fn an_instant_is_the_same_in_64_bits_and_in_128(
            rate_mhz in 1_u64..1_000_000_000_000,
            coarse in 1_u32..20_000_000,
            k in any::<u64>(),
            few in 0_u64..10_000_000_000,
            origin_ns in any::<i64>(),
        ) {
            let origin = SimTime::from_ns(origin_ns);
            for rate_hz in [rate_mhz as f64 / 1e3, f64::from(coarse) / 1e3] {
                let grid = SampleGrid::new(origin, rate_hz).unwrap();
                for k in [k, few] {
                    let quick = grid.time_in_64_bits(k);
                    prop_assert!(quick.is_none_or(|quick| quick == grid.time_in_128_bits(k)));
                }
            }
            // The usual ones take the quick way.
            let grid = SampleGrid::new(SimTime::ZERO, f64::from(coarse) / 1e3).unwrap();
            prop_assert!(coarse > 18_000_000 || grid.time_in_64_bits(few).is_some());
        }

        #[test]
        fn a_walk_meets_the_instants_of_the_grid(
            rate_mhz in prop_oneof![1_u64..2_000_000, 1_u64..=1_000_000_000_000],
            origin_ns in prop_oneof![Just(0), any::<i64>()],
            start in prop_oneof![0_u64..1_000_000, any::<u64>()],
            steps in proptest::collection::vec(prop_oneof![Just(1), 0_u64..20], 1..200),
            back in 0_u64..5,
        ) {
            let origin = SimTime::from_ns(origin_ns);
            let grid = SampleGrid::new(origin, rate_mhz as f64 / 1e3).unwrap();
            let mut walk = GridWalk::new(grid);
            prop_assert_eq!(walk.time_of(0), origin);
            let mut k = start;
            for step in steps {
                prop_assert_eq!(walk.time_of(k), grid.time_of(k));
                let behind = k.saturating_sub(if step == 3 { back } else { 0 });
                prop_assert_eq!(walk.time_of(behind), grid.time_of(behind));
                k = k.saturating_add(step);
            }
        }

        #[test]
        fn counting_periods_inverts_the_grid(
            rate_mhz in 1_u32..2_000_000_000,
            k in 0_u64..10_000_000,
        ) {
            let grid = SampleGrid::new(SimTime::ZERO, f64::from(rate_mhz) / 1e3).unwrap();
            // Above 500 MHz neighbouring instants may round to the same nanosecond.
            prop_assume!(rate_mhz < 500_000_000);
            prop_assert_eq!(grid.periods_until(grid.time_of(k)), k);
        }

        #[test]
        fn seconds_survive_the_round_trip(ns in -1_000_000_000_000_000_i64..1_000_000_000_000_000) {
            let time = SimTime::from_ns(ns);
            prop_assert_eq!(SimTime::from_s(time.as_s()).unwrap(), time);
        }
    }
}
