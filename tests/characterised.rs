//! The emulated gyros, characterised from their own bytes, give their parameters back.
//!
//! An hour at rest goes through error model, frame and decoder, and what comes out is judged as a
//! real gyro's record would be. Caught on the way: a decoder that hands another channel's value
//! out as a rate, and noise that the gyro's own band takes away.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may fail by panicking")]
#![expect(clippy::print_stdout, reason = "figures for whoever runs it with --nocapture")]

use struna::frames::frame_named_or_file;
use struna_gyro::characterise::{Options, RateRecord, Term, Verdict, characterise};
use struna_gyro::{Gyro, GyroParams, preset};
use struna_harness::{Emulator, Recording};
use struna_kernel::{SampleGrid, Seed, SimTime};
use struna_wire::Decoder;

const HOUR_S: f64 = 3600.0;

/// The gyro after its warm-up, as somebody who wants its noise would record it.
fn warm(params: GyroParams) -> GyroParams {
    let mut params = params;
    params.bias_effects.on_before_s = 50.0 * params.bias_effects.warm_up_time_s;
    params
}

/// An hour of the gyro at rest, out of its bytes.
fn record(params: GyroParams, frame: &str, seed: Seed) -> RateRecord {
    let frame = frame_named_or_file(frame).unwrap();
    let rate_hz = params.sample_rate_hz;
    let grid = SampleGrid::new(SimTime::ZERO, rate_hz).unwrap();
    let still = Recording::new(&[0.0, HOUR_S + 1.0], &[0.0, 0.0]).unwrap();
    let gyro = Gyro::new(params, seed, 0).unwrap();
    let mut emulator = Emulator::new(Box::new(still), gyro, grid, &frame).unwrap();
    let rate = frame.field_index("rate").unwrap();
    let field = frame.fields()[rate].clone();
    let mut decoder = Decoder::new(frame);
    let mut record = RateRecord::new(rate_hz).unwrap();
    let mut bytes = Vec::new();
    for _ in 0..grid.periods_until(SimTime::from_s(HOUR_S).unwrap()) {
        bytes.clear();
        emulator.emit(&mut bytes).unwrap();
        decoder.push(&bytes, &mut |frame| record.push(field.to_si(frame.raw()[rate])));
    }
    assert_eq!(decoder.finish().ok, emulator.report().frames, "a clean line loses nothing");
    record
}

/// Holds each verdict on a gyro to what the gyro was made with; `bandwidth_hz` is its own.
fn assert_found(params: GyroParams, frame: &str, bandwidth_hz: f64) {
    let params = warm(params);
    let truth = [
        (Term::AngleRandomWalk, params.angle_random_walk_rad_sqrt_s),
        (Term::BiasInstability, params.drift.bias_instability_rad_s),
        (Term::RateRandomWalk, params.drift.rate_random_walk_rad_s_sqrt_s),
    ];
    let mut estimated = Vec::new();
    let mut held = 0;
    for seed in 0..3 {
        let options = Options { bandwidth_hz: Some(bandwidth_hz), ..Options::default() };
        let found = characterise(&record(params, frame, Seed(seed)), &options).unwrap();
        for (term, truth) in truth {
            match found.verdict(term) {
                Verdict::Estimated { value, interval: [low, high] } => {
                    let holds = low <= truth && truth <= high;
                    println!("{frame} seed {seed} {term:?}: {:.4} {holds}", value / truth);
                    held += u32::from(holds);
                    estimated.push(term);
                }
                Verdict::AtMost { bound, .. } => {
                    println!("{frame} seed {seed} {term:?}: at most {:.3}", bound / truth);
                    // A 95 % bound; nine bounds that all hold come by chance in 63 of 100.
                    assert!(bound > 0.8 * truth, "{term:?}: bound {:.3} of it", bound / truth);
                }
                refused @ Verdict::Refused { .. } => panic!("{frame} {term:?}: {refused:?}"),
            }
        }
    }
    // Every record tells the walk; of 95 % intervals at most one of nine is allowed to miss.
    let walks = estimated.iter().filter(|term| **term == Term::AngleRandomWalk).count();
    assert_eq!(walks, 3, "{frame}: the angle random walk was not found");
    let missed = u32::try_from(estimated.len()).unwrap() - held;
    assert!(missed <= 1, "{frame}: {missed} of {} intervals miss", estimated.len());
}

#[test]
fn the_fibre_optic_gyro_is_found_in_its_bytes() {
    assert_found(preset::vg910d(), "struna/vg910d@1", 100.0);
}

#[test]
fn the_mems_gyro_is_found_in_its_bytes() {
    assert_found(preset::adis16100(), "struna/adis16100@1", 40.0);
}
