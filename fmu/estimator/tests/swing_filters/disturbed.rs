//! Three gyros and what no model knows of: kicks, outliers, and noise that was not declared.

use crate::rig::{R_RAD2_S2, STEP_S, Scenario, Truth};
use std::ops::Range;
use struna_estimator::{EstimatorError, Innovation, Status, ThreeAxisFilter};
use struna_kernel::{AddressedRandom, Channel, RAD_PER_DEG, Seed};

/// What the filter is told of the swing.
const SWING_SIGMA_RAD: f64 = 10.0 * RAD_PER_DEG;
/// Where the disturbances begin: the filter has found the motion by then.
const AT: u32 = 4_000;
/// Samples in a quarter of a period, for which a disturbance is spoken of.
const QUARTER: u32 = 3_000;
/// Noise of the gyros, rad/s.
fn sigma_rad_s() -> f64 {
    R_RAD2_S2.sqrt()
}

/// What is printed when a run fails its test.
impl std::fmt::Debug for Watched {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (alarms, status) = (self.filter.alarms(), self.filter.status());
        f.debug_struct("Watched")
            .field("worst", &[self.worst, self.worst_rate])
            .field("noise_factor", &self.filter.noise_factor())
            .field("alarms", &alarms)
            .field("status", &status)
            .finish_non_exhaustive()
    }
}

/// A filter on its way, its truth, and its errors over claims.
struct Watched {
    truth: Truth,
    filter: ThreeAxisFilter,
    /// Largest error of the angle over claimed sigma.
    worst: f64,
    /// And of the rate of the twist.
    worst_rate: f64,
}

impl Watched {
    fn new(scenario: Scenario, run: u32) -> Self {
        let mut truth = Truth::new(scenario, run);
        let filter = ThreeAxisFilter::new(&truth.config(), SWING_SIGMA_RAD).unwrap();
        Self { truth, filter, worst: 0.0, worst_rate: 0.0 }
    }

    /// Gives it samples with something added to the rates; what it claims is judged from
    /// `judged_from` on.
    fn hear(
        &mut self,
        samples: Range<u32>,
        judged_from: u32,
        mut added_rad_s: impl FnMut(u32) -> [f64; 3],
    ) -> Result<[Innovation; 3], EstimatorError> {
        let mut last = Err(EstimatorError::Overflow);
        for k in samples {
            let sample = self.truth.sample(k);
            let added = added_rad_s(k);
            let rates_rad_s = std::array::from_fn(|axis| sample.rates_rad_s[axis] + added[axis]);
            last = Ok(self.filter.step(STEP_S, rates_rad_s)?);
            let belief = self.filter.belief();
            if k >= judged_from {
                let off = (belief.angle_rad - sample.motion.twist_rad).abs();
                self.worst = self.worst.max(off / belief.covariance.angle_rad2.sqrt());
                let off = (belief.rate_rad_s - sample.twist_rate_rad_s).abs();
                self.worst_rate = self.worst_rate.max(off / belief.covariance.rate_rad2_s2.sqrt());
            }
        }
        last
    }

    fn sigma_deg(&self) -> f64 {
        self.filter.belief().covariance.angle_rad2.sqrt() / RAD_PER_DEG
    }
}

fn nothing(_: u32) -> [f64; 3] {
    [0.0; 3]
}

/// The root sum of squares of a start belief's and a kick's growth leaves the angle as well known
/// as before, give or take: a kick is over within a hundredth of a second.
const SIGMA_GROWTH_MAX: f64 = 1.15;

#[test]
fn a_kick_is_found_repaired_and_over_after_a_quarter_of_a_period() {
    // Least, middling, and more than the fastest turn; with the samples that it may take to see.
    for (kick_deg_s, seen_within) in [(0.05, 60), (0.5, 5), (5.0, 5)] {
        let kick = Some((AT, [kick_deg_s, -kick_deg_s, kick_deg_s]));
        let mut run = Watched::new(Scenario { kick, ..Scenario::swing(5.0) }, 1);
        run.hear(1..AT, 1, nothing).unwrap();
        assert_eq!(run.filter.alarms(), 0, "{kick_deg_s}");
        let sigma_deg = run.sigma_deg();
        // What is claimed between the kick and its alarm nobody can help.
        run.hear(AT..AT + seen_within, u32::MAX, nothing).unwrap();
        assert_eq!(run.filter.alarms(), 1, "{kick_deg_s}: seen once");
        assert!(matches!(run.filter.status(), Status::Disturbed { .. }), "{kick_deg_s}");
        assert!(run.sigma_deg() < SIGMA_GROWTH_MAX * sigma_deg, "{kick_deg_s}");
        run.hear(AT + seen_within..AT + QUARTER + 200, AT, nothing).unwrap();
        assert_eq!(run.filter.alarms(), 1, "{kick_deg_s}: and repaired once");
        // As of a run without one: 3.5 sigma is one such time in two thousand.
        assert!(run.worst < 3.5 && run.worst_rate < 4.0, "{kick_deg_s}: {run:?}");
        assert!(matches!(run.filter.status(), Status::Swinging { .. }), "{kick_deg_s}: {run:?}");
    }
}

