//! `[source]` and `[body]`: where the motion comes from.

use std::path::{Path, PathBuf};
use struna_body::{
    Body, BodyError, BodyParams, Integrator, StartState, Torsion, TorsionDamping, TorsionStiffness,
};
use struna_kernel::RAD_PER_DEG;
use struna_settings::{Result, Table, Value};

/// Where the motion comes from.
#[derive(Debug, Clone)]
pub enum Source {
    /// The body model.
    Model(ModelSource),
    /// A recorded rate.
    Recording(RecordingSource),
}

/// The body model, ready to be integrated.
#[derive(Debug, Clone)]
pub struct ModelSource {
    /// The body, judged.
    pub body: Body,
    /// How it starts.
    pub start: StartState,
    /// How it is integrated.
    pub integrator: Integrator,
}

/// A recorded rate in a CSV file.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingSource {
    /// The file.
    pub file: PathBuf,
    /// Column of the time, s.
    pub time_column: String,
    /// Column of the rate.
    pub rate_column: String,
    /// What one unit of the rate column is in rad/s.
    pub rad_s_per_unit: f64,
}

pub(super) fn source(root: &Table<'_>, folder: &Path) -> Result<Source> {
    let Some(source) = root.optional("source") else { return model(root) };
    let source = source.table()?;
    match source.required("kind")?.word(&[("model", true), ("recording", false)])? {
        true => {
            source.only(&["kind"])?;
            model(root)
        }
        false => recording(root, &source, folder),
    }
}

fn recording(root: &Table<'_>, source: &Table<'_>, folder: &Path) -> Result<Source> {
    source.only(&["kind", "file", "time_column", "rate_column", "unit"])?;
    if let Some(body) = root.optional("body") {
        return Err(body.because("a recording moves no body; remove [body] or the recording"));
    }
    let text = |key: &str| source.required(key)?.text().map(str::to_owned);
    let units = [("deg/s", RAD_PER_DEG), ("rad/s", 1.0), ("mdeg/s", RAD_PER_DEG / 1e3)];
    Ok(Source::Recording(RecordingSource {
        file: folder.join(text("file")?),
        time_column: text("time_column")?,
        rate_column: text("rate_column")?,
        rad_s_per_unit: source.required("unit")?.word(&units)?,
    }))
}

fn model(root: &Table<'_>) -> Result<Source> {
    let body = root.required("body")?.table()?;
    body.only(&[
        "mass_kg",
        "com_depth_m",
        "inertia_kg_m2",
        "gravity_m_s2",
        "torsion",
        "start",
        "integrator",
    ])?;
    let inertia = body.required("inertia_kg_m2")?;
    let params = BodyParams {
        mass_kg: body.required("mass_kg")?.positive()?,
        com_depth_m: body.required("com_depth_m")?.positive()?,
        com_offset_m: [0.0; 2],
        inertia_kg_m2: triple(&inertia, Value::positive)?,
        products_kg_m2: [0.0; 3],
        gravity_m_s2: or(&body, "gravity_m_s2", Value::positive, 9.81)?,
        torsion: torsion(&body.required("torsion")?.table()?)?,
    };
    let refused = |error: BodyError| match error {
        BodyError::Parameter(parameter) if parameter.name.starts_with("inertia") => {
            inertia.because(error.to_string())
        }
        _ => body.because(error.to_string()),
    };
    Ok(Source::Model(ModelSource {
        body: Body::new(&params).map_err(refused)?,
        start: start(&body)?,
        integrator: integrator(&body)?,
    }))
}

fn torsion(torsion: &Table<'_>) -> Result<Torsion> {
    torsion.only(&["period_s", "stiffness_n_m_rad", "damping_ratio", "damping_n_m_s_rad"])?;
    let stiffness = match (torsion.optional("period_s"), torsion.optional("stiffness_n_m_rad")) {
        (Some(period), None) => TorsionStiffness::PeriodS(period.positive()?),
        (None, Some(k)) => TorsionStiffness::ConstantNMRad(k.positive()?),
        (None, None) => {
            return Err(torsion.because("give either `period_s` or `stiffness_n_m_rad`"));
        }
        (Some(_), Some(k)) => return Err(k.because("contradicts `period_s`; remove one of them")),
    };
    let ratio = torsion.optional("damping_ratio");
    let damping = match (ratio, torsion.optional("damping_n_m_s_rad")) {
        (ratio, None) => {
            TorsionDamping::Ratio(ratio.map_or(Ok(0.0), |ratio| ratio.not_negative())?)
        }
        (None, Some(c)) => TorsionDamping::CoefficientNMSRad(c.not_negative()?),
        (Some(_), Some(c)) => {
            return Err(c.because("contradicts `damping_ratio`; remove one of them"));
        }
    };
    Ok(Torsion { stiffness, damping })
}

fn start(body: &Table<'_>) -> Result<StartState> {
    let Some(start) = body.optional("start") else { return Ok(StartState::AT_REST) };
    let start = start.table()?;
    start.only(&["twist_deg", "tilt_deg", "tilt_azimuth_deg", "body_rate_deg_s"])?;
    let angle_rad =
        |key: &str| -> Result<f64> { Ok(or(&start, key, Value::number, 0.0)? * RAD_PER_DEG) };
    let rate_deg_s = match start.optional("body_rate_deg_s") {
        Some(rate) => triple(&rate, Value::number)?,
        None => [0.0; 3],
    };
    let state = StartState {
        tilt_rad: angle_rad("tilt_deg")?,
        tilt_azimuth_rad: angle_rad("tilt_azimuth_deg")?,
        twist_rad: angle_rad("twist_deg")?,
        omega_wb_b_rad_s: rate_deg_s.map(|rate| rate * RAD_PER_DEG),
        ..StartState::AT_REST
    };
    state.check().map_err(|error| start.because(error.to_string()))?;
    Ok(state)
}

fn integrator(body: &Table<'_>) -> Result<Integrator> {
    let Some(integrator) = body.optional("integrator") else {
        return Ok(Integrator::Rk4 { step_s: 1e-3 });
    };
    let integrator = integrator.table()?;
    match integrator.required("method")?.word(&[("rk4", true), ("dop853", false)])? {
        true => {
            integrator.only(&["method", "step_s"])?;
            let step_s = integrator.required("step_s")?;
            // The fastest motion is the swing at 1.5 Hz; beyond 50 ms RK4 no longer follows it.
            Ok(Integrator::Rk4 { step_s: step_s.number_in(1e-6..=0.05)? })
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

/// The value of `key`, or `default` when it is absent.
fn or<'a, T>(
    table: &Table<'a>,
    key: &str,
    get: impl Fn(&Value<'a>) -> Result<T>,
    default: T,
) -> Result<T> {
    table.optional(key).map_or(Ok(default), |value| get(&value))
}

fn triple<'a>(value: &Value<'a>, get: impl Fn(&Value<'a>) -> Result<f64>) -> Result<[f64; 3]> {
    let items = value.array()?;
    let [x, y, z] = items.as_slice() else {
        return Err(value.out_of_range("three numbers, [x, y, z]"));
    };
    Ok([get(x)?, get(y)?, get(z)?])
}
