//! Suite `paper`: what the covariance refinement of the 2008 filters does, and what the best length
//! of it is.

use super::contestant::Kind;
use super::race::TorsionCase;
use super::requirement::{Published, Requirement, Statistic};
use super::row::{Column, Row};
use super::suite::{Case, Figure, Suite};
use super::torsion::{DAMPING_RATIO, Ensemble, START_DEG, STEP_S};
use crate::figure::FigureError;
use crate::validate::figures;
use std::f64::consts::TAU;
use struna_kernel::RAD_PER_DEG;

const NAME: &str = "paper";
const TRUE_START: &str = "true start";
const WRONG_START: &str = "start 100 deg wrong";
const BIASED: &str = "bias 0.05 deg/s";

/// Lengths of the refinement, samples.
const LENGTHS: [u32; 14] = [0, 1, 3, 10, 20, 30, 50, 70, 100, 300, 1000, 2000, 3000, 5000];
/// Those tried with a wrong start and with a bias.
const FEW: [u32; 3] = [0, 100, 1000];

/// RMS errors over 480 s in an independent simulation of reading M6, 50 runs, to three digits.
struct Row2008 {
    length: u32,
    /// Rate, deg/s, and angle, deg, of the filter of permanent rotation.
    rotation: [f64; 2],
    /// The same of that of torsional oscillation.
    torsion: [f64; 2],
}

const fn row(length: u32, rotation: [f64; 2], torsion: [f64; 2]) -> Row2008 {
    Row2008 { length, rotation, torsion }
}

const TABLE: [Row2008; 9] = [
    row(0, [3.04, 0.0634], [0.145, 16.3]),
    row(1, [0.0266, 0.0828], [0.0266, 0.0692]),
    row(10, [0.0176, 0.0642], [0.0175, 0.0616]),
    row(30, [0.0134, 0.0632], [0.0128, 0.0613]),
    row(100, [0.0147, 0.0624], [0.0085, 0.0622]),
    row(300, [0.0352, 0.0613], [0.0059, 0.0817]),
    row(1000, [0.115, 0.0625], [0.0060, 10.4]),
    row(2000, [0.230, 0.0630], [0.0037, 14.0]),
    row(5000, [0.551, 0.0631], [0.0040, 13.9]),
];
/// Runs behind the table.
const TABLE_RUNS: u32 = 50;
/// Standard errors that none of 36 normal numbers is beyond in 19 of 20 tables.
const TABLE_ERRORS: f64 = 3.2;

/// Period, s, and R, (deg/s)², of the cases that ask for the best N.
const LAWS: [(f64, f64); 5] =
    [(480.0, 2e-3), (480.0, 8e-3), (960.0, 2e-3), (240.0, 2e-3), (120.0, 2e-3)];

fn law_name((period_s, r_deg2_s2): (f64, f64)) -> String {
    format!("best N: T = {period_s} s, R = {r_deg2_s2} (deg/s)^2")
}

/// The best N of the filter of permanent rotation after its law, N = (6R(ln N - 1)/(α·h)²)^(1/3).
///
/// Between insertions the filter takes a running mean while the rate moves on: R/j + (α·h·j/2)²
/// after j samples, least on average near that. α² = Ω⁴·mean(φ²), and the mean of φ² over a period
/// is φ₀²/2·(1 - e^(-4πζ))/(4πζ).
fn law((period_s, r_deg2_s2): (f64, f64)) -> f64 {
    let decay = 2.0 * TAU * DAMPING_RATIO;
    let mean2_deg2 = 0.5 * START_DEG * START_DEG * (1.0 - (-decay).exp()) / decay;
    let drift_deg_s = (TAU / period_s).powi(2) * mean2_deg2.sqrt() * STEP_S;
    let next = |n: f64| (6.0 * r_deg2_s2 * (n.ln() - 1.0).max(0.0) / drift_deg_s.powi(2)).cbrt();
    (0..200).fold(1000.0, |n, _| next(n))
}

/// Lengths from a third of a law's to one and a half times it.
fn around(law: f64) -> Vec<u32> {
    let at = |k: i32| law * 2_f64.powf(f64::from(k) / 6.0);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some hundreds")]
    let mut lengths: Vec<u32> = (-10..=4).map(|k| at(k).round().max(1.0) as u32).collect();
    lengths.dedup();
    lengths
}

fn kinds(lengths: &[u32]) -> Vec<Kind> {
    let both = |n: &u32| [Kind::F1(*n), Kind::F2(*n)];
    std::iter::once(Kind::Integration).chain(lengths.iter().flat_map(both)).collect()
}

fn case(name: &str, ensemble: Ensemble, kinds: Vec<Kind>) -> Box<dyn Case> {
    Box::new(TorsionCase { suite: NAME, name: name.to_owned(), ensemble, kinds, bounded: false })
}

