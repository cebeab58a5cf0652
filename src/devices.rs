//! From what a scenario says of an estimator to a device under test: in this process, or as an FMU
//! that is built first.

use crate::fmu::{self, FmiVersion};
use crate::in_process::InProcess;
use crate::scenario::{EstimatorKind, EstimatorPlan, RunAs};
use crate::three_axes::ThreeAxisDevice;
use anyhow::{Context, Result};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use struna_estimator::{
    AugmentedConfig, AugmentedFilter, Filter, FilterConfig, HysteresisBank, InnovationTest,
    LiveConfig, LiveEstimator, PlainIntegration, Quantiser, RateEstimator, SwingConfig,
    TestedFilter,
};
use struna_harness::{DeviceUnderTest, FmuDevice, Parameter, ParameterValue};

/// The estimators of a scenario, ready to step; FMUs are built in `fmu_folder`.
///
/// # Errors
/// When an FMU cannot be built, loaded or started, or a parameter is refused.
pub fn devices(
    plans: &[EstimatorPlan],
    fmu_folder: &Path,
) -> Result<Vec<Box<dyn DeviceUnderTest>>> {
    // Given FMUs come first: a bad one is refused before any other is built and left behind.
    let is_given = |(_, plan): &(usize, &EstimatorPlan)| matches!(plan.run_as, RunAs::FmuFile(_));
    let (given, made): (Vec<_>, Vec<_>) = plans.iter().enumerate().partition(is_given);
    let mut devices = BTreeMap::new();
    for (place, plan) in given.into_iter().chain(made) {
        let context = || format!("estimator '{}'", plan.name);
        devices.insert(place, device(plan, fmu_folder).with_context(context)?);
    }
    Ok(devices.into_values().collect())
}

fn device(plan: &EstimatorPlan, fmu_folder: &Path) -> Result<Box<dyn DeviceUnderTest>> {
    let file = match &plan.run_as {
        RunAs::InProcess => {
            if let EstimatorKind::ThreeAxisSwing(of_three) = &plan.kind {
                return Ok(Box::new(ThreeAxisDevice::new(&plan.name, **of_three)?));
            }
            let in_process = InProcess::new(&plan.name, estimator(&plan.kind)?);
            return Ok(Box::new(in_process.telling(plan.kind.rate_of())));
        }
        RunAs::Fmi2 => built(&plan.kind, FmiVersion::Fmi2, fmu_folder)?,
        RunAs::Fmi3 => built(&plan.kind, FmiVersion::Fmi3, fmu_folder)?,
        RunAs::FmuFile(file) => file.clone(),
    };
    let importer = struna_fmi_import::open(&file)?;
    let fmu = FmuDevice::new(importer.as_ref(), &plan.name, &parameters(&plan.kind))?;
    Ok(Box::new(fmu.telling(plan.kind.rate_of())))
}

/// The estimator itself, as every bench of this program steps it.
///
/// # Errors
/// When it refuses a parameter, or is none of one rate.
pub fn estimator(kind: &EstimatorKind) -> Result<Box<dyn RateEstimator>> {
    Ok(match kind {
        EstimatorKind::PlainIntegration(config) => Box::new(PlainIntegration::new(*config)?),
        EstimatorKind::PermanentRotation(config) => Box::new(Filter::permanent_rotation(*config)?),
        EstimatorKind::TorsionalOscillation { config, period_s } => {
            Box::new(Filter::torsional_oscillation(*config, *period_s)?)
        }
        EstimatorKind::AugmentedTorsion(config) => Box::new(AugmentedFilter::new(config)?),
        EstimatorKind::TestedTorsion { config, test } => Box::new(TestedFilter::new(config, test)?),
        EstimatorKind::HysteresisBank(config) => Box::new(HysteresisBank::new(config)?),
        EstimatorKind::Live(config) => Box::new(LiveEstimator::new(config)?),
        EstimatorKind::ThreeAxisSwing(_) => anyhow::bail!("it takes three rates, not one"),
    })
}

/// Builds the FMU of an estimator.
fn built(kind: &EstimatorKind, version: FmiVersion, folder: &Path) -> Result<PathBuf> {
    let model = match kind {
        EstimatorKind::PlainIntegration(_) => anyhow::bail!("plain integration is no FMU"),
        EstimatorKind::ThreeAxisSwing(_) => anyhow::bail!("a filter of three rates is no FMU"),
        EstimatorKind::PermanentRotation(_) => "PermanentRotation",
        EstimatorKind::TorsionalOscillation { .. } => "TorsionalOscillation",
        EstimatorKind::AugmentedTorsion(_) | EstimatorKind::TestedTorsion { .. } => {
            "AugmentedTorsion"
        }
        EstimatorKind::HysteresisBank(_) => "HysteresisBank",
        EstimatorKind::Live(_) => "LiveEstimator",
    };
    Ok(fmu::build(model, version, folder)?)
}

