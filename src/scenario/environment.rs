//! `[environment]`: the place on Earth.

use super::numbers::section;
use struna_kernel::RAD_PER_DEG;
use struna_settings::{Result, Table};

/// Latitude of the laboratory, rad; none where the Earth stands still.
pub(super) fn latitude_rad(root: &Table<'_>) -> Result<Option<f64>> {
    section(root, "environment", |environment| {
        environment.only(&["latitude_deg"])?;
        Ok(environment.required("latitude_deg")?.number_in(-90.0..=90.0)? * RAD_PER_DEG)
    })
}