#[test]
fn outliers_of_any_axis_hardly_count() {
    let [mut struck, mut spared] = [0; 2].map(|_| Watched::new(Scenario::swing(5.0), 2));
    // One sample in a hundred, of one axis after the other, off by 20 sigma or by a thousand.
    let outliers = |k: u32| {
        let size = if k.is_multiple_of(200) { 20.0 } else { -1000.0 };
        // In the first three seconds only the large ones are known for what they are.
        let is_one = k.is_multiple_of(100) && (k > 300 || size < 0.0);
        let hit = |axis| if is_one && (k / 100) % 3 == axis { size } else { 0.0 };
        [0, 1, 2].map(|axis| hit(axis) * sigma_rad_s())
    };
    struck.hear(1..AT, 1, outliers).unwrap();
    spared.hear(1..AT, 1, nothing).unwrap();
    assert_eq!(struck.filter.alarms(), 0, "{struck:?}");
    assert!(struck.filter.noise_factor() <= 1.0);
    assert!(matches!(struck.filter.status(), Status::Swinging { .. }), "{struck:?}");
    assert!(struck.worst < 3.5, "{struck:?}");
    let [with, without] = [struck.filter.belief(), spared.filter.belief()];
    let off_rad = (with.angle_rad - without.angle_rad).abs();
    let sigma_rad = without.covariance.angle_rad2.sqrt();
    // A hundredth of what tells the angle is missing: a tenth of a sigma, and three of those.
    assert!(off_rad < 0.3 * sigma_rad, "{off_rad} of {sigma_rad} rad");
}

#[test]
fn noise_that_was_not_declared_is_owned_up_to_and_over_when_it_ends() {
    for (times, seed) in [(3.0_f64, 1), (30.0, 2)] {
        let mut run = Watched::new(Scenario::swing(5.0), seed);
        run.hear(1..AT, 1, nothing).unwrap();
        let mut noise = AddressedRandom::new(Seed(5), Channel::ImpulseSize, u64::from(seed));
        let extra_rad_s = (times - 1.0).sqrt() * sigma_rad_s();
        let mut more = |k: u32| {
            [0, 1, 2].map(|axis| extra_rad_s * noise.standard_normal(u64::from(3 * k + axis)))
        };
        // The first blocks come before it is known.
        run.hear(AT..AT + 400, u32::MAX, &mut more).unwrap();
        let status = run.filter.status();
        assert!(matches!(status, Status::Disturbed { .. } | Status::ModelDoubtful), "{status}");
        run.hear(AT + 400..AT + 2000, 1, &mut more).unwrap();
        let factor = run.filter.noise_factor();
        // Three hundred squares know their mean to 8 %, and it follows them: three of those, and
        // a tenth more for gated ones of the noise that came unawares.
        assert!((0.75..1.35).contains(&(factor / times)), "{factor} for {times}");
        run.hear(AT + 2000..AT + 2400, 1, nothing).unwrap();
        // Down by the share that a block shows, to one at the second.
        assert!(run.filter.noise_factor() < 1.1, "{}", run.filter.noise_factor());
        run.hear(AT + 2400..AT + 2400 + 2 * QUARTER + 200, 1, nothing).unwrap();
        assert!(run.worst < 3.5 && run.worst_rate < 4.0, "{times}: {run:?}");
        assert!(matches!(run.filter.status(), Status::Swinging { .. }), "{times}: {run:?}");
    }
}

#[test]
fn a_wide_swing_that_nobody_told_of_is_no_kick() {
    for seed in 10..13 {
        let mut run = Watched::new(Scenario::swing(15.0), seed);
        run.hear(1..1500, 500, nothing).unwrap();
        assert_eq!(run.filter.alarms(), 0, "run {seed}: {run:?}");
        assert!(run.worst < 3.5, "run {seed}: {run:?}");
        // It does not know the angle to ten degrees before the thread has turned the body.
        let status = run.filter.status();
        assert!(!matches!(status, Status::Disturbed { .. }), "run {seed}: {status}");
    }
}

#[test]
fn restored_bytes_go_on_bit_for_bit_through_an_alarm_and_through_noise() {
    let kick = Some((500, [0.5, 0.5, 0.5]));
    let mut run = Watched::new(Scenario { kick, ..Scenario::swing(5.0) }, 2);
    run.hear(1..502, u32::MAX, nothing).unwrap();
    assert_eq!(run.filter.alarms(), 0);
    let mut bytes = vec![0; run.filter.saved_len()];
    run.filter.save(&mut bytes);
    // Bytes of a filter in the midst of things, into one that has just begun.
    let mut resumed = ThreeAxisFilter::new(&run.truth.config(), SWING_SIGMA_RAD).unwrap();
    resumed.restore(&bytes).unwrap();
    let mut noise = AddressedRandom::new(Seed(5), Channel::ImpulseSize, 0);
    for k in 502..1500 {
        let mut rates_rad_s = run.truth.sample(k).rates_rad_s;
        if k >= 1000 {
            rates_rad_s[1] += 3.0 * sigma_rad_s() * noise.standard_normal(u64::from(k));
        }
        let innovations = run.filter.step(STEP_S, rates_rad_s).unwrap();
        assert_eq!(resumed.step(STEP_S, rates_rad_s).unwrap(), innovations);
    }
    assert!(run.filter.alarms() > 0 && run.filter.noise_factor() > 1.0, "{run:?}");
    assert_eq!(run.filter, resumed);
}
