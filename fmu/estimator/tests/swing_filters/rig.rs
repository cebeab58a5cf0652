//! The true motion of a swinging body, what gyros on it say, and what the filters are told.

use std::f64::consts::TAU;
use struna_body::{
    Body, BodyParams, Drag, Integrator, Rig, StartState, Torsion, TorsionDamping, TorsionStiffness,
    TruthMotion,
};
use struna_estimator::{InputAxis, MotionState, SWING_STATES, StartPrior, SwingBody, SwingConfig};
use struna_kernel::{AddressedRandom, Channel, RAD_PER_DEG, Seed, SimTime};

pub(crate) const STEP_S: f64 = 0.01;
pub(crate) const STEP_NS: i64 = 10_000_000;
pub(crate) const SAMPLES: u32 = 24_000;
pub(crate) const PERIOD_S: f64 = 120.0;
pub(crate) const R_RAD2_S2: f64 = 2e-3 * RAD_PER_DEG * RAD_PER_DEG;
const DAMPING_RATIO: f64 = 0.06;
/// What the filters believe of A and B over the truth.
const BELIEVED_INERTIA: [f64; 2] = [1.01, 0.995];
/// Decay of the swing, true and believed, 1/s.
const SWING_DECAY_1_S: f64 = 2e-3;
const INERTIA_KG_M2: [f64; 3] = [0.0100, 0.0105, 0.0100];
const SEED: Seed = Seed(20_080_120);

/// What the filters believe of the body.
pub(crate) const BODY: SwingBody = SwingBody {
    mass_kg: 1.0,
    com_depth_m: 0.1,
    inertia_kg_m2: [
        INERTIA_KG_M2[0] * BELIEVED_INERTIA[0],
        INERTIA_KG_M2[1] * BELIEVED_INERTIA[1],
        INERTIA_KG_M2[2],
    ],
    gravity_m_s2: 9.81,
    swing_damping_1_s: SWING_DECAY_1_S,
};

/// How a run differs from the others.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scenario {
    /// Amplitude of the swing, deg.
    pub(crate) swing_deg: f64,
    /// A kick: sample at which it is felt, and change of the three rates, deg/s.
    pub(crate) kick: Option<(u32, [f64; 3])>,
}

impl Scenario {
    pub(crate) const fn swing(swing_deg: f64) -> Self {
        Self { swing_deg, kick: None }
    }
}

/// Truth at a sample, and what the gyros say.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sample {
    pub(crate) motion: MotionState,
    pub(crate) twist_rate_rad_s: f64,
    /// What the gyro of one axis says, rad/s.
    pub(crate) measured_rad_s: f64,
    /// What the gyro of three axes says, rad/s.
    pub(crate) rates_rad_s: [f64; 3],
}

/// One run's truth.
pub(crate) struct Truth {
    motion: TruthMotion,
    /// Sample that the motion now running started at.
    from: u32,
    kick: Option<(u32, [f64; 3])>,
    rig: Rig,
    period_s: f64,
    ratio: f64,
    biases_rad_s: [f64; 3],
    axis: [f64; 2],
    noise: [AddressedRandom; 3],
    draws: AddressedRandom,
}

impl Truth {
    pub(crate) fn new(scenario: Scenario, run: u32) -> Self {
        let open = |channel| AddressedRandom::new(SEED, channel, u64::from(run));
        let mut draws = open(Channel::StartError);
        let mut n = |k| draws.standard_normal(k);
        let period_s = PERIOD_S * (1.0 + 0.01 * n(1));
        let ratio = DAMPING_RATIO + 0.005 * n(2);
        let biases_rad_s = [3, 4, 5].map(|k| 0.05 * RAD_PER_DEG * n(k));
        let axis_error = [6, 7].map(|k| 0.1 * RAD_PER_DEG * n(k));
        let calibrated = axis().tilt_b_rad;
        let rig = rig(period_s, ratio);
        let start = start(scenario.swing_deg, &mut draws);
        Self {
            motion: TruthMotion::new(rig.clone(), &start, integrator()).unwrap(),
            from: 0,
            kick: scenario.kick,
            rig,
            period_s,
            ratio,
            biases_rad_s,
            axis: [calibrated[0] + axis_error[0], calibrated[1] + axis_error[1]],
            noise: [
                open(Channel::GyroAngleRandomWalk),
                open(Channel::TorqueNoise),
                open(Channel::ImpulseSize),
            ],
            draws,
        }
    }

