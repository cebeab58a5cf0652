//! Makes what was sound go wrong, as planned.

use super::packet::{Packet, any_byte, below, other_byte};
use super::schedule::Schedule;
use super::{Fault, FaultKind, FaultPlan, FaultRecord, Stage, baud};
use struna_gyro::Upset;
use struna_kernel::{Channel, RandomStream, Seed, SimTime};
use struna_wire::{Decoder, Encoder, FrameSpec};

/// More than this is not doubled again: many such faults in a plan must not fill the memory.
const DUPLICATED_BYTES_MAX: usize = 1024;
/// As many equal frames convince a decoder of any layout.
const CONFIRMING_FRAMES: usize = 16;

/// What leaves the injector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Dispatch<'a> {
    /// These bytes may go on the line.
    Bytes {
        /** From this instant on; instants do not go back. */
        ready: SimTime,
        /** At so many times the declared baud rate. */
        baud_ratio: f64,
        /** The bytes, at least one. */
        bytes: &'a [u8],
    },
    /// The port is gone.
    Unplugged(SimTime),
    /// The port is back.
    Plugged(SimTime),
}

/// Stands between a gyro and its line and injects the faults of a plan.
///
/// Each sample goes through [`Self::begin`], which says what the gyro suffers, and its frame
/// through [`Self::dispatch`]. Faults of a plan draw from streams of their own, keyed by seed, run
/// and place in the plan: adding one at the end leaves the others alone.
#[derive(Debug, Clone)]
pub struct Injector {
    armed: Vec<Armed>,
    state: State,
    records: Vec<FaultRecord>,
    next_id: u64,
}

/// One fault with its own chance.
#[derive(Debug, Clone)]
struct Armed {
    number: usize,
    fault: Fault,
    schedule: Schedule,
    choice: RandomStream,
    open: Option<Open>,
    /// Bytes of a burst that the next frame has still to bear.
    burst_left: usize,
}

/// An event under way.
#[derive(Debug, Clone, Copy)]
struct Open {
    record: FaultRecord,
    until: SimTime,
}

/// What all faults act upon.
#[derive(Debug, Clone)]
struct State {
    frame: FrameSpec,
    rate: Option<usize>,
    index: u64,
    time: SimTime,
    last_time: SimTime,
    clean_bytes: u64,
    sent_bytes: u64,
    packet: Packet,
    garbled: Vec<u8>,
    /// A frame that is to come after its successor.
    held: Option<Packet>,
    /// One that comes after the present frame; faults have done with it.
    due: Option<Packet>,
    /// How far the gyro's sample clock has fallen behind, ns.
    behind_ns: f64,
    delay_s: f64,
    baud_share: f64,
    silent: bool,
    wants_port: bool,
    has_port: bool,
    last_ready: SimTime,
}

impl Injector {
    /// An injector of `plan` into frames of layout `frame`, for run `run` of the campaign `seed`.
    #[must_use]
    pub fn new(plan: &FaultPlan, frame: &FrameSpec, seed: Seed, run: u64) -> Self {
        let arm = |(number, fault): (usize, &Fault)| {
            let stream = run.wrapping_mul(super::FAULTS_MAX as u64).wrapping_add(number as u64);
            let choice = RandomStream::new(seed, Channel::FaultChoice, stream);
            let schedule = Schedule::new(*fault, seed, stream);
            Armed { number, fault: *fault, schedule, choice, open: None, burst_left: 0 }
        };
        let armed = plan.faults().iter().enumerate().map(arm).collect();
        Self { armed, state: State::new(frame), records: Vec::new(), next_id: 0 }
    }

    /// Begins and ends events for the sample `index`, complete at `time`; says what the gyro is to
    /// suffer in it. Samples come in order.
    pub fn begin(&mut self, index: u64, time: SimTime) -> Upset {
        let Self { armed, state, records, next_id } = self;
        state.begin(index, time);
        let mut upset = Upset::default();
        for armed in armed {
            if let Some(open) =
                armed.open.filter(|open| time >= open.until && armed.burst_left == 0)
            {
                records.push(open.ended(&armed.fault, time));
                armed.open = None;
            }
            if armed.open.is_none() && armed.schedule.due(time).is_some() {
                armed.open_event(state, next_id);
            }
            if let Some(open) = &mut armed.open {
                open.record.last_sample = index;
                upset_by(&armed.fault.kind, &open.record, time, &mut upset);
            }
        }
        upset
    }

