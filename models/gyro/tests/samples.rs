//! One gyro axis with white noise and turn-on bias: determinism, their statistics, saturation,
//! rounding, and what an unusable rate leaves behind.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use proptest::prelude::*;
use struna_gyro::datasheet::{rad_s_from_deg_s, vg910d};
use struna_gyro::{Gyro, GyroParams, preset};
use struna_kernel::{Counts, GyroReading, ReadingFlags, Seed};

const SEED: Seed = Seed(42);

fn gyro(params: GyroParams, run: u64) -> Gyro {
    Gyro::new(params, SEED, run).unwrap()
}

/// A VG-910D without noise and bias: quantisation and saturation alone.
fn noiseless() -> GyroParams {
    GyroParams { angle_random_walk_rad_sqrt_s: 0.0, turn_on_bias_sigma_rad_s: 0.0, ..vg910d() }
}

/// Flags of a gyro that does not warm up.
fn flags(valid: bool, over_range: bool) -> ReadingFlags {
    ReadingFlags { valid, over_range, warm_up: false, temperature_valid: true }
}

fn record(seed: Seed, run: u64) -> Vec<GyroReading> {
    // Everything on.
    let mut gyro = Gyro::new(preset::adis16100(), seed, run).unwrap();
    (0..500).map(|k| gyro.sample(f64::from(k) * 1e-3)).collect()
}

/// Errors in rad/s of `n` samples of a still gyro without bias.
fn still_errors(n: usize) -> Vec<f64> {
    let params = GyroParams { turn_on_bias_sigma_rad_s: 0.0, ..vg910d() };
    let mut gyro = gyro(params, 0);
    (0..n).map(|_| f64::from(gyro.sample(0.0).counts.0) * params.lsb_rad_s).collect()
}

fn variance(values: &[f64]) -> f64 {
    // About the known mean of zero, so no degree of freedom is lost.
    values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64
}

#[test]
fn one_seed_makes_one_record() {
    assert_eq!(record(SEED, 3), record(SEED, 3));
}

#[test]
fn another_run_and_another_seed_make_another_record() {
    assert_ne!(record(SEED, 3), record(SEED, 4));
    assert_ne!(record(SEED, 3), record(Seed(43), 3));
    assert_ne!(gyro(vg910d(), 3).bias_rad_s().to_bits(), gyro(vg910d(), 4).bias_rad_s().to_bits());
}

#[test]
fn runs_do_not_depend_on_the_order_in_which_they_are_made() {
    let forwards: Vec<_> = (0..4).map(|run| record(SEED, run)).collect();
    let mut backwards: Vec<_> = (0..4).rev().map(|run| record(SEED, run)).collect();
    backwards.reverse();
    assert_eq!(forwards, backwards);
}

#[test]
fn gyros_sampled_in_turn_do_not_disturb_each_other() {
    let (mut one, mut two) = (gyro(vg910d(), 0), gyro(vg910d(), 1));
    let interleaved: Vec<_> = (0..100).map(|_| (one.sample(0.1), two.sample(0.1))).collect();
    let mut alone = gyro(vg910d(), 1);
    for (_, second) in interleaved {
        assert_eq!(second, alone.sample(0.1));
    }
}

#[test]
fn noise_has_the_variance_of_the_angle_random_walk() {
    let n = 200_000;
    let params = vg910d();
    // Rounding to counts adds LSB²/12, here one part in five million.
    let expected = params.angle_random_walk_rad_sqrt_s.powi(2) * params.sample_rate_hz;
    let ratio = variance(&still_errors(n)) / expected;
    // Four standard errors of a variance, √(2/n) each.
    assert!((ratio - 1.0).abs() < 4.0 * (2.0 / n as f64).sqrt(), "ratio {ratio}");
}

#[test]
fn averaging_m_samples_divides_the_deviation_by_the_root_of_m() {
    let m = 25;
    let averages: Vec<f64> = still_errors(500_000)
        .chunks_exact(m)
        .map(|chunk| chunk.iter().sum::<f64>() / m as f64)
        .collect();
    let expected = vg910d().noise_sigma_rad_s().powi(2) / m as f64;
    let ratio = variance(&averages) / expected;
    // Four standard errors of a variance over 20 000 averages.
    let tolerance = 4.0 * (2.0 / averages.len() as f64).sqrt();
    assert!((ratio - 1.0).abs() < tolerance, "ratio {ratio}");
}

#[test]
fn turn_on_bias_spreads_from_run_to_run_and_is_what_the_samples_carry() {
    let params = GyroParams { angle_random_walk_rad_sqrt_s: 0.0, bias_rad_s: 1e-3, ..vg910d() };
    let sigma_rad_s = params.turn_on_bias_sigma_rad_s;
    let runs = 20_000;
    let mut biases = Vec::new();
    for run in 0..runs {
        let mut gyro = gyro(params, run);
        let read_rad_s = f64::from(gyro.sample(0.0).counts.0) * params.lsb_rad_s;
        assert!((read_rad_s - gyro.bias_rad_s()).abs() <= 0.501 * params.lsb_rad_s);
        biases.push(gyro.bias_rad_s() - params.bias_rad_s);
    }
    let n = runs as f64;
    let mean_rad_s = biases.iter().sum::<f64>() / n;
    // Four standard errors of mean and variance.
    assert!(mean_rad_s.abs() < 4.0 * sigma_rad_s / n.sqrt(), "mean {mean_rad_s:e}");
    let ratio = variance(&biases) / sigma_rad_s.powi(2);
    assert!((ratio - 1.0).abs() < 4.0 * (2.0 / n).sqrt(), "ratio {ratio}");
}

