//! The five-state filter behind a gyro whose counts are coarser than its noise.
//!
//! A body let go at 360°, T = 480 s ± 1 %, ζ = 0.03 ± 0.01, bias 0.05 deg/s, 480 s; three samples
//! of 300 Hz, of 0.0775 deg/s each, are rounded to the nearest count and their mean is a measured
//! rate. Truth is the closed form of damped torsion; nothing of it is the filter's.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use nalgebra::{SMatrix, SVector};
use struna_estimator::{
    AugmentedConfig, AugmentedFilter, HysteresisBank, InnovationTest, Quantiser, RateEstimator,
    StartPrior, TestedFilter,
};
use struna_kernel::{Channel, RAD_PER_DEG, RandomStream, Seed};

const STEP_S: f64 = 0.01;
const SAMPLES: u32 = 48_000;
const PARTS: u32 = 3;
const PERIOD_S: f64 = 480.0;
/// Of the mean of three samples, before they are rounded.
const R_RAD2_S2: f64 = 2e-3 * RAD_PER_DEG * RAD_PER_DEG;
const RUNS: u32 = 20;

/// A damped oscillation and the bias of who watches it.
struct Truth {
    omega: f64,
    damping_ratio: f64,
    rate_start_rad_s: f64,
    bias_rad_s: f64,
}

impl Truth {
    /// Angle and rate.
    fn at(&self, time_s: f64) -> (f64, f64) {
        let (decay, start) = (self.damping_ratio * self.omega, 360.0 * RAD_PER_DEG);
        let damped = self.omega * (1.0 - self.damping_ratio.powi(2)).sqrt();
        let along = (self.rate_start_rad_s + decay * start) / damped;
        let (sin, cos) = (damped * time_s).sin_cos();
        let fade = (-decay * time_s).exp();
        let angle_rad = fade * (start * cos + along * sin);
        (angle_rad, fade * damped * (along * cos - start * sin) - decay * angle_rad)
    }

    fn state(&self, time_s: f64) -> [f64; 5] {
        let (angle_rad, rate_rad_s) = self.at(time_s);
        let s = self.omega * self.omega;
        let d = 2.0 * self.damping_ratio * self.omega;
        [-s * angle_rad, rate_rad_s, s, d, self.bias_rad_s]
    }
}

/// What some runs come to.
#[derive(Debug, Default)]
struct Outcome {
    /// Over the second half, deg.
    rms_deg: f64,
    claimed_deg: f64,
    /// At the end, in claimed standard deviations.
    worst_sigmas: f64,
    /// At the middle and at the end, over five states.
    nees: f64,
    alarms: u64,
}

/// Runs with counts so coarse that the noise of a sample is `sigma` of them.
fn outcome(sigma: f64, told: bool) -> Outcome {
    let raw_sigma_rad_s = (R_RAD2_S2 * f64::from(PARTS)).sqrt();
    let step_rad_s = raw_sigma_rad_s / sigma;
    let quantiser = Quantiser { step_rad_s, raw_sigma_rad_s, samples: PARTS };
    let mut all = Outcome::default();
    for run in 0..RUNS {
        one(quantiser, told, run, &mut all);
    }
    let half = f64::from(RUNS * SAMPLES / 2);
    all.rms_deg = (all.rms_deg / half).sqrt() / RAD_PER_DEG;
    all.claimed_deg = (all.claimed_deg / half).sqrt() / RAD_PER_DEG;
    all.nees /= 2.0 * f64::from(RUNS);
    all
}