/// The FMU's parameters.
fn parameters(kind: &EstimatorKind) -> Vec<Parameter> {
    match kind {
        EstimatorKind::PlainIntegration(config) | EstimatorKind::PermanentRotation(config) => {
            of_2008(config)
        }
        EstimatorKind::TorsionalOscillation { config, period_s } => {
            let mut parameters = of_2008(config);
            parameters.push(float("period_s", *period_s));
            parameters
        }
        EstimatorKind::AugmentedTorsion(config) => {
            let mut parameters = augmented(config);
            parameters.push(boolean("innovation_test", false));
            parameters
        }
        EstimatorKind::TestedTorsion { config, test } => {
            let mut parameters = augmented(config);
            parameters.push(boolean("innovation_test", true));
            parameters.extend(tested(test));
            parameters
        }
        EstimatorKind::HysteresisBank(config) => augmented(config),
        EstimatorKind::Live(config) => live(config),
        // Runs in process alone.
        EstimatorKind::ThreeAxisSwing(_) => Vec::new(),
    }
}

fn float(name: &str, value: f64) -> Parameter {
    Parameter { name: name.to_owned(), value: ParameterValue::Float64(value) }
}

fn integer(name: &str, value: u32) -> Parameter {
    let value = ParameterValue::Int32(i32::try_from(value).unwrap_or(i32::MAX));
    Parameter { name: name.to_owned(), value }
}

fn boolean(name: &str, value: bool) -> Parameter {
    Parameter { name: name.to_owned(), value: ParameterValue::Boolean(value) }
}

/// Parameters that carry the names of the configuration's fields.
fn of_2008(c: &FilterConfig) -> Vec<Parameter> {
    vec![
        float("angle_start_rad", c.angle_start_rad),
        float("rate_start_rad_s", c.rate_start_rad_s),
        float("angle_variance_start_rad2", c.angle_variance_start_rad2),
        float("rate_variance_start_rad2_s2", c.rate_variance_start_rad2_s2),
        float("measurement_variance_rad2_s2", c.measurement_variance_rad2_s2),
        float("process_noise_rad2_s3", c.process_noise_rad2_s3),
        integer("refinement_samples", c.refinement.samples),
        integer("refinement_reading", c.refinement.reading.number().unsigned_abs()),
    ]
}

fn augmented(c: &AugmentedConfig) -> Vec<Parameter> {
    let start = &c.start;
    // A range of 0 is none.
    let (limit_rad_s, margin_rad_s) =
        c.range.map_or((0.0, 0.0), |range| (range.limit_rad_s, range.margin_rad_s));
    let mut parameters = vec![
        float("angle_start_rad", start.angle_rad),
        float("angle_sigma_start_rad", start.angle_sigma_rad),
        float("rate_start_rad_s", start.rate_rad_s),
        float("rate_sigma_start_rad_s", start.rate_sigma_rad_s),
        float("period_start_s", start.period_s),
        float("period_sigma_start_s", start.period_sigma_s),
        float("damping_ratio_start", start.damping_ratio),
        float("damping_ratio_sigma_start", start.damping_ratio_sigma),
        float("bias_start_rad_s", start.bias_rad_s),
        float("bias_sigma_start_rad_s", start.bias_sigma_rad_s),
        float("measurement_variance_rad2_s2", c.measurement_variance_rad2_s2),
        float("process_noise_rad2_s3", c.process_noise_rad2_s3),
        float("bias_walk_rad2_s3", c.bias_walk_rad2_s3),
        float("scale_factor_sigma", c.scale_factor_sigma),
        float("gyro_range_rad_s", limit_rad_s),
        float("gyro_range_margin_rad_s", margin_rad_s),
        // As an estimator in process takes what the averager hands out.
        boolean("measured_rate_is_mean", true),
    ];
    parameters.extend(c.quantiser.iter().flat_map(quantiser));
    parameters
}

fn quantiser(q: &Quantiser) -> [Parameter; 3] {
    [
        float("gyro_count_rad_s", q.step_rad_s),
        float("gyro_raw_sigma_rad_s", q.raw_sigma_rad_s),
        integer("gyro_samples", q.samples),
    ]
}

fn tested(test: &InnovationTest) -> [Parameter; 3] {
    [
        float("test_false_alarms", test.false_alarms),
        integer("test_horizon_samples", test.horizon_samples),
        float("test_kick_floor_rad_s", test.kick_floor_rad_s),
    ]
}

fn live(c: &LiveConfig) -> Vec<Parameter> {
    let mut parameters = augmented(&c.torsion);
    parameters.extend(tested(&c.test));
    parameters.extend([
        float("sample_period_s", c.sample_period_s),
        float("swing_max_rad", c.swing_max_rad),
        integer("fit_work_per_sample", c.work_per_sample),
    ]);
    parameters.extend(c.swing.iter().flat_map(swing));
    parameters
}

/// What the estimator takes from elsewhere, start and noise, is not among it.
fn swing(c: &SwingConfig) -> [Parameter; 12] {
    let [x, y, z] = c.body.inertia_kg_m2;
    let [towards_x_rad, towards_y_rad] = c.axis.tilt_b_rad;
    [
        float("body_mass_kg", c.body.mass_kg),
        float("body_com_depth_m", c.body.com_depth_m),
        float("body_inertia_x_kg_m2", x),
        float("body_inertia_y_kg_m2", y),
        float("body_inertia_z_kg_m2", z),
        float("body_inertia_sigma", c.inertia_sigma),
        float("body_swing_damping_1_s", c.body.swing_damping_1_s),
        float("body_swing_damping_sigma", c.swing_damping_sigma),
        float("gravity_m_s2", c.body.gravity_m_s2),
        float("input_axis_x_rad", towards_x_rad),
        float("input_axis_y_rad", towards_y_rad),
        float("input_axis_sigma_rad", c.axis.tilt_sigma_rad),
    ]
}
