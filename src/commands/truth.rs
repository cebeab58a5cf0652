//! `struna truth`.

use super::Outcome;
use crate::output::write_whole;
use crate::progress::Progress;
use crate::record::Record;
use crate::scenario::{Scenario, Source};
use crate::session::motion_source;
use anyhow::Result;
use std::path::Path;
use struna_body::TruthMotion;
use struna_kernel::{BodyMotion, SampleGrid, SimTime};

const RATE_COLUMNS: [&str; 3] = ["time", "body_rate_rad_s", "body_rate_integral_rad"];
const MODEL_COLUMNS: [&str; 11] = [
    "time",
    "twist_rad",
    "twist_rate_rad_s",
    "body_rate_integral_rad",
    "omega_wb_b_x_rad_s",
    "omega_wb_b_y_rad_s",
    "omega_wb_b_z_rad_s",
    "q_wb_w",
    "q_wb_x",
    "q_wb_y",
    "q_wb_z",
];

/// Writes the motion at the gyro's sample instants: all that the model knows, or the rate of a
/// recording and its integral.
pub(super) fn execute(scenario: &Scenario, csv: &Path) -> Result<Outcome> {
    let grid = SampleGrid::new(SimTime::ZERO, scenario.gyro.sample_rate_hz)?;
    let mut progress = Progress::new(scenario.duration, &scenario.name);
    let instants = (0..=grid.periods_until(scenario.duration)).map(|k| {
        let time = grid.time_of(k);
        progress.advance(time);
        time
    });
    let record = match &scenario.source {
        Source::Model(model) => of_model(model.motion(scenario.seed, 0)?, instants)?,
        Source::Recording(_) => of_rate(scenario, instants)?,
    };
    progress.finish();
    write_whole(csv, |file| record.write_csv(file))?;
    println!("{} instants written to {}", record.rows(), csv.display());
    Ok(Outcome::Complete)
}

fn of_model(mut truth: TruthMotion, instants: impl Iterator<Item = SimTime>) -> Result<Record> {
    let mut record = Record::with_columns(MODEL_COLUMNS.map(str::to_owned));
    for time in instants {
        record.push(&model_row(&truth.motion_at(time)?));
    }
    Ok(record)
}

fn model_row(motion: &BodyMotion) -> [f64; 11] {
    let (omega, q) = (motion.omega_wb_b_rad_s, motion.q_wb.quaternion());
    [
        motion.time.as_s(),
        motion.twist_rad,
        motion.twist_rate_rad_s,
        motion.spin_rad,
        omega.x,
        omega.y,
        omega.z,
        q.w,
        q.i,
        q.j,
        q.k,
    ]
}

fn of_rate(scenario: &Scenario, instants: impl Iterator<Item = SimTime>) -> Result<Record> {
    let (mut source, _) = motion_source(scenario)?;
    let mut record = Record::with_columns(RATE_COLUMNS.map(str::to_owned));
    for time in instants {
        let reference = source.reference_at(time)?;
        record.push(&[time.as_s(), reference.rate_rad_s, reference.spin_rad]);
    }
    Ok(record)
}
