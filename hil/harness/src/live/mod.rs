//! A line that is really there: bytes with their arrival times in, estimates out.

mod event;
mod listen;
mod source;

pub use event::{Gap, GapCause, Guess, LiveEvent, Sighting};
pub use listen::{Ended, Listening, listen};
pub use source::{ByteSource, HostClock, SourceRead};

use crate::axes::CrossRates;
use crate::clock::{
    Basis, Heard, Observed, Resolved, Resolver, SampleClock, Skew, TimeBase, TimeBaseSettings,
};
use crate::pipeline::Devices;
use crate::{Averager, AveragerError, DeviceUnderTest, GyroChannel, Measured, PipelineError};
use struna_kernel::{AngleEstimate, RateSample, SampleGrid, SimTime, TimeError};
use struna_wire::{Counters, Decoder, FieldSpec, Frame, FrameSpec};

/// Share of a period by which the estimators' clock is slewed once the period is known.
const SLEW: f64 = 2e-3;
/// A silent sensor that is late by more than this has paused.
const PAUSE_S: f64 = 0.25;

/// Why a live pipeline cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LiveError {
    /// The layout, or a device.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// The number of samples to average.
    #[error(transparent)]
    Averager(#[from] AveragerError),
    /// The layout's rate.
    #[error(transparent)]
    Rate(#[from] TimeError),
}

/// What happens on the line. A run that is decoded again from its record is given the same, at the
/// same times.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineInput<'a> {
    /// These bytes have arrived.
    Bytes(&'a [u8]),
    /// Nothing has arrived since the bytes before.
    Silent,
    /// The port has gone.
    Lost,
    /// The port is back; what it held was thrown away.
    Back,
}

/// Sees what a live pipeline does.
pub trait LiveObserver {
    /// What came off the line, before anything is made of it.
    fn input(&mut self, time: SimTime, input: LineInput<'_>);

    /// A good frame, and its place among the samples; `resolved` before it is averaged.
    fn frame(&mut self, arrival: SimTime, resolved: &Resolved);

    /// An averaged sample and what the devices made of it.
    fn output(&mut self, sample: &RateSample, estimates: &[AngleEstimate]);

    /// Something besides, at an instant of the record's time.
    fn event(&mut self, time: SimTime, event: &LiveEvent);

    /// The pipeline between two reads, at an instant of the host's clock.
    fn look(&mut self, now: SimTime, pipeline: &LivePipeline) {
        let _ = (now, pipeline);
    }
}

/// What went through a live pipeline.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LiveReport {
    /// The decoder's counters. Its count of lost frames knows neither whole turns of the counter
    /// nor frames without one.
    pub wire: Counters,
    /// Samples lost while the port was there.
    pub lost_on_line: u64,
    /// Samples lost while it was not.
    pub lost_with_port: u64,
    /// Losses told by the time passed alone.
    pub inferred_gaps: u64,
    /// Gyro samples marked over range.
    pub over_range: u64,
    /// Gyro samples marked not valid, and therefore not used.
    pub not_valid: u64,
    /// Averaged samples given to the devices.
    pub outputs: u64,
    /// The sensor's skew, if the line was watched long enough.
    pub skew: Option<Skew>,
    /// The longest stretch of the record's time without samples, s.
    pub longest_gap_s: f64,
}

/// Decoder, time base, averager and devices in a row, for a line that is really there.
///
/// It differs from [`crate::Pipeline`] in its time: the gyro's counter says which sample a frame
/// is, and the arrival times of all say how fast the gyro's clock runs. The record's time starts
/// with the first sample. Nothing here reads a clock, so a recorded line gives the same record
/// again; nothing is allocated after construction.
pub struct LivePipeline {
    decoder: Decoder,
    chain: Chain,
    resyncs: u64,
    skipped_bytes: u64,
}

/// Everything behind the decoder.
struct Chain {
    channel: GyroChannel,
    rate_field: FieldSpec,
    cross: Option<CrossRates>,
    resolver: Resolver,
    base: TimeBase,
    tolerance: f64,
    clock: SampleClock,
    averager: Averager,
    devices: Devices,
    silent_until: Option<SimTime>,
    outage: bool,
    /// Arrival and index of the last frame.
    last: Option<(SimTime, u64)>,
    report: LiveReport,
}

impl std::fmt::Debug for LivePipeline {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LivePipeline").field("base", &self.chain.base).finish_non_exhaustive()
    }
}

