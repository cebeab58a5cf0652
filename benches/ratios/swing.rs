//! What following a swinging body on one gyro axis costs: one sample of the filter, and the fit
//! that starts it, on 60 s of a swing of 5°. No peer has either. Beside them the bank of five
//! filters for a thread that yields, on the rates of the other benches.
//!
//! Limits in seconds mean nothing on another machine, so kfilter's step is timed in turn and gives
//! the scale: it took 22.6 ns where the limits were stated.

use crate::filters::{PERIOD_S, STEP_S, config, kfilter_of, measured_rate_rad_s, run_kfilter};
use crate::table::{Row, ns};
use crate::timing::{best_in_turns, time_per_unit};
use anyhow::{Result, anyhow, ensure};
use std::f64::consts::TAU;
use std::hint::black_box;
use struna_estimator::{
    AcceptedFit, AugmentedConfig, ExpectedRate, HysteresisBank, InnovationTest, InputAxis,
    MotionParameters, MotionState, RateEstimator, Refinement, StartPrior, SwingBody, SwingConfig,
    SwingFilter, SwingFit, SwingMotion,
};
use struna_kernel::{AddressedRandom, Channel, RAD_PER_DEG, Seed};

const KFILTER_THERE_S: f64 = 22.6e-9;
const STEP_LIMIT_S: f64 = 3e-6;
const FIT_LIMIT_S: f64 = 0.5;
/// Period of the torsion, half of which a fit takes in, s.
const SWING_PERIOD_S: f64 = 120.0;
const R_RAD2_S2: f64 = 2e-3 * RAD_PER_DEG * RAD_PER_DEG;

pub(crate) fn rows() -> Result<Vec<Row>> {
    let config_of_swing = swing_config();
    let rates_rad_s = swinging_rates_rad_s(&config_of_swing)?;
    let fit = fitted(&config_of_swing, &rates_rad_s)?;
    let timed = &rates_rad_s[usize::try_from(fit.samples)?..][..2000];
    let two_states = config(Refinement::OFF);
    let mut peer = kfilter_of(&two_states)?;
    let calm: Vec<_> = (1..=2000).map(measured_rate_rad_s).collect();
    let start = StartPrior::released(TAU, PERIOD_S);
    let torsion = AugmentedConfig::quiet(start, two_states.measurement_variance_rad2_s2);
    let [fit_s, step_s, bank_s, peer_s] = best_in_turns([
        Box::new(|| time_per_unit(1, || fitted(&config_of_swing, &rates_rad_s).map(drop))),
        Box::new(|| {
            let test = InnovationTest::STANDARD;
            let mut filter = SwingFilter::new(&config_of_swing, &test, &fit.belief)?;
            time_per_unit(timed.len(), || run(&mut filter, timed))
        }),
        Box::new(|| {
            let mut bank = HysteresisBank::new(&torsion)?;
            time_per_unit(calm.len(), || run(&mut bank, &calm))
        }),
        Box::new(|| time_per_unit(calm.len(), || run_kfilter(&mut peer, &calm))),
    ])?;
    let scale = peer_s / KFILTER_THERE_S;
    let limited = |what: &str, ours: String, limit: String, ratio: f64| Row {
        what: what.to_owned(),
        ours,
        other: format!("{limit} x {scale:.2} (limit, by kfilter)"),
        ratio: Some(ratio),
        target: 1.0,
    };
    Ok(vec![
        limited(
            "swinging body, 14 states: predict + update",
            ns(step_s),
            ns(STEP_LIMIT_S),
            STEP_LIMIT_S * scale / step_s,
        ),
        limited(
            "swinging body: fit of 60 s, 5 deg",
            format!("{fit_s:.3} s"),
            format!("{FIT_LIMIT_S} s"),
            FIT_LIMIT_S * scale / fit_s,
        ),
        Row {
            what: "yielding thread: bank of five, predict + update".into(),
            ours: ns(bank_s),
            other: format!("{} (kfilter, one filter of two states)", ns(peer_s)),
            ratio: None,
            target: 1.0,
        },
    ])
}

fn swing_config() -> SwingConfig {
    let body = SwingBody {
        mass_kg: 1.0,
        com_depth_m: 0.1,
        inertia_kg_m2: [0.0100, 0.0105, 0.0100],
        gravity_m_s2: 9.81,
        swing_damping_1_s: 2e-3,
    };
    let axis = InputAxis::towards(RAD_PER_DEG, 0.7, 0.1 * RAD_PER_DEG);
    let start = StartPrior {
        angle_sigma_rad: 10.0 * RAD_PER_DEG,
        ..StartPrior::released(TAU, SWING_PERIOD_S)
    };
    SwingConfig::quiet(body, axis, start, R_RAD2_S2)
}

/// What the gyro says of the body as it is believed, let go at one turn and 5° of swing.
fn swinging_rates_rad_s(config: &SwingConfig) -> Result<Vec<f64>> {
    let omega_rad_s = TAU / SWING_PERIOD_S;
    let ratio = config.start.damping_ratio;
    let parameters = MotionParameters::as_believed(omega_rad_s.powi(2), 2.0 * ratio * omega_rad_s);
    let motion = SwingMotion::new(&config.body);
    let tilt_rad = 5.0 * RAD_PER_DEG;
    let mut state = MotionState {
        e: [tilt_rad.sin(), 0.0],
        twist_rad: TAU,
        omega_rad_s: [0.2 * tilt_rad * config.body.swing_frequency_rad_s(), 0.0, 0.0],
    };
    let mut noise = AddressedRandom::new(Seed(60), Channel::GyroAngleRandomWalk, 0);
    (0..9_000_u32)
        .map(|k| {
            state = motion.step(&state, &parameters, STEP_S)?;
            let expected = ExpectedRate::new(state.omega_rad_s, config.axis.tilt_b_rad, 0.0)?;
            Ok(expected.rate_rad_s + R_RAD2_S2.sqrt() * noise.standard_normal(u64::from(k)))
        })
        .collect()
}

#[inline(never)]
fn fitted(config: &SwingConfig, rates_rad_s: &[f64]) -> Result<AcceptedFit> {
    let mut fit = SwingFit::new(config, STEP_S)?;
    for &rate_rad_s in rates_rad_s {
        fit.push(rate_rad_s);
    }
    let accepted = fit.run_to_end().map_err(|reason| anyhow!("no fit: {reason:?}"))?;
    ensure!(accepted.restarts == 0, "a fit of clean samples was begun again");
    Ok(*accepted)
}

/// Out of line, so that every caller times the same machine code.
#[inline(never)]
fn run(filter: &mut impl RateEstimator, rates_rad_s: &[f64]) -> Result<()> {
    for &rate_rad_s in rates_rad_s {
        let (filter, rate_rad_s) = black_box((&mut *filter, rate_rad_s));
        filter.predict(STEP_S)?;
        black_box(filter.update(rate_rad_s)?);
    }
    Ok(())
}
