//! Closed forms for bodies that hang askew or turn about no principal axis.

#![expect(clippy::panic, reason = "another answer than the one awaited fails the test")]

use super::{FREE, JUDGE, RK4_1MS, at_ms, difference_rad, motion, run};
use nalgebra::{Rotation3, Vector3};
use struna_body::{Body, BodyError, BodyParams, Drag, Rig, StartState, reference};
use struna_kernel::SimTime;

const OFFSET: [f64; 2] = [0.012, -0.035];

fn offset_body() -> Body {
    let params = BodyParams { com_offset_m: OFFSET, ..reference::PARAMS };
    Body::new(&params).expect("a sound body")
}

/// The tilt that brings the centre of mass below the point that the string holds, and the azimuth
/// of its axis on a body whose thread is not twisted.
fn hanging() -> StartState {
    let [x, y] = OFFSET;
    let tilt_rad = (x.hypot(y) / reference::PARAMS.com_depth_m).atan();
    StartState { tilt_rad, tilt_azimuth_rad: x.atan2(-y), ..StartState::AT_REST }
}

#[test]
fn a_body_with_its_centre_off_the_axis_rests_tilted_by_offset_over_depth() {
    let body = offset_body();
    for length_m in [None, Some(2.0)] {
        let rig = Rig { string_length_m: length_m, ..body.into() };
        let mut run = run(rig, &hanging(), RK4_1MS);
        let start = motion(&mut run, SimTime::ZERO);
        // Weight times depth over inertia, 100 rad/s², in rounding.
        assert!(start.angular_acceleration_b_rad_s2.norm() < 1e-13);
        let end = motion(&mut run, at_ms(60_000));
        // That rounding, pushing for 60 s: nothing restores about the vertical, swing does else.
        assert!(difference_rad(&start.q_wb, &end.q_wb) < 1e-13 * 60.0_f64.powi(2) / 2.0);
        assert!((end.q_wb * Vector3::z() - start.q_wb * Vector3::z()).xy().norm() < 1e-10);
        let below = end.com_position_w_m;
        // A string of 2 m restores with 5 1/s² against it; without one, C never gets a push.
        assert!(below.xy().norm() < 1e-12 && below.z < -0.1, "{below}");
    }
}

#[test]
fn air_brings_an_offset_body_to_rest_below_its_string() {
    let drag = Drag { rotation_n_m_s_rad: 0.05, ..Drag::NONE };
    let rig = Rig { drag, string_length_m: None, ..offset_body().into() };
    // Straight at rest is not its equilibrium, so it swings down; the thread, at 2e-6 N·m/rad,
    // leaves a twist of below 1e-6 rad that it takes hours to undo.
    let end = motion(&mut run(rig, &StartState::AT_REST, JUDGE), at_ms(60_000));
    let axis = end.q_wb * Vector3::z();
    assert!((axis.z.acos() - hanging().tilt_rad).abs() < 1e-9, "tilt {}", axis.z.acos());
    let place = end.q_wb * -offset_body().suspension_b_m();
    assert!(place.xy().norm() < 1e-9, "{place}");
}

/// A body whose principal axes y and z are turned by `angle_rad` about x.
fn body_turned_about_x(angle_rad: f64) -> Body {
    let turn = Rotation3::from_axis_angle(&Vector3::x_axis(), angle_rad);
    let principal = nalgebra::Matrix3::from_diagonal(&Vector3::new(0.0105, 0.0105, 0.0120));
    let tensor = turn * principal * turn.transpose();
    let params = BodyParams {
        inertia_kg_m2: tensor.diagonal().into(),
        products_kg_m2: [tensor.m12, tensor.m13, tensor.m23],
        torsion: FREE,
        ..reference::PARAMS
    };
    Body::new(&params).expect("a sound body")
}

#[test]
fn a_spin_about_no_principal_axis_is_held_upright_by_the_torque_of_its_product_of_inertia() {
    let angle_rad = 0.05_f64;
    let body = body_turned_about_x(angle_rad);
    let product = (0.0105 - 0.0120) * angle_rad.sin() * angle_rad.cos();
    assert!((body.inertia_b_kg_m2().m23 - product).abs() < 1e-18, "J_yz of a turn about x");
    let spin_rad_s = 4.0_f64;
    let start = StartState::twisted(0.0, spin_rad_s);
    let mut held = run(body, &start, JUDGE);
    // ω×Jω for ω along z: exact, not only to first order.
    held.set_torque(Vector3::x() * (-product * spin_rad_s.powi(2))).unwrap();
    let end = motion(&mut held, at_ms(20_000));
    // The tolerance 1e-13 over some hundred steps.
    assert!((end.q_wb * Vector3::z()).xy().norm() < 1e-11, "it must not tilt");
    assert!((end.spin_rad - 20.0 * spin_rad_s).abs() < 1e-10);
    let mut left = run(body, &start, JUDGE);
    left.set_torque(Vector3::x() * (product * spin_rad_s.powi(2))).unwrap();
    let tilt = (motion(&mut left, at_ms(160)).q_wb * Vector3::z()).xy().norm();
    assert!(tilt > 1e-4, "a test of nothing: the opposite torque must tilt it, {tilt} rad");
}

