//! The two axes beside the input axis: gyros about them, and their place in a frame.
//!
//! A layout that has the fields `rate_x` and `rate_y` beside `rate` speaks for a triad of gyros
//! along the axes of one case. `rate` stays the input axis, the case's z, and whoever reads one
//! rate reads that.

use crate::emulator::check_scale;
use crate::{CrossAxes, EmulatorError, MotionSource};
use struna_gyro::{Gyro, GyroInput};
use struna_kernel::{GyroReading, ReadingFlags, SimTime};
use struna_wire::{FieldSpec, Frame, FrameSpec, Unit};

/// Where a layout keeps the rates about the x and y axes of the case: its fields `rate_x` and
/// `rate_y`, rates both, in every frame that holds `rate`. None when it does not keep both.
#[must_use]
pub fn cross_rate_fields(frame: &FrameSpec) -> Option<[usize; 2]> {
    let main = &frame.fields()[frame.field_index("rate")?];
    let find = |name: &str| {
        frame.field_index(name).filter(|index| {
            let field = &frame.fields()[*index];
            let is_rate = matches!(field.unit(), Unit::RadPerS | Unit::DegPerS);
            is_rate && field.when() == main.when()
        })
    };
    Some([find("rate_x")?, find("rate_y")?])
}

/// Reads the rates about the other two axes out of frames.
pub(crate) struct CrossRates([(usize, FieldSpec); 2]);

impl CrossRates {
    pub(crate) fn find(frame: &FrameSpec) -> Option<Self> {
        let fields = cross_rate_fields(frame)?;
        Some(Self(fields.map(|field| (field, frame.fields()[field].clone()))))
    }

    /// Of a frame that holds the main rate.
    pub(crate) fn rates_rad_s(&self, frame: &Frame) -> [f64; 2] {
        self.0.each_ref().map(|(at, field)| field.to_si(frame.raw()[*at]))
    }
}

/// The gyros about the x and y axes of a case whose input axis has a gyro already.
#[derive(Debug)]
pub(crate) struct CrossGyros {
    gyros: [Gyro; 2],
    fields: [usize; 2],
    /// Name of the layout.
    frame: String,
    /// The motion at the last sample and at the coming one.
    span: Option<[(SimTime, CrossAxes); 2]>,
}

impl CrossGyros {
    /// Gyros like `main`, when `frame` has a place for what they say.
    pub(crate) fn find(frame: &FrameSpec, main: &Gyro) -> Result<Option<Self>, EmulatorError> {
        let Some(fields) = cross_rate_fields(frame) else { return Ok(None) };
        for field in fields {
            check_scale(frame, field, main.params().lsb_rad_s)?;
        }
        let gyros = [1, 2].map(|axis| main.about_axis(axis));
        Ok(Some(Self { gyros, fields, frame: frame.name().to_owned(), span: None }))
    }

    /// Takes the motion at the instant before the first sample.
    pub(crate) fn begin(
        &mut self,
        source: &mut dyn MotionSource,
        time: SimTime,
    ) -> Result<(), EmulatorError> {
        let first = (time, self.motion(source, time)?);
        self.span = Some([first; 2]);
        Ok(())
    }

    /// Takes the motion at the end of the coming sample.
    pub(crate) fn advance(
        &mut self,
        source: &mut dyn MotionSource,
        time: SimTime,
    ) -> Result<(), EmulatorError> {
        let now = (time, self.motion(source, time)?);
        let [_, before] = self.span.unwrap_or([now; 2]);
        self.span = Some([before, now]);
        Ok(())
    }

    fn motion(
        &self,
        source: &mut dyn MotionSource,
        time: SimTime,
    ) -> Result<CrossAxes, EmulatorError> {
        let axes = source.cross_axes_at(time)?;
        axes.ok_or_else(|| EmulatorError::OneAxis { frame: self.frame.clone() })
    }

    /// Samples both gyros, which feel what `main` feels but for the rate, into `raw`. One sample
    /// is all three: `flags` turn bad with the first that is bad.
    pub(crate) fn sample(&mut self, main: &GyroInput, flags: &mut ReadingFlags, raw: &mut [i64]) {
        let Some([(from, before), (to, now)]) = self.span else { return };
        let span_s = to.seconds_since(from);
        for axis in 0..2 {
            let gyro = &mut self.gyros[axis];
            let rate_rad_s = if gyro.takes_means() && span_s > 0.0 {
                (now.angles_rad[axis] - before.angles_rad[axis]) / span_s
            } else {
                now.rates_rad_s[axis]
            };
            let reading = gyro.sample(turned(main, rate_rad_s, axis));
            raw[self.fields[axis]] = i64::from(reading.counts.0);
            merge(flags, &reading);
        }
    }
}

/// What the gyro about axis x (0) or y (1) of the case feels at the given rate, along axes of its
/// own, the third of which is its input axis: (y, z, x) and (z, x, y).
fn turned(main: &GyroInput, rate_rad_s: f64, axis: usize) -> GyroInput {
    let [x, y, z] = main.specific_force_s_m_s2;
    let specific_force_s_m_s2 = if axis == 0 { [y, z, x] } else { [z, x, y] };
    GyroInput { rate_rad_s, specific_force_s_m_s2, ..*main }
}

fn merge(flags: &mut ReadingFlags, reading: &GyroReading) {
    flags.valid &= reading.flags.valid;
    flags.over_range |= reading.flags.over_range;
    flags.warm_up |= reading.flags.warm_up;
}
