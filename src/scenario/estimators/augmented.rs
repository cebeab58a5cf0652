//! What the estimators that learn are told: prior, noise, gyro and test.

use super::Sampling;
use struna_estimator::{AugmentedConfig, GyroRange, InnovationTest, Quantiser, StartPrior};
use struna_kernel::RAD_PER_DEG;
use struna_settings::{Result, Table};

pub(super) const RAD2_PER_DEG2: f64 = RAD_PER_DEG * RAD_PER_DEG;
const RAD_S_PER_DEG_H: f64 = RAD_PER_DEG / 3600.0;
/// Raw standard deviations next to the gyro's limit in which the noise is clipped.
const MARGIN_RAW_SIGMAS: f64 = 5.0;

/// Reads optional numbers: in units of `unit` if they are there, else the default in SI.
pub(super) struct Numbers<'t, 'a>(pub(super) &'t Table<'a>);

impl Numbers<'_, '_> {
    fn any(&self, key: &str, unit: f64, default: f64) -> Result<f64> {
        self.0.optional(key).map_or(Ok(default), |value| Ok(value.number()? * unit))
    }

    pub(super) fn not_negative(&self, key: &str, unit: f64, default: f64) -> Result<f64> {
        self.0.optional(key).map_or(Ok(default), |value| Ok(value.not_negative()? * unit))
    }
}

/// Prior, noise and gyro.
pub(super) fn config(table: &Table<'_>, sampling: Sampling) -> Result<AugmentedConfig> {
    let numbers = Numbers(table);
    let sigma_rad_s = table.required("measurement_sigma_deg_s")?.positive()? * RAD_PER_DEG;
    let quiet = AugmentedConfig::quiet(start(table)?, sigma_rad_s * sigma_rad_s);
    let (q, walk) = (quiet.process_noise_rad2_s3, quiet.bias_walk_rad2_s3);
    let config = AugmentedConfig {
        process_noise_rad2_s3: numbers.not_negative("process_noise_deg2_s3", RAD2_PER_DEG2, q)?,
        bias_walk_rad2_s3: numbers.not_negative("bias_walk_deg2_s3", RAD2_PER_DEG2, walk)?,
        scale_factor_sigma: numbers.not_negative("scale_factor_sigma_percent", 0.01, 0.0)?,
        range: range(table, sampling.raw_sigma(sigma_rad_s))?,
        quantiser: quantiser(table, sigma_rad_s, sampling)?,
        ..quiet
    };
    config.validate().map_err(|error| table.because(error.to_string()))?;
    Ok(config)
}

/// What is believed at the start, by all that learn.
pub(super) fn start(table: &Table<'_>) -> Result<StartPrior> {
    let numbers = Numbers(table);
    let period_s = table.required("torsion_period_s")?.positive()?;
    let angle_rad = numbers.any("angle_start_deg", RAD_PER_DEG, 0.0)?;
    let usual = StartPrior::released(angle_rad, period_s);
    let sigma = |key: &str, unit, usual| numbers.not_negative(key, unit, usual);
    Ok(StartPrior {
        angle_sigma_rad: sigma("angle_sigma_start_deg", RAD_PER_DEG, usual.angle_sigma_rad)?,
        rate_rad_s: numbers.any("rate_start_deg_s", RAD_PER_DEG, usual.rate_rad_s)?,
        rate_sigma_rad_s: sigma("rate_sigma_start_deg_s", RAD_PER_DEG, usual.rate_sigma_rad_s)?,
        period_sigma_s: sigma("torsion_period_sigma_s", 1.0, usual.period_sigma_s)?,
        damping_ratio: sigma("damping_ratio", 1.0, usual.damping_ratio)?,
        damping_ratio_sigma: sigma("damping_ratio_sigma", 1.0, usual.damping_ratio_sigma)?,
        bias_rad_s: numbers.any("bias_deg_h", RAD_S_PER_DEG_H, usual.bias_rad_s)?,
        bias_sigma_rad_s: sigma("bias_sigma_deg_h", RAD_S_PER_DEG_H, usual.bias_sigma_rad_s)?,
        ..usual
    })
}

/// The gyro's range, when it is told of. The margin is five deviations of a raw sample without a
/// word about it.
fn range(table: &Table<'_>, raw_sigma_rad_s: f64) -> Result<Option<GyroRange>> {
    let margin = table.optional("gyro_range_margin_deg_s");
    let Some(limit) = table.optional("gyro_range_deg_s") else {
        return match margin {
            Some(margin) => {
                Err(margin.because("is a margin of `gyro_range_deg_s`; add that, or remove this"))
            }
            None => Ok(None),
        };
    };
    let limit_rad_s = limit.positive()? * RAD_PER_DEG;
    let margin_rad_s = match &margin {
        Some(margin) => margin.not_negative()? * RAD_PER_DEG,
        None => MARGIN_RAW_SIGMAS * raw_sigma_rad_s,
    };
    if margin_rad_s >= limit_rad_s {
        let value = margin.as_ref().unwrap_or(&limit);
        return Err(value.because("the margin leaves nothing of the range; lower it or raise that"));
    }
    Ok(Some(GyroRange { limit_rad_s, margin_rad_s }))
}

/// One count of the gyro, and the noise of its raw samples: that of the averages, and as much more
/// as white noise has, without a word about it.
fn quantiser(table: &Table<'_>, sigma_rad_s: f64, sampling: Sampling) -> Result<Option<Quantiser>> {
    let raw = table.optional("gyro_raw_sigma_deg_s");
    let Some(count) = table.optional("gyro_count_deg_s") else {
        return match raw {
            Some(raw) => {
                Err(raw.because("is read with `gyro_count_deg_s`; add that, or remove this"))
            }
            None => Ok(None),
        };
    };
    let step_rad_s = count.positive()? * RAD_PER_DEG;
    let white = sampling.raw_sigma(sigma_rad_s);
    let raw_sigma_rad_s =
        Numbers(table).not_negative("gyro_raw_sigma_deg_s", RAD_PER_DEG, white)?;
    let samples = u32::try_from(sampling.averaging_samples).unwrap_or(u32::MAX);
    Ok(Some(Quantiser { step_rad_s, raw_sigma_rad_s, samples }))
}

/// The test of the innovations.
pub(super) fn test(table: &Table<'_>) -> Result<InnovationTest> {
    let usual = InnovationTest::STANDARD;
    let false_alarms = match table.optional("test_false_alarms") {
        Some(value) => {
            let share = value.positive()?;
            if share >= 1.0 {
                return Err(value.out_of_range("a number greater than 0 and less than 1"));
            }
            share
        }
        None => usual.false_alarms,
    };
    let horizon_samples = match table.optional("test_horizon_samples") {
        Some(value) => value.integer_in(2048..=i32::MAX)?.cast_unsigned(),
        None => usual.horizon_samples,
    };
    let floor = usual.kick_floor_rad_s;
    let kick_floor_rad_s =
        Numbers(table).not_negative("test_kick_floor_deg_s", RAD_PER_DEG, floor)?;
    let test = InnovationTest { false_alarms, horizon_samples, kick_floor_rad_s };
    test.validate().map_err(|error| table.because(error.to_string()))?;
    Ok(test)
}
