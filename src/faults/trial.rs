//! One stretch of one stream, with or without faults, in simulated time.

use super::{Stream, TestMotion};
use struna_gyro::Gyro;
use struna_harness::fault::{FaultPlan, FaultRecord};
use struna_harness::monitor::{Alarm, AlarmChange, Listener};
use struna_harness::{Emulator, LineEvent, MotionSource, Reference, SourceError, Transmitter};
use struna_kernel::{SampleGrid, Seed, SimTime};
use struna_line::LineModel;

/// What was done and what was noticed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trial {
    /// What was injected.
    pub records: Vec<FaultRecord>,
    /// Every alarm, in the order in which they were raised.
    pub alarms: Vec<Alarm>,
}

/// Runs `stream` for `duration_s` with the faults of `plan`.
///
/// # Errors
/// When a stream's constants contradict each other, which is a defect.
pub fn trial(
    stream: Stream,
    plan: &FaultPlan,
    duration_s: f64,
    seed: Seed,
    run: u64,
) -> anyhow::Result<Trial> {
    let (frame, gyro) = (stream.frame(), Gyro::new(stream.gyro(), seed, run)?);
    let grid = SampleGrid::new(SimTime::ZERO, stream.gyro().sample_rate_hz)?;
    let emulator = Emulator::new(Box::new(Turntable), gyro, grid, &frame)?;
    let emulator =
        emulator.with_faults(struna_harness::fault::Injector::new(plan, &frame, seed, run));
    let mut transmitter = Transmitter::new(emulator, LineModel::new(stream.line()));
    let mut host = Host { listener: Listener::new(frame, &stream.declared())?, alarms: Vec::new() };
    for _ in 0..grid.periods_until(SimTime::from_s(duration_s)?) {
        let now = transmitter.next_time();
        host.pass(now);
        transmitter.emit(&mut |time, event| host.take(time, event))?;
    }
    transmitter.flush(&mut |time, event| host.take(time, event));
    host.finish();
    let mut alarms = host.alarms;
    alarms.sort_by_key(|alarm| (alarm.since, alarm.detector));
    Ok(Trial { records: transmitter.fault_records().to_vec(), alarms })
}

/// The receiving end.
struct Host {
    listener: Listener,
    alarms: Vec<Alarm>,
}

impl Host {
    fn pass(&mut self, now: SimTime) {
        let Self { listener, alarms } = self;
        let monitor = listener.monitor();
        monitor.declare_rest(TestMotion.is_declared_rest(now.as_s()));
        monitor.pass(now, &mut |change| keep(alarms, change));
    }

    fn take(&mut self, time: SimTime, event: LineEvent<'_>) {
        let Self { listener, alarms } = self;
        if let LineEvent::Bytes(bytes) = event {
            listener.push(time, bytes, &mut |change| keep(alarms, change));
        }
    }

    fn finish(&mut self) {
        let Self { listener, alarms } = self;
        listener.monitor().finish(&mut |change| keep(alarms, change));
    }
}

/// An alarm is kept when it is over and its end known.
fn keep(alarms: &mut Vec<Alarm>, change: AlarmChange) {
    if let AlarmChange::Cleared(alarm) = change {
        alarms.push(alarm);
    }
}

/// The motion of the trials as a source.
#[derive(Debug, Clone, Copy)]
struct Turntable;

impl MotionSource for Turntable {
    fn reference_at(&mut self, time: SimTime) -> Result<Reference, SourceError> {
        let rate_rad_s = TestMotion.rate_rad_s(time.as_s());
        let angle_rad = TestMotion.angle_rad(time.as_s());
        Ok(Reference {
            time,
            input_angle_rad: angle_rad,
            input_rate_rad_s: rate_rad_s,
            spin_rad: angle_rad,
            rate_rad_s,
            specific_force_s_m_s2: None,
            twist_rad: None,
            twist_rate_rad_s: None,
        })
    }
}
