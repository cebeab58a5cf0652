//! The torsional rig: closed-form motion of the body model, struck and shaken, and a gyro with
//! bias, noise and outliers.

use super::contestant::{Measured, TrueState};
use super::row::{Column, Row};
use super::tally::{Schedule, Truth};
use anyhow::Result;
use struna_body::{
    Body, BodyParams, DampedTorsion, Torsion, TorsionDamping, TorsionStiffness, reference,
};
use struna_estimator::{AugmentedConfig, StartPrior};
use struna_kernel::{AddressedRandom, Channel, RAD_PER_DEG, Seed};

/// From sample to sample, s.
pub(super) const STEP_S: f64 = 0.01;
/// Samples of a run of that period: all of it.
pub(super) const SAMPLES: u32 = 48_000;
/// Period that estimators are told of unless a case has its own, s.
pub(super) const PERIOD_S: f64 = 480.0;
/// Damping ratio that estimators are told of.
pub(super) const DAMPING_RATIO: f64 = 0.03;
/// R: variance of one measured rate, rad²/s².
pub(super) const R_RAD2_S2: f64 = 2e-3 * RAD_PER_DEG * RAD_PER_DEG;
/// Where the body is let go, deg.
pub(super) const START_DEG: f64 = 360.0;
/// Density of white angular acceleration that estimators reckon with at the least, (deg/s²)²/Hz.
const QUIET_DEG2_S3: f64 = 1e-9;
/// How long a kick that is over may stay unseen: 5 s. Claims of the whole state are not judged
/// until then, for nobody can know of a change of the rate before its test has gathered enough of
/// it: a step of 0.02 deg/s takes 1.1 s in half of the runs and more than 1.9 s in a tenth, and the
/// filter's own memory of the rate is 3 s. Published figures are of the end of a run, at least 20 s
/// after the latest kick.
const SETTLING_SAMPLES: u32 = 500;

/// What is drawn for a run of a body let go at rest at 360°.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ensemble {
    /// Mean period, s; a run lasts so long.
    pub(super) period_s: f64,
    /// Variance of one measured rate, rad²/s².
    pub(super) r_rad2_s2: f64,
    /// Spread of the period, relative.
    pub(super) period_sigma: f64,
    /// Spread of the damping ratio.
    pub(super) damping_ratio_sigma: f64,
    /// Spread of the believed start angle, deg.
    pub(super) start_sigma_deg: f64,
    /// Believed less true start angle, deg, on top of the spread.
    pub(super) start_error_deg: f64,
    /// Spread of the true start rate, deg/s. It is believed to be zero.
    pub(super) start_rate_sigma_deg_s: f64,
    /// Spread of the bias, deg/s.
    pub(super) bias_sigma_deg_s: f64,
    /// Bias on top of the spread, deg/s.
    pub(super) bias_deg_s: f64,
    /// Density of white angular acceleration, (deg/s²)²/Hz.
    pub(super) torque_density_deg2_s3: f64,
    /// Kicks of the body.
    pub(super) kicks: Kicks,
    /// Share of samples with an extra error of 20 sigma.
    pub(super) outlier_share: f64,
}

/// Sudden changes of the rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kicks {
    /// None.
    None,
    /// Three steps at random times, of random sign, 1 to 5 deg/s.
    Three,
    /// One change of the given size, deg/s, spread over a time, s, from a random time on.
    Ramp(f64, f64),
}

impl Ensemble {
    /// The same every time: no spread, no bias, no kick.
    pub(super) const EXACT: Self = Self {
        period_s: PERIOD_S,
        r_rad2_s2: R_RAD2_S2,
        period_sigma: 0.0,
        damping_ratio_sigma: 0.0,
        start_sigma_deg: 0.0,
        start_error_deg: 0.0,
        start_rate_sigma_deg_s: 0.0,
        bias_sigma_deg_s: 0.0,
        bias_deg_s: 0.0,
        torque_density_deg2_s3: 0.0,
        kicks: Kicks::None,
        outlier_share: 0.0,
    };
    /// Scenario A: a good start. Everything that estimators reckon with is drawn as they are told,
    /// the start rate and the little random torque as well: a bound and a claim are averages over
    /// what is believed.
    pub(super) const A: Self = Self {
        period_sigma: 0.01,
        damping_ratio_sigma: 0.01,
        start_sigma_deg: 1.0,
        start_rate_sigma_deg_s: 0.01,
        torque_density_deg2_s3: QUIET_DEG2_S3,
        bias_sigma_deg_s: 0.01,
        ..Self::EXACT
    };
    /// Scenario B: a start known to 100°, a bias known to 0.05 °/s.
    pub(super) const B: Self = Self { start_sigma_deg: 100.0, bias_sigma_deg_s: 0.05, ..Self::A };
    /// Scenario C: B with a random torque.
    pub(super) const C: Self = Self { torque_density_deg2_s3: 1e-4, ..Self::B };
    /// Scenario D: B with three kicks.
    pub(super) const D: Self = Self { kicks: Kicks::Three, ..Self::B };
    /// Scenario E: B with 1 % of outliers.
    pub(super) const E: Self = Self { outlier_share: 0.01, ..Self::B };

