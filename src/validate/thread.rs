//! Suite `thread`: a thread that loses energy to hysteresis, the bank of filters that reckons with
//! it, and the one that does not.

use super::contestant::{Kind, Measured, Single, TrueState};
use super::race::describe_estimator;
use super::requirement::{Requirement, Statistic};
use super::row::{Column, Row};
use super::suite::{Case, Figure, RunId, Suite};
use super::tally::{Schedule, Tally, Truth};
use super::torsion::{PERIOD_S, R_RAD2_S2, SAMPLES, START_DEG, STEP_S};
use crate::figure::FigureError;
use crate::validate::figures;
use anyhow::Result;
use std::f64::consts::TAU;
use struna_body::{
    Body, BodyParams, Hysteresis, Integrator, Rig, StartState, Torsion, TorsionDamping,
    TorsionStiffness, TruthMotion, YieldElement, YieldLaw, reference,
};
use struna_estimator::{AugmentedConfig, HysteresisBank, StartPrior};
use struna_kernel::{AddressedRandom, Channel, RAD_PER_DEG, SampleGrid, SimTime};

const NAME: &str = "thread";
const BANK: &str = "hysteresis bank";
const TESTED: &str = "EKF5a+test";
/// Stiffness of the friction before it yields over the thread's.
const STIFFNESS_RATIO: f64 = 10.0;
/// Yield angles, deg.
const YIELDS_DEG: [f64; 4] = [0.0, 10.0, 25.0, 50.0];

struct ThreadCase {
    name: String,
    yield_deg: f64,
}

fn name(yield_deg: f64) -> String {
    if yield_deg > 0.0 { format!("yields at {yield_deg} deg") } else { "no hysteresis".to_owned() }
}

/// What is drawn for a run.
struct Draw {
    period_s: f64,
    damping_ratio: f64,
    bias_rad_s: f64,
    start_error_deg: f64,
}

impl Draw {
    fn of(id: RunId) -> Self {
        let mut draws = AddressedRandom::new(id.seed, Channel::StartError, u64::from(id.run));
        let mut n = |k| draws.standard_normal(k);
        Self {
            period_s: PERIOD_S * (1.0 + 0.01 * n(1)),
            damping_ratio: (0.01 + 0.003 * n(2)).max(0.0),
            bias_rad_s: 0.05 * n(3) * RAD_PER_DEG,
            start_error_deg: 100.0 * n(4),
        }
    }

    /// What estimators are told: the ensemble, and the start as it is believed.
    fn config(&self) -> AugmentedConfig {
        let start_rad = (START_DEG + self.start_error_deg) * RAD_PER_DEG;
        let start = StartPrior {
            damping_ratio: 0.01,
            damping_ratio_sigma: 0.003,
            ..StartPrior::released(start_rad, PERIOD_S)
        };
        AugmentedConfig::quiet(start, R_RAD2_S2)
    }

    fn motion(&self, yield_deg: f64) -> Result<TruthMotion> {
        let torsion = Torsion {
            stiffness: TorsionStiffness::PeriodS(self.period_s),
            damping: TorsionDamping::Ratio(self.damping_ratio),
        };
        let body = Body::new(&BodyParams { torsion, ..reference::PARAMS })?;
        let element = YieldElement {
            stiffness_n_m_rad: STIFFNESS_RATIO * body.stiffness_n_m_rad(),
            yield_rad: yield_deg / STIFFNESS_RATIO * RAD_PER_DEG,
        };
        let hysteresis =
            (yield_deg > 0.0).then(|| Hysteresis { law: YieldLaw::Dahl, elements: vec![element] });
        let start = StartState::twisted(START_DEG * RAD_PER_DEG, 0.0);
        let rig = Rig { hysteresis, ..Rig::from(body) };
        // Steps of 10 ms hold 1e-6 rad over these runs, a thousandth of what is asked for.
        Ok(TruthMotion::new(rig, &start, Integrator::Rk4 { step_s: STEP_S })?)
    }

    fn describe(&self, row: &mut Row, yield_deg: f64) {
        row.set(Column::DurationS, f64::from(SAMPLES) * STEP_S);
        row.set(Column::PeriodS, self.period_s);
        row.set(Column::DampingRatio, self.damping_ratio);
        row.set(Column::StartAngleDeg, START_DEG);
        row.set(Column::StartErrorDeg, self.start_error_deg);
        row.set(Column::BiasDegS, self.bias_rad_s / RAD_PER_DEG);
        row.set(Column::NoiseDegS, R_RAD2_S2.sqrt() / RAD_PER_DEG);
        row.set(Column::YieldDeg, yield_deg);
    }
}

