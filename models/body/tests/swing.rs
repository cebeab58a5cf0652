//! Motions of the swing that have a closed form.

use nalgebra::Vector3;
use std::f64::consts::{FRAC_PI_2, TAU};
use struna_body::ode::{Dop853, Tolerance};
use struna_body::{
    Body, BodyEquations, BodyParams, Integrator, STATES, StartState, Torsion, TorsionDamping,
    TorsionStiffness, TruthMotion, reference,
};
use struna_kernel::{RAD_PER_DEG, SimTime};

const TIGHT: Tolerance = Tolerance { rtol: 1e-13, atol: 1e-13 };
const RECORD: Integrator = Integrator::Dop853 { rtol: 1e-12, atol: 1e-12 };

fn symmetric_body_on_a_free_thread() -> Body {
    let torsion = Torsion {
        stiffness: TorsionStiffness::ConstantNMRad(0.0),
        damping: TorsionDamping::Ratio(0.0),
    };
    let inertia_kg_m2 = [0.0105, 0.0105, 0.0120];
    Body::new(&BodyParams { torsion, inertia_kg_m2, ..reference::PARAMS }).expect("a sound body")
}

/// The planar period with a suspension point that slides freely, s.
///
/// T = 4∫√((A + M d² sin²θ)/(2Mgd(cos θ − cos θ₀))) dθ with the substitution
/// sin(θ/2) = sin(θ₀/2)·sin s, whose integrand is smooth and periodic: the midpoint rule then
/// converges faster than any power.
fn period_by_quadrature_s(body: &Body, tilt_rad: f64) -> f64 {
    let p = body.params();
    let (a, sway) = (p.inertia_kg_m2[0], p.mass_kg * p.com_depth_m.powi(2));
    let pendulum = p.mass_kg * p.gravity_m_s2 * p.com_depth_m;
    let n = 64_u32;
    let width = FRAC_PI_2 / f64::from(n);
    let integrand = |k: u32| {
        let s = (f64::from(k) + 0.5) * width;
        let theta = 2.0 * ((0.5 * tilt_rad).sin() * s.sin()).asin();
        ((a + sway * theta.sin().powi(2)) / pendulum).sqrt() / (0.5 * theta).cos()
    };
    4.0 * width * (0..n).map(integrand).sum::<f64>()
}

/// The rates a period after a release from rest at `tilt_rad` about x, as an error of the period.
fn period_error_s(body: &Body, tilt_rad: f64, period_s: f64) -> f64 {
    let start = StartState { tilt_rad, ..StartState::AT_REST };
    let states: [f64; STATES] = BodyEquations::states(&start);
    let equations = BodyEquations::new(body, &start, Vector3::zeros());
    let mut run = Dop853::new(TIGHT, states).expect("a sound tolerance");
    let end = run.state_at(&equations, period_s).expect("a planar swing runs on");
    // At the turning point the rate is the acceleration times the time error.
    let p = body.params();
    let sway = p.mass_kg * (p.com_depth_m * tilt_rad.sin()).powi(2);
    let torque_n_m = p.mass_kg * p.gravity_m_s2 * p.com_depth_m * tilt_rad.sin();
    end[4] * (p.inertia_kg_m2[0] + sway) / torque_n_m
}

#[test]
fn the_planar_period_is_that_of_a_pendulum_on_a_sliding_point() {
    let body = Body::new(&reference::PARAMS).unwrap();
    for tilt_deg in [1.0, 10.0, 60.0, 120.0] {
        let tilt_rad = tilt_deg * RAD_PER_DEG;
        let period_s = period_by_quadrature_s(&body, tilt_rad);
        let error_s = period_error_s(&body, tilt_rad, period_s);
        println!("{tilt_deg} deg: period {period_s} s, error {error_s:.2e} s");
        // The tolerance 1e-13 of the run, over some tens of steps, against a tilt of 0.02 rad.
        assert!(error_s.abs() < 2e-11, "{tilt_deg} deg: {error_s:e} s");
    }
}

