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

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "numbers are passed on, not computed")]
mod tests {
    use super::*;
    use crate::{MotionSource, Recording};
    use struna_gyro::preset;
    use struna_kernel::{RAD_PER_DEG, Seed};

    const TRIAD: &str = include_str!("../../../frames/vg910d-triad.toml");

    fn fields(text: &str) -> Option<[usize; 2]> {
        cross_rate_fields(&FrameSpec::from_toml(text).unwrap())
    }

    #[test]
    fn a_triad_has_both_rates_beside_the_main_one_and_as_rates() {
        assert_eq!(fields(TRIAD), Some([0, 1]));
        assert_eq!(fields(include_str!("../../../frames/vg910d.toml")), None);
        assert_eq!(fields(&TRIAD.replacen("\"rate_y\"", "\"roll\"", 1)), None);
        assert_eq!(fields(&TRIAD.replacen("unit = \"deg/s\"", "unit = \"counts\"", 1)), None);
        assert_eq!(fields(&TRIAD.replacen("\"rate\"", "\"yaw\"", 1)), None);
    }

    #[test]
    fn a_rate_that_only_some_frames_carry_makes_no_triad() {
        let of_all = include_str!("../../../frames/adis16100.toml");
        // What the two analog inputs are, in frames of their own.
        let named = of_all.replacen("\"ain1\"", "\"rate_x\"", 1);
        let named =
            named.replacen("\"ain2\"", "\"rate_y\"", 1).replace("unit = \"V\"", "unit = \"deg/s\"");
        assert_eq!(fields(&named), None);
    }

    #[test]
    fn each_gyro_feels_the_force_along_its_own_axes() {
        let main = GyroInput { specific_force_s_m_s2: [1.0, 2.0, 3.0], ..GyroInput::from(0.5) };
        let [x, y] = [0, 1].map(|axis| turned(&main, 0.25, axis));
        // The third is the gyro's own input axis.
        assert_eq!(x.specific_force_s_m_s2, [2.0, 3.0, 1.0]);
        assert_eq!(y.specific_force_s_m_s2, [3.0, 1.0, 2.0]);
        assert_eq!((x.rate_rad_s, x.temperature_deg_c), (0.25, main.temperature_deg_c));
    }

    #[test]
    fn a_frame_that_counts_otherwise_about_one_axis_is_refused() {
        let gyro = Gyro::new(preset::vg910d(), Seed(1), 0).unwrap();
        let of = |text: &str| CrossGyros::find(&FrameSpec::from_toml(text).unwrap(), &gyro);
        assert!(of(TRIAD).unwrap().is_some());
        // The first field of the file is `rate_x`.
        let coarse = TRIAD.replacen("scale = 3.0517578125e-5", "scale = 1e-4", 1);
        let Err(EmulatorError::ScaleMismatch { frame_rad_s, .. }) = of(&coarse) else {
            panic!("{coarse} was taken")
        };
        assert_eq!(frame_rad_s, 1e-4 * RAD_PER_DEG);
    }

    #[test]
    fn a_source_of_one_axis_cannot_feed_three_gyros() {
        let gyro = Gyro::new(preset::vg910d(), Seed(1), 0).unwrap();
        let spec = FrameSpec::from_toml(TRIAD).unwrap();
        let mut cross = CrossGyros::find(&spec, &gyro).unwrap().unwrap();
        let mut source = Recording::new(&[0.0, 1.0], &[0.0; 2]).unwrap();
        assert_eq!(source.cross_axes_at(SimTime::ZERO), Ok(None));
        let refused = cross.begin(&mut source, SimTime::ZERO);
        assert!(matches!(refused, Err(EmulatorError::OneAxis { .. })), "{refused:?}");
    }
}
