//! Suite `thread`: a thread that loses energy to hysteresis, the bank of filters that reckons with
//! it, and the one that does not.

use super::contestant::{Contestant, Kind, Measured, Single, TrueState};
use super::race::describe_estimator;
use super::requirement::{Requirement, Statistic};
use super::row::{Column, Row};
use super::slip::{Slip, SlipMotion};
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
use struna_estimator::{
    AugmentedConfig, Belief, EstimatorError, HysteresisBank, Innovation, StartPrior, Status,
};
use struna_kernel::{AddressedRandom, Channel, RAD_PER_DEG, SampleGrid, SimTime};

const NAME: &str = "thread";
const BANK: &str = "hysteresis bank";
const TESTED: &str = "EKF5a+test";
/// Stiffness of the friction before it yields over the thread's.
const STIFFNESS_RATIO: f64 = 10.0;
/// Yield angles, deg.
const YIELDS_DEG: [f64; 4] = [0.0, 10.0, 25.0, 50.0];

/// Strains at which elements slip one after another, over their mean: friction of no kind that an
/// estimator has.
const SLIPS: [f64; 6] = [0.2, 0.52, 0.84, 1.16, 1.48, 1.8];
/// Yield angles of such threads, deg.
const SLIPS_DEG: [f64; 2] = [25.0, 50.0];

/// A thread.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Thread {
    /// Without friction.
    Elastic,
    /// After Dahl, yielding over so many degrees.
    Dahl(f64),
    /// Six elements that slip one after another, over so many degrees on average.
    SixSlips(f64),
}

impl Thread {
    fn dahl(yield_deg: f64) -> Self {
        if yield_deg > 0.0 { Self::Dahl(yield_deg) } else { Self::Elastic }
    }

    fn name(self) -> String {
        match self {
            Self::Elastic => "no hysteresis".to_owned(),
            Self::Dahl(yield_deg) => format!("yields at {yield_deg} deg"),
            Self::SixSlips(yield_deg) => format!("six slips about {yield_deg} deg"),
        }
    }

    fn yield_deg(self) -> f64 {
        match self {
            Self::Elastic => 0.0,
            Self::Dahl(yield_deg) | Self::SixSlips(yield_deg) => yield_deg,
        }
    }

    /// Motion of the reference body on it from rest, all friction relaxed.
    ///
    /// # Errors
    /// When the body model refuses the parameters.
    fn motion(self, period_s: f64, damping_ratio: f64) -> Result<Motion> {
        let start_rad = START_DEG * RAD_PER_DEG;
        let yield_rad = self.yield_deg() / STIFFNESS_RATIO * RAD_PER_DEG;
        if let Self::SixSlips(_) = self {
            let slip = |share: f64| Slip {
                stiffness_ratio: STIFFNESS_RATIO / SLIPS.len() as f64,
                yield_rad: share * yield_rad,
            };
            let slips = SLIPS.map(slip);
            return Ok(Motion::Slip(SlipMotion::new(period_s, damping_ratio, start_rad, &slips)));
        }
        let torsion = Torsion {
            stiffness: TorsionStiffness::PeriodS(period_s),
            damping: TorsionDamping::Ratio(damping_ratio),
        };
        let body = Body::new(&BodyParams { torsion, ..reference::PARAMS })?;
        let stiffness_n_m_rad = STIFFNESS_RATIO * body.stiffness_n_m_rad();
        let elements = vec![YieldElement { stiffness_n_m_rad, yield_rad }];
        let yields = self != Self::Elastic;
        let hysteresis = yields.then_some(Hysteresis { law: YieldLaw::Dahl, elements });
        let rig = Rig { hysteresis, ..Rig::from(body) };
        let start = StartState::twisted(start_rad, 0.0);
        // Steps of 10 ms hold 1e-6 rad over these runs, a thousandth of what is asked for.
        let motion = TruthMotion::new(rig, &start, Integrator::Rk4 { step_s: STEP_S })?;
        let grid = SampleGrid::new(SimTime::ZERO, 1.0 / STEP_S)?;
        Ok(Motion::Body(Box::new(motion), grid))
    }
}

/// The body on its thread.
enum Motion {
    /// By the body model.
    Body(Box<TruthMotion>, SampleGrid),
    /// By more elements than that has.
    Slip(SlipMotion),
}

impl Motion {
    /// Angle, rad, and rate, rad/s, at sample `k`, to be asked for in order from 1.
    fn at(&mut self, k: u32) -> Result<(f64, f64)> {
        match self {
            Self::Body(motion, grid) => {
                let now = motion.motion_at(grid.time_of(u64::from(k)))?;
                Ok((now.twist_rad, now.twist_rate_rad_s))
            }
            Self::Slip(motion) => Ok(motion.step(STEP_S)),
        }
    }
}

