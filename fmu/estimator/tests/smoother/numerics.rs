//! Hostile input, gaps, and priors at the edge.

use crate::accuracy::smoothed;
use crate::rig::{B, D, PERIOD_S, R_RAD2_S2, STEP_S};
use crate::runs::{Run, belief_error_squared};
use struna_estimator::{
    AugmentedConfig, ConfigError, FixedLag, GyroRange, InnovationTest, RateEstimator, RateRecord,
    RateSample, RestoreError, SmoothError, StartPrior, Status, smooth,
};
use struna_kernel::RAD_PER_DEG;

const TEST: InnovationTest = InnovationTest::STANDARD;

fn config() -> AugmentedConfig {
    AugmentedConfig::quiet(StartPrior::released(6.0, PERIOD_S), R_RAD2_S2)
}

fn samples(times_and_rates: &[(f64, f64)]) -> Vec<RateSample> {
    let sample = |&(time_s, rate_rad_s)| RateSample { time_s, rate_rad_s, over_range: false };
    times_and_rates.iter().map(sample).collect()
}

fn refusal(samples: &[RateSample]) -> SmoothError {
    smooth(&config(), &TEST, &RateRecord { start_time_s: 0.0, samples }).unwrap_err()
}

#[test]
fn a_bad_sample_is_refused_with_its_place() {
    assert_eq!(refusal(&[]), SmoothError::Empty);
    let back = samples(&[(0.01, 0.0), (0.02, 0.0), (0.015, 0.0)]);
    assert!(matches!(refusal(&back), SmoothError::BadSample { index: 2, .. }));
    let before_start = samples(&[(-0.01, 0.0)]);
    assert!(matches!(refusal(&before_start), SmoothError::BadSample { index: 0, .. }));
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(matches!(
            refusal(&samples(&[(0.01, 0.0), (0.02, bad)])),
            SmoothError::BadSample { index: 1, .. }
        ));
        assert!(matches!(refusal(&samples(&[(bad, 0.0)])), SmoothError::BadSample { .. }));
    }
    // Finite, but its residual cannot be squared.
    let huge = samples(&[(0.01, 0.0), (0.02, 1e200)]);
    assert!(matches!(refusal(&huge), SmoothError::BadSample { index: 1, .. }));
}

#[test]
fn a_bad_model_is_refused() {
    let negative = AugmentedConfig { measurement_variance_rad2_s2: -1.0, ..config() };
    let samples = samples(&[(0.01, 0.0)]);
    let record = RateRecord { start_time_s: 0.0, samples: &samples };
    assert!(matches!(smooth(&negative, &TEST, &record), Err(SmoothError::Config(_))));
    let too_long = FixedLag::new(&config(), &TEST, FixedLag::LAG_MAX_SAMPLES + 1);
    assert!(matches!(too_long, Err(ConfigError { name: "lag_samples", .. })));
}

#[test]
fn a_refused_sample_changes_nothing() {
    let mut running = FixedLag::new(&config(), &TEST, 20).unwrap();
    for k in 1..100 {
        running.step(STEP_S, -1e-5 * f64::from(k)).unwrap();
    }
    let saved = |running: &FixedLag| {
        let mut bytes = vec![0; running.saved_len()];
        running.save(&mut bytes);
        bytes
    };
    let before = saved(&running);
    for (span_s, rate_rad_s) in [(-0.01, 0.0), (f64::NAN, 0.0), (0.01, f64::NAN), (0.01, 1e200)] {
        assert!(running.step(span_s, rate_rad_s).is_err());
        assert!(running.step_over_range(span_s, rate_rad_s).is_err());
    }
    assert!(running.restore(&before[1..]).is_err());
    assert_eq!(saved(&running), before);
}

#[test]
fn bytes_that_contradict_themselves_are_refused() {
    let mut running = FixedLag::new(&config(), &TEST, 20).unwrap();
    for k in 1..100 {
        running.step(STEP_S, -1e-5 * f64::from(k)).unwrap();
    }
    let mut good = vec![0; running.saved_len()];
    running.save(&mut good);
    let n = good.len();
    // The last three words: newest, turning point, time.
    for (at, word) in [
        (n - 24, u64::MAX.to_le_bytes()),
        (n - 24, 3_u64.to_le_bytes()),
        (n - 16, 100_u64.to_le_bytes()),
        (n - 16, 79_u64.to_le_bytes()),
        (n - 16, 0_u64.to_le_bytes()),
    ] {
        let mut bytes = good.clone();
        bytes[at..at + 8].copy_from_slice(&word);
        assert_eq!(running.restore(&bytes), Err(RestoreError::Impossible), "{at}");
    }
    let mut bytes = good.clone();
    bytes[n - 8..].copy_from_slice(&f64::NAN.to_le_bytes());
    assert!(matches!(running.restore(&bytes), Err(RestoreError::NotFinite { .. })));
    running.restore(&good).unwrap();
}