fn one(quantiser: Quantiser, told: bool, run: u32, all: &mut Outcome) {
    let mut draws = RandomStream::new(Seed(20_080_480), Channel::StartError, u64::from(run));
    let mut n = || draws.standard_normal();
    let truth = Truth {
        omega: std::f64::consts::TAU / (PERIOD_S * (1.0 + 0.01 * n())),
        damping_ratio: (0.03 + 0.01 * n()).max(0.0),
        rate_start_rad_s: 0.01 * RAD_PER_DEG * n(),
        bias_rad_s: 0.05 * RAD_PER_DEG * n(),
    };
    let start = StartPrior::released((360.0 + 100.0 * n()) * RAD_PER_DEG, PERIOD_S);
    let mut config = AugmentedConfig::quiet(start, R_RAD2_S2);
    config.quantiser = told.then_some(quantiser);
    let mut filter = TestedFilter::new(&config, &InnovationTest::STANDARD).unwrap();
    let mut before_rad = truth.at(0.0).0;
    let part_s = STEP_S / f64::from(PARTS);
    for k in 1..=SAMPLES {
        let mut counts = 0.0;
        for part in 0..PARTS {
            let time_s = part_s * f64::from((k - 1) * PARTS + part + 1);
            let angle_rad = truth.at(time_s).0;
            let rate_rad_s = (angle_rad - before_rad) / part_s + truth.bias_rad_s;
            before_rad = angle_rad;
            let noisy_rad_s = rate_rad_s + quantiser.raw_sigma_rad_s * n();
            counts += (noisy_rad_s / quantiser.step_rad_s).round_ties_even();
        }
        filter.step(STEP_S, counts / f64::from(PARTS) * quantiser.step_rad_s).unwrap();
        if k > SAMPLES / 2 {
            let belief = filter.belief();
            all.rms_deg += (belief.angle_rad - before_rad).powi(2);
            all.claimed_deg += belief.covariance.angle_rad2;
        }
        if k % (SAMPLES / 2) == 0 {
            all.nees += error_squared(&filter, truth.state(f64::from(k) * STEP_S));
        }
    }
    let belief = filter.belief();
    let sigmas = (belief.angle_rad - before_rad).abs() / belief.covariance.angle_rad2.sqrt();
    all.worst_sigmas = all.worst_sigmas.max(sigmas);
    all.alarms += filter.alarms();
}

/// Normalised estimation error squared: eᵀ·P⁻¹·e over all five states.
fn error_squared(filter: &TestedFilter, truth: [f64; 5]) -> f64 {
    let rows = filter.filter().covariance();
    // Scaled to correlations first: the units differ by ten orders of magnitude.
    let sigma: [f64; 5] = std::array::from_fn(|i| rows[i][i].sqrt());
    let correlation = SMatrix::<f64, 5, 5>::from_fn(|i, j| rows[i][j] / (sigma[i] * sigma[j]));
    let mean = filter.filter().mean();
    let error = SVector::<f64, 5>::from_fn(|i, _| (mean[i] - truth[i]) / sigma[i]);
    let root = correlation.cholesky().expect("the covariance is positive definite");
    error.dot(&root.solve(&error))
}

#[test]
fn the_claim_holds_however_little_of_the_steps_is_dithered_away() {
    // 0.32 counts are a 12-bit gyro of ±500 deg/s; 0.1 is the least that is promised.
    for (sigma, angle_deg) in [(0.3176, 0.59), (0.2, 0.70), (0.1, 0.90)] {
        let told = outcome(sigma, true);
        // Largest of twenty normal numbers: beyond 3.7 once in 230 campaigns.
        assert!(told.worst_sigmas < 3.7, "{sigma}: {told:?}");
        // Two readings of five squares, √(10/20) each if they were one; three sigma.
        assert!((2.9..7.1).contains(&told.nees), "{sigma}: {told:?}");
        // What it claimed over 100 runs of other seeds; it depends little on the run. Its error
        // scatters by √(1/40) over twenty runs; three sigma.
        assert!((told.claimed_deg / angle_deg - 1.0).abs() < 0.05, "{sigma}: {told:?}");
        assert!((0.53..1.47).contains(&(told.rms_deg / told.claimed_deg)), "{sigma}: {told:?}");
        // A count that is not normal raises an alarm for nothing in some runs, not in most.
        assert!(told.alarms < u64::from(RUNS), "{sigma}: {told:?}");
    }
}

#[test]
fn one_who_is_not_told_of_the_counts_is_far_too_sure() {
    let not_told = outcome(0.3176, false);
    assert!(not_told.worst_sigmas > 6.0 && not_told.nees > 20.0, "{not_told:?}");
}

/// A rig of another kind than above, for what needs no motion.
fn config(quantiser: Option<Quantiser>) -> AugmentedConfig {
    let start = StartPrior { bias_rad_s: 1e-3, ..StartPrior::released(6.0, PERIOD_S) };
    AugmentedConfig { quantiser, ..AugmentedConfig::quiet(start, R_RAD2_S2) }
}

