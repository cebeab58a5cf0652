//! A gyro that stands in for a real one: a scenario's frames, played into a port at their times.

use crate::scenario::Scenario;
use crate::session;
use anyhow::{Context, Result, ensure};
use std::collections::VecDeque;
use std::ops::Range;
use std::path::Path;
use struna_harness::fault::FaultRecord;
use struna_harness::{EmulatorError, LineEvent, SourceError, Transmitter};
use struna_kernel::SimTime;
use struna_line::{
    Client, DevicePort, DeviceSettings, Lateness, LineModel, Pacer, PortCounts, StopFlag, Waited,
    monotonic_ns,
};

/// How often a watcher is told how things stand, beside every change of the client.
const STATUS_PERIOD_NS: i64 = 100_000_000;

/// Where in the stream a client comes in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Entry {
    /// At the first byte of a frame, by its sync bytes.
    #[default]
    FrameBoundary,
    /// In the middle of what arrives next, as happens with a device that was talking already.
    MidFrame,
}

/// The emulated device of a scenario.
#[derive(Debug)]
pub struct Device {
    /// Frames in simulated time.
    pub transmitter: Transmitter,
    /// How they stand on the line.
    pub settings: DeviceSettings,
    sync: Vec<u8>,
}

impl Device {
    /// The device of `scenario`, before its first frame.
    ///
    /// # Errors
    /// When gyro and frame do not go together, the motion cannot start, or the line cannot carry
    /// the frames.
    pub fn new(scenario: &Scenario) -> Result<Self> {
        let (line, rate_hz) = (&scenario.line, scenario.gyro.sample_rate_hz);
        let needed = scenario.symbols_per_s();
        ensure!(
            needed <= f64::from(line.baud),
            "{rate_hz} frames of {} per second need {needed:.0} baud and the line has {}; raise \
             `baud` in [line] or lower `sample_rate_hz` in [gyro]",
            scenario.frame.name(),
            line.baud,
        );
        let emulator = session::emulator(scenario)?;
        let transmitter = Transmitter::new(emulator, LineModel::new(line.settings()));
        let sync = scenario.frame.sync().to_vec();
        Ok(Self { transmitter, settings: line.device(), sync })
    }

    /// Frames until `duration`.
    ///
    /// # Errors
    /// When the gyro has no usable sample rate.
    pub fn frames(scenario: &Scenario, duration: SimTime) -> Result<u64> {
        Ok(session::sample_grid(scenario)?.periods_until(duration))
    }
}

/// How things stand.
#[derive(Debug)]
pub struct Status<'a> {
    /// Simulated time.
    pub time: SimTime,
    /// Frames that the device has sent.
    pub frames: u64,
    /// Who listens.
    pub client: Client,
    /// Where the bytes went.
    pub counts: PortCounts,
    /// How punctual.
    pub lateness: &'a Lateness,
    /// The port's node.
    pub path: Option<&'a Path>,
}

/// A frame on its way, on the monotonic clock of the machine, ns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Emission {
    /// Number of the frame, from 0.
    pub index: u64,
    /// The instant of its sample.
    pub sample_ns: i64,
    /// When its last byte was due at the host.
    pub due_ns: i64,
    /// When that byte had been handed over.
    pub sent_ns: i64,
}

/// Sees what is played. Whatever takes long here delays the frames.
pub trait Watcher {
    /// Told ten times in a second, and whenever somebody comes, goes or sets another baud rate.
    fn status(&mut self, status: &Status<'_>);

    /// Told of each frame once its last byte has reached the port, client or not.
    ///
    /// # Errors
    /// Whatever ends the emulation.
    fn emitted(&mut self, emission: Emission) -> Result<()>;
}

/// How an emulation ended.
#[derive(Debug, Clone)]
pub struct Summary {
    /// Frames that the device has sent.
    pub frames: u64,
    /// Frames in a second of the clock, from the first to the last; none for fewer than two.
    pub mean_rate_hz: Option<f64>,
    /// Where the bytes went.
    pub counts: PortCounts,
    /// How punctual.
    pub lateness: Lateness,
    /// Ended from outside.
    pub interrupted: bool,
    /// Why the motion ended before its time.
    pub stopped: Option<SourceError>,
    /// What the scenario's faults did to it.
    pub faults: Vec<FaultRecord>,
}

/// A device, its port and its clock, ready to be played.
#[derive(Debug)]
pub struct Emulation<'a> {
    /// What sends.
    pub device: Device,
    /// Where it arrives.
    pub port: DevicePort,
    /// When. Started at the device's first instant.
    pub pacer: Pacer,
    /// Where clients come in.
    pub entry: Entry,
    /// Ends it early.
    pub stop: &'a StopFlag,
}