/// Whatever numbers a saved state holds, what comes out of it is numbers.
#[test]
fn wild_bytes_yield_no_nan() {
    let mut running = FixedLag::new(&config(), &TEST, 20).unwrap();
    for k in 1..100 {
        running.step(STEP_S, -1e-5 * f64::from(k)).unwrap();
    }
    let mut good = vec![0; running.saved_len()];
    running.save(&mut good);
    let traces = good.len() - 24 - 176 * 3093;
    for at in (traces..good.len() - 24).step_by(8 * 5009).chain((traces..traces + 176).step_by(8)) {
        for wild in [1e300, -1e300, -1.0, 0.0, 1e-300] {
            let mut bytes = good.clone();
            let Some(word) = bytes.get_mut(at..at + 8) else { continue };
            word.copy_from_slice(&f64::to_le_bytes(wild));
            if running.restore(&bytes).is_err() {
                continue;
            }
            let mut beliefs = running.tail();
            beliefs.extend(running.lagged().map(|lagged| lagged.filter.belief()));
            for belief in beliefs {
                assert!(belief.angle_rad.is_finite() && belief.rate_rad_s.is_finite());
                assert!(!belief.covariance.angle_rad2.is_nan());
            }
        }
    }
}

#[test]
fn irregular_spans_and_gaps_are_as_good_as_regular_ones() {
    for run in 0..4 {
        let mut run = Run::of(B, run);
        // One to four steps, and a dropout of three seconds in each minute, and one of 40 s.
        let (mut last, mut kept) = (0, Vec::new());
        for k in 1..=48_000_u32 {
            let due = k - last > k.wrapping_mul(0x9E37_79B9) >> 30 && k % 6000 > 300;
            if due && !(20_000..24_000).contains(&k) {
                kept.push(k as usize - 1);
                last = k;
            }
        }
        run.samples = kept.iter().map(|&k| run.samples[k]).collect();
        run.truth = kept.iter().map(|&k| run.truth[k]).collect();
        let smoothed = smoothed(B, &run);
        let nees: f64 = smoothed
            .beliefs()
            .zip(&run.truth)
            .map(|(belief, truth)| belief_error_squared(&belief, truth))
            .step_by(97)
            .sum::<f64>()
            / kept.len().div_ceil(97) as f64;
        // Errors of one run go together: about five independent pairs, 2 ± 1 each.
        assert!(nees < 6.0, "{nees}");
        let sigma = smoothed.at(0).unwrap().belief().covariance.angle_rad2.sqrt();
        assert!(sigma < 0.3 * RAD_PER_DEG, "{sigma}");
    }
}

#[test]
fn samples_over_range_are_left_out() {
    let mut run = Run::of(B, 2);
    let limit_rad_s = 3.5 * RAD_PER_DEG;
    for sample in &mut run.samples {
        sample.rate_rad_s = sample.rate_rad_s.clamp(-limit_rad_s, limit_rad_s);
    }
    let range = Some(GyroRange::with_raw_sigma(limit_rad_s, R_RAD2_S2.sqrt()));
    let told = AugmentedConfig { range, ..B.config(run.believed_start_deg) };
    let told = smooth(&told, &TEST, &run.record()).unwrap();
    let rms = run.mean_squares(told.beliefs())[0].sqrt();
    assert!(rms < 0.3, "{rms}° when the model knows of the range");
    // The same by flags of the gyro, and no range in the model.
    // Flagged by what the gyro turns at and not by what it measures: that would be a bias.
    for (sample, truth) in run.samples.iter_mut().zip(&run.truth) {
        sample.over_range = truth.rate_rad_s.abs() > 0.9 * limit_rad_s;
    }
    let flagged = smoothed(B, &run);
    let rms = run.mean_squares(flagged.beliefs())[0].sqrt();
    assert!(rms < 0.5, "{rms}° when the gyro flags");
}

#[test]
fn nothing_is_learnt_when_every_sample_is_over_range() {
    let mut run = Run::of(B, 1);
    run.samples.truncate(2_000);
    run.samples.iter_mut().for_each(|sample| sample.over_range = true);
    let smoothed = smoothed(B, &run);
    assert_eq!(smoothed.status(), Status::NotObservable);
    let sigma = smoothed.at(0).unwrap().belief().covariance.angle_rad2.sqrt();
    // What the prior said: 100°.
    assert!((sigma / RAD_PER_DEG - 100.0).abs() < 1.0, "{sigma}");
}

