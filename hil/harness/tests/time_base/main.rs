//! How well sample times are found behind lines that delay them: the sliding hull and its peers.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod cases;
mod peers;

use cases::{CASES, Case, SKEW, Sample};
use struna_harness::clock::{TimeBase, TimeBaseSettings};
use struna_kernel::SimTime;

/// Everything a settled window needs has happened by then.
const WARM_S: f64 = 130.0;
const RUN_S: f64 = 310.0;

/// The deviation from its mean: a constant delay cannot be seen by anybody.
fn deviation_us(errors_s: &[f64]) -> f64 {
    let count = errors_s.len() as f64;
    let mean = errors_s.iter().sum::<f64>() / count;
    (errors_s.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / count).sqrt() * 1e6
}

/// What the sliding hull made of a stream after [`WARM_S`].
struct Sliding {
    errors_s: Vec<f64>,
    skew_error_max_ppm: f64,
    /// Largest error of the skew as a multiple of its claimed uncertainty.
    skew_sigmas_max: f64,
}

fn sliding(case: &Case, samples: &[Sample], window_s: f64) -> Sliding {
    let window = SimTime::from_s(window_s).unwrap();
    let settle = SimTime::from_s(window_s.min(5.0) * 0.9).unwrap();
    let settings = TimeBaseSettings::new(case.period_s(), 0.03);
    let mut base = TimeBase::new(TimeBaseSettings { window, settle, ..settings });
    let mut found = Sliding { errors_s: Vec::new(), skew_error_max_ppm: 0.0, skew_sigmas_max: 0.0 };
    for s in samples {
        base.observe(s.index, s.arrival);
        if s.taken_s < WARM_S {
            continue;
        }
        found.errors_s.push(base.time_of(s.index, s.arrival).as_s() - s.taken_s);
        if s.index % 97 == 0 {
            let skew = base.skew().unwrap();
            let off_ppm = (skew.ppm - SKEW * 1e6).abs();
            found.skew_error_max_ppm = found.skew_error_max_ppm.max(off_ppm);
            found.skew_sigmas_max = found.skew_sigmas_max.max(off_ppm / skew.sigma_ppm);
        }
    }
    found
}

#[test]
fn the_table() {
    println!(
        "| case | arrival | OLS | hull 120 s | Olson | loop | W=5 | W=20 | W=60 | skew W=60 | sig |"
    );
    for case in &CASES {
        let samples = case.samples(RUN_S, 7);
        let warm = samples.iter().filter(|s| s.taken_s >= WARM_S).copied().collect::<Vec<_>>();
        let batch: Vec<_> = samples.iter().filter(|s| s.taken_s < 120.0).copied().collect();
        let late = samples.len() - warm.len();
        let w: Vec<_> = [5.0, 20.0, 60.0].map(|w| sliding(case, &samples, w)).into();
        println!(
            "| {} | {:.0} | {:.1} | {:.2} | {:.1} | {:.0} | {:.1} | {:.1} | {:.1} | {:.1} {:.1} {:.1} | {:.1} {:.1} {:.1}|",
            case.name,
            deviation_us(&peers::arrival(&warm)),
            deviation_us(&peers::least_squares(&batch)),
            deviation_us(&peers::batch_hull(&batch, case.period_s())),
            deviation_us(&peers::olson(&samples, case.period_s(), 200e-6)[late..]),
            deviation_us(&peers::locked_loop(&samples, case.period_s(), 0.005)[late..]),
            deviation_us(&w[0].errors_s),
            deviation_us(&w[1].errors_s),
            deviation_us(&w[2].errors_s),
            w[0].skew_error_max_ppm,
            w[1].skew_error_max_ppm,
            w[2].skew_error_max_ppm,
            w[0].skew_sigmas_max,
            w[1].skew_sigmas_max,
            w[2].skew_sigmas_max,
        );
    }
}
