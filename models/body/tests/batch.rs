//! Bodies in a batch must move as each would alone: to the error of the method, and to the bit.

#![expect(clippy::unwrap_used, clippy::panic, reason = "either fails the test")]

use nalgebra::UnitQuaternion;
use std::num::NonZeroUsize;
use struna_body::batch::{Batch, BatchBody, BatchError, Level, NoiseGrid, SlipElement};
use struna_body::ode::{Dop853, Dop853Sampler, Rhs, Rk4, Tolerance, rk4_step};
use struna_body::{
    Body, BodyError, BodyParams, FAST_STATES, FastEquations, FastMotion, Integrator, StartState,
    StopReason, TruthMotion, reference,
};
use struna_kernel::{AddressedRandom, Bound, Channel, RAD_PER_DEG, Seed, SimTime};

const STEP_S: f64 = 1.0 / 1400.0;
const STEPS_480_S: u64 = 480 * 1400;
const NOISE: NoiseGrid = NoiseGrid { seed: Seed(7), steps_per_cell: 14 };
/// Strong enough to move the attitude by 1e-3 rad in seconds.
const DENSITY_N_M_SQRT_HZ: f64 = 1e-7;

fn reference_body() -> Body {
    Body::new(&reference::PARAMS).unwrap()
}

/// Bodies that differ in everything that a lane carries.
fn varied(count: u32) -> Vec<BatchBody> {
    let vary = |run: u32| {
        let x = f64::from(run);
        let mut params = BodyParams { mass_kg: 1.0 + 0.01 * x, ..reference::PARAMS };
        params.inertia_kg_m2[1] += 1e-5 * x;
        params.com_depth_m += 1e-3 * x;
        let start = StartState {
            twist_rad: 0.3 * x,
            omega_wb_b_rad_s: [0.2, 0.3 - 0.02 * x, 0.5],
            ..reference::S3
        };
        BatchBody { run: u64::from(run), ..BatchBody::new(Body::new(&params).unwrap(), start) }
    };
    (0..count).map(vary).collect()
}

/// The same with random torques, a constant one, and threads of zero to four elements.
fn varied_in_full(count: u32) -> Vec<BatchBody> {
    let mut bodies = varied(count);
    for (k, body) in bodies.iter_mut().enumerate() {
        body.torque_b_n_m = [1e-6, -2e-6, 3e-6 * k as f64];
        body.torque_noise_b_n_m_sqrt_hz = [DENSITY_N_M_SQRT_HZ * (k % 3) as f64; 3];
        for element in &mut body.thread[..k % 5] {
            *element = slip(&body.body, 5.0, 0.02);
        }
    }
    bodies
}

fn slip(body: &Body, stiffness_ratio: f64, yield_rad: f64) -> SlipElement {
    let stiffness_n_m_rad = stiffness_ratio * body.stiffness_n_m_rad();
    SlipElement { stiffness_n_m_rad, yield_rad, ..SlipElement::NONE }
}

fn levels() -> impl Iterator<Item = Level> {
    Level::ALL.into_iter().filter(|level| level.is_available())
}

/// All states and elastic twists of all bodies, bit by bit.
fn bits(batch: &Batch) -> Vec<u64> {
    let of = |index| {
        let (states, elastic) = (batch.states(index).unwrap(), batch.elastic_rad(index).unwrap());
        states.into_iter().chain(elastic).map(f64::to_bits)
    };
    (0..batch.bodies()).flat_map(of).collect()
}

fn attitude_difference_rad(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>) -> f64 {
    2.0 * (a.inverse() * b).imag().norm().asin()
}

fn record() -> TruthMotion {
    record_of(&reference::S3)
}

fn record_of(start: &StartState) -> TruthMotion {
    let integrator = Integrator::Dop853 { rtol: 1e-12, atol: 1e-12 };
    TruthMotion::new(reference_body(), start, integrator).unwrap()
}

#[test]
fn b1_eight_minutes_of_the_batch_are_those_of_the_record() {
    let bodies = [BatchBody::new(reference_body(), reference::S3)];
    let mut batch = Batch::new(&bodies, STEP_S, NOISE).unwrap();
    let mut record = record();
    let (mut worst_rad, mut worst_spin_rad) = (0.0_f64, 0.0_f64);
    for _ in 0..48 {
        batch.advance(STEPS_480_S / 48).unwrap();
        let (a, b) = (batch.motion(0).unwrap(), record.motion_at(batch.time()).unwrap());
        worst_rad = worst_rad.max(attitude_difference_rad(&a.q_wb, &b.q_wb));
        worst_rad = worst_rad.max((a.twist_rad - b.twist_rad).abs());
        worst_spin_rad = worst_spin_rad.max((a.spin_rad - b.spin_rad).abs());
        assert!((a.twist_rate_rad_s - b.twist_rate_rad_s).abs() < 3e-7, "{}", a.time);
    }
    println!("batch against DOP853 1e-12: {worst_rad:.2e} rad, spin {worst_spin_rad:.2e} rad");
    // Twice the 1.2e-8 rad by which RK4 runs ahead at this step, as it does in one body alone.
    assert!(worst_rad < 3e-8, "{worst_rad:e} rad");
    assert!(worst_spin_rad < 3e-8, "{worst_spin_rad:e} rad");
}

