//! Every random term against its Allan variance, and the averages of a band-limited gyro.
//!
//! Series are made at low sample rates, where long ones are short; the terms themselves know
//! nothing of the sample rate. Rounding is made fine enough not to matter.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
#![expect(clippy::print_stdout, reason = "what was measured")]

use std::f64::consts::{LN_2, PI};
use struna_gyro::{DriftParams, Gyro, GyroParams, Response, Rounding, Sampling, preset};
use struna_kernel::{RAD_PER_DEG, Seed};

const SEED: Seed = Seed(42);

/// A gyro whose counts are fine beside `scale_rad_s`.
fn fine(sample_rate_hz: f64, scale_rad_s: f64) -> GyroParams {
    GyroParams::exact(sample_rate_hz, 1e4 * scale_rad_s, 1e-5 * scale_rad_s, i32::MAX)
}

/// Rates that a still gyro reads in run `run`.
fn still(params: GyroParams, run: u64, n: usize) -> Vec<f64> {
    let mut gyro = Gyro::new(params, SEED, run).unwrap();
    (0..n).map(|_| f64::from(gyro.sample(0.0).counts.0) * params.lsb_rad_s).collect()
}

fn averages(rates: &[f64], m: usize) -> Vec<f64> {
    rates.chunks_exact(m).map(|chunk| chunk.iter().sum::<f64>() / m as f64).collect()
}

/// Allan variance over neighbouring averages of `m`, and how many differences it is of.
fn allan_variance(rates: &[f64], m: usize) -> (f64, f64) {
    let means = averages(rates, m);
    let n = means.len() - 1;
    let sum: f64 = means.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum();
    (0.5 * sum / n as f64, n as f64)
}

fn variance(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64
}

/// Asserts an Allan variance within four standard errors and `bias` more. Neighbouring
/// differences share a mean; for noises from white to random walk the relative variance of the
/// estimate is at most 3/n.
#[track_caller]
fn agrees(what: &str, (found, n): (f64, f64), expected: f64, bias: f64) {
    let (ratio, tolerance) = (found / expected, 4.0 * (3.0 / n).sqrt() + bias);
    println!("{what}: Allan variance {ratio:.4} of the closed form, +-{tolerance:.4}");
    assert!((ratio - 1.0).abs() < tolerance, "{what}: {ratio}");
}

#[test]
fn angle_random_walk_has_the_allan_variance_of_white_noise() {
    let walk = 1e-4;
    let params = GyroParams { angle_random_walk_rad_sqrt_s: walk, ..fine(100.0, 1e-3) };
    let rates = still(params, 0, 1_000_000);
    for m in [1, 10, 100, 1000] {
        let tau_s = m as f64 / 100.0;
        agrees(&format!("N at {tau_s} s"), allan_variance(&rates, m), walk * walk / tau_s, 0.0);
    }
}

#[test]
fn bias_instability_is_flat_at_its_floor_over_the_decades() {
    let floor_rad_s = 1e-4;
    let drift = DriftParams { bias_instability_rad_s: floor_rad_s, ..DriftParams::default() };
    let params = GyroParams { drift, ..fine(40.0, floor_rad_s) };
    // 14 hours.
    let rates = still(params, 0, 2_000_000);
    for tau_s in [10_usize, 30, 100, 300] {
        let expected = 2.0 * LN_2 / PI * floor_rad_s * floor_rad_s;
        // A sum over decades ripples: Allan deviations of 0.98 to 1.01 of the floor.
        agrees(&format!("B at {tau_s} s"), allan_variance(&rates, 40 * tau_s), expected, 0.04);
    }
}

#[test]
fn a_single_gauss_markov_process_peaks_at_the_floor_and_falls_on_both_sides() {
    let floor_rad_s = 1e-4;
    let drift = DriftParams {
        bias_instability_rad_s: floor_rad_s,
        correlation_time_s: 10.0,
        ..DriftParams::default()
    };
    let params = GyroParams { drift, ..fine(40.0, floor_rad_s) };
    let rates = still(params, 0, 2_000_000);
    let peak = 2.0 * LN_2 / PI * floor_rad_s * floor_rad_s;
    let shape = |tau_s: f64| {
        let x: f64 = tau_s / 10.0;
        2.0 / x * (1.0 - (3.0 - 4.0 * (-x).exp() + (-2.0 * x).exp()) / (2.0 * x))
    };
    for tau_s in [1_usize, 10, 19, 100] {
        let expected = peak * shape(tau_s as f64) / shape(18.9262);
        agrees(&format!("GM at {tau_s} s"), allan_variance(&rates, 40 * tau_s), expected, 0.0);
    }
}

#[test]
fn rate_random_walk_has_its_allan_variance() {
    let walk = 1e-5;
    let drift = DriftParams { rate_random_walk_rad_s_sqrt_s: walk, ..DriftParams::default() };
    let params = GyroParams { drift, ..fine(100.0, 1e-3) };
    let rates = still(params, 0, 2_000_000);
    for tau_s in [1_usize, 10, 100] {
        let expected = walk * walk * tau_s as f64 / 3.0;
        // Cells of 0.05 s: straight lines take 0.05/τ of the variance of 1 s and less of others.
        let bias = 0.05 / tau_s as f64;
        agrees(&format!("K at {tau_s} s"), allan_variance(&rates, 100 * tau_s), expected, bias);
    }
}

#[test]
fn a_rate_ramp_has_its_allan_variance_without_any_chance() {
    let drift = DriftParams { rate_ramp_rad_s2: 1e-6, ..DriftParams::default() };
    let rates = still(GyroParams { drift, ..fine(100.0, 1e-3) }, 0, 100_000);
    let (found, _) = allan_variance(&rates, 1000);
    // R²τ²/2; rounding is 1e-8 rad/s in means that differ by 1e-5.
    assert!((found / (0.5 * 1e-10) - 1.0).abs() < 2e-3, "{found:e}");
}