    /// Measurements of a run.
    #[must_use]
    pub(super) const fn samples(&self) -> u32 {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "minutes")]
        let samples = (self.period_s / STEP_S + 0.5) as u32;
        samples
    }

    /// What an estimator is told: the ensemble, and nothing of the run but its start angle.
    #[must_use]
    pub(super) fn config(&self, believed_start_deg: f64, r_rad2_s2: f64) -> AugmentedConfig {
        let q_deg2_s3 = self.torque_density_deg2_s3.max(QUIET_DEG2_S3);
        AugmentedConfig {
            start: StartPrior {
                angle_sigma_rad: self.start_sigma_deg.max(0.1) * RAD_PER_DEG,
                bias_sigma_rad_s: self.bias_sigma_deg_s.max(1e-3) * RAD_PER_DEG,
                ..StartPrior::released(believed_start_deg * RAD_PER_DEG, self.period_s)
            },
            process_noise_rad2_s3: q_deg2_s3 * RAD_PER_DEG * RAD_PER_DEG,
            ..AugmentedConfig::quiet(StartPrior::released(0.0, self.period_s), r_rad2_s2)
        }
    }

    /// The part of the run that is the body's: its motion, and what is believed of its start.
    ///
    /// # Errors
    /// When the body model refuses the drawn parameters.
    pub(super) fn draw(&self, seed: Seed, run: u32) -> Result<Drawn> {
        let open = |channel| AddressedRandom::new(seed, channel, u64::from(run));
        let mut draws = open(Channel::StartError);
        let mut n = |k| draws.standard_normal(k);
        let period_s = self.period_s * (1.0 + self.period_sigma * n(1));
        let damping_ratio = (DAMPING_RATIO + self.damping_ratio_sigma * n(2)).max(0.0);
        let bias_rad_s = (self.bias_deg_s + self.bias_sigma_deg_s * n(3)) * RAD_PER_DEG;
        let start_error_deg = self.start_error_deg + self.start_sigma_deg * n(4);
        let start_rate_rad_s = self.start_rate_sigma_deg_s * n(5) * RAD_PER_DEG;
        let stiffness = TorsionStiffness::PeriodS(period_s);
        let torsion = Torsion { stiffness, damping: TorsionDamping::Ratio(damping_ratio) };
        let body = Body::new(&BodyParams { torsion, ..reference::PARAMS })?;
        Ok(Drawn {
            period_s,
            damping_ratio,
            bias_rad_s,
            start_error_deg,
            start_rate_rad_s,
            samples: self.samples(),
            motion: DampedTorsion::new(&body, START_DEG * RAD_PER_DEG, start_rate_rad_s),
            body,
            motion_from: 0,
            kicks: draw_kicks(self.kicks, &mut open(Channel::ImpulseTime)),
            torque: open(Channel::TorqueNoise),
            torque_density_deg2_s3: self.torque_density_deg2_s3,
        })
    }
}

/// The body in one run.
#[derive(Debug, Clone)]
pub(super) struct Drawn {
    period_s: f64,
    damping_ratio: f64,
    bias_rad_s: f64,
    start_error_deg: f64,
    start_rate_rad_s: f64,
    samples: u32,
    body: Body,
    motion: DampedTorsion,
    motion_from: u32,
    kicks: Vec<Kick>,
    torque: AddressedRandom,
    torque_density_deg2_s3: f64,
}

/// A change of the rate in equal parts at the samples `from..to`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Kick {
    from: u32,
    to: u32,
    each_rad_s: f64,
}

impl Drawn {
    /// The start angle that estimators are told, deg.
    #[must_use]
    pub(super) fn believed_start_deg(&self) -> f64 {
        START_DEG + self.start_error_deg
    }

    /// The bias of the run, rad/s.
    #[must_use]
    pub(super) fn bias_rad_s(&self) -> f64 {
        self.bias_rad_s
    }

    /// Length of the run and its first kick.
    #[must_use]
    pub(super) fn schedule(&self) -> Schedule {
        Schedule { samples: self.samples, kick: self.kicks.iter().map(|kick| kick.from).min() }
    }

    /// Writes what was drawn into a row.
    pub(super) fn describe(&self, row: &mut Row) {
        row.set(Column::DurationS, f64::from(self.samples) * STEP_S);
        row.set(Column::PeriodS, self.period_s);
        row.set(Column::DampingRatio, self.damping_ratio);
        row.set(Column::StartAngleDeg, START_DEG);
        row.set(Column::StartErrorDeg, self.start_error_deg);
        row.set(Column::StartRateDegS, self.start_rate_rad_s / RAD_PER_DEG);
        row.set(Column::BiasDegS, self.bias_rad_s / RAD_PER_DEG);
        row.set(Column::TorqueDensityDeg2S3, self.torque_density_deg2_s3);
        row.set(Column::Kicks, self.kicks.len() as f64);
        if let Some(kick) = self.kicks.iter().min_by_key(|kick| kick.from) {
            let samples = f64::from(kick.to - kick.from);
            row.set(Column::KickDegS, samples * kick.each_rad_s / RAD_PER_DEG);
            row.set(Column::KickOverS, if samples > 1.0 { samples * STEP_S } else { 0.0 });
            row.set(Column::KickAtS, f64::from(kick.from) * STEP_S);
        }
    }

