//! What becomes of an estimator's beliefs while a run goes on: sums, and in the end a row.

use super::contestant::{Contestant, Measured, TrueState};
use super::row::{Column, EPOCHS, Epoch, Outcome, Row, word};
use struna_kernel::RAD_PER_DEG;

/// Errors beyond this count as divergence: a hundred turns, rad.
const DIVERGED_RAD: f64 = 200.0 * std::f64::consts::PI;

/// What is known of a run beforehand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Schedule {
    /// Measurements in the run.
    pub(super) samples: u32,
    /// Number of the first sample on which the first kick shows, from 1.
    pub(super) kick: Option<u32>,
}

/// Truth at a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Truth {
    /// All that can be known.
    pub(super) state: TrueState,
    /// Whether what is claimed of the whole state is judged now; not within a kick and the
    /// first seconds after it, in which nothing can know of it.
    pub(super) settled: bool,
}

/// One estimator on its way through a run.
pub(super) struct Tally {
    row: Row,
    contestant: Box<dyn Contestant>,
    schedule: Schedule,
    angle2: [f64; 2],
    rate2: [f64; 2],
    scored: [u32; 2],
    nis: f64,
    worst_sigmas: f64,
    end: (f64, f64),
    alarms_before_kick: u64,
    delay_samples: Option<u32>,
    taken: u32,
}

impl std::fmt::Debug for Tally {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Tally").field("row", &self.row).finish_non_exhaustive()
    }
}

impl Tally {
    /// `contestant` at the start of a run that `row` describes.
    #[must_use]
    pub(super) fn new(row: Row, contestant: Box<dyn Contestant>, schedule: Schedule) -> Self {
        Self {
            row,
            contestant,
            schedule,
            angle2: [0.0; 2],
            rate2: [0.0; 2],
            scored: [0; 2],
            nis: 0.0,
            worst_sigmas: 0.0,
            end: (f64::NAN, f64::NAN),
            alarms_before_kick: 0,
            delay_samples: None,
            taken: 0,
        }
    }

    /// Takes sample `k`, from 1; after a run has stopped, nothing.
    pub(super) fn step(&mut self, k: u32, measured: &Measured, truth: &Truth) {
        if !self.row.is_complete() {
            return;
        }
        match self.contestant.step(measured) {
            Ok(innovation) => self.nis += innovation.nis(),
            Err(error) => return self.stop(k, &error.to_string()),
        }
        self.taken += 1;
        self.score(k, truth);
    }

    /// Weighs the belief at sample `k` without a new measurement.
    fn score(&mut self, k: u32, truth: &Truth) {
        let belief = self.contestant.belief();
        let angle_rad = belief.angle_rad - truth.state.angle_rad;
        let rate_rad_s = belief.rate_rad_s - truth.state.rate_rad_s;
        let sigma_rad = belief.covariance.angle_rad2.sqrt();
        if !(angle_rad.abs() < DIVERGED_RAD && rate_rad_s.is_finite() && sigma_rad.is_finite()) {
            return self.stop(k, "the angle is off by more than a hundred turns, or no number");
        }
        let half = usize::from(2 * k > self.schedule.samples);
        self.angle2[half] += angle_rad * angle_rad;
        self.rate2[half] += rate_rad_s * rate_rad_s;
        self.scored[half] += 1;
        self.end = (angle_rad, sigma_rad);
        if 4 * k > self.schedule.samples {
            self.worst_sigmas = self.worst_sigmas.max(angle_rad.abs() / sigma_rad);
        }
        self.watch(k);
        self.epoch(k, truth);
    }

    fn watch(&mut self, k: u32) {
        let (Some(kick), Some(alarms)) = (self.schedule.kick, self.contestant.alarms()) else {
            return;
        };
        if k < kick {
            self.alarms_before_kick = alarms;
        } else if self.delay_samples.is_none() && alarms > self.alarms_before_kick {
            self.delay_samples = Some(k - kick);
        }
    }

    fn epoch(&mut self, k: u32, truth: &Truth) {
        #[expect(clippy::cast_possible_truncation, reason = "ten")]
        let length = self.schedule.samples / EPOCHS as u32;
        if length == 0 || !k.is_multiple_of(length) {
            return;
        }
        let (error_rad, sigma_rad) = self.end;
        let nees = self.contestant.nees(&truth.state).filter(|_| truth.settled);
        if let Some((_, states)) = nees {
            self.row.set(Column::NeesStates, f64::from(states));
        }
        if let Some(epoch) = self.row.epochs.get_mut((k / length) as usize - 1) {
            *epoch = Epoch {
                error_deg: error_rad / RAD_PER_DEG,
                sigma_deg: sigma_rad / RAD_PER_DEG,
                nees: nees.map_or(f64::NAN, |(squared, _)| squared),
            };
        }
    }

    fn stop(&mut self, k: u32, reason: &str) {
        self.row.outcome = Outcome::Stopped(format!("sample {k}: {reason}"));
    }

