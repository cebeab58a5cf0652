//! The motion against the body model, and its derivatives against differences.

use super::*;
use crate::SwingBody;
use std::f64::consts::TAU;
use std::vec::Vec;
use struna_body::{
    Body, BodyParams, Drag, Integrator, Rig, StartState, Torsion, TorsionDamping, TorsionStiffness,
    TruthMotion,
};
use struna_kernel::{RAD_PER_DEG, SimTime};

/// A body of three different moments, in air: swing of 1.6 Hz with a decay of 1/500 s.
const BODY: SwingBody = SwingBody {
    mass_kg: 1.0,
    com_depth_m: 0.1,
    inertia_kg_m2: [0.0100, 0.0105, 0.0100],
    gravity_m_s2: 9.81,
    swing_damping_1_s: 2e-3,
};
/// Of torsion: period, damping of the string alone.
const PERIOD_S: f64 = 120.0;
const STRING_RATIO: f64 = 0.03;

/// The same body as the body model has it.
fn rig() -> Rig {
    let torsion = Torsion {
        stiffness: TorsionStiffness::PeriodS(PERIOD_S),
        damping: TorsionDamping::Ratio(STRING_RATIO),
    };
    let params = BodyParams {
        mass_kg: BODY.mass_kg,
        com_depth_m: BODY.com_depth_m,
        com_offset_m: [0.0; 2],
        inertia_kg_m2: BODY.inertia_kg_m2,
        products_kg_m2: [0.0; 3],
        gravity_m_s2: BODY.gravity_m_s2,
        torsion,
    };
    let [a, b, _] = BODY.inertia_kg_m2;
    let rotation_n_m_s_rad = BODY.swing_damping_1_s * (a + b);
    let drag = Drag { rotation_n_m_s_rad, ..Drag::NONE };
    Rig { drag, ..Rig::from(Body::new(&params).unwrap()) }
}

/// The parameters of [`rig`]: its torsion is damped by string and air.
fn parameters() -> MotionParameters {
    let omega = TAU / PERIOD_S;
    let [a, b, c] = BODY.inertia_kg_m2;
    let air = BODY.swing_damping_1_s * (a + b) / c;
    MotionParameters::as_believed(omega * omega, 2.0 * STRING_RATIO * omega + air)
}

/// Swing of 15° by 3°, one turn of twist.
fn start() -> StartState {
    StartState {
        tilt_rad: 15.0 * RAD_PER_DEG,
        tilt_azimuth_rad: 0.7,
        twist_rad: TAU,
        omega_wb_b_rad_s: [-0.30, 0.42, 0.01],
        ..StartState::AT_REST
    }
}

fn state_of(truth: &struna_kernel::BodyMotion) -> MotionState {
    let up_b = truth.q_wb.inverse_transform_vector(&nalgebra::Vector3::z());
    MotionState {
        e: [up_b.x, up_b.y],
        twist_rad: truth.twist_rad,
        omega_rad_s: truth.omega_wb_b_rad_s.into(),
    }
}

#[test]
fn a_minute_of_elliptic_swing_in_air_is_that_of_the_body_model() {
    let record = Integrator::Dop853 { rtol: 1e-12, atol: 1e-12 };
    let mut truth = TruthMotion::new(rig(), &start(), record).unwrap();
    let (motion, parameters) = (SwingMotion::new(&BODY), parameters());
    let mut state = state_of(&truth.motion_at(SimTime::ZERO).unwrap());
    let (mut lowest, mut highest) = (f64::MAX, 0.0_f64);
    for k in 1..=60_000_i64 {
        state = motion.step(&state, &parameters, 1e-3).unwrap();
        highest = highest.max(state.tilt_rad());
        if k > 59_000 {
            lowest = lowest.min(state.tilt_rad());
        }
        if k % 1000 == 0 {
            let truth = truth.motion_at(SimTime::from_ns(k * 1_000_000)).unwrap();
            let truth = state_of(&truth).entries();
            for (i, (ours, theirs)) in state.entries().iter().zip(truth).enumerate() {
                // RK4 at 1 ms leaves 8e-9 rad of phase after 60 s, at up to 10 rad/s of frequency.
                let off = (ours - theirs).abs();
                assert!(off < 2e-7, "state {i} at {k} ms: {ours} against {theirs}");
            }
        }
    }
    // The swing was wide, elliptic, and the air has taken its share of a decay of 1/500 s.
    assert!(highest > 14.0 * RAD_PER_DEG && lowest < 7.0 * RAD_PER_DEG, "{lowest} to {highest}");
}

