//! What gyros on the body read: coning, misalignment, mean rates, the Earth, specific force.

use nalgebra::Vector3;
use std::f64::consts::TAU;
use struna_body::{
    Body, BodyParams, Drag, EARTH_RATE_RAD_S, Integrator, Mounting, Rig, StartState, Support,
    Torsion, TorsionDamping, TorsionStiffness, TruthMotion, Vibration, earth_rate_w_rad_s,
    reference,
};
use struna_kernel::{BodyMotion, RAD_PER_DEG, SampleGrid, SimTime};

const RK4_1MS: Integrator = Integrator::Rk4 { step_s: 1e-3 };
/// Ten times tighter than any difference that these tests look for.
const JUDGE: Integrator = Integrator::Dop853 { rtol: 1e-13, atol: 1e-13 };
const GRAVITY_M_S2: f64 = 9.81;

fn at_ms(ms: i64) -> SimTime {
    SimTime::from_ns(ms * 1_000_000)
}

fn body(inertia_kg_m2: [f64; 3]) -> Body {
    Body::new(&BodyParams { inertia_kg_m2, ..reference::PARAMS }).expect("a sound body")
}

fn symmetric_body() -> Body {
    body([0.0105, 0.0105, 0.0120])
}

fn run(rig: impl Into<Rig>, start: &StartState, integrator: Integrator) -> TruthMotion {
    TruthMotion::new(rig, start, integrator).expect("the rigs of these tests are sound")
}

fn motion(run: &mut TruthMotion, time: SimTime) -> BodyMotion {
    run.motion_at(time).expect("the motions of these tests run on")
}

/// Angular frequency of small swings of [`symmetric_body`], rad/s.
fn swing_rad_s() -> f64 {
    (0.1 * GRAVITY_M_S2 / 0.0105_f64).sqrt()
}

/// A whole turn of twist, and a swing along an ellipse of semi-axes `tilt_rad` and `ratio` times
/// it, counterclockwise from above.
fn elliptic(tilt_rad: f64, ratio: f64) -> StartState {
    let across_rad_s = ratio * tilt_rad * swing_rad_s();
    StartState {
        tilt_rad,
        twist_rad: TAU,
        omega_wb_b_rad_s: [0.0, across_rad_s, 0.0],
        ..StartState::AT_REST
    }
}

/// What a perfect gyro on the axis adds up over 480 s beyond the change of the twist, degrees.
fn excess_deg(rig: Rig, start: &StartState) -> f64 {
    let mut run = run(rig, start, RK4_1MS);
    let (first, last) = (motion(&mut run, SimTime::ZERO), motion(&mut run, at_ms(480_000)));
    let spin_rad = last.spin_rad - first.spin_rad;
    (spin_rad - (last.twist_rad - first.twist_rad)) / RAD_PER_DEG
}

#[test]
fn an_elliptic_swing_hides_its_solid_angle_from_the_gyro_on_the_axis() {
    // Swing in degrees, ratio of the axes, and the excess of a simulation by another program, in
    // the digits that were printed.
    for (tilt_deg, ratio, printed_deg, digit_deg) in [
        (1.0, 0.1, -4.05, 0.01),
        (1.0, 1.0, -40.5, 0.1),
        (2.0, 0.1, -16.2, 0.1),
        (5.0, 0.1, -101.0, 1.0),
        (5.0, 0.0, 0.0, 0.1),
    ] {
        let tilt_rad = tilt_deg * RAD_PER_DEG;
        let excess_deg = excess_deg(symmetric_body().into(), &elliptic(tilt_rad, ratio));
        println!("{tilt_deg} deg, b/a = {ratio}: {excess_deg:.3} deg");
        assert!((excess_deg - printed_deg).abs() <= 0.5 * digit_deg, "{excess_deg} deg");
        // The area of the ellipse once per period, to second order in the tilt: the next term is
        // a share θ² of it, with a coefficient below one. RK4 holds 1e-7 rad at this step.
        let area_deg = -0.5 * swing_rad_s() * tilt_rad.powi(2) * ratio * 480.0 / RAD_PER_DEG;
        let tolerance_deg = tilt_rad.powi(2) * area_deg.abs() + 6e-6;
        assert!((excess_deg - area_deg).abs() < tolerance_deg, "{excess_deg}, {area_deg} deg");
    }
}

