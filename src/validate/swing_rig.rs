//! The swinging rig: full equations of motion, a gyro a little off the axis, three gyros on it.

use super::contestant::TrueState;
use super::row::{Column, Row};
use super::suite::RunId;
use super::torsion::{R_RAD2_S2, STEP_S};
use anyhow::Result;
use std::f64::consts::TAU;
use struna_body::{
    Body, BodyParams, Drag, Integrator, Rig, StartState, Torsion, TorsionDamping, TorsionStiffness,
    TruthMotion,
};
use struna_estimator::{AugmentedConfig, InputAxis, StartPrior, SwingBody, SwingConfig};
use struna_kernel::{AddressedRandom, Channel, RAD_PER_DEG, SampleGrid, SimTime};

/// Samples of a run: two periods.
pub(super) const SAMPLES: u32 = 24_000;
/// Period that estimators are told of, s.
const PERIOD_S: f64 = 120.0;
/// Damping ratio that estimators are told of: more than the air alone takes.
const DAMPING_RATIO: f64 = 0.03;
const MASS_KG: f64 = 1.0;
const COM_DEPTH_M: f64 = 0.1;
const GRAVITY_M_S2: f64 = 9.81;
/// Moments about x and z; the one about y follows from the case.
const INERTIA_A_KG_M2: f64 = 0.0100;
const INERTIA_C_KG_M2: f64 = 0.0100;
/// What estimators believe of A and B over the truth.
const BELIEVED: [f64; 2] = [1.01, 0.995];
/// Decay of the swing, true and believed, 1/s.
const SWING_DECAY_1_S: f64 = 1e-3;
const START_SIGMA_RAD: f64 = 10.0 * RAD_PER_DEG;
/// Turns the swing by 1e-8 of its phase too little or too much.
const INTEGRATOR: Integrator = Integrator::Rk4 { step_s: 5e-3 };

/// How the body swings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shape {
    /// Long half axis of the ellipse, deg.
    pub(super) swing_deg: f64,
    /// Short half axis over the long one; none when that is drawn too. Its sense always is.
    pub(super) ratio: Option<f64>,
    /// Angle between the gyro's input axis and the body's, deg.
    pub(super) misalignment_deg: f64,
    /// What it is calibrated to, each way, deg; the truth is drawn with that spread.
    pub(super) calibration_deg: f64,
    /// B over A.
    pub(super) inertia_ratio: f64,
}

/// One run.
#[derive(Debug)]
pub(super) struct SwingRig {
    shape: Shape,
    period_s: f64,
    damping_ratio: f64,
    biases_rad_s: [f64; 3],
    start_error_rad: f64,
    /// Short half axis of the ellipse over the long one, with the sign of its sense.
    ratio: f64,
    calibrated: InputAxis,
    /// True input axis across the body's.
    axis: [f64; 2],
    motion: TruthMotion,
    grid: SampleGrid,
    noise: [AddressedRandom; 3],
}

/// Truth at a sample, and what the gyros say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sample {
    pub(super) twist_rad: f64,
    pub(super) twist_rate_rad_s: f64,
    /// Rate about the body's axis.
    pub(super) body_rate_rad_s: f64,
    /// The gyro a little off the axis, rad/s.
    pub(super) measured_rad_s: f64,
    /// Gyros on the body's axes, rad/s.
    pub(super) rates_rad_s: [f64; 3],
}

impl SwingRig {
    /// Draws a run.
    ///
    /// # Errors
    /// When the body model refuses what was drawn.
    pub(super) fn draw(shape: Shape, id: RunId) -> Result<Self> {
        let open = |channel| AddressedRandom::new(id.seed, channel, u64::from(id.run));
        let mut draws = open(Channel::StartError);
        let sense = if draws.uniform(40) < 0.5 { -1.0 } else { 1.0 };
        let ratio = sense * shape.ratio.unwrap_or_else(|| draws.uniform(43));
        let (azimuth, axis_azimuth) = (TAU * draws.uniform(41), TAU * draws.uniform(42));
        let mut n = |k| draws.standard_normal(k);
        let period_s = PERIOD_S * (1.0 + 0.01 * n(1));
        let damping_ratio = (DAMPING_RATIO + 0.003 * n(2)).max(0.02);
        let misalignment_rad = shape.misalignment_deg * RAD_PER_DEG;
        let axis_sigma_rad = shape.calibration_deg * RAD_PER_DEG;
        let calibrated = InputAxis::towards(misalignment_rad, axis_azimuth, axis_sigma_rad);
        let [x, y] = calibrated.tilt_b_rad;
        let rig = rig(&shape, period_s, damping_ratio)?;
        let motion = TruthMotion::new(rig, &start(&shape, azimuth, ratio), INTEGRATOR)?;
        Ok(Self {
            shape,
            period_s,
            damping_ratio,
            biases_rad_s: [3, 5, 6].map(|k| 0.05 * RAD_PER_DEG * n(k)),
            start_error_rad: START_SIGMA_RAD * n(4),
            ratio,
            calibrated,
            axis: [x + axis_sigma_rad * n(7), y + axis_sigma_rad * n(8)],
            motion,
            grid: SampleGrid::new(SimTime::ZERO, 1.0 / STEP_S)?,
            noise: [
                open(Channel::TorqueNoise),
                open(Channel::ImpulseSize),
                open(Channel::GyroAngleRandomWalk),
            ],
        })
    }

