//! From decoded gyro samples to the averaged rate that estimators are given.

use struna_kernel::{GridWalk, RateSample, SampleGrid, SimTime};

/// Averages fixed groups of consecutive gyro samples.
///
/// Groups are fixed by sample index, not by arrival, so a lost frame thins its own group and leaves
/// all later ones alone. A group of which nothing arrived is skipped: the next sample then starts
/// later than the last one ended, and the estimator sees the gap as a gap.
///
/// Gyro sample `k` is the mean rate over the interval from grid instant `k` to `k + 1`.
#[derive(Debug, Clone)]
pub struct Averager {
    walk: GridWalk,
    groups: Groups,
}

/// The group under way, and where the last one ended.
#[derive(Debug, Clone)]
struct Groups {
    per_output: u64,
    half_period_s: f64,
    /// First sample of the group, and of the next.
    begin: u64,
    end: u64,
    sum_rad_s: f64,
    /// Sums of the two further rates, and whether a sample of the group has brought them. No
    /// `Option`: compilers divide before they ask whether there is anything to divide, and what
    /// stands in the place of nothing may be subnormal, which costs some hundred cycles.
    cross_sums_rad_s: [f64; 2],
    has_cross: bool,
    count: u64,
    over_range: bool,
    /// Index that the next gyro sample should have.
    expected: u64,
    lost: u64,
    /// End of the last average.
    closed: SimTime,
}

/// What one gyro sample says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Rate about the input axis, rad/s.
    pub rate_rad_s: f64,
    /// Rates about the x and y axes of the case, rad/s. Every sample of a line brings them or
    /// none does: an average divides by the number of all samples.
    pub cross_rates_rad_s: Option<[f64; 2]>,
    /// It is marked over range.
    pub over_range: bool,
}

/// Averaging over no sample at all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("averaging over 0 samples: at least 1 is needed")]
pub struct AveragerError;

impl Averager {
    /// Averages groups of `per_output` samples of a gyro that samples on `grid`.
    ///
    /// # Errors
    /// [`AveragerError`] when `per_output` is 0.
    pub fn new(grid: SampleGrid, per_output: u64) -> Result<Self, AveragerError> {
        if per_output == 0 {
            return Err(AveragerError);
        }
        let groups = Groups {
            per_output,
            half_period_s: 0.5 * grid.period_s(),
            begin: 0,
            end: per_output,
            sum_rad_s: 0.0,
            cross_sums_rad_s: [0.0; 2],
            has_cross: false,
            count: 0,
            over_range: false,
            expected: 0,
            lost: 0,
            closed: grid.time_of(0),
        };
        Ok(Self { walk: GridWalk::new(grid), groups })
    }

    /// Takes gyro sample `index`; hands out each average that it completes or leaves behind.
    ///
    /// Indices must increase; one that does not is ignored.
    pub fn add(
        &mut self,
        index: u64,
        rate_rad_s: f64,
        over_range: bool,
        sink: &mut impl FnMut(&RateSample),
    ) {
        self.add_measured(
            index,
            Measured { rate_rad_s, cross_rates_rad_s: None, over_range },
            sink,
        );
    }

    /// As [`Self::add`], with instants from `times` in place of the grid: those of a live gyro's
    /// own clock, which moves a little with all that is learned about it.
    ///
    /// An average starts exactly where the one before ended, unless more than half a nominal
    /// period lies between them; so a clock that moves makes neither small gaps nor overlaps.
    pub fn add_timed(
        &mut self,
        index: u64,
        rate_rad_s: f64,
        over_range: bool,
        times: &impl Fn(u64) -> SimTime,
        sink: &mut impl FnMut(&RateSample),
    ) {
        let measured = Measured { rate_rad_s, cross_rates_rad_s: None, over_range };
        self.groups.arrive(index, Some(measured), &mut |at| times(at), sink);
    }

    /// As [`Self::add`], of a sample that may hold the rates about the other two axes as well.
    pub fn add_measured(
        &mut self,
        index: u64,
        measured: Measured,
        sink: &mut impl FnMut(&RateSample),
    ) {
        let Self { walk, groups } = self;
        groups.arrive(index, Some(measured), &mut |at| walk.time_of(at), sink);
    }

