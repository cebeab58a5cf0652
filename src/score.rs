//! How far each estimator was from the truth. Reads the record and nothing else.

use crate::record::{Record, TRUE_BODY_RATE, TRUE_TWIST_RATE};
use serde::{Serialize, Serializer};
use std::fmt;
use struna_kernel::{RAD_PER_DEG, RateOf};

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
    /// What the estimator's rate is the rate of, and so which of the two rate errors that follow
    /// is its own; none where the record says what this program does not know.
    #[serde(serialize_with = "in_words")]
    pub rate_of: Option<RateOf>,
    /// Rate against the body rate.
    pub rate_vs_body_rate_deg_s: Option<ErrorStatistics>,
    /// Rate against that of the twist.
    pub rate_vs_twist_rate_deg_s: Option<ErrorStatistics>,
    /// Share of samples whose angle error, against the twist or else against the integral, lies
    /// within three of the standard deviations that the estimator claims.
    pub angle_within_3_sigma: Option<f64>,
}

fn in_words<S: Serializer>(rate: &Option<RateOf>, to: S) -> Result<S::Ok, S::Error> {
    rate.map(RateOf::words).serialize(to)
}

impl EstimatorScore {
    /// Error of the rate against the truth of what it is the rate of, and that truth. The body's
    /// rate stands for that of the twist where the record knows of no twist.
    #[must_use]
    pub fn rate_deg_s(&self) -> Option<(RateOf, ErrorStatistics)> {
        let body_axis = || Some((RateOf::BodyAxis, self.rate_vs_body_rate_deg_s?));
        match self.rate_of? {
            RateOf::BodyAxis => body_axis(),
            RateOf::Twist => match self.rate_vs_twist_rate_deg_s {
                Some(statistics) => Some((RateOf::Twist, statistics)),
                None => body_axis(),
            },
        }
    }
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
    let error = |of_what: &str, truth: &str| Some(errors(of(of_what)?, record.column(truth)?));
    let vs_twist = error("angle_rad", "truth.twist_rad");
    let vs_integral = error("angle_rad", "truth.body_rate_integral_rad");
    let judged = vs_twist.as_ref().or(vs_integral.as_ref());
    let within = judged.zip(of("angle_sigma_rad")).and_then(|(e, sigma)| share_within(e, sigma));
    let statistics = |errors: &Option<Vec<f64>>| errors.as_deref().and_then(ErrorStatistics::of);
    EstimatorScore {
        name: name.to_owned(),
        angle_vs_twist_deg: statistics(&vs_twist),
        angle_vs_body_rate_integral_deg: statistics(&vs_integral),
        rate_of: record.rate_of(name),
        rate_vs_body_rate_deg_s: statistics(&error("rate_rad_s", TRUE_BODY_RATE)),
        rate_vs_twist_rate_deg_s: statistics(&error("rate_rad_s", TRUE_TWIST_RATE)),
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

/// Root mean square and largest magnitude, in columns.
fn pair(f: &mut fmt::Formatter<'_>, statistics: Option<ErrorStatistics>) -> fmt::Result {
    match statistics {
        Some(s) => write!(f, "  {:>10.4} {:>10.4}", s.rms, s.max_abs),
        None => write!(f, "  {:>21}", "no truth"),
    }
}

/// The table that commands print.
impl fmt::Display for Score {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.estimators.iter().map(|e| e.name.len()).max().unwrap_or(0).max(9);
        writeln!(
            f,
            "{:width$}  {:^21}  {:^21}  {:>7}  {:^32}",
            "", "angle - twist, deg", "angle - int(r), deg", "within", "rate - true rate, deg/s"
        )?;
        write!(f, "{:width$}", "estimator")?;
        for _ in 0..2 {
            write!(f, "  {:>10} {:>10}", "RMS", "max")?;
        }
        write!(f, "  {:>7}  {:>10} {:>10} {:>10}", "3 sigma", "RMS", "max", "of")?;
        for estimator in &self.estimators {
            write!(f, "\n{:width$}", estimator.name)?;
            pair(f, estimator.angle_vs_twist_deg)?;
            pair(f, estimator.angle_vs_body_rate_integral_deg)?;
            match estimator.angle_within_3_sigma {
                Some(share) => write!(f, "  {:>5.1} %", share * 100.0)?,
                None => write!(f, "  {:>7}", "-")?,
            }
            let (rate_of, rate) = estimator.rate_deg_s().unzip();
            pair(f, rate)?;
            write!(f, " {:>10}", rate_of.map_or("", RateOf::words))?;
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

    /// A record of one estimator whose rate is 2 °/s off the body's and 1 °/s off the twist's, and
    /// that says of its rate what `rate_of` says; `twist` puts the twist's rate into it.
    fn rates(rate_of: Option<f64>, twist: bool) -> Record {
        let mut columns = vec![("time", 0.0), ("a.angle_rad", 0.0), ("a.rate_rad_s", RAD_PER_DEG)];
        columns.push((TRUE_BODY_RATE, -RAD_PER_DEG));
        columns.extend(twist.then_some((TRUE_TWIST_RATE, 0.0)));
        columns.extend(rate_of.map(|number| ("a.rate_of", number)));
        let (names, row): (Vec<_>, Vec<_>) = columns.into_iter().unzip();
        let mut record = Record::with_columns(names.into_iter().map(str::to_owned));
        record.push(&row);
        record
    }

    #[test]
    fn a_rate_is_judged_by_the_true_one_that_it_tells() {
        let judged = |rate_of, twist| {
            let score = Score::of(&rates(rate_of, twist));
            let rate = score.estimators[0].rate_deg_s();
            (rate.map(|(of, error)| (of, error.rms.round())), score.to_string())
        };
        let (body_axis, twist) = (Some((RateOf::BodyAxis, 2.0)), Some((RateOf::Twist, 1.0)));
        for (rate_of, expected) in [(Some(0.0), body_axis), (Some(1.0), twist), (None, body_axis)] {
            let (rate, table) = judged(rate_of, true);
            assert_eq!(rate, expected, "{rate_of:?}");
            let words = expected.map_or("", |(of, _)| of.words());
            assert!(table.trim_end().ends_with(words), "{table}");
        }
        // A recording: the body's rate is all that there is, and the table says which it took.
        assert_eq!(judged(Some(1.0), false).0, body_axis);
        assert!(judged(Some(1.0), false).1.ends_with("body axis"));
        // A number of another program's is judged by neither.
        for stranger in [2.0, 0.5, f64::NAN] {
            assert_eq!(judged(Some(stranger), true).0, None, "{stranger}");
        }
    }

    #[test]
    fn score_files_hold_both_rate_errors_and_which_one_is_the_estimators() {
        let score = Score::of(&rates(Some(1.0), true));
        let json = serde_json::to_value(&score.estimators[0]).unwrap();
        assert_eq!(json["rate_of"], "twist");
        let rms = |key: &str| json[key]["rms"].as_f64().map(f64::round);
        assert_eq!(rms("rate_vs_body_rate_deg_s"), Some(2.0));
        assert_eq!(rms("rate_vs_twist_rate_deg_s"), Some(1.0));
    }

    #[test]
    fn without_a_twist_the_score_says_so() {
        let score = Score::of(&record(false));
        assert_eq!(score.estimators[0].angle_vs_twist_deg, None);
        assert!(score.estimators[0].angle_vs_body_rate_integral_deg.is_some());
        assert!(score.to_string().contains("no truth"));
    }
}
