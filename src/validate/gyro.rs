//! Suite `gyro`: gyros that average, round, clip, drift and colour their noise, and what an
//! estimator must be told of that.

use super::bound::Information;
use super::contestant::Measured;
use super::entrant::{Entrant, Field, Noise, describe_noise};
use super::requirement::{Requirement, Statistic, honest_nees};
use super::row::{Column, Row};
use super::suite::{Case, Figure, RunId, Suite};
use super::torsion::{Ensemble, R_RAD2_S2, SAMPLES, STEP_S};
use crate::figure::FigureError;
use crate::validate::figures;
use anyhow::{Context, Result};
use struna_estimator::{GyroRange, Quantiser, measurement_variance_from_rest};
use struna_gyro::{DriftParams, Gyro, GyroParams, Response, ScaleFactor};
use struna_kernel::RAD_PER_DEG;

const NAME: &str = "gyro";

/// One count of a 12-bit gyro of ±500 °/s, deg/s.
const COARSE_LSB_DEG_S: f64 = 300.0 / 1230.0;
/// One count of the 24-bit gyro, deg/s: 2⁻¹⁵.
const FINE_LSB_DEG_S: f64 = 1.0 / 32_768.0;
/// Noise of the MEMS chain, deg/√s: 8e-3 (deg/s)² when 14 samples at 1400 Hz are averaged behind
/// its 40 Hz filter and before rounding.
const MEMS_WALK_DEG_SQRT_S: f64 = 0.0108;
/// Variance that is stated of it, rad²/s².
const MEMS_R_RAD2_S2: f64 = 8e-3 * RAD_PER_DEG * RAD_PER_DEG;
/// Where the clipped gyro clips, deg/s; the body turns at up to 4.7.
const CLIP_DEG_S: f64 = 3.5;
/// Samples of the record at rest.
const REST_SAMPLES: u32 = 20_000;

/// One gyro and those who are told different things of it.
struct GyroCase {
    name: &'static str,
    params: GyroParams,
    /// Gyro samples in a measured rate.
    averaged: u32,
    /// Density of the bias's walk, deg/s/√s: with it there is no constant to weigh a state against.
    bias_walk_deg_s_sqrt_s: f64,
    entrants: Vec<Entrant>,
}

impl GyroCase {
    /// A gyro of 300 Hz whose mean of three samples has the rig's own noise.
    fn new(name: &'static str) -> Self {
        // Counts so fine that rounding is nothing, and a range beyond the body's 4.7 deg/s.
        let (lsb_deg_s, rate_max_deg_s) = (FINE_LSB_DEG_S * 1e-3, 50.0);
        let exact = GyroParams::exact(300.0, 0.0, 0.0, i32::MAX);
        let noisy =
            GyroParams { angle_random_walk_rad_sqrt_s: (R_RAD2_S2 * STEP_S).sqrt(), ..exact };
        let params = with_output(noisy, lsb_deg_s, rate_max_deg_s);
        let entrants = vec![Entrant::PLAIN];
        Self { name, params, averaged: 3, bias_walk_deg_s_sqrt_s: 0.0, entrants }
    }

    /// What the resting gyro shows its estimators.
    fn rest_rad2_s2(&self, id: RunId, bias_rad_s: f64) -> Result<f64> {
        // A record of its own: the noise of the run is not known before it.
        let mut gyro =
            Gyro::new(self.params_of(bias_rad_s), id.seed, REST_RUN + u64::from(id.run))?;
        let record: Vec<f64> =
            (0..REST_SAMPLES).map(|_| self.mean(&mut gyro, &mut |_| 0.0).rate_rad_s).collect();
        Ok(measurement_variance_from_rest(&record)?)
    }

    /// What a mean of samples can tell. Noise before rounding can only hide more, so it stands for
    /// all where counts are fine or its colour leaves no other form.
    fn information(&self) -> Information {
        let GyroParams { lsb_rad_s, angle_random_walk_rad_sqrt_s, .. } = self.params;
        let sigma_rad_s = self.params.noise_sigma_rad_s();
        if !self.params.response.noise_before_filter && sigma_rad_s < 5.0 * lsb_rad_s {
            return Information::Counts { lsb_rad_s, sigma_rad_s, samples: self.averaged };
        }
        Information::White(angle_random_walk_rad_sqrt_s.powi(2) / STEP_S)
    }

    fn params_of(&self, bias_rad_s: f64) -> GyroParams {
        GyroParams { bias_rad_s, ..self.params }
    }

