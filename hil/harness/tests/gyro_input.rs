//! What an emulated gyro makes of the motion, read back from its frames.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use struna_body::{
    Body, Integrator, Mounting, Rig, StartState, TruthMotion, earth_rate_w_rad_s, reference,
};
use struna_gyro::{
    BiasEffects, ClockParams, Gyro, GyroParams, Response, Sampling, Surroundings, datasheet::vg910d,
};
use struna_harness::{BodySource, Emulator, MotionSource, Recording, Reference};
use struna_kernel::{RAD_PER_DEG, SampleGrid, Seed, SimTime};
use struna_wire::{Decoder, FrameSpec};

const SAMPLE_RATE_HZ: f64 = 300.0;

fn frame() -> FrameSpec {
    FrameSpec::from_toml(include_str!("../../../frames/vg910d.toml")).unwrap()
}

/// A VG-910D without noise and bias: what is left is rounding to counts.
fn quiet() -> GyroParams {
    vg910d().without_errors()
}

/// Half a count, and the rounding of rates of up to 1 rad/s.
fn half_a_count_rad_s() -> f64 {
    0.5 * quiet().lsb_rad_s + 1e-15
}

/// Rates decoded from the frames of `samples` samples, rad/s, and the truth beside them.
fn decoded(
    source: impl MotionSource + 'static,
    sampling: Sampling,
    samples: usize,
) -> (Vec<f64>, Vec<Reference>) {
    let emulator = emulator(source, GyroParams { sampling, ..quiet() });
    decoded_of(emulator, samples)
}

fn emulator(source: impl MotionSource + 'static, params: GyroParams) -> Emulator {
    let grid = SampleGrid::new(SimTime::ZERO, SAMPLE_RATE_HZ).unwrap();
    let gyro = Gyro::new(params, Seed(1), 0).unwrap();
    Emulator::new(Box::new(source), gyro, grid, &frame()).unwrap()
}

fn decoded_of(mut emulator: Emulator, samples: usize) -> (Vec<f64>, Vec<Reference>) {
    let mut bytes = Vec::new();
    let truth = (0..samples).map(|_| emulator.emit(&mut bytes).unwrap()).collect();
    let (mut decoder, field) = (Decoder::new(frame()), frame().field_index("rate").unwrap());
    let scale = frame().fields()[field].clone();
    let mut rates_rad_s = Vec::new();
    decoder.push(&bytes, &mut |frame| rates_rad_s.push(scale.to_si(frame.raw()[field])));
    assert_eq!(rates_rad_s.len(), samples);
    (rates_rad_s, truth)
}

fn body_source(rig: impl Into<Rig>, start: &StartState, mounting: Mounting) -> BodySource {
    let truth = TruthMotion::new(rig, start, Integrator::Rk4 { step_s: 1e-3 }).unwrap();
    BodySource { truth, mounting }
}

/// Amplitude of the sine and cosine of `frequency_rad_s` in samples at the ends of intervals.
fn harmonic(values: &[f64], frequency_rad_s: f64) -> (f64, f64) {
    let (mut sin_sum, mut cos_sum) = (0.0, 0.0);
    for (k, value) in values.iter().enumerate() {
        let (sin, cos) = (frequency_rad_s * (k + 1) as f64 / SAMPLE_RATE_HZ).sin_cos();
        sin_sum += 2.0 * value * sin;
        cos_sum += 2.0 * value * cos;
    }
    let n = values.len() as f64;
    (sin_sum / n, cos_sum / n)
}

