//! The least error that any filter can have: the covariance recursion along the true trajectory.

use super::contestant::TrueState;
use super::row::{Column, Row};
use super::torsion::STEP_S;
use statrs::function::erf::erfc;
use std::f64::consts::{FRAC_1_SQRT_2, PI};
use struna_estimator::AugmentedConfig;
use struna_kernel::RAD_PER_DEG;

/// What one measured rate can tell of the true one at most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Information {
    /// As much as one with white noise of this variance, rad²/s².
    White(f64),
    /// As much as some samples that are rounded to counts, each with normal noise before that.
    Counts {
        /// One count, rad/s.
        lsb_rad_s: f64,
        /// Standard deviation of the noise of one sample, rad/s.
        sigma_rad_s: f64,
        /// Samples.
        samples: u32,
    },
}

impl Information {
    /// Variance of the white noise that would leave as much, rad²/s², at a true rate, rad/s.
    ///
    /// Of counts it is one over Fisher's information, Σ p′²/p over the counts that can come. It
    /// changes with the place between two counts, and is never below the variance before rounding.
    #[must_use]
    pub(super) fn variance_rad2_s2(&self, rate_rad_s: f64) -> f64 {
        match *self {
            Self::White(variance) => variance,
            Self::Counts { lsb_rad_s, sigma_rad_s, samples } => {
                let fisher = fisher_of_a_count(rate_rad_s / lsb_rad_s, sigma_rad_s / lsb_rad_s);
                lsb_rad_s * lsb_rad_s / (f64::from(samples) * fisher)
            }
        }
    }
}

/// Fisher's information in one count on a rate, both in counts, from noise of `sigma` counts.
fn fisher_of_a_count(rate: f64, sigma: f64) -> f64 {
    let place = rate - rate.round();
    // Beyond eight sigma nothing comes.
    let reach = (8.0 * sigma).ceil() + 1.0;
    let below = |edge: f64| 0.5 * erfc((place - edge) / sigma * FRAC_1_SQRT_2);
    let density =
        |edge: f64| (-0.5 * ((edge - place) / sigma).powi(2)).exp() / (sigma * (2.0 * PI).sqrt());
    let mut sum = 0.0;
    let mut count = -reach;
    while count <= reach {
        let (low, high) = (count - 0.5, count + 0.5);
        let share = below(high) - below(low);
        let slope = density(low) - density(high);
        if share > 1e-15 {
            sum += slope * slope / share;
        }
        count += 1.0;
    }
    sum
}

/// Covariance of (φ, φ′, Ω², 2ζΩ, b) in rad and s, linearised where the body truly is: another form
/// than the filter's, whose states are chosen for their linearity and whose place is its belief.
///
/// It is the bound for any filter, on average over runs that are drawn from the prior, whatever a
/// filter is told: the noise is that which the samples have.
///
/// # Source
/// The recursion for the posterior Cramér-Rao bound of Tichavský, Muravchik and Nehorai (1998),
/// evaluated on single trajectories and averaged over runs.
#[derive(Debug, Clone)]
pub(super) struct Bound {
    p: [[f64; 5]; 5],
    q_step: f64,
    bias_step: f64,
    half_from: u32,
    sums: (f64, f64),
    counted: u32,
}

impl Bound {
    /// The recursion at the start of a run of `samples` measurements.
    #[must_use]
    pub(super) fn new(config: &AugmentedConfig, samples: u32) -> Self {
        let start = &config.start;
        let omega = std::f64::consts::TAU / start.period_s;
        let sigma = [
            start.angle_sigma_rad,
            start.rate_sigma_rad_s,
            2.0 * omega * omega * start.period_sigma_s / start.period_s,
            2.0 * omega * start.damping_ratio_sigma,
            start.bias_sigma_rad_s,
        ];
        let mut p = [[0.0; 5]; 5];
        for (i, sigma) in sigma.iter().enumerate() {
            p[i][i] = sigma * sigma;
        }
        Self {
            p,
            q_step: config.process_noise_rad2_s3 * STEP_S,
            bias_step: config.bias_walk_rad2_s3 * STEP_S,
            half_from: samples / 2,
            sums: (0.0, 0.0),
            counted: 0,
        }
    }

    /// Goes from the truth at the sample before to sample `k`, and takes its measurement in.
    pub(super) fn step(&mut self, k: u32, before: &TrueState, information: &Information) {
        self.predict(before);
        self.update(information.variance_rad2_s2(before.rate_rad_s + before.bias_rad_s));
        if k > self.half_from {
            self.sums.0 += self.p[0][0];
            self.sums.1 += self.p[1][1];
            self.counted += 1;
        }
    }

    /// P ← F·P·Fᵀ + Q with two terms of F's exponential: the third is (Ω·h)³ = 2e-12. Only two rows
    /// of F differ from the identity's.
    fn predict(&mut self, at: &TrueState) {
        let (h, h2) = (STEP_S, 0.5 * STEP_S * STEP_S);
        let TrueState { angle_rad, rate_rad_s, s, d, .. } = *at;
        let slope = [-s, -d, -angle_rad, -rate_rad_s, 0.0];
        let mut to_angle = slope.map(|a| h2 * a);
        let mut to_rate = slope.map(|a| (h - h2 * d) * a);
        to_angle[0] += 1.0;
        to_angle[1] += h;
        to_rate[1] += 1.0 - h2 * s;
        let p = &mut self.p;
        let along = |f: &[f64; 5], column: [f64; 5]| (0..5).map(|i| f[i] * column[i]).sum::<f64>();
        let columns: [[f64; 5]; 5] = std::array::from_fn(|j| std::array::from_fn(|i| p[i][j]));
        p[0] = columns.map(|column| along(&to_angle, column));
        p[1] = columns.map(|column| along(&to_rate, column));
        for row in p.iter_mut() {
            let cells = *row;
            (row[0], row[1]) = (along(&to_angle, cells), along(&to_rate, cells));
        }
        p[1][1] += self.q_step;
        p[4][4] += self.bias_step;
    }

