//! One run of a case: all its estimators on the same measurements.

use super::bound::{Bound, Information};
use super::contestant::Kind;
use super::row::{Column, Row};
use super::suite::{Case, RunId};
use super::tally::Tally;
use super::torsion::{Drawn, Ensemble, STEP_S, WhiteGyro};
use anyhow::Result;
use struna_estimator::AugmentedConfig;
use struna_kernel::RAD_PER_DEG;

/// The torsional rig with an ideal gyro, and estimators on it.
#[derive(Debug, Clone)]
pub(super) struct TorsionCase {
    /// Suite of the rows.
    pub(super) suite: &'static str,
    /// Name.
    pub(super) name: String,
    /// What is drawn.
    pub(super) ensemble: Ensemble,
    /// Who watches.
    pub(super) kinds: Vec<Kind>,
    /// Whether the least possible error is worked out, too. With kicks there is none.
    pub(super) bounded: bool,
}

impl Case for TorsionCase {
    fn name(&self) -> &str {
        &self.name
    }

    fn estimators(&self) -> Vec<String> {
        self.kinds.iter().map(|kind| kind.name()).collect()
    }

    fn run(&self, id: RunId) -> Result<Vec<Row>> {
        let mut drawn = self.ensemble.draw(id.seed, id.run)?;
        let mut gyro = WhiteGyro::new(&self.ensemble, &drawn, id.seed, id.run);
        let config = self.ensemble.config(drawn.believed_start_deg(), self.ensemble.r_rad2_s2);
        let samples = self.ensemble.samples();
        let mut bound = self.bounded.then(|| Bound::new(&config, samples));
        let information = Information::White(self.ensemble.r_rad2_s2);
        let mut tallies = self.tallies(id, &drawn, &config)?;
        let mut before = drawn.truth(0);
        for k in 1..=samples {
            let truth = drawn.truth(k);
            let measured = gyro.measure(k, truth.state.rate_rad_s);
            for tally in &mut tallies {
                tally.step(k, &measured, &truth);
            }
            if let Some(bound) = &mut bound {
                bound.step(k, &before.state, &information);
            }
            before = truth;
        }
        let mut rows: Vec<Row> = tallies.into_iter().map(|tally| tally.finish(STEP_S)).collect();
        if let Some(bound) = &bound {
            rows.iter_mut().for_each(|row| bound.describe(row));
        }
        Ok(rows)
    }
}

impl TorsionCase {
    fn tallies(&self, id: RunId, drawn: &Drawn, config: &AugmentedConfig) -> Result<Vec<Tally>> {
        let tally = |kind: &Kind| {
            let mut row = id.row(self.suite, &self.name, &kind.name());
            drawn.describe(&mut row);
            row.set(Column::NoiseDegS, self.ensemble.r_rad2_s2.sqrt() / RAD_PER_DEG);
            row.set(Column::OutlierShare, self.ensemble.outlier_share);
            describe_estimator(&mut row, *kind, config);
            Ok(Tally::new(row, kind.make(config)?, drawn.schedule()))
        };
        self.kinds.iter().map(tally).collect()
    }
}

/// Writes what the estimator was told of the noise into a row.
pub(super) fn describe_estimator(row: &mut Row, kind: Kind, config: &AugmentedConfig) {
    let noise_rad_s = config.measurement_variance_rad2_s2.sqrt();
    row.set(Column::BelievedNoiseDegS, noise_rad_s / RAD_PER_DEG);
    if let Some(samples) = kind.refinement_samples() {
        row.set(Column::RefinementSamples, f64::from(samples));
    }
}
