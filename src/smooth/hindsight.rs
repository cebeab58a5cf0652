//! What a record comes to by each method.

use super::error::SmoothingError;
use super::file::MeasuredRecord;
use crate::cli::{Smooth, SmoothMethod};
use struna_estimator::{
    AugmentedConfig, BatchEstimate, BatchFit, Belief, ConfigError, FitRefusal, FixedLag,
    InnovationTest, Kick, LearntParameters, RateEstimator, RateRecord, SmoothError, Status,
    Verdict, smooth,
};

/// A record in hindsight.
#[derive(Debug, Clone)]
pub struct Hindsight {
    /// `map`, `rts` or `fixed-lag`.
    pub method: &'static str,
    /// Why not another one.
    pub note: Option<String>,
    /// Belief at the time of each row.
    pub beliefs: Vec<Belief>,
    /// Period, damping and bias.
    pub learnt: LearntParameters,
    /// Kicks of the body.
    pub kicks: Vec<Kick>,
    /// How it may be trusted.
    pub learnt_by: Learnt,
}

/// What tells how far a hindsight may be trusted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Learnt {
    /// From the fit.
    Fit {
        /// Mean square of the residuals over R.
        chi_square_per_sample: f64,
        /// Largest mean residual over any window, as a share of what chance allows.
        residual_run: f64,
        /// Samples used.
        used: usize,
        /// Samples beyond the gate.
        rejected: usize,
        /// Samples over range.
        over_range: usize,
        /// Whether the fit believes itself.
        verdict: Verdict,
    },
    /// From the filter that ran ahead.
    Filter(Status),
}

/// Looks back over a record with the method asked for: or, where none is, with the fit if the
/// record is what it assumes, and else with the smoother.
///
/// # Errors
/// [`SmoothingError`] in the words of what refused.
pub fn look_back(
    args: &Smooth,
    config: &AugmentedConfig,
    record: &MeasuredRecord,
) -> Result<Hindsight, SmoothingError> {
    let samples = record.samples();
    let rates = RateRecord { start_time_s: record.start_s(), samples: &samples };
    let mut hindsight = match args.method {
        Some(SmoothMethod::Map) => fitted(args, config, &rates).map_err(refused(args))?,
        Some(SmoothMethod::Rts) => smoothed(config, &rates).map_err(unusable(args))?,
        Some(SmoothMethod::FixedLag) => lagged(args, config, record, &rates)?,
        None => either(args, config, &rates)?,
    };
    carry_to_rows(&mut hindsight, record);
    Ok(hindsight)
}

/// The fit where it accepts itself, else the smoother and the reason.
fn either(
    args: &Smooth,
    config: &AugmentedConfig,
    rates: &RateRecord<'_>,
) -> Result<Hindsight, SmoothingError> {
    let note = match fitted(args, config, rates) {
        Ok(fit) => match fit.learnt_by {
            Learnt::Fit { verdict: Verdict::Accepted, .. } | Learnt::Filter(_) => return Ok(fit),
            Learnt::Fit { verdict, .. } => in_words(&verdict),
        },
        Err(refusal @ (FitRefusal::Unusable(_) | FitRefusal::BadKick { .. })) => {
            return Err(refused(args)(refusal));
        }
        Err(refusal) => refusal.to_string(),
    };
    let smoothed = smoothed(config, rates).map_err(unusable(args))?;
    Ok(Hindsight { note: Some(format!("not map: {note}")), ..smoothed })
}

fn refused(args: &Smooth) -> impl Fn(FitRefusal) -> SmoothingError {
    |source| match source {
        FitRefusal::Unusable(source) => unusable(args)(source),
        source => SmoothingError::Refused { path: args.record.clone(), source },
    }
}

fn unusable(args: &Smooth) -> impl Fn(SmoothError) -> SmoothingError {
    |source| SmoothingError::Unusable { path: args.record.clone(), source }
}

/// What a verdict means to a reader.
#[must_use]
pub(super) fn in_words(verdict: &Verdict) -> String {
    match verdict {
        Verdict::Accepted => "the residuals are the gyro's noise".to_owned(),
        Verdict::AgainstStartBelief { quantity, sigmas } => {
            format!("the record contradicts the start belief: {quantity} off by {sigmas:.1} sigma")
        }
        _ => "the record holds more than damped torsion and the gyro's noise (random torque, a \
              thread that yields, swing): its claim is too small, trust rts"
            .to_owned(),
    }
}

