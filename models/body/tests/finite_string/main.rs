//! A string of finite length on a support that may move: the demands on its motion.

mod limits;
mod linear;
mod redundant;
mod shaken;

use nalgebra::{UnitQuaternion, Vector3};
use redundant::Redundant;
use std::f64::consts::TAU;
use struna_body::{
    Body, BodyParams, Integrator, Rig, StartState, Support, Torsion, TorsionDamping,
    TorsionStiffness, TruthMotion, Vibration, reference,
};
use struna_kernel::{BodyMotion, SimTime};

const RK4_1MS: Integrator = Integrator::Rk4 { step_s: 1e-3 };
/// Ten times tighter than any difference that these tests look for.
const JUDGE: Integrator = Integrator::Dop853 { rtol: 1e-13, atol: 1e-13 };
const LENGTH_M: f64 = 2.0;

fn at_ms(ms: i64) -> SimTime {
    SimTime::from_ns(ms * 1_000_000)
}

fn hung(length_m: f64) -> Rig {
    let body = Body::new(&reference::PARAMS).expect("the reference body is sound");
    Rig { string_length_m: Some(length_m), ..body.into() }
}

/// An infinite string in the full equations: the vibration without amplitude rules out the plain
/// ones.
fn infinite() -> Rig {
    let nothing = Vibration { amplitude_w_m: [0.0; 3], frequency_hz: 1.0, phase_rad: 0.0 };
    let support = Support { vibrations: vec![nothing], ..Support::default() };
    Rig { string_length_m: None, support, ..hung(LENGTH_M) }
}

/// Two centimetres at 0.3 Hz along x, one at 0.35 Hz along y, two millimetres at 1 Hz upwards.
const SHAKING: [([f64; 3], f64); 3] =
    [([0.02, 0.0, 0.0], 0.3), ([0.0, 0.01, 0.0], 0.35), ([0.0, 0.0, 0.002], 1.0)];

fn shaken(rig: Rig) -> Rig {
    let vibration =
        |(amplitude_w_m, frequency_hz)| Vibration { amplitude_w_m, frequency_hz, phase_rad: 0.0 };
    let vibrations = SHAKING.into_iter().map(vibration).collect();
    Rig { support: Support { vibrations, ..Support::default() }, ..rig }
}

/// Displacement, velocity and acceleration of the shaken support, written out once more.
fn shaking(time_s: f64) -> [Vector3<f64>; 3] {
    let mut sum = [Vector3::zeros(); 3];
    for (amplitude, frequency_hz) in SHAKING {
        let (w, amplitude) = (TAU * frequency_hz, Vector3::from(amplitude));
        let (sin, cos) = (w * time_s).sin_cos();
        sum[0] += amplitude * sin;
        sum[1] += amplitude * (w * cos);
        sum[2] -= amplitude * (w * w * sin);
    }
    sum
}

fn still(_time_s: f64) -> [Vector3<f64>; 3] {
    [Vector3::zeros(); 3]
}

fn run(rig: &Rig, start: &StartState, integrator: Integrator) -> TruthMotion {
    TruthMotion::new(rig.clone(), start, integrator).expect("the rigs of these tests are sound")
}

fn motion(run: &mut TruthMotion, time: SimTime) -> BodyMotion {
    run.motion_at(time).expect("the motions of these tests run on")
}

fn difference_rad(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>) -> f64 {
    // Not `angle_to`: its arc cosine loses half the digits near zero.
    2.0 * (a.inverse() * b).imag().norm().asin()
}

/// Largest difference of attitude over every second up to `seconds`.
fn apart_rad(a: &mut TruthMotion, b: &mut TruthMotion, seconds: i64) -> f64 {
    (1..=seconds).fold(0.0, |worst, second| {
        let time = at_ms(1000 * second);
        let apart = difference_rad(&motion(a, time).q_wb, &motion(b, time).q_wb);
        f64::max(worst, apart)
    })
}

/// Where the string holds the body, from its place in equilibrium.
fn suspension_w_m(body: &Body, motion: &BodyMotion) -> Vector3<f64> {
    motion.com_position_w_m + motion.q_wb * body.suspension_b_m()
}

/// Pull of the string on the body, by Newton's law for its centre of mass.
fn pull_w_n(body: &Body, motion: &BodyMotion) -> Vector3<f64> {
    let p = body.params();
    (motion.com_acceleration_w_m_s2 + Vector3::z() * p.gravity_m_s2) * p.mass_kg
}

