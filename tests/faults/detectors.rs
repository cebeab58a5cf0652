//! The detectors on their three streams.

use crate::bench::seconds;
use std::sync::OnceLock;
use struna::faults::{Ablation, Case, Matrix, Row, Stream, Suite, cases, run, trial};
use struna_harness::fault::{Fault, FaultKind, FaultPlan, Stage, Trigger};
use struna_harness::monitor::{Declared, Detector, Limits, Observability, observability};
use struna_kernel::Seed;

use Detector::{Check, Clock, Gap, Innovation, Rate, Repeat, Saturation, Step, Stuck, Variance};

fn suite() -> Suite {
    Suite {
        streams: Stream::ALL.to_vec(),
        byte_events: 60,
        short_events: 24,
        long_events: 6,
        clean_hours: 0.2,
        seed: Seed(20),
    }
}

fn matrix() -> &'static Matrix {
    static MATRIX: OnceLock<Matrix> = OnceLock::new();
    MATRIX.get_or_init(|| run(&suite(), 2, &|_, _| {}).unwrap())
}

fn row(stream: Stream, kind: &str) -> &'static Row {
    let streams = &matrix().streams;
    let of = streams.iter().find(|matrix| matrix.stream == stream).unwrap();
    of.rows.iter().find(|row| row.case.kind.name() == kind).unwrap()
}

