//! The gyro's error model, sample by sample.

use crate::table::{Row, ns};
use crate::timing::{Burst, best_in_turns, time_per_unit};
use anyhow::Result;
use std::hint::black_box;
use struna_gyro::{
    ClockParams, DriftParams, Gyro, GyroInput, GyroParams, Law, Linearity, Rounding, ScaleFactor,
    Surroundings, datasheet, preset,
};
use struna_kernel::{SampleGrid, Seed, SimTime};

const SAMPLES_PER_BURST: u32 = 200_000;
/// What one sample may cost, s.
const LIMIT_S: f64 = 60e-9;

pub(crate) fn rows() -> Result<Vec<Row>> {
    let mut all = Sampled::new(all_terms())?;
    let mut vg910d = Sampled::new(preset::vg910d())?;
    let mut adis16100 = Sampled::new(preset::adis16100())?;
    let mut white = Sampled::new(datasheet::vg910d())?;
    let mut clock = Clock::new()?;
    let sides = [all.burst(), vg910d.burst(), adis16100.burst(), white.burst(), clock.burst()];
    let taken_s = best_in_turns(sides)?;
    let names = [
        "gyro error model, all terms, one sample",
        "the same, VG-910D preset",
        "the same, ADIS16100 preset",
        "white noise and rounding alone",
        "sample clock with drift and jitter, one instant",
    ];
    let row = |(what, taken_s): (&str, f64)| Row {
        what: what.to_owned(),
        ours: ns(taken_s),
        other: format!("{} (limit)", ns(LIMIT_S)),
        ratio: Some(LIMIT_S / taken_s),
        target: 1.0,
    };
    Ok(names.into_iter().zip(taken_s).map(row).collect())
}

/// The VG-910D with every term that it has off as well.
fn all_terms() -> GyroParams {
    let preset = preset::vg910d();
    let mut bias_effects = preset.bias_effects;
    bias_effects.per_specific_force_s_m = [1e-5, 2e-5, 3e-5];
    GyroParams {
        response: struna_gyro::Response {
            delay_s: 1e-3,
            noise_before_filter: true,
            ..preset.response
        },
        scale: ScaleFactor { error: 1e-3, ..preset.scale },
        linearity: Linearity { law: Law::Sine { fold_back: true }, ..preset.linearity },
        bias_effects,
        drift: DriftParams { rate_ramp_rad_s2: 1e-9, ..preset.drift },
        rounding: Rounding::Angle,
        ..preset
    }
}

struct Sampled {
    gyro: Gyro,
    input: GyroInput,
}

impl Sampled {
    fn new(params: GyroParams) -> Result<Self> {
        let input = Surroundings::default().input_at(0.0, 0.08, None);
        Ok(Self { gyro: Gyro::new(params, Seed(1), 0)?, input })
    }

    fn burst(&mut self) -> Burst<'_> {
        Box::new(|| {
            time_per_unit(SAMPLES_PER_BURST as usize, || {
                // By reference: a number read back in other pieces than it was just written in
                // waits until it is stored, and handing input and reading on by value is such
                // copying.
                for _ in 0..SAMPLES_PER_BURST {
                    black_box(&self.gyro.sample(*black_box(&self.input)));
                }
                Ok(())
            })
        })
    }
}

struct Clock {
    clock: struna_gyro::SampleClock,
    next: u64,
}

impl Clock {
    fn new() -> Result<Self> {
        let params =
            ClockParams { offset: 1e-4, turn_on_sigma: 5e-5, drift_per_s: 1e-12, jitter_s: 5e-6 };
        let grid = SampleGrid::new(SimTime::ZERO, 300.0)?;
        Ok(Self { clock: struna_gyro::SampleClock::new(grid, &params, Seed(1), 0), next: 0 })
    }

    fn burst(&mut self) -> Burst<'_> {
        Box::new(|| {
            time_per_unit(SAMPLES_PER_BURST as usize, || {
                for _ in 0..SAMPLES_PER_BURST {
                    self.next += 1;
                    black_box(self.clock.time_of(self.next));
                }
                Ok(())
            })
        })
    }
}
