//! Layouts recovered from their bytes: random ones by the hundred, and the shipped ones.
//!
//! The rules were tuned on seeds 0 to 399; the seeds here were not looked at while tuning.
//! `STRUNA_SNIFF_SEED` and `STRUNA_SNIFF_LAYOUTS` look at others.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
#![expect(clippy::print_stdout, reason = "the figures are told, whether or not they suffice")]

mod capture;
mod grade;
mod known;
mod layouts;

use capture::{Conditions, capture, fresh};
use grade::{Grade, grade};
use layouts::{Sender, random_sender};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use struna_sniff::{Labels, Report, Verdict, sniff};
use struna_wire::{Decoder, FrameSpec};

const HELD_OUT_SEED: u64 = 10_000;
const LAYOUTS: u64 = 400;

struct Trial {
    seed: u64,
    sender: Sender,
    report: Report,
    grade: Grade,
}

fn from_environment(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
}

/// Sniffs at a random sender and grades the guess on 600 frames that were not in the capture.
fn trial(seed: u64, conditions: Conditions, change: fn(&mut Sender)) -> Trial {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut sender = random_sender(&mut rng);
    change(&mut sender);
    let bytes = capture(&sender, conditions, &mut rng);
    let (new, rates) = fresh(&sender.layout, 600, &mut rng);
    let report = sniff(&bytes, None);
    let guess = report.proposals.first().and_then(|proposal| proposal.layout());
    let grade = guess.map_or_else(Grade::default, |g| grade(g, &sender.layout, &new, &rates));
    Trial { seed, sender, report, grade }
}

fn trials(count: u64, conditions: Conditions, change: fn(&mut Sender)) -> Vec<Trial> {
    let first = from_environment("STRUNA_SNIFF_SEED", HELD_OUT_SEED);
    (first..first + count).map(|seed| trial(seed, conditions, change)).collect()
}

fn share(trials: &[Trial], good: impl Fn(&Trial) -> bool) -> f64 {
    let count = |n: usize| f64::from(u32::try_from(n).unwrap());
    count(trials.iter().filter(|trial| good(trial)).count()) / count(trials.len())
}

fn moving(corrupted: f64) -> Conditions {
    Conditions { seconds: 8.0, corrupted, turned: true }
}

fn is_confirmed(trial: &Trial) -> bool {
    matches!(trial.report.verdict, Verdict::Confirmed { .. })
}

/// Holds the share of layouts of which length, counter, check and rate are all right to `least`.
fn assert_recovered(corrupted: f64, least: f64) {
    let layouts = from_environment("STRUNA_SNIFF_LAYOUTS", LAYOUTS);
    let trials = trials(layouts, moving(corrupted), |_| {});
    let functional = share(&trials, |trial| trial.grade.is_functional());
    println!(
        "corrupted {corrupted}: length {:.4} sync {:.4} counter {:.4} check {:.4} rate {:.4} \
         functional {functional:.4}; confirmed {:.4}, of them wrong {:.4}",
        share(&trials, |trial| trial.grade.len),
        share(&trials, |trial| trial.grade.sync),
        share(&trials, |trial| trial.grade.counter),
        share(&trials, |trial| trial.grade.check),
        share(&trials, |trial| trial.grade.rate),
        share(&trials, is_confirmed),
        share(&trials, |trial| is_confirmed(trial) && !trial.grade.is_functional()),
    );
    for trial in trials.iter().filter(|trial| !trial.grade.is_functional()) {
        let guess = trial.report.proposals.first().and_then(|proposal| proposal.layout());
        let (seed, grade, truth) = (trial.seed, trial.grade, &trial.sender.layout);
        println!("seed {seed}: {grade:?}\n  truth {truth:?}\n  guess {guess:?}");
    }
    assert!(functional >= least, "{functional} of layouts recovered, {least} required");
    // A confirmed layout is one that a person will rely on.
    let misled = share(&trials, |trial| is_confirmed(trial) && !trial.grade.is_functional());
    assert!(misled <= 0.02, "{misled} of layouts were confirmed and wrong");
}

#[test]
fn clean_captures_give_their_layouts_away() {
    assert_recovered(0.0, 0.95);
}

#[test]
fn one_damaged_byte_in_a_thousand_changes_little() {
    assert_recovered(0.001, 0.92);
}

#[test]
fn one_damaged_byte_in_a_hundred_is_survived() {
    assert_recovered(0.01, 0.85);
}

#[test]
fn no_check_is_found_where_there_is_none() {
    let without_check = |sender: &mut Sender| {
        if let Some(check) = sender.layout.check.take() {
            sender.layout.len -= check.kind.bytes();
        }
    };
    let conditions = Conditions { seconds: 4.0, ..moving(0.001) };
    for trial in trials(200, conditions, without_check) {
        for proposal in &trial.report.proposals {
            let check = proposal.layout().and_then(|layout| layout.check);
            assert_eq!(check, None, "seed {}: {:?}", trial.seed, trial.sender.layout);
        }
    }
}

#[test]
fn a_gyro_at_rest_confirms_nothing() {
    let conditions = Conditions { turned: false, ..moving(0.0) };
    for trial in trials(60, conditions, |_| {}) {
        assert!(!is_confirmed(&trial), "seed {}: {:?}", trial.seed, trial.sender.layout);
        let score = trial.report.proposals.first().map_or(0.0, |proposal| proposal.score);
        assert!(score <= 0.75, "seed {}: score {score}", trial.seed);
    }
}

/// The text of a proposal is a frame file, and the decoder reads with it what was sent.
#[test]
fn proposals_are_frame_files_that_decode_a_fresh_stream() {
    let labels =
        Labels { name: "test/sniffed@1".into(), baud: None, rate_hz: None, measured: true };
    let mut read_whole = 0;
    for trial in trials(60, Conditions { seconds: 3.0, ..moving(0.0) }, |_| {}) {
        for proposal in &trial.report.proposals {
            let Some(text) = proposal.to_toml(&labels) else { continue };
            FrameSpec::from_toml(&text)
                .unwrap_or_else(|error| panic!("seed {}: {error}\n{text}", trial.seed));
        }
        // A constant status byte may have been taken for sync; another time it may differ.
        if !trial.grade.is_functional() || trial.sender.status.is_some() {
            continue;
        }
        let mut rng = ChaCha8Rng::seed_from_u64(!trial.seed);
        let sender = &trial.sender;
        let bytes = capture(sender, Conditions { seconds: 2.0, ..moving(0.0) }, &mut rng);
        let text = trial.report.proposals[0].to_toml(&labels).unwrap();
        let mut decoder = Decoder::new(FrameSpec::from_toml(&text).unwrap());
        let mut frames = 0;
        decoder.push(&bytes, &mut |_| frames += 1);
        let sent = bytes.len() / sender.layout.len;
        assert!(frames + 3 >= sent, "seed {}: {frames} of {sent} frames\n{text}", trial.seed);
        read_whole += 1;
    }
    assert!(read_whole >= 20, "only {read_whole} layouts were put to the test");
}

#[test]
fn where_a_capture_begins_does_not_matter() {
    for seed in HELD_OUT_SEED..HELD_OUT_SEED + 6 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let sender = random_sender(&mut rng);
        let bytes = capture(&sender, Conditions { seconds: 4.0, ..moving(0.0) }, &mut rng);
        let shape = |from: usize| {
            sniff(&bytes[from..], None).proposals.first().map(|first| first.shape.clone())
        };
        let whole = shape(0);
        for from in (1..sender.layout.len).step_by(3) {
            assert_eq!(shape(from), whole, "seed {seed} from byte {from}");
        }
    }
}