    /// The row of the run, `step_s` seconds from sample to sample.
    #[must_use]
    pub(super) fn finish(mut self, step_s: f64) -> Row {
        self.row.status = word(self.contestant.status());
        if let Some(alarms) = self.contestant.alarms() {
            self.row.set(Column::Alarms, alarms as f64);
        }
        if let Some(yield_rad) = self.contestant.yield_rad() {
            self.row.set(Column::YieldFoundDeg, yield_rad / RAD_PER_DEG);
        }
        if let Some(samples) = self.delay_samples {
            self.row.set(Column::DelayS, f64::from(samples) * step_s);
        }
        // Errors of a run that stopped have no meaning: it counts as infinitely wrong.
        if self.row.is_complete() && self.taken > 0 {
            self.set_errors();
        }
        self.row
    }

    fn set_errors(&mut self) {
        let [first, second] = self.scored.map(f64::from);
        let rms_deg = |sum: f64, n: f64| (sum / n).sqrt() / RAD_PER_DEG;
        let (angle2, rate2, (error_rad, sigma_rad)) = (self.angle2, self.rate2, self.end);
        let row = &mut self.row;
        row.set(Column::AngleRmsDeg, rms_deg(angle2[0] + angle2[1], first + second));
        row.set(Column::AngleHalf2Deg, rms_deg(angle2[1], second));
        row.set(Column::RateRmsDegS, rms_deg(rate2[0] + rate2[1], first + second));
        row.set(Column::RateHalf2DegS, rms_deg(rate2[1], second));
        row.set(Column::AngleEndDeg, error_rad / RAD_PER_DEG);
        row.set(Column::AngleEndSigmaDeg, sigma_rad / RAD_PER_DEG);
        row.set(Column::EndSigmas, error_rad.abs() / sigma_rad);
        row.set(Column::WorstSigmas, self.worst_sigmas);
        row.set(Column::NisMean, self.nis / f64::from(self.taken));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::validate::contestant::Single;
    use struna_estimator::{FilterConfig, PlainIntegration, Refinement};

    const SAMPLES: u32 = 40;

    fn integration() -> Box<dyn Contestant> {
        let config = FilterConfig {
            angle_start_rad: 1.0,
            rate_start_rad_s: 0.0,
            angle_variance_start_rad2: 0.25,
            rate_variance_start_rad2_s2: 1.0,
            measurement_variance_rad2_s2: 1e-20,
            process_noise_rad2_s3: 0.0,
            refinement: Refinement::OFF,
        };
        Box::new(Single(PlainIntegration::new(config).unwrap()))
    }

    /// A body at rest at `angle_rad`, and a gyro that says `rate_rad_s` from sample 21 on.
    fn run(angle_rad: f64, rate_rad_s: f64) -> Row {
        let schedule = Schedule { samples: SAMPLES, kick: None };
        let row = Row::new("suite", "case", "integration", (0, 0));
        let mut tally = Tally::new(row, integration(), schedule);
        let state = TrueState { angle_rad, rate_rad_s: 0.0, s: 1.0, d: 0.0, bias_rad_s: 0.0 };
        for k in 1..=SAMPLES {
            let rate_rad_s = if k > SAMPLES / 2 { rate_rad_s } else { 0.0 };
            tally.step(k, &Measured::new(0.1, rate_rad_s), &Truth { state, settled: true });
        }
        tally.finish(0.1)
    }

    #[test]
    fn errors_and_claims_are_those_of_the_estimator() {
        let row = run(0.0, 0.0);
        let near = |column, expected: f64| {
            let found = row.get(column).unwrap();
            assert!((found - expected).abs() < 1e-9 * expected.abs(), "{column:?}: {found}");
        };
        near(Column::AngleHalf2Deg, 1.0 / RAD_PER_DEG);
        near(Column::AngleRmsDeg, 1.0 / RAD_PER_DEG);
        near(Column::AngleEndSigmaDeg, 0.5 / RAD_PER_DEG);
        near(Column::EndSigmas, 2.0);
        assert_eq!(row.get(Column::Alarms), None, "it has no test");
        assert_eq!((row.status, row.epochs.len()), ("not observable", 10));
        assert!(row.epochs.iter().all(|epoch| (epoch.error_deg * RAD_PER_DEG - 1.0).abs() < 1e-9));
    }

    #[test]
    fn a_run_that_diverges_stops_with_its_reason_and_without_errors() {
        // A tenth of a second at 1e5 rad/s is beyond a hundred turns.
        for (rate_rad_s, reason) in [(1e5, "a hundred turns"), (f64::NAN, "not finite")] {
            let row = run(0.0, rate_rad_s);
            let Outcome::Stopped(said) = &row.outcome else { panic!("{row:?}") };
            assert!(said.starts_with("sample 21: ") && said.contains(reason), "{said}");
            assert_eq!(row.get(Column::AngleHalf2Deg), None);
        }
    }
}
