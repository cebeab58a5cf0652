//! The test set: one body and the three starts on which integrators and engines are compared.
//!
//! Public, because cross-validation against other implementations quotes its figures for exactly
//! these motions.

use crate::{BodyParams, StartState, Torsion, TorsionDamping, TorsionStiffness};
use std::f64::consts::TAU;
use struna_kernel::RAD_PER_DEG;

/// A one-kilogram body with three different moments and a torsion period of 480 s, undamped.
pub const PARAMS: BodyParams = BodyParams {
    mass_kg: 1.0,
    com_depth_m: 0.1,
    com_offset_m: [0.0; 2],
    inertia_kg_m2: [0.0100, 0.0110, 0.0120],
    products_kg_m2: [0.0; 3],
    gravity_m_s2: 9.81,
    torsion: Torsion {
        stiffness: TorsionStiffness::PeriodS(480.0),
        damping: TorsionDamping::Ratio(0.0),
    },
};

/// Pure torsion: one turn, released at rest.
pub const S1: StartState = StartState { twist_rad: TAU, ..StartState::AT_REST };

/// Pure swing: 10° about the x axis, released at rest.
pub const S2: StartState = StartState { tilt_rad: 10.0 * RAD_PER_DEG, ..StartState::AT_REST };

/// Everything at once: 10° of tilt, one turn, and a push about all three axes.
pub const S3: StartState = StartState {
    tilt_rad: 10.0 * RAD_PER_DEG,
    tilt_azimuth_rad: 0.0,
    twist_rad: TAU,
    omega_wb_b_rad_s: [0.2, 0.3, 0.5],
    ..StartState::AT_REST
};
