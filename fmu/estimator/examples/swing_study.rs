//! Many runs of the swinging body, as a table: each is started by the fit and followed by the
//! filter to 240 s.
//!
//! `cargo run --release -p struna-estimator --example swing_study -- 50 120 0 1 3 5 10 15`: seeds,
//! period of the torsion, sizes of the swing. The cases are those of `tests/swing_fit`.

#![expect(clippy::unwrap_used, reason = "a study that fails stops")]
#![expect(clippy::print_stdout, reason = "the table is what it is for")]

#[expect(dead_code, reason = "the tests use more of it")]
#[path = "../tests/swing_fit/rig.rs"]
mod rig;
#[path = "../tests/shared/swinging.rs"]
mod swinging;

use rig::{Case, PERIOD_S, Run};
use struna_estimator::{
    AcceptedFit, InnovationTest, Progress, RateEstimator, SwingConfig, SwingFilter,
};
use struna_kernel::RAD_PER_DEG;

/// Steps of the model in each piece of work.
const PIECE: usize = 1000;

/// What one run comes to.
#[derive(Debug)]
struct Row {
    fit: Option<AcceptedFit>,
    /// Errors of the fit at the end of its window over what it claims.
    twist_sigmas: f64,
    rate_sigmas: f64,
    /// Pieces of work that the fit took.
    pieces: usize,
    followed: Followed,
}

/// How the filter follows from the end of the window on. Degrees.
#[derive(Debug, Default)]
struct Followed {
    /// RMS errors over the second half of the run.
    angle_deg: f64,
    rate_deg_s: f64,
    /// Error of the angle over the claimed sigma: at the end, and the largest ever.
    end_sigmas: f64,
    worst_sigmas: f64,
    alarms: u64,
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let seeds: u64 = arguments.next().map_or(4, |seeds| seeds.parse().unwrap());
    let torsion_s: f64 = arguments.next().map_or(120.0, |torsion| torsion.parse().unwrap());
    println!(
        "swing | accepted dense restarted modes>1 | fit: sigma deg median, twist e/s rms max >3, \
         rate e/s max >3, cost max, GLR max | filter: h2 median rms max deg, rate rms deg/s, \
         e/s end max >3, ever max, alarms | ksteps median max"
    );
    for swing in arguments {
        let swing_deg: f64 = swing.parse().unwrap();
        let rows: Vec<Row> = (0..seeds).map(|seed| row(swing_deg, seed, torsion_s)).collect();
        print(swing_deg, &rows);
    }
}

fn row(swing_deg: f64, seed: u64, torsion_s: f64) -> Row {
    let run = Run::of(&Case { torsion_s, ..Case::new(swing_deg, 1000 + seed, 240) });
    let mut fit = run.fit_of(&run.measured_rad_s[..17_000]);
    let mut pieces = 1;
    while fit.work(PIECE) == Progress::Working {
        pieces += 1;
    }
    let fit = match fit.run_to_end() {
        Ok(fit) => *fit,
        Err(rejection) => {
            println!("  {swing_deg} deg, seed {seed}: {rejection}");
            let followed = Followed::default();
            return Row { fit: None, twist_sigmas: 0.0, rate_sigmas: 0.0, pieces, followed };
        }
    };
    let error = run.error(&fit);
    let (twist_sigmas, rate_sigmas) = (error.twist_sigmas, error.rate_sigmas);
    let followed = follow(&run, &run.config, &fit);
    Row { fit: Some(fit), twist_sigmas, rate_sigmas, pieces, followed }
}

