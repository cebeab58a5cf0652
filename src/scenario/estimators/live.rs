//! What the estimator for a live rig is told: gyro, body and limits, besides all that the tested
//! filter of torsion takes.
//!
//! The body is the operator's own declaration, never the scenario's truth: an estimator that is
//! told the truth proves nothing.

use super::Sampling;
use super::augmented::{self, Numbers};
use struna_estimator::{
    AugmentedConfig, InputAxis, LiveConfig, StartPrior, SwingBody, SwingConfig,
};
use struna_kernel::RAD_PER_DEG;
use struna_settings::{Result, Table, Value};

/// A body is declared as a whole, or not at all.
const DECLARATION: [&str; 9] = [
    "body_mass_kg",
    "body_com_depth_m",
    "body_inertia_kg_m2",
    "body_inertia_sigma_percent",
    "body_swing_damping_1_s",
    "body_swing_damping_sigma_percent",
    "gravity_m_s2",
    "input_axis_deg",
    "input_axis_sigma_deg",
];
const GRAVITY_M_S2: f64 = 9.81;

pub(super) fn config(table: &Table<'_>, sampling: Sampling) -> Result<LiveConfig> {
    let torsion = augmented::config(table, sampling)?;
    let usual = LiveConfig::new(torsion, sampling.output_period_s);
    let work_per_sample = match table.optional("fit_work_per_sample") {
        Some(value) => value.integer_in(1..=i32::MAX)?.cast_unsigned(),
        None => usual.work_per_sample,
    };
    let swing_max_rad = match table.optional("swing_max_deg") {
        Some(value) => value.number_in(0.0..=85.0)? * RAD_PER_DEG,
        None => usual.swing_max_rad,
    };
    let is_declared = DECLARATION.iter().any(|key| table.optional(key).is_some());
    let swing = is_declared.then(|| swing(table, &torsion)).transpose()?;
    let config = LiveConfig {
        test: augmented::test(table)?,
        swing,
        swing_max_rad,
        work_per_sample,
        ..usual
    };
    config.validate().map_err(|error| table.because(error.to_string()))?;
    Ok(config)
}

/// The body and the gyro on it, as declared.
fn swing(table: &Table<'_>, torsion: &AugmentedConfig) -> Result<SwingConfig> {
    let [towards_x, towards_y] = table.required("input_axis_deg")?.pair()?;
    let axis = InputAxis {
        tilt_b_rad: tilt_b_rad([&towards_x, &towards_y])?,
        tilt_sigma_rad: table.required("input_axis_sigma_deg")?.not_negative()? * RAD_PER_DEG,
    };
    let r = torsion.measurement_variance_rad2_s2;
    with_body(table, axis, torsion.start, r)
}

/// How far the input axis leans towards the body's x and y axes, as sines.
pub(super) fn tilt_b_rad(leaning_deg: [&Value<'_>; 2]) -> Result<[f64; 2]> {
    let [towards_x, towards_y] = leaning_deg;
    let sine = |value: &Value<'_>| -> Result<f64> { Ok((value.number()? * RAD_PER_DEG).sin()) };
    Ok([sine(towards_x)?, sine(towards_y)?])
}

/// The body as declared, in a quiet laboratory.
pub(super) fn with_body(
    table: &Table<'_>,
    axis: InputAxis,
    start: StartPrior,
    measurement_variance_rad2_s2: f64,
) -> Result<SwingConfig> {
    let numbers = Numbers(table);
    let moments = table.required("body_inertia_kg_m2")?;
    let expected = "three moments of inertia, about x, y and the axis of the twist";
    let [x, y, z]: [Value<'_>; 3] =
        moments.array()?.try_into().map_err(|_| moments.out_of_range(expected))?;
    let body = SwingBody {
        mass_kg: table.required("body_mass_kg")?.positive()?,
        com_depth_m: table.required("body_com_depth_m")?.positive()?,
        inertia_kg_m2: [x.positive()?, y.positive()?, z.positive()?],
        gravity_m_s2: match table.optional("gravity_m_s2") {
            Some(gravity) => gravity.positive()?,
            None => GRAVITY_M_S2,
        },
        swing_damping_1_s: table.required("body_swing_damping_1_s")?.not_negative()?,
    };
    let quiet = SwingConfig::quiet(body, axis, start, measurement_variance_rad2_s2);
    let (inertia, damping) = (quiet.inertia_sigma, quiet.swing_damping_sigma);
    Ok(SwingConfig {
        inertia_sigma: numbers.not_negative("body_inertia_sigma_percent", 0.01, inertia)?,
        swing_damping_sigma: numbers.not_negative(
            "body_swing_damping_sigma_percent",
            0.01,
            damping,
        )?,
        ..quiet
    })
}
