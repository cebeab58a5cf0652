//! Seeded runs of closed-form torsion, watched by many filters at once.

use struna_body::{
    Body, BodyParams, DampedTorsion, Torsion, TorsionDamping, TorsionStiffness, reference,
};
use struna_estimator::{
    Filter, FilterConfig, PermanentRotation, PlainIntegration, RateEstimator, Reading, Refinement,
    TorsionalOscillation,
};
use struna_kernel::{AddressedRandom, Channel, Seed};

pub(crate) const STEP_S: f64 = 0.01;
pub(crate) const DAMPING_RATIO: f64 = 0.03;
pub(crate) const START_DEG: f64 = 360.0;
const SEED: Seed = Seed(20_080_100);

/// A torsion and its gyro. The runs last one period.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rig {
    pub(crate) period_s: f64,
    pub(crate) r_deg2_s2: f64,
    /// Constant error of the gyro.
    pub(crate) bias_deg_s: f64,
    /// Where the filters believe the start.
    pub(crate) believed_deg: f64,
}

/// The papers' rig.
pub(crate) const PAPERS: Rig =
    Rig { period_s: 480.0, r_deg2_s2: 2e-3, bias_deg_s: 0.0, believed_deg: START_DEG };

/// RMS of one estimator's errors over runs and time.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Rms {
    pub(crate) angle_deg: f64,
    pub(crate) rate_deg_s: f64,
}

impl Rig {
    /// The filters are linear, so degrees may stand in for radians throughout.
    pub(crate) fn config(&self, refinement: Refinement) -> FilterConfig {
        FilterConfig {
            angle_start_rad: self.believed_deg,
            rate_start_rad_s: 0.0,
            angle_variance_start_rad2: 1.0,
            rate_variance_start_rad2_s2: 1.0,
            measurement_variance_rad2_s2: self.r_deg2_s2,
            process_noise_rad2_s3: 0.0,
            refinement,
        }
    }

    pub(crate) fn rotation(&self, reading: Reading, samples: u32) -> Filter<PermanentRotation> {
        Filter::permanent_rotation(self.config(Refinement { samples, reading })).unwrap()
    }

    pub(crate) fn torsion(&self, reading: Reading, samples: u32) -> Filter<TorsionalOscillation> {
        let config = self.config(Refinement { samples, reading });
        Filter::torsional_oscillation(config, self.period_s).unwrap()
    }

    pub(crate) fn integration(&self) -> PlainIntegration {
        PlainIntegration::new(self.config(Refinement::OFF)).unwrap()
    }

    pub(crate) fn samples(&self) -> u32 {
        (self.period_s / STEP_S).round() as u32
    }

    /// True (angle, rate) in deg and deg/s at samples 1, 2, … of a run, the same in every run.
    pub(crate) fn truth(&self) -> Vec<(f64, f64)> {
        let torsion = Torsion {
            stiffness: TorsionStiffness::PeriodS(self.period_s),
            damping: TorsionDamping::Ratio(DAMPING_RATIO),
        };
        let body = Body::new(&BodyParams { torsion, ..reference::PARAMS }).unwrap();
        // Linear too: let go at 360 rad it moves as many radians as degrees from 360°.
        let motion = DampedTorsion::new(&body, START_DEG, 0.0);
        (1..=self.samples())
            .map(|k| {
                let t_s = f64::from(k) * STEP_S;
                (motion.twist_rad(t_s), motion.twist_rate_rad_s(t_s))
            })
            .collect()
    }

    /// What the gyro says at every sample of a run, deg/s.
    pub(crate) fn measured_deg_s(&self, truth: &[(f64, f64)], run: u32) -> Vec<f64> {
        let mut noise = AddressedRandom::new(SEED, Channel::GyroAngleRandomWalk, u64::from(run));
        let sigma_deg_s = self.r_deg2_s2.sqrt();
        let sample = |(k, (_, rate_deg_s)): (u64, &(f64, f64))| {
            rate_deg_s + self.bias_deg_s + sigma_deg_s * noise.standard_normal(k)
        };
        (0..).zip(truth).map(sample).collect()
    }

    /// RMS errors of the estimators that `fresh` makes for each run: all see the same runs.
    pub(crate) fn rms(
        &self,
        runs: u32,
        fresh: impl Fn() -> Vec<Box<dyn RateEstimator>>,
    ) -> Vec<Rms> {
        let truth = self.truth();
        let mut sums = vec![Rms::default(); fresh().len()];
        for run in 0..runs {
            let measured = self.measured_deg_s(&truth, run);
            for (sum, mut estimator) in sums.iter_mut().zip(fresh()) {
                add_errors(sum, estimator.as_mut(), &measured, &truth);
            }
        }
        let n = f64::from(runs) * f64::from(self.samples());
        sums.iter()
            .map(|sum| Rms {
                angle_deg: (sum.angle_deg / n).sqrt(),
                rate_deg_s: (sum.rate_deg_s / n).sqrt(),
            })
            .collect()
    }
}

/// Adds the squares of one run's errors.
fn add_errors(
    sum: &mut Rms,
    estimator: &mut dyn RateEstimator,
    measured: &[f64],
    truth: &[(f64, f64)],
) {
    for (rate_deg_s, (true_deg, true_deg_s)) in measured.iter().zip(truth) {
        estimator.predict(STEP_S).unwrap();
        estimator.update(*rate_deg_s).unwrap();
        let belief = estimator.belief();
        sum.angle_deg += (belief.angle_rad - true_deg).powi(2);
        sum.rate_deg_s += (belief.rate_rad_s - true_deg_s).powi(2);
    }
}
