//! `struna emulate`.

use super::Outcome;
use crate::cli::Emulate;
use crate::emulate::{Device, Emission, Emulation, Entry, Status, Summary, Watcher};
use crate::output::{create_folder, write_whole};
use crate::scenario::Scenario;
use crate::{backend, faults};
use anyhow::{Context, Result, anyhow};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use struna_harness::fault::{FaultRecord, write_fault_csv};
use struna_kernel::Seed;
use struna_line::{Client, Delays, DevicePort, Lateness, Pacer, PortCounts, RealTime, StopFlag};

pub(super) fn execute(args: &Emulate) -> Result<Outcome> {
    let mut scenario = Scenario::read(&args.scenario)?;
    if let Some(seed) = args.seed {
        scenario.seed = Seed(seed);
    }
    let frames = Device::frames(&scenario, args.duration.unwrap_or(scenario.duration))?;
    let device = Device::new(&scenario)?;
    for note in faults::unseen(&scenario) {
        println!("{note}");
    }
    let stop = StopFlag::new();
    let on_interrupt = stop.clone();
    ctrlc::set_handler(move || on_interrupt.stop()).context("cannot listen for Ctrl-C")?;
    let link = match &args.link {
        Some(link) => Some(link.clone()),
        None => usual_link(&scenario.name)?,
    };
    let port = DevicePort::open(device.settings, link.as_deref())?;
    let heading = heading(&scenario, &port, link.as_deref());
    let bench = Bench { args, heading, frames, device, port, stop: &stop };
    let summary = match &args.log {
        None => bench.run(None)?,
        Some(path) => logged(path, |log| bench.run(Some(log)))?,
    };
    let Some(summary) = summary else { return Ok(Outcome::Interrupted) };
    println!("{}", closing(&summary));
    if !scenario.faults.is_empty() {
        let usual = || Path::new("out").join(&scenario.name).join("faults.csv");
        let path = args.faults.clone().unwrap_or_else(usual);
        keep_faults(&path, &summary.faults)?;
    }
    match summary.stopped {
        Some(reason) => Err(anyhow::Error::from(reason).context("the motion ended early")),
        None if summary.interrupted => Ok(Outcome::Interrupted),
        None => Ok(Outcome::Complete),
    }
}

/// Writes the truth about the faults beside what a reader of the port may make of them.
fn keep_faults(path: &Path, faults: &[FaultRecord]) -> Result<()> {
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        create_folder(folder)?;
    }
    write_whole(path, |file| write_fault_csv(faults, file))?;
    println!("faults  {}, written to {}", faults.len(), path.display());
    Ok(())
}

/// Where ports have their names unless told otherwise; none on a system without such a place.
fn usual_link(name: &str) -> Result<Option<PathBuf>> {
    let Some(runtime) = std::env::var_os("XDG_RUNTIME_DIR").filter(|path| !path.is_empty()) else {
        return Ok(None);
    };
    let folder = Path::new(&runtime).join("struna");
    create_folder(&folder)?;
    Ok(Some(folder.join(name)))
}

fn heading(scenario: &Scenario, port: &DevicePort, link: Option<&Path>) -> String {
    let node = port.path().unwrap_or(Path::new("")).display();
    let (shown, name) = match link {
        Some(link) => (format!("{} -> {node}", link.display()), link.display().to_string()),
        None => (format!("{node} (for a lasting name: --link PATH)"), node.to_string()),
    };
    format!(
        "{}: {} at {} Hz, {} baud, seed {}, truth by {}\nport    {shown}\nread    struna hil \
         --port {name} --frame {}",
        scenario.name,
        scenario.frame.name(),
        scenario.gyro.sample_rate_hz,
        scenario.line.baud,
        scenario.seed.0,
        backend::sentence(&scenario.source),
        scenario.frame_called,
    )
}

/// What a run takes.
struct Bench<'a> {
    args: &'a Emulate,
    heading: String,
    frames: u64,
    device: Device,
    port: DevicePort,
    stop: &'a StopFlag,
}