    /// P ← P − P·h·hᵀ·P/S with h = (0, 1, 0, 0, 1), kept symmetric.
    fn update(&mut self, r: f64) {
        let p = &mut self.p;
        let column: [f64; 5] = std::array::from_fn(|i| p[i][1] + p[i][4]);
        let spread = column[1] + column[4] + r;
        for i in 0..5 {
            for j in 0..=i {
                let mean = 0.5 * (p[i][j] + p[j][i]) - column[i] * column[j] / spread;
                (p[i][j], p[j][i]) = (mean, mean);
            }
        }
    }

    /// Writes the bound into a row of the same run.
    pub(super) fn describe(&self, row: &mut Row) {
        let rms_deg = |sum: f64| (sum / f64::from(self.counted.max(1))).sqrt() / RAD_PER_DEG;
        row.set(Column::BoundAngleDeg, rms_deg(self.sums.0));
        row.set(Column::BoundRateDegS, rms_deg(self.sums.1));
        row.set(Column::BoundEndDeg, self.p[0][0].sqrt() / RAD_PER_DEG);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use struna_estimator::StartPrior;

    /// With all parameters known and t much shorter than a period the angle follows from the
    /// acceleration alone: σ = √(12·R·h/t³)/Ω².
    #[test]
    fn early_in_a_period_the_angle_is_known_from_the_acceleration() {
        let r = 2e-3 * RAD_PER_DEG * RAD_PER_DEG;
        let start = StartPrior {
            angle_sigma_rad: 100.0 * RAD_PER_DEG,
            period_sigma_s: 0.0,
            damping_ratio_sigma: 0.0,
            bias_sigma_rad_s: 0.0,
            rate_sigma_rad_s: 1.0,
            ..StartPrior::released(0.0, 480.0)
        };
        let config = AugmentedConfig {
            process_noise_rad2_s3: 0.0,
            bias_walk_rad2_s3: 0.0,
            ..AugmentedConfig::quiet(start, r)
        };
        let mut bound = Bound::new(&config, 864);
        let s = (std::f64::consts::TAU / 480.0_f64).powi(2);
        let at = TrueState { angle_rad: 6.0, rate_rad_s: 0.0, s, d: 0.0, bias_rad_s: 0.0 };
        for k in 1..=864 {
            bound.step(k, &at, &Information::White(r));
        }
        // The start rate is unknown, and the prior of 100° counts, too.
        let slope = (12.0 * r * STEP_S / 8.64_f64.powi(3)).sqrt() / s;
        let expected = (slope.powi(-2) + start.angle_sigma_rad.powi(-2)).powf(-0.5);
        let found = bound.p[0][0].sqrt();
        assert!((found / expected - 1.0).abs() < 0.01, "{found} for {expected}");
    }

    /// The gyro shows rate and bias together: one exact look halves the variance of each when both
    /// were equally unknown, and leaves their difference as it was.
    #[test]
    fn a_look_at_rate_and_bias_together_halves_both() {
        let start = StartPrior {
            rate_sigma_rad_s: 1.0,
            bias_sigma_rad_s: 1.0,
            ..StartPrior::released(0.0, 480.0)
        };
        let mut bound = Bound::new(&AugmentedConfig::quiet(start, 1e-6), 2);
        bound.update(1e-12);
        let p = &bound.p;
        let difference = p[1][1] + p[4][4] - 2.0 * p[1][4];
        for (found, expected) in [(p[1][1], 0.5), (p[4][4], 0.5), (difference, 2.0)] {
            assert!((found - expected).abs() < 1e-9, "{found} for {expected}");
        }
    }

    #[test]
    fn coarse_counts_tell_less_than_what_they_round() {
        // Well dithered, rounding adds the variance of a uniform error: 1/12.
        for place in [0.0, 0.25, 0.5] {
            let found = 1.0 / fisher_of_a_count(100.0 + place, 2.0);
            assert!((found / (4.0 + 1.0 / 12.0) - 1.0).abs() < 1e-6, "{place}: {found}");
        }
        // Noise of a twentieth of a count: on an edge a sample tells which side, whose information
        // is 2/(π·σ²), and in the middle of a count it tells nothing.
        let edge = fisher_of_a_count(0.5, 0.05) * 0.05_f64.powi(2);
        assert!((edge / (2.0 / PI) - 1.0).abs() < 1e-9, "{edge}");
        assert!(fisher_of_a_count(7.0, 0.05) < 1e-9);
        // Three samples, in units.
        let counts = Information::Counts { lsb_rad_s: 0.1, sigma_rad_s: 0.2, samples: 3 };
        let found = counts.variance_rad2_s2(0.034);
        assert!((found / (0.01 * (4.0 + 1.0 / 12.0) / 3.0) - 1.0).abs() < 1e-6, "{found}");
    }
}
