use crate::rig::{Case, PERIOD_S, Run};
use struna_estimator::{Progress, SwingFit};
use struna_kernel::RAD_PER_DEG;

#[test]
fn look() {
    let (mut total, mut worst) = (0.0, 0);
    for swing in [0.0, 1.0, 5.0, 10.0, 15.0] {
        for seed in 0..6 {
            let run = Run::of(&Case::new(swing, seed, 61));
            let mut fit = SwingFit::new(&run.config, PERIOD_S).unwrap();
            for z in &run.measured_rad_s {
                fit.push(*z);
            }
            let t = std::time::Instant::now();
            let mut n = 0;
            while fit.work(1000) == Progress::Working {
                n += 1;
            }
            let dt = t.elapsed().as_secs_f64();
            total += dt;
            worst = worst.max(n);
            let r = fit.run_to_end().cloned();
            match r {
                Ok(fit) => {
                    let k = fit.samples as usize - 1;
                    let truth = run.truth[k];
                    let e = (fit.mean[2] - truth.twist_rad) / RAD_PER_DEG;
                    let s = fit.covariance[2][2].sqrt() / RAD_PER_DEG;
                    println!(
                        "{swing} {seed} {dt:.3}s {n}k {:.0}ns e {e:.3} s {s:.3} cost {:.3} glr {:.2} sq {:.2} amp {:.2} modes {} r {} dense {}",
                        dt / n as f64 * 1e6,
                        fit.cost_per_sample,
                        fit.leftover_mean,
                        fit.leftover_square,
                        fit.amplitude_rad / RAD_PER_DEG,
                        fit.modes,
                        fit.restarts,
                        fit.dense
                    );
                }
                Err(e) => println!("{swing} {seed} {dt:.3}s {n}k {e:?}"),
            }
        }
    }
    println!("total {total} worst {worst}");
}
