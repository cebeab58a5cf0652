//! Many runs on a thread, on two threads of execution, and what is kept of them.

use crate::rig::{Run, SAMPLES, STEP_S, Thread};
use struna_estimator::{HysteresisBank, InnovationTest, RateEstimator, TestedFilter};
use struna_kernel::RAD_PER_DEG;

/// What one run comes to. Degrees.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Outcome {
    /// Mean square of the angle error over the second half.
    pub(crate) angle2_deg2: f64,
    /// Mean claimed variance over the second half.
    pub(crate) claimed2_deg2: f64,
    /// Share of the second half beyond three sigma.
    pub(crate) beyond: f64,
    /// Largest error in the second half over its sigma.
    pub(crate) worst_sigmas: f64,
    pub(crate) end_error_deg: f64,
    pub(crate) end_sigmas: f64,
    /// Mean normalised innovation squared over the whole run.
    pub(crate) nis: f64,
}

/// Runs an estimator and keeps what its angle is worth.
fn watched<E: RateEstimator>(run: &mut Run, estimator: &mut E) -> Outcome {
    let (mut angle2, mut claimed2, mut beyond, mut nis) = (0.0, 0.0, 0.0, 0.0);
    let (mut worst_sigmas, mut end_rad, mut end_sigmas) = (0.0_f64, 0.0, 0.0);
    for k in 1..=SAMPLES {
        let truth = run.sample(k);
        estimator.predict(STEP_S).unwrap();
        nis += estimator.update(truth.measured_rad_s).unwrap().nis();
        // A tenth of the samples is enough for errors that live for seconds.
        if k > SAMPLES / 2 && k % 10 == 0 {
            let belief = estimator.belief();
            end_rad = belief.angle_rad - truth.angle_rad;
            let variance = belief.covariance.angle_rad2;
            end_sigmas = end_rad.abs() / variance.sqrt();
            angle2 += end_rad * end_rad;
            claimed2 += variance;
            beyond += f64::from(u8::from(end_sigmas > 3.0));
            worst_sigmas = worst_sigmas.max(end_sigmas);
        }
    }
    let judged = f64::from(SAMPLES / 20);
    let degrees2 = judged * RAD_PER_DEG * RAD_PER_DEG;
    Outcome {
        angle2_deg2: angle2 / degrees2,
        claimed2_deg2: claimed2 / degrees2,
        beyond: beyond / judged,
        worst_sigmas,
        end_error_deg: end_rad / RAD_PER_DEG,
        end_sigmas,
        nis: nis / f64::from(SAMPLES),
    }
}

/// A run of the bank, with the bank at its end.
pub(crate) fn bank_run(thread: Thread, run: u32) -> (Outcome, HysteresisBank) {
    let mut run = Run::new(thread, run);
    let mut bank = run.bank();
    (watched(&mut run, &mut bank), bank)
}

/// A run of the linear thread's filter with its innovation test, with its alarms.
pub(crate) fn tested_run(thread: Thread, run: u32) -> (Outcome, u64) {
    let mut run = Run::new(thread, run);
    let mut filter = TestedFilter::new(&run.config(), &InnovationTest::STANDARD).unwrap();
    let outcome = watched(&mut run, &mut filter);
    (outcome, filter.alarms())
}

/// Runs 0 to `runs`, an even number.
pub(crate) fn all<T: Send>(runs: u32, of: impl Fn(u32) -> T + Sync) -> Vec<T> {
    let half = |parity: u32| (0..runs / 2).map(|k| of(2 * k + parity)).collect::<Vec<T>>();
    let (even, odd) = std::thread::scope(|scope| {
        let odd = scope.spawn(|| half(1));
        let even = half(0);
        (even, odd.join().expect("no run panics"))
    });
    even.into_iter().zip(odd).flat_map(|(a, b)| [a, b]).collect()
}

/// Runs a case has: few, unless more are asked for.
pub(crate) fn runs(few: u32) -> u32 {
    let asked = std::env::var("STRUNA_HYSTERESIS_RUNS").ok();
    asked.and_then(|runs| runs.parse().ok()).unwrap_or(few)
}

pub(crate) fn mean<'a>(
    outcomes: impl IntoIterator<Item = &'a Outcome>,
    of: impl Fn(&Outcome) -> f64,
) -> f64 {
    let (sum, count) =
        outcomes.into_iter().fold((0.0, 0.0), |(sum, count), one| (sum + of(one), count + 1.0));
    sum / count
}

pub(crate) fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
