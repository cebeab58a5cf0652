//! Three gyros, from ignorance of the swing on.

use crate::rig::{SAMPLES, STEP_S, Scenario, Truth};
use struna_estimator::{Innovation, Status, ThreeAxisFilter};
use struna_kernel::RAD_PER_DEG;

/// What the filter is told of the swing, whatever it is: within some 10°.
const SWING_SIGMA_RAD: f64 = 10.0 * RAD_PER_DEG;

/// What one run comes to. Degrees.
#[derive(Debug)]
struct Run {
    /// RMS over the second half.
    angle_deg: f64,
    rate_deg_s: f64,
    /// Largest error of the angle over claimed sigma.
    worst: f64,
    /// Mean NIS per axis.
    nis: f64,
    status: Status,
}

fn run(swing_deg: f64, run: u32) -> Run {
    let mut truth = Truth::new(Scenario::swing(swing_deg), run);
    let config = truth.config();
    let mut filter = ThreeAxisFilter::new(&config, SWING_SIGMA_RAD).unwrap();
    filter.update(truth.sample(0).rates_rad_s).unwrap();
    let (mut angle2, mut rate2, mut worst, mut nis) = (0.0, 0.0, 0.0_f64, 0.0);
    for k in 1..=SAMPLES {
        let sample = truth.sample(k);
        let innovations = filter.step(STEP_S, sample.rates_rad_s).unwrap();
        nis += innovations.iter().map(Innovation::nis).sum::<f64>();
        let belief = filter.belief();
        let error_rad = belief.angle_rad - sample.motion.twist_rad;
        worst = worst.max(error_rad.abs() / belief.covariance.angle_rad2.sqrt());
        if k > SAMPLES / 2 {
            angle2 += error_rad.powi(2);
            rate2 += (belief.rate_rad_s - sample.twist_rate_rad_s).powi(2);
        }
    }
    let half = f64::from(SAMPLES / 2);
    Run {
        angle_deg: (angle2 / half).sqrt() / RAD_PER_DEG,
        rate_deg_s: (rate2 / half).sqrt() / RAD_PER_DEG,
        worst,
        nis: nis / f64::from(3 * SAMPLES),
        status: filter.status(),
    }
}

/// Three runs at an amplitude.
fn keeps_the_angle(swing_deg: f64) {
    for seed in 0..3 {
        let run = run(swing_deg, seed);
        assert!(run.angle_deg < 0.08, "{swing_deg} deg, run {seed}: {run:?}");
        assert!(run.rate_deg_s < 0.004, "{swing_deg} deg, run {seed}: {run:?}");
        // 24 000 samples lie within a correlation time of the angle some hundred times: 3.5 sigma
        // is one such time in two thousand.
        assert!(run.worst < 3.5, "{swing_deg} deg, run {seed}: {run:?}");
        // 1 ± 3·√(2/72 000), and up to 2 % below for noise that the quiet truth does not have.
        assert!((0.965..1.017).contains(&run.nis), "{swing_deg} deg, run {seed}: {run:?}");
        if swing_deg < 0.3 {
            assert_eq!(run.status, Status::Nominal, "{swing_deg} deg, run {seed}");
            continue;
        }
        // The root sum of squares of the ellipse's half axes has fallen by exp(−240/500), from
        // √1.04; A ≠ B bends the ellipse, to a circle at most.
        let (least, most) = (0.44 * swing_deg * RAD_PER_DEG, 0.64 * swing_deg * RAD_PER_DEG);
        let swings = matches!(
            run.status,
            Status::Swinging { amplitude_rad } if (least..most).contains(&amplitude_rad)
        );
        assert!(swings, "{swing_deg} deg, run {seed}: {run:?}");
    }
}

#[test]
fn three_axes_keep_the_angle_of_a_body_that_hardly_swings() {
    keeps_the_angle(0.0);
    keeps_the_angle(1.0);
}

#[test]
fn three_axes_keep_the_angle_at_three_and_five_degrees() {
    keeps_the_angle(3.0);
    keeps_the_angle(5.0);
}

#[test]
fn three_axes_keep_the_angle_at_ten_and_fifteen_degrees() {
    keeps_the_angle(10.0);
    keeps_the_angle(15.0);
}

#[test]
fn three_axes_learn_body_and_gyros() {
    let mut truth = Truth::new(Scenario::swing(10.0), 3);
    let config = truth.config();
    let mut filter = ThreeAxisFilter::new(&config, SWING_SIGMA_RAD).unwrap();
    for k in 1..=SAMPLES {
        let rates_rad_s = truth.sample(k).rates_rad_s;
        filter.step(STEP_S, rates_rad_s).unwrap();
    }
    let learnt = filter.parameters().entries();
    // The stiffness to 1e-3 and the damping to 2e-2 of themselves, moments to 1e-4, the decay of
    // the swing to 2 %, all from far wider priors.
    let tolerances = [1e-3, 2e-2, 1e-4, 1e-4, 2e-2];
    for ((learnt, true_), tolerance) in learnt.into_iter().zip(truth.parameters()).zip(tolerances) {
        assert!((learnt / true_ - 1.0).abs() < tolerance, "{learnt} for {true_}");
    }
    for (learnt, true_) in filter.biases_rad_s().into_iter().zip(truth.biases_rad_s()) {
        let off_deg_s = (learnt - true_).abs() / RAD_PER_DEG;
        // Each sample says 0.045 deg/s, and 24 000 of them 3e-4, with the walk of the rates on top.
        assert!(off_deg_s < 3e-3, "{off_deg_s} deg/s");
    }
}