    /// The true motion at sample `k`, to be asked for in order from 0.
    pub(super) fn truth(&mut self, k: u32) -> Truth {
        let (angle_rad, mut rate_rad_s) = self.motion_between(f64::from(k));
        let change_rad_s = self.change_rad_s(k);
        if change_rad_s != 0.0 {
            rate_rad_s += change_rad_s;
            self.motion = DampedTorsion::new(&self.body, angle_rad, rate_rad_s);
            self.motion_from = k;
        }
        let axial_kg_m2 = self.body.params().inertia_kg_m2[2];
        let struck = |kick: &Kick| (kick.from..=kick.to + SETTLING_SAMPLES).contains(&k);
        Truth {
            state: TrueState {
                angle_rad,
                rate_rad_s,
                s: self.body.stiffness_n_m_rad() / axial_kg_m2,
                d: self.body.damping_n_m_s_rad() / axial_kg_m2,
                bias_rad_s: self.bias_rad_s,
            },
            settled: !self.kicks.iter().any(struck),
        }
    }

    /// Angle, rad, and rate, rad/s, at any place between the last sample asked for and the next;
    /// places are in samples.
    #[must_use]
    pub(super) fn motion_between(&self, place: f64) -> (f64, f64) {
        let since_s = (place - f64::from(self.motion_from)) * STEP_S;
        (self.motion.twist_rad(since_s), self.motion.twist_rate_rad_s(since_s))
    }

    /// What kicks and random torque add to the rate at sample `k`.
    fn change_rad_s(&mut self, k: u32) -> f64 {
        let struck = self.kicks.iter().filter(|kick| (kick.from..kick.to).contains(&k));
        let mut change_rad_s: f64 = struck.map(|kick| kick.each_rad_s).sum();
        if self.torque_density_deg2_s3 > 0.0 && k > 0 {
            let sigma_rad_s = (self.torque_density_deg2_s3 * STEP_S).sqrt() * RAD_PER_DEG;
            change_rad_s += sigma_rad_s * self.torque.standard_normal(u64::from(k));
        }
        change_rad_s
    }
}

fn draw_kicks(kicks: Kicks, random: &mut AddressedRandom) -> Vec<Kick> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below 46 000")]
    let time = |random: &mut AddressedRandom, k| 2_000 + (44_000.0 * random.uniform(k)) as u32;
    match kicks {
        Kicks::None => Vec::new(),
        Kicks::Three => (0..3)
            .map(|k| {
                let from = time(random, 3 * k);
                let size_deg_s = 1.0 + 4.0 * random.uniform(3 * k + 1);
                let sign = if random.uniform(3 * k + 2) < 0.5 { -1.0 } else { 1.0 };
                Kick { from, to: from + 1, each_rad_s: sign * size_deg_s * RAD_PER_DEG }
            })
            .collect(),
        Kicks::Ramp(size_deg_s, over_s) => {
            let from = time(random, 0);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "some seconds of samples"
            )]
            let steps = ((over_s / STEP_S).round() as u32).max(1);
            let each_rad_s = size_deg_s * RAD_PER_DEG / f64::from(steps);
            vec![Kick { from, to: from + steps, each_rad_s }]
        }
    }
}

/// An ideal gyro: bias, white noise, outliers.
#[derive(Debug, Clone)]
pub(super) struct WhiteGyro {
    bias_rad_s: f64,
    sigma_rad_s: f64,
    outlier_share: f64,
    noise: AddressedRandom,
    outliers: AddressedRandom,
}

impl WhiteGyro {
    /// The gyro of a run.
    #[must_use]
    pub(super) fn new(ensemble: &Ensemble, drawn: &Drawn, seed: Seed, run: u32) -> Self {
        let open = |channel| AddressedRandom::new(seed, channel, u64::from(run));
        Self {
            bias_rad_s: drawn.bias_rad_s,
            sigma_rad_s: ensemble.r_rad2_s2.sqrt(),
            outlier_share: ensemble.outlier_share,
            noise: open(Channel::GyroAngleRandomWalk),
            outliers: open(Channel::ImpulseSize),
        }
    }

    /// What it says at sample `k` of a true rate.
    pub(super) fn measure(&mut self, k: u32, rate_rad_s: f64) -> Measured {
        let k = u64::from(k);
        let mut noise = self.noise.standard_normal(k);
        if self.outlier_share > 0.0 && self.outliers.uniform(2 * k) < self.outlier_share {
            noise += 20.0 * self.outliers.standard_normal(2 * k + 1);
        }
        let rate_rad_s = rate_rad_s + self.bias_rad_s + self.sigma_rad_s * noise;
        Measured::new(STEP_S, rate_rad_s)
    }
}