#[test]
fn a_misaligned_gyro_on_a_swinging_body_sees_the_swing() {
    let body = Body::new(&reference::PARAMS).unwrap();
    let p = body.params();
    let [moment, ..] = p.inertia_kg_m2;
    let swing_rad_s = (p.mass_kg * p.gravity_m_s2 * p.com_depth_m / moment).sqrt();
    let (tilt_rad, misalignment_rad) = (RAD_PER_DEG, 0.5 * RAD_PER_DEG);
    // Swings about x, to which only a rotation about y brings the input axis nearer.
    let start = StartState { tilt_rad, ..StartState::AT_REST };
    let across = Mounting::new([0.0, misalignment_rad], [0.1, 0.0, 0.2]).unwrap();
    // 25 of the swing's periods take 4757.8 samples; the rest of one costs 1e-4.
    let samples = 4758;
    let (seen, _) = decoded(body_source(body, &start, across), Sampling::Instantaneous, samples);
    let (sin, cos) = harmonic(&seen, swing_rad_s);
    let expected_rad_s = misalignment_rad * swing_rad_s * tilt_rad;
    // The period is longer by θ₀²(1/16 + Md²/4A) = 1e-4, which turns the phase by 0.007 on the
    // average of 25 periods; amplitudes are smaller by θ₀²/24 and that phase squared.
    let ratio = sin.hypot(cos) / expected_rad_s;
    println!("swing seen through the misalignment: {ratio} of eps w theta");
    assert!((ratio - 1.0).abs() < 1e-3, "{ratio}");
    assert!(sin < 0.0 && cos.abs() < 0.02 * expected_rad_s, "the body falls back first: {cos:e}");
    // Nothing else is seen: what the sine leaves is that phase drift and rounding.
    let power = seen.iter().map(|rate| rate * rate).sum::<f64>() / seen.len() as f64;
    assert!((2.0 * power / expected_rad_s.powi(2) - 1.0).abs() < 1e-3);

    let along = Mounting::new([misalignment_rad, 0.0], [0.0; 3]).unwrap();
    let (unseen, _) = decoded(body_source(body, &start, along), Sampling::Mean, 600);
    assert!(unseen.iter().all(|rate| rate.abs() <= half_a_count_rad_s()));
}

#[test]
fn estimates_are_judged_by_the_body_and_not_by_the_misaligned_axis() {
    let mounting = Mounting::new([0.0, RAD_PER_DEG], [0.0; 3]).unwrap();
    let body = Body::new(&reference::PARAMS).unwrap();
    let mut truth =
        TruthMotion::new(body, &reference::S3, Integrator::Rk4 { step_s: 1e-3 }).unwrap();
    let (_, judged) = decoded(body_source(body, &reference::S3, mounting), Sampling::Mean, 300);
    for reference in judged {
        let motion = truth.motion_at(reference.time).unwrap();
        assert_eq!(reference.rate_rad_s.to_bits(), motion.omega_wb_b_rad_s.z.to_bits());
        assert_eq!(reference.spin_rad.to_bits(), motion.spin_rad.to_bits());
        assert_eq!(reference.twist_rad, Some(motion.twist_rad));
        let axis = mounting.input_axis_b();
        let input_rad_s = axis.dot(&motion.omega_wb_b_rad_s);
        // One scalar product, taken twice.
        assert!((reference.input_rate_rad_s - input_rad_s).abs() < 1e-15);
    }
}

#[test]
fn an_instantaneous_sample_is_half_an_interval_ahead_of_the_mean() {
    let acceleration_rad_s2 = 0.2;
    let ramp = || Recording::new(&[0.0, 2.0], &[0.0, 2.0 * acceleration_rad_s2]).unwrap();
    let (means, _) = decoded(ramp(), Sampling::Mean, 300);
    let (instants, truth) = decoded(ramp(), Sampling::Instantaneous, 300);
    let lead_rad_s = acceleration_rad_s2 * 0.5 / SAMPLE_RATE_HZ;
    // The lead is 626 counts; means and instants are rounded to half a count each.
    for ((mean, instant), reference) in means.iter().zip(&instants).zip(&truth) {
        assert!((instant - mean - lead_rad_s).abs() <= 2.0 * half_a_count_rad_s());
        assert!((instant - reference.rate_rad_s).abs() <= half_a_count_rad_s());
    }
}

