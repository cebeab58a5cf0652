//! One predict and update of the five-state filter, with and without its innovation test, beside
//! the limits set for them.
//!
//! No peer has this filter: a general one with five states spends several times as long on
//! matrices that are mostly identity. The two-state linear filter of kfilter gives the scale.

use crate::filters::{STEP_S, config, kfilter_of, measured_rates_rad_s, run_kfilter};
use crate::table::{Row, ns};
use crate::timing::{best_in_turns, time_per_unit};
use anyhow::Result;
use std::f64::consts::TAU;
use std::hint::black_box;
use struna_estimator::{
    AugmentedConfig, AugmentedFilter, InnovationTest, RateEstimator, Refinement, StartPrior,
    TestedFilter,
};

/// What the filter may take by itself, s.
const ALONE_LIMIT_S: f64 = 30e-9;
/// What it may take with gate, windows and the store for roll-backs, s.
const TESTED_LIMIT_S: f64 = 60e-9;

pub(crate) fn rows() -> Result<Vec<Row>> {
    let rates_rad_s = measured_rates_rad_s();
    let two_states = config(Refinement::OFF);
    let start = StartPrior::released(TAU, crate::filters::PERIOD_S);
    let model = AugmentedConfig::quiet(start, two_states.measurement_variance_rad2_s2);
    let mut alone = AugmentedFilter::new(&model)?;
    let mut tested = TestedFilter::new(&model, &InnovationTest::STANDARD)?;
    let mut peer = kfilter_of(&two_states)?;
    let [alone_s, tested_s, peer_s] = best_in_turns([
        Box::new(|| {
            alone = AugmentedFilter::new(&model)?;
            time_per_unit(rates_rad_s.len(), || run(&mut alone, &rates_rad_s))
        }),
        Box::new(|| {
            tested = TestedFilter::new(&model, &InnovationTest::STANDARD)?;
            // The windows are all in use after 2048 samples.
            run(&mut tested, &rates_rad_s)?;
            run(&mut tested, &rates_rad_s)?;
            run(&mut tested, &rates_rad_s)?;
            time_per_unit(rates_rad_s.len(), || run(&mut tested, &rates_rad_s))
        }),
        Box::new(|| time_per_unit(rates_rad_s.len(), || run_kfilter(&mut peer, &rates_rad_s))),
    ])?;
    let row = |what: &str, ours_s: f64, other: String, other_s: f64, target| Row {
        what: format!("five states, predict + update, {what}"),
        ours: ns(ours_s),
        other,
        ratio: Some(other_s / ours_s),
        target,
    };
    let limit = |limit_s: f64| format!("{} (limit)", ns(limit_s));
    Ok(vec![
        row("alone", alone_s, limit(ALONE_LIMIT_S), ALONE_LIMIT_S, 1.0),
        row("with innovation test", tested_s, limit(TESTED_LIMIT_S), TESTED_LIMIT_S, 1.0),
        row("alone", alone_s, format!("{} (kfilter, two states)", ns(peer_s)), peer_s, 0.5),
    ])
}

/// Out of line, so that every caller times the same machine code.
#[inline(never)]
fn run(filter: &mut impl RateEstimator, rates_rad_s: &[f64]) -> Result<()> {
    for &rate_rad_s in rates_rad_s {
        // Through memory, as in a program that does something else between two measurements.
        let (filter, rate_rad_s) = black_box((&mut *filter, rate_rad_s));
        filter.predict(STEP_S)?;
        black_box(filter.update(rate_rad_s)?);
    }
    Ok(())
}
