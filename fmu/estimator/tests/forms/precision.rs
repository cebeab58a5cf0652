//! What single precision costs, and where it is lost.
//!
//! At 100 Hz and T = 480 s, cos Ωh = 1 − 8.6e-9 rounds to 1, and Φ then has a determinant of
//! 1 + (Ωh)²: the angle's variance grows where it should turn into the rate's. That explains part
//! of what f32 shows. The other part is of the same kind: a step changes P by less than P's own
//! last digits, so that the sums round what they should add up.

use crate::forms::{Compensated, Form, Incremental, Joseph, Model, Real, Scaled};
use crate::{STEP_S, model};

/// Until the angle's variance is steady to nine digits, and as many again to average over.
const STEPS: u32 = 2_000_000;
const Q: f64 = 1e-6;
const R: f64 = 2e-3;

/// Steady variance of the angle, in the mean over the second half.
fn steady<T: Real, F: Form<T>>(model: &Model<T>) -> f64 {
    let mut form = F::start(T::of(1.0), T::of(1.0));
    for _ in 0..STEPS {
        form.step(model);
    }
    let mut sum = 0.0;
    for _ in 0..STEPS {
        form.step(model);
        sum += form.matrix()[0];
    }
    sum / f64::from(STEPS)
}

/// In double precision, of the model or of one spoilt.
fn off(model: &Model<f64>, increments: bool) -> f64 {
    let right = steady::<f64, Joseph<f64>>(&crate::model(STEP_S, Q, R));
    let found = if increments {
        steady::<f64, Incremental<f64>>(model)
    } else {
        steady::<f64, Joseph<f64>>(model)
    };
    found / right - 1.0
}

#[test]
fn the_cosine_of_a_step_rounds_to_one_in_single_precision() {
    let (wide, narrow) = (model::<f64>(STEP_S, Q, R), model::<f32>(STEP_S, Q, R));
    assert!(wide.f11 < 1.0 && narrow.f11.to_bits() == 1_f32.to_bits());
    let determinant = narrow.f11.wide().powi(2) - narrow.f12.wide() * narrow.f21.wide();
    let omega_h = std::f64::consts::TAU / crate::PERIOD_S * STEP_S;
    // 1e-3 of the excess itself: the coefficients have seven digits, the difference eight of 1.
    assert!(((determinant - 1.0) / omega_h.powi(2) - 1.0).abs() < 1e-3, "{determinant}");
}

#[test]
fn a_cosine_of_one_is_an_error_of_its_own_and_its_sine_repairs_it() {
    let exact = model::<f64>(STEP_S, Q, R);
    let rounded = |x: f64| f32::of(x).wide();
    let spoilt = Model { f11: rounded(exact.f11), f22: rounded(exact.f22), ..exact };
    let by_cosine = off(&spoilt, false);
    println!("cosine of 1: {by_cosine:+.5}");
    // 0.11263 %, from the algebraic Riccati equation with and without the cosine.
    assert!((by_cosine / 1.1263e-3 - 1.0).abs() < 1e-3, "{by_cosine}");
    let all_spoilt = Model {
        f12: rounded(exact.f12),
        f21: rounded(exact.f21),
        less: rounded(exact.less),
        ..spoilt
    };
    // Every coefficient in single precision, and no harm: seven digits in, six out.
    let repaired = off(&all_spoilt, true);
    assert!(repaired.abs() < 1e-6, "{repaired}");
}

#[test]
fn in_single_precision_throughout_the_sums_have_to_be_repaired_too() {
    let right = steady::<f64, Joseph<f64>>(&model(STEP_S, Q, R));
    let narrow = model::<f32>(STEP_S, Q, R);
    let plain = steady::<f32, Joseph<f32>>(&narrow) / right - 1.0;
    let increments = steady::<f32, Incremental<f32>>(&narrow) / right - 1.0;
    let compensated = steady::<f32, Compensated<f32>>(&narrow) / right - 1.0;
    println!("{plain:+.5} {increments:+.5} {compensated:+.7}");
    assert!((3e-3..6e-3).contains(&plain), "{plain}");
    assert!(increments > 0.0 && increments < 0.6 * plain, "{increments} of {plain}");
    assert!(compensated.abs() < 1e-5, "{compensated}");
}

/// The forms differ in rounding alone where they have the digits.
#[test]
fn in_double_precision_the_forms_agree() {
    let model = model::<f64>(STEP_S, Q, R);
    let joseph = steady::<f64, Joseph<f64>>(&model);
    for other in [
        steady::<f64, crate::forms::Standard<f64>>(&model),
        steady::<f64, Scaled<f64>>(&model),
        steady::<f64, Incremental<f64>>(&model),
        steady::<f64, crate::forms::Factored<f64>>(&model),
    ] {
        // The same digits are lost as in f32: 0.3 % of 6e-8 per ulp there, so 5e-12 here.
        assert!((other / joseph - 1.0).abs() < 3e-11, "{other:e} against {joseph:e}");
    }
}
