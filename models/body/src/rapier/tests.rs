//! What the walk does for bodies and loads that the public face does not offer yet.

use super::mechanics::acceleration;
use super::*;
use crate::ode::Rhs;
use crate::{Body, BodyEquations, Impulse, reference};
use nalgebra::{Matrix3, Rotation3};

fn reference_rigid() -> RigidBody {
    let [a, b, c] = reference::PARAMS.inertia_kg_m2;
    RigidBody {
        mass_kg: reference::PARAMS.mass_kg,
        com_b_m: -Vector3::z() * reference::PARAMS.com_depth_m,
        inertia_b_kg_m2: Matrix3::from_diagonal(&Vector3::new(a, b, c)),
        earth_rate_w_rad_s: Vector3::zeros(),
    }
}

/// Principal axes tilted by 0.3 rad, the centre of mass 1 to 2 cm off the axis.
fn lopsided_rigid() -> RigidBody {
    let axes = Rotation3::from_euler_angles(0.2, -0.15, 0.4);
    let inertia_b_kg_m2 = axes * reference_rigid().inertia_b_kg_m2 * axes.inverse();
    let com_b_m = Vector3::new(0.02, -0.01, -0.1);
    RigidBody { com_b_m, inertia_b_kg_m2, mass_kg: 1.3, ..reference_rigid() }
}

fn rig() -> Rig {
    Body::new(&reference::PARAMS).unwrap().into()
}

fn string() -> RigLoads {
    RigLoads::new(&rig(), reference::S3.twist_rad).unwrap()
}

fn at_ms(ms: i64) -> SimTime {
    SimTime::from_ns(ms * 1_000_000)
}

#[test]
fn the_start_accelerates_as_the_equations_of_motion_say() {
    let body = Body::new(&reference::PARAMS).unwrap();
    let start = StartState { tilt_rad: 1.0, tilt_azimuth_rad: 0.7, ..reference::S3 };
    let rate = BodyEquations::new(&body, &start, Vector3::zeros())
        .derivative(0.0, &BodyEquations::states(&start));
    let (q_wb, omega) = (start.attitude(), Vector3::from(start.omega_wb_b_rad_s));
    let now = Synchronous {
        time_s: 0.0,
        q_wb,
        omega_wb_b_rad_s: omega,
        com_velocity_w_m_s: Vector3::zeros(),
        twist_rad: start.twist_rad,
        twist_rate_rad_s: swing_twist::twist_rate_rad_s(&q_wb, &omega),
    };
    let load = string().load(&now, 1e-3);
    let ours = q_wb.inverse() * acceleration(&reference_rigid(), &now, &load).omega_w;
    for axis in 0..3 {
        // Two routes through about thirty roundings each, on accelerations up to 100 rad/s².
        assert!((ours[axis] - rate[3 + axis]).abs() < 1e-12, "axis {axis}");
    }
}

/// Energy of a rigid body on a string, J, from what the walk answers.
fn energy_j(rigid: &RigidBody, motion: &BodyMotion) -> f64 {
    let (w, rho) = (motion.omega_wb_b_rad_s, rigid.com_b_m);
    let vertical_b = motion.q_wb.inverse_transform_vector(&Vector3::z());
    let fall_m_s = vertical_b.dot(&w.cross(&rho));
    let body = rig().body;
    0.5 * rigid.mass_kg * fall_m_s * fall_m_s
        + 0.5 * w.dot(&(rigid.inertia_b_kg_m2 * w))
        + rigid.mass_kg * body.params().gravity_m_s2 * vertical_b.dot(&rho)
        + 0.5 * body.stiffness_n_m_rad() * motion.twist_rad * motion.twist_rad
}

/// Largest change of the energy of a lopsided body over 20 s, J.
fn energy_change_j(step_s: f64) -> f64 {
    let rigid = lopsided_rigid();
    let mut walk = Walk::new(rigid, &reference::S3, step_s, string()).unwrap();
    let start_j = energy_j(&rigid, &walk.motion_at(SimTime::ZERO).unwrap());
    (1..=2000).fold(0.0, |worst: f64, k| {
        let motion = walk.motion_at(at_ms(10 * k)).unwrap();
        worst.max((energy_j(&rigid, &motion) - start_j).abs())
    })
}

#[test]
fn a_lopsided_body_keeps_its_energy_to_second_order() {
    let (coarse_j, fine_j) = (energy_change_j(5e-4), energy_change_j(2.5e-4));
    println!("lopsided body: {coarse_j:.2e} J at 0.5 ms, {fine_j:.2e} J at 0.25 ms");
    // The extrapolation of the rates adds a third order that grows with time: by 20 s it is 8 % at
    // 1 ms, so 4 % and 2 % here, which lifts the order by 0.03.
    let order = (coarse_j / fine_j).log2();
    assert!((order - 2.0).abs() < 0.1, "observed order {order:.3}");
    // Mgd(1 − cos 10°) = 0.02 J moves to and fro; (9.7 rad/s · 0.5 ms)² = 2.4e-5 of it is missed.
    assert!(coarse_j < 0.02 * 2.4e-5, "{coarse_j:e} J");
}

