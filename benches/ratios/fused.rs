//! One run of 480 s at 1400 Hz on one thread: true motion with torque noise, MEMS gyro, bytes,
//! decoder, both filters of 2008 and the five-state filter, every sample through all of them.
//!
//! The same emulator and pipeline as in `struna run`, with a buffer in place of the
//! pseudo-terminal. Then each part by itself, beside twice what a hand-written version of it took
//! on a quicker machine; kfilter, which took 22.6 ns there, is timed beside them and gives the
//! scale.

use crate::filters::{config, kfilter_of, measured_rate_rad_s, run_kfilter};
use crate::table::{Row, ns};
use crate::timing::{Burst, best_in_turns, time_per_unit};
use anyhow::{Result, ensure};
use std::f64::consts::TAU;
use std::hint::black_box;
use struna::frames;
use struna::in_process::InProcess;
use struna_body::{
    Body, BodyParams, Disturbances, Integrator, Mounting, Rig, StartState, TorqueNoise, Torsion,
    TorsionDamping, TruthMotion, reference,
};
use struna_estimator::{
    AugmentedConfig, AugmentedFilter, Filter, RateEstimator, Refinement, StartPrior,
};
use struna_gyro::{ClockParams, Gyro, GyroInput, GyroParams, Surroundings, preset};
use struna_harness::{
    Averager, BodySource, DeviceUnderTest, Emulator, MotionSource, Pipeline, PipelineReport,
};
use struna_kernel::{SampleGrid, Seed, SimTime};
use struna_wire::{Decoder, Encoder, FrameSpec};

const RATE_HZ: f64 = 1400.0;
const SAMPLES: u64 = 672_000;
/// What the whole run may take on the machine of the limits below.
const LIMIT_S: f64 = 0.2;
/// Samples in a burst of one part.
const BURST: u32 = 100_000;
/// Frames between two calls of the decoder: what one read of a fast line returns.
const FRAMES_PER_READ: u64 = 64;
const PERIOD_S: f64 = 480.0;
/// kfilter's step on the machine of the limits below.
const KFILTER_THERE_S: f64 = 22.6e-9;

pub(crate) fn rows() -> Result<Vec<Row>> {
    let two_states = config(Refinement::OFF);
    let rates_rad_s: Vec<_> = (1..=4000).map(measured_rate_rad_s).collect();
    let mut peer = kfilter_of(&two_states)?;
    let frame = frames::frame_named_or_file("struna/adis16100@1")?;
    let [whole_s, truth_s, gyro_s, encode_s, decode_s, filters_s, augmented_s, peer_s] =
        best_in_turns([
            Box::new(|| time_per_unit(1, || whole(&frame))),
            truth_burst()?,
            gyro_burst()?,
            encode_burst(&frame)?,
            decode_burst(&frame)?,
            filters_burst()?,
            augmented_burst()?,
            Box::new(|| time_per_unit(rates_rad_s.len(), || run_kfilter(&mut peer, &rates_rad_s))),
        ])?;
    let scale = peer_s / KFILTER_THERE_S;
    let part = |what: &str, taken_s: f64, there_s: f64| Row {
        what: format!("of it: {what}"),
        ours: ns(taken_s),
        other: format!("{} (2 x {} x {scale:.2})", ns(2.0 * there_s * scale), ns(there_s)),
        ratio: Some(2.0 * there_s * scale / taken_s),
        target: 1.0,
    };
    Ok(vec![
        Row {
            what: "480 s at 1400 Hz, truth to estimates, one thread".into(),
            ours: format!("{whole_s:.3} s"),
            other: format!("{LIMIT_S} s x {scale:.2} (limit, by kfilter)"),
            ratio: Some(LIMIT_S * scale / whole_s),
            target: 1.0,
        },
        part("truth with torque noise, RK4", truth_s, 82e-9),
        part("gyro, ADIS16100 preset", gyro_s, 11e-9),
        part("encode 7 bytes with CRC", encode_s, 1.9e-9),
        part("decode 7 bytes with CRC", decode_s, 2.8e-9),
        part("two filters of 2008", filters_s, 15.3e-9),
        part("five-state filter", augmented_s, 25.5e-9),
    ])
}

/// The whole run, from a body at rest to the last estimate.
fn whole(frame: &FrameSpec) -> Result<()> {
    let grid = SampleGrid::new(SimTime::ZERO, RATE_HZ)?;
    // Its clock is the laboratory's: samples and the cells of the torque noise then share a grid,
    // and no step is cut in two.
    let gyro = GyroParams { clock: ClockParams::default(), ..preset::adis16100() };
    let gyro = Gyro::new(gyro, Seed(1), 0)?;
    let source = BodySource { truth: truth()?, mounting: Mounting::default() };
    let mut emulator = Emulator::new(Box::new(source), gyro, grid, frame)?;
    let mut pipeline = Pipeline::new(frame.clone(), Averager::new(grid, 1)?, devices()?)?;
    let mut bytes = Vec::new();
    for _ in 0..SAMPLES / FRAMES_PER_READ {
        bytes.clear();
        for _ in 0..FRAMES_PER_READ {
            emulator.emit(&mut bytes)?;
        }
        pipeline.push(&bytes, &mut |_, estimates| {
            black_box(estimates);
        })?;
    }
    let PipelineReport { outputs, .. } = pipeline.finish();
    ensure!(outputs + 1 >= SAMPLES, "{outputs} of {SAMPLES} samples came through");
    Ok(())
}