#[test]
fn a_damped_elliptic_swing_hides_the_area_of_its_spiral() {
    // Swing damped to a hundredth of critical by the air: 2 A ζ ω_s.
    let ratio = 0.01;
    let drag = Drag { rotation_n_m_s_rad: 2.0 * 0.0105 * ratio * swing_rad_s(), ..Drag::NONE };
    let rig = Rig { drag, ..symmetric_body().into() };
    let tilt_rad = 5.0 * RAD_PER_DEG;
    let excess_deg = excess_deg(rig, &elliptic(tilt_rad, 0.1));
    println!("damped: {excess_deg:.4} deg");
    // Printed by another program to two digits.
    assert!((excess_deg + 1.1).abs() < 0.05, "{excess_deg} deg");
    // The area rate falls as e^{−2ζω_s t}; second order in tilt and in ζ again.
    let area_deg = -0.1 * tilt_rad.powi(2) / (4.0 * ratio) / RAD_PER_DEG;
    assert!((excess_deg / area_deg - 1.0).abs() < 0.01, "{excess_deg}, {area_deg} deg");
}

#[test]
fn a_tilted_input_axis_reads_the_swing() {
    // Swing in degrees, and the rate that one degree of misalignment reads, deg/s, as printed.
    for (tilt_deg, printed_deg_s) in [(1.0, 0.17), (2.0, 0.34), (5.0, 0.84), (10.0, 1.69)] {
        let tilt_rad = tilt_deg * RAD_PER_DEG;
        // A swing about x is read by an axis turned about y, and one about y by one turned about
        // x; the axis that stays in the plane of the swing reads nothing.
        for (azimuth_rad, seeing, blind) in
            [(0.0, [0.0, 1.0], [1.0, 0.0]), (TAU / 4.0, [1.0, 0.0], [0.0, 1.0])]
        {
            let mount = |turns: [f64; 2]| {
                Mounting::new(turns.map(|turn| turn * RAD_PER_DEG), [0.0; 3]).unwrap()
            };
            let start =
                StartState { tilt_rad, tilt_azimuth_rad: azimuth_rad, ..StartState::AT_REST };
            let mut run = run(symmetric_body(), &start, JUDGE);
            let rates: Vec<_> = (0..10_000)
                .map(|k| {
                    let motion = motion(&mut run, at_ms(k));
                    assert!(mount(blind).rate_rad_s(&motion).abs() < 1e-12);
                    mount(seeing).rate_rad_s(&motion)
                })
                .collect();
            let amplitude = rates.iter().fold(0.0_f64, |a, b| a.max(b.abs())) / RAD_PER_DEG;
            let closed_form_deg_s = swing_rad_s() * tilt_deg * 1.0_f64.to_radians().sin();
            assert!((closed_form_deg_s - printed_deg_s).abs() <= 0.005, "{closed_form_deg_s}");
            // To second order in the tilt: the amplitude of the rate falls by θ²·(1/24 + …).
            assert!((amplitude / closed_form_deg_s - 1.0).abs() < tilt_rad.powi(2));
            let passages = rates.windows(2).filter(|pair| pair[0] * pair[1] < 0.0).count();
            let frequency_hz = passages as f64 / 20.0;
            // The swing's own frequency; half a passage uncertain at each end of ten seconds, and
            // θ²·0.3 slower.
            assert!((frequency_hz - 1.538).abs() < 0.05 + tilt_rad.powi(2), "{frequency_hz} Hz");
        }
    }
}

/// Motions in which everything that a gyro could miss is present.
fn rich_rigs() -> [Rig; 2] {
    let vibration =
        Vibration { amplitude_w_m: [0.02, 0.01, 0.003], frequency_hz: 0.9, phase_rad: 0.5 };
    let params =
        BodyParams { com_offset_m: [0.01, -0.02], products_kg_m2: [1e-3; 3], ..reference::PARAMS };
    let full = Rig {
        string_length_m: Some(1.5),
        support: Support { vibrations: vec![vibration], ..Support::default() },
        // A planet that turns in a minute: the Earth's share must show.
        earth_rate_w_rad_s: Vector3::new(0.02, 0.05, -0.1),
        ..Body::new(&params).expect("a sound body").into()
    };
    [body(reference::PARAMS.inertia_kg_m2).into(), full]
}

