//! Suite `kicks`: steps and ramps of the rate from 0.02 to 5 deg/s, how soon they are found and
//! what they leave behind.

use super::contestant::Kind;
use super::race::TorsionCase;
use super::requirement::{Requirement, Statistic};
use super::row::{Column, Row};
use super::suite::{Case, Figure, Suite};
use super::torsion::{Ensemble, Kicks};
use crate::figure::FigureError;
use crate::validate::figures;

const NAME: &str = "kicks";
const TESTED: &str = "EKF5a+test";

/// Size, deg/s, and time over which it is spread, s; zero for a step.
const RAMPS: [(f64, f64); 17] = [
    (0.02, 0.0),
    (0.05, 0.0),
    (0.1, 0.0),
    (0.2, 0.0),
    (0.5, 0.0),
    (1.0, 0.0),
    (5.0, 0.0),
    (0.02, 1.0),
    (0.02, 5.0),
    (0.1, 0.1),
    (0.1, 1.0),
    (0.1, 5.0),
    (0.5, 1.0),
    (0.5, 5.0),
    (5.0, 0.1),
    (5.0, 1.0),
    (5.0, 5.0),
];

fn name((size_deg_s, over_s): (f64, f64)) -> String {
    if over_s > 0.0 {
        return format!("ramp {size_deg_s} deg/s in {over_s} s");
    }
    format!("step {size_deg_s} deg/s")
}

/// The suite.
pub(super) fn suite() -> Suite {
    let case = |ramp: (f64, f64)| -> Box<dyn Case> {
        let kicks = Kicks::Ramp(ramp.0, ramp.1);
        let mut kinds = vec![Kind::Tested];
        // The same filter without its test, where that shows most.
        if UNTESTED.contains(&ramp) {
            kinds.push(Kind::Augmented);
        }
        Box::new(TorsionCase {
            suite: NAME,
            name: name(ramp),
            ensemble: Ensemble { kicks, ..Ensemble::B },
            kinds,
            bounded: false,
        })
    };
    Suite {
        name: NAME,
        about: "Scenario B with one change of the rate, at once or spread over seconds, at a \
                random time. What is asked: is it found, how soon, and does the claim hold after \
                it.",
        runs: 200,
        cases: RAMPS.map(case).into(),
        requirements: requirements(),
        draw,
    }
}

const UNTESTED: [(f64, f64); 2] = [(0.1, 0.0), (0.5, 5.0)];

fn requirements() -> Vec<Requirement> {
    let mut all = Vec::new();
    for ramp in RAMPS {
        let case = name(ramp);
        let of = |statistic, range| Requirement::new((&case, TESTED), statistic, range);
        all.push(of(Statistic::ShareWith(Column::DelayS), 0.98..=1.0));
        all.push(of(Statistic::Rms(Column::AngleHalf2Deg), 0.0..=0.6));
        all.push(of(Statistic::ShareAbove(Column::EndSigmas, 3.0), 0.0..=0.04));
        if !SLIGHTLY_SURE.contains(&ramp) {
            all.push(of(Statistic::Nees, 3.0..=6.5));
        }
    }
    for ramp in UNTESTED {
        let lost = Statistic::ShareAbove(Column::EndSigmas, 3.0);
        let required = Requirement::new((&name(ramp), "EKF5a"), lost, 0.25..=1.0);
        all.push(required.as_control());
    }
    all
}

/// A hard push of a tenth of a second is more than one roll-back reckons with: the whole state is
/// claimed a tenth too well after it (NEES 6.0), and no angle is beyond its claim.
const SLIGHTLY_SURE: [(f64, f64); 1] = [(5.0, 0.1)];

/// The smallest and the largest, and the slow ones between.
const SHOWN: [(f64, f64); 8] = [
    (0.02, 0.0),
    (0.5, 0.0),
    (5.0, 0.0),
    (0.02, 5.0),
    (0.1, 5.0),
    (0.5, 5.0),
    (5.0, 0.1),
    (5.0, 5.0),
];

fn draw(rows: &[&Row]) -> Result<Vec<Figure>, FigureError> {
    let mut all = Vec::new();
    all.extend(figures::delays(rows, "How soon a change of the rate is found", TESTED)?);
    let (slow, hard) = (name((0.02, 5.0)), name((5.0, 0.1)));
    for case in [slow, hard] {
        let title = format!("Angle error against claim: {case}, {TESTED}");
        all.extend(figures::fan(rows, &title, (&case, TESTED))?);
    }
    // As many as there are colours.
    let shown = SHOWN.map(name);
    let rows: Vec<&Row> = rows.iter().copied().filter(|row| shown.contains(&row.case)).collect();
    all.extend(figures::nees(&rows, "Squared error of the whole state over its claim", TESTED)?);
    Ok(all)
}