#[test]
fn means_of_a_swing_add_up_to_the_angle_and_instants_do_not() {
    let mounting = Mounting::new([0.0, 20.0 * RAD_PER_DEG], [0.0; 3]).unwrap();
    let body = Body::new(&reference::PARAMS).unwrap();
    let angle_errors_rad = [Sampling::Mean, Sampling::Instantaneous].map(|sampling| {
        let source = body_source(body, &reference::S3, mounting);
        let (rates, truth) = decoded(source, sampling, 1000);
        let sum_rad = rates.iter().sum::<f64>() / SAMPLE_RATE_HZ;
        (sum_rad - truth[999].input_angle_rad).abs()
    });
    println!("angle errors of summed means and instants: {angle_errors_rad:?} rad");
    // Half a count in each of 1000 samples at the very worst.
    assert!(angle_errors_rad[0] <= 1000.0 / SAMPLE_RATE_HZ * half_a_count_rad_s());
    // The left out half interval at both ends, some 1e-3 rad/s of difference times 1/600 s.
    assert!(angle_errors_rad[1] > 10.0 * angle_errors_rad[0], "{angle_errors_rad:?}");
}

#[test]
fn a_body_at_rest_turns_with_the_earth() {
    let latitude_rad = 55.9 * RAD_PER_DEG;
    let rig = Rig {
        earth_rate_w_rad_s: earth_rate_w_rad_s(latitude_rad),
        ..Rig::from(Body::new(&reference::PARAMS).unwrap())
    };
    let vertical_rad_s = 7.292_115e-5 * latitude_rad.sin();
    let source = body_source(rig.clone(), &StartState::AT_REST, Mounting::default());
    let (rates, truth) = decoded(source, Sampling::Mean, 300);
    // 113 counts: 12.45 deg/h, more than the turn-on bias.
    assert!(rates.iter().all(|rate| (rate - vertical_rad_s).abs() <= half_a_count_rad_s()));
    assert!(truth.iter().all(|reference| reference.rate_rad_s.abs() < 1e-15));

    // A rotation about x, east, by a negative angle leans the axis to the north.
    let lean_rad = 10.0 * RAD_PER_DEG;
    let north = Mounting::new([-lean_rad, 0.0], [0.0; 3]).unwrap();
    let (rates, _) = decoded(body_source(rig, &StartState::AT_REST, north), Sampling::Mean, 300);
    // The pole stands at the latitude above the horizon, so leaning north is going north.
    let leaning_rad_s = 7.292_115e-5 * (latitude_rad + lean_rad).sin();
    assert!(rates.iter().all(|rate| (rate - leaning_rad_s).abs() <= half_a_count_rad_s()));
}

/// A rate that rises by `slope_rad_s2`.
fn ramp(slope_rad_s2: f64) -> Recording {
    Recording::new(&[0.0, 4.0], &[0.0, 4.0 * slope_rad_s2]).unwrap()
}

#[test]
fn a_band_limited_gyro_lags_by_its_filter_however_it_samples() {
    let slope_rad_s2 = 0.2;
    let response = Response { natural_frequency_hz: 10.0, ..Response::default() };
    let lag_s = 2.0_f64.sqrt() / (std::f64::consts::TAU * 10.0);
    for (sampling, more_s) in
        [(Sampling::Instantaneous, 0.0), (Sampling::Mean, 0.5 / SAMPLE_RATE_HZ)]
    {
        let params = GyroParams { sampling, response, ..quiet() };
        let (rates, truth) = decoded_of(emulator(ramp(slope_rad_s2), params), 900);
        for (rate, truth) in rates.iter().zip(&truth).skip(300) {
            let lagging_rad_s = truth.rate_rad_s - slope_rad_s2 * (lag_s + more_s);
            // After 22 time constants nothing is left of the start; the mean held through each
            // sample costs 2e-5 of one.
            let tolerance = half_a_count_rad_s() + 2e-5 * slope_rad_s2 / SAMPLE_RATE_HZ;
            assert!((rate - lagging_rad_s).abs() <= tolerance, "{sampling:?}");
        }
    }
}