#[test]
fn b7_the_string_keeps_its_length_whether_its_support_moves_or_not() {
    for (rig, support) in
        [(hung(LENGTH_M), still as fn(f64) -> _), (shaken(hung(LENGTH_M)), shaking)]
    {
        for integrator in [RK4_1MS, JUDGE] {
            let mut run = run(&rig, &reference::S3, integrator);
            let mut worst_m = 0.0_f64;
            for k in 0..=4800 {
                let time = at_ms(100 * k);
                let motion = motion(&mut run, time);
                let [shift, ..]: [Vector3<f64>; 3] = support(time.as_s());
                let reach = Vector3::z() * LENGTH_M + shift - suspension_w_m(&rig.body, &motion);
                worst_m = worst_m.max((reach.norm() - LENGTH_M).abs());
            }
            println!("length, {integrator:?}: {worst_m:.1e} m");
            // Demanded of the form; heights are computed from the other two coordinates, so only
            // rounding of metres remains.
            assert!(worst_m < 1e-12, "{integrator:?}: {worst_m:e} m");
        }
    }
}

#[test]
fn the_pull_of_the_string_lies_along_it() {
    let rig = shaken(hung(LENGTH_M));
    let mut run = run(&rig, &reference::S3, RK4_1MS);
    for k in 0..=1200 {
        let time = at_ms(100 * k);
        let motion = motion(&mut run, time);
        let [shift, ..] = shaking(time.as_s());
        let reach = Vector3::z() * LENGTH_M + shift - suspension_w_m(&rig.body, &motion);
        let pull = pull_w_n(&rig.body, &motion);
        // Ten newtons times metres in some tens of roundings.
        assert!(pull.cross(&reach).norm() < 1e-13, "{time}");
        // Weight of 9.81 N, 0.8 of which swing and shaking can give or take.
        assert!((pull.norm() - 9.81).abs() < 1.0 && pull.z > 0.0, "{time}: {pull}");
    }
}

#[test]
fn b7_steps_of_a_millisecond_follow_the_string_for_eight_minutes() {
    let rig = hung(LENGTH_M);
    // The worst of every second, and the last.
    let errors_rad = |step_s| {
        let mut fixed = run(&rig, &reference::S3, Integrator::Rk4 { step_s });
        let mut record = run(&rig, &reference::S3, JUDGE);
        let worst_rad = apart_rad(&mut fixed, &mut record, 479);
        let last = [&mut fixed, &mut record].map(|run| motion(run, at_ms(480_000)).q_wb);
        (worst_rad, difference_rad(&last[0], &last[1]))
    };
    let errors = [2e-3, 1e-3, 5e-4, 2.5e-4].map(|step_s| (step_s, errors_rad(step_s)));
    for (step_s, (worst_rad, last_rad)) in errors {
        println!("RK4 {step_s} s on a finite string: {worst_rad:.1e}, at last {last_rad:.1e} rad");
    }
    // Demanded: twice the 5e-8 rad that this form errs by.
    let (worst_rad, _) = errors[1].1;
    assert!(worst_rad < 1e-7, "{worst_rad:e} rad");
    for pair in errors.windows(2) {
        let order = (pair[0].1.1 / pair[1].1.1).log2();
        // Demanded. At the last instant, because the worst ones of two steps are not the same
        // instant; 4 ms are left out, where h⁵ still shows (4.7 from there to 2 ms).
        assert!((3.8..4.7).contains(&order), "observed order {order:.3}");
    }
}

#[test]
fn b7_energy_is_conserved_on_a_finite_string() {
    let rig = hung(LENGTH_M);
    let mut run = run(&rig, &reference::S3, RK4_1MS);
    let start_j = rig.body.energy_j(&motion(&mut run, SimTime::ZERO));
    let worst = (1..=480).fold(0.0_f64, |worst, second| {
        let energy_j = rig.body.energy_j(&motion(&mut run, at_ms(1000 * second)));
        worst.max((energy_j / start_j - 1.0).abs())
    });
    println!("energy on a finite string: {worst:.1e}");
    // Demanded: four times the 5e-9 that RK4 loses at this step.
    assert!(worst < 2e-8, "{worst:e}");
}