impl LivePipeline {
    /// A pipeline for frames of layout `frame`, whose samples are averaged in groups of
    /// `averaging` and took `latency` to arrive at least.
    ///
    /// # Errors
    /// [`LiveError`] when the layout has no rate, or nothing is to be averaged.
    pub fn new(
        frame: FrameSpec,
        averaging: u64,
        latency: SimTime,
        devices: Vec<Box<dyn DeviceUnderTest>>,
    ) -> Result<Self, LiveError> {
        let channel = GyroChannel::find(&frame)?;
        let timing = frame.timing();
        let grid = SampleGrid::new(SimTime::ZERO, timing.rate_hz)?;
        let settings = TimeBaseSettings::new(grid.period_s(), timing.rate_tolerance);
        let chain = Chain {
            channel,
            rate_field: frame.fields()[channel.rate].clone(),
            cross: CrossRates::find(&frame),
            resolver: Resolver::new(frame.sequence().map(|sequence| sequence.modulus())),
            base: TimeBase::new(TimeBaseSettings { latency, ..settings }),
            tolerance: timing.rate_tolerance,
            clock: SampleClock::new(grid.period_s()),
            averager: Averager::new(grid, averaging)?,
            devices: Devices::new(devices),
            silent_until: None,
            outage: false,
            last: None,
            report: LiveReport::default(),
        };
        Ok(Self { decoder: Decoder::new(frame), chain, resyncs: 0, skipped_bytes: 0 })
    }

    /// Takes what happened on the line at `time`, which must not go back.
    ///
    /// # Errors
    /// [`PipelineError::Device`] when a device failed; nothing more is given to any device then.
    pub fn take(
        &mut self,
        time: SimTime,
        input: LineInput<'_>,
        observer: &mut dyn LiveObserver,
    ) -> Result<(), PipelineError> {
        match input {
            LineInput::Bytes(bytes) => return self.push(time, bytes, observer),
            LineInput::Silent => self.chain.silent_until = Some(time),
            LineInput::Lost => {
                self.chain.outage = true;
                // Half a frame will not be continued by another.
                self.decoder.finish();
            }
            LineInput::Back => {}
        }
        Ok(())
    }

    fn push(
        &mut self,
        arrival: SimTime,
        bytes: &[u8],
        observer: &mut dyn LiveObserver,
    ) -> Result<(), PipelineError> {
        let Self { decoder, chain, .. } = self;
        decoder.push(bytes, &mut |frame| chain.frame(frame, arrival, observer));
        chain.silent_until = None;
        let counters = self.decoder.counters();
        if counters.resyncs > self.resyncs {
            let skipped_bytes = counters.skipped_bytes - self.skipped_bytes;
            observer.event(self.time(), &LiveEvent::Resync { skipped_bytes });
            self.resyncs = counters.resyncs;
            self.skipped_bytes = counters.skipped_bytes;
        }
        self.chain.devices.outcome()
    }

    /// The record's time at the end of the last sample.
    #[must_use]
    pub fn time(&self) -> SimTime {
        self.chain.time()
    }

    /// The decoder's layout.
    #[must_use]
    pub const fn spec(&self) -> &FrameSpec {
        self.decoder.spec()
    }

    /// What has gone through so far.
    #[must_use]
    pub fn report(&self) -> LiveReport {
        LiveReport {
            wire: self.decoder.counters(),
            outputs: self.chain.devices.outputs,
            skew: self.chain.base.skew(),
            ..self.chain.report
        }
    }

    /// What was seen of a line that was looked at for `span_s`.
    #[must_use]
    pub fn sighting(&self, span_s: f64) -> Sighting {
        let (counters, spec) = (self.decoder.counters(), self.decoder.spec());
        let rate_hz = spec.timing().rate_hz;
        Sighting {
            span_s,
            bytes: counters.bytes,
            false_starts: counters.bad_check + counters.bad_sequence,
            expected_bytes_per_s: spec.frame_len() as f64 * rate_hz,
            expected_frames_per_s: rate_hz,
        }
    }

    /// Ends the stream at `now`: a port that is still gone leaves its gap behind.
    pub fn finish(&mut self, now: SimTime, observer: &mut dyn LiveObserver) -> LiveReport {
        self.decoder.finish();
        self.chain.finish(now, observer);
        self.report()
    }
}

impl Chain {
    fn time(&self) -> SimTime {
        self.last.map_or(SimTime::ZERO, |(_, index)| self.clock.time_of(index + 1))
    }

