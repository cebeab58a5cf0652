//! Once they are made, the filters with innovation test and the bank for threads that yield
//! allocate nothing: not in a step, not in an alarm with its roll-back, not when they are saved.

use struna_estimator::{
    AugmentedConfig, FixedLag, HysteresisBank, InnovationTest, InputAxis, RateEstimator,
    SWING_STATES, StartPrior, SwingBelief, SwingBody, SwingConfig, SwingFilter, TestedFilter,
    ThreeAxisFilter,
};

fn config() -> AugmentedConfig {
    AugmentedConfig::quiet(StartPrior::released(6.0, 480.0), 6e-7)
}

/// Allocations in 200 s of a body that is struck by 0.05 rad/s after 100 s, and in a save.
fn allocations_of(estimator: &mut impl RateEstimator) -> u64 {
    let mut bytes = vec![0; estimator.saved_len()];
    allocation_counter::measure(|| {
        for k in 1..=20_000_u32 {
            let time_s = f64::from(k) * 0.01;
            let blow_rad_s = if k > 10_000 { 0.05 } else { 0.0 };
            let rate_rad_s = -0.0785 * (0.01309 * time_s).sin() + blow_rad_s;
            estimator.predict(0.01).expect("a prediction");
            estimator.update(rate_rad_s).expect("an update");
        }
        estimator.save(&mut bytes);
    })
    .count_total
}

#[test]
fn no_step_and_no_roll_back_allocates() {
    let mut filter = TestedFilter::new(&config(), &InnovationTest::STANDARD).expect("a filter");
    let allocated = allocations_of(&mut filter);
    assert!(filter.alarms() > 0, "the blow raised an alarm");
    assert_eq!(allocated, 0, "{allocated} allocations");
    let mut bank = HysteresisBank::new(&config()).expect("a bank");
    let allocated = allocations_of(&mut bank);
    assert!(bank.alarms() > 0, "the blow raised an alarm");
    assert_eq!(allocated, 0, "{allocated} allocations");
}

#[test]
fn no_step_of_a_smoother_and_no_restart_of_a_bank_allocates() {
    let mut lagging = FixedLag::new(&config(), &InnovationTest::STANDARD, 500).expect("a smoother");
    let mut bank = HysteresisBank::new(&config()).expect("a bank");
    let mut bytes = vec![0; lagging.saved_len()];
    let allocated = allocation_counter::measure(|| {
        for k in 1..=4_000_u32 {
            // A blow after 20 s, and the gyro clips for a moment.
            let rate_rad_s = if k > 2_000 { 0.05 } else { 0.0 };
            if k % 700 == 0 {
                lagging.step_over_range(0.01, 9.0).expect("a step");
            } else {
                lagging.step(0.01, rate_rad_s).expect("a step");
            }
            bank.step(0.01, rate_rad_s).expect("a step");
            std::hint::black_box(lagging.lagged());
        }
        lagging.save(&mut bytes);
        bank.restart(&config()).expect("a restart");
        bank.step(0.01, 0.0).expect("a step");
    })
    .count_total;
    assert!(lagging.filter().alarms() > 0, "the blow raised an alarm");
    assert_eq!(allocated, 0, "{allocated} allocations");
}

#[test]
fn no_step_and_no_roll_back_of_a_swinging_body_allocates() {
    let body = SwingBody {
        mass_kg: 1.0,
        com_depth_m: 0.1,
        inertia_kg_m2: [0.0100, 0.0105, 0.0100],
        gravity_m_s2: 9.81,
        swing_damping_1_s: 2e-3,
    };
    let axis = InputAxis::towards(0.017, 0.7, 1.7e-3);
    let start = StartPrior::released(6.0, 120.0);
    let config = SwingConfig::quiet(body, axis, start, 6e-7);
    let mean = [0.0, 0.0, 6.0, 0.0, 0.0, 0.0, 2.7e-3, 6e-3, 1.0, 1.0, 1.0, 0.0, 0.013, 0.011];
    let belief = SwingBelief::independent(mean, [1e-3; SWING_STATES]);
    let mut one = SwingFilter::new(&config, &InnovationTest::STANDARD, &belief)
        .expect("a filter of one axis");
    let mut three = ThreeAxisFilter::new(&config, 0.1).expect("a filter of three axes");
    let mut bytes = vec![0; one.saved_len()];
    let allocated = allocation_counter::measure(|| {
        for k in 1..=3_000_u32 {
            // A blow after 20 s.
            let rate_rad_s = if k > 2_000 { 0.05 } else { 0.0 };
            one.step(0.01, rate_rad_s).expect("a step");
            three.step(0.01, [0.0, 0.0, rate_rad_s]).expect("a step");
        }
        one.save(&mut bytes);
        one.restart(&belief).expect("a restart");
    })
    .count_total;
    assert_eq!(allocated, 0, "{allocated} allocations");
    one.restore(&bytes).expect("its own bytes");
    assert!(one.alarms() > 0, "the blow raised an alarm");
}
