//! `[body]`: the body on its string, one file for each section below it.

mod backend;
mod disturbance;
mod drag;
mod places;
mod start;
mod string;
mod support;
mod torsion;

use super::environment;
use super::numbers::{or, pair, section, triple};
use struna_body::{
    Backend, Body, BodyError, BodyParams, Rig, StartErrors, StartState, TruthMotion,
    earth_rate_w_rad_s,
};
use struna_kernel::Seed;
use struna_settings::{Result, Table, Value};

/// The body model, judged and ready to move.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelSource {
    /// Body, string, support, air and disturbances. What is random in it is keyed by
    /// [`Self::motion`].
    pub rig: Rig,
    /// How it is meant to start.
    pub start: StartState,
    /// How far the start of a run is off.
    pub start_errors: StartErrors,
    /// What moves it.
    pub backend: Backend,
}

impl ModelSource {
    /// The motion of run `run` of the campaign `seed`: its own start, noise and impulses.
    ///
    /// # Errors
    /// [`BodyError`] when the start that this run draws is impossible, or the backend cannot do
    /// what the rig asks for.
    pub fn motion(&self, seed: Seed, run: u64) -> std::result::Result<TruthMotion, BodyError> {
        let mut rig = self.rig.clone();
        (rig.disturbances.seed, rig.disturbances.run) = (seed, run);
        TruthMotion::new(rig, &self.start.disturbed(&self.start_errors, seed, run), self.backend)
    }
}

const KEYS: [&str; 14] = [
    "mass_kg",
    "com_depth_m",
    "com_offset_m",
    "inertia_kg_m2",
    "products_of_inertia_kg_m2",
    "gravity_m_s2",
    "backend",
    "integrator",
    "string",
    "torsion",
    "drag",
    "support",
    "disturbance",
    "start",
];

/// The body model of a scenario, refused where it cannot move.
pub(super) fn model(root: &Table<'_>) -> Result<ModelSource> {
    let body = root.required("body")?.table()?;
    body.only(&KEYS)?;
    let thread = torsion::thread(&body.required("torsion")?.table()?)?;
    let params = BodyParams {
        mass_kg: body.required("mass_kg")?.positive()?,
        com_depth_m: body.required("com_depth_m")?.positive()?,
        com_offset_m: or(&body, "com_offset_m", |v| pair(v, Value::number), [0.0; 2])?,
        inertia_kg_m2: triple(&body.required("inertia_kg_m2")?, Value::positive)?,
        products_kg_m2: or(&body, "products_of_inertia_kg_m2", products, [0.0; 3])?,
        gravity_m_s2: or(&body, "gravity_m_s2", Value::positive, 9.81)?,
        torsion: thread.torsion,
    };
    let refused = |error: BodyError| places::refusal(&body, &error);
    let rig = Rig {
        string_length_m: section(&body, "string", string::length_m)?,
        hysteresis: thread.hysteresis,
        creep: thread.creep,
        drag: section(&body, "drag", drag::drag)?.unwrap_or_default(),
        support: section(&body, "support", support::support)?.unwrap_or_default(),
        disturbances: section(&body, "disturbance", disturbance::disturbances)?.unwrap_or_default(),
        earth_rate_w_rad_s: environment::latitude_rad(root)?
            .map(earth_rate_w_rad_s)
            .unwrap_or_default(),
        ..Rig::from(Body::new(&params).map_err(refused)?)
    };
    let (start, start_errors) = start::start(&body)?;
    let backend = backend::backend(&body)?;
    TruthMotion::new(rig.clone(), &start, backend).map_err(refused)?;
    Ok(ModelSource { rig, start, start_errors, backend })
}

fn products(value: &Value<'_>) -> Result<[f64; 3]> {
    triple(value, Value::number)
}
