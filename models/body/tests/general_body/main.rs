//! Bodies as they are built: any tensor of inertia, the centre of mass off the string's axis.

mod random;
mod tilted;

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use random::{any_azimuth, any_body, any_start, soft_thread};

use struna_body::{
    Body, BodyError, BodyParams, Disturbances, Integrator, Rig, StartState, Stop, StopReason,
    Support, TorqueNoise, Torsion, TorsionDamping, TorsionStiffness, TruthMotion, Vibration,
};
use struna_kernel::{BodyMotion, SimTime};

const RK4_1MS: Integrator = Integrator::Rk4 { step_s: 1e-3 };
const RECORD: Integrator = Integrator::Dop853 { rtol: 1e-12, atol: 1e-12 };
/// Ten times tighter than any difference that these tests look for.
const JUDGE: Integrator = Integrator::Dop853 { rtol: 1e-13, atol: 1e-13 };
const FREE: Torsion = Torsion {
    stiffness: TorsionStiffness::ConstantNMRad(0.0),
    damping: TorsionDamping::Ratio(0.0),
};

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        failure_persistence: None, // regressions become named tests
        ..Default::default()
    }
}

fn at_ms(ms: i64) -> SimTime {
    SimTime::from_ns(ms * 1_000_000)
}

fn run(rig: impl Into<Rig>, start: &StartState, integrator: Integrator) -> TruthMotion {
    TruthMotion::new(rig, start, integrator).expect("the rigs of these tests are sound")
}

fn motion(run: &mut TruthMotion, time: SimTime) -> BodyMotion {
    run.motion_at(time).expect("the motions of these tests run on")
}

/// The motion of a property's random body; a body that throws itself up until its string goes slack
/// proves nothing and is drawn again.
fn taut(run: &mut TruthMotion, time: SimTime) -> Result<BodyMotion, TestCaseError> {
    run.motion_at(time).map_err(|error| match error {
        BodyError::Stopped(Stop { reason: StopReason::Slack, .. }) => {
            TestCaseError::reject("the string went slack")
        }
        other => TestCaseError::fail(other.to_string()),
    })
}

fn difference_rad(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>) -> f64 {
    // Not `angle_to`: its arc cosine loses half the digits near zero.
    2.0 * (a.inverse() * b).imag().norm().asin()
}

/// Energy above that of the body at rest in its equilibrium, J.
fn energy_j(body: &Body, motion: &BodyMotion) -> f64 {
    let p = body.params();
    let lowest_j = p.mass_kg * p.gravity_m_s2 * (p.com_depth_m - body.suspension_b_m().norm());
    body.energy_j(motion) - lowest_j
}

/// Full equations with the motion of the plain ones: a vibration without amplitude.
fn in_full(body: Body) -> Rig {
    let nothing = Vibration { amplitude_w_m: [0.0; 3], frequency_hz: 1.0, phase_rad: 0.0 };
    Rig { support: Support { vibrations: vec![nothing], ..Support::default() }, ..body.into() }
}

/// `body` described in axes turned by `angle_rad` about its own z axis.
fn in_turned_axes(body: &Body, angle_rad: f64) -> Body {
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), angle_rad);
    let tensor = turn.transpose() * body.inertia_b_kg_m2() * turn;
    let com = turn.transpose() * -body.suspension_b_m();
    let stiffness = TorsionStiffness::ConstantNMRad(body.stiffness_n_m_rad());
    let params = BodyParams {
        com_offset_m: [com.x, com.y],
        inertia_kg_m2: tensor.diagonal().into(),
        products_kg_m2: [tensor.m12, tensor.m13, tensor.m23],
        torsion: Torsion { stiffness, ..body.params().torsion },
        ..*body.params()
    };
    Body::new(&params).expect("the same body in other axes")
}

