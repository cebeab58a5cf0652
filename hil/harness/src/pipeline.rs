//! Everything right of the line: bytes in, estimates out. No port, no clock, no truth.

use crate::axes::CrossRates;
use crate::{Averager, DeviceError, DeviceUnderTest, Measured};
use struna_kernel::{AngleEstimate, RateSample};
use struna_wire::{Counters, Decoder, FieldSpec, Frame, FrameSpec, Unit};

/// Where a frame layout keeps the rate and its status.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GyroChannel {
    pub(crate) rate: usize,
    valid: Option<usize>,
    over_range: Option<usize>,
}

/// Why a layout cannot feed the estimators, or why they stopped.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PipelineError {
    /// No rate in the layout.
    #[error("frame layout '{frame}' has no field 'rate' in rad/s or deg/s; add one")]
    NoRate {
        /** Name of the layout. */
        frame: String,
    },
    /// A device failed.
    #[error(transparent)]
    Device(#[from] DeviceError),
}

impl GyroChannel {
    /// Finds the fields `rate`, and the flags `valid` and `over_range` if the layout has them.
    ///
    /// # Errors
    /// [`PipelineError::NoRate`] when there is no rate.
    pub fn find(frame: &FrameSpec) -> Result<Self, PipelineError> {
        let rate = frame
            .field_index("rate")
            .filter(|index| matches!(frame.fields()[*index].unit(), Unit::RadPerS | Unit::DegPerS))
            .ok_or_else(|| PipelineError::NoRate { frame: frame.name().to_owned() })?;
        let (valid, over_range) = (frame.flag_index("valid"), frame.flag_index("over_range"));
        Ok(Self { rate, valid, over_range })
    }

    pub(crate) fn is_valid(&self, frame: &Frame) -> bool {
        self.valid.is_none_or(|flag| frame.flag(flag))
    }

    pub(crate) fn is_over_range(&self, frame: &Frame) -> bool {
        self.over_range.is_some_and(|flag| frame.flag(flag))
    }
}

/// What went through the pipeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PipelineReport {
    /// The decoder's counters.
    pub wire: Counters,
    /// Gyro samples marked over range.
    pub over_range: u64,
    /// Gyro samples marked not valid, and therefore not used.
    pub not_valid: u64,
    /// Averaged samples given to the devices.
    pub outputs: u64,
}

/// Decoder, averager and devices in a row.
///
/// Allocates at construction only.
pub struct Pipeline {
    decoder: Decoder,
    channel: GyroChannel,
    rate_field: FieldSpec,
    cross: Option<CrossRates>,
    averager: Averager,
    devices: Devices,
    over_range: u64,
    not_valid: u64,
}

/// The devices and what they made of the last sample.
pub(crate) struct Devices {
    under_test: Vec<Box<dyn DeviceUnderTest>>,
    estimates: Vec<AngleEstimate>,
    pub(crate) outputs: u64,
    failure: Option<DeviceError>,
}

impl std::fmt::Debug for Pipeline {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Pipeline").field("channel", &self.channel).finish_non_exhaustive()
    }
}

impl Pipeline {
    /// A pipeline for frames of layout `frame`.
    ///
    /// # Errors
    /// [`PipelineError::NoRate`] when the layout carries no rate.
    pub fn new(
        frame: FrameSpec,
        averager: Averager,
        under_test: Vec<Box<dyn DeviceUnderTest>>,
    ) -> Result<Self, PipelineError> {
        let channel = GyroChannel::find(&frame)?;
        let devices = Devices::new(under_test);
        let rate_field = frame.fields()[channel.rate].clone();
        let cross = CrossRates::find(&frame);
        let decoder = Decoder::new(frame);
        let (over_range, not_valid) = (0, 0);
        Ok(Self { decoder, channel, rate_field, cross, averager, devices, over_range, not_valid })
    }

    /// Takes bytes off the line; `sink` sees each averaged sample with the estimates made of it, in
    /// the order of the devices.
    ///
    /// # Errors
    /// [`PipelineError::Device`] when a device failed; nothing more is given to any device then.
    pub fn push(
        &mut self,
        bytes: &[u8],
        sink: &mut dyn FnMut(&RateSample, &[AngleEstimate]),
    ) -> Result<(), PipelineError> {
        let Self { decoder, channel, rate_field, cross, averager, devices, .. } = self;
        let (over_range, not_valid) = (&mut self.over_range, &mut self.not_valid);
        decoder.push(bytes, &mut |frame| {
            if !frame.has(channel.rate) {
                averager.pass_over(frame.index, &mut |sample| devices.step(sample, sink));
                return;
            }
            if !channel.is_valid(frame) {
                *not_valid += 1;
                return;
            }
            let clipped = channel.is_over_range(frame);
            *over_range += u64::from(clipped);
            let rate_rad_s = rate_field.to_si(frame.raw()[channel.rate]);
            let cross_rates_rad_s = cross.as_ref().map(|cross| cross.rates_rad_s(frame));
            let measured = Measured { rate_rad_s, cross_rates_rad_s, over_range: clipped };
            averager.add_measured(frame.index, measured, &mut |sample| {
                devices.step(sample, sink);
            });
        });
        devices.outcome()
    }

    /// Baud rate that the layout declares for its line.
    #[must_use]
    pub fn baud(&self) -> u32 {
        self.decoder.spec().line().baud
    }

    /// Names of the devices, in the order of their estimates.
    pub fn device_names(&self) -> impl Iterator<Item = &str> {
        self.devices.under_test.iter().map(|device| device.name())
    }

    /// Ends the stream and says what went through.
    pub fn finish(&mut self) -> PipelineReport {
        PipelineReport {
            wire: self.decoder.finish(),
            over_range: self.over_range,
            not_valid: self.not_valid,
            outputs: self.devices.outputs,
        }
    }
}

impl Devices {
    pub(crate) fn new(under_test: Vec<Box<dyn DeviceUnderTest>>) -> Self {
        let estimates = Vec::with_capacity(under_test.len());
        Self { under_test, estimates, outputs: 0, failure: None }
    }

    /// The failure that made the devices stop, told once.
    pub(crate) fn outcome(&mut self) -> Result<(), PipelineError> {
        self.failure.take().map_or(Ok(()), |failure| Err(failure.into()))
    }

    pub(crate) fn step(
        &mut self,
        sample: &RateSample,
        sink: &mut dyn FnMut(&RateSample, &[AngleEstimate]),
    ) {
        if self.failure.is_some() {
            return;
        }
        self.estimates.clear();
        for device in &mut self.under_test {
            match device.step(sample) {
                Ok(estimate) => self.estimates.push(estimate),
                Err(failure) => {
                    self.failure = Some(failure);
                    return;
                }
            }
        }
        self.outputs += 1;
        sink(sample, &self.estimates);
    }
}
