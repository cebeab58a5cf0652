//! `[gyro]`: a preset, and what differs from it.

use struna_gyro::{GyroParams, datasheet};
use struna_settings::{Result, Table};

pub(super) fn gyro(root: &Table<'_>) -> Result<GyroParams> {
    let gyro = root.required("gyro")?.table()?;
    gyro.only(&[
        "preset",
        "sample_rate_hz",
        "angle_random_walk_deg_sqrt_h",
        "bias_deg_h",
        "turn_on_bias_sigma_deg_h",
        "rate_max_deg_s",
        "lsb_deg_s",
    ])?;
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
