//! True motion and measured rates of a run: closed-form torsion of the body model, struck and
//! shaken, and a gyro with bias, noise and outliers. Nothing here is the filter's.

use struna_body::{
    Body, BodyParams, DampedTorsion, Torsion, TorsionDamping, TorsionStiffness, reference,
};
use struna_estimator::{
    AugmentedConfig, GyroRange, InnovationTest, StartPrior, TestedFilter,
    measurement_variance_from_rest,
};
use struna_kernel::{AddressedRandom, Channel, RAD_PER_DEG, Seed};

pub(crate) const STEP_S: f64 = 0.01;
pub(crate) const SAMPLES: u32 = 48_000;
pub(crate) const PERIOD_S: f64 = 480.0;
pub(crate) const DAMPING_RATIO: f64 = 0.03;
pub(crate) const R_RAD2_S2: f64 = 2e-3 * RAD_PER_DEG * RAD_PER_DEG;
const SEED: Seed = Seed(20_080_480);

/// What a scenario adds to the motion of a body let go at rest at 360°.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scenario {
    /// Spread of the start angle, deg.
    pub(crate) start_sigma_deg: f64,
    /// Spread of the start rate, deg/s. The filter believes 0.01 in any case.
    pub(crate) rate_sigma_deg_s: f64,
    /// Spread of the bias, deg/s.
    pub(crate) bias_sigma_deg_s: f64,
    /// Density of white angular acceleration, (deg/s²)²/Hz.
    pub(crate) acceleration_density_deg2_s3: f64,
    pub(crate) kicks: Kicks,
    /// Share of samples with an extra error of 20 sigma.
    pub(crate) outliers: f64,
    pub(crate) flaw: Flaw,
    /// Whether the filter is told of the flaw.
    pub(crate) told: bool,
}

/// What is wrong with the gyro besides bias and white noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Flaw {
    None,
    /// Noise of the same variance in which each sample holds this share of the one before.
    Coloured(f64),
    /// Rates clipped at this size, deg/s.
    Clipped(f64),
    /// A scale factor wrong by this standard deviation.
    ScaleFactor(f64),
}

/// Sudden changes of the rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Kicks {
    None,
    /// Three steps at random times, of random sign, 1 to 5 deg/s.
    Three,
    /// One change of the given size, deg/s, spread over a time, s, from a random time on.
    Ramp(f64, f64),
}

pub(crate) const A: Scenario = Scenario {
    start_sigma_deg: 1.0,
    rate_sigma_deg_s: 0.0,
    bias_sigma_deg_s: 0.01,
    acceleration_density_deg2_s3: 0.0,
    kicks: Kicks::None,
    outliers: 0.0,
    flaw: Flaw::None,
    told: true,
};
pub(crate) const B: Scenario = Scenario { start_sigma_deg: 100.0, bias_sigma_deg_s: 0.05, ..A };
pub(crate) const C: Scenario = Scenario { acceleration_density_deg2_s3: 1e-4, ..B };
pub(crate) const D: Scenario = Scenario { kicks: Kicks::Three, ..B };
pub(crate) const E: Scenario = Scenario { outliers: 0.01, ..B };

impl Scenario {
    /// The filter's model, told what the scenario's ensemble is and nothing of the run.
    pub(crate) fn config(&self, start_deg: f64) -> AugmentedConfig {
        let q_deg2_s3 = self.acceleration_density_deg2_s3.max(1e-9);
        let mut config = AugmentedConfig {
            start: StartPrior {
                angle_sigma_rad: self.start_sigma_deg.max(0.1) * RAD_PER_DEG,
                bias_sigma_rad_s: self.bias_sigma_deg_s.max(1e-3) * RAD_PER_DEG,
                ..StartPrior::released(start_deg * RAD_PER_DEG, PERIOD_S)
            },
            process_noise_rad2_s3: q_deg2_s3 * RAD_PER_DEG * RAD_PER_DEG,
            ..AugmentedConfig::quiet(StartPrior::released(0.0, PERIOD_S), R_RAD2_S2)
        };
        match self.flaw {
            _ if !self.told => {}
            Flaw::None => {}
            Flaw::Coloured(_) => {
                let record = Rig::new(*self, u32::MAX).record_at_rest(20_000);
                config.measurement_variance_rad2_s2 =
                    measurement_variance_from_rest(&record).unwrap();
            }
            Flaw::Clipped(at_deg_s) => {
                let limit_rad_s = at_deg_s * RAD_PER_DEG;
                config.range = Some(GyroRange::with_raw_sigma(limit_rad_s, R_RAD2_S2.sqrt()));
            }
            Flaw::ScaleFactor(sigma) => config.scale_factor_sigma = sigma,
        }
        config
    }

