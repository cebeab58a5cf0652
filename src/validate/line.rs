//! Suite `line`: the same estimator behind a real frame, a line that loses and alters bytes, and a
//! decoder.

use super::bound::Information;
use super::contestant::{Kind, Measured};
use super::entrant::{Entrant, Field, describe_noise};
use super::requirement::{Requirement, Statistic, honest_nees};
use super::row::{Column, Row};
use super::suite::{Case, Figure, RunId, Suite};
use super::tally::Truth;
use super::torsion::{Drawn, Ensemble, R_RAD2_S2, SAMPLES, STEP_S};
use crate::faults::Stream;
use crate::figure::FigureError;
use crate::validate::figures;
use anyhow::Result;
use struna_gyro::{Gyro, GyroParams};
use struna_harness::fault::{Fault, FaultKind, FaultPlan, Injector, Trigger};
use struna_harness::{
    Averager, Emulator, LineEvent, MotionSource, Pipeline, PipelineError, Reference, SourceError,
    Transmitter,
};
use struna_kernel::{RAD_PER_DEG, RateSample, SampleGrid, SimTime};
use struna_line::LineModel;

const NAME: &str = "line";
/// The gyro whose line it is: 300 Hz, counter of 256 frames, CRC.
const STREAM: Stream = Stream::Vg;
/// Gyro samples in a measured rate.
const AVERAGED: u64 = 3;

/// What happens to the line.
struct LineCase {
    name: &'static str,
    kind: Option<(FaultKind, Often)>,
    entrants: Vec<Entrant>,
}

/// How often it happens, and for how long.
#[derive(Clone, Copy)]
enum Often {
    /// So many times in a byte.
    PerByte(f64),
    /// So many times a second, a moment.
    PerSecond(f64),
    /// For so long, s, about every so many seconds. Shorter than the counter's round of 0.85 s, or
    /// the decoder could not know how long it was.
    Lasting(f64, f64),
}

impl LineCase {
    fn plan(&self) -> Result<FaultPlan> {
        let Some((kind, often)) = self.kind else { return Ok(FaultPlan::default()) };
        let (trigger, duration_s) = match often {
            Often::PerByte(rate_per_byte) => (Trigger::PerByte { rate_per_byte }, 0.0),
            Often::PerSecond(rate_hz) => (Trigger::Random { rate_hz }, 0.0),
            Often::Lasting(duration_s, period_s) => {
                let (first, jitter_s) = (SimTime::from_s(3.0)?, 0.5 * period_s);
                (Trigger::Every { first, period_s, jitter_s }, duration_s)
            }
        };
        Ok(FaultPlan::new(vec![Fault { kind, trigger, duration: SimTime::from_s(duration_s)? }])?)
    }
}

/// The torsional rig as a source of motion.
struct Rig(Drawn);

impl MotionSource for Rig {
    fn reference_at(&mut self, time: SimTime) -> Result<Reference, SourceError> {
        let (angle_rad, rate_rad_s) = self.0.motion_between(time.as_s() / STEP_S);
        Ok(Reference {
            time,
            input_angle_rad: angle_rad,
            input_rate_rad_s: rate_rad_s,
            spin_rad: angle_rad,
            rate_rad_s,
            specific_force_s_m_s2: None,
            twist_rad: Some(angle_rad),
            twist_rate_rad_s: Some(rate_rad_s),
        })
    }
}

/// The host's end: bytes in, measured rates to the field.
struct Host {
    pipeline: Pipeline,
    field: Field,
    drawn: Drawn,
    last: SimTime,
    samples: u64,
    failure: Option<PipelineError>,
}

impl Host {
    fn take(&mut self, event: LineEvent<'_>) {
        let LineEvent::Bytes(bytes) = event else { return };
        let Self { pipeline, field, drawn, last, samples, .. } = self;
        let pushed = pipeline.push(bytes, &mut |sample, _| {
            *samples += 1;
            step(field, drawn, last, sample);
        });
        if let Err(failure) = pushed {
            self.failure.get_or_insert(failure);
        }
    }
}

fn step(field: &mut Field, drawn: &mut Drawn, last: &mut SimTime, sample: &RateSample) {
    let span_s = sample.time.seconds_since(*last);
    let measured = Measured::mean(span_s, sample.span_s(), sample.rate_rad_s);
    let measured = Measured { over_range: sample.over_range, ..measured };
    *last = sample.time;
    let Some(k) = grid_index(sample.time) else { return };
    let truth: Truth = drawn.truth(k);
    field.step(k, &measured, &truth);
}

/// Number of the rig's sample at an instant; none beyond the end of the run.
fn grid_index(time: SimTime) -> Option<u32> {
    let step_ns = 10_000_000;
    let k = u32::try_from((time.as_ns() + step_ns / 2) / step_ns).ok()?;
    (1..=SAMPLES).contains(&k).then_some(k)
}

impl Case for LineCase {
    fn name(&self) -> &str {
        self.name
    }

    fn estimators(&self) -> Vec<String> {
        self.entrants.iter().map(|entrant| entrant.name.to_owned()).collect()
    }