proptest! {
    #![proptest_config(config(48))]

    #[test]
    fn axes_drawn_otherwise_on_the_body_change_nothing_but_the_twist(
        body in any_body(soft_thread()),
        start in any_start(30.0),
        angle_rad in any_azimuth(),
        length_m in prop::option::of(0.6_f64..5.0),
    ) {
        // The thread's neutral angle is marked on the body: turned axes see it turned, and a
        // clamp turned as far puts it back.
        let rig = Rig { string_length_m: length_m, ..in_full(body) };
        let mut other = Rig { body: in_turned_axes(&body, angle_rad), ..rig.clone() };
        other.support.clamp_rad = angle_rad;
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), angle_rad);
        let omega = turn.transpose() * Vector3::from(start.omega_wb_b_rad_s);
        let turned = StartState {
            twist_rad: start.twist_rad + angle_rad,
            omega_wb_b_rad_s: omega.into(),
            ..start
        };
        let (mut a, mut b) = (run(rig, &start, JUDGE), run(other, &turned, JUDGE));
        for k in 1..=5 {
            let (a, b) = (motion(&mut a, at_ms(300 * k)), motion(&mut b, at_ms(300 * k)));
            // Local errors of 1e-13 in some hundreds of steps, grown by 1.5 s of a motion whose
            // neighbours may part by e^{4t}.
            prop_assert!(difference_rad(&(a.q_wb * turn), &b.q_wb) < 1e-8);
            prop_assert!((a.twist_rad + angle_rad - b.twist_rad).abs() < 1e-8);
            prop_assert!((a.com_position_w_m - b.com_position_w_m).norm() < 1e-8);
            let omega = turn * b.omega_wb_b_rad_s - a.omega_wb_b_rad_s;
            prop_assert!(omega.norm() < 1e-7, "{omega}");
            let acceleration = b.com_acceleration_w_m_s2 - a.com_acceleration_w_m_s2;
            prop_assert!(acceleration.norm() < 1e-5, "{acceleration}");
        }
    }

    #[test]
    fn the_room_may_be_turned_about_the_vertical(
        body in any_body(soft_thread()),
        start in any_start(30.0),
        angle_rad in any_azimuth(),
        length_m in prop::option::of(0.6_f64..5.0),
    ) {
        let rig = Rig { string_length_m: length_m, ..in_full(body) };
        let mut other = rig.clone();
        other.support.clamp_rad = angle_rad;
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), angle_rad);
        let velocity = turn * Vector3::new(0.1, -0.2, 0.0);
        let start = StartState { com_velocity_w_m_s: [0.1, -0.2], ..start };
        let turned = StartState {
            twist_rad: start.twist_rad + angle_rad,
            tilt_azimuth_rad: start.tilt_azimuth_rad + angle_rad,
            com_velocity_w_m_s: [velocity.x, velocity.y],
            ..start
        };
        let (mut a, mut b) = (run(rig, &start, JUDGE), run(other, &turned, JUDGE));
        for k in 1..=5 {
            let (a, b) = (motion(&mut a, at_ms(300 * k)), motion(&mut b, at_ms(300 * k)));
            // As above.
            prop_assert!((a.omega_wb_b_rad_s - b.omega_wb_b_rad_s).norm() < 1e-7);
            prop_assert!((turn * a.com_position_w_m - b.com_position_w_m).norm() < 1e-8);
            let q_wb = UnitQuaternion::from(turn) * a.q_wb;
            prop_assert!(difference_rad(&q_wb, &b.q_wb) < 1e-8);
        }
    }

    #[test]
    fn any_body_keeps_its_energy(
        body in prop_oneof![any_body(FREE), any_body(soft_thread())],
        start in any_start(60.0),
    ) {
        let mut run = run(body, &start, RECORD);
        let start_j = energy_j(&body, &taut(&mut run, SimTime::ZERO)?);
        for k in 1..=20 {
            let now_j = energy_j(&body, &taut(&mut run, at_ms(500 * k))?);
            // A local tolerance of 1e-12 over up to 1e4 steps.
            prop_assert!((now_j / start_j - 1.0).abs() < 1e-8, "{start_j} J became {now_j} J");
        }
    }

    #[test]
    fn any_body_keeps_its_energy_on_a_finite_string(
        body in prop_oneof![any_body(FREE), any_body(soft_thread())],
        start in any_start(30.0),
        length_m in 0.6_f64..5.0,
    ) {
        let rig = Rig { string_length_m: Some(length_m), ..body.into() };
        let mut run = run(rig, &start, RECORD);
        let start_j = energy_j(&body, &taut(&mut run, SimTime::ZERO)?);
        for k in 1..=20 {
            let now_j = energy_j(&body, &taut(&mut run, at_ms(500 * k))?);
            // As on the infinite string.
            prop_assert!((now_j / start_j - 1.0).abs() < 1e-8, "{start_j} J became {now_j} J");
        }
    }

    #[test]
    fn a_thread_without_stiffness_leaves_the_momentum_about_the_vertical_alone(
        body in any_body(FREE),
        start in any_start(60.0),
    ) {
        let mut run = run(body, &start, RECORD);
        let scale = body.inertia_b_kg_m2().norm() * 10.0; // rates reach some 10 rad/s
        let start = body.vertical_momentum_n_m_s(&taut(&mut run, SimTime::ZERO)?);
        for k in 1..=20 {
            let now = body.vertical_momentum_n_m_s(&taut(&mut run, at_ms(500 * k))?);
            // A local tolerance of 1e-12 over up to 1e3 steps.
            prop_assert!((now - start).abs() < 1e-9 * scale, "{start} became {now}");
        }
    }

    #[test]
    fn halving_the_step_cuts_the_error_sixteenfold_for_any_body(
        body in any_body(soft_thread()),
        start in any_start(30.0),
        length_m in prop::option::of(0.6_f64..5.0),
    ) {
        let rig = Rig { string_length_m: length_m, ..in_full(body) };
        // Several instants: at one alone the leading term of the error may pass through zero.
        let rates = |integrator| -> Vec<_> {
            let mut run = run(rig.clone(), &start, integrator);
            (1..=20).map(|k| motion(&mut run, at_ms(25 * k)).omega_wb_b_rad_s).collect()
        };
        let apart = |a: &[Vector3<f64>], b: &[Vector3<f64>]| {
            a.iter().zip(b).map(|(a, b)| (a - b).norm()).sum::<f64>()
        };
        // From one step to the next, for the judge's own error would drown those of slow bodies.
        let [coarse, middle, fine] =
            [5e-4, 2.5e-4, 1.25e-4].map(|step_s| rates(Integrator::Rk4 { step_s }));
        let (first, second) = (apart(&coarse, &middle), apart(&middle, &fine));
        let order = (first / second).log2();
        // The next power of h shows: 3.76 to 4.14 among a thousand of these bodies.
        prop_assert!((order - 4.0).abs() < 0.5, "observed {order:.3}: {first:e}, {second:e}");
        prop_assert!(second > 1e-12, "a test of nothing: rounding");
        // What converges is the motion: what is left is a fifteenth of the last difference, but for
        // the judge, whose sum over 20 instants is 1e-11 at a local tolerance of 1e-13.
        let left = apart(&fine, &rates(JUDGE));
        prop_assert!(left < second + 1e-9, "{left:e} from the judge after {second:e}");
    }

    #[test]
    fn the_reported_place_moves_as_the_reported_velocity_says(
        body in any_body(soft_thread()),
        start in any_start(30.0),
    ) {
        let mut run = run(body, &start, JUDGE);
        let at = |k: i64| SimTime::from_ns(1_000_000_000 + 250_000 * k);
        let motions: Vec<_> = (-2..=2).map(|k| motion(&mut run, at(k))).collect();
        let [a, b, middle, c, d] = &motions[..] else { unreachable!("five motions") };
        // Five points: h⁴/30 of the fifth derivative; with overtones up to 100 rad/s that is
        // below 1e9 m/s⁵ of a place and below 1e11 m/s⁶ of a velocity. Any term that were
        // missing is thousands of times that.
        let slope = |of: fn(&BodyMotion) -> Vector3<f64>| {
            ((of(a) - of(d)) + (of(c) - of(b)) * 8.0) / 3e-3
        };
        let velocity = slope(|m| m.com_position_w_m);
        prop_assert!((velocity - middle.com_velocity_w_m_s).norm() < 2e-7, "{velocity}");
        let acceleration = slope(|m| m.com_velocity_w_m_s);
        let gap = acceleration - middle.com_acceleration_w_m_s2;
        prop_assert!(gap.norm() < 2e-5, "{gap}");
    }
}

