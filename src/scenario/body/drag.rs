//! `[body.drag]`: the air.

use super::super::numbers::or;
use struna_body::Drag;
use struna_settings::{Result, Table, Value};

pub(super) fn drag(drag: &Table<'_>) -> Result<Drag> {
    drag.only(&[
        "rotation_n_m_s_rad",
        "rotation_quadratic_n_m_s2_rad2",
        "translation_n_s_m",
        "translation_quadratic_n_s2_m2",
    ])?;
    let coefficient = |key: &str| or(drag, key, Value::not_negative, 0.0);
    Ok(Drag {
        rotation_n_m_s_rad: coefficient("rotation_n_m_s_rad")?,
        rotation_quadratic_n_m_s2_rad2: coefficient("rotation_quadratic_n_m_s2_rad2")?,
        translation_n_s_m: coefficient("translation_n_s_m")?,
        translation_quadratic_n_s2_m2: coefficient("translation_quadratic_n_s2_m2")?,
    })
}