#[test]
fn the_twist_rate_is_that_of_the_body_model() {
    let record = Integrator::Rk4 { step_s: 1e-3 };
    let mut truth = TruthMotion::new(rig(), &start(), record).unwrap();
    for k in 0..200 {
        let truth = truth.motion_at(SimTime::from_ns(k * 5_000_000)).unwrap();
        let (rate_rad_s, _) = state_of(&truth).twist_rate_rad_s().unwrap();
        // Two ways to write the same sum of three products.
        assert!((rate_rad_s - truth.twist_rate_rad_s).abs() < 1e-14, "{k}");
    }
}

/// Entries of state and parameters at a wide swing of a body that is not as believed.
fn general_point() -> [f64; MOTION_TANGENTS] {
    [0.31, -0.22, 5.1, 0.8, -1.3, 0.4, 0.0031, 0.011, 1.03, 0.96, 1.4]
}

fn split(entries: &[f64; MOTION_TANGENTS]) -> (MotionState, MotionParameters) {
    let (state, parameters) = entries.split_at(MOTION_STATES);
    let state = MotionState::from_entries(state.try_into().unwrap());
    (state, MotionParameters::from_entries(parameters.try_into().unwrap()))
}

/// The state after `steps` steps of `span_s`.
fn flow(entries: &[f64; MOTION_TANGENTS], steps: u32, span_s: f64) -> [f64; MOTION_STATES] {
    let motion = SwingMotion::new(&BODY);
    let (mut state, parameters) = split(entries);
    for _ in 0..steps {
        state = motion.step(&state, &parameters, span_s).unwrap();
    }
    state.entries()
}

/// Five-point central difference of a vector function of one entry.
fn difference<const N: usize>(
    entries: &[f64; MOTION_TANGENTS],
    column: usize,
    f: impl Fn(&[f64; MOTION_TANGENTS]) -> [f64; N],
) -> [f64; N] {
    let h = 1e-3 * entries[column].abs();
    let at = |share: f64| {
        let mut moved = *entries;
        moved[column] += share * h;
        f(&moved)
    };
    let (one, two) = ((at(1.0), at(-1.0)), (at(2.0), at(-2.0)));
    core::array::from_fn(|i| (8.0 * (one.0[i] - one.1[i]) - (two.0[i] - two.1[i])) / (12.0 * h))
}

#[test]
fn tangents_are_the_derivatives_of_the_step_itself() {
    // One step so long that the step is far from the motion, and two hundred ordinary ones.
    for (steps, span_s) in [(1, 0.05), (200, 0.01)] {
        let (mut state, parameters) = split(&general_point());
        let (motion, mut tangents) = (SwingMotion::new(&BODY), Tangents::START);
        for _ in 0..steps {
            let plain = motion.step(&state, &parameters, span_s).unwrap();
            let with =
                motion.step_with_tangents(&state, &parameters, span_s, &mut tangents).unwrap();
            assert_eq!(plain, with);
            state = plain;
        }
        for column in 0..MOTION_TANGENTS {
            let slope = difference(&general_point(), column, |x| flow(x, steps, span_s));
            let scale = slope.iter().fold(0.0_f64, |m, s| m.max(s.abs()));
            for (i, (row, theirs)) in tangents.0.iter().zip(slope).enumerate() {
                let ours = row[column];
                // The difference errs by 1e-12 of a fifth derivative, some 1e3 of the first over
                // two seconds of swing, and by the rounding of 200 steps over 1e-3 of the entry.
                let off = (ours - theirs).abs() / scale;
                assert!(off < 2e-9, "row {i}, column {column}: {ours} against {theirs}");
            }
        }
    }
}

#[test]
fn the_twist_rate_knows_its_slope() {
    let (state, _) = split(&general_point());
    let (_, by) = state.twist_rate_rad_s().unwrap();
    for (column, by) in by.into_iter().enumerate() {
        let rate = |x: &[f64; MOTION_TANGENTS]| [split(x).0.twist_rate_rad_s().unwrap().0];
        let [slope] = difference(&general_point(), column, rate);
        // 1e-12 of a fifth derivative, and rounding over a step of 1e-3.
        assert!((by - slope).abs() < 1e-11, "column {column}: {by} against {slope}");
    }
}