impl Emulation<'_> {
    /// Plays `frames` frames, each event of the line at its time, and gives a client that is there
    /// the time to read the last of them.
    ///
    /// # Errors
    /// When port or watcher fails, or a frame cannot carry a reading.
    pub fn play(self, frames: u64, watcher: &mut dyn Watcher) -> Result<Summary> {
        let Self { device: Device { mut transmitter, sync, .. }, port, pacer, entry, stop } = self;
        let mut player = Player {
            port,
            pacer,
            entry,
            sync,
            watcher,
            stop,
            arrived: 0,
            on_the_way: VecDeque::new(),
            handed_over: HandedOver::default(),
            client: None,
            status_due_ns: i64::MIN,
        };
        let mut batch = Batch::default();
        let mut stopped = None;
        let mut interrupted = false;
        for index in 0..frames {
            let reference = match transmitter.emit(&mut |time, event| batch.push(time, event)) {
                Ok(reference) => reference,
                Err(EmulatorError::Source(reason)) => {
                    stopped = Some(reason);
                    break;
                }
                Err(error) => return Err(error.into()),
            };
            let sent = transmitter.report().bytes;
            player.on_the_way.push_back(OnTheWay { index, sample: reference.time, end: sent });
            interrupted = player.play(&mut batch)? == Waited::Stopped;
            if interrupted {
                break;
            }
        }
        if !interrupted {
            transmitter.flush(&mut |time, event| batch.push(time, event));
            interrupted = player.play(&mut batch)? == Waited::Stopped;
            player.port.linger(stop)?;
        }
        Ok(Summary {
            frames: player.handed_over.frames,
            mean_rate_hz: player.handed_over.mean_rate_hz(),
            counts: player.port.counts(),
            lateness: player.pacer.lateness().clone(),
            interrupted,
            stopped,
            faults: transmitter.fault_records().to_vec(),
        })
    }
}

/// Events of the line that wait to be played, their bytes in one heap.
#[derive(Default)]
struct Batch {
    events: Vec<(SimTime, Event)>,
    bytes: Vec<u8>,
}

enum Event {
    Bytes(Range<usize>),
    Unplugged,
    Plugged,
}

impl Batch {
    fn push(&mut self, time: SimTime, event: LineEvent<'_>) {
        let event = match event {
            LineEvent::Bytes(bytes) => {
                let start = self.bytes.len();
                self.bytes.extend_from_slice(bytes);
                Event::Bytes(start..self.bytes.len())
            }
            LineEvent::Unplugged => Event::Unplugged,
            LineEvent::Plugged => Event::Plugged,
        };
        self.events.push((time, event));
    }
}

/// A frame of which not every byte has reached the port.
struct OnTheWay {
    index: u64,
    sample: SimTime,
    /// Bytes that have reached the port when it has.
    end: u64,
}

/// Frames that have reached the port, and the clock at the first and at the last of them.
#[derive(Default)]
struct HandedOver {
    frames: u64,
    first_ns: i64,
    last_ns: i64,
}

impl HandedOver {
    fn add(&mut self, sent_ns: i64) {
        if self.frames == 0 {
            self.first_ns = sent_ns;
        }
        self.last_ns = sent_ns;
        self.frames += 1;
    }

    fn mean_rate_hz(&self) -> Option<f64> {
        let took_ns = self.last_ns.saturating_sub(self.first_ns);
        (took_ns > 0).then(|| (self.frames - 1) as f64 * 1e9 / took_ns as f64)
    }
}

struct Player<'a> {
    port: DevicePort,
    pacer: Pacer,
    entry: Entry,
    sync: Vec<u8>,
    watcher: &'a mut dyn Watcher,
    stop: &'a StopFlag,
    /// Bytes that have reached the port.
    arrived: u64,
    on_the_way: VecDeque<OnTheWay>,
    handed_over: HandedOver,
    /// The client that the watcher was told of.
    client: Option<Client>,
    status_due_ns: i64,
}

impl Player<'_> {
    /// Plays what `batch` holds and empties it.
    fn play(&mut self, batch: &mut Batch) -> Result<Waited> {
        let Batch { events, bytes } = batch;
        for (time, event) in events.drain(..) {
            if self.pacer.wait_until(time, self.stop) == Waited::Stopped {
                return Ok(Waited::Stopped);
            }
            match event {
                Event::Bytes(range) => self.send(time, &bytes[range])?,
                Event::Unplugged => self.port.unplug(),
                Event::Plugged => self.port.plug()?,
            }
            self.tell_status(time);
        }
        bytes.clear();
        // A flag that is thrown between two instants ends it as well.
        Ok(if self.stop.is_stopped() { Waited::Stopped } else { Waited::Due })
    }

    fn send(&mut self, time: SimTime, bytes: &[u8]) -> Result<()> {
        let entry = match self.entry {
            Entry::FrameBoundary => start_of_frame(bytes, &self.sync),
            Entry::MidFrame => Some(bytes.len() / 2),
        };
        self.port.send(time, bytes, entry)?;
        let sent_ns = monotonic_ns();
        self.arrived += bytes.len() as u64;
        let due_ns = self.pacer.due_ns(time);
        while self.on_the_way.front().is_some_and(|frame| frame.end <= self.arrived) {
            let Some(OnTheWay { index, sample, .. }) = self.on_the_way.pop_front() else { break };
            self.handed_over.add(sent_ns);
            let sample_ns = self.pacer.due_ns(sample);
            self.watcher
                .emitted(Emission { index, sample_ns, due_ns, sent_ns })
                .context("the emission log")?;
        }
        Ok(())
    }

    fn tell_status(&mut self, time: SimTime) {
        let (client, now_ns) = (self.port.client(), self.pacer.due_ns(time));
        if self.client == Some(client) && now_ns < self.status_due_ns {
            return;
        }
        self.client = Some(client);
        self.status_due_ns = now_ns.saturating_add(STATUS_PERIOD_NS);
        self.watcher.status(&Status {
            time,
            frames: self.handed_over.frames,
            client,
            counts: self.port.counts(),
            lateness: self.pacer.lateness(),
            path: self.port.path(),
        });
    }
}

