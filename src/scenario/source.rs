//! `[source]`: the body model, or a recording.

use super::{ModelSource, body};
use std::path::{Path, PathBuf};
use struna_harness::cross_rate_fields;
use struna_kernel::RAD_PER_DEG;
use struna_settings::{Result, Table};
use struna_wire::FrameSpec;

/// Where the motion comes from.
#[derive(Debug, Clone)]
pub enum Source {
    /// The body model.
    Model(Box<ModelSource>),
    /// A recorded rate.
    Recording(RecordingSource),
}

/// A recorded rate in a CSV file.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingSource {
    /// The file.
    pub file: PathBuf,
    /// Column of the time, s.
    pub time_column: String,
    /// Column of the rate.
    pub rate_column: String,
    /// What one unit of the rate column is in rad/s.
    pub rad_s_per_unit: f64,
}

pub(super) fn source(root: &Table<'_>, folder: &Path) -> Result<Source> {
    let model = || Ok(Source::Model(Box::new(body::model(root)?)));
    let Some(source) = root.optional("source") else { return model() };
    let source = source.table()?;
    match source.required("kind")?.word(&[("model", true), ("recording", false)])? {
        true => {
            source.only(&["kind"])?;
            model()
        }
        false => recording(root, &source, folder),
    }
}

fn recording(root: &Table<'_>, source: &Table<'_>, folder: &Path) -> Result<Source> {
    source.only(&["kind", "file", "time_column", "rate_column", "unit"])?;
    if let Some(body) = root.optional("body") {
        return Err(body.because("a recording moves no body; remove [body] or the recording"));
    }
    if let Some(environment) = root.optional("environment") {
        let reason = "a recording holds the Earth's rate already; remove [environment]";
        return Err(environment.because(reason));
    }
    let text = |key: &str| source.required(key)?.text().map(str::to_owned);
    let units = [("deg/s", RAD_PER_DEG), ("rad/s", 1.0), ("mdeg/s", RAD_PER_DEG / 1e3)];
    Ok(Source::Recording(RecordingSource {
        file: folder.join(text("file")?),
        time_column: text("time_column")?,
        rate_column: text("rate_column")?,
        rad_s_per_unit: source.required("unit")?.word(&units)?,
    }))
}

/// Refuses a frame of three rates beside a recording, which has one.
pub(super) fn check_axes(root: &Table<'_>, source: &Source, frame: &FrameSpec) -> Result<()> {
    let is_recording = matches!(source, Source::Recording(_));
    if !is_recording || cross_rate_fields(frame).is_none() {
        return Ok(());
    }
    // The default layout carries one rate: this one was asked for.
    let asked = root.required("line")?.table()?.required("frame")?;
    Err(asked.because(
        "a recording holds one rate and this frame carries three; set it to a frame with one, \
         such as \"struna/vg910d@1\", or move a body with kind = \"model\" in [source]",
    ))
}
