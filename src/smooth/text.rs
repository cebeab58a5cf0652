//! What a hindsight writes: a record of its own, and a report for people.

use super::belief::StartBelief;
use super::file::MeasuredRecord;
use super::hindsight::{Hindsight, Learnt, in_words};
use crate::record::Record;
use crate::score::Score;
use std::fmt::{self, Write};
use struna_estimator::{Belief, Kick, Status};
use struna_kernel::RAD_PER_DEG;

/// Kicks that are listed; the rest is counted.
const KICKS_LISTED: usize = 20;
/// Signals of a hindsight: it has no innovations, and one status for all of the record.
const SIGNALS: [&str; 5] =
    ["angle_rad", "rate_rad_s", "angle_sigma_rad", "rate_sigma_rad_s", "residual_rad_s"];

/// The record in hindsight: what was measured and what is true as they were, and the method as an
/// estimator.
#[must_use]
pub fn record(measured: &MeasuredRecord, hindsight: &Hindsight) -> Record {
    let method = hindsight.method;
    let fixed = ["time", "measured_rate_rad_s", "over_range"].map(str::to_owned);
    let truth = measured.truth.iter().map(|(name, _)| name.clone());
    let signals = SIGNALS.map(|signal| format!("{method}.{signal}"));
    let mut record = Record::with_columns(fixed.into_iter().chain(truth).chain(signals));
    let half_spans_s = measured.spans_s().map(|span_s| 0.5 * span_s);
    for ((k, belief), half_s) in hindsight.beliefs.iter().enumerate().zip(half_spans_s) {
        let rate_rad_s = measured.rate_rad_s[k];
        let mut row = vec![measured.time_s[k], rate_rad_s];
        row.push(f64::from(u8::from(measured.over_range[k])));
        row.extend(measured.truth.iter().map(|(_, values)| values[k]));
        let Belief { angle_rad, rate_rad_s: believed_rad_s, covariance } = *belief;
        row.extend([angle_rad, believed_rad_s]);
        row.extend([covariance.angle_rad2, covariance.rate_rad2_s2].map(|v| v.max(0.0).sqrt()));
        let middle_rad_s = believed_rad_s - half_s * acceleration_rad_s2(hindsight, belief);
        row.push(rate_rad_s - middle_rad_s - hindsight.learnt.bias_rad_s);
        record.push(&row);
    }
    record
}

/// φ″ of damped torsion.
fn acceleration_rad_s2(hindsight: &Hindsight, belief: &Belief) -> f64 {
    let omega = std::f64::consts::TAU / hindsight.learnt.period_s;
    let damping = 2.0 * hindsight.learnt.damping_ratio * belief.rate_rad_s;
    -omega * (omega * belief.angle_rad + damping)
}

/// The report of a hindsight.
#[derive(Debug)]
pub struct Report<'a> {
    /// Where the record lies.
    pub file: String,
    /// The record.
    pub measured: &'a MeasuredRecord,
    /// The belief at its start.
    pub belief: &'a StartBelief,
    /// What came of it.
    pub hindsight: &'a Hindsight,
    /// How far from the truth, where the record holds it.
    pub score: Option<&'a Score>,
}

fn deg(rad: f64) -> f64 {
    rad / RAD_PER_DEG
}

impl fmt::Display for Report<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { measured, hindsight, .. } = self;
        let over_range = measured.over_range.iter().filter(|flag| **flag).count();
        let last_s = measured.time_s.last().copied().unwrap_or_default();
        writeln!(
            f,
            "record   {}: {} rows to {last_s} s, {over_range} over range",
            self.file,
            measured.time_s.len()
        )?;
        let noise_deg_s = deg(self.belief.config.measurement_variance_rad2_s2.sqrt());
        writeln!(f, "noise    {noise_deg_s:.5} deg/s of one rate, {}", self.belief.noise_from)?;
        writeln!(f, "method   {}", hindsight.method)?;
        if let Some(note) = &hindsight.note {
            writeln!(f, "         {note}")?;
        }
        writeln!(f, "trust    {}", trust(hindsight))?;
        let learnt = &hindsight.learnt;
        writeln!(f, "period   {:.5} +- {:.5} s", learnt.period_s, learnt.period_sigma_s)?;
        let (ratio, sigma) = (learnt.damping_ratio, learnt.damping_ratio_sigma);
        writeln!(f, "damping  {ratio:.6} +- {sigma:.6}")?;
        let (bias, sigma) = (deg(learnt.bias_rad_s), deg(learnt.bias_sigma_rad_s));
        writeln!(f, "bias     {bias:.6} +- {sigma:.6} deg/s")?;
        let ends = [("first", hindsight.beliefs.first()), ("last", hindsight.beliefs.last())];
        for (name, belief) in ends {
            let Some(belief) = belief else { continue };
            let sigma_rad = belief.covariance.angle_rad2.max(0.0).sqrt();
            let (angle, sigma) = (deg(belief.angle_rad), deg(sigma_rad));
            writeln!(f, "angle    {angle:.4} +- {sigma:.4} deg at the {name} row")?;
        }
        write!(f, "{}", kicks(&hindsight.kicks))?;
        if let Some(score) = self.score {
            write!(f, "\n{score}\n")?;
        }
        Ok(())
    }
}

/// How far a hindsight may be trusted, in words.
fn trust(hindsight: &Hindsight) -> String {
    match &hindsight.learnt_by {
        Learnt::Fit { chi_square_per_sample, residual_run, used, rejected, verdict, .. } => {
            let words = in_words(verdict);
            format!(
                "{words}; chi-square {chi_square_per_sample:.4} a sample, longest run {:.0} % of \
                 what chance allows, {used} used, {rejected} rejected",
                100.0 * residual_run
            )
        }
        Learnt::Filter(status) => match status {
            Status::Nominal => "the innovations are quiet: the claimed sigma holds".to_owned(),
            Status::Disturbed { .. } => {
                "disturbed shortly before the end; angle and sigma have been repaired".to_owned()
            }
            Status::ModelDoubtful => "too many alarms in half a period: the body does not move as \
                                      assumed; the claimed sigma is a bound at best"
                .to_owned(),
            _ => "the angle cannot be told from this record".to_owned(),
        },
    }
}

fn kicks(kicks: &[Kick]) -> String {
    let mut text = String::new();
    for kick in kicks.iter().take(KICKS_LISTED) {
        let size = deg(kick.size_rad_s);
        let sigma = if kick.size_sigma_rad_s.is_finite() {
            format!(" +- {:.4}", deg(kick.size_sigma_rad_s))
        } else {
            String::new()
        };
        let _ = writeln!(text, "kick     {size:.4}{sigma} deg/s at {:.3} s", kick.time_s);
    }
    if kicks.len() > KICKS_LISTED {
        let _ = writeln!(text, "         and {} more", kicks.len() - KICKS_LISTED);
    }
    text
}
