//! The motion by rapier: its time beside the promise, its error beside MuJoCo's default method.

use crate::table::Row;
use crate::timing::{Burst, best_in_turns, time_per_unit};
use anyhow::{Context, Result, ensure};
use std::io::ErrorKind;
use std::path::Path;
use std::process::Command;
use struna_body::{Body, Integrator, RapierMotion, StartState, TruthMotion, reference};
use struna_kernel::SimTime;

const STEP_S: f64 = 1e-3;
/// How long a run of the experiment lasts, and how long it may take.
const RUN_S: f64 = 480.0;
const LIMIT_S: f64 = 1.5;
/// Simulated seconds per burst.
const BURST_S: u32 = 2;
/// Simulated seconds after which errors are compared.
const COMPARED_S: u32 = 60;
/// 4.5e-4 rad was measured beside 6.4e-2 rad when the two were first compared.
const TARGET_ERROR_RATIO: f64 = 100.0;
const START: StartState = reference::S3;

pub(crate) fn rows() -> Result<Vec<Row>> {
    Ok(vec![time_row()?, error_row()?])
}

fn time_row() -> Result<Row> {
    let mut motion = RapierMotion::new(&Body::new(&reference::PARAMS)?.into(), &START, STEP_S)?;
    let mut seconds = 0;
    let burst: Burst<'_> = Box::new(|| {
        seconds += BURST_S;
        let time = SimTime::from_s(f64::from(seconds))?;
        time_per_unit(BURST_S as usize, || {
            motion.motion_at(time)?;
            Ok(())
        })
    });
    let [per_second] = best_in_turns([burst])?;
    let run_s = RUN_S * per_second;
    Ok(Row {
        what: "480 s of rapier truth at 1 ms (S3)".into(),
        ours: format!("{run_s:.2} s"),
        other: format!("{LIMIT_S} s (limit)"),
        ratio: Some(LIMIT_S / run_s),
        target: 1.0,
    })
}

fn error_row() -> Result<Row> {
    let body = Body::new(&reference::PARAMS)?;
    let end = SimTime::from_s(f64::from(COMPARED_S))?;
    let record = Integrator::Dop853 { rtol: 1e-12, atol: 1e-12 };
    let exact = TruthMotion::new(body, &START, record)?.motion_at(end)?.q_wb;
    let error_rad = |[w, x, y, z]: [f64; 4]| {
        // Vector part of the quaternion between the two.
        let [ew, ex, ey, ez] = [exact.w, exact.i, exact.j, exact.k];
        let [i, j, k] = [
            ew * x - ex * w - ey * z + ez * y,
            ew * y + ex * z - ey * w - ez * x,
            ew * z - ex * y + ey * x - ez * w,
        ];
        2.0 * (i * i + j * j + k * k).sqrt().min(1.0).asin()
    };
    let q = RapierMotion::new(&body.into(), &START, STEP_S)?.motion_at(end)?.q_wb;
    let ours_rad = error_rad([q.w, q.i, q.j, q.k]);
    let peer = mujoco(&body)?.map(|(version, attitude)| (version, error_rad(attitude)));
    Ok(Row {
        what: "rapier truth's error after 60 s at 1 ms (S3)".into(),
        ours: format!("{ours_rad:.2e} rad"),
        other: match &peer {
            Some((version, rad)) => format!("{rad:.2e} rad ({version} Euler)"),
            None => "not available (mujoco in .venv)".into(),
        },
        ratio: peer.map(|(_, rad)| rad / ours_rad),
        target: TARGET_ERROR_RATIO,
    })
}

/// MuJoCo's version and the attitude it ends at; none when Python's environment or MuJoCo is not
/// there.
fn mujoco(body: &Body) -> Result<Option<(String, [f64; 4])>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let q = START.attitude();
    let steps = (f64::from(COMPARED_S) / STEP_S).round();
    let numbers = [STEP_S, steps, body.stiffness_n_m_rad(), START.twist_rad, q.w, q.i, q.j, q.k];
    let run = Command::new(root.join(".venv/bin/python"))
        .arg(root.join("benches/mujoco_error.py"))
        .args(numbers.into_iter().chain(START.omega_wb_b_rad_s).map(|number| number.to_string()))
        .output();
    let run = match run {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        run => run.context("cannot start Python")?,
    };
    ensure!(run.status.success(), "mujoco_error.py: {}", String::from_utf8_lossy(&run.stderr));
    let answer = String::from_utf8(run.stdout)?;
    let mut lines = answer.lines();
    let version = lines.next().context("mujoco_error.py said nothing")?;
    if version == "missing" {
        return Ok(None);
    }
    let attitude = lines.next().context("mujoco_error.py gave no attitude")?;
    let attitude = attitude.split(' ').map(str::parse).collect::<Result<Vec<f64>, _>>()?;
    let attitude = attitude.try_into().ok().context("an attitude has four numbers")?;
    Ok(Some((version.to_owned(), attitude)))
}
