//! What a live run was asked to do, in a form that can be kept beside its bytes.

use crate::frames;
use crate::scenario::{self, EstimatorKind, EstimatorPlan, RunAs, Scenario};
use anyhow::{Context, Result, bail, ensure};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use struna_estimator::{
    AugmentedConfig, FilterConfig, InnovationTest, LiveConfig, Reading, Refinement, StartPrior,
};
use struna_harness::cross_rate_fields;
use struna_kernel::{RAD_PER_DEG, SimTime};
use struna_wire::FrameSpec;

/// Version of the file.
const SCHEMA: &str = "struna.hil.setup/1";
/// Most that a frame or scenario file may hold, bytes.
const TEXT_BYTES_MAX: usize = 1 << 20;
/// The 2008 program could take so many averaged samples in a second.
const OUTPUT_HZ_MAX: f64 = 100.0;
const AVERAGING_MAX: u64 = 1_000_000;
const LATENCY_S_MAX: f64 = 10.0;

// Defaults of estimators without a scenario.
/// Rate noise of the VG-910D, deg/s for one sample a second.
const RATE_NOISE_DEG_S: f64 = 0.00117;
/// Its scale factor, relative, from one gyro and temperature to the next.
const SCALE_FACTOR_SIGMA: f64 = 0.002;
/// Its bias instability, 3 °/h, taken as a random walk that goes so far within a second: deg²/s³.
/// With less the filter takes the wandering of the bias for kicks of the body.
const BIAS_WALK_DEG2_S3: f64 = 1e-6;
const ANGLE_SIGMA_START_DEG: f64 = 1.0;
/// The body may be moving already.
const RATE_SIGMA_START_DEG_S: f64 = 10.0;
/// Of the 2008 filter of torsion.
const REFINEMENT_SAMPLES: u32 = 100;
/// What torsion is to a filter that takes the rate for constant: 0.06 deg/s² for some 100 s, on a
/// string of 480 s that is wound by a turn. Its refinement stays off, for that replaces what the
/// filter claims of the angle by how well the angle agrees with a sum of the same rates.
const ROTATION_NOISE_DEG2_S3: f64 = 0.4;

/// Everything that decides what is made of the bytes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Setup {
    schema: String,
    /// The frame file's text; the scenario's frame, without.
    pub frame_toml: Option<String>,
    /// The scenario, if one was given.
    pub scenario: Option<ScenarioText>,
    /// Names of the estimators; those of the scenario or the usual ones, when empty.
    pub estimators: Vec<String>,
    /// Gyro samples averaged into one; the scenario's number or a default, without.
    pub averaging_samples: Option<u64>,
    /// Period of the torsional oscillation, for the default filter of that kind.
    pub torsion_period_s: Option<f64>,
    /// Angle at which the default estimators start, deg.
    pub angle_start_deg: f64,
    /// Constant delay of the line, s.
    pub latency_s: f64,
}

/// A scenario file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ScenarioText {
    /// Where it was. Paths in it are relative to that.
    pub path: PathBuf,
    /// What it says.
    pub text: String,
}

/// A setup, understood.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The frame.
    pub frame: FrameSpec,
    /// The estimators.
    pub estimators: Vec<EstimatorPlan>,
    /// Gyro samples averaged into one.
    pub averaging_samples: u64,
    /// Constant delay of the line.
    pub latency: SimTime,
}

impl Plan {
    /// Whether the frame carries rates about three axes.
    #[must_use]
    pub fn has_cross(&self) -> bool {
        cross_rate_fields(&self.frame).is_some()
    }
}

impl Setup {
    /// The defaults for a frame file's text or a scenario; a run needs one of them.
    #[must_use]
    pub fn new(frame_toml: Option<String>, scenario: Option<ScenarioText>) -> Self {
        Self {
            schema: SCHEMA.to_owned(),
            frame_toml,
            scenario,
            estimators: Vec::new(),
            averaging_samples: None,
            torsion_period_s: None,
            angle_start_deg: 0.0,
            latency_s: 0.0,
        }
    }

    /// Reads what [`Self::to_json`] wrote.
    ///
    /// # Errors
    /// When the file cannot be read or is something else.
    pub fn read(path: &Path) -> Result<Self> {
        let text = read_text(path)?;
        let setup: Self = serde_json::from_str(&text)
            .with_context(|| format!("{} is no setup of `struna hil`", path.display()))?;
        ensure!(
            setup.schema == SCHEMA,
            "{} has schema '{}', this program reads '{SCHEMA}'",
            path.display(),
            setup.schema
        );
        Ok(setup)
    }

    /// The setup as a file's text.
    ///
    /// # Errors
    /// Never in practice: all of it is text and finite numbers.
    pub fn to_json(&self) -> Result<String> {
        Ok(serde_json::to_string_pretty(self)?)
    }

