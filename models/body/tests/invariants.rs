//! What the motion conserves, and what ties its twist, spin and attitude together.

use nalgebra::Vector3;
use proptest::prelude::*;
use std::f64::consts::TAU;
use struna_body::{
    Body, BodyParams, Integrator, StartState, Torsion, TorsionDamping, TorsionStiffness,
    TruthMotion, reference,
};
use struna_kernel::{BodyMotion, SampleGrid, SimTime};

const RK4_1MS: Integrator = Integrator::Rk4 { step_s: 1e-3 };
const RECORD: Integrator = Integrator::Dop853 { rtol: 1e-12, atol: 1e-12 };
const FREE: Torsion = Torsion {
    stiffness: TorsionStiffness::ConstantNMRad(0.0),
    damping: TorsionDamping::Ratio(0.0),
};

fn body(params: BodyParams) -> Body {
    Body::new(&params).expect("the bodies of these tests are sound")
}

fn at(seconds: i64) -> SimTime {
    SimTime::from_ns(seconds * 1_000_000_000)
}

type Quantity = fn(&Body, &BodyMotion) -> f64;

/// Largest change of `quantity` over 480 s of S3 by RK4 at 1 ms, in units of `scale` at the start.
fn drift(params: BodyParams, quantity: Quantity, scale: Quantity) -> f64 {
    let body = body(params);
    let mut run = TruthMotion::new(body, &reference::S3, RK4_1MS).expect("S3 is sound");
    let start = run.motion_at(SimTime::ZERO).expect("a start is a motion");
    let change = |motion| (quantity(&body, &motion) - quantity(&body, &start)).abs();
    let worst = (1..=480).fold(0.0_f64, |worst, seconds| {
        worst.max(change(run.motion_at(at(seconds)).expect("S3 runs on")))
    });
    worst / scale(&body, &start).abs()
}

#[test]
fn v11_energy_is_conserved_by_an_undamped_string() {
    let drift = drift(reference::PARAMS, Body::energy_j, Body::energy_j);
    println!("energy: {drift:.2e}");
    // Four times the 5e-9 that RK4 loses at this step.
    assert!(drift < 2e-8, "{drift:e}");
}

#[test]
fn v11_vertical_momentum_is_conserved_by_a_string_without_stiffness() {
    let params = BodyParams { torsion: FREE, ..reference::PARAMS };
    let momentum = Body::vertical_momentum_n_m_s;
    let drift = drift(params, momentum, momentum);
    println!("Lz: {drift:.2e}");
    // Ten times the 5e-10 that RK4 loses at this step.
    assert!(drift < 5e-9, "{drift:e}");
}

#[test]
fn v11_a_symmetric_body_conserves_its_momentum_difference_on_any_string() {
    for damping in [TorsionDamping::Ratio(0.0), TorsionDamping::Ratio(0.2)] {
        let torsion = Torsion { stiffness: TorsionStiffness::PeriodS(480.0), damping };
        let inertia_kg_m2 = [0.0105, 0.0105, 0.0120];
        let params = BodyParams { torsion, inertia_kg_m2, ..reference::PARAMS };
        // In units of Lz, because the conserved value is a small difference of two such momenta.
        let drift = drift(params, Body::momentum_difference_n_m_s, Body::vertical_momentum_n_m_s);
        println!("Lz - C r, {damping:?}: {drift:.2e}");
        // Ten times the 4e-10 that RK4 loses at this step.
        assert!(drift < 5e-9, "{drift:e}");
    }
}

#[test]
fn a_damped_string_only_ever_takes_energy_away() {
    let damping = TorsionDamping::Ratio(0.1);
    let torsion = Torsion { damping, ..reference::PARAMS.torsion };
    let body = body(BodyParams { torsion, ..reference::PARAMS });
    let mut run = TruthMotion::new(body, &reference::S3, RECORD).unwrap();
    let mut last_j = f64::INFINITY;
    for seconds in 0..=480 {
        let energy_j = body.energy_j(&run.motion_at(at(seconds)).unwrap());
        assert!(energy_j < last_j, "{seconds} s: {energy_j} J after {last_j} J");
        last_j = energy_j;
    }
}

#[test]
fn the_twist_is_the_quaternion_twist_up_to_whole_turns() {
    let mut run = TruthMotion::new(body(reference::PARAMS), &reference::S3, RK4_1MS).unwrap();
    for seconds in 0..=480 {
        let motion = run.motion_at(at(seconds)).unwrap();
        let from_quaternion = 2.0 * motion.q_wb.k.atan2(motion.q_wb.w);
        let turns = (motion.twist_rad - from_quaternion) / TAU;
        // Both are integrated apart: the gap is RK4's error in each, of the order of 1e-9 rad.
        assert!((turns - turns.round()).abs() * TAU < 1e-8, "{seconds} s: {turns} turns");
    }
}

