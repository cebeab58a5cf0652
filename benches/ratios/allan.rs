//! The Allan deviation of an hour at 300 Hz beside allantools, on one thread each.

use crate::table::Row;
use crate::timing::{Burst, best_in_turns, time_per_unit};
use anyhow::{Context, Result, bail, ensure};
use std::hint::black_box;
use std::io::{BufRead, BufReader, ErrorKind, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use struna_gyro::characterise::{CumulativeAngle, TauGrid};
use struna_kernel::{Channel, RandomStream, Seed};

const SAMPLES: usize = 1_080_000;
/// Up to a third of the record, where the curve ends.
const FACTOR_MAX: usize = SAMPLES / 3 - 1;
const TARGET: f64 = 3.0;

pub(crate) fn rows() -> Result<Vec<Row>> {
    // Any channel does; it only keys the stream.
    let mut stream = RandomStream::new(Seed(1), Channel::GyroAngleRandomWalk, 0);
    let rates: Vec<f64> = (0..SAMPLES).map(|_| stream.standard_normal()).collect();
    let factors = TauGrid::TenPerDecade.factors(FACTOR_MAX);
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("rates");
    std::fs::write(&path, rates.iter().flat_map(|rate| rate.to_le_bytes()).collect::<Vec<_>>())?;
    let mut ours = || -> Result<f64> {
        time_per_unit(1, || {
            black_box(deviations(black_box(&rates), &factors)?);
            Ok(())
        })
    };
    let (ours_s, peer) = match Allantools::start(&path, &factors)? {
        Some(mut peer) => {
            same_deviations(&rates, &factors, &mut peer)?;
            let theirs: Burst<'_> = Box::new(|| Ok(peer.burst()?.0));
            let [ours_s, theirs_s] = best_in_turns([Box::new(&mut ours), theirs])?;
            (ours_s, Some((theirs_s, peer.version.clone())))
        }
        None => (best_in_turns([Box::new(&mut ours)])?[0], None),
    };
    let milliseconds = |s: f64| format!("{:.1} ms", 1e3 * s);
    Ok(vec![Row {
        what: format!("Allan deviation of {SAMPLES} rates at {} tau", factors.len()),
        ours: milliseconds(ours_s),
        other: match &peer {
            Some((theirs_s, version)) => format!("{} ({version})", milliseconds(*theirs_s)),
            None => "not available (allantools in .venv)".into(),
        },
        ratio: peer.map(|(theirs_s, _)| theirs_s / ours_s),
        target: TARGET,
    }])
}

/// All deviations, the summing up of the angle included, as allantools includes it.
fn deviations(rates: &[f64], factors: &[usize]) -> Result<Vec<f64>> {
    let mean = rates.iter().sum::<f64>() / rates.len() as f64;
    let angle = CumulativeAngle::of(rates, mean);
    let deviation = |factor: &usize| angle.allan_variance(*factor).map(f64::sqrt);
    factors.iter().map(deviation).collect::<Option<_>>().context("too few samples")
}

/// A ratio of two different calculations would say nothing.
fn same_deviations(rates: &[f64], factors: &[usize], peer: &mut Allantools) -> Result<()> {
    let (ours, theirs) = (deviations(rates, factors)?.iter().sum::<f64>(), peer.burst()?.1);
    ensure!((ours / theirs - 1.0).abs() < 1e-10, "the deviations add up to {ours} and {theirs}");
    Ok(())
}

/// allantools in a process of its own, which times itself.
struct Allantools {
    process: Child,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
    version: String,
}

impl Allantools {
    /// None when Python's environment or allantools is not there.
    fn start(path: &Path, factors: &[usize]) -> Result<Option<Self>> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let spawned = Command::new(root.join(".venv/bin/python"))
            .arg("-B") // leaves no byte code beside the script
            .arg(root.join("benches/ratios/allantools_speed.py"))
            .arg(path)
            .args(factors.iter().map(ToString::to_string))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn();
        let mut process = match spawned {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            spawned => spawned.context("cannot start Python")?,
        };
        let requests = process.stdin.take().context("Python has no input")?;
        let answers = BufReader::new(process.stdout.take().context("Python has no output")?);
        let mut peer = Self { process, requests, answers, version: String::new() };
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
            bail!("allantools_speed.py ended without an answer");
        }
        Ok(line.trim().to_owned())
    }

    /// Wall time in s, and the sum of the deviations.
    fn burst(&mut self) -> Result<(f64, f64)> {
        writeln!(self.requests)?;
        let answer = self.answer()?;
        let (taken_s, sum) = answer.split_once(' ').context("allantools' answer is incomplete")?;
        Ok((taken_s.parse()?, sum.parse()?))
    }
}

impl Drop for Allantools {
    fn drop(&mut self) {
        // It may have ended by itself; either way nothing is left to be told.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
