//! A gyro that clips for a third of the time, and says so: the flag goes from its status word
//! through frame and average to the estimator, as FMU and in process.

mod support;

use std::path::Path;
use struna::record::Record;
use struna::scenario::{EstimatorKind, RunAs, Scenario};
use struna_kernel::EstimateStatus;
use support::run;

/// The demo watched by a gyro that tells 3.5 deg/s at most, of 4.5; estimator `tested` alone.
fn scenario(run_as: RunAs) -> Scenario {
    let text = include_str!("../scenarios/demo.toml")
        .replacen("bias_deg_h = 3.0", "bias_deg_h = 3.0\nrate_max_deg_s = 3.5", 1)
        .replacen("bias_sigma_deg_h", "gyro_range_deg_s = 3.5\nbias_sigma_deg_h", 1);
    let mut scenario = Scenario::parse(&text, Path::new("demo.toml")).expect("the demo parses");
    scenario.estimators.drain(..3);
    scenario.estimators[0].run_as = run_as;
    scenario
}

fn column<'a>(record: &'a Record, name: &str) -> &'a [f64] {
    record.column(name).expect("a column of every record")
}

#[test]
fn what_a_clipped_gyro_says_is_noted_and_not_believed() {
    let record = run(&scenario(RunAs::InProcess)).record;
    let clipped = column(&record, "over_range");
    let share = clipped.iter().sum::<f64>() / clipped.len() as f64;
    assert!((0.2..0.5).contains(&share), "{share} of the samples are clipped");
    let (angle, truth) = (column(&record, "tested.angle_rad"), column(&record, "truth.twist_rad"));
    let sigma = column(&record, "tested.angle_sigma_rad");
    for (k, ((angle, truth), sigma)) in angle.iter().zip(truth).zip(sigma).enumerate() {
        assert!((angle - truth).abs() < 3.0 * sigma, "sample {k}: {angle} for {truth} +- {sigma}");
    }
    // Silent for more than a second: there is no angle, and it says so. And it comes back.
    let status = column(&record, "tested.status");
    let blind = f64::from(EstimateStatus::NotObservable.code());
    for (k, clipped) in clipped.windows(150).enumerate() {
        if clipped.iter().all(|flag| *flag > 0.0) {
            assert_eq!(status[k + 149].to_bits(), blind.to_bits(), "sample {}", k + 149);
        }
    }
    assert!(status.iter().any(|status| status.to_bits() == blind.to_bits()));
    assert!(status.last().is_some_and(|last| last.to_bits() != blind.to_bits()), "{status:?}");
}

#[test]
fn an_fmu_is_told_of_clipping_as_an_estimator_in_process_is() {
    let short = |run_as| {
        let mut scenario = scenario(run_as);
        scenario.duration = struna_kernel::SimTime::from_ns(90_000_000_000);
        run(&scenario).record
    };
    let reference = short(RunAs::InProcess);
    assert!(column(&reference, "over_range").iter().sum::<f64>() > 100.0);
    for run_as in [RunAs::Fmi2, RunAs::Fmi3] {
        let record = short(run_as.clone());
        for signal in ["angle_rad", "rate_rad_s", "angle_sigma_rad", "nis", "status"] {
            let name = format!("tested.{signal}");
            let bits = |record: &Record| -> Vec<u64> {
                column(record, &name).iter().map(|value| value.to_bits()).collect()
            };
            assert!(bits(&record) == bits(&reference), "{run_as:?}: {name} differs");
        }
    }
    // The kind is what the test believes it to be.
    let kind = scenario(RunAs::InProcess).estimators[0].kind.clone();
    let EstimatorKind::TestedTorsion { config, .. } = kind else { panic!("{kind:?}") };
    assert!(config.range.is_some_and(|range| range.margin_rad_s > 0.0));
}
