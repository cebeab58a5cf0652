//! One run of a scenario: builds the chain, drives it, gathers the record.

pub use crate::devices::devices;

use crate::record::{
    ESTIMATOR_SIGNALS, Record, TRUE_BODY_RATE, TRUE_TWIST_RATE, estimator_values, measured_signals,
    measured_values,
};
use crate::recording;
use crate::scenario::{Scenario, Source};
use anyhow::Result;
use std::path::Path;
use struna_body::Backend;
use struna_gyro::Gyro;
use struna_harness::fault::Injector;
use struna_harness::{
    Averager, BodySource, Emulator, MotionSource, Observer, Pacing, Pipeline, Reference, RunReport,
    cross_rate_fields,
};
use struna_kernel::{AngleEstimate, RateSample, SampleGrid, SimTime};
use struna_line::StopFlag;

/// What a run left behind.
#[derive(Debug)]
pub struct Session {
    /// The signals over time.
    pub record: Record,
    /// What happened on the line.
    pub report: RunReport,
}

/// How a run is driven.
pub struct Drive<'a> {
    /// Folder in which FMUs are built.
    pub fmu_folder: &'a Path,
    /// Speed.
    pub pacing: Pacing,
    /// Ends the run early.
    pub stop: &'a StopFlag,
    /// Told how much of the run is done, in simulated time.
    pub progress: &'a mut dyn FnMut(SimTime),
}

impl std::fmt::Debug for Drive<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Drive").field("pacing", &self.pacing).finish_non_exhaustive()
    }
}

/// Runs `scenario` through gyro, frames, pseudo-terminal, decoder and estimators.
///
/// A motion that ends early ends the run with what came until then, as a stop from outside does;
/// [`RunReport::stopped`] tells.
///
/// # Errors
/// Whatever stops the chain, with the place it happened in; the end of a motion from which nothing
/// came.
pub fn run(scenario: &Scenario, drive: Drive<'_>) -> Result<Session> {
    let grid = sample_grid(scenario)?;
    let frames = grid.periods_until(scenario.duration);
    let emulator = emulator(scenario)?;
    let devices = devices(&scenario.estimators, drive.fmu_folder)?;
    let averager = Averager::new(grid, scenario.averaging_samples)?;
    let mut recorder = Recorder::new(scenario, drive.progress);
    let mut pipeline = Pipeline::new(scenario.frame.clone(), averager, devices)?;
    let report = struna_harness::run(
        emulator,
        frames,
        drive.pacing,
        &mut pipeline,
        &mut recorder,
        drive.stop,
    )?;
    match report.stopped {
        Some(reason) if recorder.record.rows() == 0 => Err(reason.into()),
        _ => Ok(Session { record: recorder.record, report }),
    }
}

/// Instants of a scenario's samples.
///
/// # Errors
/// When the gyro has no usable sample rate.
pub fn sample_grid(scenario: &Scenario) -> Result<SampleGrid> {
    Ok(SampleGrid::new(SimTime::ZERO, scenario.gyro.sample_rate_hz)?)
}

/// Everything left of a scenario's line.
///
/// # Errors
/// When gyro and frame do not go together, or the motion cannot start.
pub fn emulator(scenario: &Scenario) -> Result<Emulator> {
    let gyro = Gyro::new(scenario.gyro, scenario.seed, 0)?;
    let grid = sample_grid(scenario)?;
    let emulator = Emulator::new(motion_source(scenario)?, gyro, grid, &scenario.frame)?;
    let emulator = emulator.with_surroundings(scenario.surroundings);
    if scenario.faults.is_empty() {
        return Ok(emulator);
    }
    let injector = Injector::new(&scenario.faults, &scenario.frame, scenario.seed, 0);
    Ok(emulator.with_faults(injector))
}

/// The source of a scenario's motion.
///
/// # Errors
/// When the body refuses its start, its backend the rig, or the recording cannot be read.
pub fn motion_source(scenario: &Scenario) -> Result<Box<dyn MotionSource>> {
    Ok(match &scenario.source {
        Source::Model(model) => {
            let truth = model.motion(scenario.seed, 0)?;
            Box::new(BodySource { truth, mounting: scenario.mounting })
        }
        Source::Recording(plan) => {
            let (time, rate) = (&plan.time_column, &plan.rate_column);
            let recording = recording::read(&plan.file, time, rate, plan.rad_s_per_unit)?;
            Box::new(recording)
        }
    })
}

/// Gathers the record.
struct Recorder<'a> {
    record: Record,
    /// What moves the body; a recording, which knows no twist, has none.
    backend: Option<Backend>,
    /// The frame carries rates about three axes.
    has_cross: bool,
    row: Vec<f64>,
    progress: &'a mut dyn FnMut(SimTime),
}

impl<'a> Recorder<'a> {
    fn new(scenario: &Scenario, progress: &'a mut dyn FnMut(SimTime)) -> Self {
        let backend = match &scenario.source {
            Source::Model(model) => Some(model.backend),
            Source::Recording(_) => None,
        };
        let has_cross = cross_rate_fields(&scenario.frame).is_some();
        let mut names = measured_signals(has_cross);
        let truth = ["truth.input_rate_rad_s", TRUE_BODY_RATE, "truth.body_rate_integral_rad"];
        names.extend(truth.map(str::to_owned));
        if backend.is_some() {
            let truth = ["truth.twist_rad", TRUE_TWIST_RATE, "truth.by_rapier"];
            names.extend(truth.map(str::to_owned));
        }
        for plan in &scenario.estimators {
            for signal in ESTIMATOR_SIGNALS {
                names.push(format!("{}.{signal}", plan.name));
            }
        }
        let row = Vec::with_capacity(names.len());
        Self { record: Record::with_columns(names), backend, has_cross, row, progress }
    }
}

impl Observer for Recorder<'_> {
    fn observe(
        &mut self,
        sample: &RateSample,
        reference: Option<&Reference>,
        estimates: &[AngleEstimate],
    ) {
        let of = |get: fn(&Reference) -> f64| reference.map_or(f64::NAN, get);
        self.row.clear();
        self.row.extend(measured_values(sample, self.has_cross));
        self.row.extend([of(|r| r.input_rate_rad_s), of(|r| r.rate_rad_s), of(|r| r.spin_rad)]);
        if let Some(backend) = self.backend {
            let twist = reference.and_then(|r| r.twist_rad.zip(r.twist_rate_rad_s));
            let (twist_rad, twist_rate_rad_s) = twist.unwrap_or((f64::NAN, f64::NAN));
            let by_rapier = u8::from(matches!(backend, Backend::Rapier { .. }));
            self.row.extend([twist_rad, twist_rate_rad_s, f64::from(by_rapier)]);
        }
        self.row.extend(estimates.iter().flat_map(estimator_values));
        self.record.push(&self.row);
        (self.progress)(sample.time);
    }
}
