//! Many runs of a scenario, on two threads, and what is kept of them.

use crate::rig::{Rig, SAMPLES, STEP_S, Scenario};
use nalgebra::{SMatrix, SVector};
use struna_estimator::{RateEstimator, TestedFilter};
use struna_kernel::RAD_PER_DEG;

/// Instants at which the whole error is weighed against the whole covariance.
pub(crate) const EPOCHS: usize = 10;

/// How long a kick may stay unseen, s; what the filter claims meanwhile is not judged.
const SETTLING_S: f64 = 2.0;

/// What one run comes to. Degrees.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Run {
    /// Mean squares over the second half.
    pub(crate) angle2_deg2: f64,
    pub(crate) rate2_deg2_s2: f64,
    pub(crate) end_error_deg: f64,
    pub(crate) end_sigma_deg: f64,
    /// Normalised estimation error squared, five states, at equal intervals; none within
    /// [`SETTLING_S`] of a kick.
    pub(crate) nees: [Option<f64>; EPOCHS],
    pub(crate) alarms: u64,
    /// Time from the first sample of the first kick to the first alarm, s.
    pub(crate) delay_s: Option<f64>,
}

/// All runs of a scenario.
#[derive(Debug)]
pub(crate) struct Campaign(pub(crate) Vec<Run>);

impl Campaign {
    /// An even number of runs.
    pub(crate) fn of(scenario: Scenario, runs: u32) -> Self {
        let half = |parity: u32| {
            move || -> Vec<Run> { (0..runs / 2).map(|k| run(scenario, 2 * k + parity)).collect() }
        };
        let (even, odd) = std::thread::scope(|scope| {
            let odd = scope.spawn(half(1));
            let even = half(0)();
            (even, odd.join().expect("no run panics"))
        });
        Self(even.into_iter().zip(odd).flat_map(|(a, b)| [a, b]).collect())
    }

    pub(crate) fn mean(&self, of: impl Fn(&Run) -> f64) -> f64 {
        self.0.iter().map(of).sum::<f64>() / self.0.len() as f64
    }

    /// RMS of the angle error over the second half, deg.
    pub(crate) fn angle_deg(&self) -> f64 {
        self.mean(|run| run.angle2_deg2).sqrt()
    }

    /// RMS of the rate error over the second half, deg/s.
    pub(crate) fn rate_deg_s(&self) -> f64 {
        self.mean(|run| run.rate2_deg2_s2).sqrt()
    }

    pub(crate) fn end_deg(&self) -> f64 {
        self.mean(|run| run.end_error_deg.powi(2)).sqrt()
    }

    pub(crate) fn alarms(&self) -> f64 {
        self.mean(|run| run.alarms as f64)
    }

    /// Largest error at the end in claimed standard deviations.
    pub(crate) fn worst_sigmas(&self) -> f64 {
        let sigmas = |run: &Run| run.end_error_deg.abs() / run.end_sigma_deg;
        self.0.iter().map(sigmas).fold(0.0, f64::max)
    }

    /// Mean normalised estimation error squared at an epoch.
    pub(crate) fn nees(&self, epoch: usize) -> f64 {
        let known: Vec<f64> = self.0.iter().filter_map(|run| run.nees[epoch]).collect();
        assert!(known.len() * 10 > self.0.len() * 9, "most runs are settled at any one epoch");
        known.iter().sum::<f64>() / known.len() as f64
    }

    /// Detection delays in order, s.
    pub(crate) fn delays_s(&self) -> Vec<f64> {
        let mut delays: Vec<f64> = self.0.iter().filter_map(|run| run.delay_s).collect();
        delays.sort_by(f64::total_cmp);
        delays
    }
}

fn run(scenario: Scenario, run: u32) -> Run {
    let mut rig = Rig::new(scenario, run);
    let mut filter = scenario.filter(&rig);
    let (mut angle2, mut rate2, mut end_rad) = (0.0, 0.0, 0.0);
    let (mut nees, mut delay_s) = ([None; EPOCHS], None);
    let mut alarms_before_kick = 0;
    for k in 1..=SAMPLES {
        let truth = rig.sample(k);
        filter.step(STEP_S, truth.measured_rad_s).unwrap();
        if let Some(kick) = rig.first_kick() {
            if k < kick {
                alarms_before_kick = filter.alarms();
            } else if delay_s.is_none() && filter.alarms() > alarms_before_kick {
                delay_s = Some(f64::from(k - kick) * STEP_S);
            }
        }
        if k > SAMPLES / 2 {
            let belief = filter.belief();
            end_rad = belief.angle_rad - truth.angle_rad;
            angle2 += end_rad * end_rad;
            rate2 += (belief.rate_rad_s - truth.rate_rad_s).powi(2);
        }
        let epoch = SAMPLES / EPOCHS as u32;
        if k % epoch == 0 {
            let (s, d) = rig.parameters();
            let state = [-s * truth.angle_rad, truth.rate_rad_s, s, d, rig.bias_rad_s];
            let settled = !rig.is_struck_within(k, (SETTLING_S / STEP_S) as u32);
            nees[(k / epoch) as usize - 1] = settled.then(|| error_squared(&filter, state));
        }
    }
    let half = f64::from(SAMPLES / 2) * RAD_PER_DEG * RAD_PER_DEG;
    Run {
        angle2_deg2: angle2 / half,
        rate2_deg2_s2: rate2 / half,
        end_error_deg: end_rad / RAD_PER_DEG,
        end_sigma_deg: filter.belief().covariance.angle_rad2.sqrt() / RAD_PER_DEG,
        nees,
        alarms: filter.alarms(),
        delay_s,
    }
}

/// Normalised estimation error squared: eᵀ·P⁻¹·e over all five states.
fn error_squared(filter: &TestedFilter, truth: [f64; 5]) -> f64 {
    let rows = filter.filter().covariance();
    // Scaled to correlations first: the units differ by ten orders of magnitude.
    let sigma: [f64; 5] = std::array::from_fn(|i| rows[i][i].sqrt());
    let correlation = SMatrix::<f64, 5, 5>::from_fn(|i, j| rows[i][j] / (sigma[i] * sigma[j]));
    let mean = filter.filter().mean();
    let error = SVector::<f64, 5>::from_fn(|i, _| (mean[i] - truth[i]) / sigma[i]);
    let root = correlation.cholesky().expect("the covariance is positive definite");
    error.dot(&root.solve(&error))
}