#[test]
fn rounded_angles_and_rates_have_the_allan_variances_of_their_quantisation() {
    let lsb_rad_s = 1e-3;
    // White noise of three counts spreads the remainders evenly and makes them independent.
    let noisy = |rounding, lsb_rad_s| {
        let exact = GyroParams::exact(100.0, 1.0, lsb_rad_s, i32::MAX);
        let params = GyroParams { rounding, angle_random_walk_rad_sqrt_s: 3e-4, ..exact };
        still(params, 0, 1_000_000)
    };
    let truth = noisy(Rounding::Rate, 1e-6 * lsb_rad_s);
    let error = |rounding| -> Vec<f64> {
        noisy(rounding, lsb_rad_s).iter().zip(&truth).map(|(read, truth)| read - truth).collect()
    };
    let (of_angles, of_rates) = (error(Rounding::Angle), error(Rounding::Rate));
    for m in [1, 10, 100] {
        let tau_s = m as f64 / 100.0;
        let quantum_rad = lsb_rad_s / 100.0 / 12.0_f64.sqrt();
        let angles = 3.0 * (quantum_rad / tau_s).powi(2);
        agrees(&format!("Q at {tau_s} s"), allan_variance(&of_angles, m), angles, 0.0);
        let rates = lsb_rad_s * lsb_rad_s / 12.0 / 100.0 / tau_s;
        agrees(&format!("rate rounding at {tau_s} s"), allan_variance(&of_rates, m), rates, 0.0);
    }
}

/// An ADIS16100 with its white noise and filter alone.
fn adis_noise() -> GyroParams {
    let all = preset::adis16100();
    GyroParams {
        angle_random_walk_rad_sqrt_s: all.angle_random_walk_rad_sqrt_s,
        response: Response { delay_s: 0.0, ..all.response },
        // Fine counts: a third of a degree per second is 1.4 of the real ones.
        lsb_rad_s: 1e-3 * all.lsb_rad_s,
        counts_max: i32::MAX,
        ..all.without_errors()
    }
}

#[test]
fn averaging_a_band_limited_gyro_gains_less_than_the_root_of_the_number() {
    let rates = still(adis_noise(), 0, 2_800_000);
    let one_rad_s = variance(&rates).sqrt();
    // 44.4 Hz of noise bandwidth, both signs of frequency: 0.035·√88.9 deg/s.
    let expected_deg_s = (0.05 / 2.0_f64.sqrt()) * (2.0 * 40.0 * PI / 8.0_f64.sqrt()).sqrt();
    let found_deg_s = one_rad_s / RAD_PER_DEG;
    println!("one sample: {found_deg_s:.4} deg/s, {expected_deg_s:.4} by bandwidth");
    // Noise constant through 0.7 ms steps has (ωₙT)²/12 = 0.3 % less bandwidth; 4 standard errors
    // of some 10⁵ independent values are 0.9 %.
    assert!((found_deg_s / expected_deg_s - 1.0).abs() < 0.012);
    for (m, expected) in [(14, 0.865), (70, 0.462), (140, 0.331)] {
        let means = averages(&rates, m);
        let ratio = variance(&means).sqrt() / one_rad_s;
        // Published to three digits; four standard errors of the deviation of the averages, of
        // which those of 14 samples have a third of them in common.
        let tolerance = 0.0005 + 4.0 * expected * (1.4 / (2.0 * means.len() as f64)).sqrt();
        println!("averages of {m}: {ratio:.4}, expected {expected} +-{tolerance:.4}");
        assert!((ratio - expected).abs() < tolerance, "{m}: {ratio}");
    }
}

#[test]
fn noise_behind_the_filter_is_white_however_narrow_the_band() {
    let response = Response { noise_before_filter: false, ..adis_noise().response };
    let params = GyroParams { response, sampling: Sampling::Mean, ..adis_noise() };
    let rates = still(params, 0, 500_000);
    let expected = params.noise_sigma_rad_s().powi(2);
    for m in [1, 14] {
        let means = averages(&rates, m);
        let ratio = variance(&means) * m as f64 / expected;
        assert!((ratio - 1.0).abs() < 4.0 * (2.0 / means.len() as f64).sqrt(), "{m}: {ratio}");
    }
}

#[test]
fn each_noise_has_a_stream_of_its_own() {
    let white = GyroParams { angle_random_walk_rad_sqrt_s: 1e-4, ..fine(100.0, 1e-2) };
    let drift = DriftParams {
        bias_instability_rad_s: 1e-4,
        rate_random_walk_rad_s_sqrt_s: 1e-5,
        ..DriftParams::default()
    };
    let wandering = GyroParams { drift, ..fine(100.0, 1e-2) };
    let both = GyroParams { drift, ..white };
    let series = [white, wandering, both].map(|params| still(params, 5, 2000));
    for ((white, wandering), both) in series[0].iter().zip(&series[1]).zip(&series[2]) {
        // Three values rounded to half a count of 1e-7 rad/s each.
        assert!((white + wandering - both).abs() < 1.6e-7, "{white} + {wandering} is not {both}");
    }
}

#[test]
fn runs_and_seeds_wander_differently_and_each_the_same_way_again() {
    let params = preset::adis16100();
    let series = |seed, run| {
        let mut gyro = Gyro::new(params, Seed(seed), run).unwrap();
        (0..300).map(|_| gyro.sample(0.1).counts.0).collect::<Vec<_>>()
    };
    let (last, first) = (series(1, 7), series(1, 0));
    assert_eq!((series(1, 0), series(1, 7)), (first.clone(), last.clone()));
    assert!(first != last && first != series(2, 0));
}
