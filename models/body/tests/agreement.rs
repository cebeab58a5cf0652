//! Two integrators, an independent program and a closed form must tell the same motion.
//!
//! The outside reference is SciPy 1.17, `solve_ivp(method="DOP853", rtol=3e-14, atol=1e-14)`, on
//! the equations written with a full 3×3 solve instead of the closed inverse used here. Its two
//! tightest tolerances differ by 2e-11 rad at 60 s and 4e-10 rad at 480 s.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use struna_body::{
    Body, BodyParams, DampedTorsion, Integrator, StartState, Torsion, TorsionDamping,
    TorsionStiffness, TruthMotion, reference,
};
use struna_kernel::{BodyMotion, SampleGrid, SimTime};

const RK4_1MS: Integrator = Integrator::Rk4 { step_s: 1e-3 };
const RECORD: Integrator = Integrator::Dop853 { rtol: 1e-12, atol: 1e-12 };

fn truth(start: &StartState, integrator: Integrator) -> TruthMotion {
    let body = Body::new(&reference::PARAMS).expect("the reference body is sound");
    TruthMotion::new(body, start, integrator).expect("the reference starts are sound")
}

fn at(seconds: i64) -> SimTime {
    SimTime::from_ns(seconds * 1_000_000_000)
}

fn attitude_difference_rad(a: &BodyMotion, b: &UnitQuaternion<f64>) -> f64 {
    // Not `angle_to`: its arc cosine loses half the digits near zero.
    2.0 * (a.q_wb.inverse() * b).imag().norm().asin()
}

/// SciPy's S3: seconds, quaternion (w, x, y, z), twist, spin.
type ScipyRow = (i64, [f64; 4], f64, f64);
const SCIPY_S3: [ScipyRow; 2] = [
    (
        60,
        [-0.020746770969104922, -0.010517049155522203, -0.004688557756863068, -0.9997184506637742],
        34.51601991860683,
        35.55624732075822,
    ),
    (
        480,
        [0.5839830544936803, -0.0715312935670036, -0.01705116783654447, -0.8084283046629873],
        10.675940153723287,
        10.833150034505337,
    ),
];

#[test]
fn v2_adaptive_runs_end_where_scipy_ends() {
    let mut run = truth(&reference::S3, RECORD);
    for (seconds, [w, x, y, z], twist_rad, spin_rad) in SCIPY_S3 {
        let motion = run.motion_at(at(seconds)).unwrap();
        let q_wb = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        let attitude_rad = attitude_difference_rad(&motion, &q_wb);
        println!(
            "SciPy, {seconds} s: attitude {attitude_rad:.2e}, twist {:.2e}, spin {:.2e} rad",
            motion.twist_rad - twist_rad,
            motion.spin_rad - spin_rad
        );
        // Demand of cross-validation; the tolerance 1e-12 itself costs 4e-10 to 7e-10 rad by 480 s.
        assert!(attitude_rad < 1e-9, "attitude {attitude_rad:e} at {seconds} s");
        assert!((motion.twist_rad - twist_rad).abs() < 1e-9, "twist at {seconds} s");
        assert!((motion.spin_rad - spin_rad).abs() < 1e-9, "spin at {seconds} s");
    }
}

#[test]
fn v1_fixed_and_adaptive_steps_agree_over_eight_minutes() {
    let (mut fixed, mut record) = (truth(&reference::S3, RK4_1MS), truth(&reference::S3, RECORD));
    let mut worst_rad = 0.0_f64;
    for seconds in 1..=480 {
        let (a, b) =
            (fixed.motion_at(at(seconds)).unwrap(), record.motion_at(at(seconds)).unwrap());
        worst_rad = worst_rad.max(attitude_difference_rad(&a, &b.q_wb));
        worst_rad = worst_rad.max((a.twist_rad - b.twist_rad).abs());
    }
    println!("RK4 1 ms against DOP853 1e-12: {worst_rad:.2e} rad");
    // Demand of cross-validation: twice the 4.6e-8 rad that RK4 errs by at this step.
    assert!(worst_rad < 1e-7, "{worst_rad:e} rad");
}

#[test]
fn halving_the_step_cuts_the_motion_error_sixteenfold() {
    let exact = truth(&reference::S3, RECORD).motion_at(at(60)).unwrap();
    let error_rad = |step_s: f64| {
        let mut run = truth(&reference::S3, Integrator::Rk4 { step_s });
        attitude_difference_rad(&run.motion_at(at(60)).unwrap(), &exact.q_wb)
    };
    let (coarse, fine) = (error_rad(2e-3), error_rad(1e-3));
    println!("RK4, S3, 60 s: {coarse:.2e} rad at 2 ms, {fine:.2e} rad at 1 ms");
    let order = (coarse / fine).log2();
    assert!((order - 4.0).abs() < 0.1, "observed order {order:.3}");
}