#[test]
fn the_momentum_about_the_vertical_through_the_support_is_conserved_without_stiffness() {
    let torsion = Torsion {
        stiffness: TorsionStiffness::ConstantNMRad(0.0),
        damping: TorsionDamping::Ratio(0.0),
    };
    let body = Body::new(&BodyParams { torsion, ..reference::PARAMS }).unwrap();
    let rig = Rig { body, ..hung(LENGTH_M) };
    let start =
        StartState { suspension_w_m: [0.3, 0.0], com_velocity_w_m_s: [0.1, 0.4], ..reference::S3 };
    let mut run = run(&rig, &start, JUDGE);
    let mut momentum = |time| {
        let motion = motion(&mut run, time);
        let orbit = motion.com_position_w_m.cross(&motion.com_velocity_w_m_s).z;
        let about_c = body.vertical_momentum_n_m_s(&motion);
        (body.params().mass_kg * orbit + about_c, about_c)
    };
    let (start_n_m_s, mut about_c) = (momentum(SimTime::ZERO).0, [f64::INFINITY, -f64::INFINITY]);
    for second in 1..=120 {
        let (total, own) = momentum(at_ms(1000 * second));
        about_c = [about_c[0].min(own), about_c[1].max(own)];
        // The tolerance 1e-13 over some ten thousand steps.
        assert!((total / start_n_m_s - 1.0).abs() < 1e-10, "{second} s");
    }
    assert!(about_c[1] - about_c[0] > 1e-4, "a test of nothing: the string exchanged no momentum");
}

/// Both forms at 1 ms over `seconds`: worst difference of attitude, and of the place of C.
fn forms_apart(rig: &Rig, support: redundant::Shaking, seconds: i64) -> (f64, f64) {
    let step_s = 1e-3;
    let judge = Redundant::new(&rig.body, LENGTH_M, support);
    let mut y = judge.states(&reference::S3);
    let mut run = run(rig, &reference::S3, RK4_1MS);
    let mut worst = (0.0_f64, 0.0_f64);
    for k in 0..1000 * seconds {
        y = judge.step(k as f64 * step_s, &y, step_s);
        if (k + 1) % 1000 == 0 {
            let motion = motion(&mut run, at_ms(k + 1));
            let apart_m = (motion.com_position_w_m - y.fixed_rows::<3>(0)).norm();
            let apart_rad = difference_rad(&motion.q_wb, &Redundant::attitude(&y));
            worst = (worst.0.max(apart_rad), worst.1.max(apart_m));
        }
    }
    worst
}

#[test]
fn b7_twice_the_coordinates_give_the_same_motion() {
    for (name, rig, support, seconds) in [
        ("still", hung(LENGTH_M), still as redundant::Shaking, 480),
        ("shaken", shaken(hung(LENGTH_M)), shaking, 120),
    ] {
        let (apart_rad, apart_m) = forms_apart(&rig, support, seconds);
        println!("12 against 14 states, {name}, {seconds} s: {apart_rad:.1e} rad, {apart_m:.1e} m");
        // Demanded; both are RK4 at the same step, whose own error is thirty times that.
        assert!(apart_rad < 1e-9, "{name}: {apart_rad:e} rad");
        // The body is a tenth of a metre long, and the string passes its motion on.
        assert!(apart_m < 1e-9, "{name}: {apart_m:e} m");
    }
}

#[test]
fn b7_the_attitude_differs_from_that_on_an_infinite_string_by_its_inverse_length() {
    // 60 s of S3, against the plain equations, which know no string length at all.
    let apart = |curvature_1_m: f64| {
        let mut plain = run(&hung(1.0).body.into(), &reference::S3, RK4_1MS);
        let mut finite = run(&hung(curvature_1_m.recip()), &reference::S3, RK4_1MS);
        apart_rad(&mut finite, &mut plain, 60)
    };
    for curvature_1_m in [1e-9, 1e-8, 1e-6, 1e-5, 1e-4] {
        let slope_m = apart(curvature_1_m) / curvature_1_m;
        println!("slope at 1/L = {curvature_1_m:e} 1/m: {slope_m:.3} rad m");
        // Demanded: 5.1 rad·m for this motion, a tenth either way for the instants looked at.
        assert!((4.6..5.6).contains(&slope_m), "{curvature_1_m:e}: {slope_m}");
    }
}

#[test]
fn a_string_too_long_to_curve_in_floating_point_is_the_infinite_one_bit_for_bit() {
    let mut endless = run(&infinite(), &reference::S3, RK4_1MS);
    let mut long = run(&hung(1e200), &reference::S3, RK4_1MS);
    for second in 0..=60 {
        let time = at_ms(1000 * second);
        let (a, b) = (motion(&mut endless, time), motion(&mut long, time));
        assert_eq!((a.q_wb, a.twist_rad), (b.q_wb, b.twist_rad), "{time}");
    }
    // The plain equations have other states, and so another truncation: both by the judge.
    let mut endless = run(&infinite(), &reference::S3, JUDGE);
    let mut plain = run(&hung(1.0).body.into(), &reference::S3, JUDGE);
    for second in 0..=60 {
        let time = at_ms(1000 * second);
        let apart =
            difference_rad(&motion(&mut endless, time).q_wb, &motion(&mut plain, time).q_wb);
        // A local tolerance of 1e-13 over thousands of steps.
        assert!(apart < 1e-10, "{time}: {apart:e} rad");
    }
}