fn follow(run: &Run, config: &SwingConfig, fit: &AcceptedFit) -> Followed {
    let mut filter = SwingFilter::new(config, &InnovationTest::STANDARD, &fit.belief).unwrap();
    let mut followed = Followed::default();
    let (mut angle2, mut rate2) = (0.0, 0.0);
    let start = usize::try_from(fit.samples).unwrap();
    let half = run.truth.len() / 2;
    for (k, (truth, measured)) in run.truth.iter().zip(&run.measured_rad_s).enumerate().skip(start)
    {
        filter.step(PERIOD_S, *measured).unwrap();
        let belief = filter.belief();
        let error_rad = belief.angle_rad - truth.twist_rad;
        followed.end_sigmas = error_rad.abs() / belief.covariance.angle_rad2.sqrt();
        followed.worst_sigmas = followed.worst_sigmas.max(followed.end_sigmas);
        if k >= half {
            angle2 += error_rad * error_rad;
            rate2 += (belief.rate_rad_s - truth.twist_rate_rad_s).powi(2);
        }
    }
    let samples = (run.truth.len() - half.max(start)) as f64;
    followed.angle_deg = (angle2 / samples).sqrt() / RAD_PER_DEG;
    followed.rate_deg_s = (rate2 / samples).sqrt() / RAD_PER_DEG;
    followed.alarms = filter.alarms();
    followed
}

/// The rows that have a fit.
fn with_fit(rows: &[Row]) -> impl Iterator<Item = (&Row, &AcceptedFit)> {
    rows.iter().filter_map(|row| row.fit.as_ref().map(|fit| (row, fit)))
}

fn sorted(rows: &[Row], of: impl Fn(&Row, &AcceptedFit) -> f64) -> Vec<f64> {
    let mut values: Vec<f64> = with_fit(rows).map(|(row, fit)| of(row, fit)).collect();
    values.sort_by(f64::total_cmp);
    values
}

fn median(sorted: &[f64]) -> f64 {
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

fn largest(sorted: &[f64]) -> f64 {
    sorted.last().copied().unwrap_or(f64::NAN)
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
}

fn beyond_3(values: &[f64]) -> usize {
    values.iter().filter(|value| **value > 3.0).count()
}

fn print(swing_deg: f64, rows: &[Row]) {
    let count =
        |of: &dyn Fn(&AcceptedFit) -> bool| with_fit(rows).filter(|(_, fit)| of(fit)).count();
    let twist = sorted(rows, |row, _| row.twist_sigmas);
    let rate = sorted(rows, |row, _| row.rate_sigmas);
    let sigma = sorted(rows, |_, fit| fit.belief.covariance[2][2].sqrt() / RAD_PER_DEG);
    let h2 = sorted(rows, |row, _| row.followed.angle_deg);
    let end = sorted(rows, |row, _| row.followed.end_sigmas);
    let mut pieces: Vec<usize> = rows.iter().map(|row| row.pieces).collect();
    pieces.sort_unstable();
    println!(
        "{swing_deg} | {}/{} {} {} {} | {:.3}, {:.2} {:.2} {}, {:.2} {}, {:.3}, {:.2} | \
         {:.3} {:.3} {:.3}, {:.4}, {:.2} {}, {:.2}, {:.2} | {} {}",
        twist.len(),
        rows.len(),
        count(&|fit| fit.dense),
        count(&|fit| fit.restarts > 0),
        count(&|fit| fit.modes > 1),
        median(&sigma),
        rms(&twist),
        largest(&twist),
        beyond_3(&twist),
        largest(&rate),
        beyond_3(&rate),
        largest(&sorted(rows, |_, fit| fit.cost_per_sample)),
        largest(&sorted(rows, |_, fit| fit.leftover_mean)),
        median(&h2),
        rms(&h2),
        largest(&h2),
        rms(&sorted(rows, |row, _| row.followed.rate_deg_s)),
        largest(&end),
        beyond_3(&end),
        largest(&sorted(rows, |row, _| row.followed.worst_sigmas)),
        sorted(rows, |row, _| row.followed.alarms as f64).iter().sum::<f64>() / rows.len() as f64,
        pieces[pieces.len() / 2],
        pieces.last().unwrap(),
    );
}
