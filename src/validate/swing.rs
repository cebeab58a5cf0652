//! Suite `swing`: a body that swings while it turns, watched by one gyro a degree off its axis, or
//! by three.

use super::contestant::{Contestant, Kind, Measured, Single, TrueState};
use super::requirement::{Requirement, Statistic};
use super::row::{Column, Row};
use super::suite::{Case, Figure, RunId, Suite};
use super::swing_rig::{SAMPLES, Shape, SwingRig};
use super::tally::{Schedule, Tally, Truth};
use super::torsion::STEP_S;
use crate::figure::FigureError;
use crate::validate::figures;
use anyhow::Result;
use struna_estimator::{
    Belief, EstimatorError, Innovation, LiveConfig, LiveEstimator, Status, ThreeAxisFilter,
};
use struna_kernel::RAD_PER_DEG;

const NAME: &str = "swing";
const LIVE: &str = "live switch";
const THREE: &str = "three axes";
const KINDS: [Kind; 4] = [Kind::Integration, Kind::F1(100), Kind::F2(100), Kind::Tested];

struct SwingCase {
    name: String,
    shape: Shape,
}

impl SwingCase {
    fn tallies(&self, id: RunId, rig: &SwingRig) -> Result<Vec<Tally>> {
        let schedule = Schedule { samples: SAMPLES, kick: None };
        let row = |estimator: &str| {
            let mut row = id.row(NAME, &self.name, estimator);
            rig.describe(&mut row);
            row
        };
        let config = rig.torsion_config();
        let mut tallies = Vec::new();
        for kind in KINDS {
            tallies.push(Tally::new(row(&kind.name()), kind.make(&config)?, schedule));
        }
        let swing = rig.swing_config();
        let live = LiveConfig { swing: Some(swing), ..LiveConfig::new(config, STEP_S) };
        let live = Box::new(Single(LiveEstimator::new(&live)?));
        tallies.push(Tally::new(row(LIVE), live, schedule));
        // It is told how far the body may swing, and no less than a tenth of a degree.
        let sigma_rad = self.shape.swing_deg.max(0.1) * RAD_PER_DEG;
        let three = Box::new(ThreeAxes(ThreeAxisFilter::new(&swing, sigma_rad)?));
        tallies.push(Tally::new(row(THREE), three, schedule));
        Ok(tallies)
    }
}

impl Case for SwingCase {
    fn name(&self) -> &str {
        &self.name
    }

    fn estimators(&self) -> Vec<String> {
        let more = [LIVE.to_owned(), THREE.to_owned()];
        KINDS.iter().map(|kind| kind.name()).chain(more).collect()
    }

    fn run(&self, id: RunId) -> Result<Vec<Row>> {
        let mut rig = SwingRig::draw(self.shape, id)?;
        let mut tallies = self.tallies(id, &rig)?;
        for k in 1..=SAMPLES {
            let sample = rig.sample(k)?;
            let truth = |rate_rad_s| {
                let angle_rad = sample.twist_rad;
                let state = TrueState { angle_rad, rate_rad_s, ..rig.parameters() };
                Truth { state, settled: true }
            };
            let (body, twist) = (truth(sample.body_rate_rad_s), truth(sample.twist_rate_rad_s));
            let one = Measured::new(STEP_S, sample.measured_rad_s);
            let [p, q, r] = sample.rates_rad_s;
            let three = Measured { across_rad_s: Some([p, q]), ..Measured::new(STEP_S, r) };
            let (of_torsion, of_swing) = tallies.split_at_mut(KINDS.len());
            of_torsion.iter_mut().for_each(|tally| tally.step(k, &one, &body));
            // These tell the rate of the twist.
            for (tally, measured) in of_swing.iter_mut().zip([&one, &three]) {
                tally.step(k, measured, &twist);
            }
        }
        Ok(tallies.into_iter().map(|tally| tally.finish(STEP_S)).collect())
    }
}

/// The filter of three axes; without the two rates across it has nothing to go by.
struct ThreeAxes(ThreeAxisFilter);

impl Contestant for ThreeAxes {
    fn step(&mut self, measured: &Measured) -> Result<Innovation, EstimatorError> {
        let [p, q] =
            measured.across_rad_s.ok_or(EstimatorError::BadMeasurement { rate_rad_s: f64::NAN })?;
        let rates_rad_s = [p, q, measured.rate_rad_s];
        self.0.step(measured.span_s, rates_rad_s).map(|[_, _, axial]| axial)
    }

    fn belief(&self) -> Belief {
        self.0.belief()
    }

    fn status(&self) -> Status {
        self.0.status()
    }
}

/// A gyro that leaves no trace of the swing in what it measures, and one of which nobody knows how
/// much.
const ON_AXIS: &str = "5 deg, gyro on the axis";
const UNKNOWN_AXIS: &str = "5 deg, gyro not calibrated";

/// Amplitudes, deg, of a swing on an ellipse of any form.
const SWINGS_DEG: [f64; 6] = [0.0, 1.0, 3.0, 5.0, 10.0, 15.0];

