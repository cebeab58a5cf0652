//! Everything left of the line: motion, gyro, encoder. Bytes out, and the truth beside them.

use crate::axes::CrossGyros;
use crate::fault::{Dispatch, FaultRecord, Injector};
use crate::{MotionSource, Reference, SourceError};
use struna_gyro::{Gyro, SampleClock, Surroundings, Upset};
use struna_kernel::{GyroReading, SampleGrid, SimTime};
use struna_wire::{EncodeError, Encoder, FieldSpec, FrameSpec};

/// How the emulator keeps time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pacing {
    /// As fast as the reader takes the bytes; no clock is looked at.
    AsFastAsPossible,
    /// Each frame at its own absolute deadline.
    RealTime,
}

/// Why the emulator stopped.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EmulatorError {
    /// The motion source failed.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The layout has no field to put the rate into.
    #[error("frame layout '{frame}' has no field 'rate'; add one")]
    NoRate {
        /** Name of the layout. */
        frame: String,
    },
    /// Counts of this gyro would be misread.
    #[error(
        "the gyro's count is {gyro_rad_s:e} rad/s but frame layout '{frame}' declares \
         {frame_rad_s:e} rad/s; make `lsb_deg_s` of the gyro and `scale` of the frame equal"
    )]
    ScaleMismatch {
        /** Name of the layout. */
        frame: String,
        /** One count of the gyro, rad/s. */
        gyro_rad_s: f64,
        /** One count by the layout, rad/s. */
        frame_rad_s: f64,
    },
    /// Three rates to send, and a motion about one axis.
    #[error(
        "frame layout '{frame}' carries rates about three axes and this motion knows one; take a \
         layout with the field 'rate' alone"
    )]
    OneAxis {
        /** Name of the layout. */
        frame: String,
    },
    /// A reading that the layout cannot carry.
    #[error(transparent)]
    Encode(#[from] EncodeError),
}

/// What the emulator did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct EmulatorReport {
    /// Frames put on the line.
    pub frames: u64,
    /// Bytes put on the line.
    pub bytes: u64,
    /// Samples whose measured rate lay beyond the gyro's range.
    pub saturated: u64,
}

/// Turns motion into gyro frames, one at a time. Knows no port and no clock.
pub struct Emulator {
    source: Box<dyn MotionSource>,
    gyro: Gyro,
    /// Those about the other two axes, when the layout has a place for them.
    cross: Option<Box<CrossGyros>>,
    /// When the gyro samples, and the instant of the next frame.
    clock: SampleClock,
    next: SimTime,
    surroundings: Surroundings,
    encoder: Encoder,
    layout: Layout,
    raw: Vec<i64>,
    frame: Vec<u8>,
    injector: Option<Injector>,
    /// Instant and input angle of the last frame's motion.
    before: Option<(SimTime, f64)>,
    report: EmulatorReport,
}

impl std::fmt::Debug for Emulator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Emulator").field("gyro", &self.gyro).finish_non_exhaustive()
    }
}

impl Emulator {
    /// An emulator of `gyro` on the body that `source` moves, speaking frames of layout `frame`.
    /// A layout that carries three rates gets two gyros more, about the other axes of the case,
    /// with noises of their own and sampled by the clock of the first.
    /// The gyro's clock means to sample on `grid`; the laboratory is quiet unless
    /// [`Self::with_surroundings`] says otherwise.
    ///
    /// # Errors
    /// [`EmulatorError`] when the layout has no rate or counts differently.
    pub fn new(
        source: Box<dyn MotionSource>,
        gyro: Gyro,
        grid: SampleGrid,
        frame: &FrameSpec,
    ) -> Result<Self, EmulatorError> {
        let layout = Layout::find(frame, gyro.params().lsb_rad_s)?;
        let cross = CrossGyros::find(frame, &gyro)?.map(Box::new);
        let raw = vec![0; frame.fields().len()];
        let encoder = Encoder::new(frame);
        let mut clock = gyro.clock(grid);
        let next = clock.time_of(encoder.next_index() + 1);
        let (surroundings, report) = (Surroundings::default(), EmulatorReport::default());
        let frame = Vec::with_capacity(frame.frame_len());
        let (injector, before) = (None, None);
        Ok(Self {
            source,
            gyro,
            cross,
            clock,
            next,
            surroundings,
            encoder,
            layout,
            raw,
            frame,
            injector,
            before,
            report,
        })
    }