    /// A number of this run, normal with variance 1; the first 20 are the truth's own.
    pub(crate) fn draw(&mut self, index: u64) -> f64 {
        self.draws.standard_normal(index)
    }

    /// Sample `k`, to be asked for in order from 0.
    pub(crate) fn sample(&mut self, k: u32) -> Sample {
        if let Some((at, change_deg_s)) = self.kick.take_if(|(at, _)| *at <= k) {
            self.strike(at, change_deg_s);
        }
        let time = SimTime::from_ns(i64::from(k - self.from) * STEP_NS);
        let truth = self.motion.motion_at(time).unwrap();
        let up_b = truth.q_wb.inverse_transform_vector(&nalgebra::Vector3::z());
        let omega_rad_s: [f64; 3] = truth.omega_wb_b_rad_s.into();
        let motion = MotionState { e: [up_b.x, up_b.y], twist_rad: truth.twist_rad, omega_rad_s };
        let sigma = R_RAD2_S2.sqrt();
        let [x, y] = self.axis;
        let [p, q, r] = omega_rad_s;
        let along = x * p + y * q + (1.0 - x * x - y * y).sqrt() * r;
        let mut noise = |i: usize| sigma * self.noise[i].standard_normal(u64::from(k));
        let rates_rad_s = std::array::from_fn(|i| omega_rad_s[i] + self.biases_rad_s[i] + noise(i));
        Sample {
            motion,
            twist_rate_rad_s: truth.twist_rate_rad_s,
            measured_rad_s: along + self.biases_rad_s[2] + noise(2),
            rates_rad_s,
        }
    }

    /// Changes the rates at sample `k` by starting another motion from there.
    fn strike(&mut self, k: u32, change_deg_s: [f64; 3]) {
        let time = SimTime::from_ns(i64::from(k - self.from) * STEP_NS);
        let truth = self.motion.motion_at(time).unwrap();
        let up_b = truth.q_wb.inverse_transform_vector(&nalgebra::Vector3::z());
        let omega: [f64; 3] = truth.omega_wb_b_rad_s.into();
        let omega = std::array::from_fn(|i| omega[i] + change_deg_s[i] * RAD_PER_DEG);
        let start = hung([up_b.x, up_b.y], truth.twist_rad, omega);
        self.motion = TruthMotion::new(self.rig.clone(), &start, integrator()).unwrap();
        self.from = k;
    }

    /// All that the filter of one axis is to find, at a motion.
    pub(crate) fn states(&self, motion: &MotionState) -> [f64; SWING_STATES] {
        let [s, d, a, b, air] = self.parameters();
        let [x, y, twist, p, q, r] = motion.entries();
        let [g1, g2] = self.axis;
        [x, y, twist, p, q, r, s, d, a, b, air, self.biases_rad_s[2], g1, g2]
    }

    /// Ω², 2ζΩ and the three scales.
    pub(crate) fn parameters(&self) -> [f64; 5] {
        let omega = TAU / self.period_s;
        let [a, b, _] = INERTIA_KG_M2;
        let [believed_a, believed_b] = BELIEVED_INERTIA;
        // The same torque of the air, over that of a decay of believed moments.
        let air = (a + b) / (a * believed_a + b * believed_b);
        [omega * omega, 2.0 * self.ratio * omega, 1.0 / believed_a, 1.0 / believed_b, air]
    }

    pub(crate) fn biases_rad_s(&self) -> [f64; 3] {
        self.biases_rad_s
    }

    /// What the filters are told.
    pub(crate) fn config(&mut self) -> SwingConfig {
        let twist_rad = TAU + 10.0 * RAD_PER_DEG * self.draw(20);
        let start = StartPrior {
            angle_sigma_rad: 10.0 * RAD_PER_DEG,
            rate_sigma_rad_s: RAD_PER_DEG,
            damping_ratio: DAMPING_RATIO,
            ..StartPrior::released(twist_rad, PERIOD_S)
        };
        SwingConfig::quiet(BODY, axis(), start, R_RAD2_S2)
    }

    /// Sample at which a kick is felt, before it is.
    pub(crate) fn kick_at(&self) -> Option<u32> {
        self.kick.map(|(at, _)| at)
    }
}