/// A constant push beside the string, for a body at rest.
#[derive(Debug, Clone)]
struct Push {
    string: RigLoads,
    force_w_n: Vector3<f64>,
    velocity_seen_m_s: f64,
}

impl Loads for Push {
    fn load(&mut self, now: &Synchronous, step_s: f64) -> Load {
        self.velocity_seen_m_s = now.com_velocity_w_m_s.x;
        Load { force_w_n: self.force_w_n, ..self.string.load(now, step_s) }
    }

    fn impulse(&mut self, from_s: f64, to_s: f64) -> Option<Momentum> {
        self.string.impulse(from_s, to_s)
    }
}

#[test]
fn a_horizontal_force_at_the_centre_of_mass_drags_the_body_without_turning_it() {
    let force_w_n = Vector3::new(0.02, -0.05, 0.0);
    let loads = Push { string: string(), force_w_n, velocity_seen_m_s: 0.0 };
    let rigid = reference_rigid();
    let mut walk = Walk::new(rigid, &StartState::AT_REST, 1e-3, loads).unwrap();
    let motion = walk.motion_at(at_ms(10_000)).unwrap();
    assert!(motion.omega_wb_b_rad_s.norm() < 1e-15, "{:?}", motion.omega_wb_b_rad_s);
    // Half a step past 10 s, summed over 1e4 steps.
    let expected = force_w_n * (10.0005 / rigid.mass_kg);
    assert!((walk.newest().com_velocity_w_m_s - expected).norm() < 1e-12);
    // The load of the step at 10 s saw the velocity of that very instant.
    assert!((walk.loads_mut().velocity_seen_m_s - 0.02 * 10.0).abs() < 1e-12);
}

#[test]
fn a_force_impulse_moves_the_centre_of_mass_by_momentum_over_mass() {
    // Beyond the 400 m/s at which rapier holds a body unless told otherwise.
    let linear_w_n_s = Vector3::new(300.0, -100.0, 0.0);
    let impulses = [500, 250].map(|ms| Impulse {
        time: at_ms(ms),
        angular_b_n_m_s: [0.0; 3],
        linear_w_n_s: linear_w_n_s.into(),
    });
    let mut rig = rig();
    rig.disturbances.impulses = impulses.to_vec();
    let (rigid, loads) = (reference_rigid(), RigLoads::new(&rig, 0.0).unwrap());
    let mut walk = Walk::new(rigid, &StartState::AT_REST, 1e-3, loads).unwrap();
    for (ms, count) in [(240, 0.0), (260, 1.0), (490, 1.0), (510, 2.0)] {
        walk.motion_at(at_ms(ms)).unwrap();
        let velocity = walk.newest().com_velocity_w_m_s;
        // Multiplied and divided by the step: a few roundings of 600 m/s.
        assert!((velocity - linear_w_n_s * count).norm() < 1e-12, "{ms} ms: {velocity}");
    }
}

#[test]
fn a_tensor_of_any_size_and_attitude_keeps_its_axes() {
    // rapier's own decomposition loses the axes of the two smaller ones. Some of the attitudes
    // make the eigenvectors come out left-handed.
    for (scale, turn) in [1.0, 1e-4, 1e-9].into_iter().cycle().zip(0..30_i32) {
        let turned = Rotation3::from_euler_angles(f64::from(turn), 0.3, 0.7 * f64::from(turn));
        let inertia = turned * lopsided_rigid().inertia_b_kg_m2 * turned.inverse() * scale;
        let (moments, axes) = engine::principal(&inertia).unwrap();
        let axes = axes.to_rotation_matrix();
        let again = axes * Matrix3::from_diagonal(&moments) * axes.inverse();
        // An orthogonal transformation there and back: some ten roundings.
        assert!((again - inertia).norm() < 1e-14 * inertia.norm(), "{scale:e}, {turn}");
    }
}

#[test]
fn a_tensor_that_no_body_has_is_refused_by_name() {
    let rigid = reference_rigid();
    let flat = Matrix3::from_diagonal(&Vector3::new(0.01, 0.0, 0.01));
    let skew = Matrix3::new(0.01, 0.02, 0.0, 0.02, 0.01, 0.0, 0.0, 0.0, 0.01);
    for inertia_b_kg_m2 in [flat, skew, rigid.inertia_b_kg_m2 * f64::NAN] {
        let rigid = RigidBody { inertia_b_kg_m2, ..rigid };
        match Walk::new(rigid, &reference::S3, 1e-3, string()) {
            Err(BodyError::Parameter(refused)) => assert_eq!(refused.name, "inertia_b_kg_m2"),
            other => panic!("{other:?}"),
        }
    }
}
