//! One co-simulation step of a filter as an FMU, beside the same filter called directly.

use crate::filters::{PERIOD_S, STEP_S, config, measured_rates_rad_s};
use crate::table::{Row, ns};
use crate::timing::{best_in_turns, time_per_unit};
use anyhow::{Result, ensure};
use std::hint::black_box;
use std::path::Path;
use struna::fmu::{FmiVersion, build};
use struna_estimator::{Filter, RateEstimator, Reading, Refinement, TorsionalOscillation};
use struna_fmi_import::{FmuDescription, Instance, Kind, ValueReference, open};

const MODEL: &str = "TorsionalOscillation";
/// What a step through FMI may cost above the plain call.
const ALLOWANCE_S: f64 = 20e-9;
const REFINEMENT: Refinement = Refinement { samples: 100, reading: Reading::M6 };

pub(crate) fn rows() -> Result<Vec<Row>> {
    let folder = tempfile::tempdir()?;
    let rates_rad_s = measured_rates_rad_s();
    let mut fmi2 = Stepped::start(FmiVersion::Fmi2, folder.path())?;
    let mut fmi3 = Stepped::start(FmiVersion::Fmi3, folder.path())?;
    let mut plain = Filter::torsional_oscillation(config(REFINEMENT), PERIOD_S)?;
    let [fmi2_s, fmi3_s, plain_s] = best_in_turns([
        Box::new(|| time_per_unit(rates_rad_s.len(), || fmi2.run(&rates_rad_s))),
        Box::new(|| time_per_unit(rates_rad_s.len(), || fmi3.run(&rates_rad_s))),
        Box::new(|| time_per_unit(rates_rad_s.len(), || run_plain(&mut plain, &rates_rad_s))),
    ])?;
    same_estimate(&[fmi2, fmi3], &plain)?;
    let row = |version: &str, ours_s: f64| Row {
        what: format!("{version}: set 1, do_step, get 2"),
        ours: ns(ours_s),
        other: format!("{} (plain call {} + 20)", ns(plain_s + ALLOWANCE_S), ns(plain_s)),
        ratio: Some((plain_s + ALLOWANCE_S) / ours_s),
        target: 1.0,
    };
    Ok(vec![row("FMI 2.0", fmi2_s), row("FMI 3.0", fmi3_s)])
}

/// A running FMU and how far it has come.
struct Stepped {
    instance: Box<dyn Instance>,
    measured_rate: [ValueReference; 1],
    outputs: [ValueReference; 2],
    values: [f64; 2],
    steps: u32,
}

impl Stepped {
    fn start(version: FmiVersion, folder: &Path) -> Result<Self> {
        let importer = open(&build(MODEL, version, folder)?)?;
        let description = importer.description();
        let float = |name| description.variable(name, Kind::Float64);
        let mut instance = importer.instantiate("bench")?;
        set_parameters(description, instance.as_mut())?;
        instance.initialise(0.0)?;
        Ok(Self {
            instance,
            measured_rate: [float("measured_rate_rad_s")?],
            outputs: [float("angle_rad")?, float("rate_rad_s")?],
            values: [0.0; 2],
            steps: 0,
        })
    }

    #[inline(never)]
    fn run(&mut self, rates_rad_s: &[f64]) -> Result<()> {
        let instance = self.instance.as_mut();
        for &rate_rad_s in rates_rad_s {
            instance.set_f64(&self.measured_rate, &[rate_rad_s])?;
            instance.do_step(f64::from(self.steps) * STEP_S, STEP_S)?;
            instance.get_f64(&self.outputs, &mut self.values)?;
            self.steps += 1;
        }
        Ok(())
    }
}

fn set_parameters(description: &FmuDescription, instance: &mut dyn Instance) -> Result<()> {
    let config = config(REFINEMENT);
    for (name, value) in [
        ("angle_start_rad", config.angle_start_rad),
        ("rate_start_rad_s", config.rate_start_rad_s),
        ("angle_variance_start_rad2", config.angle_variance_start_rad2),
        ("rate_variance_start_rad2_s2", config.rate_variance_start_rad2_s2),
        ("measurement_variance_rad2_s2", config.measurement_variance_rad2_s2),
        ("process_noise_rad2_s3", config.process_noise_rad2_s3),
        ("period_s", PERIOD_S),
    ] {
        instance.set_f64(&[description.variable(name, Kind::Float64)?], &[value])?;
    }
    let samples = description.variable("refinement_samples", Kind::Int32)?;
    instance.set_i32(samples, i32::try_from(REFINEMENT.samples)?)?;
    Ok(instance.set_i32(description.variable("refinement_reading", Kind::Int32)?, 6)?)
}

#[inline(never)]
fn run_plain(filter: &mut Filter<TorsionalOscillation>, rates_rad_s: &[f64]) -> Result<()> {
    for &rate_rad_s in rates_rad_s {
        let (filter, rate_rad_s) = black_box((&mut *filter, rate_rad_s));
        filter.predict(STEP_S)?;
        filter.update(rate_rad_s)?;
        let belief = filter.belief();
        black_box([belief.angle_rad, belief.rate_rad_s]);
    }
    Ok(())
}

/// All of them have taken the same measurements, so all must have ended at the same bits.
fn same_estimate(fmus: &[Stepped], plain: &Filter<TorsionalOscillation>) -> Result<()> {
    let belief = plain.belief();
    let expected = [belief.angle_rad, belief.rate_rad_s].map(f64::to_bits);
    for fmu in fmus {
        let found = fmu.values.map(f64::to_bits);
        ensure!(found == expected, "{:?} ends at other bits than the plain filter", fmu.instance);
    }
    Ok(())
}
