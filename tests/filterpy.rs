//! FilterPy, which shares no code with this workspace, referees the plain Kalman filters: both
//! motions, with process noise and without, at irregular steps and across gaps.

#![expect(
    clippy::panic,
    clippy::print_stdout,
    reason = "a panic fails the test, figures for whoever asks"
)]

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use struna_estimator::{
    Belief, Filter, FilterConfig, Innovation, Motion, RateEstimator, Refinement,
};
use struna_kernel::{Channel, RandomStream, Seed};

/// What is promised, of each number's own size: of the angle and rate their largest, of the
/// covariance each element's.
const AGREEMENT: f64 = 1e-12;
const PERIOD_S: f64 = 7.0;

/// A step over a span, with a measurement at its end or, in a gap, without.
#[derive(Debug, Clone, Copy)]
struct Step {
    span_s: f64,
    rate_rad_s: Option<f64>,
}

/// Angle, rate; their covariance as angle, cross, rate; innovation and its variance, 0 in a gap.
type Answer = [f64; 7];

/// FilterPy's answer after each step.
fn oracle(config: &FilterConfig, period_s: Option<f64>, steps: &[Step]) -> Vec<Answer> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let python = std::env::var_os("STRUNA_PYTHON")
        .map_or_else(|| root.join(".venv/bin/python"), PathBuf::from);
    assert!(python.is_file(), "{} is missing: run make test", python.display());
    let mut child = Command::new(python)
        .arg("-B") // leaves no byte code beside the script
        .arg(root.join("tests/filterpy/oracle.py"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("an interpreter that exists can be started");
    let mut asked = format!(
        "{} {} {} {} {} {} {}\n",
        period_s.map_or("rotation".to_owned(), |period_s| period_s.to_string()),
        config.angle_start_rad,
        config.rate_start_rad_s,
        config.angle_variance_start_rad2,
        config.rate_variance_start_rad2_s2,
        config.measurement_variance_rad2_s2,
        config.process_noise_rad2_s3,
    );
    for step in steps {
        let rate = step.rate_rad_s.map_or("gap".to_owned(), |rate| rate.to_string());
        asked += &format!("{} {rate}\n", step.span_s);
    }
    // The script reads all of it before it answers. One that died early is reported below.
    let _ = child.stdin.take().expect("piped").write_all(asked.as_bytes());
    let output = child.wait_with_output().expect("our child");
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "oracle.py: {}\n{complaint}", output.status);
    let answers = String::from_utf8_lossy(&output.stdout);
    let answer = |line: &str| -> Answer {
        let number = |word: &str| word.parse().unwrap_or_else(|_| panic!("{word} in {line}"));
        let numbers: Vec<f64> = line.split(' ').map(number).collect();
        numbers.try_into().unwrap_or_else(|_| panic!("{line}"))
    };
    let answers: Vec<Answer> = answers.lines().map(answer).collect();
    assert_eq!(answers.len(), steps.len(), "{complaint}");
    answers
}

/// 1000 steps of 2 to 18 ms, every fiftieth followed by a gap of half a second.
fn steps() -> Vec<Step> {
    // Any channel does; it only keys the stream.
    let mut stream = RandomStream::new(Seed(2008), Channel::GyroAngleRandomWalk, 0);
    let mut time_s = 0.0_f64;
    let mut steps = Vec::new();
    for k in 1..=1000_u32 {
        let span_s = 0.002 + 0.016 * stream.uniform();
        time_s += span_s;
        let rate_rad_s = -2.0 * (0.9 * time_s).sin() + 0.01 * stream.standard_normal();
        steps.push(Step { span_s, rate_rad_s: Some(rate_rad_s) });
        if k.is_multiple_of(50) {
            steps.push(Step { span_s: 0.5, rate_rad_s: None });
            time_s += 0.5;
        }
    }
    steps
}

fn answer(filter: &impl RateEstimator, innovation: Option<Innovation>) -> Answer {
    let Belief { angle_rad, rate_rad_s, covariance: c } = filter.belief();
    let residual_rad_s = innovation.map_or(0.0, |innovation| innovation.residual_rad_s);
    let variance_rad2_s2 = innovation.map_or(0.0, |innovation| innovation.variance_rad2_s2);
    [
        angle_rad,
        rate_rad_s,
        c.angle_rad2,
        c.cross_rad2_s,
        c.rate_rad2_s2,
        residual_rad_s,
        variance_rad2_s2,
    ]
}

/// What each difference is a share of: of what may be 0, the largest there was.
fn scales(answers: &[Answer], k: usize) -> Answer {
    let largest = |i: usize| answers[..=k].iter().map(|a| a[i].abs()).fold(0.0, f64::max);
    let [_, _, a, _, c, _, variance] = answers[k];
    // A gap has no innovation; 0 against 0 is off by 0 of anything.
    [largest(0), largest(1), a, (a * c).sqrt(), c, largest(1), variance.max(f64::MIN_POSITIVE)]
}

fn compare<M: Motion>(
    what: &str,
    mut filter: Filter<M>,
    config: &FilterConfig,
    period: Option<f64>,
) {
    let steps = steps();
    let theirs = oracle(config, period, &steps);
    let mut widest = 0.0_f64;
    for (k, (step, theirs_now)) in steps.iter().zip(&theirs).enumerate() {
        let innovation = match step.rate_rad_s {
            Some(rate_rad_s) => Some(filter.step(step.span_s, rate_rad_s).expect("a sound step")),
            None => {
                filter.predict(step.span_s).expect("a sound span");
                None
            }
        };
        let ours = answer(&filter, innovation);
        let scales = scales(&theirs, k);
        for i in 0..ours.len() {
            let off = (ours[i] - theirs_now[i]).abs() / scales[i];
            assert!(off < AGREEMENT, "{what}, step {k}, number {i}: {off:e}, {ours:?}");
            widest = widest.max(off);
        }
    }
    println!("{what}: {} steps, off by {widest:.1e} at most", steps.len());
}

#[test]
fn the_plain_filters_are_those_of_filterpy() {
    for process_noise_rad2_s3 in [0.0, 1e-3] {
        let config = FilterConfig {
            angle_start_rad: 2.0,
            rate_start_rad_s: 0.1,
            angle_variance_start_rad2: 0.04,
            rate_variance_start_rad2_s2: 0.01,
            measurement_variance_rad2_s2: 1e-4,
            process_noise_rad2_s3,
            refinement: Refinement::OFF,
        };
        let rotation = Filter::permanent_rotation(config).expect("a sound configuration");
        compare(&format!("rotation, q = {process_noise_rad2_s3}"), rotation, &config, None);
        let torsion =
            Filter::torsional_oscillation(config, PERIOD_S).expect("a sound configuration");
        compare(&format!("torsion, q = {process_noise_rad2_s3}"), torsion, &config, Some(PERIOD_S));
    }
}