    /// The mean of the gyro's next samples; `rate` gives the mean rate over each part.
    fn mean(&self, gyro: &mut Gyro, rate: &mut dyn FnMut(u32) -> f64) -> Measured {
        let (mut counts, mut over_range) = (0.0, false);
        for part in 0..self.averaged {
            let reading = gyro.sample(rate(part));
            counts += f64::from(reading.counts.0);
            over_range |= reading.flags.over_range;
        }
        let rate_rad_s = counts / f64::from(self.averaged) * self.params.lsb_rad_s;
        Measured { over_range, ..Measured::mean(STEP_S, STEP_S, rate_rad_s) }
    }

    fn describe(&self, row: &mut Row) {
        let params = &self.params;
        describe_noise(row, params.noise_sigma_rad_s() / RAD_PER_DEG, self.averaged);
        row.set(Column::LsbDegS, params.lsb_rad_s / RAD_PER_DEG);
        row.set(Column::BiasWalkDegSSqrtS, self.bias_walk_deg_s_sqrt_s);
        row.set(Column::RangeDegS, params.rate_max_rad_s / RAD_PER_DEG);
    }
}

/// Runs of records at rest are numbered apart from those of campaigns.
const REST_RUN: u64 = 1 << 32;

impl Case for GyroCase {
    fn name(&self) -> &str {
        self.name
    }

    fn estimators(&self) -> Vec<String> {
        self.entrants.iter().map(|entrant| entrant.name.to_owned()).collect()
    }

    fn run(&self, id: RunId) -> Result<Vec<Row>> {
        let ensemble = Ensemble::B;
        let mut drawn = ensemble.draw(id.seed, id.run)?;
        let params = self.params_of(drawn.bias_rad_s());
        let mut gyro = Gyro::new(params, id.seed, u64::from(id.run))?;
        let needs_rest = self.entrants.iter().any(|entrant| entrant.noise == Noise::Rest);
        let rest_rad2_s2 = if needs_rest {
            self.rest_rad2_s2(id, drawn.bias_rad_s()).context("the record at rest")?
        } else {
            R_RAD2_S2
        };
        let of = (&ensemble, &mut drawn);
        let describe = |row: &mut Row| self.describe(row);
        let noise = (rest_rad2_s2, self.information());
        let mut field = Field::new(id, (NAME, self.name), &self.entrants, of, noise, &describe)?;
        let (mut place, mut angle_rad) = (0.0, drawn.motion_between(0.0).0);
        let part_samples = 1.0 / f64::from(self.averaged);
        for k in 1..=SAMPLES {
            let measured = self.mean(&mut gyro, &mut |part| {
                place = f64::from(k - 1) + f64::from(part + 1) * part_samples;
                let before_rad = std::mem::replace(&mut angle_rad, drawn.motion_between(place).0);
                (angle_rad - before_rad) / (part_samples * STEP_S)
            });
            let mut truth = drawn.truth(k);
            truth.settled &= self.bias_walk_deg_s_sqrt_s == 0.0;
            field.step(k, &measured, &truth);
        }
        Ok(field.finish(&|_| {}))
    }
}

/// The suite.
pub(super) fn suite() -> Suite {
    let cases = vec![
        GyroCase::new(MEAN),
        fine(),
        coarse(),
        scale(),
        clipped(),
        walking(WALK_SLOW, 1e-4),
        walking(WALK_FAST, 1e-3),
        mems(),
    ];
    Suite {
        name: NAME,
        about: "Scenario B with gyros as they are: means of three samples, counts of 24 and of 12 \
                bits, a scale factor wrong by 1 %, clipping, a bias that walks, and a MEMS chain \
                with a 40 Hz filter before its rounding. Each with an estimator that is told, and \
                most with one that is not.",
        runs: 2000,
        cases: cases.into_iter().map(|case| Box::new(case) as Box<dyn Case>).collect(),
        requirements: requirements(),
        draw,
    }
}

const MEAN: &str = "mean of three";
const FINE: &str = "24-bit counts";
const COARSE: &str = "12-bit counts, little noise";
const SCALE: &str = "scale factor 1 %";
const CLIPPED: &str = "clipped at 3.5 deg/s";
const WALK_SLOW: &str = "bias walks 1e-4 deg/s/sqrt s";
const WALK_FAST: &str = "bias walks 1e-3 deg/s/sqrt s";
const MEMS: &str = "MEMS chain";
const NOT_TOLD: &str = "not told";
const TOLD: &str = "told";
const R_RULE: &str = "R from rest";