proptest! {
    #![proptest_config(config(24))]

    #[test]
    fn plain_and_full_equations_move_an_aligned_body_alike(
        second in [0.001_f64..0.02, 0.001_f64..0.02, 0.001_f64..0.02],
        (mass_kg, com_depth_m, period_s) in (0.2_f64..5.0, 0.02_f64..0.3, 5.0_f64..1000.0),
        (ratio, gravity_m_s2) in (0.0_f64..0.3, 1.0_f64..20.0),
        start in any_start(15.0),
        noise in prop::option::of([0.0..1e-4, 0.0..1e-4, 0.0..1e-4]),
    ) {
        let [x, y, z] = second;
        let params = BodyParams {
            mass_kg,
            com_depth_m,
            com_offset_m: [0.0; 2],
            inertia_kg_m2: [y + z, z + x, x + y],
            products_kg_m2: [0.0; 3],
            gravity_m_s2,
            torsion: Torsion {
                stiffness: TorsionStiffness::PeriodS(period_s),
                damping: TorsionDamping::Ratio(ratio),
            },
        };
        let body = Body::new(&params).unwrap();
        let noise = noise.map(|density_b_n_m_sqrt_hz| TorqueNoise { density_b_n_m_sqrt_hz });
        let disturbances = Disturbances { noise, grid_hz: 50.0, ..Disturbances::default() };
        let shaken = |rig: Rig| Rig { disturbances: disturbances.clone(), ..rig };
        // Two sets of states, vertical and quaternion: fixed steps would truncate each in its own
        // way.
        let mut plain = run(shaken(body.into()), &start, JUDGE);
        let mut full = run(shaken(in_full(body)), &start, JUDGE);
        for seconds in [1, 10, 60] {
            // Each of some four steps in a cell of the noise errs by the judge's 1e-13, and what
            // that adds to a swing moves its phase on from then on.
            let steps = f64::from(4 * 50 * seconds);
            let phase_rad = fastest_rad_s(&body, &start) * f64::from(seconds);
            let tolerance = 1e-13 * steps * phase_rad.max(1.0);
            let time = at_ms(1000 * i64::from(seconds));
            let (a, b) = (motion(&mut plain, time), motion(&mut full, time));
            let apart = difference_rad(&a.q_wb, &b.q_wb);
            prop_assert!(apart < tolerance, "{seconds} s: {apart:e} rad");
            let gaps = [
                a.twist_rad - b.twist_rad,
                a.spin_rad - b.spin_rad,
                (a.inertial_angle_b_rad - b.inertial_angle_b_rad).norm(),
                a.twist_rate_rad_s - b.twist_rate_rad_s,
            ];
            // Rates move at up to ten times the angles.
            prop_assert!(gaps.iter().all(|gap| gap.abs() < 10.0 * tolerance), "{gaps:?}");
            let place = a.com_position_w_m - b.com_position_w_m;
            prop_assert!(place.norm() < tolerance, "{seconds} s: {place}");
            let pull = a.com_acceleration_w_m_s2 - b.com_acceleration_w_m_s2;
            prop_assert!(pull.norm() < 1e3 * tolerance, "{seconds} s: {pull}");
        }
    }
}