    /// The same emulator, its gyro in these surroundings.
    #[must_use]
    pub fn with_surroundings(self, surroundings: Surroundings) -> Self {
        Self { surroundings, ..self }
    }

    /// The same emulator, with the faults of `injector`.
    #[must_use]
    pub fn with_faults(self, injector: Injector) -> Self {
        Self { injector: Some(injector), ..self }
    }

    /// What has been injected so far.
    #[must_use]
    pub fn fault_records(&self) -> &[FaultRecord] {
        self.injector.as_ref().map_or(&[], Injector::records)
    }

    /// Instant at which the next frame is complete.
    #[must_use]
    pub fn next_time(&self) -> SimTime {
        self.next
    }

    /// The same by the gyro's own clock, which is all that a reader of its counter can know.
    #[must_use]
    pub fn next_sensor_time(&self) -> SimTime {
        self.clock.grid().time_of(self.encoder.next_index() + 1)
    }

    /// Appends the next frame, or what faults leave of it, to `out`; returns the motion at its
    /// instant. Faults of time alone leave no trace here.
    ///
    /// # Errors
    /// [`EmulatorError`] when the motion cannot be carried on; nothing was appended then.
    pub fn emit(&mut self, out: &mut Vec<u8>) -> Result<Reference, EmulatorError> {
        if self.injector.is_none() {
            let sent_before = out.len();
            let now = self.take(out)?;
            self.report.bytes += (out.len() - sent_before) as u64;
            return Ok(now);
        }
        self.emit_to(&mut |dispatch| {
            if let Dispatch::Bytes { bytes, .. } = dispatch {
                out.extend_from_slice(bytes);
            }
        })
    }

