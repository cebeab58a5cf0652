//! What an alarm of the bank costs, and where the bank stands after it.

use crate::rig::{Run, START_DEG, STEP_S, Thread, config};
use struna_estimator::{HysteresisBank, InnovationTest, RateEstimator, TestedFilter};
use struna_kernel::RAD_PER_DEG;

/// Samples before the body is struck: almost as many as there are between two checkpoints.
const CALM: u32 = 480;

/// Five seconds of a turn that takes eight minutes are all that is known of the angle. An alarm
/// doubts the rate around the kick; were it to doubt it over the whole way back to the checkpoint,
/// those five seconds would be lost.
#[test]
fn a_kick_takes_away_next_to_nothing_of_what_was_known_of_the_angle() {
    let mut run = Run::new(Thread::Linear, 3);
    let mut bank = HysteresisBank::new(&config(START_DEG)).unwrap();
    let step = |bank: &mut HysteresisBank, run: &mut Run, k: u32, kick_rad_s: f64| {
        bank.step(STEP_S, run.sample(k).measured_rad_s + kick_rad_s).unwrap();
    };
    for k in 1..=CALM {
        step(&mut bank, &mut run, k, 0.0);
    }
    let sigma_deg =
        |bank: &HysteresisBank| bank.belief().covariance.angle_rad2.sqrt() / RAD_PER_DEG;
    let before_deg = sigma_deg(&bank);
    assert_eq!(bank.alarms(), 0);
    let mut k = CALM;
    while bank.alarms() == 0 && k < CALM + 20 {
        k += 1;
        step(&mut bank, &mut run, k, 1.0 * RAD_PER_DEG);
    }
    let after_deg = sigma_deg(&bank);
    println!("{before_deg:.2} deg before the kick, {after_deg:.2} after {} samples", k - CALM);
    assert_eq!(bank.alarms(), 1);
    // 13.0° and 13.4°; without those five seconds it is the prior's 100°.
    assert!(after_deg < 1.2 * before_deg, "{after_deg} {before_deg}");
}

/// A push that swells: three samples weak enough to pass the gate, and with the fourth, which
/// raises the alarm, the blow. It is two dozen times what the mean over the four makes one expect,
/// and yet the best that is known of the rate.
#[test]
fn the_sample_that_raises_an_alarm_is_believed_however_large_it_is() {
    let mut run = Run::new(Thread::Linear, 3);
    let model = config(START_DEG);
    let mut bank = HysteresisBank::new(&model).unwrap();
    let mut tested = TestedFilter::new(&model, &InnovationTest::STANDARD).unwrap();
    let mut step = |rate_of: &dyn Fn(f64) -> f64, k| {
        let rate_rad_s = rate_of(run.sample(k).measured_rad_s);
        bank.step(STEP_S, rate_rad_s).unwrap();
        tested.step(STEP_S, rate_rad_s).unwrap();
        (
            [bank.alarms(), tested.alarms()],
            [&bank as &dyn RateEstimator, &tested].map(RateEstimator::belief),
        )
    };
    for k in 1..=CALM {
        step(&|rate_rad_s| rate_rad_s, k);
    }
    let sigma_rad_s = model.measurement_variance_rad2_s2.sqrt();
    for (k, sigmas) in (CALM + 1..).zip([3.5, 3.5, 3.5]) {
        let (alarms, _) = step(&|rate_rad_s| rate_rad_s + sigmas * sigma_rad_s, k);
        assert_eq!(alarms, [0, 0]);
    }
    let blow_rad_s = 100.0 * sigma_rad_s;
    let (alarms, beliefs) = step(&|rate_rad_s| rate_rad_s + blow_rad_s, CALM + 4);
    assert_eq!(alarms, [1, 1]);
    for belief in beliefs {
        // 7 % of it are left to what was believed before.
        assert!((belief.rate_rad_s / blow_rad_s - 1.0).abs() < 0.1, "{}", belief.rate_rad_s);
    }
}
