//! `struna hil`.

use super::Outcome;
use super::screen::StatusLine;
use crate::cli::Hil;
use crate::hil::recorder::Screen;
use crate::hil::serial::{SerialSource, WallClock};
use crate::hil::setup::{ScenarioText, Setup, frame_text, read_text};
use crate::hil::{self, Bench, Finished, SETUP, choose};
use anyhow::{Context, Result, bail, ensure};
use std::path::{Path, PathBuf};
use struna_harness::live::Ended;
use struna_kernel::SimTime;
use struna_line::StopFlag;

const US_PER_S: f64 = 1e6;

pub(super) fn execute(args: &Hil) -> Result<Outcome> {
    match (&args.replay, &args.port) {
        (Some(folder), _) => replay(args, folder),
        (None, Some(port)) => live(args, port),
        (None, None) => bail!("name a port with --port"),
    }
}

fn live(args: &Hil, port: &Path) -> Result<Outcome> {
    let setup = changed(Setup::new(None, None), args)?;
    let plan = setup.plan()?;
    let baud = args.baud.unwrap_or(plan.frame.line().baud);
    let port = match port == Path::new("auto") {
        true => choose::port(&plan.frame, baud)?,
        false => port.to_owned(),
    };
    let stop = StopFlag::new();
    let on_interrupt = stop.clone();
    ctrlc::set_handler(move || on_interrupt.stop()).context("cannot listen for Ctrl-C")?;
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from("out/hil"));
    let mut source = SerialSource::open(&port, baud)?;
    let name = format!("{} at {baud} baud", source.name().display());
    let mut screen = StatusLine::new();
    screen.say(&format!("listening to {name}; Ctrl-C ends the run"));
    let until = args.duration.map(SimTime::from_s).transpose()?;
    let bench = Bench { out: &out, screen: &mut screen, stop: &stop, until, strict: args.strict };
    let finished = hil::run(&setup, &name, &mut source, &mut WallClock::start(), bench);
    screen.finish();
    let finished = finished.with_context(|| format!("recorded so far in {}", out.display()))?;
    show(&finished, &out, "record.csv, events.csv, report.json, raw.bin, raw.csv, setup.json");
    match finished.ended {
        Ended::TimeUp => Ok(Outcome::Complete),
        Ended::Stopped => Ok(Outcome::Interrupted),
        Ended::NoFrames => {
            let frame = plan.frame.name();
            let sniff = format!("struna frame sniff --port {}", port.display());
            bail!(
                "no frame of {frame} came from {}; try another --baud or `{sniff}`",
                port.display()
            )
        }
    }
}

fn replay(args: &Hil, folder: &Path) -> Result<Outcome> {
    let setup = changed(Setup::read(&folder.join(SETUP))?, args)?;
    let out = args.out.clone().unwrap_or_else(|| folder.join("replay"));
    let same = std::fs::canonicalize(&out).ok() == std::fs::canonicalize(folder).ok();
    ensure!(!same, "the replay would overwrite {}; choose another --out", folder.display());
    let mut screen = StatusLine::new();
    let finished = hil::replay(&setup, folder, &out, &mut screen);
    screen.finish();
    show(&finished?, &out, "record.csv, events.csv, report.json");
    Ok(Outcome::Complete)
}

fn show(finished: &Finished, out: &Path, files: &str) {
    println!("{}\n\nwritten to {}: {files}", finished.report, out.display());
}

/// `setup` with what was typed in place of what it says.
fn changed(mut setup: Setup, args: &Hil) -> Result<Setup> {
    if let Some(frame) = &args.frame {
        setup.frame_toml = Some(frame_text(frame)?);
    }
    if let Some(path) = &args.scenario {
        setup.scenario = Some(ScenarioText { path: path.clone(), text: read_text(path)? });
    }
    if !args.estimators.is_empty() {
        setup.estimators.clone_from(&args.estimators);
    }
    setup.averaging_samples = args.averaging.or(setup.averaging_samples);
    setup.torsion_period_s = args.period_s.or(setup.torsion_period_s);
    setup.angle_start_deg = args.angle_start_deg.unwrap_or(setup.angle_start_deg);
    setup.latency_s = args.latency_us.map_or(setup.latency_s, |us| us / US_PER_S);
    Ok(setup)
}
