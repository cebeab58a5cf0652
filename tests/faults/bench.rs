//! A sound stream, and the same one with faults.

use struna_harness::fault::{
    Dispatch, Fault, FaultKind, FaultPlan, FaultRecord, Injector, Trigger,
};
use struna_kernel::{SampleGrid, Seed, SimTime};
use struna_wire::{Decoder, Encoder, FrameSpec};

/// Bytes of one sample as they left.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sent {
    pub(crate) ready: SimTime,
    pub(crate) baud_ratio: f64,
    pub(crate) bytes: Vec<u8>,
}

/// What a plan made of a stream.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Faulty {
    pub(crate) clean: Vec<u8>,
    pub(crate) sent: Vec<Sent>,
    pub(crate) ports: Vec<(SimTime, bool)>,
    pub(crate) records: Vec<FaultRecord>,
}

impl Faulty {
    pub(crate) fn bytes(&self) -> Vec<u8> {
        self.sent.iter().flat_map(|sent| sent.bytes.iter().copied()).collect()
    }
}

pub(crate) fn frame() -> FrameSpec {
    FrameSpec::from_toml(include_str!("../../frames/vg910d.toml")).unwrap()
}

pub(crate) fn grid() -> SampleGrid {
    SampleGrid::new(SimTime::ZERO, 300.0).unwrap()
}

pub(crate) fn seconds(s: f64) -> SimTime {
    SimTime::from_s(s).unwrap()
}

/// Every `period_s` from one period on, for `duration_s`.
pub(crate) fn every(kind: FaultKind, period_s: f64, duration_s: f64) -> FaultPlan {
    let trigger = Trigger::Every { first: seconds(period_s), period_s, jitter_s: 0.3 * period_s };
    FaultPlan::new(vec![Fault { kind, trigger, duration: seconds(duration_s) }]).unwrap()
}

/// The rate of sample `k` in these streams.
pub(crate) fn raw_rate(k: u64) -> i64 {
    i64::try_from(k).unwrap() * 37 - 5000
}

/// `frames` frames with the faults of `plan`.
pub(crate) fn faulty(plan: &FaultPlan, frames: u64, seed: Seed) -> Faulty {
    let spec = frame();
    let mut injector = Injector::new(plan, &spec, seed, 0);
    let mut encoder = Encoder::new(&spec);
    let mut raw = vec![0; spec.fields().len()];
    let rate = spec.field_index("rate").unwrap();
    let (mut clean, mut sent, mut ports) = (Vec::new(), Vec::new(), Vec::new());
    let mut take = |dispatch: Dispatch<'_>| match dispatch {
        Dispatch::Bytes { ready, baud_ratio, bytes } => {
            sent.push(Sent { ready, baud_ratio, bytes: bytes.to_vec() });
        }
        Dispatch::Unplugged(time) => ports.push((time, false)),
        Dispatch::Plugged(time) => ports.push((time, true)),
    };
    for k in 0..frames {
        raw[rate] = raw_rate(k);
        let mut one = Vec::new();
        encoder.encode(&raw, &mut one).unwrap();
        injector.begin(k, grid().time_of(k + 1));
        injector.dispatch(&one, &mut take);
        clean.extend(one);
    }
    injector.finish(&mut take);
    Faulty { clean, sent, ports, records: injector.records().to_vec() }
}

/// Raw rates of the frames in `bytes` with their decoder's indices.
pub(crate) fn decoded(bytes: &[u8]) -> Vec<(u64, i64)> {
    let spec = frame();
    let rate = spec.field_index("rate").unwrap();
    let mut frames = Vec::new();
    Decoder::new(spec).push(bytes, &mut |frame| frames.push((frame.index, frame.raw()[rate])));
    frames
}