fn law_case(of: (f64, f64)) -> Box<dyn Case> {
    let (period_s, r_deg2_s2) = of;
    let r_rad2_s2 = r_deg2_s2 * RAD_PER_DEG * RAD_PER_DEG;
    let ensemble = Ensemble { period_s, r_rad2_s2, ..Ensemble::EXACT };
    case(&law_name(of), ensemble, around(law(of)).into_iter().map(Kind::F1).collect())
}

/// The suite.
pub(super) fn suite() -> Suite {
    let wrong = Ensemble { start_error_deg: 100.0, ..Ensemble::EXACT };
    let biased = Ensemble { bias_deg_s: 0.05, ..Ensemble::EXACT };
    let mut cases = vec![
        case(TRUE_START, Ensemble::EXACT, kinds(&LENGTHS)),
        case(WRONG_START, wrong, kinds(&FEW)),
        case(BIASED, biased, kinds(&FEW)),
    ];
    cases.extend(LAWS.map(law_case));
    Suite {
        name: NAME,
        about: "The two filters of 2008 with their covariance refinement every N samples, in the \
                reading that fits what their authors show (M6), beside plain integration. Exact \
                period, damping ratio 0.03, no bias; then the same with a start 100 deg wrong, \
                and with a bias of 0.05 deg/s; and other periods and gyros, for the law of the \
                best N.",
        runs: 400,
        cases,
        requirements: requirements(),
        draw,
    }
}

/// The table, within what 50 runs leave open: rounding, and 3.2 standard errors.
fn table() -> Vec<Requirement> {
    let mut all = Vec::new();
    for Row2008 { length, rotation, torsion } in TABLE {
        for (kind, [rate, angle]) in [(Kind::F1(length), rotation), (Kind::F2(length), torsion)] {
            let name = kind.name();
            let of = |column, value| {
                let published = Published { value, rounding: rounding(value), runs: TABLE_RUNS };
                let off = Statistic::RmsOff(column, published);
                Requirement::new((TRUE_START, &name), off, -TABLE_ERRORS..=TABLE_ERRORS)
            };
            all.extend([of(Column::RateRmsDegS, rate), of(Column::AngleRmsDeg, angle)]);
        }
    }
    all
}

/// Half a unit of the last digit of the table's numbers: three digits, and no more than four
/// decimals.
fn rounding(value: f64) -> f64 {
    0.5 * 10_f64.powf((value.log10().floor() - 2.0).max(-4.0))
}

fn requirements() -> Vec<Requirement> {
    let mut all = table();
    for of in LAWS {
        let (law, name) = (law(of), law_name(of));
        let best = Statistic::BestRefinement("F1", Column::RateRmsDegS);
        let any = Kind::F1(around(law)[0]).name();
        // The law is within 30 % of the best.
        all.push(Requirement::new((&name, &any), best, law / 1.3..=law / 0.7));
    }
    all.extend(findings());
    all
}

/// What the table's authors say of it, and what they could not see.
fn findings() -> Vec<Requirement> {
    let of = Requirement::new;
    let (angle, rate) = (Column::AngleRmsDeg, Column::RateRmsDegS);
    let against = Statistic::RmsAgainst(angle, "integration");
    let best = |family, column| Statistic::BestRefinement(family, column);
    vec![
        // Without refinement the filter of permanent rotation *is* the integral in angle, to the
        // share 1/n of its first samples, and a cumulative mean in rate.
        of((TRUE_START, "F1 N=0"), against, 0.99..=1.01),
        // Fig. 5.5 of the preprint: N = 1000 is far better than none.
        of((TRUE_START, "F1 N=1000"), Statistic::RmsAgainst(rate, "F1 N=0"), 0.0..=0.1),
        of((TRUE_START, "F2 N=70"), best("F2", angle), 3.0..=200.0),
        of((TRUE_START, "F2 N=3000"), best("F2", rate), 300.0..=5000.0),
        // N > 2000 is unsatisfactory, said the authors: three sigma of the gyro are 0.134 deg/s.
        of((TRUE_START, "F1 N=5000"), Statistic::Rms(rate), 0.134..=f64::INFINITY).as_control(),
        of((TRUE_START, "F2 N=5000"), Statistic::Rms(angle), 5.0..=f64::INFINITY).as_control(),
        // A wrong start stays wrong, a bias is integrated, and neither is told by residuals.
        of((WRONG_START, "F1 N=100"), Statistic::Rms(angle), 95.0..=105.0).as_control(),
        of((WRONG_START, "F2 N=100"), Statistic::Rms(angle), 95.0..=105.0).as_control(),
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
