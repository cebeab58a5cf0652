//! Which sample a frame is, when its counter alone cannot tell.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use struna_harness::clock::{Basis, Heard, Resolved, Resolver, TimeBase, TimeBaseSettings};
use struna_kernel::SimTime;

const PERIOD_S: f64 = 0.003_333;

/// Resolver and time base in a row, fed with samples of a steady gyro.
struct Line {
    resolver: Resolver,
    base: TimeBase,
    modulus: Option<u64>,
    heard: u64,
    last_counter: Option<u64>,
}

impl Line {
    fn new(modulus: Option<u64>) -> Self {
        let base = TimeBase::new(TimeBaseSettings::new(PERIOD_S, 0.03));
        Self { resolver: Resolver::new(modulus), base, modulus, heard: 0, last_counter: None }
    }

    /// Sample `k` arrives `late_s` after it was taken, with counter `counter`.
    fn frame(&mut self, k: u64, late_s: f64, silent_s: Option<f64>, outage: bool) -> Resolved {
        self.frame_with(k, k, late_s, silent_s, outage)
    }

    fn frame_with(
        &mut self,
        k: u64,
        counter: u64,
        late_s: f64,
        silent_s: Option<f64>,
        outage: bool,
    ) -> Resolved {
        // What the decoder makes of it.
        self.heard += match (self.modulus, self.last_counter) {
            (Some(modulus), Some(last)) => (counter + modulus - last % modulus) % modulus,
            _ => 1,
        };
        self.last_counter = Some(counter);
        let arrival = SimTime::from_s(10.0 + k as f64 * PERIOD_S + late_s).unwrap();
        let silent_until = silent_s.map(|s| SimTime::from_ns(arrival.as_ns() - ns(s)));
        let heard = Heard { index: self.heard, arrival, silent_until, after_outage: outage };
        let resolved = self.resolver.resolve(&heard, &self.base);
        self.base.observe(resolved.index, arrival);
        resolved
    }

    /// Ten seconds of undisturbed samples.
    fn settled(modulus: Option<u64>) -> Self {
        let mut line = Self::new(modulus);
        for k in 0..3000 {
            let resolved = line.frame(k, 0.0, None, false);
            assert_eq!(resolved, Resolved { index: k, lost: 0, basis: Basis::Counter });
        }
        assert!(line.base.is_settled());
        line
    }
}

fn ns(seconds: f64) -> i64 {
    SimTime::from_s(seconds).unwrap().as_ns()
}

#[test]
fn losses_of_whole_turns_of_the_counter_are_told_by_the_silence() {
    for lost in [1_u64, 100, 254, 256, 300, 512, 1000, 100_000] {
        let mut line = Line::settled(Some(256));
        let k = 2999 + lost + 1;
        // The line was seen silent until 15 ms before, as a read of 20 ms shows it.
        let resolved = line.frame(k, 0.0, Some(0.015), false);
        assert_eq!((resolved.index, resolved.lost), (k, lost));
        let whole_turns = (lost + 1) / 256 > 0;
        assert_eq!(resolved.basis == Basis::CounterAndTime, whole_turns, "{lost}");
    }
}

#[test]
fn a_host_held_up_loses_nothing() {
    let mut line = Line::settled(Some(256));
    // Three seconds of backlog read at once: no silence was seen.
    for k in 3000..3900 {
        let late_s = (3900 - k) as f64 * PERIOD_S;
        assert_eq!(line.frame(k, late_s, None, false).index, k);
    }
}

#[test]
fn after_an_outage_the_time_gone_tells_the_turns() {
    let mut line = Line::settled(Some(256));
    let resolved = line.frame(50_000, 0.010, None, true);
    assert_eq!((resolved.index, resolved.lost), (50_000, 47_000));
    assert_eq!(line.frame(50_001, 0.0, None, false).index, 50_001);
}

#[test]
fn a_counter_that_began_anew_is_numbered_by_time() {
    let mut line = Line::settled(Some(1 << 16));
    let resolved = line.frame_with(6000, 0, 0.0, None, true);
    assert_eq!((resolved.index, resolved.basis), (6000, Basis::Restarted));
    assert_eq!(line.frame_with(6001, 1, 0.0, None, false).index, 6001);
}

#[test]
fn without_a_counter_a_silence_is_counted_at_once() {
    let mut line = Line::settled(None);
    let resolved = line.frame(3500, 0.0002, Some(0.015), false);
    assert_eq!(resolved, Resolved { index: 3500, lost: 500, basis: Basis::Inferred });
}

#[test]
fn without_a_counter_a_short_loss_is_inferred_once_frames_stay_late() {
    let mut line = Line::settled(None);
    // Two samples lost; the rest comes with delays up to a period, as bursts have them.
    let mut index = 0;
    let mut inferred = 0;
    for k in 3002..3102_u64 {
        let late_s = (k % 5) as f64 * 0.0007;
        let resolved = line.frame(k, late_s, None, false);
        inferred += u64::from(resolved.basis == Basis::Inferred);
        index = resolved.index;
    }
    assert_eq!((index, inferred), (3101, 1));
}

#[test]
fn without_a_counter_delays_are_no_losses() {
    let mut line = Line::settled(None);
    for k in 3000..6000_u64 {
        // Bursts of five, and now and then 40 ms late.
        let spike_s = if k % 100 == 0 { 0.04 } else { 0.0 };
        let resolved = line.frame(k, (4 - k % 5) as f64 * PERIOD_S + spike_s, None, false);
        assert_eq!(resolved.index, k);
    }
}