    /// Takes the frame of the sample begun last; hands on what becomes of it.
    pub fn dispatch(&mut self, frame: &[u8], sink: &mut dyn FnMut(Dispatch<'_>)) {
        let Self { armed, state, records, next_id } = self;
        state.load(frame);
        for armed in armed.iter_mut() {
            if let Some(mut open) = armed.open {
                state.strike(armed, &mut open.record);
                if armed.fault.kind.stage() != Stage::Byte {
                    open.record.clean_bytes.1 = state.clean_bytes;
                }
                armed.open = Some(open);
            }
            state.strike_by_byte(armed, records, next_id);
        }
        state.release();
        state.send(sink);
        for open in armed.iter_mut().filter_map(|armed| armed.open.as_mut()) {
            open.record.sent_bytes.1 = state.sent_bytes;
        }
    }

    /// Ends the stream: what was held back is sent, and events under way end with it.
    pub fn finish(&mut self, sink: &mut dyn FnMut(Dispatch<'_>)) {
        let Self { armed, state, records, .. } = self;
        state.packet.clear();
        state.due = state.held.take();
        state.release();
        state.send(sink);
        let end = state.time;
        for armed in armed {
            if let Some(open) = armed.open.take() {
                records.push(open.ended(&armed.fault, end));
            }
        }
        records.sort_by_key(|record| record.id);
    }

    /// What has been injected so far, in the order in which events ended; after
    /// [`Self::finish`], all of it in the order in which events began.
    #[must_use]
    pub fn records(&self) -> &[FaultRecord] {
        &self.records
    }
}

impl Open {
    fn ended(mut self, fault: &Fault, time: SimTime) -> FaultRecord {
        let momentary = fault.duration == SimTime::ZERO;
        self.record.end = if momentary { self.record.start } else { time };
        self.record
    }
}

impl Armed {
    fn open_event(&mut self, state: &State, next_id: &mut u64) {
        let Some(due) = self.schedule.due(state.time) else { return };
        let until = due.as_ns().saturating_add(self.fault.duration.as_ns());
        let until = SimTime::from_ns(until);
        self.schedule.advance(until);
        self.open = Some(Open { record: self.record(state, next_id), until });
    }

    fn record(&self, state: &State, next_id: &mut u64) -> FaultRecord {
        let id = *next_id;
        *next_id += 1;
        let (clean, sent) = (state.clean_bytes, state.sent_bytes);
        FaultRecord {
            id,
            fault: self.number,
            kind: self.fault.kind,
            start: state.time,
            end: state.time,
            first_sample: state.index,
            last_sample: state.index,
            clean_bytes: (clean, clean),
            sent_bytes: (sent, sent),
            magnitude: self.fault.kind.magnitude().0,
        }
    }
}

/// Adds what `kind` does to a gyro.
fn upset_by(kind: &FaultKind, record: &FaultRecord, time: SimTime, upset: &mut Upset) {
    match *kind {
        FaultKind::Stuck => upset.stuck = true,
        FaultKind::Saturation { rail } => upset.railed = Some(rail),
        FaultKind::BiasStep { rate_rad_s } | FaultKind::Spike { rate_rad_s } => {
            upset.bias_rad_s += rate_rad_s;
        }
        FaultKind::BiasRamp { rate_rad_s2 } => {
            upset.bias_rad_s += rate_rad_s2 * time.seconds_since(record.start);
        }
        FaultKind::ScaleChange { share } => upset.scale_factor *= 1.0 + share,
        FaultKind::NoiseChange { factor } => upset.noise_factor *= factor,
        _ => {}
    }
}

impl State {
    fn new(frame: &FrameSpec) -> Self {
        let (frame, rate) = (frame.clone(), frame.field_index("rate"));
        let packet = Packet::default();
        Self {
            frame,
            rate,
            index: 0,
            time: SimTime::ZERO,
            last_time: SimTime::ZERO,
            clean_bytes: 0,
            sent_bytes: 0,
            packet,
            garbled: Vec::new(),
            held: None,
            due: None,
            behind_ns: 0.0,
            delay_s: 0.0,
            baud_share: 0.0,
            silent: false,
            wants_port: true,
            has_port: true,
            last_ready: SimTime::ZERO,
        }
    }

    fn begin(&mut self, index: u64, time: SimTime) {
        self.index = index;
        self.last_time = self.time;
        self.time = time;
        self.delay_s = 0.0;
        self.baud_share = 0.0;
        self.silent = false;
        self.wants_port = true;
    }

    /// A fresh frame, and after it the one held back.
    fn load(&mut self, frame: &[u8]) {
        self.packet.fill(frame, self.clean_bytes);
        self.clean_bytes += frame.len() as u64;
        self.due = self.held.take();
    }

    /// Lets the frame that was held back follow the present one.
    fn release(&mut self) {
        if let Some(due) = self.due.take() {
            self.packet.follow(due);
        }
    }

    /// Lets an event under way act on the present frame.
    fn strike(&mut self, armed: &mut Armed, record: &mut FaultRecord) {
        match armed.fault.kind.stage() {
            Stage::Gyro => {}
            Stage::Line => self.strike_line(armed, record),
            Stage::Frame => self.strike_frame(armed, record),
            Stage::Byte => {
                if self.packet.len() > 0 {
                    self.strike_byte(armed, record, None);
                }
            }
        }
    }

    fn strike_line(&mut self, armed: &mut Armed, record: &FaultRecord) {
        match armed.fault.kind {
            FaultKind::Dropout => self.silent = true,
            FaultKind::PortLoss => self.wants_port = false,
            FaultKind::Delay { delay_s } => self.delay_s += delay_s,
            FaultKind::Jitter { delay_max_s } => {
                self.delay_s += delay_max_s * armed.choice.uniform();
            }
            FaultKind::BaudError { share } => {
                self.baud_share += share;
                self.misread(share, &mut armed.choice);
            }
            FaultKind::ClockDrift { share } => {
                let span_s = self.time.seconds_since(self.last_time);
                self.behind_ns += share * span_s * 1e9;
            }
            FaultKind::ClockJump { jump_s } if record.first_sample == self.index => {
                self.behind_ns += jump_s * 1e9;
            }
            _ => {}
        }
    }

    /// Replaces the bytes by what a receiver makes of them.
    fn misread(&mut self, share: f64, choice: &mut RandomStream) {
        self.garbled.clear();
        baud::misread(&self.packet.bytes, share, &mut || choice.uniform(), &mut self.garbled);
        std::mem::swap(&mut self.packet.bytes, &mut self.garbled);
        // Bytes may have merged; the last place stands for any beyond.
        let last = self.packet.origins.last().copied().unwrap_or(self.clean_bytes);
        self.packet.origins.resize(self.packet.bytes.len(), last);
    }

    fn strike_frame(&mut self, armed: &mut Armed, record: &mut FaultRecord) {
        match armed.fault.kind {
            FaultKind::Truncated if self.packet.len() > 1 => {
                let left = 1 + below(&mut armed.choice, self.packet.len() - 1);
                self.packet.truncate(left);
                record.magnitude = left as f64;
            }
            FaultKind::DuplicatedFrame if self.packet.len() <= DUPLICATED_BYTES_MAX => {
                let (bytes, origins) = (self.packet.bytes.clone(), self.packet.origins.clone());
                self.packet.bytes.extend(bytes);
                self.packet.origins.extend(origins);
            }
            // One swap at a time: a frame behind which another waits is not held back too.
            FaultKind::SwappedFrames if self.packet.len() > 0 && self.due.is_none() => {
                self.held = Some(std::mem::take(&mut self.packet));
            }
            FaultKind::WrongValue => self.replace_rate(armed, record),
            _ => {}
        }
    }

    /// Writes another rate into the frame, and the check that belongs to it.
    fn replace_rate(&mut self, armed: &mut Armed, record: &mut FaultRecord) {
        let Some(rate) = self.rate else { return };
        let mut decoder = Decoder::new(self.frame.clone());
        let mut decoded = None;
        // Frames of little evidence are believed only in a row.
        for _ in 0..CONFIRMING_FRAMES {
            decoder.push(&self.packet.bytes, &mut |frame| {
                decoded.get_or_insert_with(|| (frame.index, frame.raw().to_vec()));
            });
        }
        // Whatever was done to the frame before has left no rate to replace.
        let Some((index, mut raw)) = decoded else { return };
        let field = &self.frame.fields()[rate];
        let (low, high) = match field.clip_si() {
            Some([low, high]) => (field.from_si(low), field.from_si(high)),
            None => (field.raw_min(), field.raw_max()),
        };
        let (low, high) = (low.min(high), low.max(high));
        let drawn = low as f64 + armed.choice.uniform() * (high as f64 - low as f64);
        #[expect(clippy::cast_possible_truncation, reason = "between two raw values")]
        let drawn = (drawn.round() as i64).clamp(low, high);
        raw[rate] = drawn;
        record.magnitude = drawn as f64;
        let mut frame = Vec::with_capacity(self.frame.frame_len());
        if Encoder::starting_at(&self.frame, index).encode(&raw, &mut frame).is_ok() {
            let origin = self.packet.origins[0];
            self.packet.fill(&frame, origin);
        }
    }

    /// Hits one byte: the one at `at`, or any.
    fn strike_byte(&mut self, armed: &mut Armed, record: &mut FaultRecord, at: Option<usize>) {
        let (kind, choice) = (armed.fault.kind, &mut armed.choice);
        let at = at.or((armed.burst_left > 0).then_some(0));
        // A byte can be inserted in one place more than there are bytes.
        let places = self.packet.len() + usize::from(kind == FaultKind::InsertedByte);
        let at = at.unwrap_or_else(|| below(choice, places));
        let origin = match self.packet.origins.get(at) {
            Some(origin) => *origin,
            None => self.packet.origins[at - 1] + 1,
        };
        let mut hit = 1;
        match kind {
            FaultKind::ByteDrop => self.packet.remove(at),
            FaultKind::BitFlip => {
                let bit = below(choice, 8);
                self.packet.bytes[at] ^= 1 << bit;
                record.magnitude = bit as f64;
            }
            FaultKind::DuplicateByte => {
                let byte = self.packet.bytes[at];
                self.packet.insert(at, byte, origin);
            }
            FaultKind::InsertedByte => {
                self.packet.insert(at, any_byte(choice), origin);
                hit = 0;
            }
            FaultKind::Burst { bytes } => {
                let whole = if armed.burst_left > 0 { armed.burst_left } else { bytes as usize };
                hit = whole.min(self.packet.len() - at);
                for byte in &mut self.packet.bytes[at..at + hit] {
                    *byte = other_byte(choice, *byte);
                }
                armed.burst_left = whole - hit;
            }
            _ => return,
        }
        if record.first_sample == self.index {
            record.clean_bytes.0 = origin;
            record.sent_bytes.0 = self.sent_bytes + at as u64;
        }
        record.clean_bytes.1 = origin + hit as u64;
    }

    /// Faults that come by the byte: none, one or several in this frame.
    fn strike_by_byte(
        &mut self,
        armed: &mut Armed,
        records: &mut Vec<FaultRecord>,
        next_id: &mut u64,
    ) {
        while let Some(origin) = armed.schedule.due_byte(self.clean_bytes) {
            armed.schedule.advance_byte();
            // A byte that an earlier fault has taken away cannot be hit.
            let Some(at) = self.packet.find(origin) else { continue };
            let mut record = armed.record(self, next_id);
            self.strike_byte(armed, &mut record, Some(at));
            record.sent_bytes.1 = record.sent_bytes.0 + 1;
            records.push(record);
        }
    }

    /// Hands on what is left of the frame.
    fn send(&mut self, sink: &mut dyn FnMut(Dispatch<'_>)) {
        #[expect(clippy::cast_possible_truncation, reason = "a float-to-int cast saturates")]
        let late_ns = (self.behind_ns + self.delay_s * 1e9).round() as i64;
        let ready = SimTime::from_ns(self.time.as_ns().saturating_add(late_ns));
        let ready = ready.max(self.last_ready);
        self.last_ready = ready;
        if self.has_port != self.wants_port {
            self.has_port = self.wants_port;
            sink(if self.has_port { Dispatch::Plugged(ready) } else { Dispatch::Unplugged(ready) });
        }
        let bytes = &self.packet.bytes;
        if self.silent || !self.has_port || bytes.is_empty() {
            return;
        }
        self.sent_bytes += bytes.len() as u64;
        sink(Dispatch::Bytes { ready, baud_ratio: 1.0 + self.baud_share, bytes });
    }
}
