//! One run of a scenario: builds the chain, drives it, gathers the record.

use crate::fmu::{self, FmiVersion};
use crate::in_process::InProcess;
use crate::record::Record;
use crate::recording;
use crate::scenario::{EstimatorKind, EstimatorPlan, RunAs, Scenario, Source};
use anyhow::{Context, Result};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use struna_body::Backend;
use struna_estimator::{Filter, PlainIntegration, RateEstimator};
use struna_gyro::Gyro;
use struna_harness::fault::Injector;
use struna_harness::{
    Averager, BodySource, DeviceUnderTest, Emulator, FmuDevice, MotionSource, Observer, Pacing,
    Parameter, ParameterValue, Pipeline, Reference, RunReport,
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

/// The estimators of a scenario, ready to step; FMUs are built in `fmu_folder`.
///
/// # Errors
/// When an FMU cannot be built, loaded or started, or a parameter is refused.
pub fn devices(
    plans: &[EstimatorPlan],
    fmu_folder: &Path,
) -> Result<Vec<Box<dyn DeviceUnderTest>>> {
    // Given FMUs come first: a bad one is refused before any other is built and left behind.
    let is_given = |(_, plan): &(usize, &EstimatorPlan)| matches!(plan.run_as, RunAs::FmuFile(_));
    let (given, made): (Vec<_>, Vec<_>) = plans.iter().enumerate().partition(is_given);
    let mut devices = BTreeMap::new();
    for (place, plan) in given.into_iter().chain(made) {
        let context = || format!("estimator '{}'", plan.name);
        devices.insert(place, device(plan, fmu_folder).with_context(context)?);
    }
    Ok(devices.into_values().collect())
}

fn device(plan: &EstimatorPlan, fmu_folder: &Path) -> Result<Box<dyn DeviceUnderTest>> {
    let file = match &plan.run_as {
        RunAs::InProcess => return Ok(Box::new(InProcess::new(&plan.name, estimator(plan)?))),
        RunAs::Fmi2 => built(plan.kind, FmiVersion::Fmi2, fmu_folder)?,
        RunAs::Fmi3 => built(plan.kind, FmiVersion::Fmi3, fmu_folder)?,
        RunAs::FmuFile(file) => file.clone(),
    };
    let importer = struna_fmi_import::open(&file)?;
    Ok(Box::new(FmuDevice::new(importer.as_ref(), &plan.name, &parameters(plan))?))
}

fn estimator(plan: &EstimatorPlan) -> Result<Box<dyn RateEstimator>> {
    Ok(match plan.kind {
        EstimatorKind::PlainIntegration => Box::new(PlainIntegration::new(plan.config)?),
        EstimatorKind::PermanentRotation => Box::new(Filter::permanent_rotation(plan.config)?),
        EstimatorKind::TorsionalOscillation { period_s } => {
            Box::new(Filter::torsional_oscillation(plan.config, period_s)?)
        }
    })
}

/// Builds the FMU of an estimator.
fn built(kind: EstimatorKind, version: FmiVersion, folder: &Path) -> Result<PathBuf> {
    let model = match kind {
        EstimatorKind::PermanentRotation => "PermanentRotation",
        EstimatorKind::TorsionalOscillation { .. } => "TorsionalOscillation",
        EstimatorKind::PlainIntegration => anyhow::bail!("plain integration is no FMU"),
    };
    Ok(fmu::build(model, version, folder)?)
}

/// The FMU's parameters, which carry the names of the configuration's fields.
fn parameters(plan: &EstimatorPlan) -> Vec<Parameter> {
    let float = |name: &str, value| Parameter {
        name: name.to_owned(),
        value: ParameterValue::Float64(value),
    };
    let integer = |name: &str, value| Parameter {
        name: name.to_owned(),
        value: ParameterValue::Int32(value),
    };
    let c = &plan.config;
    let samples = i32::try_from(c.refinement.samples).unwrap_or(i32::MAX);
    let mut parameters = vec![
        float("angle_start_rad", c.angle_start_rad),
        float("rate_start_rad_s", c.rate_start_rad_s),
        float("angle_variance_start_rad2", c.angle_variance_start_rad2),
        float("rate_variance_start_rad2_s2", c.rate_variance_start_rad2_s2),
        float("measurement_variance_rad2_s2", c.measurement_variance_rad2_s2),
        float("process_noise_rad2_s3", c.process_noise_rad2_s3),
        integer("refinement_samples", samples),
        integer("refinement_reading", c.refinement.reading.number()),
    ];
    if let EstimatorKind::TorsionalOscillation { period_s } = plan.kind {
        parameters.push(float("period_s", period_s));
    }
    parameters
}

/// Gathers the record.
struct Recorder<'a> {
    record: Record,
    /// What moves the body; a recording, which knows no twist, has none.
    backend: Option<Backend>,
    row: Vec<f64>,
    progress: &'a mut dyn FnMut(SimTime),
}

impl<'a> Recorder<'a> {
    fn new(scenario: &Scenario, progress: &'a mut dyn FnMut(SimTime)) -> Self {
        let backend = match &scenario.source {
            Source::Model(model) => Some(model.backend),
            Source::Recording(_) => None,
        };
        let mut names: Vec<String> = ["time", "measured_rate_rad_s", "over_range", "lost_before"]
            .map(str::to_owned)
            .to_vec();
        let truth = ["input_rate_rad_s", "body_rate_rad_s", "body_rate_integral_rad"];
        names.extend(truth.map(|signal| format!("truth.{signal}")));
        if backend.is_some() {
            let truth = ["twist_rad", "twist_rate_rad_s", "by_rapier"];
            names.extend(truth.map(|signal| format!("truth.{signal}")));
        }
        for plan in &scenario.estimators {
            for signal in ["angle_rad", "rate_rad_s", "angle_sigma_rad", "rate_sigma_rad_s"] {
                names.push(format!("{}.{signal}", plan.name));
            }
        }
        let row = Vec::with_capacity(names.len());
        Self { record: Record::with_columns(names), backend, row, progress }
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
        self.row.extend([
            sample.time.as_s(),
            sample.rate_rad_s,
            f64::from(u8::from(sample.over_range)),
            sample.lost_before as f64,
            of(|r| r.input_rate_rad_s),
            of(|r| r.rate_rad_s),
            of(|r| r.spin_rad),
        ]);
        if let Some(backend) = self.backend {
            let twist = reference.and_then(|r| r.twist_rad.zip(r.twist_rate_rad_s));
            let (twist_rad, twist_rate_rad_s) = twist.unwrap_or((f64::NAN, f64::NAN));
            let by_rapier = u8::from(matches!(backend, Backend::Rapier { .. }));
            self.row.extend([twist_rad, twist_rate_rad_s, f64::from(by_rapier)]);
        }
        for e in estimates {
            let signals = [e.angle_rad, e.rate_rad_s, e.angle_sigma_rad, e.rate_sigma_rad_s];
            self.row.extend(signals);
        }
        self.record.push(&self.row);
        (self.progress)(sample.time);
    }
}