/// The swing's frequency for the smaller moment, and the rate of the body on top, rad/s.
fn fastest_rad_s(body: &Body, start: &StartState) -> f64 {
    let p = body.params();
    let least_kg_m2 = p.inertia_kg_m2[0].min(p.inertia_kg_m2[1]);
    let swing_rad_s = (p.mass_kg * p.gravity_m_s2 * p.com_depth_m / least_kg_m2).sqrt();
    swing_rad_s + Vector3::from(start.omega_wb_b_rad_s).norm()
}

/// What Simpson's rule, which a Runge-Kutta step of fourth order is for a mere integral, leaves of
/// the place of the suspension as it goes to and fro beside the centre of mass, m: amplitude times
/// (ωh)⁴/2880. The whole arm stands for the amplitude, which leaves room for overtones: of 15° it
/// is a quarter.
fn simpson_m(body: &Body, start: &StartState, step_s: f64) -> f64 {
    body.params().com_depth_m * (fastest_rad_s(body, start) * step_s).powi(4) / 2880.0
}

#[test]
fn full_equations_hold_the_horizontal_momentum_to_their_order_and_no_further() {
    // A small stiff body that swings at 80 rad/s; by then the attitude itself is off by 8e-3 rad.
    let params = BodyParams {
        mass_kg: 3.731_612_508_841_661,
        com_depth_m: 0.216_431_330_431_506_1,
        com_offset_m: [0.0; 2],
        inertia_kg_m2: [0.002; 3],
        products_kg_m2: [0.0; 3],
        gravity_m_s2: 15.754_350_255_675_988,
        torsion: Torsion {
            stiffness: TorsionStiffness::PeriodS(5.0),
            damping: TorsionDamping::Ratio(0.0),
        },
    };
    let body = Body::new(&params).unwrap();
    let start = StartState { tilt_rad: 0.195_838_330_702_639, ..StartState::twisted(0.0, 0.0) };
    let slip_m = |step_s| {
        let integrator = Integrator::Rk4 { step_s };
        let (mut plain, mut full) =
            (run(body, &start, integrator), run(in_full(body), &start, integrator));
        let first = motion(&mut plain, SimTime::ZERO);
        let (a, b) = (motion(&mut plain, at_ms(10_000)), motion(&mut full, at_ms(10_000)));
        // The two forms truncate in their own ways, each by 8e-3 rad.
        assert!(difference_rad(&a.q_wb, &b.q_wb) < 2e-2);
        assert_eq!(a.com_position_w_m.xy(), first.com_position_w_m.xy(), "kept to the bit");
        (b.com_position_w_m - first.com_position_w_m).xy().norm()
    };
    let (coarse_m, fine_m) = (slip_m(1e-3), slip_m(5e-4));
    assert!(coarse_m < simpson_m(&body, &start, 1e-3), "{coarse_m:e} m");
    // Rounding is 1e-14 of 2e-11; the next order in ωh = 0.08 is below a percent.
    assert!((coarse_m / fine_m - 16.0).abs() < 0.2, "{coarse_m:e} m, then {fine_m:e} m");
}

