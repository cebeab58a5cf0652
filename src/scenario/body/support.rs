//! `[body.support]`: how the upper end of the string moves.

use super::super::numbers::{or, triple};
use struna_body::{ClampSwing, Support, VIBRATIONS_MAX, Vibration};
use struna_kernel::RAD_PER_DEG;
use struna_settings::{Result, Table, Value};

pub(super) fn support(support: &Table<'_>) -> Result<Support> {
    support.only(&["vibration", "clamp_deg", "clamp_rate_deg_s", "clamp_swing"])?;
    let turn_rad =
        |key: &str| -> Result<f64> { Ok(or(support, key, Value::number, 0.0)? * RAD_PER_DEG) };
    let vibrations = support.tables("vibration", VIBRATIONS_MAX)?;
    let swings = support.tables("clamp_swing", VIBRATIONS_MAX)?;
    Ok(Support {
        vibrations: vibrations.iter().map(vibration).collect::<Result<_>>()?,
        clamp_rad: turn_rad("clamp_deg")?,
        clamp_rate_rad_s: turn_rad("clamp_rate_deg_s")?,
        clamp_swings: swings.iter().map(clamp_swing).collect::<Result<_>>()?,
    })
}

fn vibration(vibration: &Table<'_>) -> Result<Vibration> {
    vibration.only(&["amplitude_m", "frequency_hz", "phase_deg"])?;
    Ok(Vibration {
        amplitude_w_m: triple(&vibration.required("amplitude_m")?, Value::number)?,
        frequency_hz: vibration.required("frequency_hz")?.positive()?,
        phase_rad: or(vibration, "phase_deg", Value::number, 0.0)? * RAD_PER_DEG,
    })
}

fn clamp_swing(swing: &Table<'_>) -> Result<ClampSwing> {
    swing.only(&["amplitude_deg", "frequency_hz", "phase_deg"])?;
    Ok(ClampSwing {
        amplitude_rad: swing.required("amplitude_deg")?.number()? * RAD_PER_DEG,
        frequency_hz: swing.required("frequency_hz")?.positive()?,
        phase_rad: or(swing, "phase_deg", Value::number, 0.0)? * RAD_PER_DEG,
    })
}
