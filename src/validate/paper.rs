//! Suite `paper`: what the covariance refinement of the 2008 filters does, and what the best length
//! of it is.

use super::contestant::Kind;
use super::race::TorsionCase;
use super::requirement::{Requirement, Statistic};
use super::row::{Column, Row};
use super::suite::{Case, Figure, Suite};
use super::torsion::Ensemble;
use crate::figure::FigureError;
use crate::validate::figures;

const NAME: &str = "paper";
const TRUE_START: &str = "true start";
const WRONG_START: &str = "start 100 deg wrong";
const BIASED: &str = "bias 0.05 deg/s";

/// Lengths of the refinement, samples.
const LENGTHS: [u32; 14] = [0, 1, 3, 10, 20, 30, 50, 70, 100, 300, 1000, 2000, 3000, 5000];
/// Those tried with a wrong start and with a bias.
const FEW: [u32; 3] = [0, 100, 1000];

fn kinds(lengths: &[u32]) -> Vec<Kind> {
    let both = |n: &u32| [Kind::F1(*n), Kind::F2(*n)];
    std::iter::once(Kind::Integration).chain(lengths.iter().flat_map(both)).collect()
}

/// The suite.
pub(super) fn suite() -> Suite {
    let case = |name: &str, ensemble, lengths: &[u32]| -> Box<dyn Case> {
        let (name, kinds) = (name.to_owned(), kinds(lengths));
        Box::new(TorsionCase { suite: NAME, name, ensemble, kinds, bounded: false })
    };
    let wrong = Ensemble { start_error_deg: 100.0, ..Ensemble::EXACT };
    let biased = Ensemble { bias_deg_s: 0.05, ..Ensemble::EXACT };
    Suite {
        name: NAME,
        about: "The two filters of 2008 with their covariance refinement every N samples, in the \
                reading that fits what their authors show (M6), beside plain integration. Exact \
                period, damping ratio 0.03, no bias; then the same with a start 100 deg wrong, \
                and with a bias of 0.05 deg/s.",
        runs: 50,
        cases: vec![
            case(TRUE_START, Ensemble::EXACT, &LENGTHS),
            case(WRONG_START, wrong, &FEW),
            case(BIASED, biased, &FEW),
        ],
        requirements: requirements(),
        draw,
    }
}

fn requirements() -> Vec<Requirement> {
    let of = Requirement::new;
    let (angle, rate) = (Column::AngleRmsDeg, Column::RateRmsDegS);
    let against = Statistic::RmsAgainst(angle, "integration");
    let best = |family, column| Statistic::BestRefinement(family, column);
    vec![
        // Without refinement the filter of permanent rotation *is* the integral in angle, to the
        // share 1/n of its first samples, and a cumulative mean in rate.
        of((TRUE_START, "F1 N=0"), against, 0.99..=1.01),
        of((TRUE_START, "F1 N=0"), Statistic::Mean(rate), 2.0..=5.0),
        // Fig. 5.5 of the preprint: N = 1000 is far better than none. N = 100 beats the raw gyro
        // (0.0447 deg/s) three times over; N = 1 hardly smooths.
        of((TRUE_START, "F1 N=1000"), Statistic::RmsAgainst(rate, "F1 N=0"), 0.0..=0.1),
        of((TRUE_START, "F1 N=100"), Statistic::Mean(rate), 0.0..=0.02),
        of((TRUE_START, "F2 N=100"), Statistic::Mean(rate), 0.0..=0.0125),
        of((TRUE_START, "F1 N=1"), Statistic::Mean(rate), 0.015..=0.04),
        // N* follows from T and R: (6R(ln N - 1)/(α·h)²)^(1/3) = 62 for these.
        of((TRUE_START, "F1 N=50"), best("F1", rate), 20.0..=200.0),
        of((TRUE_START, "F2 N=70"), best("F2", angle), 1.0..=300.0),
        of((TRUE_START, "F2 N=3000"), best("F2", rate), 300.0..=5000.0),
        // N > 2000 is unsatisfactory, said the authors: three sigma of the gyro are 0.134 deg/s.
        of((TRUE_START, "F1 N=5000"), Statistic::Mean(rate), 0.134..=f64::INFINITY).as_control(),
        of((TRUE_START, "F2 N=5000"), Statistic::Mean(angle), 5.0..=f64::INFINITY).as_control(),
        // A wrong start stays wrong, a bias is integrated, and neither is told by residuals.
        of((WRONG_START, "F1 N=100"), Statistic::Mean(angle), 75.0..=125.0).as_control(),
        of((WRONG_START, "F2 N=100"), Statistic::Mean(angle), 75.0..=125.0).as_control(),
        of((BIASED, "F1 N=100"), against, 0.96..=1.04).as_control(),
        of((BIASED, "F2 N=100"), against, 0.96..=1.04).as_control(),
        of((WRONG_START, "F2 N=100"), Statistic::Mean(Column::NisMean), 0.9..=1.1).as_control(),
        of((WRONG_START, "F2 N=100"), Statistic::Nees, 100.0..=f64::INFINITY).as_control(),
    ]
}

fn draw(rows: &[&Row]) -> Result<Vec<Figure>, FigureError> {
    let mut all = Vec::new();
    for (title, column) in [
        ("RMS of the rate against N", Column::RateRmsDegS),
        ("RMS of the angle against N", Column::AngleRmsDeg),
    ] {
        all.extend(figures::refinement(rows, title, TRUE_START, column)?);
    }
    Ok(all)
}
