//! `[body.start]`: how the body is released, and how far a release may be off.

use super::super::numbers::{or, pair, triple};
use struna_body::{StartErrors, StartState};
use struna_kernel::RAD_PER_DEG;
use struna_settings::{Result, Table, Value};

const KEYS: [&str; 9] = [
    "twist_deg",
    "tilt_deg",
    "tilt_azimuth_deg",
    "body_rate_deg_s",
    "com_velocity_m_s",
    "suspension_m",
    "twist_sigma_deg",
    "tilt_sigma_deg",
    "rate_sigma_deg_s",
];

pub(super) fn start(body: &Table<'_>) -> Result<(StartState, StartErrors)> {
    let Some(start) = body.optional("start") else {
        return Ok((StartState::AT_REST, StartErrors::NONE));
    };
    let start = start.table()?;
    start.only(&KEYS)?;
    Ok((intended(&start)?, errors(&start)?))
}

fn intended(start: &Table<'_>) -> Result<StartState> {
    let angle_rad =
        |key: &str| -> Result<f64> { Ok(or(start, key, Value::number, 0.0)? * RAD_PER_DEG) };
    let across = |key: &str| or(start, key, |value| pair(value, Value::number), [0.0; 2]);
    let rate_deg_s = or(start, "body_rate_deg_s", |value| triple(value, Value::number), [0.0; 3])?;
    Ok(StartState {
        tilt_rad: angle_rad("tilt_deg")?,
        tilt_azimuth_rad: angle_rad("tilt_azimuth_deg")?,
        twist_rad: angle_rad("twist_deg")?,
        omega_wb_b_rad_s: rate_deg_s.map(|rate| rate * RAD_PER_DEG),
        suspension_w_m: across("suspension_m")?,
        com_velocity_w_m_s: across("com_velocity_m_s")?,
    })
}

fn errors(start: &Table<'_>) -> Result<StartErrors> {
    let sigma =
        |key: &str| -> Result<f64> { Ok(or(start, key, Value::not_negative, 0.0)? * RAD_PER_DEG) };
    Ok(StartErrors {
        twist_sigma_rad: sigma("twist_sigma_deg")?,
        tilt_sigma_rad: sigma("tilt_sigma_deg")?,
        rate_sigma_rad_s: sigma("rate_sigma_deg_s")?,
    })
}