/// Solid angle between the vertical and two directions of the body axis, signed.
///
/// Source: the tangent formula for a spherical triangle, here with the vertical as first corner.
fn triangle(a: Vector3<f64>, b: Vector3<f64>) -> f64 {
    2.0 * (a.x * b.y - a.y * b.x).atan2(1.0 + a.z + b.z + a.dot(&b))
}

#[test]
fn spin_lags_the_twist_by_the_solid_angle_that_the_axis_sweeps() {
    let grid = SampleGrid::new(SimTime::ZERO, 1000.0).unwrap();
    let mut run = TruthMotion::new(body(reference::PARAMS), &reference::S3, RECORD).unwrap();
    let start = run.motion_at(SimTime::ZERO).unwrap();
    let (mut axis, mut swept_rad) = (start.q_wb * Vector3::z(), 0.0_f64);
    for k in 1..=60_000 {
        let motion = run.motion_at(grid.time_of(k)).unwrap();
        let next = motion.q_wb * Vector3::z();
        swept_rad += triangle(axis, next);
        axis = next;
        if k % 1000 == 0 {
            let lag = (motion.twist_rad - start.twist_rad) - (motion.spin_rad - start.spin_rad);
            // Chords for arcs lose |e′×e″|·h²/12 = a·b·ω³·h²/12 per second: 4e-7 rad/s for an
            // ellipse of 0.17 × 0.03 rad at 9.7 rad/s and h = 1 ms, so 2.4e-5 rad in all.
            assert!((lag - swept_rad).abs() < 3e-5, "{k}: lag {lag}, swept {swept_rad}");
        }
    }
    assert!(swept_rad.abs() > 0.5, "a test of nothing: only {swept_rad} rad swept");
}

/// A body with three different moments that obey the triangle inequality by construction: each is
/// the sum of two of three positive second moments of mass.
fn any_body() -> impl Strategy<Value = Body> {
    let second = || 0.001_f64..0.02;
    (0.2_f64..5.0, 0.02_f64..0.3, (second(), second(), second()), 5.0_f64..1000.0).prop_map(
        |(mass_kg, com_depth_m, (x, y, z), period_s)| {
            let torsion = Torsion {
                stiffness: TorsionStiffness::PeriodS(period_s),
                damping: TorsionDamping::Ratio(0.0),
            };
            let inertia_kg_m2 = [y + z, z + x, x + y];
            body(BodyParams { mass_kg, com_depth_m, inertia_kg_m2, torsion, ..reference::PARAMS })
        },
    )
}

fn any_start() -> impl Strategy<Value = StartState> {
    let rate = || -1.0_f64..1.0;
    (0.0_f64..TAU / 6.0, 0.0_f64..TAU, -2.0 * TAU..2.0 * TAU, [rate(), rate(), rate()]).prop_map(
        |(tilt_rad, tilt_azimuth_rad, twist_rad, omega_wb_b_rad_s)| StartState {
            tilt_rad,
            tilt_azimuth_rad,
            twist_rad,
            omega_wb_b_rad_s,
            ..StartState::AT_REST
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 64,
        failure_persistence: None, // regressions become named tests
        ..Default::default()
    })]

    #[test]
    fn any_body_from_any_start_up_to_sixty_degrees_keeps_its_energy(
        body in any_body(),
        start in any_start(),
    ) {
        let mut run = TruthMotion::new(body, &start, RECORD).unwrap();
        let start_j = body.energy_j(&run.motion_at(SimTime::ZERO).unwrap());
        let end_j = body.energy_j(&run.motion_at(at(20)).unwrap());
        // A local tolerance of 1e-12 over up to 1e4 steps.
        prop_assert!((end_j / start_j - 1.0).abs() < 1e-8, "{start_j} J became {end_j} J");
    }

    #[test]
    fn a_start_has_the_tilt_and_twist_it_names(start in any_start()) {
        let q = start.attitude();
        let axis = q * Vector3::z();
        prop_assert!((axis.z - start.tilt_rad.cos()).abs() < 1e-14);
        let turns = (start.twist_rad - 2.0 * q.k.atan2(q.w)) / TAU;
        prop_assert!((turns - turns.round()).abs() < 1e-14, "{turns}");
        // The body axis leans across the axis of the swing.
        let lean = axis.x * start.tilt_azimuth_rad.cos() + axis.y * start.tilt_azimuth_rad.sin();
        prop_assert!(lean.abs() < 1e-14);
    }
}
