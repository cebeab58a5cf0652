//! Many bodies at once beside one body at a time, and the price of a smooth sample.

use crate::table::{Row, ns};
use crate::timing::{Burst, best_in_turns, time_per_unit};
use anyhow::{Result, ensure};
use std::hint::black_box;
use struna_body::batch::{Batch, BatchBody, Level, NoiseGrid, SlipElement};
use struna_body::ode::{Dop853Sampler, Rk4};
use struna_body::{Body, FAST_STATES, FastEquations, reference};
use struna_kernel::Seed;

const STEP_S: f64 = 1.0 / 1400.0;
const STEPS: u32 = 700;
/// Whole blocks at every level.
const BODIES: usize = 64;
/// What one body's steps in lanes must gain on one body's steps alone. A step that lost the vector
/// instructions, as by a closure, gains nothing.
const GAIN_TARGET: f64 = 4.0;
const SAMPLE_LIMIT_S: f64 = 25e-9;
const SAMPLES: usize = 14_000;
/// Rate about the body axis, and twist.
const SAMPLED: [usize; 2] = [5, 6];
/// Torques are held for 10 ms.
const STEPS_PER_CELL: u32 = 14;

pub(crate) fn rows() -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for level in Level::ALL.into_iter().filter(|level| level.is_available()) {
        rows.extend(against_one_body(level)?);
    }
    rows.push(smooth_samples()?);
    Ok(rows)
}

fn body() -> Result<BatchBody> {
    Ok(BatchBody::new(Body::new(&reference::PARAMS)?, reference::S3))
}

/// A body with a random torque of its own and a thread that slips.
fn full_body(run: usize) -> Result<BatchBody> {
    let body = body()?;
    let stiffness_n_m_rad = 10.0 * body.body.stiffness_n_m_rad();
    let element = SlipElement { stiffness_n_m_rad, yield_rad: 0.1, ..SlipElement::NONE };
    let mut thread = body.thread;
    thread[0] = element;
    Ok(BatchBody { run: run as u64, torque_noise_b_n_m_sqrt_hz: [1e-7; 3], thread, ..body })
}

fn against_one_body(level: Level) -> Result<[Row; 2]> {
    let noise = NoiseGrid { seed: Seed(1), steps_per_cell: STEPS_PER_CELL };
    let mut plain = Batch::with_level(&[body()?; BODIES], STEP_S, noise, level)?;
    let full: Vec<_> = (0..BODIES).map(full_body).collect::<Result<_>>()?;
    let mut full = Batch::with_level(&full, STEP_S, noise, level)?;
    let mut single = Single::start()?;
    same_motion(&plain, &single)?;
    let [plain_s, full_s, single_s] =
        best_in_turns([batch_burst(&mut plain), batch_burst(&mut full), single.burst()])?;
    // Plain Rust gains what the compiler finds in its loops; only the vector types owe a gain.
    let target = if level == Level::Baseline { 1.0 } else { GAIN_TARGET };
    let row = |what: &str, ours_s: f64, target| Row {
        what: format!("batch {level} against single body scalar, per core{what}"),
        ours: steps_per_s(ours_s),
        other: format!("{} (single body)", steps_per_s(single_s)),
        ratio: Some(single_s / ours_s),
        target,
    };
    Ok([row("", plain_s, target), row(", noise at 100 Hz and hysteresis", full_s, 1.0)])
}

fn steps_per_s(s: f64) -> String {
    format!("{:.1}e6 steps/s", 1e-6 / s)
}

fn batch_burst(batch: &mut Batch) -> Burst<'_> {
    Box::new(|| {
        time_per_unit(STEPS as usize * BODIES, || Ok(black_box(&mut *batch).advance(STEPS.into())?))
    })
}

/// One body, walked by the integrator that live runs use.
struct Single {
    equations: FastEquations,
    walk: Rk4<FAST_STATES>,
    steps: u32,
}

impl Single {
    fn start() -> Result<Self> {
        let equations = FastEquations::new(&Body::new(&reference::PARAMS)?, [0.0; 3]);
        let walk = Rk4::new(STEP_S, FastEquations::start(&reference::S3)?)?;
        Ok(Self { equations, walk, steps: 0 })
    }

    #[inline(never)]
    fn step(&mut self, steps: u32) -> Result<[f64; FAST_STATES]> {
        self.steps += steps;
        Ok(self.walk.state_at(&self.equations, f64::from(self.steps) * STEP_S)?)
    }

    fn burst(&mut self) -> Burst<'_> {
        Box::new(|| time_per_unit(STEPS as usize, || self.step(STEPS).map(drop)))
    }
}

/// A ratio of two different motions would say nothing.
fn same_motion(batch: &Batch, single: &Single) -> Result<()> {
    let (mut batch, mut walk) = (batch.clone(), single.walk.clone());
    batch.advance(STEPS.into())?;
    let alone = walk.state_at(&single.equations, f64::from(STEPS) * STEP_S)?;
    for index in 0..BODIES {
        let apart = alone.iter().zip(batch.states(index)?).any(|(a, b)| (a - b).abs() > 1e-12);
        ensure!(!apart, "body {index} of the batch does not move as the same body alone");
    }
    Ok(())
}

/// Samples of rate and twist at 1400 Hz without noise.
fn smooth_samples() -> Result<Row> {
    let equations = FastEquations::new(&Body::new(&reference::PARAMS)?, [0.0; 3]);
    let start = FastEquations::start(&reference::S3)?;
    let mut samples = vec![[0.0; 2]; SAMPLES];
    let [taken_s] = best_in_turns([Box::new(|| {
        time_per_unit(SAMPLES, || {
            let mut sampler = Dop853Sampler::new(0.04, STEP_S, SAMPLED, black_box(start))?;
            sampler.fill(&equations, &mut samples)?;
            black_box(&samples);
            Ok(())
        })
    })])?;
    Ok(Row {
        what: "noise-free 1400 Hz samples of rate and twist".into(),
        ours: ns(taken_s),
        other: format!("{} (limit)", ns(SAMPLE_LIMIT_S)),
        ratio: Some(SAMPLE_LIMIT_S / taken_s),
        target: 1.0,
    })
}