#[test]
fn certain_priors_stay_certain() {
    let run = Run::of(B, 6);
    let (s, d) = run.parameters;
    let start = StartPrior {
        angle_sigma_rad: 0.0,
        rate_sigma_rad_s: 0.0,
        period_s: std::f64::consts::TAU / s.sqrt(),
        period_sigma_s: 0.0,
        damping_ratio: 0.5 * d / s.sqrt(),
        damping_ratio_sigma: 0.0,
        bias_rad_s: run.bias_rad_s,
        bias_sigma_rad_s: 0.0,
        ..StartPrior::released(360.0 * RAD_PER_DEG, PERIOD_S)
    };
    for q in [0.0, 1e-9 * RAD_PER_DEG * RAD_PER_DEG] {
        let config = AugmentedConfig {
            start,
            process_noise_rad2_s3: q,
            bias_walk_rad2_s3: 0.0,
            ..AugmentedConfig::quiet(start, R_RAD2_S2)
        };
        // An alarm without a cause would open the rate for good.
        let quiet = InnovationTest { false_alarms: 1e-9, ..TEST };
        let smoothed = smooth(&config, &quiet, &run.record()).unwrap();
        assert!(smoothed.kicks().is_empty());
        let rms = run.mean_squares(smoothed.beliefs());
        // The truth itself, but for random torque that may be believed in.
        assert!(rms[0].sqrt() < if q > 0.0 { 0.05 } else { 1e-6 }, "q {q:e}: {rms:?}");
    }
}

/// Thirty amplitudes' worth of damping and no random torque: the way back is unstable on paper.
#[test]
fn a_motion_long_died_down_is_smoothed() {
    let (period_s, ratio, step_s) = (20.0, 0.2, 0.1);
    let omega = std::f64::consts::TAU / period_s;
    let decay = ratio * omega;
    let beat = omega * (1.0 - ratio * ratio).sqrt();
    let angle =
        |t: f64| 6.0 * (-decay * t).exp() * ((beat * t).cos() + decay / beat * (beat * t).sin());
    let rate = |t: f64| -6.0 * omega * omega / beat * (-decay * t).exp() * (beat * t).sin();
    // Noise enough for a filter: a sawtooth of the right variance.
    let noise =
        |k: u32| R_RAD2_S2.sqrt() * (f64::from(k.wrapping_mul(0x9E37_79B9)) / 1.24e9 - 1.73);
    let samples: Vec<RateSample> = (1..=6_000)
        .map(|k| RateSample {
            time_s: f64::from(k) * step_s,
            rate_rad_s: rate(f64::from(k) * step_s) + noise(k),
            over_range: false,
        })
        .collect();
    let start = StartPrior { damping_ratio: 0.2, ..StartPrior::released(6.3, period_s) };
    for q in [0.0, 1e-14] {
        let config = AugmentedConfig {
            process_noise_rad2_s3: q,
            ..AugmentedConfig::quiet(start, R_RAD2_S2)
        };
        let record = RateRecord { start_time_s: 0.0, samples: &samples };
        let smoothed = smooth(&config, &TEST, &record).unwrap();
        for (belief, sample) in smoothed.beliefs().zip(&samples) {
            let (off, sigma) =
                (belief.angle_rad - angle(sample.time_s), belief.covariance.angle_rad2);
            assert!(off.abs() < 5.0 * sigma.sqrt() + 1e-9, "{}: {off} {sigma}", sample.time_s);
        }
    }
}

#[test]
fn a_period_wrong_by_a_factor_of_three_is_owned_up_to() {
    for factor in [1.0 / 3.0, 3.0] {
        let run = Run::of(B, 2);
        let start = StartPrior::released(run.believed_start_deg * RAD_PER_DEG, PERIOD_S * factor);
        let config = AugmentedConfig { start, ..B.config(0.0) };
        let smoothed = smooth(&config, &TEST, &run.record()).unwrap();
        let status = smoothed.status();
        let owned_up = matches!(status, Status::ModelDoubtful | Status::NotObservable);
        assert!(owned_up, "{factor}: {status:?}");
        assert!(smoothed.kicks().len() > 10, "{factor}: {} alarms", smoothed.kicks().len());
    }
}

#[test]
fn kicks_are_found_at_their_sample() {
    for run in 0..6 {
        let run = Run::of(D, run);
        let truth = run.kicks.clone();
        let smoothed = smoothed(D, &run);
        for (sample, size_rad_s) in truth {
            let near = |kick: &&struna_estimator::Kick| kick.sample.abs_diff(sample) <= 1;
            let kick = smoothed.kicks().iter().find(near);
            let kick = kick.unwrap_or_else(|| panic!("none at {sample}: {:?}", smoothed.kicks()));
            // Seen over at least three samples after and twenty before: 0.5 and 0.2 of 0.045 °/s.
            let off = (kick.size_rad_s - size_rad_s).abs();
            assert!(off < 0.15 * RAD_PER_DEG, "{off}");
        }
    }
}
