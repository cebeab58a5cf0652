//! What is believed before a record is read.

use super::error::SmoothingError;
use super::file::MeasuredRecord;
use crate::cli::{Smooth, SmoothPrior};
use crate::scenario::{EstimatorKind, Scenario};
use struna_estimator::{AugmentedConfig, FilterConfig, Refinement, StartPrior};
use struna_kernel::RAD_PER_DEG;

/// A belief, and where its noise comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct StartBelief {
    /// The belief.
    pub config: AugmentedConfig,
    /// In words.
    pub noise_from: &'static str,
}

/// What the options say, else the scenario's torsional estimator, else the defaults.
///
/// # Errors
/// [`SmoothingError`] when the period is nowhere said, or a number is unusable; whatever keeps the
/// scenario from being read.
pub fn start_belief(args: &Smooth, record: &MeasuredRecord) -> anyhow::Result<StartBelief> {
    let prior = &args.prior;
    let told = prior.scenario.as_deref().map(told_by).transpose()?;
    let deg = |option: Option<f64>, scenario: Option<f64>, default_deg: f64| {
        option.map(|value| value * RAD_PER_DEG).or(scenario).unwrap_or(default_deg * RAD_PER_DEG)
    };
    let filter = told.as_ref().map(|told| &told.1);
    let of = |get: fn(&FilterConfig) -> f64| filter.map(get);
    let period_s = prior.period_s.or_else(|| told.as_ref().map(|told| told.0));
    let period_s = period_s.ok_or(SmoothingError::NoPeriod)?;
    let start = StartPrior {
        angle_rad: deg(prior.angle_deg, of(|c| c.angle_start_rad), 0.0),
        angle_sigma_rad: deg(
            prior.angle_sigma_deg,
            of(|c| c.angle_variance_start_rad2.sqrt()),
            360.0,
        ),
        rate_rad_s: deg(prior.rate_deg_s, of(|c| c.rate_start_rad_s), 0.0),
        rate_sigma_rad_s: deg(
            prior.rate_sigma_deg_s,
            of(|c| c.rate_variance_start_rad2_s2.sqrt()),
            1.0,
        ),
        period_s,
        period_sigma_s: prior.period_sigma_s.unwrap_or(0.01 * period_s),
        damping_ratio: prior.damping_ratio,
        damping_ratio_sigma: prior.damping_ratio_sigma,
        bias_rad_s: 0.0,
        bias_sigma_rad_s: prior.bias_sigma_deg_s * RAD_PER_DEG,
    };
    let told_variance = of(|c| c.measurement_variance_rad2_s2);
    let (variance, noise_from) = noise(prior, told_variance, record);
    if variance <= 0.0 {
        return Err(SmoothingError::NoNoise { path: args.record.clone() }.into());
    }
    let config = AugmentedConfig {
        process_noise_rad2_s3: prior.random_torque * RAD_PER_DEG * RAD_PER_DEG,
        scale_factor_sigma: prior.scale_factor_sigma,
        ..AugmentedConfig::quiet(start, variance)
    };
    config.validate().map_err(|source| SmoothingError::Belief { source })?;
    Ok(StartBelief { config, noise_from })
}

/// Variance of one rate, rad²/s², and whose word it is.
fn noise(prior: &SmoothPrior, told: Option<f64>, record: &MeasuredRecord) -> (f64, &'static str) {
    let square = |sigma_rad_s: f64| sigma_rad_s * sigma_rad_s;
    match (prior.noise_deg_s, told) {
        (Some(sigma_deg_s), _) => (square(sigma_deg_s * RAD_PER_DEG), "as told"),
        (None, Some(variance)) => (variance, "by the scenario"),
        (None, None) => (square(record.noise_rad_s()), "by the record's second differences"),
    }
}

/// Period and start belief of a scenario's first torsional estimator.
fn told_by(path: &std::path::Path) -> anyhow::Result<(f64, FilterConfig)> {
    let scenario = Scenario::read(path)?;
    let torsional = scenario.estimators.iter().find_map(|plan| match &plan.kind {
        EstimatorKind::PlainIntegration(_) | EstimatorKind::PermanentRotation(_) => None,
        EstimatorKind::TorsionalOscillation { config, period_s } => Some((*period_s, *config)),
        EstimatorKind::AugmentedTorsion(config)
        | EstimatorKind::TestedTorsion { config, .. }
        | EstimatorKind::HysteresisBank(config) => Some(of_two_states(config)),
        EstimatorKind::Live(config) => Some(of_two_states(&config.torsion)),
        EstimatorKind::ThreeAxisSwing(plan) => {
            let of = &plan.config;
            let r = of.measurement_variance_rad2_s2;
            Some(of_two_states(&AugmentedConfig::quiet(of.start, r)))
        }
    });
    Ok(torsional.ok_or_else(|| SmoothingError::NoTorsion { path: path.to_owned() })?)
}

/// Period and start belief of a filter that knows more.
fn of_two_states(config: &AugmentedConfig) -> (f64, FilterConfig) {
    let start = &config.start;
    let of_two = FilterConfig {
        angle_start_rad: start.angle_rad,
        rate_start_rad_s: start.rate_rad_s,
        angle_variance_start_rad2: start.angle_sigma_rad * start.angle_sigma_rad,
        rate_variance_start_rad2_s2: start.rate_sigma_rad_s * start.rate_sigma_rad_s,
        measurement_variance_rad2_s2: config.measurement_variance_rad2_s2,
        process_noise_rad2_s3: config.process_noise_rad2_s3,
        refinement: Refinement::OFF,
    };
    (start.period_s, of_two)
}
