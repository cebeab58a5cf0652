//! The body that swings while it turns, as the tests of the fit and of the live estimator have it:
//! how it is let go, what it is, and what is believed of it and of the gyro askew on it.

use std::f64::consts::TAU;
use struna_body::{
    Body, BodyParams, Drag, Rig, StartState, Torsion, TorsionDamping, TorsionStiffness,
};
use struna_estimator::{InputAxis, SwingBody};
use struna_kernel::RAD_PER_DEG;

/// Torsion: 2ζΩ with ζ = 0.03.
pub(crate) const DAMPING_RATIO: f64 = 0.03;
pub(crate) const INERTIA_KG_M2: [f64; 3] = [0.0100, 0.0105, 0.0100];
/// What is believed of them: wrong by 1 % and 0.5 %.
const BELIEVED_KG_M2: [f64; 3] = [0.0101, 0.010_447_5, 0.0100];
const MASS_KG: f64 = 1.0;
const DEPTH_M: f64 = 0.1;
const GRAVITY_M_S2: f64 = 9.81;

/// One turn of twist at rest, and a swing on an ellipse: the rate across the tilt is `ratio` of
/// what a circle has.
pub(crate) fn start(swing_rad: f64, azimuth: f64, ratio: f64) -> StartState {
    let still = StartState {
        tilt_rad: swing_rad,
        tilt_azimuth_rad: azimuth,
        twist_rad: TAU,
        ..StartState::AT_REST
    };
    let e = still.attitude().inverse_transform_vector(&nalgebra::Vector3::z());
    let frequency = (MASS_KG * GRAVITY_M_S2 * DEPTH_M / 0.01025_f64).sqrt();
    let (p, q) = (ratio * frequency * e.x, ratio * frequency * e.y);
    // The twist starts at rest: its rate is r + (e₁p + e₂q)/(1 + e₃).
    let r = -(e.x * p + e.y * q) / (1.0 + e.z);
    StartState { omega_wb_b_rad_s: [p, q, r], ..still }
}

/// Torque of the air per rate that takes the swing at `decay_1_s`, N·m·s/rad.
pub(crate) fn air_n_m_s_rad(decay_1_s: f64) -> f64 {
    decay_1_s * (INERTIA_KG_M2[0] + INERTIA_KG_M2[1])
}

/// The body in air that takes the swing at `decay_1_s`, its torsion damped by thread and air
/// together at `damping_ratio`.
pub(crate) fn rig(period_s: f64, damping_ratio: f64, decay_1_s: f64) -> Rig {
    let rotation_n_m_s_rad = air_n_m_s_rad(decay_1_s);
    // What the thread damps is what the air leaves of 2ζΩ.
    let both = 2.0 * damping_ratio * (TAU / period_s) * INERTIA_KG_M2[2];
    let params = BodyParams {
        mass_kg: MASS_KG,
        com_depth_m: DEPTH_M,
        com_offset_m: [0.0; 2],
        inertia_kg_m2: INERTIA_KG_M2,
        products_kg_m2: [0.0; 3],
        gravity_m_s2: GRAVITY_M_S2,
        torsion: Torsion {
            stiffness: TorsionStiffness::PeriodS(period_s),
            damping: TorsionDamping::CoefficientNMSRad((both - rotation_n_m_s_rad).max(0.0)),
        },
    };
    let drag = Drag { rotation_n_m_s_rad, ..Drag::NONE };
    Rig { drag, ..Rig::from(Body::new(&params).unwrap()) }
}

/// What is believed of the body.
pub(crate) fn believed_body(swing_damping_1_s: f64) -> SwingBody {
    SwingBody {
        mass_kg: MASS_KG,
        com_depth_m: DEPTH_M,
        inertia_kg_m2: BELIEVED_KG_M2,
        gravity_m_s2: GRAVITY_M_S2,
        swing_damping_1_s,
    }
}

/// What is believed of a gyro's axis with the components `across`: known to 0.1° each, and off by
/// so many times that.
pub(crate) fn believed_axis(across: [f64; 2], off_sigmas: [f64; 2]) -> InputAxis {
    let tilt_sigma_rad = 0.1 * RAD_PER_DEG;
    let believed = |k: usize| across[k] + tilt_sigma_rad * off_sigmas[k];
    InputAxis { tilt_b_rad: [believed(0), believed(1)], tilt_sigma_rad }
}
