//! How well sample times are found behind lines that delay them: the sliding hull and its peers.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
#![expect(clippy::print_stdout, reason = "measured figures, for whoever asks with --nocapture")]

mod cases;
mod peers;

use cases::{CASES, Case, Random, SKEW, Sample};
use struna_harness::clock::{Observed, TimeBase, TimeBaseSettings};
use struna_kernel::SimTime;

/// Everything a settled window needs has happened by then.
const WARM_S: f64 = 130.0;
const RUN_S: f64 = 310.0;

/// The deviation from its mean: a constant delay cannot be seen by anybody.
fn deviation_us(errors_s: &[f64]) -> f64 {
    let count = errors_s.len() as f64;
    let mean = errors_s.iter().sum::<f64>() / count;
    (errors_s.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / count).sqrt() * 1e6
}

/// What the sliding hull made of a stream after [`WARM_S`].
struct Sliding {
    errors_s: Vec<f64>,
    skew_error_max_ppm: f64,
    /// Largest error of the skew as a multiple of its claimed uncertainty.
    skew_sigmas_max: f64,
}

fn sliding(case: &Case, samples: &[Sample], window_s: f64) -> Sliding {
    let window = SimTime::from_s(window_s).unwrap();
    let settle = SimTime::from_s(window_s.min(5.0) * 0.9).unwrap();
    let settings = TimeBaseSettings::new(case.period_s(), 0.03);
    let mut base = TimeBase::new(TimeBaseSettings { window, settle, ..settings });
    let mut found = Sliding { errors_s: Vec::new(), skew_error_max_ppm: 0.0, skew_sigmas_max: 0.0 };
    for s in samples {
        base.observe(s.index, s.arrival);
        if s.taken_s < WARM_S {
            continue;
        }
        found.errors_s.push(base.time_of(s.index, s.arrival).as_s() - s.taken_s);
        if s.index % 97 == 0 {
            let skew = base.skew().unwrap();
            let off_ppm = (skew.ppm - SKEW * 1e6).abs();
            found.skew_error_max_ppm = found.skew_error_max_ppm.max(off_ppm);
            found.skew_sigmas_max = found.skew_sigmas_max.max(off_ppm / skew.sigma_ppm);
        }
    }
    found
}

/// One line of the table: deviations in us.
struct Row {
    name: &'static str,
    arrival: f64,
    least_squares: f64,
    batch_hull: f64,
    olson: f64,
    locked_loop: f64,
    /// Windows of 5, 20 and 60 s.
    sliding: [f64; 3],
    /// Largest error of the skew, ppm, in a window of 60 s.
    skew_ppm: f64,
    skew_sigmas: f64,
}

fn row(case: &Case, seed: u64) -> Row {
    let samples = case.samples(RUN_S, seed);
    let warm = samples.partition_point(|s| s.taken_s < WARM_S);
    let batch = &samples[..samples.partition_point(|s| s.taken_s < 120.0)];
    let windows = [5.0, 20.0, 60.0].map(|window_s| sliding(case, &samples, window_s));
    let period_s = case.period_s();
    Row {
        name: case.name,
        arrival: deviation_us(&peers::arrival(&samples[warm..])),
        least_squares: deviation_us(&peers::least_squares(batch)),
        batch_hull: deviation_us(&peers::batch_hull(batch, period_s)),
        olson: deviation_us(&peers::olson(&samples, period_s, 200e-6)[warm..]),
        locked_loop: deviation_us(&peers::locked_loop(&samples, period_s, 0.005)[warm..]),
        sliding: [0, 1, 2].map(|k| deviation_us(&windows[k].errors_s)),
        skew_ppm: windows[2].skew_error_max_ppm,
        skew_sigmas: windows[2].skew_sigmas_max,
    }
}

fn print(row: &Row) {
    let [w5, w20, w60] = row.sliding;
    println!(
        "{:18} {:8.0} {:6.1} {:8.2} {:7.1} {:7.0} {w5:8.1} {w20:8.1} {w60:8.2} {:8.2}",
        row.name,
        row.arrival,
        row.least_squares,
        row.batch_hull,
        row.olson,
        row.locked_loop,
        row.skew_ppm,
    );
}

/// Deviations allowed to the sliding hull of 60 s, us: about twice the largest of three streams.
const SLIDING_US_MAX: [f64; 4] = [0.1, 20.0, 5.0, 15.0];
/// The same for the batch of 120 s.
const BATCH_US_MAX: [f64; 4] = [0.1, 7.5, 3.9, 8.0];

