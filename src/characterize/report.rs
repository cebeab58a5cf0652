//! What was found, for other programs; docs/characterize.md explains each key.

use super::Characterized;
use super::unit::{DEG_H, of_term, on_data_sheet};
use serde::Serialize;
use std::collections::BTreeMap;
use struna_gyro::characterise::{AllanPoint, LabStatistic, NoiseModel, Term, Verdict};
use struna_kernel::RAD_PER_DEG;

/// The content of the JSON file.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    schema: &'static str,
    program_version: &'static str,
    name: String,
    source: String,
    rate_column: String,
    sample_rate_hz: f64,
    samples: usize,
    lost_samples: u64,
    gaps: usize,
    duration_s: f64,
    longest_stretch_s: f64,
    mean_rate_deg_h: f64,
    bandwidth_hz: Option<f64>,
    confidence: f64,
    taus_s: Vec<f64>,
    adev_deg_h: Vec<f64>,
    ci_low_deg_h: Vec<f64>,
    ci_high_deg_h: Vec<f64>,
    hdev_deg_h: Vec<Option<f64>>,
    edf: Vec<f64>,
    noise: Vec<&'static str>,
    trusted: Vec<bool>,
    filtered: Vec<bool>,
    coefficients: BTreeMap<&'static str, Coefficient>,
    fit: Fit,
    overbound: Option<BTreeMap<&'static str, f64>>,
    lab2008: Laboratory,
}

#[derive(Debug, Clone, Serialize)]
struct Coefficient {
    verdict: &'static str,
    value: Option<f64>,
    ci_low: Option<f64>,
    ci_high: Option<f64>,
    at_most: Option<f64>,
    reason: Option<String>,
}

#[derive(Debug, Clone, Serialize)]
struct Fit {
    terms: String,
    misfit: f64,
    aicc: f64,
    bic: f64,
    adev_over_hdev: Option<f64>,
}

#[derive(Debug, Clone, Serialize)]
struct Laboratory {
    single: Option<Statistic>,
    averaged: Option<Statistic>,
}

#[derive(Debug, Clone, Serialize)]
struct Statistic {
    averaging: usize,
    averages: usize,
    half_range_deg_s: f64,
    printed_sigma2_deg2_s2: f64,
    bias_factor: f64,
    debiased_sigma_deg_s: f64,
    sigma_deg_s: f64,
    white_sigma_deg_s: f64,
    variance_over_white: f64,
    lag1_correlation: Option<f64>,
}

impl Report {
    /// Puts together what was found.
    #[must_use]
    pub fn new(of: &Characterized) -> Self {
        let (record, found) = (&of.record, &of.found);
        let column = |value: fn(&AllanPoint) -> f64| found.points.iter().map(value).collect();
        let flags = |flag: fn(&AllanPoint) -> bool| found.points.iter().map(flag).collect();
        let verdicts = Term::ALL.iter().map(|term| (of_term(*term).1, coefficient(of, *term)));
        let [single, averaged] = found.laboratory.map(|lab| lab.as_ref().map(statistic));
        Self {
            schema: "struna.characterize/1",
            program_version: env!("CARGO_PKG_VERSION"),
            name: of.name.clone(),
            source: of.source.clone(),
            rate_column: of.rate_column.clone(),
            sample_rate_hz: record.sample_rate_hz(),
            samples: record.rates_rad_s().len(),
            lost_samples: record.lost(),
            gaps: record.stretches().len() - 1,
            duration_s: record.duration_s(),
            longest_stretch_s: record.longest_stretch() as f64 / record.sample_rate_hz(),
            mean_rate_deg_h: record.mean_rad_s() / DEG_H,
            bandwidth_hz: of.options.bandwidth_hz,
            confidence: of.options.confidence,
            taus_s: column(|point| point.tau_s),
            adev_deg_h: column(|point| point.adev_rad_s / DEG_H),
            ci_low_deg_h: column(|point| point.interval_rad_s[0] / DEG_H),
            ci_high_deg_h: column(|point| point.interval_rad_s[1] / DEG_H),
            hdev_deg_h: found.points.iter().map(|p| p.hdev_rad_s.map(|h| h / DEG_H)).collect(),
            edf: column(|point| point.edf),
            noise: found.points.iter().map(|point| point.noise.name()).collect(),
            trusted: flags(|point| point.trusted),
            filtered: flags(|point| point.filtered),
            coefficients: verdicts.collect(),
            fit: fit(of),
            overbound: found.overbound.as_ref().map(overbound),
            lab2008: Laboratory { single, averaged },
        }
    }
}

fn coefficient(of: &Characterized, term: Term) -> Coefficient {
    let unit = |value| on_data_sheet(term, value);
    let silent = Coefficient {
        verdict: "",
        value: None,
        ci_low: None,
        ci_high: None,
        at_most: None,
        reason: None,
    };
    match of.found.verdict(term) {
        Verdict::Estimated { value, interval: [low, high] } => Coefficient {
            verdict: "estimated",
            value: Some(unit(value)),
            ci_low: Some(unit(low)),
            ci_high: Some(unit(high)),
            ..silent
        },
        Verdict::AtMost { bound, reason } => Coefficient {
            verdict: "at most",
            at_most: Some(unit(bound)),
            reason: Some(reason.to_string()),
            ..silent
        },
        Verdict::Refused { reason } => {
            Coefficient { verdict: "refused", reason: Some(reason.to_string()), ..silent }
        }
    }
}

fn fit(of: &Characterized) -> Fit {
    let found = &of.found;
    let terms = Term::ALL.iter().filter(|term| found.model.has(**term));
    let [aicc, bic] = found.criteria;
    Fit {
        terms: terms.map(|term| term.symbol()).collect(),
        misfit: found.misfit,
        aicc,
        bic,
        adev_over_hdev: found.drift_ratio,
    }
}

fn overbound(model: &NoiseModel) -> BTreeMap<&'static str, f64> {
    let terms = [Term::AngleRandomWalk, Term::BiasInstability, Term::RateRandomWalk];
    let value = |term| (of_term(term).1, on_data_sheet(term, model.coefficient(term)));
    terms.map(value).into()
}

fn statistic(lab: &LabStatistic) -> Statistic {
    Statistic {
        averaging: lab.averaging,
        averages: lab.averages,
        half_range_deg_s: lab.half_range_rad_s / RAD_PER_DEG,
        printed_sigma2_deg2_s2: lab.printed_variance() / RAD_PER_DEG.powi(2),
        bias_factor: lab.bias_factor,
        debiased_sigma_deg_s: lab.debiased_sigma_rad_s() / RAD_PER_DEG,
        sigma_deg_s: lab.sigma_rad_s / RAD_PER_DEG,
        white_sigma_deg_s: lab.white_sigma_rad_s / RAD_PER_DEG,
        variance_over_white: lab.excess_over_white(),
        lag1_correlation: lab.lag1_correlation,
    }
}
