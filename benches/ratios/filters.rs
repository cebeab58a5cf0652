//! One predict and update of the two-state filter, beside kfilter with the same model.
//!
//! Measurements change from call to call, and each call starts from the result of the one before:
//! what counts is the length of that chain.

use crate::table::{Row, ns};
use crate::timing::{best_in_turns, time_per_unit};
use anyhow::{Result, anyhow, ensure};
use kfilter::kalman::{Kalman1MLinearNoInput, KalmanFilter, KalmanPredict};
use std::f64::consts::TAU;
use std::hint::black_box;
use struna_estimator::{
    Filter, FilterConfig, Motion, RateEstimator, Reading, Refinement, TorsionalOscillation,
};
use struna_kernel::RAD_PER_DEG;

pub(crate) const PERIOD_S: f64 = 480.0;
pub(crate) const STEP_S: f64 = 0.01;
/// What the target of 12 ns was where kfilter takes 22.6 ns.
const TARGET_RATIO: f64 = 22.6 / 12.0;

/// The 2008 rig's gyro and start, with a little process noise so that the peer's Q does work.
pub(crate) const fn config(refinement: Refinement) -> FilterConfig {
    const DEG2: f64 = RAD_PER_DEG * RAD_PER_DEG;
    FilterConfig {
        angle_start_rad: TAU,
        rate_start_rad_s: 0.0,
        angle_variance_start_rad2: DEG2,
        rate_variance_start_rad2_s2: DEG2,
        measurement_variance_rad2_s2: 2e-3 * DEG2,
        process_noise_rad2_s3: 1e-6 * DEG2,
        refinement,
    }
}

/// Ten seconds of measured rates.
pub(crate) fn measured_rates_rad_s() -> Vec<f64> {
    (1..=1000).map(measured_rate_rad_s).collect()
}

/// A measured rate: the torsion from one turn, and noise of the gyro's size.
pub(crate) fn measured_rate_rad_s(k: u32) -> f64 {
    let omega_rad_s = TAU / PERIOD_S;
    let noise = (f64::from(k) * 0.618_033_988_749_895).fract() - 0.5;
    let phase = omega_rad_s * STEP_S * f64::from(k);
    -TAU * omega_rad_s * phase.sin() + 0.15 * RAD_PER_DEG * noise
}

pub(crate) fn rows() -> Result<Vec<Row>> {
    let m6 = Refinement { samples: 100, reading: Reading::M6 };
    let [plain, refined, peer_s] = race(Refinement::OFF, m6)?;
    let row = |what: &str, ours_s: f64, target| Row {
        what: format!("predict + update, {what}"),
        ours: ns(ours_s),
        other: format!("{} (kfilter)", ns(peer_s)),
        ratio: Some(peer_s / ours_s),
        target,
    };
    Ok(vec![
        row("refinement off, first target", plain, 1.5),
        row("refinement off, 12 ns on 22.6 ns", plain, TARGET_RATIO),
        row("refinement M6 N=100", refined, 1.5),
    ])
}

/// Best times of our filter under both refinements and of kfilter, s per predict and update.
fn race(first: Refinement, second: Refinement) -> Result<[f64; 3]> {
    let rates_rad_s = measured_rates_rad_s();
    let mut ours = Filter::torsional_oscillation(config(first), PERIOD_S)?;
    let mut refined = Filter::torsional_oscillation(config(second), PERIOD_S)?;
    let mut peer = kfilter_of(&config(first))?;
    run(&mut ours, &rates_rad_s)?;
    run_kfilter(&mut peer, &rates_rad_s)?;
    same_estimate(&ours, &peer)?;
    best_in_turns([
        Box::new(|| time_per_unit(rates_rad_s.len(), || run(&mut ours, &rates_rad_s))),
        Box::new(|| time_per_unit(rates_rad_s.len(), || run(&mut refined, &rates_rad_s))),
        Box::new(|| time_per_unit(rates_rad_s.len(), || run_kfilter(&mut peer, &rates_rad_s))),
    ])
}

/// Out of line, so that every caller times the same machine code.
#[inline(never)]
pub(crate) fn run<M: Motion>(filter: &mut Filter<M>, rates_rad_s: &[f64]) -> Result<()> {
    for &rate_rad_s in rates_rad_s {
        // Through memory, as in a program that does something else between two measurements.
        let (filter, rate_rad_s) = black_box((&mut *filter, rate_rad_s));
        filter.predict(STEP_S)?;
        black_box(filter.update(rate_rad_s)?);
    }
    Ok(())
}

pub(crate) type Peer = Kalman1MLinearNoInput<f64, 2, 1>;

/// kfilter with the same transition, process noise, measurement and start.
pub(crate) fn kfilter_of(config: &FilterConfig) -> Result<Peer> {
    let t = TorsionalOscillation::with_period(PERIOD_S)?.transition(STEP_S);
    let q = config.process_noise_rad2_s3;
    let mut peer = Peer::new(
        [[t.f11, t.f21], [t.f12, t.f22]].into(), // by columns
        [[q * t.q11, q * t.q12], [q * t.q12, q * t.q22]].into(),
        [[0.0], [1.0]].into(),
        [[config.measurement_variance_rad2_s2]].into(),
        [[config.angle_start_rad, config.rate_start_rad_s]].into(),
    );
    *peer.covariance_mut() =
        [[config.angle_variance_start_rad2, 0.0], [0.0, config.rate_variance_start_rad2_s2]].into();
    Ok(peer)
}

#[inline(never)]
pub(crate) fn run_kfilter(peer: &mut Peer, rates_rad_s: &[f64]) -> Result<()> {
    let refused = |reason| anyhow!("kfilter refuses a call: {reason:?}");
    for &rate_rad_s in rates_rad_s {
        let (peer, rate_rad_s) = black_box((&mut *peer, rate_rad_s));
        peer.predict().map_err(refused)?;
        black_box(peer.update([[rate_rad_s]].into()).map_err(refused)?);
    }
    Ok(())
}

/// A ratio of two programs that compute different things would say nothing.
fn same_estimate(ours: &Filter<TorsionalOscillation>, peer: &Peer) -> Result<()> {
    let (belief, state) = (ours.belief(), peer.state());
    let angle_off_rad = (belief.angle_rad - state[0]).abs();
    let rate_off_rad_s = (belief.rate_rad_s - state[1]).abs();
    ensure!(
        // A dozen roundings in each of 1000 steps at 6 rad, were they all in one direction.
        angle_off_rad < 1e-11 && rate_off_rad_s < 1e-11,
        "our filter and kfilter disagree by {angle_off_rad:e} rad and {rate_off_rad_s:e} rad/s"
    );
    Ok(())
}
