//! `[[estimator]]`: which estimators run, how they start, and whether as FMU or in process.

mod augmented;
mod keys;
mod live;
mod three_axes;

pub use three_axes::ThreeAxisPlan;

use keys::KindWord;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use struna_estimator::{
    AugmentedConfig, FilterConfig, InnovationTest, LiveConfig, Reading, Refinement,
};
use struna_harness::cross_rate_fields;
use struna_kernel::{RAD_PER_DEG, RateOf};
use struna_settings::{Result, Table};
use struna_wire::FrameSpec;

/// A shipped layout that carries three rates.
const TRIAD_FRAME: &str = "struna/vg910d-triad@1";
const RAD2_PER_DEG2: f64 = RAD_PER_DEG * RAD_PER_DEG;

/// One estimator of a scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct EstimatorPlan {
    /// Its name in record and score.
    pub name: String,
    /// What it is, and what it is told.
    pub kind: EstimatorKind,
    /// Where it runs.
    pub run_as: RunAs,
}

/// The estimators there are, with all that each is told before it starts.
#[derive(Debug, Clone, PartialEq)]
pub enum EstimatorKind {
    /// Plain integration of the rate.
    PlainIntegration(FilterConfig),
    /// Kalman filter that assumes a constant rate.
    PermanentRotation(FilterConfig),
    /// Kalman filter that assumes undamped torsion.
    TorsionalOscillation {
        /// Start and noise.
        config: FilterConfig,
        /// Assumed period, s.
        period_s: f64,
    },
    /// Kalman filter that learns period, damping and bias.
    AugmentedTorsion(AugmentedConfig),
    /// The same behind a test of its innovations, with roll-back.
    TestedTorsion {
        /// Prior and noise.
        config: AugmentedConfig,
        /// The test.
        test: InnovationTest,
    },
    /// Bank of Kalman filters for a thread that may yield.
    HysteresisBank(AugmentedConfig),
    /// What switches between filters as a live rig demands.
    Live(Box<LiveConfig>),
    /// Kalman filter of a swinging body watched by gyros about three axes.
    ThreeAxisSwing(Box<ThreeAxisPlan>),
}

impl EstimatorKind {
    /// What the rate that it tells is the rate of.
    ///
    /// The filters of pure torsion follow what the gyro feels, and that is the rate about the
    /// body's axis. Those of a swinging body know the tilt and tell the rate of the twist; so does
    /// the switch, whoever speaks in it, since its fallback counts what the swing winds up as bias
    /// and its filter of pure torsion speaks only where the two rates are one.
    #[must_use]
    pub const fn rate_of(&self) -> RateOf {
        match self {
            Self::PlainIntegration(_)
            | Self::PermanentRotation(_)
            | Self::TorsionalOscillation { .. }
            | Self::AugmentedTorsion(_)
            | Self::TestedTorsion { .. }
            | Self::HysteresisBank(_) => RateOf::BodyAxis,
            Self::Live(_) | Self::ThreeAxisSwing(_) => RateOf::Twist,
        }
    }
}

/// How the rates come that estimators are given.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sampling {
    /// Gyro samples averaged into one rate.
    pub(super) averaging_samples: u64,
    /// Time from one rate to the next, s.
    pub(super) output_period_s: f64,
}

impl Sampling {
    /// Deviation of a raw sample, when averages of white noise have this one.
    fn raw_sigma(self, sigma: f64) -> f64 {
        sigma * (self.averaging_samples as f64).sqrt()
    }
}

/// Where an estimator runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RunAs {
    /// In this process.
    InProcess,
    /// As the FMU that this program builds, FMI 2.0.
    Fmi2,
    /// As the FMU that this program builds, FMI 3.0.
    Fmi3,
    /// As an FMU from a file.
    FmuFile(PathBuf),
}

#[derive(Clone, Copy)]
enum Place {
    InProcess,
    Fmi2,
    Fmi3,
    File,
}

