//! The one table of parameters: key, unit, place, bounds.

use crate::GyroParams;
use crate::datasheet::{S_PER_H, SQRT_S_PER_SQRT_H};
use crate::input::STANDARD_GRAVITY_M_S2;
use struna_kernel::RAD_PER_DEG;
use struna_settings::{Result, Value};

/// A parameter that is a number.
pub(crate) struct NumberKey {
    /// Name in files, unit included.
    pub(crate) name: &'static str,
    /// Its unit, as printed.
    pub(crate) unit: &'static str,
    /// One unit in SI.
    pub(crate) si: f64,
    /// What is refused at its own line; the rest is judged with all parameters together.
    pub(crate) allowed: Allowed,
    /// Where it goes.
    pub(crate) place: fn(&mut GyroParams) -> &mut f64,
}

#[derive(Clone, Copy)]
pub(crate) enum Allowed {
    Any,
    NotNegative,
    Positive,
    Within(f64, f64),
}

impl Allowed {
    pub(crate) fn read(self, value: &Value<'_>) -> Result<f64> {
        match self {
            Self::Any => value.number(),
            Self::NotNegative => value.not_negative(),
            Self::Positive => value.positive(),
            Self::Within(least, most) => value.number_in(least..=most),
        }
    }
}

const DEG_H: f64 = RAD_PER_DEG / S_PER_H;
const PER_G: f64 = RAD_PER_DEG / STANDARD_GRAVITY_M_S2;
const PERCENT: f64 = 1e-2;
const PPM: f64 = 1e-6;
const S_PER_MIN: f64 = 60.0;
const T_PER_GAUSS: f64 = 1e-4;

const fn number(
    name: &'static str,
    unit: &'static str,
    si: f64,
    allowed: Allowed,
    place: fn(&mut GyroParams) -> &mut f64,
) -> NumberKey {
    NumberKey { name, unit, si, allowed, place }
}

use Allowed::{Any, NotNegative, Positive, Within};

