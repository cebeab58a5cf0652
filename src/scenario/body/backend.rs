//! `backend` of `[body]` and `[body.integrator]`: what computes the motion.

use super::super::numbers::or;
use struna_body::{Backend, Integrator};
use struna_settings::{Result, Table, Value};

/// Follows the reference motions to 1e-7 rad over eight minutes.
const RK4_STEP_S: f64 = 1e-3;
/// Rapier is of second order: 7e-5 rad over eight minutes.
const RAPIER_STEP_S: f64 = 2e-4;

pub(super) fn backend(body: &Table<'_>) -> Result<Backend> {
    let words = [("lagrange", true), ("rapier", false)];
    match or(body, "backend", |value| value.word(&words), true)? {
        true => integrator(body).map(Backend::Lagrange),
        false => rapier(body),
    }
}

fn integrator(body: &Table<'_>) -> Result<Integrator> {
    let Some(integrator) = body.optional("integrator") else {
        return Ok(Integrator::Rk4 { step_s: RK4_STEP_S });
    };
    let integrator = integrator.table()?;
    match integrator.required("method")?.word(&[("rk4", true), ("dop853", false)])? {
        true => {
            integrator.only(&["method", "step_s"])?;
            Ok(Integrator::Rk4 { step_s: step_s(&integrator.required("step_s")?)? })
        }
        false => {
            integrator.only(&["method", "relative_tolerance", "absolute_tolerance"])?;
            let tolerance = |key: &str, default: f64| {
                or(&integrator, key, |value| value.number_in(1e-14..=1e-2), default)
            };
            Ok(Integrator::Dop853 {
                rtol: tolerance("relative_tolerance", 1e-12)?,
                atol: tolerance("absolute_tolerance", 1e-12)?,
            })
        }
    }
}

fn rapier(body: &Table<'_>) -> Result<Backend> {
    let Some(integrator) = body.optional("integrator") else {
        return Ok(Backend::Rapier { step_s: RAPIER_STEP_S });
    };
    let integrator = integrator.table()?;
    if let Some(method) = integrator.optional("method") {
        let reason = "rapier has one method of its own; remove this key or choose \
                      backend = \"lagrange\"";
        return Err(method.because(reason));
    }
    integrator.only(&["step_s"])?;
    Ok(Backend::Rapier { step_s: or(&integrator, "step_s", step_s, RAPIER_STEP_S)? })
}

/// Shorter steps only take time. How long one may be depends on the rig, which judges it.
fn step_s(value: &Value<'_>) -> Result<f64> {
    value.number_in(1e-6..=1.0)
}
