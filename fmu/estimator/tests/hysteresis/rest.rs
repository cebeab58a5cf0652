//! A body that rests tells nothing of where it rests, and the bank must not claim that it does.

use crate::rig::{Run, SAMPLES, START_DEG, STEP_S, Thread, config};
use struna_estimator::{HysteresisBank, RateEstimator, Status};
use struna_kernel::{AddressedRandom, Channel, RAD_PER_DEG, Seed};

const NOISE_RAD_S: f64 = 0.044_72 * RAD_PER_DEG;

/// What a gyro says of a body at rest.
fn at_rest_rad_s(noise: &mut AddressedRandom, k: u32) -> f64 {
    0.03 * RAD_PER_DEG + NOISE_RAD_S * noise.standard_normal(u64::from(k))
}

fn noise(run: u64) -> AddressedRandom {
    AddressedRandom::new(Seed(7), Channel::GyroAngleRandomWalk, run)
}

fn angle_sigma_rad(bank: &HysteresisBank) -> f64 {
    bank.belief().covariance.angle_rad2.sqrt()
}

#[test]
fn a_body_that_has_never_moved_is_claimed_no_better_than_at_the_start() {
    for run in 0..4 {
        let mut noise = noise(run);
        let mut bank = HysteresisBank::new(&config(START_DEG)).unwrap();
        let start_rad = angle_sigma_rad(&bank);
        for k in 1..=SAMPLES {
            bank.step(STEP_S, at_rest_rad_s(&mut noise, k)).unwrap();
            if k % 100 == 0 {
                assert!(angle_sigma_rad(&bank) >= start_rad, "run {run}, sample {k}");
                assert_eq!(bank.status(), Status::NotObservable);
            }
        }
        // The linear member does claim that a body at rest hangs at its equilibrium.
        let linear = bank.linear_member().unwrap().belief();
        assert!(linear.covariance.angle_rad2.sqrt() < 0.1 * start_rad);
    }
}

#[test]
fn a_body_let_go_is_seen_to_move_at_once() {
    let mut run = Run::new(Thread::Dahl(25.0), 0);
    let mut bank = run.bank();
    let start_rad = angle_sigma_rad(&bank);
    let seen = (1..=2000).find(|&k| {
        bank.step(STEP_S, run.sample(k).measured_rad_s).unwrap();
        angle_sigma_rad(&bank) < 0.9 * start_rad
    });
    // It gains 0.06 deg/s in a second, and the bias is known to 0.05 deg/s: five of that take 4 s.
    assert!(seen.is_some_and(|k| k < 800), "{seen:?}");
}

#[test]
fn once_it_has_come_to_rest_the_claim_does_not_shrink() {
    for run in 0..4 {
        let mut truth = Run::new(Thread::Dahl(50.0), run);
        let mut bank = truth.bank();
        let mut last_rad_s = 0.0;
        for k in 1..=SAMPLES {
            last_rad_s = truth.sample(k).measured_rad_s;
            bank.step(STEP_S, last_rad_s).unwrap();
        }
        let bias_rad_s = bank.learnt().bias_rad_s;
        assert!((last_rad_s - bias_rad_s).abs() < 0.5 * RAD_PER_DEG, "it hardly moves any more");
        let mut noise = noise(u64::from(run));
        let mut rest = |bank: &mut HysteresisBank, samples: u32| {
            for k in 1..=samples {
                let noise_rad_s = NOISE_RAD_S * noise.standard_normal(u64::from(k));
                bank.step(STEP_S, bias_rad_s + noise_rad_s).unwrap();
            }
            angle_sigma_rad(bank)
        };
        // The last creeping movement, held up all at once, is news for a quarter of a period.
        let mut before_rad = rest(&mut bank, 12_000);
        let settled_rad = before_rad;
        for minute in 0..8 {
            let sigma_rad = rest(&mut bank, 6000);
            // Weights that shift between members may take a little of the mixture's spread.
            assert!(sigma_rad > 0.98 * before_rad, "run {run}, minute {minute}: {sigma_rad}");
            before_rad = sigma_rad;
        }
        assert!(before_rad > settled_rad, "run {run}: {before_rad} {settled_rad}");
    }
}
