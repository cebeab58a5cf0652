//! The statistic of the 2008 laboratory: half of the range of a record, taken for its deviation.

use super::RateRecord;
use super::record::mean;

/// Nothing of a Gaussian lies beyond this many deviations that a sum in double precision sees.
const TAIL_SIGMAS: f64 = 38.0;
/// Panels of Simpson's rule; the integrand changes over tenths of a deviation.
const PANELS: u32 = 4000;

/// What a record of `averaging` samples at a time shows by the laboratory's rule, σ = (max −
/// min)/2, beside what it should show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LabStatistic {
    /// Samples per average.
    pub averaging: usize,
    /// How many averages there are.
    pub averages: usize,
    /// Half of the range of the averages, rad/s; its square is what the laboratory prints as σ².
    pub half_range_rad_s: f64,
    /// d(n): what half of the range is in deviations, for as many Gaussian numbers.
    pub bias_factor: f64,
    /// Standard deviation of the averages about their mean, rad/s.
    pub sigma_rad_s: f64,
    /// Standard deviation of single samples over √averaging: what averages of white noise have.
    pub white_sigma_rad_s: f64,
    /// Correlation of one average with the next; none when no two follow each other.
    pub lag1_correlation: Option<f64>,
}

impl LabStatistic {
    /// The statistic of whole averages, each from one stretch of the record. None when there are
    /// less than two.
    #[must_use]
    pub fn of(record: &RateRecord, averaging: usize) -> Option<Self> {
        let averaging = averaging.max(1);
        let stretches: Vec<Vec<f64>> = record
            .stretches()
            .map(|rates| rates.chunks_exact(averaging).map(mean).collect())
            .collect();
        let averages = stretches.concat();
        if averages.len() < 2 {
            return None;
        }
        let (least, greatest) = averages
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
        Some(Self {
            averaging,
            averages: averages.len(),
            half_range_rad_s: 0.5 * (greatest - least),
            bias_factor: half_range_in_deviations(averages.len()),
            sigma_rad_s: deviation(&averages),
            white_sigma_rad_s: deviation(record.rates_rad_s()) / (averaging as f64).sqrt(),
            lag1_correlation: lag1_correlation(&stretches, mean(&averages)),
        })
    }

    /// The printed σ², (rad/s)².
    #[must_use]
    pub fn printed_variance(&self) -> f64 {
        self.half_range_rad_s.powi(2)
    }

    /// Half of the range less its bias: an estimate of the deviation, rad/s.
    #[must_use]
    pub fn debiased_sigma_rad_s(&self) -> f64 {
        self.half_range_rad_s / self.bias_factor
    }

    /// How many times the variance of the averages exceeds that of white noise, for which averaging
    /// m samples divides the deviation by √m.
    #[must_use]
    pub fn excess_over_white(&self) -> f64 {
        (self.sigma_rad_s / self.white_sigma_rad_s).powi(2)
    }
}

/// d(n): expected half of the range of `n` independent Gaussian numbers of unit deviation.
///
/// The expected range is the integral of 1 − Φ(x)ⁿ − Φ(−x)ⁿ, which is even in x.
#[must_use]
pub fn half_range_in_deviations(n: usize) -> f64 {
    let n = n as f64;
    let integrand = |x: f64| {
        let upper = 0.5 * libm::erfc(x / std::f64::consts::SQRT_2);
        // 1 − Φⁿ without the cancellation that far tails would suffer.
        -(n * (-upper).ln_1p()).exp_m1() - upper.powf(n)
    };
    let step = TAIL_SIGMAS / f64::from(PANELS);
    let weight = |k: u32| match k {
        0 | PANELS => 1.0,
        odd if odd % 2 == 1 => 4.0,
        _ => 2.0,
    };
    let sum: f64 = (0..=PANELS).map(|k| weight(k) * integrand(f64::from(k) * step)).sum();
    sum * step / 3.0
}

fn deviation(values: &[f64]) -> f64 {
    let mean = mean(values);
    let squares = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
    (squares / (values.len() - 1) as f64).sqrt()
}