const COARSE: Quantiser = Quantiser { step_rad_s: 4e-3, raw_sigma_rad_s: 1e-3, samples: 2 };

#[test]
fn dithered_counts_are_no_more_than_noise() {
    let fine = Quantiser { raw_sigma_rad_s: 0.5 * COARSE.step_rad_s, ..COARSE };
    let r_rad2_s2 = (fine.raw_sigma_rad_s.powi(2) + fine.step_rad_s.powi(2) / 12.0) / 2.0;
    let mut told = AugmentedFilter::new(&config(Some(fine))).unwrap();
    let noise = AugmentedConfig { measurement_variance_rad2_s2: r_rad2_s2, ..config(None) };
    let mut plain = AugmentedFilter::new(&noise).unwrap();
    for k in 0..50 {
        let rate_rad_s = 0.5 * COARSE.step_rad_s * f64::from(k % 3);
        let pair = [&mut told, &mut plain].map(|filter| filter.step(STEP_S, rate_rad_s).unwrap());
        assert_eq!(pair[0], pair[1]);
    }
    assert_eq!((told.mean(), told.covariance()), (plain.mean(), plain.covariance()));
    // A record that shows more noise than that is believed.
    let noisy = AugmentedConfig { quantiser: Some(fine), ..noise };
    let noisy = AugmentedConfig { measurement_variance_rad2_s2: 2.0 * r_rad2_s2, ..noisy };
    let of = |config: &AugmentedConfig| {
        let innovation = AugmentedFilter::new(config).unwrap().step(STEP_S, 0.0).unwrap();
        innovation.variance_rad2_s2
    };
    assert!((of(&noisy) - of(&noise) - r_rad2_s2).abs() < 1e-12 * r_rad2_s2);
}

#[test]
fn those_who_know_no_rounding_take_ten_times_the_noise() {
    let bank = |config: &AugmentedConfig| {
        let mut bank = HysteresisBank::new(config).unwrap();
        let innovation = bank.step(STEP_S, 1e-3).unwrap();
        (innovation, bank.belief())
    };
    let tenfold = 10.0 * R_RAD2_S2;
    let noise = AugmentedConfig { measurement_variance_rad2_s2: tenfold, ..config(None) };
    assert_eq!(bank(&config(Some(COARSE))), bank(&noise));
    let fine = Quantiser { raw_sigma_rad_s: 2e-3, ..COARSE };
    assert_eq!(bank(&config(Some(fine))), bank(&config(None)));
}

#[test]
fn impossible_counts_are_refused_and_wild_rates_change_nothing() {
    for (name, bad) in [
        ("step_rad_s", Quantiser { step_rad_s: 0.0, ..COARSE }),
        ("step_rad_s", Quantiser { step_rad_s: f64::NAN, ..COARSE }),
        ("step_rad_s", Quantiser { step_rad_s: 1e-200, ..COARSE }),
        ("raw_sigma_rad_s", Quantiser { raw_sigma_rad_s: -1e-3, ..COARSE }),
        ("raw_sigma_rad_s", Quantiser { raw_sigma_rad_s: f64::INFINITY, ..COARSE }),
        ("samples", Quantiser { samples: 0, ..COARSE }),
    ] {
        let told = config(Some(bad));
        assert_eq!(AugmentedFilter::new(&told).unwrap_err().name, name);
        assert_eq!(HysteresisBank::new(&told).unwrap_err().name, name);
    }
    for step_rad_s in [1e-100, 1.0, 1e100] {
        let counts = Quantiser { step_rad_s, raw_sigma_rad_s: 0.0, samples: u32::MAX };
        let mut filter = AugmentedFilter::new(&config(Some(counts))).unwrap();
        let before = filter.mean();
        for rate_rad_s in [f64::NAN, f64::INFINITY, 1e200, -1e308] {
            assert!(filter.step(STEP_S, rate_rad_s).is_err(), "{rate_rad_s} at {step_rad_s}");
            assert_eq!(filter.mean().map(f64::to_bits), before.map(f64::to_bits));
        }
        // A rate that can be squared may be taken in or refused, but leaves numbers.
        let _ = filter.step(STEP_S, 1e150);
        let entries = filter.mean().into_iter().chain(filter.covariance().into_iter().flatten());
        assert!(entries.into_iter().all(f64::is_finite), "at {step_rad_s}");
    }
}