#[test]
fn a_body_spinning_about_no_principal_axis_leans_by_the_closed_form() {
    let spin_rad_s = 4.0_f64;
    for angle_rad in [0.01, 0.02, 0.04] {
        let body = body_turned_about_x(angle_rad);
        let j = body.inertia_b_kg_m2();
        // Steady spin Ω about the vertical γ, torques about C: Ω² γ×Jγ = M g d (−γ₂, γ₁, 0), to
        // first order in γ₁, γ₂.
        let weight_n_m = 0.1 * 9.81;
        let square = spin_rad_s.powi(2);
        let lean_rad = square * j.m23 / (weight_n_m + square * (j.m33 - j.m22));
        // γ₂ = lean: the body is tilted about its x axis.
        let vertical = Vector3::new(0.0, lean_rad, (1.0 - lean_rad.powi(2)).sqrt());
        let start = StartState {
            tilt_rad: lean_rad.asin(),
            omega_wb_b_rad_s: (vertical * spin_rad_s).into(),
            ..StartState::AT_REST
        };
        let mut run = run(body, &start, JUDGE);
        let mut worst_rad = 0.0_f64;
        for k in 0..=100 {
            let now = motion(&mut run, at_ms(100 * k)).q_wb.inverse_transform_vector(&Vector3::z());
            worst_rad = worst_rad.max((now - vertical).norm());
        }
        println!("axes off by {angle_rad} rad: lean {lean_rad:.3e}, wobble {worst_rad:.1e} rad");
        // The closed form lacks terms of third order in the small angles, each with a factor of
        // order Ω²/ω_s² = 0.17 at most; twice that is the wobble about the true steady lean.
        assert!(worst_rad < 0.4 * angle_rad * lean_rad.abs().max(angle_rad * angle_rad));
        // The sign and size of what it has.
        assert!(worst_rad < 0.05 * lean_rad.abs(), "{worst_rad:e} of {lean_rad:e}");
    }
}

fn refusal(params: BodyParams) -> &'static str {
    match Body::new(&params) {
        Err(BodyError::Parameter(error)) => error.name,
        other => panic!("accepted or refused otherwise: {other:?}"),
    }
}

#[test]
fn a_tensor_that_no_masses_have_is_refused_by_name() {
    let with = |products_kg_m2| BodyParams { products_kg_m2, ..reference::PARAMS };
    // Products beyond the geometric mean of two moments: a negative principal moment.
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let mut products = [0.0; 3];
            products[axis] = sign * 0.013;
            assert_eq!(refusal(with(products)), "principal_inertia_kg_m2", "{products:?}");
        }
    }
    // Positive definite, but principal moments of 0.006, 0.006 and 0.018: thinner than a plate.
    // 0.010·1 + 0.004·(ones off the diagonal) has them.
    let inertia_kg_m2 = [0.010; 3];
    let rod = |product: f64| BodyParams { inertia_kg_m2, ..with([product; 3]) };
    assert_eq!(refusal(rod(0.004)), "principal_inertia_kg_m2");
    // With the product p the moments are 0.010 − p twice and 0.010 + 2p: a plate at p = 0.0025.
    assert_eq!(refusal(rod(0.0026)), "principal_inertia_kg_m2");
    assert!(Body::new(&rod(0.0024)).is_ok());
    // With −p they are 0.010 + p twice and 0.010 − 2p: a rod without thickness at p = 0.005.
    assert!(Body::new(&rod(-0.0049)).is_ok());
    assert_eq!(refusal(rod(-0.0051)), "principal_inertia_kg_m2");
}

#[test]
fn products_and_offsets_that_are_no_numbers_are_refused_by_name() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for axis in 0..3 {
            let mut products_kg_m2 = [0.0; 3];
            products_kg_m2[axis] = bad;
            let params = BodyParams { products_kg_m2, ..reference::PARAMS };
            assert_eq!(refusal(params), "products_kg_m2");
        }
        for axis in 0..2 {
            let mut com_offset_m = [0.0; 2];
            com_offset_m[axis] = bad;
            assert_eq!(refusal(BodyParams { com_offset_m, ..reference::PARAMS }), "com_offset_m");
        }
    }
}