/// Correlation of neighbours within stretches.
fn lag1_correlation(stretches: &[Vec<f64>], mean: f64) -> Option<f64> {
    let (mut products, mut pairs, mut squares, mut values) = (0.0, 0.0, 0.0, 0.0);
    for averages in stretches {
        for pair in averages.windows(2) {
            products += (pair[0] - mean) * (pair[1] - mean);
            pairs += 1.0;
        }
        squares += averages.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
        values += averages.len() as f64;
    }
    let correlation = (products / pairs) / (squares / values);
    correlation.is_finite().then_some(correlation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use struna_kernel::{Channel, RandomStream, Seed};

    fn normals(n: usize, run: u64) -> impl Iterator<Item = f64> {
        // Any channel does; it only keys the stream.
        let mut stream = RandomStream::new(Seed(8), Channel::GyroAngleRandomWalk, run);
        std::iter::repeat_with(move || stream.standard_normal()).take(n)
    }

    #[test]
    fn the_bias_of_half_a_range_is_that_of_the_table() {
        // Means of 2000 drawn records each, with their spread; two decimals were kept, and the mean
        // of 2000 records is known to a forty-fifth of the spread.
        for (n, expected, spread) in [
            (50, 2.25, 0.33),
            (100, 2.50, 0.31),
            (300, 2.87, 0.27),
            (1000, 3.25, 0.25),
            (3000, 3.56, 0.23),
            (10_000, 3.85, 0.22),
            (30_000, 4.11, 0.20),
        ] {
            let found = half_range_in_deviations(n);
            let tolerance = 0.005 + 3.0 * spread / 2000.0_f64.sqrt();
            assert!((found - expected).abs() < tolerance, "{n}: {found}");
        }
    }

    #[test]
    fn the_bias_is_exact_where_it_has_a_closed_form() {
        // Two numbers: 1/√π; three: 3/(2√π).
        let root_pi = std::f64::consts::PI.sqrt();
        assert!((half_range_in_deviations(2) - 1.0 / root_pi).abs() < 1e-10);
        assert!((half_range_in_deviations(3) - 1.5 / root_pi).abs() < 1e-10);
    }

    #[test]
    fn dividing_by_the_bias_gives_the_deviation_back() {
        let runs = 400_u16;
        let sum: f64 = (0..runs)
            .map(|run| {
                let rates = normals(300, run.into()).map(|x| 0.02 * x + 7.0);
                let record = RateRecord::contiguous(300.0, rates).unwrap();
                LabStatistic::of(&record, 1).unwrap().debiased_sigma_rad_s()
            })
            .sum();
        let mean = sum / f64::from(runs);
        // Four standard errors; half of a range spreads by 0.27/2.87 of itself.
        assert!((mean / 0.02 - 1.0).abs() < 4.0 * 0.094 / 20.0, "{mean}");
    }

    #[test]
    fn averages_of_white_noise_shrink_by_the_root_and_are_not_correlated() {
        let record = RateRecord::contiguous(300.0, normals(300_000, 0)).unwrap();
        let lab = LabStatistic::of(&record, 30).unwrap();
        assert_eq!((lab.averaging, lab.averages), (30, 10_000));
        // Four standard errors of a variance and of a correlation of 10 000 numbers.
        assert!((lab.excess_over_white() - 1.0).abs() < 4.0 * 0.02_f64.sqrt() / 10.0);
        assert!(lab.lag1_correlation.unwrap().abs() < 4.0 / 100.0);
        let ratio = lab.printed_variance() / lab.sigma_rad_s.powi(2);
        assert!((8.0..25.0).contains(&ratio), "the printed variance is {ratio} times the true one");
    }

    /// White noise through a second-order low pass of 40 Hz, sampled at 1400 Hz.
    fn band_limited(n: usize) -> Vec<f64> {
        let (rate_hz, band_hz, damping) = (1400.0, 40.0, std::f64::consts::FRAC_1_SQRT_2);
        let k = (std::f64::consts::PI * band_hz / rate_hz).tan();
        let norm = 1.0 + 2.0 * damping * k + k * k;
        let (b, a1, a2) = (k * k, 2.0 * (k * k - 1.0), 1.0 - 2.0 * damping * k + k * k);
        let (mut x1, mut x2, mut y1, mut y2) = (0.0, 0.0, 0.0, 0.0);
        let filtered = normals(n + 1000, 1).map(|x| {
            let y = (b * (x + 2.0 * x1 + x2) - a1 * y1 - a2 * y2) / norm;
            (x2, x1, y2, y1) = (x1, x, y1, y);
            y
        });
        filtered.skip(1000).collect()
    }

    #[test]
    fn averaging_a_band_limited_gyro_does_not_divide_by_the_root() {
        let record = RateRecord::contiguous(1400.0, band_limited(2_800_000)).unwrap();
        // Deviation beside single samples, variance beside white noise, correlation.
        for (m, sigma, excess, correlation) in
            [(14, 0.865, 10.5, 0.29), (70, 0.462, 14.9, 0.03), (140, 0.331, 15.3, 0.01)]
        {
            let lab = LabStatistic::of(&record, m).unwrap();
            let ratio = lab.sigma_rad_s / (lab.white_sigma_rad_s * (m as f64).sqrt());
            // At m = 140 there are 20 000 averages: 4 standard errors of a deviation are 2 %, of a
            // correlation 0.03.
            assert!((ratio / sigma - 1.0).abs() < 0.02, "{m}: {ratio}");
            assert!((lab.excess_over_white() / excess - 1.0).abs() < 0.04, "{m}");
            let found = lab.lag1_correlation.unwrap();
            assert!((found - correlation).abs() < 0.03, "{m}: {found}");
        }
    }

    #[test]
    fn averages_do_not_reach_over_gaps() {
        let mut record = RateRecord::contiguous(1.0, [1.0, 3.0, 100.0]).unwrap();
        record.lose(1);
        [5.0, 7.0].into_iter().for_each(|rate| record.push(rate));
        let lab = LabStatistic::of(&record, 2).unwrap();
        assert_eq!((lab.averages, lab.lag1_correlation), (2, None));
        assert!((lab.half_range_rad_s - 2.0).abs() < 1e-15, "2 and 6");
        assert_eq!(LabStatistic::of(&record, 3), None);
    }
}
