//! True motion and measured rates of a run.

use crate::slip::SlipMotion;
use struna_body::{
    Body, BodyParams, Hysteresis, Integrator, Rig, StartState, Torsion, TorsionDamping,
    TorsionStiffness, TruthMotion, YieldElement, YieldLaw, reference,
};
use struna_estimator::{AugmentedConfig, HysteresisBank, StartPrior};
use struna_kernel::{AddressedRandom, Channel, RAD_PER_DEG, SampleGrid, Seed, SimTime};

pub(crate) const STEP_S: f64 = 0.01;
pub(crate) const SAMPLES: u32 = 48_000;
pub(crate) const PERIOD_S: f64 = 480.0;
pub(crate) const START_DEG: f64 = 360.0;
/// Stiffness of the friction before it yields over the thread's.
pub(crate) const STIFFNESS_RATIO: f64 = 10.0;
const R_RAD2_S2: f64 = 2e-3 * RAD_PER_DEG * RAD_PER_DEG;
const SEED: Seed = Seed(19_680_125);

/// The friction in the thread; yield angles in degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Thread {
    Linear,
    /// One element after Dahl.
    Dahl(f64),
    /// Six that slip one after another, at 0.2 to 1.8 of the mean strain.
    SixSlips(f64),
}

/// Strains at which the six elements slip, over their mean.
pub(crate) const SIX: [f64; 6] = [0.2, 0.52, 0.84, 1.16, 1.48, 1.8];

/// One run's truth.
pub(crate) struct Run {
    motion: Motion,
    grid: SampleGrid,
    bias_rad_s: f64,
    noise: AddressedRandom,
    pub(crate) believed_start_deg: f64,
}

enum Motion {
    Body(Box<TruthMotion>),
    Slip(SlipMotion),
}

/// Truth at a sample, and what the gyro says.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sample {
    pub(crate) angle_rad: f64,
    pub(crate) measured_rad_s: f64,
}

/// The reference body on a thread with elements of a stiffness, over the thread's, and a yield
/// strain, deg.
pub(crate) fn body_rig(
    period_s: f64,
    damping_ratio: f64,
    law: YieldLaw,
    elements: &[(f64, f64)],
) -> Rig {
    let torsion = Torsion {
        stiffness: TorsionStiffness::PeriodS(period_s),
        damping: TorsionDamping::Ratio(damping_ratio),
    };
    let body = Body::new(&BodyParams { torsion, ..reference::PARAMS }).unwrap();
    let element = |&(ratio, yield_deg): &(f64, f64)| YieldElement {
        stiffness_n_m_rad: ratio * body.stiffness_n_m_rad(),
        yield_rad: yield_deg * RAD_PER_DEG,
    };
    let elements: Vec<_> = elements.iter().map(element).collect();
    let hysteresis = (!elements.is_empty()).then_some(Hysteresis { law, elements });
    Rig { hysteresis, ..Rig::from(body) }
}

/// Motion from rest on a relaxed thread. Steps of 10 ms hold 1e-6 rad over these runs, a thousandth
/// of what is asked for.
pub(crate) fn body_motion(rig: Rig) -> TruthMotion {
    let start = StartState::twisted(START_DEG * RAD_PER_DEG, 0.0);
    TruthMotion::new(rig, &start, Integrator::Rk4 { step_s: STEP_S }).unwrap()
}

impl Run {
    pub(crate) fn new(thread: Thread, run: u32) -> Self {
        let mut draws = AddressedRandom::new(SEED, Channel::StartError, u64::from(run));
        let mut n = |k| draws.standard_normal(k);
        let period_s = PERIOD_S * (1.0 + 0.01 * n(1));
        let ratio = (0.01 + 0.003 * n(2)).max(0.0);
        let body = |elements: &[(f64, f64)]| {
            let rig = body_rig(period_s, ratio, YieldLaw::Dahl, elements);
            Motion::Body(Box::new(body_motion(rig)))
        };
        let motion = match thread {
            Thread::Linear => body(&[]),
            Thread::Dahl(yield_deg) => body(&[(STIFFNESS_RATIO, yield_deg / STIFFNESS_RATIO)]),
            Thread::SixSlips(yield_deg) => {
                let of = |share: f64| (STIFFNESS_RATIO / 6.0, share * yield_deg / STIFFNESS_RATIO);
                Motion::Slip(SlipMotion::new(period_s, ratio, &SIX.map(of)))
            }
        };
        Self {
            motion,
            grid: SampleGrid::new(SimTime::ZERO, 1.0 / STEP_S).unwrap(),
            bias_rad_s: 0.05 * n(3) * RAD_PER_DEG,
            noise: AddressedRandom::new(SEED, Channel::GyroAngleRandomWalk, u64::from(run)),
            believed_start_deg: START_DEG + 100.0 * n(4),
        }
    }

    /// Sample `k`, to be asked for in order from 1.
    pub(crate) fn sample(&mut self, k: u32) -> Sample {
        let (angle_rad, rate_rad_s) = match &mut self.motion {
            Motion::Body(motion) => {
                let motion = motion.motion_at(self.grid.time_of(u64::from(k))).unwrap();
                (motion.twist_rad, motion.twist_rate_rad_s)
            }
            Motion::Slip(slip) => slip.step(STEP_S),
        };
        let noise = R_RAD2_S2.sqrt() * self.noise.standard_normal(u64::from(k));
        Sample { angle_rad, measured_rad_s: rate_rad_s + self.bias_rad_s + noise }
    }

    /// Strikes the body; only one on six slips can be struck.
    pub(crate) fn kick(&mut self, change_rad_s: f64) {
        match &mut self.motion {
            Motion::Body(_) => unreachable!("the body model is struck by its own disturbances"),
            Motion::Slip(slip) => slip.kick(change_rad_s),
        }
    }

    /// What the estimators are told: what these runs have in common, and nothing of this one.
    pub(crate) fn config(&self) -> AugmentedConfig {
        config(self.believed_start_deg)
    }

    pub(crate) fn bank(&self) -> HysteresisBank {
        HysteresisBank::new(&self.config()).unwrap()
    }
}

/// The runs' prior about a start angle.
pub(crate) fn config(start_deg: f64) -> AugmentedConfig {
    let start = StartPrior {
        damping_ratio: 0.01,
        damping_ratio_sigma: 0.003,
        ..StartPrior::released(start_deg * RAD_PER_DEG, PERIOD_S)
    };
    AugmentedConfig::quiet(start, R_RAD2_S2)
}