/// Recall of `detector` for a fault on the three streams, `None` where nothing is claimed.
type Expected = (&'static str, Detector, [Option<f64>; 3]);

const ALL: [Option<f64>; 3] = [Some(1.0); 3];
const COUNTED: [Option<f64>; 3] = [Some(1.0), Some(1.0), Some(0.0)];
const NONE: [Option<f64>; 3] = [Some(0.0); 3];

/// The table to be regenerated, but for what depends on the phase of the motion.
const EXPECTED: &[Expected] = &[
    ("byte-drop", Check, ALL),
    ("byte-drop", Gap, COUNTED),
    ("bit-flip", Check, ALL),
    ("bit-flip", Gap, COUNTED),
    ("duplicate-byte", Check, ALL),
    // Of the first or of the last byte, the frame is whole all the same: 9 of 11, 5 of 7.
    ("duplicate-byte", Gap, [Some(9.0 / 11.0), Some(5.0 / 7.0), Some(0.0)]),
    ("inserted-byte", Check, ALL),
    // Before the first or behind the last: 10 of 12 places, 6 of 8.
    ("inserted-byte", Gap, [Some(10.0 / 12.0), Some(6.0 / 8.0), Some(0.0)]),
    ("burst", Check, ALL),
    ("burst", Gap, COUNTED),
    ("truncated-frame", Check, ALL),
    ("truncated-frame", Gap, COUNTED),
    ("wrong-value", Check, NONE),
    ("wrong-value", Step, ALL),
    ("wrong-value", Innovation, ALL),
    ("swapped-frames", Gap, COUNTED),
    ("swapped-frames", Repeat, COUNTED),
    ("duplicated-frame", Repeat, COUNTED),
    ("duplicated-frame", Check, NONE),
    ("stuck", Stuck, ALL),
    ("saturation", Saturation, ALL),
    ("saturation", Stuck, ALL),
    ("saturation", Step, ALL),
    ("bias-step", Step, [Some(0.0), Some(1.0), Some(0.0)]),
    ("bias-step", Innovation, [Some(0.0), Some(1.0), Some(0.0)]),
    ("bias-ramp", Step, [Some(0.0), Some(1.0), Some(0.0)]),
    ("noise-change", Variance, ALL),
    // Noise of two poles hardly changes from one sample to the next, even three times as large.
    ("noise-change", Step, NONE),
    ("noise-change", Innovation, [Some(0.0), Some(1.0), Some(0.0)]),
    ("spike", Step, ALL),
    ("spike", Innovation, ALL),
    ("dropout", Gap, COUNTED),
    ("dropout", Rate, ALL),
    ("clock-drift", Clock, ALL),
    // Silent for longer than 50 ms, a stream without a counter has to be counted anew.
    ("clock-jump", Clock, [Some(1.0), Some(1.0), None]),
    ("delay", Clock, ALL),
];

#[test]
fn recall_is_that_of_the_table() {
    for (kind, detector, recalls) in EXPECTED {
        for (stream, expected) in Stream::ALL.into_iter().zip(recalls) {
            let Some(expected) = expected else { continue };
            let row = row(stream, kind);
            let found = row.recall(*detector);
            let n = f64::from(row.events);
            // Four deviations of a binomial share, and the 0.03 that figures were given with.
            let tolerance = 0.03 + 4.0 * (expected * (1.0 - expected) / n).sqrt();
            assert!(
                (found - expected).abs() <= tolerance,
                "{} on {}: {} finds {found:.2} of {n}, not {expected:.2}",
                kind,
                stream.name(),
                detector.name(),
            );
        }
    }
}

#[test]
fn clean_streams_raise_no_alarm() {
    for stream in &matrix().streams {
        assert_eq!(stream.clean.alarms, [0; 11], "{}", stream.stream.name());
    }
}

#[test]
fn each_of_the_seven_parts_alone_finds_something() {
    for (k, (part, _)) in Ablation::PARTS.iter().enumerate() {
        let mut rows = matrix().streams.iter().flat_map(|stream| &stream.rows);
        assert!(rows.any(|row| row.ablation.is_lost_without(k, row.events)), "{part}");
    }
}

#[test]
fn what_cannot_be_seen_is_said_before_the_run_and_nobody_else_finds_it() {
    for (stream, kind) in [
        (Stream::Weak, "swapped-frames"),
        (Stream::Weak, "duplicated-frame"),
        (Stream::Vg, "bias-step"),
        (Stream::Vg, "bias-ramp"),
        (Stream::Vg, "scale-change"),
        (Stream::Adis, "scale-change"),
        (Stream::Vg, "jitter"),
    ] {
        let row = row(stream, kind);
        assert!(matches!(row.observability, Observability::NotObservable(_)), "{kind}");
    }
    for stream in &matrix().streams {
        for row in &stream.rows {
            let found = f64::from(row.ablation.all) / f64::from(row.events);
            if row.observability == Observability::Observable {
                let name = row.case.kind.name();
                assert!(found > 0.95, "{name} on {}: {found}", stream.stream.name());
            }
        }
    }
    let text = matrix().to_string();
    assert!(text.contains("not observable: no counter"), "{text}");
    assert!(text.lines().all(|line| line.chars().count() <= 120), "{text}");
}

#[test]
fn one_seed_makes_one_table_on_any_number_of_threads() {
    let tiny = Suite {
        streams: vec![Stream::Weak],
        byte_events: 5,
        short_events: 3,
        long_events: 1,
        clean_hours: 0.01,
        seed: Seed(3),
    };
    let alone = run(&tiny, 1, &|_, _| {}).unwrap();
    assert_eq!(alone, run(&tiny, 3, &|_, _| {}).unwrap());
}

#[test]
fn twelve_seconds_after_a_fault_nothing_is_alarmed_any_more() {
    for stream in [Stream::Vg, Stream::Weak] {
        for case in cases(stream) {
            let once =
                |case: &Case| Fault { trigger: Trigger::At(seconds(15.0)), ..case.fault(15.0) };
            let plan = FaultPlan::new(vec![once(&case)]).unwrap();
            let trial = trial(stream, &plan, 42.0, Seed(5), 0).unwrap();
            assert_eq!(trial.records.len(), 1, "{case:?}");
            let end = trial.records[0].end;
            for alarm in &trial.alarms {
                let late_s = alarm.until.seconds_since(end);
                assert!(late_s <= 12.0, "{} on {}: {alarm}", case.kind.name(), stream.name());
            }
        }
    }
}

#[test]
fn limits_follow_from_what_is_declared() {
    let limits = |change: fn(&mut Declared)| {
        let mut declared = Stream::Vg.declared();
        change(&mut declared);
        Limits::of(&declared).unwrap()
    };
    let plain = limits(|_| {});
    assert!(limits(|d| d.acceleration_max_rad_s2 *= 2.0).step_rad_s > 1.6 * plain.step_rad_s);
    let noisy = limits(|d| d.noise_sigma_rad_s *= 10.0);
    assert!(noisy.innovation_rad_s > plain.innovation_rad_s && noisy.step_rad_s > plain.step_rad_s);
    assert_eq!(plain.stuck_samples, Some(5));
    // Noise of a third of a count: the middle count holds nine samples in ten.
    let coarse = limits(|d| d.lsb_rad_s = 3.0 * d.noise_sigma_rad_s);
    assert!(coarse.stuck_samples.is_some_and(|samples| samples > 50), "{coarse:?}");
    assert_eq!(limits(|d| d.lsb_rad_s = 100.0 * d.noise_sigma_rad_s).stuck_samples, None);
    // On the coarse gyro some thirty equal samples come in a day; once in 1000 h is more, and less
    // than the tenth of a second that would be noticed.
    let adis = Limits::of(&Stream::Adis.declared()).unwrap();
    assert!(adis.stuck_samples.is_some_and(|n| (30..140).contains(&n)), "{adis:?}");
}

#[test]
fn every_kind_has_a_stage_and_is_tried() {
    let tried: Vec<_> = cases(Stream::Vg).iter().map(|case| case.kind.name()).collect();
    for name in ["byte-drop", "swapped-frames", "stuck", "port-loss", "baud-error", "clock-jump"] {
        assert!(tried.contains(&name), "{name}");
    }
    assert_eq!(FaultKind::Dropout.stage(), Stage::Line);
    let fault = cases(Stream::Vg)[0].fault(1.0);
    let (declared, vg) = (Stream::Vg.declared(), Limits::of(&Stream::Vg.declared()).unwrap());
    assert_eq!(observability(&fault, &declared, &vg), Observability::Observable);
}