/// `cargo test -p struna-harness --test time_base -- --nocapture` prints the table.
#[test]
fn the_sliding_hull_finds_sample_times_better_than_its_peers() {
    println!("deviation of the sample time, us, and largest error of the skew, ppm");
    println!(
        "{:18} {:>8} {:>6} {:>8} {:>7} {:>7} {:>8} {:>8} {:>8} {:>8}",
        "case", "arrival", "OLS", "hull 120", "Olson", "loop", "W=5 s", "W=20 s", "W=60 s", "skew"
    );
    for (case, k) in CASES.iter().zip(0..) {
        for seed in [7, 8, 9] {
            let row = row(case, seed);
            print(&row);
            let ours = row.sliding[2];
            assert!(ours < SLIDING_US_MAX[k], "{}: {ours} us", row.name);
            assert!(row.batch_hull < BATCH_US_MAX[k], "{}: batch {} us", row.name, row.batch_hull);
            // Of those that, like ours, know the past alone.
            for peer in [row.arrival, row.olson, row.locked_loop] {
                assert!(3.0 * ours < peer, "{}: {ours} us beside {peer} us", row.name);
            }
            assert!(row.skew_ppm < 5.0, "{}: skew off by {} ppm", row.name, row.skew_ppm);
            assert!(row.skew_sigmas < 3.0, "{}: {} sigmas", row.name, row.skew_sigmas);
        }
    }
}

fn base_of(case: &Case) -> TimeBase {
    TimeBase::new(TimeBaseSettings::new(case.period_s(), 0.03))
}

#[test]
fn arrivals_are_passed_on_until_they_span_five_seconds() {
    let case = &CASES[0];
    let mut base = base_of(case);
    for s in case.samples(10.0, 1) {
        base.observe(s.index, s.arrival);
        // The block that completes the five seconds may be as long as 1/256 of the window, and
        // a spike late.
        if s.taken_s < 5.0 {
            assert!(!base.is_settled() && base.skew().is_none());
            assert_eq!(base.time_of(s.index, s.arrival), s.arrival);
        } else if s.taken_s > 5.3 {
            assert!(base.is_settled());
        }
    }
}

#[test]
fn a_declared_latency_is_taken_off() {
    let case = &CASES[0];
    let latency = SimTime::from_ns(125_000);
    let settings = TimeBaseSettings::new(case.period_s(), 0.03);
    let (mut plain, mut less) =
        (base_of(case), TimeBase::new(TimeBaseSettings { latency, ..settings }));
    for s in case.samples(10.0, 1) {
        plain.observe(s.index, s.arrival);
        less.observe(s.index, s.arrival);
        let (with, without) = (less.time_of(s.index, s.arrival), plain.time_of(s.index, s.arrival));
        assert_eq!(without.as_ns() - with.as_ns(), 125_000);
    }
}

/// Times go on by the counter when the host's clock is set by `by_s` after 30 s.
fn a_clock_set(by_s: f64) {
    let case = &CASES[2];
    let mut base = base_of(case);
    let (mut seen, mut before_s, mut after) = (Vec::new(), 0.0, Vec::new());
    for s in case.samples(120.0, 3) {
        let set_s = if s.taken_s > 30.0 { by_s } else { 0.0 };
        let arrival = SimTime::from_s(s.arrival.as_s() + set_s).unwrap();
        if let Observed::ClockSet(found_s) = base.observe(s.index, arrival) {
            seen.push(found_s);
        }
        let error_s = base.time_of(s.index, arrival).as_s() - s.taken_s;
        if s.taken_s < 30.0 {
            before_s = error_s;
        } else if s.taken_s > 100.0 {
            after.push(error_s);
        }
    }
    assert_eq!(seen.len(), 1, "{seen:?}");
    // To the delay of the samples that show it: a USB frame of 1 ms, spikes of some ms.
    assert!((seen[0] - by_s).abs() < 0.02, "{seen:?} for {by_s}");
    let moved_s = after.iter().sum::<f64>() / after.len() as f64 - before_s;
    assert!(moved_s.abs() < 0.02, "the times moved by {moved_s} s");
    assert!(deviation_us(&after) < 20.0, "{} us", deviation_us(&after));
}

#[test]
fn a_host_clock_that_is_set_is_noticed_and_times_go_on_by_the_counter() {
    [1.0, -1.0, 3600.0, -3600.0].into_iter().for_each(a_clock_set);
}

#[test]
fn a_host_held_up_for_seconds_finds_a_backlog_and_no_clock_was_set() {
    let case = &CASES[0];
    let mut base = base_of(case);
    for s in case.samples(60.0, 3) {
        // From 30 s to 31.5 s nothing is read, then everything at once.
        let held = (30.0..31.5).contains(&s.taken_s);
        let arrival = if held { SimTime::from_s(31.5).unwrap() } else { s.arrival };
        assert_eq!(base.observe(s.index, arrival), Observed::Usual, "at {} s", s.taken_s);
        if s.taken_s > 30.0 {
            let error_s = base.time_of(s.index, arrival).as_s() - s.taken_s;
            // The frame takes 955 us on the line, and no delay is shorter.
            assert!((error_s - 954.9e-6).abs() < 5e-6, "{error_s} s at {} s", s.taken_s);
        }
    }
}

#[test]
fn anything_may_be_observed() {
    let mut random = Random(1);
    let mut base = base_of(&CASES[0]);
    for _ in 0..20_000 {
        let bits = random.uniform().to_bits();
        let index = if bits.is_multiple_of(7) { bits } else { bits % 100_000 };
        let arrival = SimTime::from_ns((bits ^ (bits << 13)).cast_signed());
        base.observe(index, arrival);
        let _ = (base.time_of(index, arrival), base.skew(), base.lateness_s(index, arrival));
    }
}
