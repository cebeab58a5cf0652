//! Steps of the true motion by RK4, beside MuJoCo's RK4 on the same body.

use crate::table::Row;
use crate::timing::{Burst, best_in_turns, time_per_unit};
use anyhow::{Context, Result, bail, ensure};
use std::io::{BufRead, BufReader, ErrorKind, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use struna_body::{
    Body, BodyParams, Integrator, StartState, Torsion, TorsionStiffness, TruthMotion, reference,
};
use struna_kernel::SimTime;

const STEP_S: f64 = 1e-3;
const STEPS_PER_BURST: u32 = 5_000;
/// Steps after which the two motions are compared.
const STEPS_COMPARED: u32 = 1_000;
/// 80 was measured, 5.9e6 beside 0.07e6 steps/s on one core.
const TARGET_RATIO: f64 = 50.0;

/// The reference body on a string without torsion, which MuJoCo cannot do natively.
const PARAMS: BodyParams = BodyParams {
    torsion: Torsion {
        stiffness: TorsionStiffness::ConstantNMRad(0.0),
        ..reference::PARAMS.torsion
    },
    ..reference::PARAMS
};
const START: StartState = reference::S3;

pub(crate) fn rows() -> Result<Vec<Row>> {
    let mut ours = Truth::start()?;
    let mut peer = MuJoCo::start()?;
    if let Some(peer) = &mut peer {
        same_motion(&mut ours, peer)?;
    }
    let (ours_s, peer_s) = match &mut peer {
        Some(peer) => {
            let [ours_s, peer_s] =
                best_in_turns([ours.burst(), Box::new(|| peer.step(STEPS_PER_BURST))])?;
            (ours_s, Some(peer_s))
        }
        None => (best_in_turns([ours.burst()])?[0], None),
    };
    Ok(vec![Row {
        what: "truth motion, RK4 at 1 ms (S3, no torsion)".into(),
        ours: steps_per_s(ours_s),
        other: match (&peer, peer_s) {
            (Some(peer), Some(s)) => format!("{} ({} RK4)", steps_per_s(s), peer.version),
            _ => "not available (mujoco in .venv)".into(),
        },
        ratio: peer_s.map(|peer_s| peer_s / ours_s),
        target: TARGET_RATIO,
    }])
}

fn steps_per_s(s: f64) -> String {
    format!("{:.2}e6 steps/s", 1e-6 / s)
}

/// Our motion, walked on in bursts.
struct Truth {
    motion: TruthMotion,
    steps: u32,
}

impl Truth {
    fn start() -> Result<Self> {
        let integrator = Integrator::Rk4 { step_s: STEP_S };
        Ok(Self { motion: TruthMotion::new(Body::new(&PARAMS)?, &START, integrator)?, steps: 0 })
    }

    /// Steps on; gives the vertical component of the body axis.
    #[inline(never)]
    fn step(&mut self, steps: u32) -> Result<f64> {
        self.steps += steps;
        let motion = self.motion.motion_at(SimTime::from_s(f64::from(self.steps) * STEP_S)?)?;
        Ok(1.0 - 2.0 * (motion.q_wb.i.powi(2) + motion.q_wb.j.powi(2)))
    }

    fn burst(&mut self) -> Burst<'_> {
        Box::new(|| {
            time_per_unit(STEPS_PER_BURST as usize, || self.step(STEPS_PER_BURST).map(drop))
        })
    }
}

/// MuJoCo in a process of its own, which times itself around one native call.
struct MuJoCo {
    process: Child,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
    version: String,
    /// Vertical component of the body axis after the last burst.
    upright: f64,
}

impl MuJoCo {
    /// None when Python's environment or MuJoCo is not there.
    fn start() -> Result<Option<Self>> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let q = START.attitude();
        let attitude = [q.w, q.i, q.j, q.k].into_iter().chain(START.omega_wb_b_rad_s);
        let spawned = Command::new(root.join(".venv/bin/python"))
            .arg(root.join("benches/mujoco_rk4.py"))
            .args(attitude.map(|number| format!("{number:e}")))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn();
        let mut process = match spawned {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            spawned => spawned.context("cannot start Python")?,
        };
        let requests = process.stdin.take().context("Python has no input")?;
        let answers = BufReader::new(process.stdout.take().context("Python has no output")?);
        let mut peer = Self { process, requests, answers, version: String::new(), upright: 0.0 };
        match peer.answer()?.as_str() {
            "missing" => Ok(None),
            version => {
                peer.version = version.to_owned();
                Ok(Some(peer))
            }
        }
    }

    fn answer(&mut self) -> Result<String> {
        let mut line = String::new();
        if self.answers.read_line(&mut line)? == 0 {
            bail!("mujoco_rk4.py ended without an answer");
        }
        Ok(line.trim().to_owned())
    }

    /// Seconds per step of a burst.
    fn step(&mut self, steps: u32) -> Result<f64> {
        writeln!(self.requests, "{steps}")?;
        let answer = self.answer()?;
        let (taken_s, upright) = answer.split_once(' ').context("MuJoCo's answer is incomplete")?;
        self.upright = upright.parse()?;
        Ok(taken_s.parse::<f64>()? / f64::from(steps))
    }
}

impl Drop for MuJoCo {
    fn drop(&mut self) {
        // It may have ended by itself; either way nothing is left to be told.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// A ratio of two different motions would say nothing.
fn same_motion(ours: &mut Truth, peer: &mut MuJoCo) -> Result<()> {
    let upright = ours.step(STEPS_COMPARED)?;
    peer.step(STEPS_COMPARED)?;
    let off = (upright - peer.upright).abs();
    // Both err by some 1e-9 rad a minute at this step.
    ensure!(off < 1e-9, "after {STEPS_COMPARED} steps MuJoCo's body axis is off by {off:e}");
    Ok(())
}
