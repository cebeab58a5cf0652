//! Small motions on a finite string are those of a double pendulum in its linear limit.

use super::{JUDGE, at_ms, hung, infinite, motion, run, suspension_w_m};
use nalgebra::{Matrix2, Vector2, Vector3};
use std::f64::consts::TAU;
use struna_body::{Body, BodyParams, Rig, StartState, Support, TruthMotion, Vibration, reference};
use struna_kernel::{BodyMotion, SimTime};

/// A body with two equal moments, so that every vertical plane has the same modes.
fn symmetric_body() -> Body {
    let inertia_kg_m2 = [0.0105, 0.0105, 0.0120];
    Body::new(&BodyParams { inertia_kg_m2, ..reference::PARAMS }).expect("a sound body")
}

fn rig(length_m: Option<f64>) -> Rig {
    let rig = length_m.map_or_else(infinite, hung);
    Rig { body: symmetric_body(), ..rig }
}

/// The linear problem M·q″ + K·q = f in one vertical plane: q holds the displacement of A, m, and
/// the lean of the body from A to C, rad.
struct Plane {
    mass: Matrix2<f64>,
    /// Restoring force of the string per displacement of A, N/m.
    string_n_m: f64,
    /// Angular frequencies, rad/s, slow one first, and the shapes that belong to them.
    modes: [(f64, Vector2<f64>); 2],
}

impl Plane {
    fn new(body: &Body, curvature_1_m: f64) -> Self {
        let p = body.params();
        let (m, d, a, g) = (p.mass_kg, p.com_depth_m, p.inertia_kg_m2[0], p.gravity_m_s2);
        let mass = Matrix2::new(m, m * d, m * d, a + m * d * d);
        // det(K − λM) = M A λ² − b λ + c.
        let b = m * g * (curvature_1_m * (a + m * d * d) + m * d);
        let c = (m * g).powi(2) * curvature_1_m * d;
        let fast = (b + (b * b - 4.0 * m * a * c).sqrt()) / (2.0 * m * a);
        let slow = c / (m * a * fast);
        let shape = |square: f64| {
            let displacement_m = square * d / (g * curvature_1_m - square);
            (square.sqrt(), Vector2::new(displacement_m, 1.0))
        };
        let rest = (0.0, Vector2::new(1.0, 0.0));
        let modes = if slow > 0.0 { [shape(slow), shape(fast)] } else { [rest, shape(fast)] };
        Self { mass, string_n_m: m * g * curvature_1_m, modes }
    }

    /// q at `time_s` when the support sets out from rest below it with `amplitude_m`·sin(Ωt).
    fn shaken(&self, amplitude_m: f64, shaking_rad_s: f64, time_s: f64) -> Vector2<f64> {
        let force = Vector2::new(self.string_n_m * amplitude_m, 0.0);
        let answer = |(w, shape): &(f64, Vector2<f64>)| {
            let share = shape.dot(&force) / shape.dot(&(self.mass * shape));
            let ratio = shaking_rad_s / w;
            let both = (shaking_rad_s * time_s).sin() - ratio * (w * time_s).sin();
            shape * (share * both / (w * w - shaking_rad_s.powi(2)))
        };
        self.modes.iter().map(answer).sum()
    }
}

const AZIMUTH_RAD: f64 = 0.7;

/// Horizontal direction in which a body tilted about the axis at [`AZIMUTH_RAD`] leans, A to C.
fn direction() -> Vector3<f64> {
    Vector3::new(-AZIMUTH_RAD.sin(), AZIMUTH_RAD.cos(), 0.0)
}

/// Displacement of A and lean of the body in that direction.
fn in_plane(body: &Body, motion: &BodyMotion, direction: &Vector3<f64>) -> Vector2<f64> {
    let lean = -(motion.q_wb * Vector3::z()).dot(direction);
    Vector2::new(suspension_w_m(body, motion).dot(direction), lean)
}

/// A release from rest in the shape of a mode.
fn start(shape: &Vector2<f64>, lean_rad: f64) -> StartState {
    let suspension = direction() * (shape.x * lean_rad);
    StartState {
        tilt_rad: lean_rad,
        tilt_azimuth_rad: AZIMUTH_RAD,
        suspension_w_m: [suspension.x, suspension.y],
        ..StartState::AT_REST
    }
}

/// Frequency of the lean over `seconds`, from the first and last passage through zero.
fn frequency_hz(body: &Body, run: &mut TruthMotion, seconds: i64) -> f64 {
    let mut crossings = Vec::new();
    let mut last = (0.0, f64::NAN);
    for k in 0..=100 * seconds {
        let time = at_ms(10 * k);
        let now = (time.as_s(), in_plane(body, &motion(run, time), &direction()).y);
        if last.1 * now.1 < 0.0 {
            crossings.push(last.0 + (now.0 - last.0) * last.1 / (last.1 - now.1));
        }
        last = now;
    }
    assert!(crossings.len() > 4, "only {} passages", crossings.len());
    (crossings.len() - 1) as f64 / (2.0 * (crossings[crossings.len() - 1] - crossings[0]))
}

