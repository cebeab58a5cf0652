//! allantools, which shares no code with this workspace, referees the Allan deviation: the same
//! numbers from the same rates, the same intervals, and noise of its making recognised.

#![expect(clippy::panic, reason = "a panic fails the test")]

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use struna_gyro::characterise::{
    CumulativeAngle, Options, RateRecord, TauGrid, Term, Verdict, characterise, degrees_of_freedom,
    variance_interval,
};
use struna_kernel::{Channel, RandomStream, Seed};

/// What is promised. Sums of a million squares in another order differ by some 1e-13.
const AGREEMENT: f64 = 1e-10;

/// allantools' answers, one for each line of words, all from one process.
fn oracle(questions: &[Vec<String>]) -> Vec<Vec<f64>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let python = std::env::var_os("STRUNA_PYTHON")
        .map_or_else(|| root.join(".venv/bin/python"), PathBuf::from);
    assert!(python.is_file(), "{} is missing: run make test", python.display());
    let mut child = Command::new(python)
        .arg("-B") // leaves no byte code beside the script
        .arg(root.join("tests/allantools/oracle.py"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("an interpreter that exists can be started");
    let lines: String = questions.iter().map(|words| words.join("\t") + "\n").collect();
    // Some kilobytes fit into a pipe. A script that died early is reported below.
    let _ = child.stdin.take().expect("piped").write_all(lines.as_bytes());
    let output = child.wait_with_output().expect("our child");
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "oracle.py: {}\n{complaint}", output.status);
    let answers = String::from_utf8_lossy(&output.stdout);
    let number = |word: &str| word.parse().unwrap_or_else(|_| panic!("{word} in {answers}"));
    let answers: Vec<Vec<f64>> =
        answers.lines().map(|line| line.split(' ').map(number).collect()).collect();
    assert_eq!(answers.len(), questions.len(), "{complaint}");
    answers
}

fn words(asked: &str, rest: impl IntoIterator<Item = impl ToString>) -> Vec<String> {
    std::iter::once(asked.to_owned()).chain(rest.into_iter().map(|word| word.to_string())).collect()
}

/// Rates with an offset, a walk and a ramp, so that the sums are long and large.
fn rates(samples: usize) -> Vec<f64> {
    // Any channel does; it only keys the stream.
    let mut stream = RandomStream::new(Seed(2024), Channel::GyroAngleRandomWalk, 0);
    let mut walked = 0.0;
    let rate = |k: usize| {
        walked += 1e-3 * stream.standard_normal();
        12.5 + stream.standard_normal() + walked + 1e-7 * k as f64
    };
    (0..samples).map(rate).collect()
}

#[test]
fn deviations_are_those_of_allantools() {
    let samples = 200_000;
    let rates = rates(samples);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("rates");
    let bytes: Vec<u8> = rates.iter().flat_map(|rate| rate.to_le_bytes()).collect();
    fs::write(&path, bytes).expect("a file of ours");
    let factors = TauGrid::TenPerDecade.factors(samples / 3 - 1);
    let path = path.display().to_string();
    let asked = std::iter::once(path).chain(factors.iter().map(ToString::to_string));
    let answer = &oracle(&[words("deviations", asked)])[0];
    let (allan, hadamard) = answer.split_at(factors.len());
    let mean = rates.iter().sum::<f64>() / samples as f64;
    let angle = CumulativeAngle::of(&rates, mean);
    let mut widest = 0.0_f64;
    for ((factor, allan), hadamard) in factors.iter().zip(allan).zip(hadamard) {
        let ours = angle.allan_variance(*factor).expect("it fits in").sqrt();
        let ours_h = angle.hadamard_variance(*factor).expect("it fits in").sqrt();
        let off = (ours / allan - 1.0).abs().max((ours_h / hadamard - 1.0).abs());
        assert!(off < AGREEMENT, "{factor}: {ours:e} and {ours_h:e} are off by {off:e}");
        widest = widest.max(off);
    }
    println!("{} averaging times, off by {widest:.1e} at most", factors.len());
}

