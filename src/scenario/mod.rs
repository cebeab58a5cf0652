//! Scenarios: what a run consists of, and the TOML files that say so.
//!
//! This is one of the few places that speak degrees: files do, everything inside is SI.

mod body;
mod environment;
mod estimators;
mod fault;
mod gyro;
mod line;
mod numbers;
mod source;

pub use body::ModelSource;
pub use estimators::{EstimatorKind, EstimatorPlan, RunAs, ThreeAxisPlan, one_rate};
pub use line::LinePlan;
pub use source::{RecordingSource, Source};

use crate::frames;
use std::path::{Path, PathBuf};
use struna_body::Mounting;
use struna_gyro::{GyroParams, Surroundings};
use struna_harness::fault::FaultPlan;
use struna_kernel::{Seed, SimTime};
use struna_settings::{Result, SettingsError, Table};
use struna_wire::FrameSpec;

/// A run that lasts longer than this is a typing error.
const DURATION_S_MAX: f64 = 1e7;
const ESTIMATORS_MAX: usize = 32;

/// Everything that decides a run.
#[derive(Debug, Clone)]
pub struct Scenario {
    /// Name, used for the result folder and the figure.
    pub name: String,
    /// Length of the run.
    pub duration: SimTime,
    /// Seed of all random streams.
    pub seed: Seed,
    /// Where the motion comes from.
    pub source: Source,
    /// The gyro on the body.
    pub gyro: GyroParams,
    /// How it sits there.
    pub mounting: Mounting,
    /// What surrounds it.
    pub surroundings: Surroundings,
    /// The layout of its frames.
    pub frame: FrameSpec,
    /// What another command has to call that layout: a shipped name or a file.
    pub frame_called: String,
    /// The line they go over.
    pub line: LinePlan,
    /// Gyro samples averaged into one rate sample.
    pub averaging_samples: u64,
    /// The estimators, in the order of the record.
    pub estimators: Vec<EstimatorPlan>,
    /// What goes wrong on purpose.
    pub faults: FaultPlan,
}

/// Why a scenario cannot be run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ScenarioError {
    /// The file cannot be read.
    #[error("cannot read the scenario {}: {source}; check the path", path.display())]
    Read {
        /** The file. */
        path: PathBuf,
        /** The system's reason. */
        source: std::io::Error,
    },
    /// A key or value in it, or in the frame file it names.
    #[error(transparent)]
    Settings(#[from] Box<SettingsError>),
    /// The frame file it names cannot be read.
    #[error("cannot read the frame file {}: {source}; check `frame` in [line]", path.display())]
    ReadFrame {
        /** The file. */
        path: PathBuf,
        /** The system's reason. */
        source: std::io::Error,
    },
}

impl Scenario {
    /// Reads a scenario file. Paths in it are relative to the file's folder.
    ///
    /// # Errors
    /// [`ScenarioError`] names file, line, key, value and remedy.
    pub fn read(path: &Path) -> std::result::Result<Self, ScenarioError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| ScenarioError::Read { path: path.to_owned(), source })?;
        Self::parse(&text, path)
    }

    /// Symbols per second that its frames take on the line, whatever baud rate that has.
    #[must_use]
    pub fn symbols_per_s(&self) -> f64 {
        line::symbols_per_s(&self.frame, self.gyro.sample_rate_hz)
    }

    /// Parses the text of a scenario file; `path` is for messages and for paths inside.
    ///
    /// # Errors
    /// [`ScenarioError`] names file, line, key, value and remedy.
    pub fn parse(text: &str, path: &Path) -> std::result::Result<Self, ScenarioError> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let (mut scenario, frame) = struna_settings::read(text, |root| from_root(root, folder))
            .map_err(|error| {
                // A gyro's file, read on the way, has named itself.
                Box::new(if error.file.is_some() { *error } else { error.in_file(path) })
            })?;
        if let Some(file) = frame {
            scenario.frame = read_frame(&file)?;
            scenario.frame_called = file.display().to_string();
        }
        // The rest of [line], and what is made of it, is judged by the frame that goes over it.
        let rate_hz = scenario.gyro.sample_rate_hz;
        let line = |root: &Table<'_>| {
            source::check_axes(root, &scenario.source, &scenario.frame)?;
            estimators::check_axes(root, &scenario.frame)?;
            line::line(root, &scenario.frame, rate_hz)
        };
        scenario.line =
            struna_settings::read(text, line).map_err(|error| Box::new(error.in_file(path)))?;
        Ok(scenario)
    }
}