/// The estimators of a scenario.
pub(super) fn estimators(
    tables: &[Table<'_>],
    folder: &Path,
    sampling: Sampling,
) -> Result<Vec<EstimatorPlan>> {
    let mut names = BTreeSet::new();
    let mut plans = Vec::with_capacity(tables.len());
    for table in tables {
        let plan = estimator(table, folder, sampling)?;
        if !names.insert(plan.name.clone()) {
            let name = table.required("name")?;
            return Err(name.because("another estimator has this name; choose a different one"));
        }
        plans.push(plan);
    }
    Ok(plans)
}

/// Refuses estimators of three rates beside a frame that carries fewer.
pub(super) fn check_axes(root: &Table<'_>, frame: &FrameSpec) -> Result<()> {
    if cross_rate_fields(frame).is_some() {
        return Ok(());
    }
    for table in root.tables("estimator", super::ESTIMATORS_MAX)? {
        let kind = table.required("kind")?;
        if kind.word(&keys::WORDS)? == KindWord::ThreeAxis {
            return Err(kind.because(one_rate(frame)));
        }
    }
    Ok(())
}

/// Why an estimator of three rates cannot go with `frame`, and what to do.
#[must_use]
pub fn one_rate(frame: &FrameSpec) -> String {
    format!(
        "it takes the rates `rate_x`, `rate_y` and `rate` and frame layout '{}' does not carry \
         them; set the frame to \"{TRIAD_FRAME}\" or to a file with all three, or choose another \
         kind of estimator",
        frame.name()
    )
}

fn estimator(table: &Table<'_>, folder: &Path, sampling: Sampling) -> Result<EstimatorPlan> {
    keys::refuse_unknown(table)?;
    let word = table.required("kind")?.word(&keys::WORDS)?;
    keys::refuse_unread(table, word)?;
    let kind = match word {
        KindWord::Integration => EstimatorKind::PlainIntegration(config(table)?),
        KindWord::Rotation => EstimatorKind::PermanentRotation(config(table)?),
        KindWord::Torsion => EstimatorKind::TorsionalOscillation {
            period_s: table.required("torsion_period_s")?.positive()?,
            config: config(table)?,
        },
        KindWord::Augmented => EstimatorKind::AugmentedTorsion(augmented::config(table, sampling)?),
        KindWord::Tested => EstimatorKind::TestedTorsion {
            config: augmented::config(table, sampling)?,
            test: augmented::test(table)?,
        },
        KindWord::Bank => EstimatorKind::HysteresisBank(augmented::config(table, sampling)?),
        KindWord::Live => EstimatorKind::Live(Box::new(live::config(table, sampling)?)),
        KindWord::ThreeAxis => EstimatorKind::ThreeAxisSwing(Box::new(three_axes::plan(table)?)),
    };
    Ok(EstimatorPlan { name: name(table)?, kind, run_as: run_as(table, word, folder)? })
}

fn name(table: &Table<'_>) -> Result<String> {
    let value = table.required("name")?;
    let name = value.text()?;
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
    if name.is_empty() || name.len() > 32 || name == "truth" || !name.chars().all(plain) {
        return Err(value.out_of_range("up to 32 letters, digits, '-' or '_', and not \"truth\""));
    }
    Ok(name.to_owned())
}

fn run_as(table: &Table<'_>, kind: KindWord, folder: &Path) -> Result<RunAs> {
    let value = table.required("run_as")?;
    let place = value.word(&[
        ("in-process", Place::InProcess),
        ("fmi2", Place::Fmi2),
        ("fmi3", Place::Fmi3),
        ("fmu-file", Place::File),
    ])?;
    let no_fmu = match kind {
        KindWord::Integration => Some("plain integration is no FMU"),
        KindWord::ThreeAxis => Some("an FMU here is given one rate, and this filter takes three"),
        _ => None,
    };
    if let (Some(reason), false) = (no_fmu, matches!(place, Place::InProcess)) {
        return Err(value.out_of_range(format!("\"in-process\": {reason}")));
    }
    let file = table.optional("fmu_file");
    match (place, file) {
        (Place::File, None) => Err(value.because("needs `fmu_file`; add it")),
        (Place::File, Some(file)) => Ok(RunAs::FmuFile(folder.join(file.text()?))),
        (_, Some(file)) => {
            Err(file.because("is read with `run_as = \"fmu-file\"` only; change one of them"))
        }
        (Place::InProcess, None) => Ok(RunAs::InProcess),
        (Place::Fmi2, None) => Ok(RunAs::Fmi2),
        (Place::Fmi3, None) => Ok(RunAs::Fmi3),
    }
}

fn config(table: &Table<'_>) -> Result<FilterConfig> {
    let number =
        |key: &str, default: f64| table.optional(key).map_or(Ok(default), |value| value.number());
    let sigma2 = |key: &str| -> Result<f64> {
        let sigma_rad = table.required(key)?.not_negative()? * RAD_PER_DEG;
        Ok(sigma_rad * sigma_rad)
    };
    let measurement = table.required("measurement_sigma_deg_s")?.positive()? * RAD_PER_DEG;
    let noise = table.optional("process_noise_deg2_s3");
    let config = FilterConfig {
        angle_start_rad: number("angle_start_deg", 0.0)? * RAD_PER_DEG,
        rate_start_rad_s: number("rate_start_deg_s", 0.0)? * RAD_PER_DEG,
        angle_variance_start_rad2: sigma2("angle_sigma_start_deg")?,
        rate_variance_start_rad2_s2: sigma2("rate_sigma_start_deg_s")?,
        measurement_variance_rad2_s2: measurement * measurement,
        process_noise_rad2_s3: noise.map_or(Ok(0.0), |q| q.not_negative())? * RAD2_PER_DEG2,
        refinement: refinement(table)?,
    };
    config.validate().map_err(|error| table.because(error.to_string()))?;
    Ok(config)
}

fn refinement(table: &Table<'_>) -> Result<Refinement> {
    let samples = match table.optional("refinement_samples") {
        Some(samples) => samples.integer_in(0..=i32::MAX)?.cast_unsigned(),
        None => 0,
    };
    let reading = match table.optional("refinement_reading") {
        Some(reading) => reading.word(&[
            ("M0", Reading::M0),
            ("M1", Reading::M1),
            ("M4", Reading::M4),
            ("M6", Reading::M6),
        ])?,
        None => Reading::M6,
    };
    Ok(Refinement { samples, reading })
}