    fn run(&self, id: RunId) -> Result<Vec<Row>> {
        // The source of the emulator's motion goes on by itself: nothing may strike the body.
        let ensemble = Ensemble { torque_density_deg2_s3: 0.0, ..Ensemble::B };
        let mut drawn = ensemble.draw(id.seed, id.run)?;
        let params = GyroParams { bias_rad_s: drawn.bias_rad_s(), ..gyro_params() };
        let describe = |row: &mut Row| {
            describe_noise(row, params.noise_sigma_rad_s() / RAD_PER_DEG, 3);
            row.set(Column::LsbDegS, params.lsb_rad_s / RAD_PER_DEG);
        };
        let of = (&ensemble, &mut drawn);
        let noise = (R_RAD2_S2, Information::White(R_RAD2_S2));
        let field = Field::new(id, (NAME, self.name), &self.entrants, of, noise, &describe)?;
        let (frame, run) = (STREAM.frame(), u64::from(id.run));
        let grid = SampleGrid::new(SimTime::ZERO, params.sample_rate_hz)?;
        let gyro = Gyro::new(params, id.seed, run)?;
        let injector = Injector::new(&self.plan()?, &frame, id.seed, run);
        let emulator = Emulator::new(Box::new(Rig(drawn.clone())), gyro, grid, &frame)?;
        let mut transmitter =
            Transmitter::new(emulator.with_faults(injector), LineModel::new(STREAM.line()));
        let pipeline = Pipeline::new(frame, Averager::new(grid, AVERAGED)?, Vec::new())?;
        let last = SimTime::ZERO;
        let mut host = Host { pipeline, field, drawn, last, samples: 0, failure: None };
        for _ in 0..u64::from(SAMPLES) * AVERAGED {
            transmitter.emit(&mut |_, event| host.take(event))?;
        }
        transmitter.flush(&mut |_, event| host.take(event));
        if let Some(failure) = host.failure {
            return Err(failure.into());
        }
        let events = transmitter.fault_records().len() as f64;
        let lost = host.pipeline.finish().wire.lost as f64;
        let describe = |row: &mut Row| {
            row.set(Column::LineEvents, events);
            row.set(Column::LostSamples, lost);
        };
        Ok(host.field.finish(&describe))
    }
}

/// The gyro of the line with the rig's noise in the mean of three.
fn gyro_params() -> GyroParams {
    let angle_random_walk_rad_sqrt_s = (R_RAD2_S2 * STEP_S).sqrt();
    GyroParams { angle_random_walk_rad_sqrt_s, ..STREAM.gyro() }
}

const CLEAN: &str = "clean line";
const WRONG: &str = "1 wrong value in 10 s, check right";

/// The suite.
pub(super) fn suite() -> Suite {
    let tested = || vec![Entrant::PLAIN];
    let case = |name, kind, often| LineCase { name, kind: Some((kind, often)), entrants: tested() };
    let untested = Entrant { name: "EKF5a", kind: Kind::Augmented, ..Entrant::PLAIN };
    let cases = vec![
        LineCase { name: CLEAN, kind: None, entrants: tested() },
        case("1 bit in 1000 bytes flipped", FaultKind::BitFlip, Often::PerByte(1e-3)),
        case("1 byte in 1000 lost", FaultKind::ByteDrop, Often::PerByte(1e-3)),
        case("1 byte in 1000 put in", FaultKind::InsertedByte, Often::PerByte(1e-3)),
        case("bursts of 8 bytes, 1 a second", FaultKind::Burst { bytes: 8 }, Often::PerSecond(1.0)),
        case("1 frame in 100 cut short", FaultKind::Truncated, Often::PerSecond(3.0)),
        case("frames doubled, 3 a second", FaultKind::DuplicatedFrame, Often::PerSecond(3.0)),
        case("gaps of 0.5 s every 10 s", FaultKind::Dropout, Often::Lasting(0.5, 10.0)),
        case("unplugged 0.5 s every 30 s", FaultKind::PortLoss, Often::Lasting(0.5, 30.0)),
        LineCase {
            name: WRONG,
            kind: Some((FaultKind::WrongValue, Often::PerSecond(0.1))),
            entrants: vec![Entrant::PLAIN, untested],
        },
    ];
    let names: Vec<&'static str> = cases.iter().map(|case| case.name).collect();
    Suite {
        name: NAME,
        about: "Scenario B through the whole chain: gyro, frames of 11 bytes with counter and CRC, \
                a serial line behind a USB bridge, decoder, mean of three samples. Bytes are \
                altered, lost and put in, frames are cut and doubled, the line falls silent. The \
                bound is that of a line which loses nothing.",
        runs: 400,
        cases: cases.into_iter().map(|case| Box::new(case) as Box<dyn Case>).collect(),
        requirements: requirements(&names),
        draw,
    }
}

fn requirements(cases: &[&str]) -> Vec<Requirement> {
    let ratio = Statistic::RmsOver(Column::AngleHalf2Deg, Column::BoundAngleDeg);
    let beyond = Statistic::ShareAbove(Column::EndSigmas, 3.0);
    let mut all = Vec::new();
    for case in cases {
        let cell = (*case, Entrant::PLAIN.name);
        // As on no line at all: what is lost is a few per cent of the samples.
        all.push(Requirement::new(cell, ratio, 0.8..=1.15));
        all.push(Requirement::new(cell, beyond, 0.0..=0.03));
        // The torque that estimators reckon with is not there: a claim may be too cautious.
        all.push(Requirement::new(cell, Statistic::Nees, 0.0..=*honest_nees(5.0).end()));
    }
    let loud = Requirement::new((WRONG, "EKF5a"), ratio, 2.0..=f64::INFINITY);
    all.push(loud.as_control());
    all
}

fn draw(rows: &[&Row]) -> Result<Vec<Figure>, FigureError> {
    let all = vec![
        figures::bars(
            rows,
            &figures::Bars {
                title: "RMS of the angle over the second half, by what happens to the line",
                column: Column::AngleHalf2Deg,
                bound: Some(Column::BoundAngleDeg),
                axis: "deg",
            },
        )?,
        figures::claims(rows, "Error at the end in claimed standard deviations")?,
    ];
    Ok(all)
}