/// Where in `bytes` a frame starts, as far as its sync bytes tell.
fn start_of_frame(bytes: &[u8], sync: &[u8]) -> Option<usize> {
    if sync.is_empty() {
        return Some(0);
    }
    bytes.windows(sync.len()).position(|window| window == sync)
}

#[cfg(test)]
mod tests {
    use super::*;
    use struna_line::CharacterFormat;

    #[test]
    fn a_frame_starts_at_its_sync_bytes() {
        let sync = [0xA5, 0x5A];
        for (bytes, start) in [
            (&[0xA5, 0x5A, 1][..], Some(0)),
            (&[9, 0xA5, 0xA5, 0x5A], Some(2)),
            // Cut in two by the end of a packet: the next frame is as good.
            (&[1, 2, 0xA5], None),
            (&[], None),
        ] {
            assert_eq!(start_of_frame(bytes, &sync), start, "{bytes:?}");
        }
        assert_eq!(start_of_frame(&[1, 2], &[]), Some(0));
    }

    #[test]
    fn the_mean_rate_is_that_of_the_intervals() {
        let mut handed_over = HandedOver::default();
        assert_eq!(handed_over.mean_rate_hz(), None);
        for k in 0..5 {
            handed_over.add(1_000 + k * 2_000_000);
        }
        let rate_hz = handed_over.mean_rate_hz().expect("five frames have a rate");
        assert!((rate_hz - 500.0).abs() < 1e-9, "{rate_hz}");
    }

    /// Remembers the clients and the frames it was told of.
    #[derive(Default)]
    struct Notes {
        clients: Vec<Client>,
        frames: Vec<u64>,
    }

    impl Watcher for Notes {
        fn status(&mut self, status: &Status<'_>) {
            if self.clients.last() != Some(&status.client) {
                self.clients.push(status.client);
            }
        }

        fn emitted(&mut self, emission: Emission) -> Result<()> {
            self.frames.push(emission.index);
            Ok(())
        }
    }

    #[test]
    fn events_of_the_line_are_played_into_the_port_in_order() {
        let settings = DeviceSettings { baud: 115_200, format: CharacterFormat::default() };
        let port = DevicePort::open(settings, None).expect("a pseudo-terminal");
        let (mut notes, stop) = (Notes::default(), StopFlag::new());
        // Two frames of four bytes; the second comes in two packets.
        let frame = |index, end| OnTheWay { index, sample: SimTime::ZERO, end };
        let mut player = Player {
            port,
            pacer: Pacer::start(),
            entry: Entry::FrameBoundary,
            sync: vec![0xA5],
            watcher: &mut notes,
            stop: &stop,
            arrived: 0,
            on_the_way: VecDeque::from([frame(0, 4), frame(1, 8)]),
            handed_over: HandedOver::default(),
            client: None,
            status_due_ns: i64::MIN,
        };
        let mut batch = Batch::default();
        for (k, event) in [
            LineEvent::Bytes(&[0xA5, 1, 2, 3, 0xA5]),
            LineEvent::Unplugged,
            LineEvent::Bytes(&[4, 5]),
            LineEvent::Plugged,
        ]
        .into_iter()
        .enumerate()
        {
            batch.push(SimTime::from_ns(i64::try_from(k).expect("a small number")), event);
        }
        assert_eq!(player.play(&mut batch).expect("it plays"), Waited::Due);
        assert!(batch.events.is_empty() && batch.bytes.is_empty());
        assert!(player.port.path().is_some());
        let counts = player.port.counts();
        assert_eq!((counts.sent, counts.unheard), (7, 7));
        assert_eq!((player.arrived, player.on_the_way.len()), (7, 1));
        stop.stop();
        batch.push(SimTime::from_s(1e6).expect("a time"), LineEvent::Unplugged);
        assert_eq!(player.play(&mut batch).expect("it plays"), Waited::Stopped);
        assert!(player.port.path().is_some(), "what was not due has not happened");
        assert_eq!(notes.clients, [Client::Absent, Client::Unplugged, Client::Absent]);
        assert_eq!(notes.frames, [0]);
    }
}