    fn frame(&mut self, frame: &Frame, arrival: SimTime, observer: &mut dyn LiveObserver) {
        let after_outage = std::mem::take(&mut self.outage);
        let silent_until = self.silent_until.take();
        let heard = Heard { index: frame.index, arrival, silent_until, after_outage };
        let resolved = self.resolver.resolve(&heard, &self.base);
        observer.frame(arrival, &resolved);
        let before = self.time();
        let paused = self.is_paused(&heard, &resolved);
        self.tell_time(arrival, &resolved, paused, observer);
        let cause = match (after_outage, paused) {
            (true, _) => GapCause::Port,
            (false, true) => GapCause::Pause,
            (false, false) => GapCause::Line,
        };
        let is_gap = resolved.lost > 0 || cause != GapCause::Line;
        if is_gap && self.last.is_some() {
            let to = self.clock.time_of(resolved.index).max(before);
            let Resolved { lost, basis, .. } = resolved;
            self.gap(Gap { from: before, to, lost, cause, basis }, observer);
        }
        self.last = Some((arrival, resolved.index));
        self.measure(frame, resolved.index, observer);
    }

    /// Whether time has passed in which the sensor took no samples: the line was seen silent for
    /// most of it.
    fn is_paused(&self, heard: &Heard, resolved: &Resolved) -> bool {
        let (Some((last, _)), Some(silent_until)) = (self.last, heard.silent_until) else {
            return false;
        };
        let late_s = self.base.lateness_s(resolved.index, heard.arrival);
        late_s > PAUSE_S && silent_until.seconds_since(last) > 0.5 * late_s
    }

    /// Brings time base and clock to the end of the sample.
    fn tell_time(
        &mut self,
        arrival: SimTime,
        resolved: &Resolved,
        paused: bool,
        observer: &mut dyn LiveObserver,
    ) {
        if resolved.basis == Basis::Restarted {
            observer.event(self.time(), &LiveEvent::CounterRestarted);
        }
        if paused || resolved.basis == Basis::Restarted {
            self.base.restart(resolved.index, arrival);
        } else if let Observed::ClockSet(by_s) = self.base.observe(resolved.index, arrival) {
            observer.event(self.time(), &LiveEvent::ClockSet { by_s });
        }
        let target = self.base.time_of(resolved.index, arrival);
        let slew = if self.base.is_settled() { SLEW } else { self.tolerance.max(SLEW) };
        self.clock.advance(resolved.index + 1, target, self.base.period_s(), slew);
    }

    fn gap(&mut self, gap: Gap, observer: &mut dyn LiveObserver) {
        let report = &mut self.report;
        let of_cause = match gap.cause {
            GapCause::Port => &mut report.lost_with_port,
            GapCause::Line | GapCause::Pause => &mut report.lost_on_line,
        };
        *of_cause = of_cause.saturating_add(gap.lost);
        let is_inferred = matches!(gap.basis, Basis::Inferred | Basis::Restarted);
        report.inferred_gaps += u64::from(is_inferred);
        report.longest_gap_s = report.longest_gap_s.max(gap.to.seconds_since(gap.from));
        observer.event(gap.from, &LiveEvent::Gap(gap));
    }

    fn measure(&mut self, frame: &Frame, index: u64, observer: &mut dyn LiveObserver) {
        if !frame.has(self.channel.rate) {
            let Self { averager, devices, clock, .. } = self;
            let times = |instant| clock.time_of(instant);
            averager.pass_over_timed(index, &times, &mut |sample| {
                devices.step(sample, &mut |sample, estimates| observer.output(sample, estimates));
            });
            return;
        }
        if !self.channel.is_valid(frame) {
            self.report.not_valid += 1;
            return;
        }
        let clipped = self.channel.is_over_range(frame);
        self.report.over_range += u64::from(clipped);
        let rate_rad_s = self.rate_field.to_si(frame.raw()[self.channel.rate]);
        let cross_rates_rad_s = self.cross.as_ref().map(|cross| cross.rates_rad_s(frame));
        let measured = Measured { rate_rad_s, cross_rates_rad_s, over_range: clipped };
        let Self { averager, devices, clock, .. } = self;
        let times = |instant| clock.time_of(instant);
        averager.add_measured_timed(index, measured, &times, &mut |sample| {
            devices.step(sample, &mut |sample, estimates| observer.output(sample, estimates));
        });
    }

    fn finish(&mut self, now: SimTime, observer: &mut dyn LiveObserver) {
        let Some((last, index)) = self.last.filter(|_| self.outage) else { return };
        self.outage = false;
        let gone_s = now.seconds_since(last).max(0.0);
        let periods = (gone_s / self.base.period_s()).round();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative")]
        let lost = periods as u64;
        let from = self.time();
        let to = self.clock.time_of(index.saturating_add(1).saturating_add(lost));
        let (cause, basis) = (GapCause::Port, Basis::Inferred);
        self.gap(Gap { from, to, lost, cause, basis }, observer);
    }
}