#[test]
fn a_fast_clock_samples_early_and_the_truth_comes_with_it() {
    let clock = ClockParams { offset: 0.02, ..ClockParams::default() };
    let params = GyroParams { clock, sampling: Sampling::Instantaneous, ..quiet() };
    let mut emulator = emulator(ramp(0.2), params);
    for k in 1..=600_u32 {
        let sensor_time_s = emulator.next_sensor_time().as_s();
        assert!((sensor_time_s - f64::from(k) / SAMPLE_RATE_HZ).abs() < 1e-9);
        let time = emulator.next_time();
        let truth = emulator.emit(&mut Vec::new()).unwrap();
        assert_eq!(truth.time, time);
        // Rounded to the nanosecond, each of the two.
        assert!((time.as_s() * 1.02 - sensor_time_s).abs() < 1.1e-9, "{k}");
    }
}

#[test]
fn a_gyro_sensitive_to_g_feels_gravity_by_its_lean_and_swing_by_its_place() {
    let body = Body::new(&reference::PARAMS).unwrap();
    let g = body.params().gravity_m_s2;
    let felt = |source: BodySource, axis: usize, samples| {
        let mut per_specific_force_s_m = [0.0; 3];
        per_specific_force_s_m[axis] = 1e-2;
        let bias_effects = BiasEffects { per_specific_force_s_m, ..BiasEffects::default() };
        let params = GyroParams { bias_effects, ..quiet() };
        let (rates, truth) = decoded_of(emulator(source, params), samples);
        let own = |(rate, truth): (&f64, &Reference)| rate - truth.rate_rad_s;
        rates.iter().zip(&truth).map(own).map(|rate| rate / 1e-2).collect::<Vec<_>>()
    };
    // Half a count of rate is 3e-5 m/s² here.
    let close = |found: f64, expected: f64| (found - expected).abs() < 3e-5;
    // Turned by α about x and β about y: along the case gravity is Rᵀ(0, 0, g).
    let (alpha, beta) = (0.1_f64, -0.2_f64);
    let leaning = Mounting::new([alpha, beta], [0.0; 3]).unwrap();
    let expected = [-beta.sin() * g, alpha.sin() * beta.cos() * g, alpha.cos() * beta.cos() * g];
    for (axis, expected) in expected.into_iter().enumerate() {
        let found = felt(body_source(body, &StartState::AT_REST, leaning), axis, 3);
        assert!(found.iter().all(|force| close(*force, expected)), "{axis}: {found:?} {expected}");
    }

    // Under a string without end the centre of mass stays where it is while the body swings
    // about it by θ·cos ωt, ω² = Mgd/A: across the body, h below the hold, it feels
    // (g − ω²(h − d))·θ.
    let (p, tilt_rad) = (body.params(), 0.02);
    let start = StartState { tilt_rad, ..StartState::AT_REST };
    let squared = p.mass_kg * g * p.com_depth_m / p.inertia_kg_m2[0];
    for depth_m in [-0.1, 0.0, 0.3] {
        let mounting = Mounting::new([0.0; 2], [0.0, 0.0, -depth_m]).unwrap();
        let found = felt(body_source(body, &start, mounting), 1, 60);
        for (k, found) in (1..).zip(found) {
            let swing_rad = tilt_rad * (squared.sqrt() * f64::from(k) / SAMPLE_RATE_HZ).cos();
            let expected = (g - squared * (depth_m - p.com_depth_m)) * swing_rad;
            // Half a count, and what is of third order in the tilt: some θ² of (3g + ω²h)θ.
            assert!((found - expected).abs() < 3e-5 + 1e-3, "{depth_m} m: {found} {expected}");
        }
    }
}

#[test]
fn temperature_rises_over_a_run_as_the_surroundings_say() {
    let bias_effects = BiasEffects { per_deg_c_rad_s: 1e-3, ..BiasEffects::default() };
    let warming = Surroundings { temperature_rate_deg_c_s: 0.5, ..Surroundings::default() };
    let emulator = emulator(ramp(0.0), GyroParams { bias_effects, ..quiet() });
    let (rates, truth) = decoded_of(emulator.with_surroundings(warming), 300);
    for (rate, truth) in rates.iter().zip(&truth) {
        let expected_rad_s = 1e-3 * 0.5 * truth.time.as_s();
        assert!((rate - expected_rad_s).abs() <= half_a_count_rad_s());
    }
}