const KINDS: [Kind; 2] = [Kind::Integration, Kind::Tested];

impl Case for ThreadCase {
    fn name(&self) -> &str {
        &self.name
    }

    fn estimators(&self) -> Vec<String> {
        KINDS.iter().map(|kind| kind.name()).chain([BANK.to_owned()]).collect()
    }

    fn run(&self, id: RunId) -> Result<Vec<Row>> {
        let draw = Draw::of(id);
        let config = draw.config();
        let schedule = Schedule { samples: SAMPLES, kick: None };
        let row = |estimator: &str| {
            let mut row = id.row(NAME, &self.name, estimator);
            draw.describe(&mut row, self.yield_deg);
            row
        };
        let mut tallies = Vec::new();
        for kind in KINDS {
            let mut row = row(&kind.name());
            describe_estimator(&mut row, kind, &config);
            tallies.push(Tally::new(row, kind.make(&config)?, schedule));
        }
        let bank = Box::new(Single(HysteresisBank::new(&config)?));
        tallies.push(Tally::new(row(BANK), bank, schedule));
        let mut motion = draw.motion(self.yield_deg)?;
        let mut noise =
            AddressedRandom::new(id.seed, Channel::GyroAngleRandomWalk, u64::from(id.run));
        let grid = SampleGrid::new(SimTime::ZERO, 1.0 / STEP_S)?;
        let omega = TAU / draw.period_s;
        for k in 1..=SAMPLES {
            let now = motion.motion_at(grid.time_of(u64::from(k)))?;
            let noise_rad_s = R_RAD2_S2.sqrt() * noise.standard_normal(u64::from(k));
            let rate_rad_s = now.twist_rate_rad_s + draw.bias_rad_s + noise_rad_s;
            let measured = Measured::new(STEP_S, rate_rad_s);
            let state = TrueState {
                angle_rad: now.twist_rad,
                rate_rad_s: now.twist_rate_rad_s,
                s: omega * omega,
                d: 2.0 * draw.damping_ratio * omega,
                bias_rad_s: draw.bias_rad_s,
            };
            let truth = Truth { state, settled: true };
            tallies.iter_mut().for_each(|tally| tally.step(k, &measured, &truth));
        }
        Ok(tallies.into_iter().map(|tally| tally.finish(STEP_S)).collect())
    }
}

/// The suite.
pub(super) fn suite() -> Suite {
    let case = |yield_deg: f64| -> Box<dyn Case> {
        Box::new(ThreadCase { name: name(yield_deg), yield_deg })
    };
    Suite {
        name: NAME,
        about: "Scenario B on a thread with friction inside, after Dahl: ten times as stiff as the \
                thread until it yields. The bank of hysteresis filters must hold its claim; the \
                five-state filter must say by its alarms that it cannot.",
        runs: 160,
        cases: YIELDS_DEG.map(case).into(),
        requirements: requirements(),
        draw,
    }
}

fn requirements() -> Vec<Requirement> {
    let mut all = Vec::new();
    for yield_deg in YIELDS_DEG {
        let case = name(yield_deg);
        let bank = |statistic, range| Requirement::new((&case, BANK), statistic, range);
        all.push(bank(Statistic::Rms(Column::AngleHalf2Deg), 0.0..=1.5));
        all.push(bank(Statistic::ShareAbove(Column::EndSigmas, 3.0), 0.0..=0.05));
        if yield_deg > 0.0 {
            let of = |statistic, range| Requirement::new((&case, TESTED), statistic, range);
            let alarms = Statistic::Count(Column::Alarms);
            all.push(of(alarms, 10.0..=f64::INFINITY).as_control());
            let wrong = Statistic::ShareAbove(Column::WorstSigmas, 3.0);
            all.push(of(wrong, 0.8..=1.0).as_control());
        }
    }
    all
}

fn draw(rows: &[&Row]) -> Result<Vec<Figure>, FigureError> {
    let mut all = vec![figures::bars(
        rows,
        &figures::Bars {
            title: "RMS of the angle over the second half, by yield angle",
            column: Column::AngleHalf2Deg,
            bound: None,
            axis: "deg",
        },
    )?];
    for estimator in [BANK, TESTED] {
        let case = name(25.0);
        let title = format!("Angle error against claim: {case}, {estimator}");
        all.extend(figures::fan(rows, &title, (&case, estimator))?);
    }
    Ok(all)
}
