//! `[gyro]`: a preset, what differs from it, how it samples and how it sits on the body.

use super::Source;
use super::numbers::{or, pair, section, triple};
use struna_body::Mounting;
use struna_gyro::{GyroParams, datasheet};
use struna_harness::Sampling;
use struna_kernel::RAD_PER_DEG;
use struna_settings::{Result, Table, Value};

/// What `[gyro]` describes.
pub(super) struct GyroPlan {
    pub(super) params: GyroParams,
    pub(super) mounting: Mounting,
    pub(super) sampling: Sampling,
}

const KEYS: [&str; 9] = [
    "preset",
    "sample_rate_hz",
    "angle_random_walk_deg_sqrt_h",
    "bias_deg_h",
    "turn_on_bias_sigma_deg_h",
    "rate_max_deg_s",
    "lsb_deg_s",
    "sampling",
    "mounting",
];

/// Largest misalignment, deg: beyond half a right angle it is another input axis.
const MISALIGNMENT_DEG_MAX: f64 = 45.0;

pub(super) fn gyro(root: &Table<'_>, source: &Source) -> Result<GyroPlan> {
    let gyro = root.required("gyro")?.table()?;
    gyro.only(&KEYS)?;
    if let (Source::Recording(_), Some(mounting)) = (source, gyro.optional("mounting")) {
        let reason = "a recording is the rate about the input axis already; remove [gyro.mounting]";
        return Err(mounting.because(reason));
    }
    let words = [("mean", Sampling::Mean), ("instantaneous", Sampling::Instantaneous)];
    Ok(GyroPlan {
        params: params(&gyro)?,
        mounting: section(&gyro, "mounting", mounting)?.unwrap_or_default(),
        sampling: or(&gyro, "sampling", |value| value.word(&words), Sampling::Mean)?,
    })
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

fn params(gyro: &Table<'_>) -> Result<GyroParams> {
    let mut params = gyro.required("preset")?.word(&[("vg910d", datasheet::vg910d())])?;
    if let Some(rate) = gyro.optional("sample_rate_hz") {
        params.sample_rate_hz = rate.number_in(1.0..=100_000.0)?;
    }
    if let Some(walk) = gyro.optional("angle_random_walk_deg_sqrt_h") {
        let walk_deg_sqrt_h = walk.not_negative()?;
        params.angle_random_walk_rad_sqrt_s =
            datasheet::rad_sqrt_s_from_deg_sqrt_h(walk_deg_sqrt_h);
    }
    if let Some(bias) = gyro.optional("bias_deg_h") {
        params.bias_rad_s = datasheet::rad_s_from_deg_h(bias.number()?);
    }
    if let Some(sigma) = gyro.optional("turn_on_bias_sigma_deg_h") {
        params.turn_on_bias_sigma_rad_s = datasheet::rad_s_from_deg_h(sigma.not_negative()?);
    }
    if let Some(range) = gyro.optional("rate_max_deg_s") {
        params.rate_max_rad_s = datasheet::rad_s_from_deg_s(range.positive()?);
    }
    if let Some(lsb) = gyro.optional("lsb_deg_s") {
        params.lsb_rad_s = datasheet::rad_s_from_deg_s(lsb.positive()?);
    }
    params.validate().map_err(|error| gyro.because(error.to_string()))?;
    Ok(params)
}