#[test]
fn b2_every_level_ends_at_the_bits_of_one_body_alone() {
    // Seventeen: a full block of the widest lanes and one body over.
    let bodies = varied(17);
    let ends: Vec<_> = levels()
        .map(|level| {
            let mut batch = Batch::with_level(&bodies, STEP_S, NOISE, level).unwrap();
            batch.advance(STEPS_480_S).unwrap();
            (level, batch)
        })
        .collect();
    let (_, first) = &ends[0];
    for (level, batch) in &ends {
        assert_eq!(bits(batch), bits(first), "{level}");
    }
    for index in [0, 7, 16] {
        let equations = FastEquations::new(&bodies[index].body, [0.0; 3]);
        let start = FastEquations::start(&bodies[index].start).unwrap();
        let end = Rk4::new(STEP_S, start).unwrap().state_at(&equations, 480.0).unwrap();
        let of_batch = first.states(index).unwrap();
        assert_eq!(end.map(f64::to_bits), of_batch.map(f64::to_bits), "body {index}");
    }
}

#[test]
fn every_level_has_the_same_bits_with_noise_and_hysteresis() {
    let bodies = varied_in_full(21);
    let mut first: Option<Vec<u64>> = None;
    for level in levels() {
        let mut batch = Batch::with_level(&bodies, STEP_S, NOISE, level).unwrap();
        batch.advance(20 * 1400).unwrap();
        let bits = bits(&batch);
        assert_eq!(&bits, first.get_or_insert(bits.clone()), "{level}");
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let bodies = varied_in_full(50);
    let run = |threads| {
        let batch = Batch::new(&bodies, STEP_S, NOISE).unwrap();
        let mut batch = batch.on_threads(NonZeroUsize::new(threads).unwrap());
        batch.advance(2000).unwrap();
        bits(&batch)
    };
    let one = run(1);
    for threads in [2, 3, 64] {
        assert_eq!(run(threads), one, "{threads} threads");
    }
}

#[test]
fn a_body_moves_the_same_way_in_any_company() {
    let bodies = varied_in_full(37);
    let mut together = Batch::new(&bodies, STEP_S, NOISE).unwrap();
    together.advance(2000).unwrap();
    for index in [0, 1, 2, 16, 36] {
        let mut alone = Batch::new(&bodies[index..=index], STEP_S, NOISE).unwrap();
        alone.advance(2000).unwrap();
        let (a, b) = (together.states(index).unwrap(), alone.states(0).unwrap());
        assert_eq!(a.map(f64::to_bits), b.map(f64::to_bits), "body {index}");
        assert_eq!(together.elastic_rad(index), alone.elastic_rad(0), "body {index}");
    }
}

#[test]
fn a_run_may_be_cut_anywhere() {
    let bodies = varied_in_full(5);
    let mut whole = Batch::new(&bodies, STEP_S, NOISE).unwrap();
    let mut cut = whole.clone();
    whole.advance(1000).unwrap();
    for steps in [1, 0, 12, 2, 985] {
        // Inside a cell of 14 steps, at its end, and across many.
        cut.advance(steps).unwrap();
    }
    assert_eq!(bits(&whole), bits(&cut));
    assert_eq!(whole.time(), cut.time());
}

#[test]
fn b9_the_path_under_noise_belongs_to_the_noise_grid_and_not_to_the_step() {
    let noisy = BatchBody {
        torque_noise_b_n_m_sqrt_hz: [DENSITY_N_M_SQRT_HZ; 3],
        ..BatchBody::new(reference_body(), reference::S3)
    };
    let end = |sub_steps: u32| {
        let grid = NoiseGrid { steps_per_cell: sub_steps, ..NOISE };
        let mut batch = Batch::new(&[noisy], STEP_S / f64::from(sub_steps), grid).unwrap();
        batch.advance(u64::from(sub_steps) * 20 * 1400).unwrap();
        batch.motion(0).unwrap()
    };
    let [one, eight] = [1, 8].map(end);
    let apart_rad = attitude_difference_rad(&one.q_wb, &eight.q_wb);
    println!("1 against 8 sub-steps of one noise grid: {apart_rad:.2e} rad");
    // RK4 itself errs by 3e-10 rad in 20 s at this step; the rest is its coarser view of kinks.
    assert!(apart_rad < 2e-9, "{apart_rad:e} rad");
    let mut quiet = record();
    let moved_rad = attitude_difference_rad(&one.q_wb, &quiet.motion_at(one.time).unwrap().q_wb);
    assert!(moved_rad > 1e-5, "the noise must act, and moved by {moved_rad:e} rad");
}

/// S3 under a Brownian torque of 1400 × 8 cells per second, held over `hold` of them at a time at
/// their mean, for 20 s.
fn end_under_averaged_noise(run: u64, hold: u64) -> FastMotion {
    const FINE_HZ: u64 = 11_200;
    let mut random = AddressedRandom::new(Seed(3), Channel::TorqueNoise, run);
    let sigma_n_m = DENSITY_N_M_SQRT_HZ * (FINE_HZ as f64).sqrt();
    let body = reference_body();
    let mut states = FastEquations::start(&reference::S3).unwrap();
    for first in (0..20 * FINE_HZ).step_by(usize::try_from(hold).unwrap()) {
        let torque_n_m = [0, 1, 2].map(|axis| {
            let sum: f64 =
                (first..first + hold).map(|cell| random.standard_normal(3 * cell + axis)).sum();
            sigma_n_m * sum / hold as f64
        });
        let equations = FastEquations::new(&body, torque_n_m);
        states = rk4_step(&equations, 0.0, &states, hold as f64 / FINE_HZ as f64);
        equations.project(&mut states);
    }
    FastEquations::motion(SimTime::ZERO, &states)
}

#[test]
fn b9_holding_the_noise_longer_costs_the_first_power_of_the_cell() {
    const HOLDS: [u64; 4] = [2, 4, 8, 16];
    const PATHS: u32 = 12;
    let mut squares = [0.0; HOLDS.len()];
    for run in 0..PATHS {
        let fine = end_under_averaged_noise(run.into(), 1);
        for (square, hold) in squares.iter_mut().zip(HOLDS) {
            let coarse = end_under_averaged_noise(run.into(), hold);
            *square += attitude_difference_rad(&coarse.q_wb, &fine.q_wb).powi(2) / f64::from(PATHS);
        }
    }
    let logs = squares.map(|square: f64| 0.5 * square.log2());
    println!("strong error, log2 rad: {logs:.2?}");
    // Least squares through four equally spaced points: weights −3, −1, 1, 3 over 10.
    let order = (3.0 * (logs[3] - logs[0]) + logs[2] - logs[1]) / 10.0;
    assert!((0.8..1.2).contains(&order), "observed order {order:.2}");
}

#[test]
fn b10_the_spread_of_the_rate_under_noise_does_not_depend_on_the_step() {
    const PATHS: u32 = 600;
    const SECONDS: u32 = 20;
    // Hanging at rest: a swing would pass on noise from the other axes.
    let body = BatchBody {
        torque_noise_b_n_m_sqrt_hz: [DENSITY_N_M_SQRT_HZ; 3],
        ..BatchBody::new(reference_body(), StartState::AT_REST)
    };
    let bodies: Vec<_> = (0..PATHS).map(|run| BatchBody { run: run.into(), ..body }).collect();
    // √(S·t)/C, less the percent that the string takes back: impulses turn with cos Ω(t − s).
    let (time_s, omega_rad_s) = (f64::from(SECONDS), body.body.torsion_frequency_rad_s());
    let effective_s = 0.5 * time_s + (2.0 * omega_rad_s * time_s).sin() / (4.0 * omega_rad_s);
    let theory_rad_s =
        DENSITY_N_M_SQRT_HZ * effective_s.sqrt() / reference::PARAMS.inertia_kg_m2[2];
    for rate_hz in [350, 1400, 2800] {
        let grid = NoiseGrid { seed: Seed(11), steps_per_cell: 1 };
        let batch = Batch::new(&bodies, 1.0 / f64::from(rate_hz), grid).unwrap();
        let mut batch = batch.on_threads(NonZeroUsize::new(2).unwrap());
        batch.advance(u64::from(SECONDS * rate_hz)).unwrap();
        let square = |index| batch.states(index).unwrap()[5].powi(2);
        let variance = (0..bodies.len()).map(square).sum::<f64>() / f64::from(PATHS);
        let spread_rad_s = variance.sqrt();
        println!("{rate_hz} Hz: {spread_rad_s:.3e} rad/s, in theory {theory_rad_s:.3e}");
        // 2.8 standard errors of 600 paths, 1/√1200 each. Noise of constant size instead of √(S/h)
        // would be off by a factor of two for each factor of four in the step.
        assert!((spread_rad_s / theory_rad_s - 1.0).abs() < 0.08, "{rate_hz} Hz");
    }
}

#[test]
fn b6_smooth_samples_of_long_steps_lie_on_the_record() {
    let equations = FastEquations::new(&reference_body(), [0.0; 3]);
    let start = FastEquations::start(&reference::S3).unwrap();
    let mut sampler = Dop853Sampler::new(0.04, STEP_S, [5, 6], start).unwrap();
    let mut samples = vec![[0.0; 2]; usize::try_from(STEPS_480_S).unwrap()];
    sampler.fill(&equations, &mut samples).unwrap();
    let mut record = Dop853::new(Tolerance { rtol: 1e-12, atol: 1e-12 }, start).unwrap();
    let (mut worst_rate_rad_s, mut worst_twist_rad) = (0.0_f64, 0.0_f64);
    for (k, [rate_rad_s, twist_rad]) in samples.iter().enumerate() {
        let states: [f64; FAST_STATES] = record.state_at(&equations, k as f64 * STEP_S).unwrap();
        worst_rate_rad_s = worst_rate_rad_s.max((rate_rad_s - states[5]).abs());
        worst_twist_rad = worst_twist_rad.max((twist_rad - states[6]).abs());
    }
    println!(
        "DOP853 at 0.04 s: rate {worst_rate_rad_s:.2e} rad/s, twist {worst_twist_rad:.2e} rad"
    );
    // What the step was chosen for; a third of it in the twist, a tenth in the rate.
    assert!(worst_twist_rad < 1e-6, "{worst_twist_rad:e} rad");
    assert!(worst_rate_rad_s < 2e-7, "{worst_rate_rad_s:e} rad/s");
}

/// Pure torsion from one turn on a thread with hysteresis, 600 s.
fn twist_after_600_s_deg(thread: &[SlipElement], rate_hz: u32) -> f64 {
    let mut body = BatchBody::new(reference_body(), reference::S1);
    body.thread[..thread.len()].copy_from_slice(thread);
    let mut batch = Batch::new(&[body], 1.0 / f64::from(rate_hz), NOISE).unwrap();
    batch.advance(600 * u64::from(rate_hz)).unwrap();
    batch.motion(0).unwrap().twist_rad / RAD_PER_DEG
}

#[test]
fn a_thread_that_slips_ends_where_splitting_at_its_events_ends() {
    let body = reference_body();
    let one = [slip(&body, 10.0, 25.0 * RAD_PER_DEG)];
    let four = [(5.0, 4.0), (12.0, 3.0), (25.0, 2.0), (50.0, 1.0)]
        .map(|(yield_deg, ratio)| slip(&body, ratio, yield_deg * RAD_PER_DEG));
    // End angles of an independent program that splits its steps at every slip and every reversal,
    // to a microdegree; the return map errs by less than 1e-8 rad even at 10 ms.
    for (thread, expected_deg) in [(&one[..], 127.122_738), (&four[..], -13.878_540)] {
        let found_deg = twist_after_600_s_deg(thread, 100);
        println!("{} elements: {found_deg:.6} deg, reference {expected_deg:.6}", thread.len());
        assert!((found_deg - expected_deg).abs() < 2e-6, "{found_deg} deg");
    }
}

/// Name and bound of the value refused.
fn refusal(bodies: &[BatchBody], step_s: f64, noise: NoiseGrid) -> (&'static str, Bound) {
    match Batch::new(bodies, step_s, noise) {
        Err(BatchError::Parameter(error)) => {
            assert!(!error.reason.is_empty());
            (error.name, error.bound)
        }
        other => panic!("accepted or refused otherwise: {other:?}"),
    }
}

#[test]
fn what_no_batch_can_have_is_refused_by_name_and_bound() {
    let good = BatchBody::new(reference_body(), reference::S3);
    assert_eq!(refusal(&[], STEP_S, NOISE), ("bodies", Bound::AtLeast(1.0)));
    let never = NoiseGrid { steps_per_cell: 0, ..NOISE };
    assert_eq!(refusal(&[good], STEP_S, never), ("steps_per_cell", Bound::AtLeast(1.0)));
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-12] {
        assert_eq!(refusal(&[good], bad, NOISE).0, "step_s", "{bad}");
    }
    assert_eq!(refusal(&[good], 2.0, NOISE), ("step_s", Bound::AtMost(1.0)));
    let slipping = slip(&good.body, 1.0, 0.1);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let torque = BatchBody { torque_b_n_m: [0.0, bad, 0.0], ..good };
        assert_eq!(refusal(&[good, torque], STEP_S, NOISE), ("torque_b_n_m", Bound::Finite));
    }
    for bad in [f64::NAN, f64::INFINITY, -1e-20] {
        let noise = BatchBody { torque_noise_b_n_m_sqrt_hz: [0.0, 0.0, bad], ..good };
        let density = ("torque_noise_b_n_m_sqrt_hz", Bound::AtLeast(0.0));
        assert_eq!(refusal(&[noise], STEP_S, NOISE), density);
        for (element, name) in [
            (SlipElement { stiffness_n_m_rad: bad, ..slipping }, "slip.stiffness_n_m_rad"),
            (SlipElement { yield_rad: bad, ..slipping }, "slip.yield_rad"),
        ] {
            let thread = [SlipElement::NONE, element, SlipElement::NONE, SlipElement::NONE];
            assert_eq!(refusal(&[BatchBody { thread, ..good }], STEP_S, NOISE).0, name, "{bad}");
        }
    }
    let wound = SlipElement { elastic_start_rad: -0.2, ..slipping };
    let thread = [wound, SlipElement::NONE, SlipElement::NONE, SlipElement::NONE];
    let refused = refusal(&[BatchBody { thread, ..good }], STEP_S, NOISE);
    assert_eq!(refused, ("|slip.elastic_start_rad|", Bound::AtMost(0.1)));
}