impl Bench<'_> {
    /// Plays the device; nothing when it was stopped before it began.
    fn run(self, mut log: Option<&mut dyn Write>) -> Result<Option<Summary>> {
        let Self { args, heading, frames, device, mut port, stop } = self;
        println!("{heading}");
        if let Some(log) = &mut log {
            writeln!(log, "index,sample_ns,due_ns,sent_ns")?;
        }
        if args.wait_for_client {
            println!("waiting for a client");
            if !port.wait_for_client(stop)? {
                return Ok(None);
            }
        }
        if args.rt {
            println!("rt      {}", RealTime::request());
        }
        let mut console = Console::new(device.settings.baud, log);
        let entry = if args.mid_frame { Entry::MidFrame } else { Entry::FrameBoundary };
        let pacer = Pacer::at_speed(args.speed);
        let emulation = Emulation { device, port, pacer, entry, stop };
        let summary = emulation.play(frames, &mut console);
        console.bar.finish_and_clear();
        summary.map(Some)
    }
}

/// Runs `run` with the file `path` to write into; the file is there when it succeeds.
fn logged<T>(path: &Path, run: impl FnOnce(&mut dyn Write) -> Result<T>) -> Result<T> {
    let mut outcome = None;
    write_whole(path, |file| {
        let ran = run(file);
        let failed = ran.is_err();
        outcome = Some(ran);
        if failed { Err(io::Error::other("the emulation failed")) } else { Ok(()) }
    })
    .or_else(|error| match outcome {
        // Its own error is the one to report.
        Some(Err(_)) => Ok(()),
        _ => Err(error),
    })?;
    outcome.unwrap_or_else(|| Err(anyhow!("nothing was run")))
}

/// The person at the terminal.
struct Console<'a> {
    bar: ProgressBar,
    baud: u32,
    client: Client,
    log: Option<&'a mut dyn Write>,
}

impl<'a> Console<'a> {
    fn new(baud: u32, log: Option<&'a mut dyn Write>) -> Self {
        // Hidden where standard error is no terminal.
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
        let style = ProgressStyle::with_template("{wide_msg}").expect("the template is constant");
        bar.set_style(style);
        Self { bar, baud, client: Client::Absent, log }
    }
}

impl Watcher for Console<'_> {
    fn status(&mut self, status: &Status<'_>) {
        if status.client != self.client {
            let news = news(self.client, status, self.baud);
            self.bar.suspend(|| println!("{news}"));
            self.client = status.client;
        }
        self.bar.set_message(status_line(status));
    }

    fn emitted(&mut self, emission: Emission) -> Result<()> {
        let Some(log) = &mut self.log else { return Ok(()) };
        let Emission { index, sample_ns, due_ns, sent_ns } = emission;
        Ok(writeln!(log, "{index},{sample_ns},{due_ns},{sent_ns}")?)
    }
}

/// What has happened to the client, in a line.
fn news(before: Client, status: &Status<'_>, own_baud: u32) -> String {
    let what = match (before, status.client) {
        (_, Client::Unplugged) => "unplugged".to_owned(),
        (Client::Unplugged, Client::Absent) => {
            format!("plugged in as {}", status.path.unwrap_or(Path::new("?")).display())
        }
        (_, Client::Absent) => "closed by its client".to_owned(),
        (_, Client::Present { baud, agrees: true }) => format!("opened at {baud} baud"),
        (_, Client::Present { baud, agrees: false }) => format!(
            "opened at {baud} baud, but the gyro sends at {own_baud}: the client reads garbage"
        ),
    };
    format!("{:>8.3} s  {what}", status.time.as_s())
}

fn status_line(status: &Status<'_>) -> String {
    let Status { time, frames, client, counts, lateness, .. } = status;
    let client = match client {
        Client::Unplugged => "unplugged".to_owned(),
        Client::Absent => "no client".to_owned(),
        Client::Present { baud, agrees: true } => format!("client at {baud} baud"),
        Client::Present { baud, .. } => format!("client at wrong {baud} baud"),
    };
    format!(
        "{:.1} s  {frames} frames  {:.1} kB  {client}  dropped {} B  late p50 {} p99 {} max {} ms",
        time.as_s(),
        counts.sent as f64 / 1e3,
        dropped(counts),
        ms(lateness.oversleep.quantile_s(0.5)),
        ms(lateness.oversleep.quantile_s(0.99)),
        ms(lateness.max_s()),
    )
}

/// Bytes that no client got as they were sent.
fn dropped(counts: &PortCounts) -> u64 {
    counts.sent.saturating_sub(counts.passed)
}

fn ms(time_s: f64) -> String {
    format!("{:.3}", time_s * 1e3)
}

