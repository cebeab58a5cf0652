//! Suite `limits`: how close each estimator comes to the least possible error, and whether its
//! claims hold, in the five scenarios A to E.

use super::contestant::Kind;
use super::race::TorsionCase;
use super::requirement::{Requirement, Statistic, honest_nees};
use super::row::{Column, Row};
use super::suite::{Case, Figure, Suite};
use super::torsion::Ensemble;
use crate::figure::FigureError;
use crate::validate::figures;

const NAME: &str = "limits";
const TESTED: &str = "EKF5a+test";

const KINDS: [Kind; 6] = [
    Kind::Integration,
    Kind::F1(100),
    Kind::F2(100),
    Kind::F2(1000),
    Kind::Augmented,
    Kind::Tested,
];

/// Scenario, what is drawn, whether it has a bound.
const SCENARIOS: [(&str, Ensemble, bool); 5] = [
    ("A good start", Ensemble::A, true),
    ("B start 100 deg", Ensemble::B, true),
    ("C random torque", Ensemble::C, true),
    ("D three kicks", Ensemble::D, false),
    ("E outliers", Ensemble::E, true),
];

/// The suite.
pub(super) fn suite() -> Suite {
    let case = |(name, ensemble, bounded): (&str, Ensemble, bool)| -> Box<dyn Case> {
        Box::new(TorsionCase {
            suite: NAME,
            name: name.to_owned(),
            ensemble,
            kinds: KINDS.to_vec(),
            bounded,
        })
    };
    Suite {
        name: NAME,
        about: "Five scenarios of a body let go at one turn, T = 480 s, one period long: a good \
                start (A), a start known to 100 deg and a bias known to 0.05 deg/s (B), and B with \
                a random torque (C), three kicks (D), 1 % of outliers (E). The bound is what the \
                best possible filter would be left with.",
        runs: 1000,
        cases: SCENARIOS.map(case).into(),
        requirements: requirements(),
        draw,
    }
}

/// The bound is an average over the prior, and everything is drawn from it: the best filter comes
/// to 1 on average, and the two errors of a few runs to 20 % below.
fn requirements() -> Vec<Requirement> {
    let mut all = Vec::new();
    for (case, _, bounded) in SCENARIOS {
        let of = |statistic, range| Requirement::new((case, TESTED), statistic, range);
        let calm = bounded && !case.starts_with('E');
        if calm {
            let angle = Statistic::RmsOver(Column::AngleHalf2Deg, Column::BoundAngleDeg);
            all.push(of(angle, 0.8..=1.15));
            let rate = Statistic::RmsOver(Column::RateHalf2DegS, Column::BoundRateDegS);
            all.push(of(rate, 0.8..=1.15));
        } else {
            all.push(of(Statistic::Rms(Column::AngleHalf2Deg), 0.0..=0.6));
        }
        all.push(of(Statistic::Nees, honest_nees(5.0)));
        // Normal errors: 0.0027.
        all.push(of(Statistic::ShareAbove(Column::EndSigmas, 3.0), 0.0..=0.03));
        if calm {
            all.push(of(Statistic::Mean(Column::NisMean), 0.98..=1.02));
            all.push(of(Statistic::CountAnHour(Column::Alarms), 0.0..=2.0));
        }
    }
    all.extend(controls());
    all
}

/// What must fail for the campaign to be believed.
fn controls() -> Vec<Requirement> {
    let over = Statistic::RmsOver(Column::AngleHalf2Deg, Column::BoundAngleDeg);
    let against = Statistic::RmsAgainst(Column::AngleHalf2Deg, "integration");
    let of = |cell, statistic, range| Requirement::new(cell, statistic, range).as_control();
    let (b, d) = ("B start 100 deg", "D three kicks");
    vec![
        of((b, "integration"), over, 100.0..=f64::INFINITY),
        // The filters of 2008 add nothing to the integral, and their residuals do not tell.
        of((b, "F2 N=100"), against, 0.95..=1.05),
        of((b, "F2 N=100"), Statistic::Mean(Column::NisMean), 0.9..=1.1),
        of((b, "F2 N=100"), Statistic::Nees, 10.0..=f64::INFINITY),
        // Without its test the five-state filter is lost after a kick.
        of((d, "EKF5a"), Statistic::Rms(Column::AngleHalf2Deg), 10.0..=f64::INFINITY),
    ]
}

fn draw(rows: &[&Row]) -> Result<Vec<Figure>, FigureError> {
    let mut all = vec![figures::bars(
        rows,
        &figures::Bars {
            title: "RMS of the angle over the second half, by scenario",
            column: Column::AngleHalf2Deg,
            bound: Some(Column::BoundAngleDeg),
            axis: "deg",
        },
    )?];
    for case in ["B start 100 deg", "D three kicks"] {
        let title = format!("Angle error against claim: {case}, {TESTED}");
        all.extend(figures::fan(rows, &title, (case, TESTED))?);
    }
    all.extend(figures::nees(rows, "Squared error of the whole state over its claim", TESTED)?);
    Ok(all)
}
