//! Whole runs as records, and what their errors come to.

use crate::rig::{Rig, SAMPLES, STEP_S, Sample, Scenario};
use nalgebra::{DMatrix, DVector};
use struna_estimator::{Belief, RateRecord, RateSample};
use struna_kernel::RAD_PER_DEG;

/// One run: its truth, and what the gyro said.
#[derive(Clone)]
pub(crate) struct Run {
    pub(crate) truth: Vec<Sample>,
    pub(crate) samples: Vec<RateSample>,
    pub(crate) believed_start_deg: f64,
    pub(crate) bias_rad_s: f64,
    /// (s, d) of the true oscillator.
    pub(crate) parameters: (f64, f64),
    /// First sample, from 0, that shows each kick, and the kick's size, rad/s.
    pub(crate) kicks: Vec<(usize, f64)>,
}

impl Run {
    pub(crate) fn of(scenario: Scenario, run: u32) -> Self {
        let mut rig = Rig::new(scenario, run);
        let truth: Vec<Sample> = (1..=SAMPLES).map(|k| rig.sample(k)).collect();
        let samples = (1..=SAMPLES)
            .zip(&truth)
            .map(|(k, truth)| RateSample {
                time_s: f64::from(k) * STEP_S,
                rate_rad_s: truth.measured_rad_s,
                over_range: false,
            })
            .collect();
        Self {
            kicks: rig.kicks().map(|(k, size)| (k as usize - 1, size)).collect(),
            believed_start_deg: rig.believed_start_deg,
            bias_rad_s: rig.bias_rad_s,
            parameters: rig.parameters(),
            truth,
            samples,
        }
    }

    pub(crate) fn record(&self) -> RateRecord<'_> {
        RateRecord { start_time_s: 0.0, samples: &self.samples }
    }

    /// Mean squares of the errors over the run, deg² and (deg/s)².
    pub(crate) fn mean_squares(&self, beliefs: impl Iterator<Item = Belief>) -> [f64; 2] {
        let mut sums = [0.0; 2];
        let mut count = 0;
        for (belief, truth) in beliefs.zip(&self.truth) {
            sums[0] += (belief.angle_rad - truth.angle_rad).powi(2);
            sums[1] += (belief.rate_rad_s - truth.rate_rad_s).powi(2);
            count += 1;
        }
        assert_eq!(count, self.truth.len(), "a belief for every sample");
        sums.map(|sum| sum / count as f64 / (RAD_PER_DEG * RAD_PER_DEG))
    }

    /// The five states after sample `k`, from 0.
    pub(crate) fn state(&self, k: usize) -> [f64; 5] {
        let ((s, d), truth) = (self.parameters, self.truth[k]);
        [-s * truth.angle_rad, truth.rate_rad_s, s, d, self.bias_rad_s]
    }
}

/// What `of` makes of each of `runs` runs, on two threads.
pub(crate) fn each<T: Send>(
    scenario: Scenario,
    runs: u32,
    of: impl Fn(&Run) -> T + Sync,
) -> Vec<T> {
    let half = |parity: u32| -> Vec<T> {
        (0..runs / 2).map(|k| of(&Run::of(scenario, 2 * k + parity))).collect()
    };
    std::thread::scope(|scope| {
        let odd = scope.spawn(|| half(1));
        let mut all = half(0);
        all.extend(odd.join().expect("no run panics"));
        all
    })
}

/// Root of the mean of each number.
pub(crate) fn root_mean(of: &[[f64; 2]]) -> [f64; 2] {
    [0, 1].map(|i| (of.iter().map(|x| x[i]).sum::<f64>() / of.len() as f64).sqrt())
}

/// eᵀ·P⁻¹·e, scaled to correlations first.
pub(crate) fn error_squared<const N: usize>(
    mean: [f64; N],
    rows: [[f64; N]; N],
    truth: [f64; N],
) -> f64 {
    let sigma: [f64; N] = std::array::from_fn(|i| rows[i][i].sqrt());
    let correlation = DMatrix::from_fn(N, N, |i, j| rows[i][j] / (sigma[i] * sigma[j]));
    let error = DVector::from_fn(N, |i, _| (mean[i] - truth[i]) / sigma[i]);
    // By singular values: states that differ by a certain multiple of each other leave none.
    error.dot(&correlation.svd(true, true).solve(&error, 1e-9).unwrap())
}

/// NEES of angle and rate.
pub(crate) fn belief_error_squared(belief: &Belief, truth: &Sample) -> f64 {
    let p = belief.covariance;
    error_squared(
        [belief.angle_rad, belief.rate_rad_s],
        [[p.angle_rad2, p.cross_rad2_s], [p.cross_rad2_s, p.rate_rad2_s2]],
        [truth.angle_rad, truth.rate_rad_s],
    )
}
