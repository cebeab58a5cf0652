//! Faults of time, and of the line between.

use crate::bench::{every, faulty, grid, seconds};
use struna_harness::fault::{Dispatch, FaultKind};
use struna_harness::{LineEvent, LinePath};
use struna_kernel::{Seed, SimTime};
use struna_line::{LineModel, LineSettings};

const FRAMES: u64 = 3000;

/// By how much each sample is late, ns, and whether an event has hold of it.
fn lateness(kind: FaultKind, period_s: f64, duration_s: f64) -> Vec<(i64, bool)> {
    let run = faulty(&every(kind, period_s, duration_s), FRAMES, Seed(1));
    assert!(run.records.len() >= 3, "{kind:?}");
    assert!(run.bytes() == run.clean, "{kind:?} changes no byte");
    let late = |(k, ready): (u64, SimTime)| {
        let ns = ready.as_ns() - grid().time_of(k + 1).as_ns();
        (ns, run.records.iter().any(|r| (r.first_sample..=r.last_sample).contains(&k)))
    };
    (0..FRAMES).zip(run.sent.iter().map(|sent| sent.ready)).map(late).collect()
}

#[test]
fn a_delay_lasts_as_long_as_its_event() {
    // Less than a sample period, so that no sample waits for the one before it.
    for (late_ns, hit) in lateness(FaultKind::Delay { delay_s: 2e-3 }, 2.0, 0.5) {
        assert_eq!(late_ns, if hit { 2_000_000 } else { 0 });
    }
}

#[test]
fn jitter_is_uniform_up_to_its_maximum() {
    let late = lateness(FaultKind::Jitter { delay_max_s: 3e-3 }, 2.0, 1.0);
    let hit: Vec<f64> = late.iter().filter(|(_, hit)| *hit).map(|(ns, _)| *ns as f64).collect();
    assert!(late.iter().all(|(ns, hit)| *hit || *ns == 0));
    assert!(hit.iter().all(|ns| (0.0..=3e6).contains(ns)));
    let mean = hit.iter().sum::<f64>() / hit.len() as f64;
    // Four standard errors of the mean of a uniform number.
    assert!((mean - 1.5e6).abs() < 4.0 * 3e6 / (12.0 * hit.len() as f64).sqrt(), "{mean}");
}

#[test]
fn a_clock_that_has_jumped_stays_behind() {
    let late = lateness(FaultKind::ClockJump { jump_s: 0.03 }, 2.0, 0.0);
    let mut jumps = 0;
    for (late_ns, hit) in late {
        jumps += i64::from(hit);
        assert_eq!(late_ns, jumps * 30_000_000);
    }
}

#[test]
fn a_drift_grows_with_its_event_and_stays() {
    let late = lateness(FaultKind::ClockDrift { share: 2e-3 }, 3.0, 1.0);
    let mut hits = 0;
    for (late_ns, hit) in late {
        hits += i64::from(hit);
        let expected_ns = hits as f64 * 2e-3 * 1e9 / 300.0;
        // Rounding to whole nanoseconds, of the lateness and of the grid.
        assert!((late_ns as f64 - expected_ns).abs() <= 2.0, "{late_ns} {expected_ns}");
    }
}

#[test]
fn a_wrong_baud_rate_changes_the_length_of_bytes_and_beyond_four_per_cent_their_values() {
    let slow = faulty(&every(FaultKind::BaudError { share: -0.02 }, 2.0, 0.5), FRAMES, Seed(2));
    assert!(slow.bytes() == slow.clean);
    let wrong = faulty(&every(FaultKind::BaudError { share: 0.08 }, 2.0, 0.5), FRAMES, Seed(2));
    assert!(wrong.bytes() != wrong.clean);
    for (k, sent) in (0..).zip(&slow.sent) {
        let hit = slow.records.iter().any(|r| (r.first_sample..=r.last_sample).contains(&k));
        assert!((sent.baud_ratio - if hit { 0.98 } else { 1.0 }).abs() < 1e-12);
    }
    // 11 bytes of 10 symbols at 0.98 times 115200 baud.
    let mut path = LinePath::new(LineModel::new(LineSettings::direct(115_200.0)));
    let mut arrived = Vec::new();
    for (ready, baud_ratio) in [(seconds(1.0), 0.98), (seconds(2.0), 1.0)] {
        let dispatch = Dispatch::Bytes { ready, baud_ratio, bytes: &[0x55; 11] };
        path.carry(dispatch, &mut |time, _| arrived.push(time.as_ns() - ready.as_ns()));
    }
    assert_eq!(arrived, [974_348, 954_861]);
}

#[test]
fn bytes_in_a_bridge_are_lost_when_it_is_unplugged() {
    let mut path = LinePath::new(LineModel::new(struna::faults::Stream::Vg.line()));
    let mut events = Vec::new();
    let mut note = |time: SimTime, event: LineEvent<'_>| {
        events.push((
            time.as_ns() / 1_000_000,
            match event {
                LineEvent::Bytes(bytes) => bytes.len(),
                LineEvent::Unplugged => 1000,
                LineEvent::Plugged => 2000,
            },
        ));
    };
    let send = |s: f64| Dispatch::Bytes { ready: seconds(s), baud_ratio: 1.0, bytes: &[1; 11] };
    path.carry(send(0.001), &mut note);
    path.carry(send(0.020), &mut note);
    path.carry(Dispatch::Unplugged(seconds(0.022)), &mut note);
    path.carry(Dispatch::Plugged(seconds(0.050)), &mut note);
    path.carry(send(0.060), &mut note);
    path.flush(&mut note);
    // The timer runs out every 16 ms: at 16, 32, 48, 64.
    assert_eq!(events, [(16, 11), (22, 1000), (50, 2000), (64, 11)]);
}