#[test]
fn degrees_of_freedom_are_those_of_allantools() {
    let slopes = [
        (Term::Quantisation, 2),
        (Term::AngleRandomWalk, 0),
        (Term::BiasInstability, -1),
        (Term::RateRandomWalk, -2),
    ];
    let mut cases = Vec::new();
    for (term, alpha) in slopes {
        for points in [101_usize, 4097, 1_080_001] {
            for factor in [1, 2, 7, points / 9, points / 3] {
                // At one sample allantools' flicker formula lacks the square of the handbook's.
                if (term, factor) != (Term::BiasInstability, 1) {
                    cases.push((term, alpha, points, factor));
                }
            }
        }
    }
    let ask = |(_, alpha, points, factor): &(Term, i32, usize, usize)| {
        words("freedom", [points.to_string(), factor.to_string(), alpha.to_string()])
    };
    let answers = oracle(&cases.iter().map(ask).collect::<Vec<_>>());
    for ((term, _, points, factor), answer) in cases.into_iter().zip(answers) {
        let ours = degrees_of_freedom(term, points, factor);
        // The same few operations in another order.
        let off = (ours / answer[0] - 1.0).abs();
        assert!(off < 1e-13, "{term:?}, {factor} of {points}: {ours} beside {}", answer[0]);
    }
}

#[test]
fn intervals_are_those_of_allantools() {
    let mut cases = Vec::new();
    for edf in [1.0, 2.5, 7.9, 30.0, 999.0, 1e4, 1.5e6] {
        cases.extend([0.6827, 0.95, 0.99].map(|confidence| [edf, confidence]));
    }
    let questions: Vec<_> = cases.iter().map(|case| words("interval", case)).collect();
    for ([edf, confidence], answer) in cases.into_iter().zip(oracle(&questions)) {
        for (ours, theirs) in variance_interval(edf, confidence).into_iter().zip(answer) {
            let off = (ours.sqrt() / theirs - 1.0).abs();
            // From 1000 degrees on the quantile is a normal approximation, good to 1e-6.
            assert!(off < 1e-6, "{edf}, {confidence}: {} beside {theirs}", ours.sqrt());
        }
    }
}

#[test]
fn noise_made_by_allantools_is_recognised() {
    let samples = 1 << 17;
    let folder = tempfile::tempdir().expect("a temporary folder");
    // Slope of the angle's noise, term, and what its coefficient is for a unit deviation at 1 s.
    // Kasdin's noise is sampled: only from some samples on is it that of the formula.
    let flat = (2.0 * std::f64::consts::LN_2 / std::f64::consts::PI).sqrt();
    for (b, term, per_deviation, tolerance) in [
        // 131 072 samples know N to some 0.3 %.
        (-2, Term::AngleRandomWalk, 1.0, 0.01),
        // The record's own scatter: fitted points within an octave go together.
        (-3, Term::BiasInstability, 1.0 / flat, 0.05),
        (-4, Term::RateRandomWalk, 3.0_f64.sqrt(), 0.05),
    ] {
        let path = folder.path().join(term.name());
        let asked = [path.display().to_string(), b.to_string(), "7".into(), samples.to_string()];
        let deviation = oracle(&[words("noise", asked)])[0][0];
        let bytes = fs::read(&path).expect("the script wrote it");
        let rates = bytes.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes));
        let record = RateRecord::contiguous(1.0, rates).expect("a positive rate");
        // Averages of less than some eight samples see that the noise is sampled.
        let options = Options { bandwidth_hz: Some(0.25), ..Options::default() };
        let found = characterise(&record, &options).expect("a sound record");
        let Verdict::Estimated { value, interval } = found.verdict(term) else {
            panic!("{term:?}: {:?}", found.verdict(term))
        };
        let ratio = value / (deviation * per_deviation);
        println!("{}: {ratio:.4} of what was made, interval {interval:?}", term.name());
        assert!((ratio - 1.0).abs() < tolerance, "{term:?}: {ratio}");
    }
}