struct ThreadCase {
    name: String,
    thread: Thread,
}

/// The bank, asked for the yield angle as well.
struct Bank(Single<HysteresisBank>);

impl Contestant for Bank {
    fn step(&mut self, measured: &Measured) -> Result<Innovation, EstimatorError> {
        self.0.step(measured)
    }

    fn belief(&self) -> Belief {
        self.0.belief()
    }

    fn status(&self) -> Status {
        self.0.status()
    }

    fn yield_rad(&self) -> Option<f64> {
        self.0.0.leading_yield().map(|learnt| learnt.yield_angle_rad)
    }
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
            draw.describe(&mut row, self.thread.yield_deg());
            row
        };
        let mut tallies = Vec::new();
        for kind in KINDS {
            let mut row = row(&kind.name());
            describe_estimator(&mut row, kind, &config);
            tallies.push(Tally::new(row, kind.make(&config)?, schedule));
        }
        let bank = Box::new(Bank(Single(HysteresisBank::new(&config)?)));
        tallies.push(Tally::new(row(BANK), bank, schedule));
        let mut motion = self.thread.motion(draw.period_s, draw.damping_ratio)?;
        let mut noise =
            AddressedRandom::new(id.seed, Channel::GyroAngleRandomWalk, u64::from(id.run));
        let omega = TAU / draw.period_s;
        for k in 1..=SAMPLES {
            let (angle_rad, true_rad_s) = motion.at(k)?;
            let noise_rad_s = R_RAD2_S2.sqrt() * noise.standard_normal(u64::from(k));
            let measured = Measured::new(STEP_S, true_rad_s + draw.bias_rad_s + noise_rad_s);
            let state = TrueState {
                angle_rad,
                rate_rad_s: true_rad_s,
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
    let case =
        |thread: Thread| -> Box<dyn Case> { Box::new(ThreadCase { name: thread.name(), thread }) };
    let threads = YIELDS_DEG.map(Thread::dahl).into_iter().chain(SLIPS_DEG.map(Thread::SixSlips));
    Suite {
        name: NAME,
        about: "Scenario B on a thread with friction inside, after Dahl: ten times as stiff as \
                the thread until it yields. The bank of hysteresis filters must hold its \
                claim; the five-state filter must say by its alarms that it cannot. Six \
                elements that slip one after another are friction that the bank does not know: \
                it finds where they yield, and claims a little too much of the angle.",
        runs: 400,
        cases: threads.map(case).collect(),
        requirements: requirements(),
        draw,
    }
}

fn requirements() -> Vec<Requirement> {
    let half2 = Statistic::Rms(Column::AngleHalf2Deg);
    let ever = Statistic::ShareAbove(Column::WorstSigmas, 3.0);
    let found = Statistic::Median(Column::YieldFoundDeg);
    let mut all = Vec::new();
    for thread in YIELDS_DEG.map(Thread::dahl) {
        let (case, yield_deg) = (thread.name(), thread.yield_deg());
        let bank = |statistic, range| Requirement::new((&case, BANK), statistic, range);
        all.push(bank(half2, 0.0..=1.5));
        all.push(bank(Statistic::ShareAbove(Column::EndSigmas, 3.0), 0.0..=0.03));
        if thread != Thread::Elastic {
            all.push(bank(found, 0.95 * yield_deg..=1.05 * yield_deg));
            let of = |statistic, range| Requirement::new((&case, TESTED), statistic, range);
            let alarms = Statistic::Count(Column::Alarms);
            all.push(of(alarms, 10.0..=f64::INFINITY).as_control());
            all.push(of(ever, 0.8..=1.0).as_control());
        }
    }
    for thread in SLIPS_DEG.map(Thread::SixSlips) {
        let (case, yield_deg) = (thread.name(), thread.yield_deg());
        let bank = |statistic, range| Requirement::new((&case, BANK), statistic, range);
        all.push(bank(found, 0.95 * yield_deg..=1.05 * yield_deg));
        // Friction of another kind than its own is more than the bank can claim to cover.
        all.push(bank(ever, 0.03..=1.0).as_control());
    }
    let wide = Thread::SixSlips(50.0).name();
    all.push(Requirement::new((&wide, BANK), half2, 1.5..=f64::INFINITY).as_control());
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
        let case = Thread::Dahl(25.0).name();
        let title = format!("Angle error against claim: {case}, {estimator}");
        all.extend(figures::fan(rows, &title, (&case, estimator))?);
    }
    Ok(all)
}