    /// Finds frame, estimators and numbers.
    ///
    /// # Errors
    /// When a file does not parse, an estimator is not known, or a number is out of its range.
    pub fn plan(&self) -> Result<Plan> {
        let scenario = match &self.scenario {
            Some(ScenarioText { path, text }) => Some(Scenario::parse(text, path)?),
            None => None,
        };
        let frame = match (&self.frame_toml, &scenario) {
            (Some(text), _) => frames::unique(text)?,
            (None, Some(scenario)) => scenario.frame.clone(),
            (None, None) => bail!("name a frame with --frame, or a --scenario that has one"),
        };
        let latency_ok = self.latency_s.abs() <= LATENCY_S_MAX;
        ensure!(latency_ok, "a latency of {} s is none: at most {LATENCY_S_MAX} s", self.latency_s);
        let averaging_samples = match (self.averaging_samples, &scenario) {
            (Some(samples), _) => samples,
            (None, Some(scenario)) => scenario.averaging_samples,
            (None, None) => default_averaging(frame.timing().rate_hz),
        };
        ensure!(
            (1..=AVERAGING_MAX).contains(&averaging_samples),
            "averaging over {averaging_samples} samples: take 1 to {AVERAGING_MAX}"
        );
        let output_hz = frame.timing().rate_hz / averaging_samples as f64;
        let (known, usual) = match scenario {
            Some(scenario) => (scenario.estimators, None),
            None => (self.default_estimators(output_hz)?, Some(self.usual())),
        };
        let estimators = match usual {
            Some(usual) if self.estimators.is_empty() => chosen(known, &usual.map(str::to_owned))?,
            _ => chosen(known, &self.estimators)?,
        };
        let of_three =
            |plan: &&EstimatorPlan| matches!(plan.kind, EstimatorKind::ThreeAxisSwing(_));
        if let (Some(plan), None) = (estimators.iter().find(of_three), cross_rate_fields(&frame)) {
            bail!("estimator '{}': {}", plan.name, scenario::one_rate(&frame));
        }
        let latency = SimTime::from_s(self.latency_s)?;
        Ok(Plan { frame, estimators, averaging_samples, latency })
    }

    /// Names of the estimators that run when none is named.
    fn usual(&self) -> [&'static str; 2] {
        ["integration", if self.torsion_period_s.is_some() { "live" } else { "rotation" }]
    }

    fn default_estimators(&self, output_hz: f64) -> Result<Vec<EstimatorPlan>> {
        let config = |samples, process_noise_deg2_s3| FilterConfig {
            angle_start_rad: self.angle_start_deg * RAD_PER_DEG,
            rate_start_rad_s: 0.0,
            angle_variance_start_rad2: variance_of_deg(ANGLE_SIGMA_START_DEG),
            rate_variance_start_rad2_s2: variance_of_deg(RATE_SIGMA_START_DEG_S),
            measurement_variance_rad2_s2: variance_of_deg(RATE_NOISE_DEG_S * output_hz.sqrt()),
            process_noise_rad2_s3: process_noise_deg2_s3 * RAD_PER_DEG * RAD_PER_DEG,
            refinement: Refinement { samples, reading: Reading::M6 },
        };
        let plan = |name: &str, kind| {
            let (name, run_as) = (name.to_owned(), RunAs::InProcess);
            EstimatorPlan { name, kind, run_as }
        };
        ensure!(self.angle_start_deg.is_finite(), "a start angle is a number");
        let rotation = config(0, ROTATION_NOISE_DEG2_S3);
        let mut plans = vec![
            plan("integration", EstimatorKind::PlainIntegration(config(0, 0.0))),
            plan("rotation", EstimatorKind::PermanentRotation(rotation)),
        ];
        if let Some(period_s) = self.torsion_period_s {
            ensure!(
                period_s.is_finite() && period_s > 0.0,
                "a torsion period of {period_s} s is none: write a positive number"
            );
            let config = config(REFINEMENT_SAMPLES, 0.0);
            plans.push(plan("torsion", EstimatorKind::TorsionalOscillation { config, period_s }));
            let (config, test) = (self.learning(output_hz, period_s), InnovationTest::STANDARD);
            plans.push(plan("tested", EstimatorKind::TestedTorsion { config, test }));
            let live = LiveConfig::new(config, 1.0 / output_hz);
            plans.push(plan("live", EstimatorKind::Live(Box::new(live))));
        }
        Ok(plans)
    }

    /// What those that learn are told, which is little: the body may be moving, and the angle be
    /// anything.
    fn learning(&self, output_hz: f64, period_s: f64) -> AugmentedConfig {
        let start = StartPrior {
            rate_sigma_rad_s: RATE_SIGMA_START_DEG_S * RAD_PER_DEG,
            ..StartPrior::released(self.angle_start_deg * RAD_PER_DEG, period_s)
        };
        let r = variance_of_deg(RATE_NOISE_DEG_S * output_hz.sqrt());
        AugmentedConfig {
            scale_factor_sigma: SCALE_FACTOR_SIGMA,
            bias_walk_rad2_s3: BIAS_WALK_DEG2_S3 * RAD_PER_DEG * RAD_PER_DEG,
            ..AugmentedConfig::quiet(start, r)
        }
    }
}

/// Variance in rad or rad/s, squared, of a deviation in degrees.
fn variance_of_deg(sigma_deg: f64) -> f64 {
    (sigma_deg * RAD_PER_DEG).powi(2)
}