fn closing(summary: &Summary) -> String {
    let Summary { frames, mean_rate_hz, counts, lateness, interrupted, .. } = summary;
    let rate = mean_rate_hz.map_or(String::new(), |rate_hz| format!(", {rate_hz:.3} Hz"));
    let PortCounts { sent, passed, unheard, skipped, overrun, garbled, garbage, .. } = counts;
    let Lateness { overrun: behind, oversleep } = lateness;
    let how = if *interrupted { " (interrupted)" } else { "" };
    let mut text = format!(
        "frames  {frames}{rate}{how}\nbytes   {sent} sent: {passed} passed, {unheard} unheard, \
         {skipped} skipped, {overrun} overrun, {garbled} garbled"
    );
    if *garbled > 0 {
        text += &format!(
            "\ngarbage {garbage} bytes read instead, {} framing and {} parity errors",
            counts.errors.framing, counts.errors.parity
        );
    }
    text += &format!("\nclients {}, {} bytes from them", counts.clients, counts.commands);
    text += &format!("\nlate    overrun:   {}", delays(behind));
    text += &format!("\n        oversleep: {}", delays(oversleep));
    text
}

/// Delays of one kind in a line.
fn delays(delays: &Delays) -> String {
    if delays.count() == 0 {
        return "none".to_owned();
    }
    let [p50, p90, p99, p999] = [0.5, 0.9, 0.99, 0.999].map(|q| ms(delays.quantile_s(q)));
    let (count, max) = (delays.count(), ms(delays.max_s()));
    format!("{count} waits, p50 {p50}, p90 {p90}, p99 {p99}, p99.9 {p999}, max {max} ms")
}

#[cfg(test)]
mod tests {
    use super::*;
    use struna_kernel::SimTime;
    use struna_line::ReceiverErrors;

    fn counts() -> PortCounts {
        let errors = ReceiverErrors { framing: 7, parity: 0 };
        PortCounts {
            sent: 1100,
            passed: 900,
            unheard: 190,
            garbled: 10,
            errors,
            ..Default::default()
        }
    }

    fn status(client: Client, lateness: &Lateness) -> Status<'_> {
        let (time, path) = (SimTime::from_ns(1_250_000_000), Some(Path::new("/dev/pts/7")));
        Status { time, frames: 100, client, counts: counts(), lateness, path }
    }

    #[test]
    fn each_change_of_the_client_is_told_in_words() {
        let lateness = Lateness::default();
        let good = Client::Present { baud: 115_200, agrees: true };
        let bad = Client::Present { baud: 9600, agrees: false };
        for (before, now, told) in [
            (Client::Absent, good, "opened at 115200 baud"),
            (
                good,
                bad,
                "opened at 9600 baud, but the gyro sends at 115200: the client reads garbage",
            ),
            (good, Client::Absent, "closed by its client"),
            (good, Client::Unplugged, "unplugged"),
            (Client::Unplugged, Client::Absent, "plugged in as /dev/pts/7"),
        ] {
            let news = news(before, &status(now, &lateness), 115_200);
            assert_eq!(news, format!("   1.250 s  {told}"));
        }
    }

    #[test]
    fn the_closing_lines_account_for_every_byte_and_delay() {
        let mut lateness = Lateness::default();
        lateness.oversleep.record(2_000_000);
        let summary = Summary {
            frames: 100,
            mean_rate_hz: Some(299.987_6),
            counts: counts(),
            lateness,
            interrupted: true,
            stopped: None,
            faults: Vec::new(),
        };
        let text = closing(&summary);
        for line in [
            "frames  100, 299.988 Hz (interrupted)",
            "bytes   1100 sent: 900 passed, 190 unheard, 0 skipped, 0 overrun, 10 garbled",
            "garbage 0 bytes read instead, 7 framing and 0 parity errors",
            "clients 0, 0 bytes from them",
            "late    overrun:   none",
            "oversleep: 1 waits, p50 2.000, p90 2.000, p99 2.000, p99.9 2.000, max 2.000 ms",
        ] {
            assert!(text.contains(line), "{line}\n{text}");
        }
    }

    #[test]
    fn the_status_fits_on_a_line() {
        let lateness = Lateness::default();
        let line = status_line(&status(Client::Absent, &lateness));
        assert_eq!(
            line,
            "1.2 s  100 frames  1.1 kB  no client  dropped 200 B  late p50 0.000 p99 0.000 max \
             0.000 ms"
        );
    }
}