    pub(crate) fn filter(&self, rig: &Rig) -> TestedFilter {
        TestedFilter::new(&self.config(rig.believed_start_deg), &InnovationTest::STANDARD).unwrap()
    }
}

/// One run's truth.
pub(crate) struct Rig {
    scenario: Scenario,
    body: Body,
    motion: DampedTorsion,
    motion_from: u32,
    pub(crate) bias_rad_s: f64,
    /// True scale factor minus one.
    scale_error: f64,
    pub(crate) believed_start_deg: f64,
    /// Instants of the kicks in samples, and the change of the rate at each sample of it.
    kicks: Vec<(u32, u32, f64)>,
    noise: AddressedRandom,
    torque: AddressedRandom,
    outliers: AddressedRandom,
}

/// Truth at a sample, and what the gyro says.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sample {
    pub(crate) angle_rad: f64,
    pub(crate) rate_rad_s: f64,
    pub(crate) measured_rad_s: f64,
}

impl Rig {
    pub(crate) fn new(scenario: Scenario, run: u32) -> Self {
        let open = |channel| AddressedRandom::new(SEED, channel, u64::from(run));
        let mut draws = open(Channel::StartError);
        let mut n = |k| draws.standard_normal(k);
        let period_s = PERIOD_S * (1.0 + 0.01 * n(1));
        let ratio = (DAMPING_RATIO + 0.01 * n(2)).max(0.0);
        let torsion = Torsion {
            stiffness: TorsionStiffness::PeriodS(period_s),
            damping: TorsionDamping::Ratio(ratio),
        };
        let body = Body::new(&BodyParams { torsion, ..reference::PARAMS }).unwrap();
        Self {
            motion: DampedTorsion::new(
                &body,
                360.0 * RAD_PER_DEG,
                scenario.rate_sigma_deg_s * n(5) * RAD_PER_DEG,
            ),
            motion_from: 0,
            bias_rad_s: scenario.bias_sigma_deg_s * n(3) * RAD_PER_DEG,
            scale_error: match scenario.flaw {
                Flaw::ScaleFactor(sigma) => sigma * n(6),
                _ => 0.0,
            },
            believed_start_deg: 360.0 + scenario.start_sigma_deg * n(4),
            kicks: kicks(scenario.kicks, &mut open(Channel::ImpulseTime)),
            noise: open(Channel::GyroAngleRandomWalk),
            torque: open(Channel::TorqueNoise),
            outliers: open(Channel::ImpulseSize),
            scenario,
            body,
        }
    }

    /// First sample at which the first kick shows.
    pub(crate) fn first_kick(&self) -> Option<u32> {
        self.kicks().map(|kick| kick.0).min()
    }

    /// First sample at which each kick shows, and the change of the rate at it.
    pub(crate) fn kicks(&self) -> impl Iterator<Item = (u32, f64)> {
        self.kicks.iter().map(|kick| (kick.0, kick.2))
    }

    /// Whether a kick began at most `samples` before sample `k`.
    pub(crate) fn is_struck_within(&self, k: u32, samples: u32) -> bool {
        self.kicks.iter().any(|kick| (kick.0..=kick.0 + samples).contains(&k))
    }

    /// (s, d) of the true oscillator.
    pub(crate) fn parameters(&self) -> (f64, f64) {
        let axial_kg_m2 = self.body.params().inertia_kg_m2[2];
        (self.body.stiffness_n_m_rad() / axial_kg_m2, self.body.damping_n_m_s_rad() / axial_kg_m2)
    }