/// Every number, in the order in which `struna gyro show` prints them.
pub(crate) const NUMBERS: [NumberKey; 33] = [
    number("sample_rate_hz", "Hz", 1.0, Within(1.0, 1e5), |p| &mut p.sample_rate_hz),
    number("rate_max_deg_s", "deg/s", RAD_PER_DEG, Positive, |p| &mut p.rate_max_rad_s),
    number("lsb_deg_s", "deg/s", RAD_PER_DEG, Positive, |p| &mut p.lsb_rad_s),
    number("bandwidth_hz", "Hz", 1.0, NotNegative, |p| &mut p.response.natural_frequency_hz),
    number("damping_ratio", "-", 1.0, Positive, |p| &mut p.response.damping_ratio),
    number("delay_ms", "ms", 1e-3, NotNegative, |p| &mut p.response.delay_s),
    number("scale_error_percent", "%", PERCENT, Any, |p| &mut p.scale.error),
    number("turn_on_scale_sigma_percent", "%", PERCENT, NotNegative, |p| {
        &mut p.scale.turn_on_sigma
    }),
    number("scale_asymmetry_percent", "%", PERCENT, Any, |p| &mut p.scale.asymmetry),
    number("scale_percent_deg_c", "%/degC", PERCENT, Any, |p| &mut p.scale.per_deg_c),
    number("nonlinearity_percent_fs", "% of range", PERCENT, Any, |p| {
        &mut p.linearity.nonlinearity
    }),
    number("angle_random_walk_deg_sqrt_h", "deg/sqrt(h)", DEG_SQRT_H, NotNegative, |p| {
        &mut p.angle_random_walk_rad_sqrt_s
    }),
    number("bias_instability_deg_h", "deg/h", DEG_H, NotNegative, |p| {
        &mut p.drift.bias_instability_rad_s
    }),
    number("bias_correlation_s", "s", 1.0, NotNegative, |p| &mut p.drift.correlation_time_s),
    number(
        "rate_random_walk_deg_h_sqrt_h",
        "deg/h/sqrt(h)",
        DEG_H / SQRT_S_PER_SQRT_H,
        NotNegative,
        |p| &mut p.drift.rate_random_walk_rad_s_sqrt_s,
    ),
    number("rate_ramp_deg_h_h", "deg/h/h", DEG_H / S_PER_H, Any, |p| &mut p.drift.rate_ramp_rad_s2),
    number("bias_deg_h", "deg/h", DEG_H, Any, |p| &mut p.bias_rad_s),
    number("turn_on_bias_sigma_deg_h", "deg/h", DEG_H, NotNegative, |p| {
        &mut p.turn_on_bias_sigma_rad_s
    }),
    number("bias_deg_h_deg_c", "deg/h/degC", DEG_H, Any, |p| &mut p.bias_effects.per_deg_c_rad_s),
    number("bias_deg_h_deg_c_min", "deg/h per degC/min", DEG_H * S_PER_MIN, Any, |p| {
        &mut p.bias_effects.per_temperature_rate_rad_deg_c
    }),
    number("g_sensitivity_x_deg_s_g", "deg/s/g", PER_G, Any, |p| {
        &mut p.bias_effects.per_specific_force_s_m[0]
    }),
    number("g_sensitivity_y_deg_s_g", "deg/s/g", PER_G, Any, |p| {
        &mut p.bias_effects.per_specific_force_s_m[1]
    }),
    number("g_sensitivity_z_deg_s_g", "deg/s/g", PER_G, Any, |p| {
        &mut p.bias_effects.per_specific_force_s_m[2]
    }),
    number("magnetic_deg_h_gauss", "deg/h/G", DEG_H / T_PER_GAUSS, Any, |p| {
        &mut p.bias_effects.per_magnetic_field_rad_s_t
    }),
    number("warm_up_deg_h", "deg/h", DEG_H, Any, |p| &mut p.bias_effects.warm_up_rad_s),
    number("warm_up_time_s", "s", 1.0, NotNegative, |p| &mut p.bias_effects.warm_up_time_s),
    number("on_before_s", "s", 1.0, NotNegative, |p| &mut p.bias_effects.on_before_s),
    number("reference_temperature_deg_c", "degC", 1.0, Any, |p| &mut p.reference_temperature_deg_c),
    number("clock_offset_ppm", "ppm", PPM, Within(-1e5, 1e5), |p| &mut p.clock.offset),
    number("clock_offset_sigma_ppm", "ppm", PPM, Within(0.0, 1e4), |p| &mut p.clock.turn_on_sigma),
    number("clock_drift_ppm_h", "ppm/h", PPM / S_PER_H, Within(-36.0, 36.0), |p| {
        &mut p.clock.drift_per_s
    }),
    number("clock_jitter_us", "us", 1e-6, NotNegative, |p| &mut p.clock.jitter_s),
    // A data sheet's density: an alternative to the angle random walk, see `density`.
    number(DENSITY, "deg/s/sqrt(Hz)", RAD_PER_DEG, NotNegative, |p| {
        &mut p.angle_random_walk_rad_sqrt_s
    }),
];

const DEG_SQRT_H: f64 = RAD_PER_DEG / SQRT_S_PER_SQRT_H;

/// The angle random walk, and the two keys of a data sheet's density in its place.
pub(crate) const WALK: &str = "angle_random_walk_deg_sqrt_h";
pub(crate) const DENSITY: &str = "noise_density_deg_s_sqrt_hz";
pub(crate) const SIDED: &str = "noise_density_sided";

/// Parameters that are no plain number, in the order of printing, before the numbers.
pub(crate) const WORDS: [&str; 7] =
    ["kind", "sampling", "output", "fold_back", "noise_before_filter", "counts_bits", SIDED];

/// Without these there is no gyro.
pub(crate) const REQUIRED: [&str; 4] =
    ["sample_rate_hz", "rate_max_deg_s", "lsb_deg_s", "counts_bits"];
