//! A body, a gyro askew on it, what is believed of both, and the trace that an estimator leaves.

use crate::swinging::{self, DAMPING_RATIO, INERTIA_KG_M2};
use nalgebra::Vector3;
use std::f64::consts::TAU;
use struna_body::{Hysteresis, Impulse, Integrator, Rig, TruthMotion, YieldElement, YieldLaw};
use struna_estimator::{
    AugmentedConfig, LiveConfig, LiveEstimator, RateEstimator, StartPrior, Status, SwingConfig,
};
use struna_kernel::{Channel, RAD_PER_DEG, RandomStream, Seed, SimTime};

/// Sample period, s.
pub(crate) const STEP_S: f64 = 0.01;
/// Variance of a sample, rad²/s²: 2e-3 (°/s)².
pub(crate) const R_RAD2_S2: f64 = 2e-3 * RAD_PER_DEG * RAD_PER_DEG;

/// What a run is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Case {
    /// Swing at the start, deg, on an ellipse of this ratio of its axes.
    pub(crate) swing_deg: f64,
    pub(crate) ratio: f64,
    /// Angle between the gyro's axis and the body's, deg.
    pub(crate) askew_deg: f64,
    pub(crate) seconds: u32,
    pub(crate) torsion_s: f64,
    /// Decay of the swing, 1/s. The air that does it brakes the twist as well.
    pub(crate) decay_1_s: f64,
    /// A blow: when, s, and what it adds to the three body rates, deg/s.
    pub(crate) blow: Option<(f64, [f64; 3])>,
    /// Angle at which the thread yields, deg.
    pub(crate) yields_deg: Option<f64>,
    pub(crate) seed: u64,
}

impl Case {
    /// Released at one turn of twist, T = 120 s, without swing.
    pub(crate) const STILL: Self = Self {
        swing_deg: 0.0,
        ratio: 0.0,
        askew_deg: 1.0,
        seconds: 120,
        torsion_s: 120.0,
        decay_1_s: 1e-3,
        blow: None,
        yields_deg: None,
        seed: 1,
    };
}

/// Truth and measurement at every sample, and what is believed beforehand.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) twist_rad: Vec<f64>,
    pub(crate) measured_rad_s: Vec<f64>,
    pub(crate) config: LiveConfig,
}

impl Run {
    pub(crate) fn of(case: &Case) -> Self {
        let mut draws = RandomStream::new(Seed(case.seed), Channel::StartError, 0);
        let (azimuth, axis_azimuth) = (TAU * draws.uniform(), TAU * draws.uniform());
        let normal: [f64; 6] = std::array::from_fn(|_| draws.standard_normal());
        let bias_rad_s = 0.01 * RAD_PER_DEG * normal[0];
        let (tilt, along) = (case.askew_deg * RAD_PER_DEG).sin_cos();
        let across = [tilt * axis_azimuth.cos(), tilt * axis_azimuth.sin()];
        let axis = Vector3::new(across[0], across[1], along);
        let start = swinging::start(case.swing_deg * RAD_PER_DEG, azimuth, case.ratio);
        let mut motion =
            TruthMotion::new(rig(case), &start, Integrator::Rk4 { step_s: 2e-3 }).unwrap();
        let mut noise = RandomStream::new(Seed(case.seed), Channel::GyroAngleRandomWalk, 0);
        let (mut twist_rad, mut measured_rad_s) = (Vec::new(), Vec::new());
        for k in 1..=100 * case.seconds {
            let motion = motion.motion_at(SimTime::from_s(f64::from(k) * STEP_S).unwrap()).unwrap();
            let white = R_RAD2_S2.sqrt() * noise.standard_normal();
            measured_rad_s.push(axis.dot(&motion.omega_wb_b_rad_s) + bias_rad_s + white);
            twist_rad.push(motion.twist_rad);
        }
        Self { twist_rad, measured_rad_s, config: config(case, across, &normal) }
    }

    pub(crate) fn estimator(&self) -> LiveEstimator {
        LiveEstimator::new(&self.config).unwrap()
    }

    /// The trace of an estimator over the whole run.
    pub(crate) fn trace(&self, estimator: &mut dyn RateEstimator) -> Trace {
        let mut trace = Trace::default();
        for (measured_rad_s, twist_rad) in self.measured_rad_s.iter().zip(&self.twist_rad) {
            estimator.predict(STEP_S).unwrap();
            estimator.update(*measured_rad_s).unwrap();
            trace.note(estimator, *twist_rad);
        }
        trace
    }
}

/// What the thread and the air take from the twist, as one damping ratio.
fn damping_ratio(case: &Case) -> f64 {
    let air =
        0.5 * swinging::air_n_m_s_rad(case.decay_1_s) / INERTIA_KG_M2[2] * case.torsion_s / TAU;
    DAMPING_RATIO.max(air)
}