fn read_frame(path: &Path) -> std::result::Result<FrameSpec, ScenarioError> {
    let text = std::fs::read_to_string(path)
        .map_err(|source| ScenarioError::ReadFrame { path: path.to_owned(), source })?;
    Ok(frames::unique(&text).map_err(|error| Box::new(error.in_file(path)))?)
}

/// The scenario, and the frame file still to be read if it names one.
fn from_root(root: &Table<'_>, folder: &Path) -> Result<(Scenario, Option<PathBuf>)> {
    root.only(&[
        "run",
        "source",
        "environment",
        "body",
        "gyro",
        "line",
        "averaging",
        "estimator",
        "fault",
    ])?;
    let run = root.required("run")?.table()?;
    run.only(&["name", "duration_s", "seed"])?;
    let name = run_name(&run)?;
    let duration = run.required("duration_s")?;
    let duration_s = duration.positive()?;
    if duration_s > DURATION_S_MAX {
        return Err(duration.out_of_range(format!("at most {DURATION_S_MAX:e}")));
    }
    let duration = SimTime::from_s(duration_s).map_err(|e| duration.because(e.to_string()))?;
    let seed = match run.optional("seed") {
        Some(seed) => seed.integer_in(0..=i64::MAX)?.cast_unsigned(),
        None => 0,
    };
    let (frame, frame_file) = frame(root, folder)?;
    let estimators = root.tables("estimator", ESTIMATORS_MAX)?;
    let source = source::source(root, folder)?;
    let gyro = gyro::gyro(root, &source, folder)?;
    let averaging_samples = averaging(root)?;
    let output_period_s = averaging_samples as f64 / gyro.preset.params.sample_rate_hz;
    let sampling = estimators::Sampling { averaging_samples, output_period_s };
    let scenario = Scenario {
        name,
        duration,
        seed: Seed(seed),
        source,
        gyro: gyro.preset.params,
        mounting: gyro.mounting,
        surroundings: gyro.surroundings,
        frame_called: frame.name().to_owned(),
        line: LinePlan::of_frame(&frame),
        frame,
        averaging_samples,
        estimators: estimators::estimators(&estimators, folder, sampling)?,
        faults: fault::plan(root)?,
    };
    Ok((scenario, frame_file))
}

/// A name that can be a folder's.
fn run_name(run: &Table<'_>) -> Result<String> {
    let value = run.required("name")?;
    let name = value.text()?;
    let plain = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.');
    if name.is_empty() || name.len() > 64 || name.starts_with('.') || !name.chars().all(plain) {
        return Err(value.out_of_range("up to 64 letters, digits, '-', '_' or '.'"));
    }
    Ok(name.to_owned())
}

fn frame(root: &Table<'_>, folder: &Path) -> Result<(FrameSpec, Option<PathBuf>)> {
    let shipped = |text| FrameSpec::from_toml(text).expect("shipped frames are tested");
    let default = shipped(frames::SHIPPED[0].1);
    let Some(line) = root.optional("line") else { return Ok((default, None)) };
    let line = line.table()?;
    line.only(&line::KEYS)?;
    let Some(frame) = line.optional("frame") else { return Ok((default, None)) };
    let name = frame.text()?;
    if let Some(text) = frames::shipped(name) {
        return Ok((shipped(text), None));
    }
    let is_file = Path::new(name).extension().is_some_and(|extension| extension == "toml");
    if !is_file {
        let known = frames::SHIPPED.map(|(name, _)| format!("\"{name}\""));
        return Err(frame.out_of_range(format!("a .toml file or one of: {}", known.join(", "))));
    }
    Ok((default, Some(folder.join(name))))
}

fn averaging(root: &Table<'_>) -> Result<u64> {
    let Some(averaging) = root.optional("averaging") else { return Ok(1) };
    let averaging = averaging.table()?;
    averaging.only(&["samples"])?;
    averaging.required("samples")?.integer_in(1..=1_000_000)
}