    /// As [`Self::add_measured`], with instants from `times` as in [`Self::add_timed`].
    pub fn add_measured_timed(
        &mut self,
        index: u64,
        measured: Measured,
        times: &impl Fn(u64) -> SimTime,
        sink: &mut impl FnMut(&RateSample),
    ) {
        self.groups.arrive(index, Some(measured), &mut |at| times(at), sink);
    }

    /// Takes note of frame `index`, which carries no rate but another channel's value: its place
    /// in the group stays empty, and it is not lost.
    pub fn pass_over(&mut self, index: u64, sink: &mut impl FnMut(&RateSample)) {
        let Self { walk, groups } = self;
        groups.arrive(index, None, &mut |instant| walk.time_of(instant), sink);
    }

    /// As [`Self::pass_over`], with instants from `times` as in [`Self::add_timed`].
    pub fn pass_over_timed(
        &mut self,
        index: u64,
        times: &impl Fn(u64) -> SimTime,
        sink: &mut impl FnMut(&RateSample),
    ) {
        self.groups.arrive(index, None, &mut |at| times(at), sink);
    }
}

impl Groups {
    #[inline]
    fn arrive(
        &mut self,
        index: u64,
        measured: Option<Measured>,
        times: &mut impl FnMut(u64) -> SimTime,
        sink: &mut impl FnMut(&RateSample),
    ) {
        if index < self.expected {
            return;
        }
        if index >= self.end {
            self.close(times, sink);
            self.enter(index - index % self.per_output);
        }
        self.lost += index - self.expected;
        self.expected = index.saturating_add(1);
        if let Some(measured) = measured {
            self.sum_rad_s += measured.rate_rad_s;
            self.count += 1;
            self.over_range |= measured.over_range;
            if let Some([x_rad_s, y_rad_s]) = measured.cross_rates_rad_s {
                let [sum_x, sum_y] = self.cross_sums_rad_s;
                self.cross_sums_rad_s = [sum_x + x_rad_s, sum_y + y_rad_s];
                self.has_cross = true;
            }
        }
        if self.expected == self.end {
            self.close(times, sink);
            self.enter(self.end);
        }
    }

    #[inline]
    fn enter(&mut self, begin: u64) {
        (self.begin, self.end) = (begin, begin.saturating_add(self.per_output));
    }

    /// Hands out the average of the current group, if anything of it arrived.
    #[inline]
    fn close(
        &mut self,
        times: &mut impl FnMut(u64) -> SimTime,
        sink: &mut impl FnMut(&RateSample),
    ) {
        if self.count == 0 {
            return;
        }
        let begin = times(self.begin);
        let is_gap = begin > self.closed && begin.seconds_since(self.closed) > self.half_period_s;
        let from = if is_gap { begin } else { self.closed };
        let time = times(self.end).max(from);
        self.closed = time;
        let cross_rates_rad_s = self.cross_sums_rad_s.map(|sum| sum / self.count as f64);
        sink(&RateSample {
            from,
            time,
            rate_rad_s: self.mean_rad_s(),
            cross_rates_rad_s: self.has_cross.then_some(cross_rates_rad_s),
            over_range: self.over_range,
            lost_before: self.lost,
        });
        self.sum_rad_s = 0.0;
        (self.cross_sums_rad_s, self.has_cross) = ([0.0; 2], false);
        self.count = 0;
        self.over_range = false;
        self.lost = 0;
    }

    /// One sample is its own mean, to the bit.
    #[inline]
    fn mean_rad_s(&self) -> f64 {
        if self.count == 1 { self.sum_rad_s } else { self.sum_rad_s / self.count as f64 }
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "means of small integers and whole milliseconds are exact")]
mod tests {
    use super::*;
    use struna_kernel::SimTime;

    fn averager(per_output: u64) -> Averager {
        Averager::new(SampleGrid::new(SimTime::ZERO, 300.0).unwrap(), per_output).unwrap()
    }

    #[test]
    fn a_frame_of_another_channel_thins_its_group_and_is_not_lost() {
        let (mut averager, mut out) = (averager(3), Vec::new());
        for k in 0..9_u64 {
            match k {
                1 | 5 => averager.pass_over(k, &mut |sample| out.push(*sample)),
                _ => averager.add(k, k as f64, false, &mut |sample| out.push(*sample)),
            }
        }
        let means: Vec<_> = out.iter().map(|sample| sample.rate_rad_s).collect();
        assert_eq!(means, [1.0, 3.5, 7.0]);
        assert!(out.iter().all(|sample| sample.lost_before == 0));
        assert_eq!(out.last().unwrap().time, SimTime::from_ns(30_000_000));
    }