    /// Sample `k`, to be asked for in order from 1.
    pub(crate) fn sample(&mut self, k: u32) -> Sample {
        let since_s = f64::from(k - self.motion_from) * STEP_S;
        let angle_rad = self.motion.twist_rad(since_s);
        let mut rate_rad_s = self.motion.twist_rate_rad_s(since_s);
        let change_rad_s = self.change_rad_s(k);
        if change_rad_s != 0.0 {
            rate_rad_s += change_rad_s;
            self.motion = DampedTorsion::new(&self.body, angle_rad, rate_rad_s);
            self.motion_from = k;
        }
        let measured_rad_s = self.measured_rad_s(k, rate_rad_s);
        Sample { angle_rad, rate_rad_s, measured_rad_s }
    }

    fn measured_rad_s(&mut self, k: u32, rate_rad_s: f64) -> f64 {
        let scaled_rad_s = rate_rad_s * (1.0 + self.scale_error);
        let measured_rad_s = scaled_rad_s + self.bias_rad_s + R_RAD2_S2.sqrt() * self.noise(k);
        match self.scenario.flaw {
            Flaw::Clipped(at_deg_s) => {
                let limit_rad_s = at_deg_s * RAD_PER_DEG;
                measured_rad_s.clamp(-limit_rad_s, limit_rad_s)
            }
            _ => measured_rad_s,
        }
    }

    /// Noise of variance 1, outliers apart.
    fn noise(&mut self, k: u32) -> f64 {
        let k = u64::from(k);
        let mut noise = self.noise.standard_normal(k);
        if let Flaw::Coloured(share) = self.scenario.flaw {
            let before = self.noise.standard_normal(k - 1);
            noise = (noise + share * before) / (1.0 + share * share).sqrt();
        }
        let share = self.scenario.outliers;
        if share > 0.0 && self.outliers.uniform(2 * k) < share {
            noise += 20.0 * self.outliers.standard_normal(2 * k + 1);
        }
        noise
    }

    /// What the gyro says while the body rests.
    fn record_at_rest(&mut self, samples: u32) -> Vec<f64> {
        (1..=samples).map(|k| self.measured_rad_s(k, 0.0)).collect()
    }

    /// What kicks and torque noise add to the rate at sample `k`.
    fn change_rad_s(&mut self, k: u32) -> f64 {
        let struck = self.kicks.iter().filter(|(from, to, _)| (*from..*to).contains(&k));
        let mut change_rad_s: f64 = struck.map(|kick| kick.2).sum();
        let q = self.scenario.acceleration_density_deg2_s3;
        if q > 0.0 {
            let sigma_rad_s = (q * STEP_S).sqrt() * RAD_PER_DEG;
            change_rad_s += sigma_rad_s * self.torque.standard_normal(u64::from(k));
        }
        change_rad_s
    }
}

/// First sample, sample after the last, and change of the rate at each, for every kick.
fn kicks(kicks: Kicks, random: &mut AddressedRandom) -> Vec<(u32, u32, f64)> {
    let time = |random: &mut AddressedRandom, k| 2_000 + (44_000.0 * random.uniform(k)) as u32;
    match kicks {
        Kicks::None => Vec::new(),
        Kicks::Three => (0..3)
            .map(|k| {
                let from = time(random, 3 * k);
                let size_deg_s = 1.0 + 4.0 * random.uniform(3 * k + 1);
                let sign = if random.uniform(3 * k + 2) < 0.5 { -1.0 } else { 1.0 };
                (from, from + 1, sign * size_deg_s * RAD_PER_DEG)
            })
            .collect(),
        Kicks::Ramp(size_deg_s, over_s) => {
            let from = time(random, 0);
            let steps = ((over_s / STEP_S).round() as u32).max(1);
            vec![(from, from + steps, size_deg_s * RAD_PER_DEG / f64::from(steps))]
        }
    }
}