#[test]
fn a_measurement_knows_its_slopes() {
    let at = [0.02, -0.03, 0.8, -1.3, 0.4, 0.01, 0.0, 0.0, 0.0, 0.0, 0.0];
    let expected = |x: &[f64; MOTION_TANGENTS]| {
        ExpectedRate::new([x[2], x[3], x[4]], [x[0], x[1]], x[5]).unwrap()
    };
    let ours = expected(&at);
    let by: Vec<f64> = ours.by_tilt.into_iter().chain(ours.by_omega).collect();
    for (column, by) in by.into_iter().enumerate() {
        let [slope] = difference(&at, column, |x| [expected(x).rate_rad_s]);
        // Rounding over a step of 2e-5 at least.
        assert!((by - slope).abs() < 1e-10, "column {column}: {by} against {slope}");
    }
    for no_axis in [[1.0, 0.0], [0.8, 0.8], [f64::NAN, 0.0], [0.0, f64::INFINITY]] {
        assert_eq!(ExpectedRate::new([1.0; 3], no_axis, 0.0), Err(EstimatorError::Overflow));
    }
}

#[test]
fn what_leaves_the_chart_or_the_range_is_refused_and_moves_no_tangent() {
    let motion = SwingMotion::new(&BODY);
    let (state, parameters) = split(&general_point());
    let tipped = MotionState { e: [0.8, 0.6], ..state };
    let falling = MotionState { e: [0.0, 0.95], omega_rad_s: [60.0, 0.0, 0.0], ..state };
    let racing = MotionState { omega_rad_s: [1e200, 0.0, 1e200], ..state };
    let lost = MotionState { twist_rad: f64::NAN, ..state };
    let nothing = MotionParameters { scale_a: 0.0, ..parameters };
    for (state, parameters) in [
        (tipped, parameters),
        (falling, parameters),
        (racing, parameters),
        (lost, parameters),
        (state, nothing),
    ] {
        let mut tangents = Tangents::START;
        let refused = motion.step_with_tangents(&state, &parameters, 0.01, &mut tangents);
        assert!(refused.is_err(), "{state:?}");
        assert_eq!(refused, motion.step(&state, &parameters, 0.01));
        assert_eq!(tangents, Tangents::START);
    }
    let refused = motion.step(&tipped, &parameters, 0.01);
    assert_eq!(refused, Err(EstimatorError::TiltTooLarge));
    for span_s in [-1e-9, f64::NAN, f64::INFINITY] {
        let refused = motion.step(&state, &parameters, span_s);
        assert!(matches!(refused, Err(EstimatorError::BadSpan { .. })), "{span_s}");
    }
}

#[test]
fn a_span_is_cut_into_steps_that_follow_the_swing() {
    let motion = SwingMotion::new(&BODY);
    // 0.15/√(9.81·0.1/0.01) s = 15.14 ms.
    assert!((motion.step_max_s() - 0.015_144).abs() < 1e-6);
    for (span_s, steps) in [(0.0, 1), (0.01, 1), (0.0152, 2), (1.0, 67), (1e300, 1 << 31)] {
        assert_eq!(motion.steps_in(span_s), steps, "{span_s}");
    }
}

#[test]
fn a_long_span_is_its_steps_and_a_longer_one_is_refused() {
    let motion = SwingMotion::new(&BODY);
    let (start, parameters) = split(&general_point());
    let (mut state, mut tangents) = (start, Tangents::START);
    for _ in 0..67 {
        let span_s = 1.0 / 67.0;
        state = motion.step_with_tangents(&state, &parameters, span_s, &mut tangents).unwrap();
    }
    let mut at_once = Tangents::START;
    let later = motion.advance_with_tangents(&start, &parameters, 1.0, &mut at_once);
    assert_eq!((later, at_once), (Ok(state), tangents));
    let refused = motion.advance_with_tangents(&start, &parameters, 1e4, &mut at_once);
    assert!(matches!(refused, Err(EstimatorError::SpanTooLong { .. })));
    assert_eq!(at_once, tangents);
}