fn truth() -> Result<TruthMotion> {
    let damping = TorsionDamping::Ratio(0.03);
    let torsion = Torsion { damping, ..reference::PARAMS.torsion };
    let noise = TorqueNoise { density_b_n_m_sqrt_hz: [1e-8; 3] };
    let disturbances = Disturbances { noise: Some(noise), ..Disturbances::default() };
    let body = Body::new(&BodyParams { torsion, ..reference::PARAMS })?;
    let rig = Rig { disturbances, ..Rig::from(body) };
    let integrator = Integrator::Rk4 { step_s: 1.0 / RATE_HZ };
    Ok(TruthMotion::new(rig, &StartState::twisted(TAU, 0.0), integrator)?)
}

fn augmented() -> Result<AugmentedFilter> {
    let r = config(Refinement::OFF).measurement_variance_rad2_s2;
    let start = StartPrior::released(TAU, PERIOD_S);
    Ok(AugmentedFilter::new(&AugmentedConfig::quiet(start, r))?)
}

fn devices() -> Result<Vec<Box<dyn DeviceUnderTest>>> {
    let two_states = config(Refinement::OFF);
    let rotation = Filter::permanent_rotation(two_states)?;
    let torsion = Filter::torsional_oscillation(two_states, PERIOD_S)?;
    let device = |name, estimator: Box<dyn RateEstimator>| -> Box<dyn DeviceUnderTest> {
        Box::new(InProcess::new(name, estimator))
    };
    Ok(vec![
        device("rotation", Box::new(rotation)),
        device("torsion", Box::new(torsion)),
        device("augmented", Box::new(augmented()?)),
    ])
}

/// A burst of `BURST` samples, each made by `sample`.
fn burst<'a>(mut sample: impl FnMut(u32) -> Result<()> + 'a) -> Burst<'a> {
    Box::new(move || time_per_unit(BURST as usize, || (0..BURST).try_for_each(&mut sample)))
}

fn truth_burst() -> Result<Burst<'static>> {
    let grid = SampleGrid::new(SimTime::ZERO, RATE_HZ)?;
    let mut source = BodySource { truth: truth()?, mounting: Mounting::default() };
    let mut k = 0;
    Ok(burst(move |_| {
        k += 1;
        black_box(source.reference_at(grid.time_of(k))?);
        Ok(())
    }))
}

fn gyro_burst() -> Result<Burst<'static>> {
    let mut gyro = Gyro::new(preset::adis16100(), Seed(1), 0)?;
    let input: GyroInput = Surroundings::default().input_at(0.0, 0.08, None);
    Ok(burst(move |_| {
        black_box(&gyro.sample(*black_box(&input)));
        Ok(())
    }))
}

fn encode_burst(frame: &FrameSpec) -> Result<Burst<'_>> {
    let mut encoder = Encoder::new(frame);
    let mut raw = vec![0; frame.fields().len()];
    let mut bytes = Vec::new();
    let rate = frame.field_index("rate").unwrap_or(0);
    Ok(burst(move |k| {
        if u64::from(k).is_multiple_of(FRAMES_PER_READ) {
            bytes.clear();
        }
        raw[rate] = i64::from(k % 64);
        encoder.encode(black_box(&raw), &mut bytes)?;
        Ok(())
    }))
}

fn decode_burst(frame: &FrameSpec) -> Result<Burst<'_>> {
    let mut encoder = Encoder::new(frame);
    let mut bytes = Vec::new();
    let raw = vec![0; frame.fields().len()];
    for _ in 0..BURST {
        encoder.encode(&raw, &mut bytes)?;
    }
    let read = bytes.len() / (u64::from(BURST) / FRAMES_PER_READ) as usize;
    Ok(Box::new(move || {
        let mut decoder = Decoder::new(frame.clone());
        time_per_unit(BURST as usize, || {
            for read in bytes.chunks(read) {
                decoder.push(black_box(read), &mut |frame| {
                    black_box(frame);
                });
            }
            Ok(())
        })
    }))
}

fn filters_burst() -> Result<Burst<'static>> {
    let two_states = config(Refinement::OFF);
    let mut rotation = Filter::permanent_rotation(two_states)?;
    let mut torsion = Filter::torsional_oscillation(two_states, PERIOD_S)?;
    Ok(burst(move |k| {
        let rate_rad_s = black_box(f64::from(k % 64) * 1e-5);
        black_box(rotation.step(1.0 / RATE_HZ, rate_rad_s)?);
        black_box(torsion.step(1.0 / RATE_HZ, rate_rad_s)?);
        Ok(())
    }))
}

fn augmented_burst() -> Result<Burst<'static>> {
    let mut filter = augmented()?;
    Ok(burst(move |k| {
        let rate_rad_s = black_box(f64::from(k % 64) * 1e-5);
        black_box(filter.step(1.0 / RATE_HZ, rate_rad_s)?);
        Ok(())
    }))
}