fn rig(case: &Case) -> Rig {
    let mut rig = swinging::rig(case.torsion_s, damping_ratio(case), case.decay_1_s);
    let stiffness_n_m_rad = rig.body.stiffness_n_m_rad();
    rig.hysteresis = case.yields_deg.map(|yields_deg| Hysteresis {
        law: YieldLaw::Dahl,
        elements: vec![YieldElement {
            stiffness_n_m_rad: 10.0 * stiffness_n_m_rad,
            yield_rad: 0.1 * yields_deg * RAD_PER_DEG,
        }],
    });
    rig.disturbances.impulses.extend(case.blow.map(|(time_s, rates_deg_s)| Impulse {
        time: SimTime::from_s(time_s).unwrap(),
        angular_b_n_m_s: std::array::from_fn(|i| INERTIA_KG_M2[i] * rates_deg_s[i] * RAD_PER_DEG),
        linear_w_n_s: [0.0; 3],
    }));
    rig
}

/// What the gyro of the run's declared axis reads of the body's rate is cos ε of it.
pub(crate) fn gain_of(run: &Run) -> f64 {
    let [x, y] = run.config.swing.unwrap().axis.tilt_b_rad;
    1.0 / (1.0 - x * x - y * y).sqrt()
}

/// What is believed: a start within 8°, a bias of 0 ± 0.01 °/s, a misalignment known to 0.1° per
/// axis, moments wrong by 1 % and 0.5 %.
fn config(case: &Case, across: [f64; 2], normal: &[f64; 6]) -> LiveConfig {
    let axis = swinging::believed_axis(across, [normal[1], normal[2]]);
    let body = swinging::believed_body(case.decay_1_s);
    let ratio = damping_ratio(case);
    let start = StartPrior {
        angle_rad: TAU + 8.0 * RAD_PER_DEG * normal[3],
        angle_sigma_rad: 8.0 * RAD_PER_DEG,
        period_s: case.torsion_s * (1.0 + 0.01 * normal[4]),
        damping_ratio: ratio * (1.0 + 0.1 * normal[5]),
        damping_ratio_sigma: 0.1 * ratio,
        bias_sigma_rad_s: 0.01 * RAD_PER_DEG,
        ..StartPrior::released(TAU, case.torsion_s)
    };
    let torsion = AugmentedConfig::quiet(start, R_RAD2_S2);
    let swing = SwingConfig::quiet(body, axis, start, R_RAD2_S2);
    LiveConfig { swing: Some(swing), ..LiveConfig::new(torsion, STEP_S) }
}

/// What an estimator showed, sample by sample.
#[derive(Debug, Default)]
pub(crate) struct Trace {
    pub(crate) status: Vec<Status>,
    pub(crate) error_rad: Vec<f64>,
    pub(crate) sigma_rad: Vec<f64>,
}

impl Trace {
    pub(crate) fn note(&mut self, estimator: &dyn RateEstimator, twist_rad: f64) {
        let belief = estimator.belief();
        let sigma_rad = belief.covariance.angle_rad2.sqrt();
        assert!(belief.angle_rad.is_finite() && sigma_rad.is_finite(), "{belief:?}");
        self.status.push(estimator.status());
        self.error_rad.push(belief.angle_rad - twist_rad);
        self.sigma_rad.push(sigma_rad);
    }

    /// Largest error in units of the claim among the samples whose status counts, and how many
    /// they are.
    pub(crate) fn worst_sigmas(&self, counts: impl Fn(&Status) -> bool) -> (f64, usize) {
        let all = self.error_rad.iter().zip(&self.sigma_rad).zip(&self.status);
        let counted = all.filter(|(_, status)| counts(status));
        let sigmas = counted.map(|((error_rad, sigma_rad), _)| (error_rad / sigma_rad).abs());
        sigmas.fold((0.0, 0), |(worst, count), sigmas| (sigmas.max(worst), count + 1))
    }

    /// RMS error from `from_s` on, deg.
    pub(crate) fn rms_deg(&self, from_s: usize) -> f64 {
        let errors = &self.error_rad[100 * from_s..];
        let squares: f64 = errors.iter().map(|error_rad| error_rad * error_rad).sum();
        (squares / errors.len() as f64).sqrt() / RAD_PER_DEG
    }

    /// The statuses in the order of their coming, each with the second at which it came, numbers
    /// within them left out.
    pub(crate) fn announced(&self) -> Vec<(usize, &'static str)> {
        let mut announced: Vec<(usize, &'static str)> = Vec::new();
        for (k, status) in self.status.iter().enumerate() {
            let name = name(status);
            if announced.last().is_none_or(|(_, last)| *last != name) {
                announced.push((k / 100, name));
            }
        }
        announced
    }

    /// Second at which a status of this name was first shown.
    pub(crate) fn first_s(&self, of: &str) -> Option<usize> {
        self.announced().into_iter().find(|(_, name)| *name == of).map(|(second, _)| second)
    }
}

pub(crate) fn name(status: &Status) -> &'static str {
    match status {
        Status::Nominal => "nominal",
        Status::Swinging { .. } => "swinging",
        Status::Fitting { .. } => "fitting",
        Status::Disturbed { .. } => "disturbed",
        Status::ModelDoubtful => "doubtful",
        Status::ThreadYields { .. } => "yields",
        Status::NotObservable => "unseen",
        _ => "other",
    }
}
