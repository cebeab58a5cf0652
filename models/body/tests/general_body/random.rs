//! Bodies made of balls, and their starts.

use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;
use std::f64::consts::TAU;
use struna_body::{
    Body, BodyParams, StartState, Torsion, TorsionDamping, TorsionStiffness, reference,
};
use struna_kernel::RAD_PER_DEG;

/// A thread whose torsion shows within seconds.
pub(crate) fn soft_thread() -> Torsion {
    Torsion { stiffness: TorsionStiffness::PeriodS(8.0), damping: TorsionDamping::Ratio(0.0) }
}

/// Radius of the balls that bodies are made of, m: none is a point, so no body is a needle.
pub(crate) const BALL_RADIUS_M: f64 = 0.04;

/// The body that consists of such balls, kg, at places seen from the point that the string holds,
/// m. Its tensor obeys every inequality because it is one.
pub(crate) fn body_of(balls: &[(f64, Vector3<f64>)], torsion: Torsion) -> Body {
    let mass_kg: f64 = balls.iter().map(|(m, _)| m).sum();
    let com = balls.iter().map(|(m, place)| place * *m).sum::<Vector3<f64>>() / mass_kg;
    let tensor: Matrix3<f64> = balls
        .iter()
        .map(|(m, place)| {
            let arm = place - com;
            let own = 0.4 * BALL_RADIUS_M.powi(2);
            (Matrix3::identity() * (own + arm.norm_squared()) - arm * arm.transpose()) * *m
        })
        .sum();
    let params = BodyParams {
        mass_kg,
        com_depth_m: -com.z,
        com_offset_m: [com.x, com.y],
        inertia_kg_m2: tensor.diagonal().into(),
        products_kg_m2: [tensor.m12, tensor.m13, tensor.m23],
        torsion,
        ..reference::PARAMS
    };
    Body::new(&params).expect("balls make a body")
}

/// Eight balls in a box of 30 cm below the string, half of them near its axis, so that the body
/// hangs within some twenty degrees of straight.
pub(crate) fn any_body(torsion: Torsion) -> impl Strategy<Value = Body> {
    let place = |wide: f64| [-wide..wide, -wide..wide, -0.35_f64..-0.05].prop_map(Vector3::from);
    let mass = || 0.05_f64..0.5;
    let outer = prop::collection::vec((mass(), place(0.15)), 4);
    let inner = prop::collection::vec((mass(), place(0.05)), 4);
    (outer, inner).prop_map(move |(mut balls, inner)| {
        balls.extend(inner);
        body_of(&balls, torsion)
    })
}

pub(crate) fn any_azimuth() -> impl Strategy<Value = f64> {
    0.0_f64..TAU
}

pub(crate) fn any_start(tilt_max_deg: f64) -> impl Strategy<Value = StartState> {
    let rate = || -1.0_f64..1.0;
    let tilt = 0.0_f64..tilt_max_deg * RAD_PER_DEG;
    (tilt, any_azimuth(), -TAU..TAU, [rate(), rate(), rate()]).prop_map(
        |(tilt_rad, tilt_azimuth_rad, twist_rad, omega_wb_b_rad_s)| StartState {
            tilt_rad,
            tilt_azimuth_rad,
            twist_rad,
            omega_wb_b_rad_s,
            ..StartState::AT_REST
        },
    )
}