/// Those of `known` that `names` name, in the order of `known`.
fn chosen(known: Vec<EstimatorPlan>, names: &[String]) -> Result<Vec<EstimatorPlan>> {
    let is_known = |name: &&String| !known.iter().any(|plan| plan.name == **name);
    if let Some(name) = names.iter().find(is_known) {
        let there: Vec<_> = known.iter().map(|plan| plan.name.as_str()).collect();
        let needs_period = matches!(name.as_str(), "torsion" | "tested" | "live");
        let hint = if needs_period { format!("; {name} needs --period-s") } else { String::new() };
        bail!("no estimator is called '{name}'; there are: {}{hint}", there.join(", "));
    }
    let wanted = |plan: &EstimatorPlan| names.is_empty() || names.contains(&plan.name);
    Ok(known.into_iter().filter(wanted).collect())
}

/// As many as the 2008 program would have averaged.
fn default_averaging(rate_hz: f64) -> u64 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "rates of frame files are positive and far below 2^53"
    )]
    return (rate_hz / OUTPUT_HZ_MAX).ceil().max(1.0) as u64;
}

/// The text of the frame file `name`: a shipped layout, or a file.
///
/// # Errors
/// When it is neither; the message names the shipped ones.
pub fn frame_text(name: &str) -> Result<String> {
    if let Some(text) = frames::shipped(name) {
        return Ok(text.to_owned());
    }
    let known = frames::SHIPPED.map(|(name, _)| name);
    let remedy = || format!("no such frame; write a .toml file or one of: {}", known.join(", "));
    read_text(Path::new(name)).with_context(remedy)
}

/// The whole of a file that is not absurdly large.
///
/// # Errors
/// When it cannot be read or holds more than a megabyte.
pub fn read_text(path: &Path) -> Result<String> {
    let cannot = || format!("cannot read {}", path.display());
    let length = std::fs::metadata(path).with_context(cannot)?.len();
    ensure!(length <= TEXT_BYTES_MAX as u64, "{}: larger than any such file", path.display());
    std::fs::read_to_string(path).with_context(cannot)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn setup() -> Setup {
        Setup::new(Some(frame_text("struna/vg910d@1").unwrap()), None)
    }

    #[test]
    fn without_a_scenario_there_are_integration_and_rotation_or_what_learns_a_period() {
        let plan = setup().plan().unwrap();
        let names: Vec<_> = plan.estimators.iter().map(|plan| plan.name.as_str()).collect();
        assert_eq!(names, ["integration", "rotation"]);
        assert_eq!(plan.averaging_samples, 3, "300 Hz to 100 Hz");
        let with_period = Setup { torsion_period_s: Some(480.0), ..setup() };
        let names = |setup: &Setup| -> Vec<String> {
            setup.plan().unwrap().estimators.into_iter().map(|plan| plan.name).collect()
        };
        assert_eq!(names(&with_period), ["integration", "live"]);
        let named = ["torsion", "rotation"].map(str::to_owned).to_vec();
        assert_eq!(names(&Setup { estimators: named, ..with_period }), ["rotation", "torsion"]);
    }

    #[test]
    fn names_choose_and_unknown_ones_are_refused_with_those_there_are() {
        let named = |name: &str| Setup { estimators: vec![name.to_owned()], ..setup() };
        assert_eq!(named("rotation").plan().unwrap().estimators.len(), 1);
        let refused = named("torsion").plan().unwrap_err().to_string();
        assert!(refused.contains("integration, rotation; torsion needs --period-s"), "{refused}");
    }

    #[test]
    fn a_scenario_gives_its_estimators_and_its_averaging() {
        let text = include_str!("../../scenarios/demo.toml").to_owned();
        let scenario = Some(ScenarioText { path: PathBuf::from("demo.toml"), text });
        let plan = Setup::new(None, scenario).plan().unwrap();
        assert_eq!((plan.estimators.len(), plan.averaging_samples), (4, 3));
        assert_eq!(plan.frame.name(), "struna/vg910d@1", "the scenario's own");
        assert!(Setup::new(None, None).plan().is_err());
    }

    #[test]
    fn a_setup_survives_its_file() {
        let written = Setup { latency_s: 1.25e-4, torsion_period_s: Some(0.1), ..setup() };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("setup.json");
        std::fs::write(&path, written.to_json().unwrap()).unwrap();
        assert_eq!(Setup::read(&path).unwrap(), written);
        std::fs::write(&path, "{}").unwrap();
        assert!(Setup::read(&path).is_err());
    }

    #[test]
    fn numbers_out_of_range_are_refused() {
        for bad in [
            Setup { latency_s: f64::NAN, ..setup() },
            Setup { latency_s: 11.0, ..setup() },
            Setup { averaging_samples: Some(0), ..setup() },
            Setup { torsion_period_s: Some(-1.0), ..setup() },
            Setup { angle_start_deg: f64::INFINITY, ..setup() },
        ] {
            assert!(bad.plan().is_err(), "{bad:?}");
        }
    }
}
