//! Three gyros, from ignorance of the swing on.

use crate::rig::{SAMPLES, STEP_S, Scenario, Truth};
use struna_estimator::ThreeAxisFilter;
use struna_kernel::RAD_PER_DEG;

#[derive(Debug)]
struct Run {
    rms: f64,
    rate: f64,
    worst: f64,
    es: f64,
    sig: f64,
    nis: f64,
    mis: f64,
    st: struna_estimator::Status,
}

fn run(deg: f64, seed: u32) -> Run {
    let mut truth = Truth::new(Scenario::swing(deg), seed);
    let mut config = truth.config();
    if let Ok(w) = std::env::var("W") {
        config.swing_walk_s_m3_2 = w.parse().unwrap();
    }
    if let Ok(w) = std::env::var("WR") {
        config.rate_walk_rad2_s3 = w.parse::<f64>().unwrap() * RAD_PER_DEG * RAD_PER_DEG;
    }
    let s0 = std::env::var("S0").map_or(10.0, |s| s.parse::<f64>().unwrap());
    let mut filter = ThreeAxisFilter::new(&config, s0 * RAD_PER_DEG).unwrap();
    let (mut sum, mut rsum, mut worst, mut es, mut sig, mut nis) =
        (0.0, 0.0, 0.0_f64, 0.0, 0.0, 0.0);
    let mut mis = 0.0_f64;
    for k in 0..=SAMPLES {
        let sample = truth.sample(k);
        let i = filter.step(if k == 0 { 0.0 } else { STEP_S }, sample.rates_rad_s).unwrap();
        let n: f64 = i.iter().map(|i| i.nis()).sum::<f64>() / 3.0;
        nis += n;
        let b = filter.belief();
        let e = b.angle_rad - sample.motion.twist_rad;
        sig = b.covariance.angle_rad2.sqrt();
        es = e / sig;
        if k > 100 {
            worst = worst.max(es.abs());
        }
        if k > SAMPLES / 2 {
            sum += e * e;
            rsum += (b.rate_rad_s - sample.twist_rate_rad_s).powi(2);
        }
        mis = mis.max(n);
    }
    let h = f64::from(SAMPLES / 2);
    Run {
        rms: (sum / h).sqrt() / RAD_PER_DEG,
        rate: (rsum / h).sqrt() / RAD_PER_DEG,
        worst,
        es,
        sig: sig / RAD_PER_DEG,
        nis: nis / f64::from(SAMPLES),
        mis,
        st: filter.status(),
    }
}

#[test]
fn three() {
    for deg in [0.0, 1.0, 3.0, 5.0, 10.0, 15.0] {
        for seed in 0..3 {
            println!("{deg} {seed} {:?}", run(deg, seed));
        }
    }
}
