//! The Allan deviation of a record as a curve with intervals.

use super::angle::CumulativeAngle;
use super::freedom::{degrees_of_freedom, variance_interval};
use super::{NoiseModel, RateRecord, TauGrid, Term};
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Averages of three times the averaging time are the least that a difference of averages and one
/// shift of it need.
const REPORTED_SHARE: usize = 3;
/// An estimate is trusted up to a ninth of the record, where some ten degrees of freedom are left.
const TRUSTED_SHARE: usize = 9;
/// A band-limited gyro shows less than its white noise below this many radians of its band edge.
const FILTERED_RAD: f64 = 12.0;

/// The Allan deviation at one averaging time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AllanPoint {
    /// Averaging time in samples.
    pub factor: usize,
    /// Averaging time τ, s.
    pub tau_s: f64,
    /// Overlapping Allan deviation, rad/s.
    pub adev_rad_s: f64,
    /// Lower and upper end of its confidence interval, rad/s.
    pub interval_rad_s: [f64; 2],
    /// Overlapping Hadamard deviation, rad/s; none where it does not fit in.
    pub hdev_rad_s: Option<f64>,
    /// Equivalent degrees of freedom.
    pub edf: f64,
    /// The noise that they are counted for.
    pub noise: Term,
    /// Whether the averaging time is at most a ninth of what the record offers.
    pub trusted: bool,
    /// Whether the gyro's band hides noise at this averaging time.
    pub filtered: bool,
}

impl AllanPoint {
    /// Whether a fit may use the point.
    #[must_use]
    pub fn is_usable(&self) -> bool {
        self.trusted && !self.filtered && self.adev_rad_s > 0.0
    }
}

/// Averaging times below this are filtered by a band of `bandwidth_hz`, s.
#[must_use]
pub(super) fn filtered_below_s(bandwidth_hz: f64) -> f64 {
    FILTERED_RAD / (2.0 * PI * bandwidth_hz)
}

/// By how much a band makes the Allan variance of white noise smaller beyond the times that it
/// hides: N²/τ·(1 − lag/τ), s.
///
/// White noise through a filter H turns by an angle of variance N²·(t − c), with
/// c = (1/π)·∫(1 − |H|²)/ω² dω, once t is long beside the filter's memory; so the lag is 3c/2. Of a
/// second-order Butterworth filter c is 1/(√2·ω₀); of a first-order one it would be 1/ω₀, and N
/// comes out 1 % too small for it at most.
#[must_use]
pub(super) fn white_lag_s(bandwidth_hz: f64) -> f64 {
    1.5 * FRAC_1_SQRT_2 / (2.0 * PI * bandwidth_hz)
}

/// The stretches of a record as angles, from which every curve is drawn.
pub(super) struct Angles {
    sample_rate_hz: f64,
    stretches: Vec<CumulativeAngle>,
}

impl Angles {
    pub(super) fn of(record: &RateRecord) -> Self {
        let mean_rad_s = record.mean_rad_s();
        let stretches = record.stretches().map(|rates| CumulativeAngle::of(rates, mean_rad_s));
        Self { sample_rate_hz: record.sample_rate_hz(), stretches: stretches.collect() }
    }

    /// The curve, with degrees of freedom counted for flicker, which lies between the others.
    pub(super) fn curve(&self, grid: TauGrid, bandwidth_hz: Option<f64>) -> Vec<AllanPoint> {
        let longest = self.stretches.iter().map(|angle| angle.points() - 1).max().unwrap_or(0);
        let hidden_s = bandwidth_hz.map_or(0.0, filtered_below_s);
        let factors = grid.factors(longest / REPORTED_SHARE);
        factors.into_iter().filter_map(|factor| self.point(factor, hidden_s)).collect()
    }

    fn point(&self, factor: usize, hidden_s: f64) -> Option<AllanPoint> {
        let (variance, samples) = self.pooled(factor, CumulativeAngle::allan_variance)?;
        let hadamard = self.pooled(factor, CumulativeAngle::hadamard_variance);
        let tau_s = factor as f64 / self.sample_rate_hz;
        let noise = Term::BiasInstability;
        Some(AllanPoint {
            factor,
            tau_s,
            adev_rad_s: variance.sqrt(),
            interval_rad_s: [0.0, f64::INFINITY],
            hdev_rad_s: hadamard.map(|(variance, _)| variance.sqrt()),
            edf: self.freedom(noise, factor),
            noise,
            trusted: factor * TRUSTED_SHARE <= samples,
            filtered: tau_s < hidden_s,
        })
    }