/// Length, m, and the two frequencies in Hz, quoted to the digits given.
const MODES: [(Option<f64>, f64, f64); 6] = [
    (None, 0.0, 1.538),
    (Some(66.0), 0.061, 1.5395),
    (Some(5.0), 0.221, 1.554),
    (Some(3.0), 0.283, 1.565),
    (Some(2.0), 0.344, 1.578),
    (Some(1.0), 0.473, 1.621),
];

#[test]
fn the_two_modes_of_a_small_motion_are_those_of_the_linear_double_pendulum() {
    for (length_m, quoted_slow_hz, quoted_fast_hz) in MODES {
        let rig = rig(length_m);
        let plane = Plane::new(&rig.body, length_m.map_or(0.0, f64::recip));
        for ((w, shape), quoted_hz) in plane.modes.into_iter().zip([quoted_slow_hz, quoted_fast_hz])
        {
            let exact_hz = w / TAU;
            // A tenth of a per cent, or half of the last digit quoted where that is coarser.
            let quoted = (1e-3 * quoted_hz).max(0.5e-3);
            assert!((exact_hz - quoted_hz).abs() < quoted, "{length_m:?}: {exact_hz} Hz");
            if w == 0.0 {
                continue; // an infinite string does not pull back at all
            }
            // The string, at its longest 66 m, must stay as near to the vertical as the body.
            let mut run = run(&rig, &start(&shape, 1e-4), JUDGE);
            let measured_hz = frequency_hz(&rig.body, &mut run, if w < 1.0 { 100 } else { 20 });
            println!("L = {length_m:?}: {measured_hz:.6} Hz against {exact_hz:.6} Hz");
            // Passages interpolated over 10 ms err by (0.1 rad)³/16 of a radian in 200 rad; the
            // motion itself departs from the linear one by 1e-8.
            assert!((measured_hz / exact_hz - 1.0).abs() < 1e-6, "{length_m:?}: {measured_hz} Hz");
        }
    }
}

#[test]
fn a_mode_released_alone_stays_alone() {
    let rig = rig(Some(2.0));
    let plane = Plane::new(&rig.body, 0.5);
    for (w, shape) in plane.modes {
        let lean_rad = 1e-4;
        let mut run = run(&rig, &start(&shape, lean_rad), JUDGE);
        for k in 0..=1000 {
            let time = at_ms(20 * k);
            let q = in_plane(&rig.body, &motion(&mut run, time), &direction());
            let expected = shape * (lean_rad * (w * time.as_s()).cos());
            // Amplitudes squared, 1e-8 of the angle, times up to 200 rad of phase.
            assert!((q - expected).norm() < 2e-6 * lean_rad * shape.norm(), "{w} rad/s, {time}");
        }
    }
}

#[test]
fn a_support_shaken_sideways_forces_both_modes_of_a_finite_string() {
    let (amplitude_m, frequency_hz) = (1e-5, 0.9);
    let amplitude_w_m = [amplitude_m, 0.0, 0.0];
    let vibrations = vec![Vibration { amplitude_w_m, frequency_hz, phase_rad: 0.0 }];
    let rig = Rig { support: Support { vibrations, ..Support::default() }, ..rig(Some(2.0)) };
    let plane = Plane::new(&rig.body, 0.5);
    let mut run = run(&rig, &StartState::AT_REST, JUDGE);
    let mut largest_rad = 0.0_f64;
    for k in 0..=1000 {
        let time = at_ms(20 * k);
        let q = in_plane(&rig.body, &motion(&mut run, time), &Vector3::x());
        let expected = plane.shaken(amplitude_m, TAU * frequency_hz, time.as_s());
        largest_rad = largest_rad.max(q.y.abs());
        // Some 1e-5 of motion, whose squares and whose roundings of unit quaternions are 1e-10
        // and 1e-11 of it.
        assert!((q - expected).norm() < 1e-6 * amplitude_m, "{time}: {q} against {expected}");
    }
    assert!(largest_rad > amplitude_m, "a test of nothing: {largest_rad} rad");
}

#[test]
fn a_body_hanging_straight_at_rest_stays() {
    for rig in [rig(Some(2.0)), rig(None)] {
        let mut run = run(&rig, &StartState::AT_REST, JUDGE);
        let first = motion(&mut run, SimTime::ZERO);
        let last = motion(&mut run, at_ms(60_000));
        assert_eq!(first, BodyMotion { time: first.time, ..last });
        assert_eq!(rig.body.energy_j(&first).to_bits(), 0, "height and rest are zero");
    }
}
