//! Both gyros in real time on a virtual port: how punctual they are, and how long bytes take to
//! their reader. Reported and not judged: it tells of the machine and its load.

use crate::table::Row;
use anyhow::{Context, Result, ensure};
use std::path::Path;
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use struna::emulate::{Device, Emission, Emulation, Entry, Status, Watcher};
use struna::scenario::Scenario;
use struna_harness::LineEvent;
use struna_kernel::SimTime;
use struna_line::{
    Delays, DevicePort, Lateness, Pacer, ReadOutcome, SerialReader, StopFlag, monotonic_ns,
};
use struna_wire::Decoder;

/// Length of each run, s.
const DURATION_S: f64 = 60.0;
const SWING: &str = include_str!("../../scenarios/swing.toml");

pub(crate) fn rows() -> Result<Vec<Row>> {
    let slow = scenario(SWING)?;
    let fast = SWING.replacen("preset = \"vg910d\"", "preset = \"adis16100\"", 1).replacen(
        "struna/vg910d@1",
        "struna/adis16100@1",
        1,
    );
    let fast = scenario(&fast)?;
    let mut rows = of_gyro(&slow)?;
    rows.extend(of_gyro(&fast)?);
    Ok(rows)
}

fn scenario(text: &str) -> Result<Scenario> {
    let mut scenario = Scenario::parse(text, Path::new("swing.toml"))?;
    scenario.duration = SimTime::from_s(DURATION_S)?;
    Ok(scenario)
}

fn of_gyro(scenario: &Scenario) -> Result<Vec<Row>> {
    let expected = unpaced(scenario)?;
    let frames = Device::frames(scenario, scenario.duration)?;
    let device = Device::new(scenario)?;
    let mut port = DevicePort::open(device.settings, None)?;
    let path = port.path().context("a port that was just plugged in")?.to_owned();
    let (decoder, baud) = (Decoder::new(scenario.frame.clone()), device.settings.baud);
    let reading = thread::spawn(move || Client::default().read(&path, baud, decoder, frames));
    let stop = StopFlag::new();
    port.wait_for_client(&stop)?;
    let (emissions, told) = channel();
    let pacer = Pacer::start();
    let emulation = Emulation { device, port, pacer, entry: Entry::FrameBoundary, stop: &stop };
    let summary = emulation.play(frames, &mut Tell(emissions))?;
    let client = match reading.join() {
        Ok(client) => client?,
        Err(_) => anyhow::bail!("the reader panicked"),
    };
    ensure!(client.bytes == expected, "other bytes came than an unpaced run sends");
    ensure!(client.arrived_ns.len() as u64 == frames, "frames were lost");
    let rate_hz = scenario.gyro.sample_rate_hz;
    let what = |of: &str| format!("{rate_hz} Hz for {DURATION_S} s: {of}");
    let Lateness { overrun, oversleep } = &summary.lateness;
    Ok(vec![
        told_row(what("mean rate"), format!("{:.4} Hz", summary.mean_rate_hz.unwrap_or(0.0))),
        told_row(what("behind before the wait"), percentiles(overrun)),
        told_row(what("woken late"), percentiles(oversleep)),
        told_row(what("write to decoded frame"), percentiles(&transit(told, &client.arrived_ns))),
    ])
}

fn told_row(what: String, ours: String) -> Row {
    Row { what, ours, other: "reported".into(), ratio: None, target: 0.0 }
}

fn percentiles(delays: &Delays) -> String {
    let us = |time_s: f64| format!("{:.0}", time_s * 1e6);
    let [p50, p90, p99, p999] = [0.5, 0.9, 0.99, 0.999].map(|q| us(delays.quantile_s(q)));
    let (count, max) = (delays.count(), us(delays.max_s()));
    format!("{count}: {p50} / {p90} / {p99} / {p999} / {max} us (p50/90/99/99.9/max)")
}

/// From the moment the last byte of a frame was handed over to the one when it had been decoded.
fn transit(told: Receiver<Emission>, arrived_ns: &[i64]) -> Delays {
    let mut delays = Delays::default();
    for (emission, arrived_ns) in told.into_iter().zip(arrived_ns) {
        delays.record(arrived_ns - emission.sent_ns);
    }
    delays
}

/// The bytes of a run that looks at no clock.
fn unpaced(scenario: &Scenario) -> Result<Vec<u8>> {
    let mut transmitter = Device::new(scenario)?.transmitter;
    let mut bytes = Vec::new();
    let mut take = |_, event: LineEvent<'_>| {
        if let LineEvent::Bytes(arrived) = event {
            bytes.extend_from_slice(arrived);
        }
    };
    for _ in 0..Device::frames(scenario, scenario.duration)? {
        transmitter.emit(&mut take)?;
    }
    transmitter.flush(&mut take);
    Ok(bytes)
}

/// Passes emissions on.
struct Tell(std::sync::mpsc::Sender<Emission>);

impl Watcher for Tell {
    fn status(&mut self, _: &Status<'_>) {}

    fn emitted(&mut self, emission: Emission) -> Result<()> {
        Ok(self.0.send(emission)?)
    }
}

/// What a reader has seen.
#[derive(Default)]
struct Client {
    bytes: Vec<u8>,
    /// When each frame had been decoded, by the monotonic clock.
    arrived_ns: Vec<i64>,
}

impl Client {
    fn read(mut self, path: &Path, baud: u32, mut decoder: Decoder, frames: u64) -> Result<Self> {
        let mut reader = SerialReader::open(path, baud)?;
        let mut buffer = [0; 4096];
        while (self.arrived_ns.len() as u64) < frames {
            let ReadOutcome::Bytes(n) = reader.read(&mut buffer)? else { continue };
            self.bytes.extend_from_slice(&buffer[..n]);
            let arrived_ns = &mut self.arrived_ns;
            decoder.push(&buffer[..n], &mut |_| arrived_ns.push(monotonic_ns()));
        }
        Ok(self)
    }
}
