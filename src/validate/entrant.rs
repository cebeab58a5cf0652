//! Estimators told different things of the same rates, beside the bound for what these can tell.

use super::bound::{Bound, Information};
use super::contestant::{Kind, Measured, TrueState};
use super::race::describe_estimator;
use super::row::{Column, Row};
use super::suite::RunId;
use super::tally::{Schedule, Tally, Truth};
use super::torsion::{Drawn, Ensemble, R_RAD2_S2, STEP_S};
use anyhow::Result;
use struna_estimator::{AugmentedConfig, GyroRange, Quantiser};

/// An estimator and what it is told of the gyro besides the ensemble.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Entrant {
    /// Name in tables.
    pub(super) name: &'static str,
    /// Which.
    pub(super) kind: Kind,
    /// Where its R comes from.
    pub(super) noise: Noise,
    /// Density of the bias's random walk, rad/s/√s.
    pub(super) bias_walk_rad_s_sqrt_s: f64,
    /// Spread of the scale factor.
    pub(super) scale_factor_sigma: f64,
    /// Where the gyro clips; an estimator that is not told does not get the gyro's flags either.
    pub(super) range: Option<GyroRange>,
    /// How coarsely the gyro counts.
    pub(super) quantiser: Option<Quantiser>,
}

/// Where an estimator's R comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Noise {
    /// A variance, rad²/s².
    Variance(f64),
    /// A record of the resting gyro.
    Rest,
}

impl Entrant {
    /// The tested five-state filter with the rig's own R, told of nothing else.
    pub(super) const PLAIN: Self = Self {
        name: "EKF5a+test",
        kind: Kind::Tested,
        noise: Noise::Variance(R_RAD2_S2),
        bias_walk_rad_s_sqrt_s: 0.0,
        scale_factor_sigma: 0.0,
        range: None,
        quantiser: None,
    };

    /// What it is told; `rest_rad2_s2` is the R of the record at rest.
    fn config(&self, ensemble: &Ensemble, start_deg: f64, rest_rad2_s2: f64) -> AugmentedConfig {
        let r = match self.noise {
            Noise::Variance(r) => r,
            Noise::Rest => rest_rad2_s2,
        };
        let told = ensemble.config(start_deg, r);
        AugmentedConfig {
            bias_walk_rad2_s3: told.bias_walk_rad2_s3 + self.bias_walk_rad_s_sqrt_s.powi(2),
            scale_factor_sigma: self.scale_factor_sigma,
            range: self.range,
            quantiser: self.quantiser,
            ..told
        }
    }
}

/// Entrants on their way through a run.
#[derive(Debug)]
pub(super) struct Field {
    entrants: Vec<(Entrant, Tally, Bound)>,
    schedule: Schedule,
    information: Information,
    /// Truth at the sample that the bounds have come to.
    before: TrueState,
    at: u32,
}

impl Field {
    /// All at the start of a run; `describe` adds what is known of the gyro to each row,
    /// `information` is what each measured rate can tell.
    ///
    /// # Errors
    /// When an estimator cannot work with what it is told.
    pub(super) fn new(
        id: RunId,
        (suite, case): (&'static str, &str),
        entrants: &[Entrant],
        (ensemble, drawn): (&Ensemble, &mut Drawn),
        (rest_rad2_s2, information): (f64, Information),
        describe: &dyn Fn(&mut Row),
    ) -> Result<Self> {
        let schedule = drawn.schedule();
        let make = |entrant: &Entrant| {
            let config = entrant.config(ensemble, drawn.believed_start_deg(), rest_rad2_s2);
            let mut row = id.row(suite, case, entrant.name);
            drawn.describe(&mut row);
            describe_estimator(&mut row, entrant.kind, &config);
            describe(&mut row);
            let tally = Tally::new(row, entrant.kind.make(&config)?, schedule);
            Ok((*entrant, tally, Bound::new(&config, schedule.samples)))
        };
        let entrants = entrants.iter().map(make).collect::<Result<Vec<_>>>()?;
        Ok(Self { entrants, schedule, information, before: drawn.truth(0).state, at: 0 })
    }

    /// A measurement that ends at sample `k` of the grid; samples before it may be missing.
    pub(super) fn step(&mut self, k: u32, measured: &Measured, truth: &Truth) {
        for (entrant, tally, bound) in &mut self.entrants {
            let over_range = measured.over_range && entrant.range.is_some();
            tally.step(k, &Measured { over_range, ..*measured }, truth);
            // As if nothing were missing: what is lost is part of what is asked.
            for at in self.at + 1..=k.min(self.schedule.samples) {
                bound.step(at, &self.before, &self.information);
            }
        }
        (self.before, self.at) = (truth.state, k);
    }

    /// The rows, with the bounds in them.
    pub(super) fn finish(self, describe: &dyn Fn(&mut Row)) -> Vec<Row> {
        let finish = |(_, tally, bound): (Entrant, Tally, Bound)| {
            let mut row = tally.finish(STEP_S);
            bound.describe(&mut row);
            describe(&mut row);
            row
        };
        self.entrants.into_iter().map(finish).collect()
    }
}

/// Writes a standard deviation of the gyro's noise into a row, deg/s.
pub(super) fn describe_noise(row: &mut Row, sigma_deg_s: f64, averaged: u32) {
    row.set(Column::NoiseDegS, sigma_deg_s);
    row.set(Column::AveragedSamples, f64::from(averaged));
}
