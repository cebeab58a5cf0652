//! Many fits of the swinging body, as a table: `cargo run --release --example swing_study -- 50`.
//!
//! The cases are those of `tests/swing_fit`, the number of seeds the argument.

#![expect(clippy::unwrap_used, reason = "a study that fails stops")]
#![expect(clippy::print_stdout, reason = "the table is what it is for")]

#[expect(dead_code, reason = "the tests use more of it")]
#[path = "../tests/swing_fit/rig.rs"]
mod rig;

use rig::{Case, Run};
use struna_estimator::{AcceptedFit, Progress, SwingFit};
use struna_kernel::RAD_PER_DEG;

/// Steps of the model in each piece of work.
const PIECE: usize = 1000;

/// What one run comes to.
#[derive(Debug)]
struct Row {
    fit: Option<AcceptedFit>,
    twist_sigmas: f64,
    rate_sigmas: f64,
    pieces: usize,
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let seeds: u64 = arguments.next().map_or(10, |seeds| seeds.parse().unwrap());
    let torsion_s: f64 = arguments.next().map_or(120.0, |torsion| torsion.parse().unwrap());
    println!(
        "swing accepted dense restarted modes>1 | sigma deg median | twist e/s max >3 | \
              rate e/s max >3 | cost max GLR max | ksteps median max"
    );
    for swing_deg in [0.0, 1.0] {
        let rows: Vec<Row> =
            (0..seeds).map(|seed| row(swing_deg, 1000 + seed, torsion_s)).collect();
        print(swing_deg, &rows);
    }
}

fn row(swing_deg: f64, seed: u64, torsion_s: f64) -> Row {
    let run = Run::of(&Case { torsion_s, ..Case::new(swing_deg, seed, 240) });
    let mut fit: SwingFit = run.fit_of(&run.measured_rad_s[..12_500]);
    let mut pieces = 1;
    while fit.work(PIECE) == Progress::Working {
        pieces += 1;
    }
    let fit = match fit.run_to_end() {
        Ok(fit) => fit.clone(),
        Err(rejection) => {
            println!("  {swing_deg} deg, seed {seed}: {rejection}");
            return Row { fit: None, twist_sigmas: 0.0, rate_sigmas: 0.0, pieces };
        }
    };
    let error = run.error(&fit);
    if error.twist_sigmas > 3.0 || fit.restarts > 0 {
        println!(
            "  {swing_deg} deg, seed {seed}: {error:?} {} {} {} {:?} {:?}",
            fit.cost_per_sample,
            fit.leftover_mean,
            fit.leftover_square,
            (fit.restarts, fit.dense),
            fit.belief.mean
        );
        println!("{:?}", run.config.start);
    }
    let (twist_sigmas, rate_sigmas) = (error.twist_sigmas, error.rate_sigmas);
    Row { fit: Some(fit), twist_sigmas, rate_sigmas, pieces }
}

fn print(swing_deg: f64, rows: &[Row]) {
    let fits = || rows.iter().filter_map(|row| row.fit.as_ref());
    let largest = |of: &dyn Fn(&Row) -> f64| rows.iter().map(of).fold(0.0, f64::max);
    let beyond = |of: &dyn Fn(&Row) -> f64| rows.iter().filter(|row| of(row) > 3.0).count();
    let (twist, rate) = (|row: &Row| row.twist_sigmas, |row: &Row| row.rate_sigmas);
    let mut sigmas: Vec<f64> =
        fits().map(|fit| fit.belief.covariance[2][2].sqrt() / RAD_PER_DEG).collect();
    sigmas.sort_by(f64::total_cmp);
    let mut pieces: Vec<usize> = rows.iter().map(|row| row.pieces).collect();
    pieces.sort_unstable();
    println!(
        "{swing_deg} {}/{} {} {} {} | {:.3} | {:.2} {} | {:.2} {} | {:.3} {:.2} | {} {}",
        fits().count(),
        rows.len(),
        fits().filter(|fit| fit.dense).count(),
        fits().filter(|fit| fit.restarts > 0).count(),
        fits().filter(|fit| fit.modes > 1).count(),
        sigmas.get(sigmas.len() / 2).copied().unwrap_or(f64::NAN),
        largest(&twist),
        beyond(&twist),
        largest(&rate),
        beyond(&rate),
        fits().map(|fit| fit.cost_per_sample).fold(0.0, f64::max),
        fits().map(|fit| fit.leftover_mean).fold(0.0, f64::max),
        pieces[pieces.len() / 2],
        pieces.last().unwrap(),
    );
}