    /// Hands the next frame, or what faults leave of it, to `sink` with the instant at which it may
    /// leave; returns the motion at the sample's instant.
    ///
    /// # Errors
    /// [`EmulatorError`] when the motion cannot be carried on; nothing was handed over then.
    pub fn emit_to(
        &mut self,
        sink: &mut dyn FnMut(Dispatch<'_>),
    ) -> Result<Reference, EmulatorError> {
        self.frame.clear();
        let mut frame = std::mem::take(&mut self.frame);
        let taken = self.take(&mut frame);
        self.frame = frame;
        let now = taken?;
        let sent = &mut self.report.bytes;
        let mut sink = counted(sent, sink);
        match &mut self.injector {
            Some(injector) => injector.dispatch(&self.frame, &mut sink),
            None => sink(Dispatch::Bytes { ready: now.time, baud_ratio: 1.0, bytes: &self.frame }),
        }
        Ok(now)
    }

    /// Takes the next sample and appends its frame to `out`; nothing when it fails.
    fn take(&mut self, out: &mut Vec<u8>) -> Result<Reference, EmulatorError> {
        let index = self.encoder.next_index();
        let (time_before, angle_before_rad) = match self.before {
            Some(before) => before,
            None => self.first_instant(index)?,
        };
        let now = self.source.reference_at(self.next)?;
        if let Some(cross) = &mut self.cross {
            cross.advance(self.source.as_mut(), now.time)?;
        }
        let rate_rad_s = if self.gyro.takes_means() {
            (now.input_angle_rad - angle_before_rad) / now.time.seconds_since(time_before)
        } else {
            now.input_rate_rad_s
        };
        let upset = match &mut self.injector {
            Some(injector) => injector.begin(index, now.time),
            None => Upset::default(),
        };
        let force = now.specific_force_s_m_s2;
        let input = self.surroundings.input_at(now.time.as_s(), rate_rad_s, force);
        let mut reading = self.gyro.sample_upset(input, &upset);
        self.raw.fill(0);
        if let Some(cross) = &mut self.cross {
            cross.sample(&input, &mut reading.flags, &mut self.raw);
        }
        self.layout.fill(&reading, &mut self.raw);
        self.encoder.encode(&self.raw, out)?;
        self.before = Some((now.time, now.input_angle_rad));
        self.next = self.clock.time_of(self.encoder.next_index() + 1);
        self.report.frames += 1;
        self.report.saturated += u64::from(reading.flags.over_range);
        Ok(now)
    }

    /// The first instant, before which nothing has been sampled, and the input angle then, rad.
    fn first_instant(&mut self, index: u64) -> Result<(SimTime, f64), EmulatorError> {
        let first = self.source.reference_at(self.clock.time_of(index))?;
        if let Some(cross) = &mut self.cross {
            cross.begin(self.source.as_mut(), first.time)?;
        }
        Ok((first.time, first.input_angle_rad))
    }

    /// Ends the stream: a frame that a fault holds back is handed over, events under way end.
    pub fn finish(&mut self, sink: &mut dyn FnMut(Dispatch<'_>)) {
        if let Some(injector) = &mut self.injector {
            injector.finish(&mut counted(&mut self.report.bytes, sink));
        }
    }

    /// What it has done so far.
    #[must_use]
    pub fn report(&self) -> EmulatorReport {
        self.report
    }
}

/// `sink`, with the bytes that pass added to `sent`.
fn counted(sent: &mut u64, sink: &mut dyn FnMut(Dispatch<'_>)) -> impl FnMut(Dispatch<'_>) {
    move |dispatch| {
        if let Dispatch::Bytes { bytes, .. } = dispatch {
            *sent += bytes.len() as u64;
        }
        sink(dispatch);
    }
}

/// Refuses a layout whose field `rate` counts in other steps than the gyro.
pub(crate) fn check_scale(
    frame: &FrameSpec,
    rate: usize,
    gyro_rad_s: f64,
) -> Result<(), EmulatorError> {
    let frame_rad_s = frame.fields()[rate].scale_si();
    // Both come from decimal text through one multiplication: equal to the last bits or not
    // meant to be equal.
    if (frame_rad_s / gyro_rad_s - 1.0).abs() > 1e-12 {
        let frame = frame.name().to_owned();
        return Err(EmulatorError::ScaleMismatch { frame, gyro_rad_s, frame_rad_s });
    }
    Ok(())
}

/// Where the parts of a reading go in a frame. What the layout does not have is not sent.
#[derive(Debug)]
struct Layout {
    rate: usize,
    temperature: Option<Temperature>,
    valid: Option<Bit>,
    over_range: Option<Bit>,
    warm_up: Option<Bit>,
    temperature_valid: Option<Bit>,
}

/// The temperature's field, and its raw value for the last temperature, which seldom changes.
#[derive(Debug)]
struct Temperature {
    at: usize,
    field: FieldSpec,
    last: Option<(f64, i64)>,
}

#[derive(Debug, Clone, Copy)]
struct Bit {
    field: usize,
    mask: i64,
}

impl Layout {
    fn find(frame: &FrameSpec, gyro_rad_s: f64) -> Result<Self, EmulatorError> {
        let name = || frame.name().to_owned();
        let rate =
            frame.field_index("rate").ok_or_else(|| EmulatorError::NoRate { frame: name() })?;
        check_scale(frame, rate, gyro_rad_s)?;
        let bit = |flag: &str| {
            let flag = &frame.flags()[frame.flag_index(flag)?];
            Some(Bit { field: flag.field(), mask: flag.mask() })
        };
        let temperature = frame.field_index("temp").map(|at| {
            let field = frame.fields()[at].clone();
            Temperature { at, field, last: None }
        });
        let (valid, over_range) = (bit("valid"), bit("over_range"));
        let (warm_up, temperature_valid) = (bit("warm_up"), bit("temp_valid"));
        Ok(Self { rate, temperature, valid, over_range, warm_up, temperature_valid })
    }

    /// Fills in what there is; the rest of `raw` is left as it is.
    fn fill(&mut self, reading: &GyroReading, raw: &mut [i64]) {
        raw[self.rate] = i64::from(reading.counts.0);
        let set = |raw: &mut [i64], bit: Option<Bit>, on: bool| {
            if let Some(Bit { field, mask }) = bit.filter(|_| on) {
                raw[field] |= mask;
            }
        };
        if let Some(temperature) = &mut self.temperature {
            raw[temperature.at] = temperature.raw_of(reading.temperature_deg_c);
            set(raw, self.temperature_valid, reading.flags.temperature_valid);
        }
        set(raw, self.valid, reading.flags.valid);
        set(raw, self.over_range, reading.flags.over_range);
        set(raw, self.warm_up, reading.flags.warm_up);
    }
}

impl Temperature {
    fn raw_of(&mut self, temperature_deg_c: f64) -> i64 {
        match self.last {
            Some((last_deg_c, raw)) if last_deg_c.to_bits() == temperature_deg_c.to_bits() => raw,
            _ => {
                let raw = self.field.from_si(temperature_deg_c);
                self.last = Some((temperature_deg_c, raw));
                raw
            }
        }
    }
}
