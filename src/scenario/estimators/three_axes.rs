//! What the filter of three rates is told: the body, how its gyros sit, and how far it may swing.

use super::augmented::{self, Numbers, RAD2_PER_DEG2};
use super::live;
use struna_estimator::{InputAxis, SwingConfig, ThreeAxisFilter};
use struna_kernel::RAD_PER_DEG;
use struna_settings::{Result, Table};

/// Swing that is allowed for without a word about it, rad. Too large a value costs a few seconds,
/// too small a one may cost the track.
const SWING_SIGMA_RAD: f64 = 10.0 * RAD_PER_DEG;

/// What the filter of three rates is told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThreeAxisPlan {
    /// Body, start and noise. Its axis is how the case of the gyros sits on the body, taken as
    /// known: the x axis of the case stays in the plane of the body's x and z.
    pub config: SwingConfig,
    /// By how much the body may swing at the start, rad.
    pub swing_sigma_rad: f64,
}

pub(super) fn plan(table: &Table<'_>) -> Result<ThreeAxisPlan> {
    let numbers = Numbers(table);
    let sigma_rad_s = table.required("measurement_sigma_deg_s")?.positive()? * RAD_PER_DEG;
    let tilt_b_rad = match table.optional("input_axis_deg") {
        Some(leaning) => live::tilt_b_rad(leaning.pair()?.each_ref())?,
        None => [0.0; 2],
    };
    let axis = InputAxis { tilt_b_rad, tilt_sigma_rad: 0.0 };
    let start = augmented::start(table)?;
    let quiet = live::with_body(table, axis, start, sigma_rad_s * sigma_rad_s)?;
    let (q, walk) = (quiet.rate_walk_rad2_s3, quiet.bias_walk_rad2_s3);
    let config = SwingConfig {
        rate_walk_rad2_s3: numbers.not_negative("process_noise_deg2_s3", RAD2_PER_DEG2, q)?,
        bias_walk_rad2_s3: numbers.not_negative("bias_walk_deg2_s3", RAD2_PER_DEG2, walk)?,
        scale_factor_sigma: numbers.not_negative("scale_factor_sigma_percent", 0.01, 0.0)?,
        ..quiet
    };
    let swing_sigma_rad = match table.optional("swing_sigma_start_deg") {
        Some(value) => value.positive()? * RAD_PER_DEG,
        None => SWING_SIGMA_RAD,
    };
    ThreeAxisFilter::new(&config, swing_sigma_rad)
        .map_err(|error| table.because(error.to_string()))?;
    Ok(ThreeAxisPlan { config, swing_sigma_rad })
}
