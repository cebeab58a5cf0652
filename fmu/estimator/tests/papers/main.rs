//! What the 2008 filters do on the motion that the papers simulate.
//!
//! Conventions of the comparison: degrees, 100 Hz, R = 2e-3 (deg/s)², T = 480 s, released from rest
//! at 360°, damping ratio 0.03, P₀ = diag(1, 1), 480 s. Truth is the closed form of damped torsion.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use std::f64::consts::TAU;
use struna_estimator::{
    Filter, FilterConfig, PlainIntegration, RateEstimator, Reading, Refinement,
};

const SAMPLES: u32 = 48_000;
const STEP_S: f64 = 0.01;
const PERIOD_S: f64 = 480.0;
const DAMPING_RATIO: f64 = 0.03;
const R_DEG2_S2: f64 = 2e-3;
const SEEDS: u64 = 10;

/// The filters are linear, so degrees may stand in for radians throughout.
fn config(refinement: Refinement) -> FilterConfig {
    FilterConfig {
        angle_start_rad: 360.0,
        rate_start_rad_s: 0.0,
        angle_variance_start_rad2: 1.0,
        rate_variance_start_rad2_s2: 1.0,
        measurement_variance_rad2_s2: R_DEG2_S2,
        process_noise_rad2_s3: 0.0,
        refinement,
    }
}

/// Damped torsion released from rest at 360°: (angle, rate) in deg and deg/s.
fn truth(t_s: f64) -> (f64, f64) {
    let omega = TAU / PERIOD_S;
    let decay = DAMPING_RATIO * omega;
    let damped = omega * (1.0 - DAMPING_RATIO * DAMPING_RATIO).sqrt();
    let (sin, cos) = (damped * t_s).sin_cos();
    let envelope = 360.0 * (-decay * t_s).exp();
    (envelope * (cos + decay / damped * sin), -envelope * omega * omega / damped * sin)
}

/// RMS of the angle error (deg) and of the rate error (deg/s) over run and seeds.
fn rms(mut fresh: impl FnMut() -> Box<dyn RateEstimator>) -> (f64, f64) {
    let noise = Normal::new(0.0, R_DEG2_S2.sqrt()).unwrap();
    let (mut angle2, mut rate2) = (0.0, 0.0);
    for seed in 0..SEEDS {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut estimator = fresh();
        for k in 1..=SAMPLES {
            let (angle_deg, rate_deg_s) = truth(f64::from(k) * STEP_S);
            estimator.predict(STEP_S).unwrap();
            estimator.update(rate_deg_s + noise.sample(&mut rng)).unwrap();
            let belief = estimator.belief();
            angle2 += (belief.angle_rad - angle_deg).powi(2);
            rate2 += (belief.rate_rad_s - rate_deg_s).powi(2);
        }
    }
    let n = f64::from(SAMPLES) * 10.0;
    ((angle2 / n).sqrt(), (rate2 / n).sqrt())
}

fn rotation(samples: u32, reading: Reading) -> impl FnMut() -> Box<dyn RateEstimator> {
    let config = config(Refinement { samples, reading });
    move || Box::new(Filter::permanent_rotation(config).unwrap())
}

fn torsion(samples: u32, reading: Reading) -> impl FnMut() -> Box<dyn RateEstimator> {
    let config = config(Refinement { samples, reading });
    move || Box::new(Filter::torsional_oscillation(config, PERIOD_S).unwrap())
}

#[track_caller]
fn assert_near(what: &str, got: f64, published: f64, relative: f64) {
    assert!((got / published - 1.0).abs() < relative, "{what}: {got:.4} against {published}");
}

/// Rates average over 48 000 samples and ten runs: their Monte-Carlo spread is a few per cent.
/// Angles are a random walk and have one independent value per run: 1/√(2·10) = 22 % at one sigma.
const RATE_TOLERANCE: f64 = 0.05;
const ANGLE_TOLERANCE: f64 = 0.5;

#[test]
fn reading_m6_reproduces_the_refined_filters() {
    let (angle_deg, rate_deg_s) = rms(rotation(100, Reading::M6));
    assert_near("rotation N=100 rate", rate_deg_s, 0.0147, RATE_TOLERANCE);
    assert_near("rotation N=100 angle", angle_deg, 0.0624, ANGLE_TOLERANCE);
    let (angle_deg, rate_deg_s) = rms(torsion(100, Reading::M6));
    assert_near("torsion N=100 rate", rate_deg_s, 0.0085, RATE_TOLERANCE);
    assert_near("torsion N=100 angle", angle_deg, 0.0622, ANGLE_TOLERANCE);
}

#[test]
fn the_literal_reading_extinguishes_its_own_gain() {
    let (unrefined_deg, _) = rms(rotation(0, Reading::M0));
    let (refined_deg, rate_deg_s) = rms(rotation(100, Reading::M0));
    assert_near("rotation M0 N=100 rate", rate_deg_s, 3.04, RATE_TOLERANCE);
    assert!(refined_deg > 1000.0 * unrefined_deg, "{refined_deg} against {unrefined_deg}");
    // 414° published: the angle follows a rate that has stopped listening, so it hardly varies.
    assert_near("rotation M0 N=100 angle", refined_deg, 414.0, RATE_TOLERANCE);
}

#[test]
fn the_unrefined_rotation_filter_is_plain_integration_in_angle() {
    let (filter_deg, rate_deg_s) = rms(rotation(0, Reading::M6));
    let integration = || -> Box<dyn RateEstimator> {
        Box::new(PlainIntegration::new(config(Refinement::OFF)).unwrap())
    };
    let (integral_deg, _) = rms(integration);
    // Its angle gain is dt·n/(n + m), m = R/c₀ = 2e-3: equal to integration from the first second.
    assert!((filter_deg / integral_deg - 1.0).abs() < 0.01, "{filter_deg} {integral_deg}");
    assert_near("rotation N=0 rate", rate_deg_s, 3.04, RATE_TOLERANCE);
}

#[test]
fn a_start_error_of_100_deg_stays_100_deg() {
    let config = FilterConfig {
        angle_start_rad: 460.0,
        ..config(Refinement { samples: 100, reading: Reading::M6 })
    };
    for (name, (angle_deg, _)) in [
        ("rotation", rms(|| Box::new(Filter::permanent_rotation(config).unwrap()))),
        ("torsion", rms(|| Box::new(Filter::torsional_oscillation(config, PERIOD_S).unwrap()))),
    ] {
        // Both copy the integral, and the integral starts wrong: 100.0 published for N ≤ 100.
        assert!((angle_deg - 100.0).abs() < 0.5, "{name}: {angle_deg}");
    }
}