#[test]
fn a_start_that_no_body_can_have_is_refused() {
    let start = StartState { tilt_rad: 3.1, ..reference::S3 };
    let answer = Batch::new(&[BatchBody::new(reference_body(), start)], STEP_S, NOISE);
    assert!(matches!(answer, Err(BatchError::Body(_))), "{answer:?}");
}

#[test]
fn a_run_beyond_the_end_of_time_is_refused_before_its_first_step() {
    let bodies = [BatchBody::new(reference_body(), reference::S3)];
    let mut batch = Batch::new(&bodies, 1.0, NOISE).unwrap();
    for steps in [1_000_000_001, u64::MAX] {
        assert!(matches!(batch.advance(steps), Err(BatchError::Parameter(_))), "{steps}");
    }
    assert_eq!(batch.time(), SimTime::ZERO);
    assert!(batch.motion(0).is_ok());
}

#[test]
fn a_body_that_turns_over_is_lost_alone_and_for_good() {
    let mut bodies = varied(6);
    bodies[2].start.omega_wb_b_rad_s = [60.0, 0.0, 0.0];
    let mut batch = Batch::new(&bodies, STEP_S, NOISE).unwrap();
    let mut without = Batch::new(&bodies[3..4], STEP_S, NOISE).unwrap();
    assert!(batch.motion(2).is_ok(), "the start itself is sound");
    for _ in 0..20 {
        batch.advance(70).unwrap();
        without.advance(70).unwrap();
    }
    match batch.motion(2) {
        Err(BatchError::OutsideDomain { run: 2, time }) => assert_eq!(time, batch.time()),
        other => panic!("{other:?}"),
    }
    for index in [0, 1, 3, 4, 5] {
        assert!(batch.motion(index).is_ok(), "body {index}");
    }
    assert_eq!(batch.motion(3), without.motion(0));
    let beyond = batch.motion(6);
    assert_eq!(beyond, Err(BatchError::NoSuchBody { index: 6, bodies: 6 }));
}

#[test]
fn a_body_whose_string_slackens_is_lost_before_it_turns_over() {
    let thrown = StartState { omega_wb_b_rad_s: [30.0, 0.0, 0.0], ..StartState::AT_REST };
    let mut alone = record_of(&thrown);
    let slack_s = match alone.motion_at(SimTime::from_ns(1_000_000_000)) {
        Err(BodyError::Stopped(stop)) if stop.reason == StopReason::Slack => stop.time_s,
        other => panic!("{other:?}"),
    };
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a hundred and some steps"
    )]
    let before = (slack_s / STEP_S) as u64;
    let mut batch = Batch::new(&[BatchBody::new(reference_body(), thrown)], STEP_S, NOISE).unwrap();
    batch.advance(before).unwrap();
    assert!(batch.motion(0).is_ok());
    // The pull is judged where steps begin: the slack step begins taut and the next one does not.
    batch.advance(2).unwrap();
    assert!(matches!(batch.motion(0), Err(BatchError::OutsideDomain { .. })));
    assert!(batch.states(0).unwrap()[2] > -0.5, "far from upside down");
}
