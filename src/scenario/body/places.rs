//! Where a scenario writes what a rig refuses.

use struna_body::BodyError;
use struna_settings::{Result, SettingsError, Table};

/// Keys below `[body]` for the parameters that a rig, start or integrator may refuse by name after
/// each value alone has passed. Where several keys make one parameter, the first that is there
/// counts.
const PLACES: [(&str, &[&[&str]]); 17] = [
    ("inertia_a_kg_m2", &[&["inertia_kg_m2"]]),
    ("inertia_b_kg_m2", &[&["inertia_kg_m2"]]),
    ("inertia_c_kg_m2", &[&["inertia_kg_m2"]]),
    ("inertia_kg_m2", &[&["inertia_kg_m2"]]),
    ("principal_inertia_kg_m2", &[&["products_of_inertia_kg_m2"]]),
    ("stiffness_n_m_rad", &[&["torsion", "stiffness_n_m_rad"], &["torsion", "period_s"]]),
    ("damping_n_m_s_rad", &[&["torsion", "damping_n_m_s_rad"], &["torsion", "damping_ratio"]]),
    ("damping_ratio", &[&["torsion", "damping_ratio"]]),
    ("string_length_m", &[&["string", "length_m"]]),
    ("impulse_rate_hz", &[&["disturbance", "random_impulses", "rate_hz"]]),
    ("|tilt_rad|", &[&["start", "tilt_deg"]]),
    ("|twist_rad|", &[&["start", "twist_deg"]]),
    ("|suspension_w_m|/string_length_m", &[&["start", "suspension_m"]]),
    ("step_s", &[&["integrator", "step_s"]]),
    ("rtol", &[&["integrator", "relative_tolerance"]]),
    ("atol", &[&["integrator", "absolute_tolerance"]]),
    (GRID, &[&["disturbance", "grid_hz"]]),
];
/// The one refusal without a parameter's name.
const GRID: &str = "grid_hz";

/// The refusal of what `error` is about, at its key if it has one here, else at `[body]`.
pub(super) fn refusal(body: &Table<'_>, error: &BodyError) -> Box<SettingsError> {
    let name = match error {
        BodyError::Parameter(parameter) => parameter.name,
        BodyError::Grid(_) => GRID,
        // A string of finite length is all that a backend cannot do.
        BodyError::Unsupported { .. } => "string_length_m",
        _ => "",
    };
    let known = PLACES.iter().filter(|(parameter, _)| *parameter == name);
    let mut paths = known.flat_map(|(_, paths)| paths.iter());
    let at_key = paths.find_map(|path| refused_at(body, path, &error.to_string()));
    at_key.unwrap_or_else(|| body.because(error.to_string()))
}

/// A refusal at the key that `path` leads to.
fn refused_at(table: &Table<'_>, path: &[&str], reason: &str) -> Option<Box<SettingsError>> {
    let (key, rest) = path.split_first()?;
    let value = table.optional(key)?;
    if rest.is_empty() {
        return Some(value.because(reason));
    }
    let below: Result<Table<'_>> = value.table();
    refused_at(&below.ok()?, rest, reason)
}