    fn feed(averager: &mut Averager, indices: &[u64]) -> Vec<RateSample> {
        let mut out = Vec::new();
        for &k in indices {
            averager.add(k, k as f64, k == 4, &mut |sample| out.push(*sample));
        }
        out
    }

    #[test]
    fn three_samples_at_300_hz_make_one_at_100_hz() {
        let out = feed(&mut averager(3), &[0, 1, 2, 3, 4, 5]);
        assert_eq!(out.len(), 2);
        assert_eq!(out[0].time, SimTime::from_ns(10_000_000));
        assert_eq!((out[0].rate_rad_s, out[1].rate_rad_s), (1.0, 4.0));
        assert_eq!((out[0].over_range, out[1].over_range), (false, true));
        assert_eq!(out[1].span_s(), 0.01);
    }

    #[test]
    fn rates_about_three_axes_are_means_of_the_same_samples() {
        let (mut averager, mut out) = (averager(3), Vec::new());
        // Samples 1, 3 and 4 are lost: groups of two, one and three.
        for k in [0_u64, 2, 5, 6, 7, 8] {
            let rate_rad_s = k as f64;
            let cross_rates_rad_s = Some([10.0 * rate_rad_s, -rate_rad_s]);
            let measured = Measured { rate_rad_s, cross_rates_rad_s, over_range: k == 7 };
            averager.add_measured(k, measured, &mut |sample| out.push(*sample));
        }
        let means: Vec<_> = out.iter().map(|s| (s.rate_rad_s, s.cross_rates_rad_s)).collect();
        let of = |mean: f64| (mean, Some([10.0 * mean, -mean]));
        assert_eq!(means, [of(1.0), of(5.0), of(7.0)]);
        let flags: Vec<_> = out.iter().map(|s| (s.over_range, s.lost_before)).collect();
        assert_eq!(flags, [(false, 1), (false, 2), (true, 0)]);
        assert_eq!(feed(&mut self::averager(3), &[0, 1, 2])[0].cross_rates_rad_s, None);
    }

    #[test]
    fn a_lost_sample_thins_its_own_group_only() {
        let out = feed(&mut averager(3), &[0, 2, 3, 4, 5]);
        assert_eq!((out[0].rate_rad_s, out[0].lost_before), (1.0, 1));
        assert_eq!((out[1].rate_rad_s, out[1].lost_before), (4.0, 0));
    }

    #[test]
    fn a_lost_end_of_a_group_is_closed_by_the_next_sample() {
        let out = feed(&mut averager(3), &[0, 1, 3, 4, 5]);
        assert_eq!((out[0].rate_rad_s, out[0].lost_before), (0.5, 0));
        assert_eq!((out[1].rate_rad_s, out[1].lost_before), (4.0, 1));
    }

    #[test]
    fn a_group_that_never_came_is_a_gap() {
        let out = feed(&mut averager(3), &[0, 1, 2, 9, 10, 11]);
        assert_eq!(out.len(), 2);
        assert_eq!(out[1].lost_before, 6);
        let gap_s = out[1].from.seconds_since(out[0].time);
        assert_eq!(gap_s, 0.02);
    }

    #[test]
    fn a_clock_that_moves_makes_neither_gaps_nor_overlaps() {
        let mut averager = averager(3);
        let mut out: Vec<RateSample> = Vec::new();
        for k in 0..300_u64 {
            // A period of 10/3 ms whose phase jumps to and fro by 1 ms with every sample.
            let phase_ns = if k % 2 == 0 { 0 } else { 1_000_000 };
            let times =
                |instant: u64| SimTime::from_ns(instant.cast_signed() * 10_000_000 / 3 + phase_ns);
            averager.add_timed(k, 1.0, false, &times, &mut |sample| out.push(*sample));
        }
        assert_eq!(out.len(), 100);
        assert!(out.windows(2).all(|pair| pair[0].time == pair[1].from && pair[1].span_s() > 0.0));
    }

    #[test]
    fn an_index_that_does_not_increase_is_ignored() {
        let out = feed(&mut averager(3), &[0, 1, 1, 0, 2]);
        assert_eq!(out.len(), 1);
        assert_eq!(out[0].rate_rad_s, 1.0);
    }
}