#[test]
fn without_swing_the_motion_is_the_closed_form_of_damped_torsion() {
    for (ratio, start) in [
        (0.0, reference::S1),
        (0.1, reference::S1),
        (1.0, StartState::twisted(1.0, -0.3)),
        (2.0, StartState::twisted(-2.0, 0.5)),
    ] {
        let torsion = Torsion {
            stiffness: TorsionStiffness::PeriodS(480.0),
            damping: TorsionDamping::Ratio(ratio),
        };
        let body = Body::new(&BodyParams { torsion, ..reference::PARAMS }).unwrap();
        let closed = DampedTorsion::new(&body, start.twist_rad, start.omega_wb_b_rad_s[2]);
        // Half a million roundings of up to 2π add up to 4e-13; the record's error is rtol·2π a
        // few times over.
        for (integrator, tolerance_rad) in [(RK4_1MS, 1.5e-12), (RECORD, 1e-10)] {
            let mut run = TruthMotion::new(body, &start, integrator).unwrap();
            let mut worst_rad = 0.0_f64;
            for seconds in 0..=480_i32 {
                let motion = run.motion_at(at(i64::from(seconds))).unwrap();
                let time_s = f64::from(seconds);
                worst_rad = worst_rad.max((motion.twist_rad - closed.twist_rad(time_s)).abs());
                let rate_error = motion.twist_rate_rad_s - closed.twist_rate_rad_s(time_s);
                worst_rad = worst_rad.max(rate_error.abs());
                assert!(motion.omega_wb_b_rad_s.xy().norm() == 0.0, "torsion must not swing");
            }
            println!("ratio {ratio}, {integrator:?}: {worst_rad:.2e} rad from the closed form");
            assert!(worst_rad < tolerance_rad, "ratio {ratio}, {integrator:?}: {worst_rad:e}");
        }
    }
}

#[test]
fn the_motion_does_not_depend_on_the_output_rate() {
    for integrator in [RK4_1MS, RECORD] {
        let mut runs = [300.0, 1400.0, 1.0].map(|rate_hz| {
            let grid = SampleGrid::new(SimTime::ZERO, rate_hz).unwrap();
            let mut run = truth(&reference::S3, integrator);
            let samples = grid.periods_until(at(5));
            (0..=samples).map(|k| run.motion_at(grid.time_of(k)).unwrap()).last().unwrap()
        });
        let [slow, medium, fast] = &mut runs;
        assert_eq!(slow, medium, "{integrator:?}");
        assert_eq!(slow, fast, "{integrator:?}");
    }
}

#[test]
fn samples_off_the_step_grid_lie_on_the_motion() {
    // 300 Hz against a 1 ms grid: two samples of three need a shortened step.
    let grid = SampleGrid::new(SimTime::ZERO, 300.0).unwrap();
    let (mut fixed, mut record) = (truth(&reference::S3, RK4_1MS), truth(&reference::S3, RECORD));
    for k in 0..=3000 {
        let a = fixed.motion_at(grid.time_of(k)).unwrap();
        let b = record.motion_at(grid.time_of(k)).unwrap();
        // RK4 errs by 7.5e-9 rad in 60 s at this step, so by a sixth of it in 10 s; rates move
        // at up to 10/s.
        assert!(attitude_difference_rad(&a, &b.q_wb) < 2e-9, "sample {k}");
        assert!((a.omega_wb_b_rad_s - b.omega_wb_b_rad_s).norm() < 2e-8, "sample {k}");
    }
}

#[test]
fn a_held_axial_torque_shifts_the_equilibrium_by_torque_over_stiffness() {
    let body = Body::new(&reference::PARAMS).unwrap();
    let shift_rad = 0.5;
    let torque = Vector3::z() * (shift_rad * body.stiffness_n_m_rad());
    // In the shifted frame the motion is free torsion from minus the shift.
    let closed = DampedTorsion::new(&body, -shift_rad, 0.0);
    for integrator in [RK4_1MS, RECORD] {
        let mut run = TruthMotion::new(body, &StartState::AT_REST, integrator).unwrap();
        run.motion_at(at(10)).unwrap();
        run.set_torque(torque).unwrap();
        for seconds in 10..=100_i32 {
            let motion = run.motion_at(at(i64::from(seconds))).unwrap();
            let expected = shift_rad + closed.twist_rad(f64::from(seconds - 10));
            // Torque over moment over 90 s in 1e5 roundings, or rtol accumulated.
            assert!((motion.twist_rad - expected).abs() < 1e-11, "{integrator:?}, {seconds} s");
        }
    }
}

#[test]
fn a_torque_set_between_grid_points_acts_from_that_instant() {
    let body = Body::new(&reference::PARAMS).unwrap();
    let switch = SimTime::from_s(1.234_567_891).unwrap();
    let end_of = |integrator| {
        let mut run = TruthMotion::new(body, &reference::S3, integrator).unwrap();
        run.motion_at(switch).unwrap();
        run.set_torque(Vector3::new(0.02, -0.03, 0.001)).unwrap();
        run.motion_at(at(11)).unwrap()
    };
    let (fixed, record) = (end_of(RK4_1MS), end_of(RECORD));
    let free = truth(&reference::S3, RECORD).motion_at(at(11)).unwrap();
    assert!(attitude_difference_rad(&record, &free.q_wb) > 1e-3, "the torque must act");
    // The figure of `samples_off_the_step_grid_lie_on_the_motion`.
    assert!(attitude_difference_rad(&fixed, &record.q_wb) < 2e-9);
}