#[test]
fn the_mean_of_a_run_is_its_bias() {
    let n = 100_000_u32;
    let mut gyro = gyro(vg910d(), 5);
    let sum: i64 = (0..n).map(|_| i64::from(gyro.sample(0.0).counts.0)).sum();
    let mean_rad_s = sum as f64 / f64::from(n) * gyro.params().lsb_rad_s;
    // Four standard errors of the mean.
    let tolerance = 4.0 * gyro.params().noise_sigma_rad_s() / f64::from(n).sqrt();
    assert!((mean_rad_s - gyro.bias_rad_s()).abs() < tolerance, "{mean_rad_s:e}");
}

#[test]
fn beyond_the_range_counts_clip_exactly_and_the_flag_is_up() {
    let mut gyro = gyro(noiseless(), 0);
    for (rate_deg_s, counts, over_range) in [
        (199.0, 6_520_832, false),
        (200.0, 6_553_600, false),
        (200.1, 6_553_600, true),
        (-199.0, -6_520_832, false),
        (-200.0, -6_553_600, false),
        (-200.1, -6_553_600, true),
        (1e9, 6_553_600, true),
        (-1e300, -6_553_600, true),
    ] {
        let reading = gyro.sample(rad_s_from_deg_s(rate_deg_s));
        assert_eq!(reading.counts, Counts(counts), "{rate_deg_s} deg/s");
        assert_eq!(reading.flags, flags(true, over_range), "{rate_deg_s}");
    }
}

#[test]
fn noise_and_bias_alone_can_drive_a_reading_over_range() {
    let params = GyroParams { bias_rad_s: 0.01, ..noiseless() };
    let reading = gyro(params, 0).sample(params.rate_max_rad_s - 0.005);
    assert!(reading.flags.over_range && reading.flags.valid);
    assert_eq!(reading.counts, Counts(6_553_600));
}

#[test]
fn a_rate_that_is_no_number_is_marked_invalid_and_shifts_nothing() {
    let (mut disturbed, mut calm) = (gyro(vg910d(), 0), gyro(vg910d(), 0));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let reading = disturbed.sample(bad);
        assert_eq!(reading.flags, flags(false, false));
        assert_eq!(reading.counts, Counts(0));
        calm.sample(0.0);
    }
    assert_eq!(disturbed.sample(0.2), calm.sample(0.2));
}

#[test]
fn a_bias_that_overflows_is_marked_invalid() {
    let turn_on_bias_sigma_rad_s = f64::MAX;
    let params = GyroParams { turn_on_bias_sigma_rad_s, ..noiseless() };
    // A third of all runs draw beyond one sigma and overflow; none may pass as a number.
    let readings = (0..100).map(|run| {
        let mut gyro = gyro(params, run);
        (gyro.bias_rad_s().is_finite(), gyro.sample(0.0).flags.valid)
    });
    let (finite, infinite): (Vec<_>, Vec<_>) = readings.partition(|(finite, _)| *finite);
    assert!(!finite.is_empty() && finite.iter().all(|(_, valid)| *valid));
    assert!(!infinite.is_empty() && infinite.iter().all(|(_, valid)| !valid));
}

#[test]
fn saturation_does_not_shift_the_noise_of_later_samples() {
    let (mut saturated, mut calm) = (gyro(vg910d(), 0), gyro(vg910d(), 0));
    for _ in 0..10 {
        saturated.sample(100.0);
        calm.sample(0.0);
    }
    assert_eq!(saturated.sample(0.2), calm.sample(0.2));
}

proptest! {
    #[test]
    fn a_noiseless_reading_is_within_half_a_count(share in -1.0_f64..=1.0) {
        let params = noiseless();
        let rate_rad_s = share * params.rate_max_rad_s;
        let reading = gyro(params, 0).sample(rate_rad_s);
        let error_rad_s = f64::from(reading.counts.0) * params.lsb_rad_s - rate_rad_s;
        // Half a count, and one rounding of a rate of up to 3.5 rad/s.
        prop_assert!(error_rad_s.abs() <= 0.5 * params.lsb_rad_s + 1e-15);
        prop_assert!(!reading.flags.over_range);
    }

    #[test]
    fn no_rate_leaves_the_output_code(rate_rad_s in any::<f64>()) {
        let reading = gyro(vg910d(), 0).sample(rate_rad_s);
        prop_assert!(reading.counts.0.abs() <= 6_553_600);
        prop_assert_eq!(reading.flags.valid, rate_rad_s.is_finite());
    }
}
