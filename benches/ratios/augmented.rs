//! One predict and update of the five-state filter, with and without its innovation test.
//!
//! No peer has this filter: a general one with five states spends several times as long on
//! matrices that are mostly identity. The two-state linear filter of kfilter gives the scale, as
//! limits in nanoseconds mean nothing on another machine.

use crate::filters::{PERIOD_S, STEP_S, config, kfilter_of, measured_rate_rad_s, run_kfilter};
use crate::table::{Row, ns};
use crate::timing::{best_in_turns, time_per_unit};
use anyhow::{Result, ensure};
use std::f64::consts::TAU;
use std::hint::black_box;
use struna_estimator::{
    AugmentedConfig, AugmentedFilter, InnovationTest, RateEstimator, Refinement, StartPrior,
    TestedFilter,
};

/// What the limit of 30 ns was where kfilter takes 22.6 ns.
const ALONE_RATIO: f64 = 22.6 / 30.0;
/// What the limit of 60 ns was, with gate, windows and the store for roll-backs.
const TESTED_RATIO: f64 = 22.6 / 60.0;

pub(crate) fn rows() -> Result<Vec<Row>> {
    let rates_rad_s: Vec<_> = (1..=4000).map(measured_rate_rad_s).collect();
    // Half a minute in, all windows are in use.
    let (warm_up, timed) = rates_rad_s.split_at(3000);
    let two_states = config(Refinement::OFF);
    let start = StartPrior::released(TAU, PERIOD_S);
    let model = AugmentedConfig::quiet(start, two_states.measurement_variance_rad2_s2);
    let mut peer = kfilter_of(&two_states)?;
    let [alone_s, tested_s, peer_s] = best_in_turns([
        Box::new(|| {
            let mut alone = AugmentedFilter::new(&model)?;
            run(&mut alone, warm_up)?;
            time_per_unit(timed.len(), || run(&mut alone, timed))
        }),
        Box::new(|| {
            let mut tested = TestedFilter::new(&model, &InnovationTest::STANDARD)?;
            run(&mut tested, warm_up)?;
            ensure!(tested.alarms() == 0, "an alarm where nothing struck");
            time_per_unit(timed.len(), || run(&mut tested, timed))
        }),
        Box::new(|| time_per_unit(timed.len(), || run_kfilter(&mut peer, timed))),
    ])?;
    let row = |what: &str, ours_s: f64, target| Row {
        what: format!("five states, predict + update, {what}"),
        ours: ns(ours_s),
        other: format!("{} (kfilter, two states)", ns(peer_s)),
        ratio: Some(peer_s / ours_s),
        target,
    };
    Ok(vec![
        row("30 ns on 22.6 ns", alone_s, ALONE_RATIO),
        row("innovation test, 60 ns on 22.6 ns", tested_s, TESTED_RATIO),
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