#[test]
fn small_swings_take_the_central_moment_and_not_the_fixed_pivot_one() {
    let body = Body::new(&reference::PARAMS).unwrap();
    let p = body.params();
    let (a, sway) = (p.inertia_kg_m2[0], p.mass_kg * p.com_depth_m.powi(2));
    let base_s = TAU * (a / (p.mass_kg * p.gravity_m_s2 * p.com_depth_m)).sqrt();
    for tilt_rad in [0.05, 0.1] {
        let series_s = base_s * (1.0 + tilt_rad * tilt_rad * (1.0 / 16.0 + sway / (4.0 * a)));
        // The series stops at θ₀²: the next term is of order θ₀⁴ with a coefficient below one.
        let error_s = period_error_s(&body, tilt_rad, series_s);
        assert!(error_s.abs() < base_s * tilt_rad.powi(4), "{tilt_rad}: {error_s:e} s");
    }
}

/// Start of a steady precession at rate `precession_rad_s`: A W² cos θ − C r W − M g d = 0.
fn steady_start(body: &Body, tilt_rad: f64, precession_rad_s: f64) -> StartState {
    let p = body.params();
    let [a, _, c] = p.inertia_kg_m2;
    let weight = p.mass_kg * p.gravity_m_s2 * p.com_depth_m;
    let spin_rad_s =
        (a * precession_rad_s.powi(2) * tilt_rad.cos() - weight) / (c * precession_rad_s);
    let omega_wb_b_rad_s = [0.0, precession_rad_s * tilt_rad.sin(), spin_rad_s];
    StartState { tilt_rad, omega_wb_b_rad_s, ..StartState::AT_REST }
}

#[test]
fn a_symmetric_body_precesses_steadily_at_the_rate_of_the_closed_form() {
    let body = symmetric_body_on_a_free_thread();
    let tilt_rad = 25.0 * RAD_PER_DEG;
    for precession_rad_s in [11.0, 14.0, -9.0] {
        let start = steady_start(&body, tilt_rad, precession_rad_s);
        let mut run = TruthMotion::new(body, &start, RECORD).unwrap();
        for k in 0..=200_i64 {
            let time = SimTime::from_ns(k * 50_000_000);
            let axis = run.motion_at(time).unwrap().q_wb * Vector3::z();
            let azimuth_rad = precession_rad_s * time.as_s();
            let expected = Vector3::new(
                tilt_rad.sin() * azimuth_rad.sin(),
                -tilt_rad.sin() * azimuth_rad.cos(),
                tilt_rad.cos(),
            );
            // Ten seconds at the tolerance 1e-12, some hundreds of steps.
            assert!((axis - expected).norm() < 1e-9, "W = {precession_rad_s}, t = {time}");
        }
    }
}

#[test]
fn a_conical_swing_looks_like_gyro_bias() {
    // A cone without spin: A W² cos θ = M g d. The gyro reads nothing while the twist runs away.
    let body = symmetric_body_on_a_free_thread();
    let p = body.params();
    let weight = p.mass_kg * p.gravity_m_s2 * p.com_depth_m;
    let swing_rad_s = (weight / p.inertia_kg_m2[0]).sqrt();
    for (tilt_deg, quoted_deg_s) in [(1.0, 0.084), (2.0, 0.34), (5.0, 2.11), (10.0, 8.5)] {
        let tilt_rad = tilt_deg * RAD_PER_DEG;
        let precession_rad_s = swing_rad_s / tilt_rad.cos().sqrt();
        let start = steady_start(&body, tilt_rad, precession_rad_s);
        let mut run = TruthMotion::new(body, &start, RECORD).unwrap();
        let seconds = 60_i32;
        let end = run.motion_at(SimTime::from_ns(i64::from(seconds) * 1_000_000_000)).unwrap();
        let drift_rad_s = (end.twist_rad - end.spin_rad) / f64::from(seconds);
        let exact_rad_s = precession_rad_s * (1.0 - tilt_rad.cos());
        // The tolerance 1e-12 over some thousand steps, spread over sixty seconds.
        assert!((drift_rad_s - exact_rad_s).abs() < 1e-10, "{tilt_deg} deg");
        let small_rad_s = 0.5 * swing_rad_s * tilt_rad * tilt_rad;
        // To second order in the tilt; the next term is θ²/6, half a per cent at ten degrees.
        assert!((drift_rad_s / small_rad_s - 1.0).abs() < 0.01, "{tilt_deg} deg");
        // The table of coning rates, quoted to two or three digits.
        assert!((drift_rad_s / RAD_PER_DEG / quoted_deg_s - 1.0).abs() < 0.02, "{tilt_deg} deg");
    }
}