#[test]
fn the_mean_rate_of_a_sample_is_the_integral_of_the_rate_over_it() {
    let mounting = Mounting::new([0.02, -0.05], [0.1, 0.0, 0.0]).unwrap();
    for (rig, integrator) in rich_rigs()
        .into_iter()
        .flat_map(|rig| [RK4_1MS, JUDGE].map(|integrator| (rig.clone(), integrator)))
    {
        let grid = SampleGrid::new(SimTime::ZERO, 300.0).unwrap();
        let mut run = run(rig, &reference::S3, integrator);
        for k in 0..600 {
            let (from, to) = (grid.time_of(k), grid.time_of(k + 1));
            let span_s = to.seconds_since(from);
            let mut at_node = |node: i64| {
                let ns = (to.as_ns() - from.as_ns()) * node / 10;
                motion(&mut run, SimTime::from_ns(from.as_ns() + ns))
            };
            let first = mounting.angle_rad(&at_node(0));
            // Simpson's rule on ten intervals; the ends of a sample are whole nanoseconds.
            let integral: f64 = (0..=10)
                .zip([1.0, 4.0, 2.0, 4.0, 2.0, 4.0, 2.0, 4.0, 2.0, 4.0, 1.0])
                .map(|(node, weight)| weight * mounting.rate_rad_s(&at_node(node)) * span_s / 30.0)
                .sum();
            let last = mounting.angle_rad(&at_node(10));
            // Nodes rounded to the nanosecond in 0.3 ms at a rate that changes by 20 rad/s².
            let gap_rad = last - first - integral;
            assert!(gap_rad.abs() < 2e-11, "{integrator:?}, sample {k}: {gap_rad:e} rad");
        }
    }
}

fn on_earth(latitude_rad: f64) -> Rig {
    let earth = earth_rate_w_rad_s(latitude_rad);
    Rig { earth_rate_w_rad_s: earth, ..symmetric_body().into() }
}

#[test]
fn a_body_at_rest_reads_the_rate_of_the_earth() {
    for latitude_deg in [-90.0, -33.0, 0.0, 55.75, 90.0] {
        let latitude_rad = latitude_deg * RAD_PER_DEG;
        let mut run = run(on_earth(latitude_rad), &StartState::AT_REST, RK4_1MS);
        let motion = motion(&mut run, at_ms(100_000));
        let rate = motion.omega_ib_b_rad_s;
        let (sin, cos) = latitude_rad.sin_cos();
        // Products of three numbers below 1e-4.
        assert!((rate.z - EARTH_RATE_RAD_S * sin).abs() < 1e-19, "{latitude_deg}: {rate}");
        assert!((rate.y - EARTH_RATE_RAD_S * cos).abs() < 1e-19, "{latitude_deg}: {rate}");
        assert!(rate.x == 0.0, "{latitude_deg}: {rate}");
        // An axis turned from the vertical by α towards north reads Ω sin(φ + α).
        let lean_rad = 0.6;
        let north = Mounting::new([-lean_rad, 0.0], [0.0; 3]).unwrap();
        let expected = EARTH_RATE_RAD_S * (latitude_rad + lean_rad).sin();
        assert!((north.rate_rad_s(&motion) - expected).abs() < 1e-18, "{latitude_deg}");
        // A hundred thousand roundings of 7e-3 rad.
        assert!((north.angle_rad(&motion) - 100.0 * expected).abs() < 1e-14, "{latitude_deg}");
        // The motion itself is against the room.
        assert!(motion.omega_wb_b_rad_s == Vector3::zeros() && motion.spin_rad == 0.0);
    }
}

