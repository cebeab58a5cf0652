//! The covariance of the plain two-state filter, carried in other forms and in single precision:
//! why the filters are in the form they are, and in double.
//!
//! The filter itself is [`forms::Scaled`] in f64. The others live here alone, as what it is
//! compared with.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod forms;
mod long_run;
mod precision;

use forms::Model;
use std::f64::consts::TAU;
use struna_estimator::{Motion, TorsionalOscillation};

const PERIOD_S: f64 = 480.0;
const STEP_S: f64 = 0.01;

/// Torsion of the papers' period over `span_s`, with noise density q and measurement variance R.
fn model<T: forms::Real>(span_s: f64, q: f64, r: f64) -> Model<T> {
    let motion = TorsionalOscillation::with_period(PERIOD_S).unwrap();
    let half_sin = (0.5 * TAU / PERIOD_S * span_s).sin();
    Model::new(&motion.transition(span_s), -2.0 * half_sin * half_sin, q, r)
}