/// Direction of the long axis of the path that the body axis draws over one period from `start_s`
/// on, rad: that of the larger second moment, by an even sum over the period.
fn long_axis_rad(run: &mut TruthMotion, start_s: f64, period_s: f64) -> f64 {
    const POINTS: u32 = 400;
    let (mut difference, mut product) = (0.0, 0.0);
    for k in 0..POINTS {
        let time_s = start_s + period_s * f64::from(k) / f64::from(POINTS);
        let time = SimTime::from_s(time_s).expect("a time");
        let axis = run.motion_at(time).expect("a small swing runs on").q_wb * Vector3::z();
        difference += axis.x * axis.x - axis.y * axis.y;
        product += 2.0 * axis.x * axis.y;
    }
    0.5 * product.atan2(difference)
}

#[test]
fn a_small_elliptic_swing_turns_at_the_rate_of_its_closed_form() {
    let body = symmetric_body_on_a_free_thread();
    let p = body.params();
    let (a, sway) = (p.inertia_kg_m2[0], p.mass_kg * p.com_depth_m.powi(2));
    let swing_rad_s = (p.mass_kg * p.gravity_m_s2 * p.com_depth_m / a).sqrt();
    for (tilt_deg, tolerance) in [(5.0, 0.01), (2.0, 0.002)] {
        let (long_rad, short_rad) = (tilt_deg * RAD_PER_DEG, 0.1 * tilt_deg * RAD_PER_DEG);
        let omega_wb_b_rad_s = [0.0, swing_rad_s * short_rad, 0.0];
        let start = StartState { tilt_rad: long_rad, omega_wb_b_rad_s, ..StartState::AT_REST };
        let mut run = TruthMotion::new(body, &start, RECORD).unwrap();
        // Periods of this amplitude, so that moments close.
        let period_s = period_by_quadrature_s(&body, long_rad);
        let periods = 100.0;
        let first_rad = long_axis_rad(&mut run, 0.0, period_s);
        let last_rad = long_axis_rad(&mut run, periods * period_s, period_s);
        let turned = (last_rad - first_rad).rem_euclid(FRAC_PI_2 * 2.0);
        let rate_rad_s = turned / (periods * period_s);
        let expected = swing_rad_s * long_rad * short_rad * (3.0 / 8.0 + sway / (2.0 * a));
        println!("{tilt_deg} deg: {rate_rad_s:.4e} rad/s, closed form {expected:.4e}");
        // To second order in the amplitudes; the next is of relative order tilt², 0.8 % and 0.1 %.
        assert!((rate_rad_s / expected - 1.0).abs() < tolerance, "{tilt_deg} deg: {rate_rad_s:e}");
        // Without string nor difference of moments the body keeps its rate about its own axis.
        let end = run.motion_at(SimTime::from_s(200.0).unwrap()).unwrap();
        assert!(end.omega_wb_b_rad_s.z.abs() < 1e-14, "{}", end.omega_wb_b_rad_s.z);
    }
}
