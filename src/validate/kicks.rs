//! Suite `kicks`: steps and ramps of the rate from 0.02 to 5 deg/s, how soon they are found and
//! what they leave behind.

use super::contestant::Kind;
use super::race::TorsionCase;
use super::requirement::{Requirement, Statistic, honest_nees};
use super::row::{Column, Row};
use super::suite::{Case, Figure, Suite};
use super::torsion::{Ensemble, Kicks, STEP_S};
use crate::figure::FigureError;
use crate::validate::figures;

const NAME: &str = "kicks";
const TESTED: &str = "EKF5a+test";

/// A change of the rate, and how soon it was found in 200 runs of the published simulation.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Ramp {
    size_deg_s: f64,
    /// Time over which it is spread, s; zero for a step.
    over_s: f64,
    /// Median of the delay from its beginning, s.
    found_after_s: f64,
}

const fn ramp(size_deg_s: f64, over_s: f64, found_after_s: f64) -> Ramp {
    Ramp { size_deg_s, over_s, found_after_s }
}

const RAMPS: [Ramp; 19] = [
    ramp(0.02, 0.0, 1.13),
    ramp(0.05, 0.0, 0.18),
    ramp(0.1, 0.0, 0.05),
    ramp(0.2, 0.0, 0.02),
    ramp(0.5, 0.0, 0.02),
    ramp(1.0, 0.0, 0.02),
    ramp(5.0, 0.0, 0.02),
    ramp(0.02, 1.0, 1.75),
    ramp(0.02, 5.0, 4.40),
    ramp(0.05, 5.0, 2.41),
    ramp(0.1, 0.1, 0.11),
    ramp(0.1, 1.0, 0.51),
    ramp(0.1, 5.0, 1.56),
    ramp(0.5, 0.1, 0.04),
    ramp(0.5, 1.0, 0.18),
    ramp(0.5, 5.0, 0.51),
    ramp(5.0, 0.1, 0.03),
    ramp(5.0, 1.0, 0.04),
    ramp(5.0, 5.0, 0.11),
];

/// A delay is of the published size up to half as much again, and one sample, for the published
/// ones count from the sample before the change.
const LATER: f64 = 1.5;

fn name(Ramp { size_deg_s, over_s, .. }: Ramp) -> String {
    if over_s > 0.0 {
        return format!("ramp {size_deg_s} deg/s in {over_s} s");
    }
    format!("step {size_deg_s} deg/s")
}

/// The suite.
pub(super) fn suite() -> Suite {
    let case = |ramp: Ramp| -> Box<dyn Case> {
        let kicks = Kicks::Ramp(ramp.size_deg_s, ramp.over_s);
        let mut kinds = vec![Kind::Tested];
        // The same filter without its test, where that shows most.
        if UNTESTED.contains(&(ramp.size_deg_s, ramp.over_s)) {
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
        runs: 800,
        cases: RAMPS.map(case).into(),
        requirements: requirements(),
        draw,
    }
}

const UNTESTED: [(f64, f64); 2] = [(0.1, 0.0), (0.5, 5.0)];

fn requirements() -> Vec<Requirement> {
    let mut all = Vec::new();
    let lost = Statistic::ShareAbove(Column::EndSigmas, 3.0);
    for ramp in RAMPS {
        let case = name(ramp);
        let of = |statistic, range| Requirement::new((&case, TESTED), statistic, range);
        all.push(of(Statistic::ShareWith(Column::DelayS), 0.99..=1.0));
        let latest_s = LATER * ramp.found_after_s + STEP_S;
        all.push(of(Statistic::Median(Column::DelayS), 0.0..=latest_s));
        all.push(of(Statistic::Rms(Column::AngleHalf2Deg), 0.0..=0.6));
        all.push(of(lost, 0.0..=0.03));
        all.push(of(Statistic::Nees, honest_nees(5.0)));
        if UNTESTED.contains(&(ramp.size_deg_s, ramp.over_s)) {
            let without = Requirement::new((&case, "EKF5a"), lost, 0.25..=1.0);
            all.push(without.as_control());
        }
    }
    all
}

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
    let named = |(size_deg_s, over_s)| name(ramp(size_deg_s, over_s, f64::NAN));
    let (slow, hard) = (named((0.02, 5.0)), named((5.0, 0.1)));
    for case in [slow, hard] {
        let title = format!("Angle error against claim: {case}, {TESTED}");
        all.extend(figures::fan(rows, &title, (&case, TESTED))?);
    }
    // As many as there are colours.
    let shown = SHOWN.map(named);
    let rows: Vec<&Row> = rows.iter().copied().filter(|row| shown.contains(&row.case)).collect();
    all.extend(figures::nees(&rows, "Squared error of the whole state over its claim", TESTED)?);
    Ok(all)
}