fn fine() -> GyroCase {
    let case = GyroCase::new(FINE);
    GyroCase { params: with_output(case.params, FINE_LSB_DEG_S, 200.0), ..case }
}

fn coarse() -> GyroCase {
    let case = GyroCase::new(COARSE);
    let params = with_output(case.params, COARSE_LSB_DEG_S, 300.0);
    // 0.32 counts of noise: steps this coarse are not dithered away.
    let quantiser = Some(Quantiser {
        step_rad_s: params.lsb_rad_s,
        raw_sigma_rad_s: params.noise_sigma_rad_s(),
        samples: case.averaged,
    });
    let told = Entrant { name: TOLD, quantiser, ..Entrant::PLAIN };
    let not_told = Entrant { name: NOT_TOLD, ..Entrant::PLAIN };
    GyroCase { params, entrants: vec![told, not_told], ..case }
}

fn scale() -> GyroCase {
    let case = GyroCase::new(SCALE);
    let sigma = 0.01;
    let scale = ScaleFactor { turn_on_sigma: sigma, ..ScaleFactor::default() };
    let told = Entrant { name: TOLD, scale_factor_sigma: sigma, ..Entrant::PLAIN };
    let not_told = Entrant { name: NOT_TOLD, ..Entrant::PLAIN };
    let params = GyroParams { scale, ..case.params };
    GyroCase { params, entrants: vec![told, not_told], ..case }
}

fn clipped() -> GyroCase {
    let case = GyroCase::new(CLIPPED);
    let params = with_output(case.params, FINE_LSB_DEG_S, CLIP_DEG_S);
    let raw_rad_s = params.noise_sigma_rad_s();
    let range = Some(GyroRange::with_raw_sigma(CLIP_DEG_S * RAD_PER_DEG, raw_rad_s));
    let told = Entrant { name: TOLD, range, ..Entrant::PLAIN };
    let not_told = Entrant { name: NOT_TOLD, ..Entrant::PLAIN };
    GyroCase { params, entrants: vec![told, not_told], ..case }
}

fn walking(name: &'static str, walk_deg_s_sqrt_s: f64) -> GyroCase {
    let case = GyroCase::new(name);
    let walk = walk_deg_s_sqrt_s * RAD_PER_DEG;
    let drift = DriftParams { rate_random_walk_rad_s_sqrt_s: walk, ..DriftParams::default() };
    let told = Entrant { name: TOLD, bias_walk_rad_s_sqrt_s: walk, ..Entrant::PLAIN };
    GyroCase {
        params: GyroParams { drift, ..case.params },
        bias_walk_deg_s_sqrt_s: walk_deg_s_sqrt_s,
        entrants: vec![told],
        ..case
    }
}

fn mems() -> GyroCase {
    let response =
        Response { natural_frequency_hz: 40.0, noise_before_filter: true, ..Response::default() };
    let lsb_rad_s = COARSE_LSB_DEG_S * RAD_PER_DEG;
    let params = GyroParams {
        response,
        angle_random_walk_rad_sqrt_s: MEMS_WALK_DEG_SQRT_S * RAD_PER_DEG,
        ..GyroParams::exact(1400.0, 300.0 * RAD_PER_DEG, lsb_rad_s, 2047)
    };
    let rule = Entrant { name: R_RULE, noise: Noise::Rest, ..Entrant::PLAIN };
    let stated =
        Entrant { name: "R as stated", noise: Noise::Variance(MEMS_R_RAD2_S2), ..Entrant::PLAIN };
    let entrants = vec![rule, stated];
    GyroCase { params, averaged: 14, entrants, ..GyroCase::new(MEMS) }
}

/// The same gyro with an output of its own, deg/s.
fn with_output(params: GyroParams, lsb_deg_s: f64, rate_max_deg_s: f64) -> GyroParams {
    GyroParams {
        lsb_rad_s: lsb_deg_s * RAD_PER_DEG,
        rate_max_rad_s: rate_max_deg_s * RAD_PER_DEG,
        counts_max: i32::MAX,
        ..params
    }
}

