//! Faults of the gyro itself, seen in its counts.

use crate::bench::{decoded, every, frame, grid, seconds};
use struna_gyro::{Gyro, GyroParams, Rail, Sampling, datasheet};
use struna_harness::fault::{FaultKind, FaultPlan, FaultRecord, Injector};
use struna_harness::{Emulator, Recording};
use struna_kernel::Seed;

const FRAMES: u64 = 3000;
const LSB_DEG_S: f64 = 1.0 / 32_768.0;

fn emulator(plan: &FaultPlan) -> Emulator {
    let motion = Recording::new(&[0.0, 5.0, 10.0], &[0.0, 1.0, -1.0]).unwrap();
    let params = GyroParams { sampling: Sampling::Instantaneous, ..datasheet::vg910d() };
    let gyro = Gyro::new(params, Seed(1), 0).unwrap();
    let emulator = Emulator::new(Box::new(motion), gyro, grid(), &frame()).unwrap();
    let injector = Injector::new(plan, &frame(), Seed(2), 0);
    emulator.with_faults(injector)
}

fn bytes(plan: &FaultPlan) -> (Vec<u8>, Vec<FaultRecord>) {
    let mut emulator = emulator(plan);
    let mut out = Vec::new();
    for _ in 0..FRAMES {
        emulator.emit(&mut out).unwrap();
    }
    emulator.finish(&mut |_| {});
    (out, emulator.fault_records().to_vec())
}

/// Counts of a sound gyro and of the faulty one, with the event that has hold of each.
fn pairs(kind: FaultKind, duration_s: f64) -> Vec<(i64, i64, Option<FaultRecord>)> {
    let (faulty, records) = bytes(&every(kind, 1.0, duration_s));
    let (clean, _) = bytes(&FaultPlan::default());
    assert!(records.len() >= 8, "{kind:?}: {}", records.len());
    let holds =
        |k: u64| records.iter().copied().find(|r| (r.first_sample..=r.last_sample).contains(&k));
    let rates = |bytes: &[u8]| decoded(bytes).into_iter().map(|(_, raw)| raw).collect::<Vec<_>>();
    let both = rates(&clean).into_iter().zip(rates(&faulty));
    both.zip(0..).map(|((a, b), k)| (a, b, holds(k))).collect()
}

/// Outside events the gyro reads as if there had been none, and inside as `expected` says.
fn check(kind: FaultKind, duration_s: f64, expected: impl Fn(i64, &FaultRecord, u64) -> f64) {
    for (k, (clean, faulty, hit)) in (0..).zip(pairs(kind, duration_s)) {
        match hit {
            None => assert_eq!(clean, faulty, "{kind:?}, sample {k}"),
            Some(record) => {
                let off = faulty as f64 - expected(clean, &record, k);
                // Both are rounded to counts.
                assert!(off.abs() <= 1.0, "{kind:?}, sample {k}: off by {off}");
            }
        }
    }
}

#[test]
fn a_bias_steps_ramps_and_spikes_by_what_is_planned() {
    let rate_rad_s = datasheet::rad_s_from_deg_s(0.5);
    let counts = 0.5 / LSB_DEG_S;
    check(FaultKind::BiasStep { rate_rad_s }, 0.4, |clean, _, _| clean as f64 + counts);
    check(FaultKind::Spike { rate_rad_s }, 0.0, |clean, _, _| clean as f64 + counts);
    let ramp = FaultKind::BiasRamp { rate_rad_s2: rate_rad_s };
    check(ramp, 0.4, |clean, record, k| {
        let grown_s = (k - record.first_sample) as f64 / 300.0;
        clean as f64 + counts * grown_s
    });
}

#[test]
fn a_saturated_gyro_is_at_the_end_of_its_range() {
    let rail = FaultKind::Saturation { rail: Rail::Negative };
    check(rail, 0.2, |_, _, _| -200.0 / LSB_DEG_S);
}

#[test]
fn a_stuck_gyro_repeats_what_it_said_last() {
    let pairs = pairs(FaultKind::Stuck, 0.2);
    for window in pairs.windows(2) {
        let [(_, before, _), (clean, now, hit)] = window else { unreachable!("two samples") };
        assert_eq!(*now, if hit.is_some() { *before } else { *clean });
    }
}

#[test]
fn without_noise_a_gyro_reads_the_motion_and_with_more_of_it_scatters_more() {
    // The true rate falls and rises by 1 rad/s in 5 s; what scatters about that line is noise.
    let scatter = |factor: f64| {
        let pairs = pairs(FaultKind::NoiseChange { factor }, 0.5);
        let second = |w: &[(i64, i64, Option<FaultRecord>)]| {
            w.iter().all(|x| x.2.is_some()).then(|| (w[0].1 - 2 * w[1].1 + w[2].1) as f64)
        };
        let squares: Vec<f64> = pairs.windows(3).filter_map(second).map(|x| x * x).collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    };
    // Second differences of rounded numbers and of one bend.
    assert!(scatter(0.0) < 40.0, "{}", scatter(0.0));
    let ratio = scatter(3.0) / scatter(1.0);
    // The same draws, three times as large, rounded.
    assert!((ratio - 3.0).abs() < 0.02, "{ratio}");
}

#[test]
fn a_scale_change_is_a_share_of_the_rate_and_not_of_the_noise() {
    let pairs = pairs(FaultKind::ScaleChange { share: 0.05 }, 0.5);
    let mut compared = 0;
    for (k, (clean, faulty, hit)) in (0_u32..).zip(pairs) {
        let t_s = f64::from(k + 1) / 300.0;
        let true_rad_s = if t_s < 5.0 { 0.2 * t_s } else { 1.0 - 0.4 * (t_s - 5.0) };
        let share = if hit.is_some() { 0.05 } else { 0.0 };
        let expected = share * true_rad_s.to_degrees() / LSB_DEG_S;
        assert!(((faulty - clean) as f64 - expected).abs() <= 1.0, "sample {k}");
        compared += u32::from(hit.is_some());
    }
    assert!(compared > 1000);
}

#[test]
fn one_by_one_or_in_blocks_the_bytes_are_the_same() {
    let plan = every(FaultKind::Burst { bytes: 20 }, 0.05, 0.0);
    let (whole, records) = bytes(&plan);
    let mut emulator = emulator(&plan);
    let mut singly = Vec::new();
    for _ in 0..FRAMES {
        let mut one = Vec::new();
        emulator.emit(&mut one).unwrap();
        singly.extend(one);
    }
    emulator.finish(&mut |_| {});
    assert!(whole == singly);
    assert_eq!(records, emulator.fault_records());
    assert!(records.iter().all(|r| r.start >= seconds(0.05)));
}
