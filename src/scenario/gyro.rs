//! `[gyro]`: a preset or a file, what differs from it, what surrounds it and how it sits.

use super::Source;
use super::numbers::{or, pair, section, triple};
use std::path::Path;
use struna_body::Mounting;
use struna_gyro::preset::{self, Preset};
use struna_gyro::{ROOM_TEMPERATURE_DEG_C, Surroundings};
use struna_kernel::RAD_PER_DEG;
use struna_settings::{Result, Table, Value};

/// What `[gyro]` describes.
pub(super) struct GyroPlan {
    pub(super) preset: Preset,
    pub(super) mounting: Mounting,
    pub(super) surroundings: Surroundings,
}

const KEYS: [&str; 4] = ["preset", "file", "mounting", "surroundings"];

/// Largest misalignment, deg: beyond half a right angle it is another input axis.
const MISALIGNMENT_DEG_MAX: f64 = 45.0;
const S_PER_MIN: f64 = 60.0;
const T_PER_GAUSS: f64 = 1e-4;

pub(super) fn gyro(root: &Table<'_>, source: &Source, folder: &Path) -> Result<GyroPlan> {
    let gyro = root.required("gyro")?.table()?;
    let known: Vec<_> = KEYS.into_iter().chain(preset::parameter_keys()).collect();
    gyro.only(&known)?;
    if let (Source::Recording(_), Some(mounting)) = (source, gyro.optional("mounting")) {
        let reason = "a recording is the rate about the input axis already; remove [gyro.mounting]";
        return Err(mounting.because(reason));
    }
    Ok(GyroPlan {
        preset: of_keys(&gyro, folder)?,
        mounting: section(&gyro, "mounting", mounting)?.unwrap_or_default(),
        surroundings: section(&gyro, "surroundings", surroundings)?.unwrap_or_default(),
    })
}

/// The gyro of a preset, of a file, or of the keys alone.
fn of_keys(gyro: &Table<'_>, folder: &Path) -> Result<Preset> {
    match (gyro.optional("preset"), gyro.optional("file")) {
        (Some(_), Some(file)) => {
            Err(file.because("`preset` says which gyro it is already; remove one of the two"))
        }
        (Some(name), None) => {
            let name = name.word(&preset::NAMES.map(|name| (name, name)))?;
            preset::named(name).expect("the name is one of the shipped").with(gyro)
        }
        (None, Some(file)) => of_file(&file, folder)?.with(gyro),
        (None, None) => preset::blank(gyro),
    }
}

fn of_file(value: &Value<'_>, folder: &Path) -> Result<Preset> {
    let path = folder.join(value.text()?);
    let text = std::fs::read_to_string(&path).map_err(|error| {
        value.because(format!("cannot read {}: {error}; check the path", path.display()))
    })?;
    preset::read(&text).map_err(|error| Box::new(error.in_file(&path)))
}

fn mounting(mounting: &Table<'_>) -> Result<Mounting> {
    mounting.only(&["misalignment_deg", "position_m"])?;
    let angle = |value: &Value<'_>| value.number_in(-MISALIGNMENT_DEG_MAX..=MISALIGNMENT_DEG_MAX);
    let turned = |value: &Value<'_>| pair(value, angle);
    let place = |value: &Value<'_>| triple(value, Value::number);
    let misalignment_deg = or(mounting, "misalignment_deg", turned, [0.0; 2])?;
    let position_m = or(mounting, "position_m", place, [0.0; 3])?;
    Mounting::new(misalignment_deg.map(|angle_deg| angle_deg * RAD_PER_DEG), position_m)
        .map_err(|error| mounting.because(error.to_string()))
}

fn surroundings(table: &Table<'_>) -> Result<Surroundings> {
    table.only(&["temperature_deg_c", "temperature_deg_c_min", "magnetic_field_gauss"])?;
    let number = |key, default| or(table, key, Value::number, default);
    Ok(Surroundings {
        temperature_deg_c: number("temperature_deg_c", ROOM_TEMPERATURE_DEG_C)?,
        temperature_rate_deg_c_s: number("temperature_deg_c_min", 0.0)? / S_PER_MIN,
        magnetic_field_t: number("magnetic_field_gauss", 0.0)? * T_PER_GAUSS,
    })
}