fn requirements() -> Vec<Requirement> {
    let ratio = Statistic::RmsOver(Column::AngleHalf2Deg, Column::BoundAngleDeg);
    let beyond = Statistic::ShareAbove(Column::EndSigmas, 3.0);
    let half2 = Statistic::Rms(Column::AngleHalf2Deg);
    let alarms = Statistic::CountAnHour(Column::Alarms);
    let plain = Entrant::PLAIN.name;
    let white = [(MEAN, plain), (FINE, plain)];
    // What they reckon with is the samples' own noise: a claim is neither bold nor cautious.
    let honest = [(MEAN, plain), (FINE, plain), (COARSE, TOLD)];
    // Its R is larger than what the samples have: a claim may be too cautious, never too bold.
    let cautious = [(MEMS, R_RULE)];
    let walking = [(WALK_SLOW, TOLD), (WALK_FAST, TOLD)];
    // No filter that knows of one gyro alone can find its scale factor or what was clipped.
    let unbounded = [(SCALE, TOLD), (CLIPPED, TOLD)];
    let mut all = vec![Requirement::new((CLIPPED, TOLD), half2, 0.0..=1.5)];
    for cell in honest.into_iter().chain(cautious).chain(walking) {
        all.push(Requirement::new(cell, ratio, 0.6..=1.15));
    }
    for cell in honest.into_iter().chain(cautious).chain(walking).chain(unbounded) {
        all.push(Requirement::new(cell, beyond, 0.0..=0.03));
    }
    let most = *honest_nees(5.0).end();
    all.extend(honest.map(|cell| Requirement::new(cell, Statistic::Nees, honest_nees(5.0))));
    all.extend(cautious.map(|cell| Requirement::new(cell, Statistic::Nees, 0.0..=most)));
    for cell in white.into_iter().chain([(MEMS, R_RULE)]) {
        all.push(Requirement::new(cell, alarms, 0.0..=2.0));
    }
    let control = |cell, statistic, range| Requirement::new(cell, statistic, range).as_control();
    let stated = (MEMS, "R as stated");
    all.extend([
        control((COARSE, NOT_TOLD), beyond, 0.2..=1.0),
        control((SCALE, NOT_TOLD), beyond, 0.5..=1.0),
        control((CLIPPED, NOT_TOLD), half2, 10.0..=f64::INFINITY),
        control(stated, Statistic::Count(Column::Alarms), 1.0..=f64::INFINITY),
        control(stated, Statistic::Nees, 7.0..=f64::INFINITY),
    ]);
    all
}

fn draw(rows: &[&Row]) -> Result<Vec<Figure>, FigureError> {
    let mut all = vec![figures::bars(
        rows,
        &figures::Bars {
            title: "RMS of the angle over the second half, by gyro",
            column: Column::AngleHalf2Deg,
            bound: Some(Column::BoundAngleDeg),
            axis: "deg",
        },
    )?];
    all.push(figures::claims(rows, "Error at the end in claimed standard deviations")?);
    for cell in [(MEMS, R_RULE), (MEMS, "R as stated"), (SCALE, TOLD)] {
        let title = format!("Angle error against claim: {}, {}", cell.0, cell.1);
        all.extend(figures::fan(rows, &title, cell)?);
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use struna_kernel::Seed;

    #[test]
    fn the_mems_chain_has_the_noise_that_is_stated_of_it() {
        let mut case = mems();
        case.params = with_output(case.params, 1e-6, 300.0);
        let mut gyro = Gyro::new(case.params, Seed(1), 0).unwrap();
        let n = 40_000;
        let square = |gyro: &mut Gyro| case.mean(gyro, &mut |_| 0.0).rate_rad_s.powi(2);
        let variance = (0..n).map(|_| square(&mut gyro)).sum::<f64>() / f64::from(n);
        // Scatter of a variance: √(2/n)·1.2 for the correlation, 0.8 %.
        assert!((variance / MEMS_R_RAD2_S2 - 1.0).abs() < 0.04, "{}", variance / MEMS_R_RAD2_S2);
    }

    #[test]
    fn the_mean_of_three_has_the_noise_of_the_rig() {
        let case = GyroCase::new(MEAN);
        let mut gyro = Gyro::new(case.params, Seed(1), 0).unwrap();
        let n = 40_000;
        let square = |gyro: &mut Gyro| case.mean(gyro, &mut |_| 0.0).rate_rad_s.powi(2);
        let variance = (0..n).map(|_| square(&mut gyro)).sum::<f64>() / f64::from(n);
        assert!((variance / R_RAD2_S2 - 1.0).abs() < 0.03, "{}", variance / R_RAD2_S2);
    }
}