fn fitted(
    args: &Smooth,
    config: &AugmentedConfig,
    rates: &RateRecord<'_>,
) -> Result<Hindsight, FitRefusal> {
    let fit = BatchFit::new(config, &InnovationTest::STANDARD)
        .map_err(|error| FitRefusal::Unusable(error.into()))?;
    let estimate = match &args.kicks_s {
        Some(kicks_s) => fit.fit_with_kicks(rates, kicks_s)?,
        None => fit.fit(rates)?,
    };
    let learnt_by = quality(&estimate);
    let BatchEstimate { beliefs, learnt, kicks, .. } = estimate;
    Ok(Hindsight { method: "map", note: None, beliefs, learnt, kicks, learnt_by })
}

fn quality(estimate: &BatchEstimate) -> Learnt {
    Learnt::Fit {
        chi_square_per_sample: estimate.chi_square_per_sample,
        residual_run: estimate.residual_run,
        used: estimate.used,
        rejected: estimate.rejected,
        over_range: estimate.over_range,
        verdict: estimate.verdict,
    }
}

fn smoothed(config: &AugmentedConfig, rates: &RateRecord<'_>) -> Result<Hindsight, SmoothError> {
    let smoothed = smooth(config, &InnovationTest::STANDARD, rates)?;
    Ok(Hindsight {
        method: "rts",
        note: None,
        beliefs: smoothed.beliefs().collect(),
        learnt: smoothed.learnt(),
        kicks: smoothed.kicks().to_vec(),
        learnt_by: Learnt::Filter(smoothed.status()),
    })
}

fn lagged(
    args: &Smooth,
    config: &AugmentedConfig,
    record: &MeasuredRecord,
    rates: &RateRecord<'_>,
) -> Result<Hindsight, SmoothingError> {
    let lag = lag_samples(args.lag_s, record.step_s())?;
    let belief = |source: ConfigError| SmoothingError::Belief { source };
    let mut running = FixedLag::new(config, &InnovationTest::STANDARD, lag).map_err(belief)?;
    let (mut beliefs, mut kicks) = (Vec::with_capacity(rates.samples.len()), Vec::new());
    let mut before_s = rates.start_time_s;
    for (index, sample) in rates.samples.iter().enumerate() {
        let (span_s, alarms) = (sample.time_s - before_s, running.filter().alarms());
        let step = if sample.over_range {
            running.step_over_range(span_s, sample.rate_rad_s)
        } else {
            running.step(span_s, sample.rate_rad_s)
        };
        let bad = |source| SmoothError::BadSample { index, time_s: sample.time_s, source };
        step.map_err(bad).map_err(unusable(args))?;
        before_s = sample.time_s;
        if let Some(alarm) = running.filter().last_alarm()
            && running.filter().alarms() > alarms
        {
            let (time_s, size_rad_s) = (sample.time_s, alarm.kick_rad_s);
            kicks.push(Kick { sample: index, time_s, size_rad_s, size_sigma_rad_s: f64::INFINITY });
        }
        // The first one is the start itself, which is no row.
        if index as u64 >= u64::from(lag) {
            beliefs.extend(running.lagged().map(|lagged| lagged.filter.belief()));
        }
    }
    beliefs.extend(running.tail());
    Ok(Hindsight {
        method: "fixed-lag",
        note: None,
        beliefs,
        learnt: running.filter().filter().learnt(),
        kicks,
        learnt_by: Learnt::Filter(running.filter().status()),
    })
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "judged before")]
fn lag_samples(lag_s: f64, step_s: f64) -> Result<u32, SmoothingError> {
    let (samples, most) = ((lag_s / step_s).round(), FixedLag::LAG_MAX_SAMPLES);
    if samples <= f64::from(most) {
        Ok(samples as u32)
    } else {
        Err(SmoothingError::LagTooLong { lag_s, samples, most })
    }
}

/// From the middle of each span, where its mean rate is, to its end, where the row is.
///
/// Half a step is short beside a period: two terms of the motion's series leave (Ω·h/2)³/6.
fn carry_to_rows(hindsight: &mut Hindsight, record: &MeasuredRecord) {
    let LearntParameters { period_s, damping_ratio, .. } = hindsight.learnt;
    let omega = std::f64::consts::TAU / period_s;
    for (belief, span_s) in hindsight.beliefs.iter_mut().zip(record.spans_s()) {
        let h = 0.5 * span_s;
        let acceleration =
            -omega * (omega * belief.angle_rad + 2.0 * damping_ratio * belief.rate_rad_s);
        belief.angle_rad += h * (belief.rate_rad_s + 0.5 * h * acceleration);
        belief.rate_rad_s += h * acceleration;
    }
}
