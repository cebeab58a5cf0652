//! How far each estimator was from the truth. Reads the record and nothing else.

use crate::record::Record;
use serde::Serialize;
use std::fmt;
use struna_kernel::RAD_PER_DEG;

/// Scores of all estimators of a record.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Score {
    /// One for each estimator, in record order.
    pub estimators: Vec<EstimatorScore>,
}

/// How one estimator did. `null` in JSON: the record has no such truth.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EstimatorScore {
    /// Name of the estimator.
    pub name: String,
    /// Angle against the twist of the string: what the thread's torque sees.
    pub angle_vs_twist_deg: Option<ErrorStatistics>,
    /// Angle against the integral of the body rate: what a perfect gyro integrates.
    pub angle_vs_body_rate_integral_deg: Option<ErrorStatistics>,
    /// Rate against the body rate.
    pub rate_vs_body_rate_deg_s: Option<ErrorStatistics>,
    /// Share of samples whose angle error, against the twist or else against the integral, lies
    /// within three of the standard deviations that the estimator claims.
    pub angle_within_3_sigma: Option<f64>,
}

/// Statistics of an error over time, in the unit that the field's name says.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ErrorStatistics {
    /// Root mean square.
    pub rms: f64,
    /// Root mean square over the second half of the run.
    pub rms_second_half: f64,
    /// Largest magnitude.
    pub max_abs: f64,
    /// Error at the end.
    pub end: f64,
}

impl Score {
    /// Scores every estimator of `record`.
    ///
    /// The starting angle of estimator and truth are both angles from equilibrium; where a record
    /// has no twist the integral of the body rate starts at zero.
    #[must_use]
    pub fn of(record: &Record) -> Self {
        let estimators = record.estimators().map(|name| score_one(record, name)).collect();
        Self { estimators }
    }
}

fn score_one(record: &Record, name: &str) -> EstimatorScore {
    let of = |quantity: &str| record.column(&format!("{name}.{quantity}"));
    let angle_error = |truth: &str| Some(errors(of("angle_rad")?, record.column(truth)?));
    let vs_twist = angle_error("truth.twist_rad");
    let vs_integral = angle_error("truth.body_rate_integral_rad");
    let rate_error = of("rate_rad_s")
        .zip(record.column("truth.body_rate_rad_s"))
        .map(|(estimate, truth)| errors(estimate, truth));
    let judged = vs_twist.as_ref().or(vs_integral.as_ref());
    let within = judged.zip(of("angle_sigma_rad")).and_then(|(e, sigma)| share_within(e, sigma));
    let statistics = |errors: &Option<Vec<f64>>| errors.as_deref().and_then(ErrorStatistics::of);
    EstimatorScore {
        name: name.to_owned(),
        angle_vs_twist_deg: statistics(&vs_twist),
        angle_vs_body_rate_integral_deg: statistics(&vs_integral),
        rate_vs_body_rate_deg_s: statistics(&rate_error),
        angle_within_3_sigma: within,
    }
}

fn errors(estimate_rad: &[f64], truth_rad: &[f64]) -> Vec<f64> {
    estimate_rad.iter().zip(truth_rad).map(|(e, t)| e - t).collect()
}

fn share_within(errors_rad: &[f64], sigma_rad: &[f64]) -> Option<f64> {
    if errors_rad.is_empty() {
        return None;
    }
    let inside = errors_rad.iter().zip(sigma_rad).filter(|(e, s)| e.abs() <= 3.0 * **s).count();
    Some(inside as f64 / errors_rad.len() as f64)
}

impl ErrorStatistics {
    /// Statistics in degrees of errors in radians; nothing for an empty record.
    fn of(errors_rad: &[f64]) -> Option<Self> {
        let end = errors_rad.last()? / RAD_PER_DEG;
        let max_rad = errors_rad.iter().fold(0.0, |max: f64, e| max.max(e.abs()));
        Some(Self {
            rms: rms(errors_rad) / RAD_PER_DEG,
            rms_second_half: rms(&errors_rad[errors_rad.len() / 2..]) / RAD_PER_DEG,
            max_abs: max_rad / RAD_PER_DEG,
            end,
        })
    }
}

fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
}

/// The table that commands print.
impl fmt::Display for Score {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.estimators.iter().map(|e| e.name.len()).max().unwrap_or(0).max(9);
        writeln!(
            f,
            "{:width$}  {:^21}  {:^21}  {:^21}  {:>7}",
            "", "angle - twist, deg", "angle - int(r), deg", "rate - r, deg/s", "within"
        )?;
        write!(f, "{:width$}", "estimator")?;
        for _ in 0..3 {
            write!(f, "  {:>10} {:>10}", "RMS", "max")?;
        }
        write!(f, "  {:>7}", "3 sigma")?;
        for estimator in &self.estimators {
            write!(f, "\n{:width$}", estimator.name)?;
            for statistics in [
                estimator.angle_vs_twist_deg,
                estimator.angle_vs_body_rate_integral_deg,
                estimator.rate_vs_body_rate_deg_s,
            ] {
                match statistics {
                    Some(s) => write!(f, "  {:>10.4} {:>10.4}", s.rms, s.max_abs)?,
                    None => write!(f, "  {:>21}", "no truth")?,
                }
            }
            match estimator.angle_within_3_sigma {
                Some(share) => write!(f, "  {:>5.1} %", share * 100.0)?,
                None => write!(f, "  {:>7}", "-")?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "equal signals differ by exactly zero")]
mod tests {
    use super::*;

    fn record(twist: bool) -> Record {
        let mut names = vec!["time", "truth.body_rate_integral_rad", "truth.body_rate_rad_s"];
        if twist {
            names.push("truth.twist_rad");
        }
        names.extend(["a.angle_rad", "a.rate_rad_s", "a.angle_sigma_rad"]);
        let mut record = Record::with_columns(names.into_iter().map(str::to_owned));
        for (k, error) in [3.0, -4.0, 0.0, 1.0].into_iter().enumerate() {
            let mut row = vec![k as f64, 1.0, 0.0];
            if twist {
                row.push(2.0);
            }
            row.extend([2.0 + error * RAD_PER_DEG, 0.0, 1.1 * RAD_PER_DEG]);
            record.push(&row);
        }
        record
    }

    #[test]
    fn statistics_are_those_of_the_error_in_degrees() {
        let score = Score::of(&record(true));
        let twist = score.estimators[0].angle_vs_twist_deg.unwrap();
        // Degrees to radians and back costs a few last bits.
        assert!((twist.rms - (26.0_f64 / 4.0).sqrt()).abs() < 1e-12);
        assert!((twist.rms_second_half - 0.5_f64.sqrt()).abs() < 1e-12);
        assert!((twist.max_abs - 4.0).abs() < 1e-12);
        assert!((twist.end - 1.0).abs() < 1e-12);
        assert_eq!(score.estimators[0].angle_within_3_sigma, Some(0.75));
        let rate = score.estimators[0].rate_vs_body_rate_deg_s.unwrap();
        assert_eq!(rate.max_abs, 0.0);
    }

    #[test]
    fn without_a_twist_the_score_says_so() {
        let score = Score::of(&record(false));
        assert_eq!(score.estimators[0].angle_vs_twist_deg, None);
        assert!(score.estimators[0].angle_vs_body_rate_integral_deg.is_some());
        assert!(score.to_string().contains("no truth"));
    }
}