fn ellipse(swing_deg: f64) -> (String, Shape) {
    let shape = Shape {
        swing_deg,
        ratio: None,
        misalignment_deg: 1.0,
        calibration_deg: 0.1,
        inertia_ratio: 1.05,
    };
    (format!("{swing_deg} deg, any ellipse"), shape)
}

/// Other shapes at 5°, and at 15° the hardest.
fn others() -> Vec<(String, Shape)> {
    let (_, five) = ellipse(5.0);
    let (_, fifteen) = ellipse(15.0);
    let of = |name: &str, shape| (name.to_owned(), shape);
    vec![
        of("5 deg, planar", Shape { ratio: Some(0.0), ..five }),
        of("5 deg, conical", Shape { ratio: Some(1.0), ..five }),
        of("15 deg, conical", Shape { ratio: Some(1.0), ..fifteen }),
        of("5 deg, A = B", Shape { ratio: Some(0.2), inertia_ratio: 1.0, ..five }),
        of("15 deg, A = B", Shape { ratio: Some(0.2), inertia_ratio: 1.0, ..fifteen }),
        of(ON_AXIS, Shape { misalignment_deg: 0.0, ..five }),
        // Mounted somehow: a degree or so off, and nobody knows which way.
        of(UNKNOWN_AXIS, Shape { misalignment_deg: 0.0, calibration_deg: 1.0, ..five }),
    ]
}

/// The suite.
pub(super) fn suite() -> Suite {
    let shapes = SWINGS_DEG.into_iter().map(ellipse).chain(others());
    let case = |(name, shape)| Box::new(SwingCase { name, shape }) as Box<dyn Case>;
    Suite {
        name: NAME,
        about: "Two periods of T = 120 s of a body that swings as well, truth by the full \
                equations of motion; 1 deg of misalignment known to 0.1 deg, moments of inertia \
                believed 1 % and 0.5 % wrong. The live estimator finds the swing, bounds the \
                angle, fits the motion and follows it; where the gyro sits on the axis, or nobody \
                knows how it sits, it can do no more than bound. The filter of three axes sees \
                the swing at once.",
        runs: 150,
        cases: shapes.map(case).collect(),
        requirements: requirements(),
        draw,
    }
}

/// Swings of which no more is asked than that the claim holds.
const HARDEST: [&str; 2] = ["15 deg, conical", "15 deg, A = B"];

fn requirements() -> Vec<Requirement> {
    let (half2, end, worst) = (Column::AngleHalf2Deg, Column::EndSigmas, Column::WorstSigmas);
    let mut all = Vec::new();
    let names = SWINGS_DEG.into_iter().map(ellipse).chain(others()).map(|(name, _)| name);
    for case in names {
        let of =
            |estimator, statistic, range| Requirement::new((&case, estimator), statistic, range);
        // Of every run, not of most, and of a bound no less than of an angle.
        all.push(of(LIVE, Statistic::Largest(end), 0.0..=3.0));
        all.push(of(LIVE, Statistic::Largest(worst), 0.0..=6.0));
        if [ON_AXIS, UNKNOWN_AXIS].contains(&case.as_str()) {
            // No angle is claimed then, whatever it is; 150 of 150 are above 97.5 %.
            all.push(of(LIVE, Statistic::ShareSaying("not observable"), 0.95..=1.0));
        } else if !HARDEST.contains(&case.as_str()) {
            // The widest swings that are not a slim ellipse on an uneven body are bounded, not
            // always fitted.
            all.push(of(LIVE, Statistic::Median(half2), 0.0..=0.06));
        }
        all.push(of(THREE, Statistic::Rms(half2), 0.0..=0.08));
        // Normal errors: 0.0027; none of 150 is below 2.4 %.
        all.push(of(THREE, Statistic::ShareAbove(end, 3.0), 0.0..=0.05));
    }
    let control = |case: f64, estimator: &str, statistic, range| {
        Requirement::new((&ellipse(case).0, estimator), statistic, range).as_control()
    };
    let of_torsion = "EKF5a+test";
    all.push(control(5.0, of_torsion, Statistic::Rms(half2), 5.0..=f64::INFINITY));
    all.push(control(15.0, of_torsion, Statistic::Rms(half2), 50.0..=f64::INFINITY));
    all.push(control(5.0, "integration", Statistic::Rms(half2), 5.0..=f64::INFINITY));
    all
}

fn draw(rows: &[&Row]) -> Result<Vec<Figure>, FigureError> {
    let mut all = Vec::new();
    let main: Vec<&Row> =
        rows.iter().copied().filter(|row| row.case.ends_with("any ellipse")).collect();
    all.extend(figures::against(
        &main,
        &figures::Against {
            title: "Median RMS of the angle over the second half against the swing",
            x: Column::SwingDeg,
            x_name: "amplitude of the swing, deg",
            y: Column::AngleHalf2Deg,
            y_name: "angle error, deg",
        },
    )?);
    all.push(figures::claims(rows, "Error at the end in claimed standard deviations")?);
    for (swing_deg, estimator) in [(5.0, LIVE), (15.0, LIVE), (15.0, THREE)] {
        let (case, _) = ellipse(swing_deg);
        let title = format!("Angle error against claim: {case}, {estimator}");
        all.extend(figures::fan(rows, &title, (&case, estimator))?);
    }
    Ok(all)
}