    /// Writes what was drawn into a row.
    pub(super) fn describe(&self, row: &mut Row) {
        row.set(Column::DurationS, f64::from(SAMPLES) * STEP_S);
        row.set(Column::PeriodS, self.period_s);
        row.set(Column::DampingRatio, self.damping_ratio);
        row.set(Column::StartAngleDeg, 360.0);
        row.set(Column::StartErrorDeg, self.start_error_rad / RAD_PER_DEG);
        row.set(Column::BiasDegS, self.biases_rad_s[2] / RAD_PER_DEG);
        row.set(Column::NoiseDegS, R_RAD2_S2.sqrt() / RAD_PER_DEG);
        row.set(Column::BelievedNoiseDegS, R_RAD2_S2.sqrt() / RAD_PER_DEG);
        row.set(Column::SwingDeg, self.shape.swing_deg);
        row.set(Column::SwingRatio, self.ratio);
        let across_rad = self.axis[0].hypot(self.axis[1]).asin();
        row.set(Column::MisalignmentDeg, across_rad / RAD_PER_DEG);
        row.set(Column::InertiaRatio, self.shape.inertia_ratio);
    }

    /// Sample `k`, to be asked for in order from 1.
    ///
    /// # Errors
    /// When the integrator stops.
    pub(super) fn sample(&mut self, k: u32) -> Result<Sample> {
        let now = self.motion.motion_at(self.grid.time_of(u64::from(k)))?;
        let omega_rad_s: [f64; 3] = now.omega_wb_b_rad_s.into();
        let sigma = R_RAD2_S2.sqrt();
        let noise: [f64; 3] =
            std::array::from_fn(|i| sigma * self.noise[i].standard_normal(u64::from(k)));
        let [x, y] = self.axis;
        let [p, q, r] = omega_rad_s;
        let along_rad_s = x * p + y * q + (1.0 - x * x - y * y).sqrt() * r;
        Ok(Sample {
            twist_rad: now.twist_rad,
            twist_rate_rad_s: now.twist_rate_rad_s,
            body_rate_rad_s: r,
            measured_rad_s: along_rad_s + self.biases_rad_s[2] + noise[2],
            rates_rad_s: std::array::from_fn(|i| omega_rad_s[i] + self.biases_rad_s[i] + noise[i]),
        })
    }

    /// True parameters; angle and rate are left at zero.
    pub(super) fn parameters(&self) -> TrueState {
        let omega = TAU / self.period_s;
        TrueState {
            angle_rad: 0.0,
            rate_rad_s: 0.0,
            s: omega * omega,
            d: 2.0 * self.damping_ratio * omega,
            bias_rad_s: self.biases_rad_s[2],
        }
    }

    /// What estimators of pure torsion are told.
    pub(super) fn torsion_config(&self) -> AugmentedConfig {
        let start = StartPrior {
            angle_sigma_rad: START_SIGMA_RAD,
            rate_sigma_rad_s: RAD_PER_DEG,
            ..StartPrior::released(TAU + self.start_error_rad, PERIOD_S)
        };
        // A gyro off the axis feels the cosine of the twist rate. Estimators of pure torsion know
        // of no axis, and to them that is a scale factor: 1.5e-4 for one degree.
        let tilt = self.calibrated.tilt_b_rad.iter().map(|tilt| tilt * tilt).sum::<f64>();
        let scale_factor_sigma = 1.0 - (1.0 - tilt).sqrt();
        AugmentedConfig { scale_factor_sigma, ..AugmentedConfig::quiet(start, R_RAD2_S2) }
    }

    /// What estimators of the swinging body are told.
    pub(super) fn swing_config(&self) -> SwingConfig {
        let [a, b, c] = inertia(&self.shape);
        let body = SwingBody {
            mass_kg: MASS_KG,
            com_depth_m: COM_DEPTH_M,
            inertia_kg_m2: [a * BELIEVED[0], b * BELIEVED[1], c],
            gravity_m_s2: GRAVITY_M_S2,
            swing_damping_1_s: SWING_DECAY_1_S,
        };
        SwingConfig::quiet(body, self.calibrated, self.torsion_config().start, R_RAD2_S2)
    }
}

fn inertia(shape: &Shape) -> [f64; 3] {
    [INERTIA_A_KG_M2, INERTIA_A_KG_M2 * shape.inertia_ratio, INERTIA_C_KG_M2]
}

