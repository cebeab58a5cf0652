//! Faults of bytes and frames, replayed from their records alone.

use crate::bench::{Faulty, decoded, every, faulty, raw_rate, seconds};
use proptest::prelude::*;
use struna_harness::fault::{Fault, FaultKind, FaultPlan, FaultRecord, Trigger, write_fault_csv};
use struna_kernel::Seed;

const FRAMES: u64 = 3000;
const LEN: usize = 11;

fn place(byte: u64) -> usize {
    usize::try_from(byte).unwrap()
}

/// What `record` says has become of the frame that begins at `from`, which is `clean`.
fn replayed(record: &FaultRecord, clean: &[u8]) -> Vec<u8> {
    let (from, len) = (place(record.first_sample) * LEN, clean.len());
    let at = place(record.clean_bytes.0) - from;
    let mut frame = clean.to_vec();
    match record.kind {
        FaultKind::ByteDrop => {
            frame.remove(at);
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a bit")]
        FaultKind::BitFlip => frame[at] ^= 1 << record.magnitude as u8,
        FaultKind::DuplicateByte => frame.insert(at, clean[at]),
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a length")]
        FaultKind::Truncated => frame.truncate(record.magnitude as usize),
        FaultKind::DuplicatedFrame => frame.extend_from_slice(clean),
        FaultKind::Dropout | FaultKind::PortLoss => frame.clear(),
        _ => unreachable!("{record:?} of {len} bytes is not replayed"),
    }
    frame
}

/// The whole stream as the records say it was sent.
fn replay(run: &Faulty) -> Vec<u8> {
    let mut out = Vec::new();
    for (k, clean) in run.clean.chunks(LEN).enumerate() {
        let k = k as u64;
        let hit = run.records.iter().find(|r| (r.first_sample..=r.last_sample).contains(&k));
        match hit {
            Some(record) => {
                let mut here = *record;
                (here.first_sample, here.clean_bytes.0) =
                    if record.first_sample == k { (k, record.clean_bytes.0) } else { (k, k * 11) };
                out.extend(replayed(&here, clean));
            }
            None => out.extend_from_slice(clean),
        }
    }
    out
}

#[test]
fn what_is_sent_is_what_the_records_say() {
    for kind in [
        FaultKind::ByteDrop,
        FaultKind::BitFlip,
        FaultKind::DuplicateByte,
        FaultKind::Truncated,
        FaultKind::DuplicatedFrame,
    ] {
        let run = faulty(&every(kind, 0.1, 0.0), FRAMES, Seed(3));
        assert!(run.records.len() > 80, "{kind:?}: {} events", run.records.len());
        assert!(run.bytes() == replay(&run), "{kind:?}");
        assert_ne!(run.bytes(), run.clean, "{kind:?}");
    }
    for kind in [FaultKind::Dropout, FaultKind::PortLoss] {
        let run = faulty(&every(kind, 0.5, 0.05), FRAMES, Seed(3));
        assert!(run.bytes() == replay(&run), "{kind:?}");
        assert!(run.records.iter().all(|r| (14..=16).contains(&(r.last_sample - r.first_sample))));
        let changes = if kind == FaultKind::PortLoss { 2 * run.records.len() } else { 0 };
        assert_eq!(run.ports.len(), changes);
    }
}

#[test]
fn an_inserted_byte_taken_out_again_leaves_the_clean_stream() {
    let run = faulty(&every(FaultKind::InsertedByte, 0.1, 0.0), FRAMES, Seed(4));
    let mut bytes = run.bytes();
    for record in run.records.iter().rev() {
        bytes.remove(place(record.sent_bytes.0));
    }
    assert!(bytes == run.clean);
    // Before the first byte, behind the last and everywhere between.
    let places: Vec<_> =
        run.records.iter().map(|r| r.clean_bytes.0 - r.first_sample * 11).collect();
    assert!((0..=11).all(|place| places.contains(&place)), "{places:?}");
}

#[test]
fn a_burst_changes_every_byte_it_names_and_no_other_over_frame_ends_too() {
    let run = faulty(&every(FaultKind::Burst { bytes: 8 }, 0.1, 0.0), FRAMES, Seed(5));
    let (sent, mut expected) = (run.bytes(), vec![false; run.clean.len()]);
    for record in &run.records {
        let (from, to) = record.clean_bytes;
        assert_eq!(to - from, 8);
        expected[place(from)..place(to)].fill(true);
    }
    let changed: Vec<bool> = sent.iter().zip(&run.clean).map(|(a, b)| a != b).collect();
    assert!(changed == expected);
    assert!(run.records.iter().any(|r| r.last_sample > r.first_sample));
}

#[test]
fn swapped_frames_come_in_the_other_order_and_nothing_is_lost() {
    let run = faulty(&every(FaultKind::SwappedFrames, 0.1, 0.0), FRAMES, Seed(6));
    let mut frames: Vec<&[u8]> = run.clean.chunks(LEN).collect();
    for record in &run.records {
        let k = place(record.first_sample);
        if k + 1 < frames.len() {
            frames.swap(k, k + 1);
        }
    }
    assert!(run.bytes() == frames.concat());
}

#[test]
fn a_wrong_value_is_the_recorded_one_under_a_check_that_holds() {
    let run = faulty(&every(FaultKind::WrongValue, 0.1, 0.0), FRAMES, Seed(7));
    let frames = decoded(&run.bytes());
    assert_eq!(frames.len() as u64, FRAMES);
    let mut values = Vec::new();
    for (index, raw) in frames {
        match run.records.iter().find(|r| r.first_sample == index) {
            Some(record) => {
                #[expect(clippy::cast_possible_truncation, reason = "a whole number")]
                let drawn = record.magnitude as i64;
                assert_eq!(raw, drawn);
                values.push(drawn);
            }
            None => assert_eq!(raw, raw_rate(index)),
        }
    }
    // Over the whole range, not about the truth.
    assert!(values.iter().any(|v| *v > 4_000_000) && values.iter().any(|v| *v < -4_000_000));
}

#[test]
fn bytes_are_hit_at_the_declared_rate() {
    let trigger = Trigger::PerByte { rate_per_byte: 0.01 };
    let fault = Fault { kind: FaultKind::BitFlip, trigger, duration: seconds(0.0) };
    let run = faulty(&FaultPlan::new(vec![fault]).unwrap(), FRAMES, Seed(8));
    let changed = run.bytes().iter().zip(&run.clean).filter(|(a, b)| a != b).count();
    assert_eq!(changed, run.records.len());
    // 33 000 bytes, mean 1 % of each: about 327 hits; four deviations of a Poisson number.
    let expected = 33_000.0 / 101.0;
    assert!((changed as f64 - expected).abs() < 4.0 * f64::sqrt(expected), "{changed}");
}

#[test]
fn random_events_come_at_the_declared_rate() {
    let fault = Fault {
        kind: FaultKind::BitFlip,
        trigger: Trigger::Random { rate_hz: 10.0 },
        duration: seconds(0.0),
    };
    let run = faulty(&FaultPlan::new(vec![fault]).unwrap(), 30 * FRAMES, Seed(9));
    let events = run.records.len() as f64;
    // 300 s at 10 Hz; four deviations of a Poisson number.
    assert!((events - 3000.0).abs() < 4.0 * 3000.0_f64.sqrt(), "{events}");
}

#[test]
fn one_seed_makes_one_stream_and_a_fault_added_at_the_end_leaves_the_others_alone() {
    let fault =
        |kind| Fault { kind, trigger: Trigger::Random { rate_hz: 5.0 }, duration: seconds(0.0) };
    let one = FaultPlan::new(vec![fault(FaultKind::BitFlip)]).unwrap();
    let two = vec![fault(FaultKind::BitFlip), fault(FaultKind::DuplicatedFrame)];
    let two = FaultPlan::new(two).unwrap();
    let run = faulty(&one, FRAMES, Seed(10));
    assert_eq!(run, faulty(&one, FRAMES, Seed(10)));
    assert_ne!(run.records, faulty(&one, FRAMES, Seed(11)).records);
    let both = faulty(&two, FRAMES, Seed(10)).records;
    let key = |r: &FaultRecord| (r.first_sample, r.clean_bytes, r.magnitude.to_bits());
    let first: Vec<_> = both.iter().filter(|r| r.fault == 0).map(key).collect();
    assert_eq!(first, run.records.iter().map(key).collect::<Vec<_>>());
    assert!(both.len() > first.len());
}

#[test]
fn the_sidecar_has_a_line_for_each_event_and_units_in_its_columns() {
    let run = faulty(&every(FaultKind::Dropout, 0.5, 0.05), FRAMES, Seed(3));
    let mut out = Vec::new();
    write_fault_csv(&run.records, &mut out).unwrap();
    let text = String::from_utf8(out).unwrap();
    let mut lines = text.lines();
    let columns = lines.next().unwrap().split(',').count();
    assert!(text.starts_with("id,fault,kind,stage,start_s,end_s,first_sample"));
    assert_eq!(lines.clone().count(), run.records.len());
    assert!(lines.all(|line| line.split(',').count() == columns && line.contains("dropout,line")));
}

fn any_kind() -> impl Strategy<Value = FaultKind> {
    prop_oneof![
        Just(FaultKind::ByteDrop),
        Just(FaultKind::BitFlip),
        Just(FaultKind::DuplicateByte),
        Just(FaultKind::InsertedByte),
        (1_u32..40).prop_map(|bytes| FaultKind::Burst { bytes }),
        Just(FaultKind::Truncated),
        Just(FaultKind::WrongValue),
        Just(FaultKind::SwappedFrames),
        Just(FaultKind::DuplicatedFrame),
        (-0.2_f64..0.2).prop_map(|share| FaultKind::BaudError { share }),
        Just(FaultKind::Dropout),
        Just(FaultKind::PortLoss),
        (0.0..0.1_f64).prop_map(|delay_s| FaultKind::Delay { delay_s }),
        (-0.5..0.5_f64).prop_map(|share| FaultKind::ClockDrift { share }),
    ]
}

proptest! {
    #[test]
    fn any_faults_together_are_carried_out_in_order_of_time(
        kinds in proptest::collection::vec(any_kind(), 1..8),
        seed in any::<u64>(),
    ) {
        let faults = kinds.iter().map(|kind| Fault {
            kind: *kind,
            trigger: Trigger::Random { rate_hz: 8.0 },
            duration: seconds(0.03),
        });
        let run = faulty(&FaultPlan::new(faults.collect()).unwrap(), 300, Seed(seed));
        prop_assert!(run.sent.windows(2).all(|w| w[0].ready <= w[1].ready));
        prop_assert!(run.sent.iter().all(|sent| !sent.bytes.is_empty()));
        prop_assert!(run.records.windows(2).all(|w| w[0].id < w[1].id));
        prop_assert!(run.records.iter().all(|r| r.start <= r.end));
        // Each fault of frames or bytes at most doubles a frame: nothing piles up.
        let most = run.clean.len() << kinds.len();
        prop_assert!(run.bytes().len() <= most.min(64 * run.clean.len()));
        // And the truth says how much was sent.
        prop_assert!(run.records.iter().all(|r| r.sent_bytes.1 <= run.bytes().len() as u64));
    }
}