/// The gyro as calibrated: 1° off towards 40°.
pub(crate) fn axis() -> InputAxis {
    InputAxis::towards(RAD_PER_DEG, 40.0 * RAD_PER_DEG, 0.1 * RAD_PER_DEG)
}

/// RK4 at 5 ms turns the swing by 1e-8 of its phase too little or too much.
fn integrator() -> Integrator {
    Integrator::Rk4 { step_s: 5e-3 }
}

/// The body in air, its torsion damped by string and air together at `ratio`.
fn rig(period_s: f64, ratio: f64) -> Rig {
    let [a, b, c] = INERTIA_KG_M2;
    let rotation_n_m_s_rad = SWING_DECAY_1_S * (a + b);
    let both = 2.0 * ratio * c * TAU / period_s;
    let torsion = Torsion {
        stiffness: TorsionStiffness::PeriodS(period_s),
        damping: TorsionDamping::CoefficientNMSRad(both - rotation_n_m_s_rad),
    };
    let params = BodyParams {
        mass_kg: BODY.mass_kg,
        com_depth_m: BODY.com_depth_m,
        com_offset_m: [0.0; 2],
        inertia_kg_m2: INERTIA_KG_M2,
        products_kg_m2: [0.0; 3],
        gravity_m_s2: BODY.gravity_m_s2,
        torsion,
    };
    let drag = Drag { rotation_n_m_s_rad, ..Drag::NONE };
    Rig { drag, ..Rig::from(Body::new(&params).unwrap()) }
}

/// A body let go at one turn, at the wide end of an ellipse of 5 : 1 in a random direction and of
/// random sense.
fn start(swing_deg: f64, draws: &mut AddressedRandom) -> StartState {
    let swing_rad = swing_deg * RAD_PER_DEG;
    let azimuth = TAU * draws.uniform(10);
    let sense = if draws.uniform(11) < 0.5 { -1.0 } else { 1.0 };
    let (sin, cos) = azimuth.sin_cos();
    let e = [swing_rad.sin() * cos, swing_rad.sin() * sin];
    let swing_rad_s = BODY.swing_frequency_rad_s();
    let across = 0.2 * sense * swing_rad * swing_rad_s;
    // The vertical leans at the rates (−q, p), here at right angles to where it leans.
    hung(e, TAU, [across * cos, across * sin, 0.0])
}

/// The start whose vertical has the components `e` in body axes.
fn hung(e: [f64; 2], twist_rad: f64, omega_wb_b_rad_s: [f64; 3]) -> StartState {
    // Rᵀ·z of a swing by θ about the azimuth α, after a twist τ: sin θ·(−sin(α − τ), cos(α − τ)).
    let tilt_rad = e[0].hypot(e[1]).asin();
    let tilt_azimuth_rad = (-e[0]).atan2(e[1]) + twist_rad;
    StartState { tilt_rad, tilt_azimuth_rad, twist_rad, omega_wb_b_rad_s, ..StartState::AT_REST }
}

#[test]
fn a_motion_started_anew_is_the_one_that_ran() {
    let kick = Some((700, [0.0; 3]));
    let mut straight = Truth::new(Scenario::swing(15.0), 1);
    let mut anew = Truth::new(Scenario { kick, ..Scenario::swing(15.0) }, 1);
    for k in [0, 700, 701, 1500] {
        let (a, b) = (straight.sample(k).motion.entries(), anew.sample(k).motion.entries());
        for (a, b) in a.into_iter().zip(b) {
            // Rounding of the attitude there and back, turned by 8 s of swing.
            assert!((a - b).abs() < 1e-10, "sample {k}: {a} and {b}");
        }
    }
}

#[test]
fn the_swing_is_an_ellipse_of_five_to_one() {
    let mut truth = Truth::new(Scenario::swing(5.0), 0);
    let tilts = (0..64).map(|k| truth.sample(k).motion.tilt_rad() / RAD_PER_DEG);
    let (least, most) = tilts.fold((90.0_f64, 0.0_f64), |(a, b), t| (a.min(t), b.max(t)));
    // A swing takes 63 samples; its two modes of 1.540 and 1.577 Hz bend the ellipse meanwhile.
    assert!((4.9..5.05).contains(&most) && (0.7..1.3).contains(&least), "{least} to {most}");
}