/// The body in air, its torsion damped by string and air together.
fn rig(shape: &Shape, period_s: f64, damping_ratio: f64) -> Result<Rig> {
    let [a, b, c] = inertia(shape);
    let rotation_n_m_s_rad = SWING_DECAY_1_S * (a + b);
    let both = 2.0 * damping_ratio * c * TAU / period_s;
    let torsion = Torsion {
        stiffness: TorsionStiffness::PeriodS(period_s),
        damping: TorsionDamping::CoefficientNMSRad((both - rotation_n_m_s_rad).max(0.0)),
    };
    let body = Body::new(&BodyParams {
        mass_kg: MASS_KG,
        com_depth_m: COM_DEPTH_M,
        com_offset_m: [0.0; 2],
        inertia_kg_m2: [a, b, c],
        products_kg_m2: [0.0; 3],
        gravity_m_s2: GRAVITY_M_S2,
        torsion,
    })?;
    Ok(Rig { drag: Drag { rotation_n_m_s_rad, ..Drag::NONE }, ..Rig::from(body) })
}

/// A body let go at one turn, at the wide end of an ellipse in a random direction.
fn start(shape: &Shape, azimuth: f64, ratio: f64) -> StartState {
    let swing_rad = shape.swing_deg * RAD_PER_DEG;
    let mean_kg_m2 = 0.5 * (INERTIA_A_KG_M2 + INERTIA_A_KG_M2 * shape.inertia_ratio);
    let swing_rad_s = (MASS_KG * GRAVITY_M_S2 * COM_DEPTH_M / mean_kg_m2).sqrt();
    let (sin, cos) = azimuth.sin_cos();
    let e = [swing_rad.sin() * cos, swing_rad.sin() * sin];
    // The vertical leans at the rates (-q, p), here at right angles to where it leans.
    let across = ratio * swing_rad * swing_rad_s;
    let (p, q) = (across * cos, across * sin);
    // The twist starts at rest: its rate is r + (e1 p + e2 q)/(1 + e3).
    let r = -(e[0] * p + e[1] * q) / (1.0 + swing_rad.cos());
    StartState {
        tilt_rad: swing_rad,
        // After a swing by θ about α and a twist τ, Rᵀ·z = sin θ·(−sin(α − τ), cos(α − τ)) across.
        tilt_azimuth_rad: (-e[0]).atan2(e[1]) + TAU,
        twist_rad: TAU,
        omega_wb_b_rad_s: [p, q, r],
        ..StartState::AT_REST
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use struna_body::Backend;

    const ALIGNED: Shape = Shape {
        swing_deg: 0.0,
        ratio: None,
        misalignment_deg: 1.0,
        calibration_deg: 0.1,
        inertia_ratio: 1.0,
    };

    /// The widest swing of the suite by both engines. Rapier at 1 ms is allowed 1e-3 rad in a
    /// minute; these are 20 s.
    #[test]
    fn the_rigid_body_engine_sees_the_same_swing() {
        let shape = Shape { swing_deg: 15.0, ratio: None, inertia_ratio: 1.05, ..ALIGNED };
        let rig = rig(&shape, 120.0, 0.03).unwrap();
        let start = start(&shape, 0.7, -0.2);
        let at = SimTime::from_s(20.0).unwrap();
        let moved = |backend: Backend| {
            TruthMotion::new(rig.clone(), &start, backend).unwrap().motion_at(at).unwrap()
        };
        let (lagrange, rapier) =
            (moved(INTEGRATOR.into()), moved(Backend::Rapier { step_s: 1e-3 }));
        let gap_rad = (lagrange.twist_rad - rapier.twist_rad).abs();
        assert!(gap_rad < 1e-3, "{gap_rad} rad");
        let rates = (lagrange.omega_wb_b_rad_s - rapier.omega_wb_b_rad_s).norm();
        // The swing turns at 9.7 rad/s: a phase off by 1e-3 rad is 1e-3 of its rate.
        assert!(rates < 1e-3 * 9.7, "{rates} rad/s");
        assert!((lagrange.twist_rad - TAU).abs() > 0.5, "it has moved: {}", lagrange.twist_rad);
    }

    #[test]
    fn a_run_starts_at_one_turn_at_rest_in_twist_and_as_wide_as_asked() {
        let id = RunId { seed: struna_kernel::Seed(5), run: 3 };
        let shape = Shape { swing_deg: 10.0, ratio: Some(1.0), inertia_ratio: 1.0, ..ALIGNED };
        let mut rig = SwingRig::draw(shape, id).unwrap();
        let first = rig.sample(1).unwrap();
        // A hundredth of a second later: the thread alone gives 2e-4 rad/s by then, and the cone,
        // which is not quite a steady one, no more than that either.
        assert!((first.twist_rad - TAU).abs() < 1e-4, "{}", first.twist_rad);
        assert!(first.twist_rate_rad_s.abs() < 2e-3, "{}", first.twist_rate_rad_s);
        // A conical swing turns its rate about: 10° at 9.8 rad/s, seen by the two gyros across.
        let across = first.rates_rad_s[0].hypot(first.rates_rad_s[1]);
        assert!((across - 0.1745 * 9.9).abs() < 0.1, "{across}");
    }
}