#[test]
fn a_body_that_turns_sees_the_horizontal_rate_of_the_earth_go_round() {
    let latitude_rad = 55.75 * RAD_PER_DEG;
    let (sin, cos) = latitude_rad.sin_cos();
    let lean_rad = 0.3_f64;
    let mounting = Mounting::new([-lean_rad, 0.0], [0.0; 3]).unwrap();
    let mut run = run(on_earth(latitude_rad), &reference::S1, RK4_1MS);
    let (mut least, mut most) = (f64::INFINITY, -f64::INFINITY);
    for second in 0..=240 {
        let motion = motion(&mut run, at_ms(1000 * second));
        let (twist_sin, twist_cos) = motion.twist_rad.sin_cos();
        // North in body axes turns back as the body turns on.
        let horizontal = Vector3::new(twist_sin, twist_cos, 0.0) * (EARTH_RATE_RAD_S * cos);
        let earth = horizontal + Vector3::z() * (EARTH_RATE_RAD_S * sin);
        let expected = motion.omega_wb_b_rad_s + earth;
        // The quaternion and the twist, integrated apart, differ by 1e-12 rad.
        assert!((motion.omega_ib_b_rad_s - expected).norm() < 1e-15, "{second} s");
        let own = mounting.input_axis_b().dot(&motion.omega_wb_b_rad_s);
        let seen = mounting.rate_rad_s(&motion) - own;
        (least, most) = (least.min(seen), most.max(seen));
    }
    // Half a torsion period is two turns of the body: both extremes are passed, within a second
    // of a rotation of up to 0.08 rad/s.
    let swing = EARTH_RATE_RAD_S * cos * lean_rad.sin();
    assert!(((most - least) / (2.0 * swing) - 1.0).abs() < 0.08_f64.powi(2), "{least} {most}");
    let middle = EARTH_RATE_RAD_S * sin * lean_rad.cos();
    assert!((0.5 * (most + least) / middle - 1.0).abs() < 1e-2);
}

#[test]
fn at_rest_the_specific_force_is_gravity_upwards_anywhere_on_the_body() {
    let body = symmetric_body();
    for position_b_m in [[0.0; 3], [0.2, -0.1, 0.05]] {
        let mounting = Mounting::new([0.1, 0.2], position_b_m).unwrap();
        let motion = motion(&mut run(body, &StartState::AT_REST, RK4_1MS), at_ms(10_000));
        let force = mounting.specific_force_b_m_s2(&motion, &body.suspension_b_m(), GRAVITY_M_S2);
        assert!((force - Vector3::z() * GRAVITY_M_S2).norm() < 1e-14, "{force}");
    }
}

#[test]
fn on_a_spinning_body_the_specific_force_points_inwards() {
    let torsion = Torsion {
        stiffness: TorsionStiffness::ConstantNMRad(0.0),
        damping: TorsionDamping::Ratio(0.0),
    };
    let body = Body::new(&BodyParams { torsion, ..*symmetric_body().params() }).unwrap();
    let (spin_rad_s, radius_m) = (5.0_f64, 0.3);
    let mut run = run(body, &StartState::twisted(0.0, spin_rad_s), JUDGE);
    let motion = motion(&mut run, at_ms(3000));
    for (place, inwards) in [
        ([radius_m, 0.0, 0.1], Vector3::new(-1.0, 0.0, 0.0)),
        ([0.0, radius_m, -0.2], Vector3::new(0.0, -1.0, 0.0)),
    ] {
        let mounting = Mounting::new([0.0; 2], place).unwrap();
        let force = mounting.specific_force_b_m_s2(&motion, &body.suspension_b_m(), GRAVITY_M_S2);
        let expected = inwards * (radius_m * spin_rad_s.powi(2)) + Vector3::z() * GRAVITY_M_S2;
        // Ten m/s² in some roundings.
        assert!((force - expected).norm() < 1e-13, "{force}");
    }
}

#[test]
fn the_specific_force_is_the_second_derivative_of_the_place_less_gravity() {
    let place = Vector3::new(0.15, -0.08, 0.06);
    let mounting = Mounting::new([0.0; 2], place.into()).unwrap();
    for rig in rich_rigs() {
        let suspension = rig.body.suspension_b_m();
        let mut run = run(rig, &reference::S3, JUDGE);
        let h = 4e-3;
        let motions: Vec<_> = (0..=500).map(|k| motion(&mut run, at_ms(4 * k))).collect();
        let at = |m: &BodyMotion| m.com_position_w_m + m.q_wb * (suspension + place);
        for window in motions.windows(5) {
            let [a, b, middle, c, d] = window else { unreachable!("windows of five") };
            let near = (at(b) + at(c)) * 16.0 - (at(a) + at(d)) - at(middle) * 30.0;
            let second = near / (12.0 * h * h) + Vector3::z() * GRAVITY_M_S2;
            let expected = middle.q_wb.inverse_transform_vector(&second);
            let force = mounting.specific_force_b_m_s2(middle, &suspension, GRAVITY_M_S2);
            // Five points: h⁴/90 of a sixth derivative of up to 1e5 m/s⁶, and rounding of 1e-16 m
            // and of the motion's 1e-13 rad over h².
            assert!((force - expected).norm() < 1e-6, "{}: {}", middle.time, force - expected);
        }
    }
}