    /// Mean of a variance over the stretches that are long enough, each by its degrees of freedom,
    /// and how many samples these hold.
    ///
    /// The weights are counted for flicker whatever the noise is: they then do not depend on the
    /// estimate, and for other noise are off by a factor that all long stretches share.
    fn pooled(
        &self,
        factor: usize,
        variance: impl Fn(&CumulativeAngle, usize) -> Option<f64>,
    ) -> Option<(f64, usize)> {
        let (mut sum, mut weights, mut samples) = (0.0, 0.0, 0);
        for angle in self.long_enough(factor) {
            let Some(variance) = variance(angle, factor) else { continue };
            let weight = degrees_of_freedom(Term::BiasInstability, angle.points(), factor);
            sum += weight * variance;
            weights += weight;
            samples += angle.points() - 1;
        }
        (weights > 0.0).then(|| (sum / weights, samples))
    }

    fn long_enough(&self, factor: usize) -> impl Iterator<Item = &CumulativeAngle> {
        let least = factor.saturating_mul(REPORTED_SHARE);
        self.stretches.iter().filter(move |angle| angle.points() > least)
    }

    /// Degrees of freedom of the pooled variance for this kind of noise.
    fn freedom(&self, noise: Term, factor: usize) -> f64 {
        self.long_enough(factor).map(|a| degrees_of_freedom(noise, a.points(), factor)).sum()
    }

    /// Counts the degrees of freedom for the noise that `model` has at each point, for flicker
    /// where it is mixed, and sets the intervals.
    pub(super) fn match_noise(
        &self,
        points: &mut [AllanPoint],
        model: &NoiseModel,
        confidence: f64,
    ) {
        for point in points {
            point.noise = model.dominant(point.tau_s).unwrap_or(Term::BiasInstability);
            point.edf = self.freedom(point.noise, point.factor);
            let factors = variance_interval(point.edf, confidence);
            point.interval_rad_s = factors.map(|factor| point.adev_rad_s * factor.sqrt());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn alternating(n: usize) -> Vec<f64> {
        (0..n).map(|k| [0.0, 1.0, 0.5, -1.0, 2.0][k * k % 7 % 5]).collect()
    }

    #[test]
    fn trust_ends_at_a_ninth_and_the_curve_at_a_third() {
        let record = RateRecord::contiguous(10.0, alternating(900)).unwrap();
        let points = Angles::of(&record).curve(TauGrid::TenPerDecade, Some(2.0));
        let trusted: Vec<_> = points.iter().filter(|p| p.trusted).collect();
        assert_eq!(trusted.last().unwrap().factor, 100);
        assert_eq!(points.last().unwrap().factor, 251);
        // 12/(2π · 2 Hz) = 0.955 s.
        let filtered: Vec<_> = points.iter().filter(|p| p.filtered).map(|p| p.factor).collect();
        assert_eq!(filtered, [1, 2, 3, 4, 5, 6, 8]);
    }

    #[test]
    fn stretches_of_equal_length_weigh_the_same() {
        let (first, second) = (alternating(300), alternating(300).into_iter().map(|x| 3.0 * x));
        let mut record = RateRecord::contiguous(1.0, first.clone()).unwrap();
        record.lose(1);
        second.for_each(|rate| record.push(rate));
        let alone = RateRecord::contiguous(1.0, first).unwrap();
        let pooled = Angles::of(&record).curve(TauGrid::Octave, None);
        let alone = Angles::of(&alone).curve(TauGrid::Octave, None);
        assert_eq!(pooled.len(), alone.len());
        for (pooled, alone) in pooled.iter().zip(&alone) {
            // (1 + 9)/2 = 5 times the variance, twice the freedom. The mean does not matter.
            let ratio = (pooled.adev_rad_s / alone.adev_rad_s).powi(2);
            assert!((ratio - 5.0).abs() < 1e-9, "{ratio}");
            assert!((pooled.edf / alone.edf - 2.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_step_hidden_in_a_gap_does_not_show() {
        let mut record = RateRecord::contiguous(1.0, alternating(300)).unwrap();
        record.lose(1000);
        alternating(300).into_iter().for_each(|rate| record.push(rate + 1e6));
        let whole = Angles::of(&record).curve(TauGrid::Octave, None);
        let part = RateRecord::contiguous(1.0, alternating(300)).unwrap();
        let part = Angles::of(&part).curve(TauGrid::Octave, None);
        for (whole, part) in whole.iter().zip(&part) {
            // A million costs six of sixteen digits, and the mean as much again in the angle.
            assert!((whole.adev_rad_s / part.adev_rad_s - 1.0).abs() < 1e-5);
        }
    }
}
