//! `struna truth`.

use super::Outcome;
use crate::backend;
use crate::output::write_whole;
use crate::progress::Progress;
use crate::record::Record;
use crate::scenario::{Scenario, Source};
use crate::session::motion_source;
use anyhow::{Error, Result};
use std::io::{self, Write};
use std::path::Path;
use struna_body::{Mounting, TruthMotion};
use struna_harness::SourceError;
use struna_kernel::{BodyMotion, SampleGrid, SimTime};

const RATE_COLUMNS: [&str; 3] = ["time", "body_rate_rad_s", "body_rate_integral_rad"];
const MODEL_COLUMNS: [&str; 19] = [
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
    "com_w_x_m",
    "com_w_y_m",
    "com_w_z_m",
    "com_velocity_w_x_m_s",
    "com_velocity_w_y_m_s",
    "com_velocity_w_z_m_s",
    "input_rate_rad_s",
    "input_angle_rad",
];

/// Writes the motion at the gyro's sample instants: all that the model knows, or the rate of a
/// recording and its integral. A motion that stops is written up to there, and says why.
pub(super) fn execute(scenario: &Scenario, csv: &Path) -> Result<Outcome> {
    let grid = SampleGrid::new(SimTime::ZERO, scenario.gyro.sample_rate_hz)?;
    let mut progress = Progress::new(scenario.duration, &scenario.name);
    let mut instants = (0..=grid.periods_until(scenario.duration)).map(|k| {
        let time = grid.time_of(k);
        progress.advance(time);
        time
    });
    let truth = match &scenario.source {
        Source::Model(model) => {
            let motion = model.motion(scenario.seed, 0)?;
            of_model(motion, &scenario.mounting, &mut instants)
        }
        Source::Recording(_) => of_rate(scenario, &mut instants)?,
    };
    progress.finish();
    let (rows, file) = (truth.record.rows(), csv.display());
    if rows > 0 {
        write_whole(csv, |out| truth.write(scenario, out))?;
    }
    match truth.stopped {
        None => println!("{rows} instants written to {file}"),
        Some(reason) if rows == 0 => return Err(reason),
        Some(reason) => {
            let kept = format!("{rows} instants written to {file} until the motion stopped");
            return Err(reason.context(kept));
        }
    }
    Ok(Outcome::Complete)
}

/// A motion, as far as it came.
struct Truth {
    record: Record,
    stopped: Option<Error>,
}

impl Truth {
    /// Asks `row_at` for a row at each instant, until one is refused.
    fn gather<const N: usize, E: Into<Error>>(
        columns: [&str; N],
        instants: &mut dyn Iterator<Item = SimTime>,
        mut row_at: impl FnMut(SimTime) -> Result<[f64; N], E>,
    ) -> Self {
        let mut record = Record::with_columns(columns.map(str::to_owned));
        for time in instants {
            match row_at(time) {
                Ok(row) => record.push(&row),
                Err(reason) => return Self { record, stopped: Some(reason.into()) },
            }
        }
        Self { record, stopped: None }
    }

    /// The record between lines of comment that say where it comes from and why it ends early.
    fn write(&self, scenario: &Scenario, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "# struna truth")?;
        writeln!(out, "# scenario: {}", scenario.name)?;
        writeln!(out, "# backend: {}", backend::sentence(&scenario.source))?;
        writeln!(out, "# seed: {}", scenario.seed.0)?;
        writeln!(out, "# columns: SI units in the names; q_wb carries body components to world")?;
        self.record.write_csv(out)?;
        self.stopped.iter().try_for_each(|reason| writeln!(out, "# stopped: {reason}"))
    }
}

fn of_model(
    mut truth: TruthMotion,
    mounting: &Mounting,
    instants: &mut dyn Iterator<Item = SimTime>,
) -> Truth {
    let row_at = |time| truth.motion_at(time).map(|motion| model_row(&motion, mounting));
    Truth::gather(MODEL_COLUMNS, instants, row_at)
}

/// The mean of the input rate over any span is the difference of the input angle over it.
fn model_row(motion: &BodyMotion, mounting: &Mounting) -> [f64; 19] {
    let (omega, q) = (motion.omega_wb_b_rad_s, motion.q_wb.quaternion());
    let (com, velocity) = (motion.com_position_w_m, motion.com_velocity_w_m_s);
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
        com.x,
        com.y,
        com.z,
        velocity.x,
        velocity.y,
        velocity.z,
        mounting.rate_rad_s(motion),
        mounting.angle_rad(motion),
    ]
}

fn of_rate(scenario: &Scenario, instants: &mut dyn Iterator<Item = SimTime>) -> Result<Truth> {
    let mut source = motion_source(scenario)?;
    Ok(Truth::gather(RATE_COLUMNS, instants, |time| {
        let reference = source.reference_at(time)?;
        Ok::<_, SourceError>([time.as_s(), reference.rate_rad_s, reference.spin_rad])
    }))
}