#[test]
fn the_balls_behind_a_body_give_its_tensor_and_centre() {
    // Four known balls: the generator of these tests is itself held to the definition.
    let balls = [
        (0.5, Vector3::new(0.1, 0.0, -0.1)),
        (0.25, Vector3::new(0.0, 0.2, -0.2)),
        (0.25, Vector3::new(-0.1, 0.0, -0.3)),
        (1.0, Vector3::new(0.0, 0.0, -0.1)),
    ];
    let body = random::body_of(&balls, FREE);
    let arm = -body.suspension_b_m();
    assert!((arm - Vector3::new(0.0125, 0.025, -0.1375)).norm() < 1e-16, "{arm}");
    // About the point that the string holds the moments are plain sums of m r²; Steiner's theorem
    // takes them to the centre of mass.
    let about_a = Matrix3::new(
        0.5 * 0.01 + 0.25 * 0.08 + 0.25 * 0.09 + 0.01,
        0.0,
        0.5 * 0.01 - 0.25 * 0.03,
        0.0,
        0.5 * 0.02 + 0.25 * 0.04 + 0.25 * 0.10 + 0.01,
        0.25 * 0.04,
        0.5 * 0.01 - 0.25 * 0.03,
        0.25 * 0.04,
        0.5 * 0.01 + 0.25 * 0.04 + 0.25 * 0.01,
    );
    let steiner = (Matrix3::identity() * arm.norm_squared() - arm * arm.transpose()) * 2.0;
    // Each ball adds two fifths of its mass times its radius squared, 2 kg in all.
    let own = Matrix3::identity() * (2.0 * 0.4 * 0.04_f64.powi(2));
    assert!((body.inertia_b_kg_m2() - (about_a - steiner + own)).norm() < 1e-16);
}
