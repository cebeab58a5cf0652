//! `[body.string]`: a string of finite length.

use struna_settings::{Result, Table};

pub(super) fn length_m(string: &Table<'_>) -> Result<f64> {
    string.only(&["length_m"])?;
    string.required("length_m")?.positive()
}
