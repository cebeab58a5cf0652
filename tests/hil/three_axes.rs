//! A triad of gyros at a port.

use crate::Live;
use crate::script::Step;
use std::path::PathBuf;
use struna::hil::setup::{ScenarioText, Setup, frame_text};
use struna::scenario::{Scenario, Source};
use struna::session;
use struna_kernel::SimTime;

/// The first columns of a record of three rates.
pub(crate) const COLUMNS: &str = "\"time\",\"measured_rate_rad_s\",\"over_range\",\"lost_before\",\
    \"measured_rate_x_rad_s\",\"measured_rate_y_rad_s\",\"torsion.angle_rad\"";
const TEXT: &str = include_str!("../../scenarios/three-axes.toml");

fn scenario() -> ScenarioText {
    ScenarioText { path: PathBuf::from("three-axes.toml"), text: TEXT.to_owned() }
}

/// The true twist at an instant.
fn twist_rad(time_s: f64) -> f64 {
    let ScenarioText { path, text } = scenario();
    let scenario = Scenario::parse(&text, &path).unwrap();
    let Source::Model(model) = &scenario.source else { panic!("a model") };
    let mut motion = model.motion(scenario.seed, 0).unwrap();
    motion.motion_at(SimTime::from_s(time_s).unwrap()).unwrap().twist_rad
}

/// So many seconds of the shipped scenario's frames, each a millisecond after its sample.
pub(crate) fn frames(seconds: f64) -> Vec<(i64, Step)> {
    let ScenarioText { path, text } = scenario();
    let mut emulator = session::emulator(&Scenario::parse(&text, &path).unwrap()).unwrap();
    let mut steps = Vec::new();
    while emulator.next_time().as_s() < seconds {
        let (sent, mut bytes) = (emulator.next_time().as_ns() + 1_000_000, Vec::new());
        emulator.emit(&mut bytes).unwrap();
        steps.push((sent, Step::Bytes(bytes)));
    }
    steps
}

#[test]
fn a_swing_is_followed_from_a_port_and_the_replay_is_the_same_to_the_byte() {
    let mut steps = frames(40.0);
    // A second without frames: a gap for the filter, not an end.
    steps.retain(|(ns, _)| !(30_000_000_000..31_000_000_000).contains(ns));
    let live = Live::play_as(&Setup::new(None, Some(scenario())), steps, 41.0, false);
    let record = live.text("record.csv");
    assert!(record.starts_with(COLUMNS), "{record}");
    let rows = live.rows();
    // 40 s at 100 Hz without one.
    assert!((3895..=3905).contains(&rows.len()), "{} rows", rows.len());
    // The bodies' 5 degrees at 9.8 rad/s turn the cross axes by 49 deg/s, or 0.85 rad/s.
    let widest = |k: usize| rows.iter().map(|row| row[k].abs()).fold(0.0, f64::max);
    assert!((0.6..1.0).contains(&widest(4).max(widest(5))), "{} {}", widest(4), widest(5));
    // Seven signals of the one-rate filter stand before: angle, rate, two deviations, NIS, status
    // and what the rate is the rate of.
    let [angle, sigma, status] = [13, 15, 18].map(|k| rows.last().unwrap()[k]);
    // Swinging; or disturbed, which it says for 30 s after the first seconds, in which the clock of
    // the line settles and the motion is only being found.
    assert!([1.0, 3.0].contains(&status), "status {status}");
    assert!(sigma < 0.02, "{sigma}");
    // The record's time starts with the first sample, a millisecond and 1/300 s are 0.1 degrees;
    // it started 10 degrees off, and half a minute of the swing leaves a tenth of that.
    let error_rad = angle - twist_rad(40.0);
    assert!(error_rad.abs() < 2_f64.to_radians(), "{} deg", error_rad.to_degrees());
    assert_eq!(live.replayed(), record);
}

#[test]
fn a_frame_of_one_rate_is_refused_with_the_estimator_and_the_remedy() {
    let one_rate = frame_text("struna/vg910d@1").unwrap();
    let refused = Setup::new(Some(one_rate.clone()), Some(scenario())).plan().unwrap_err();
    let said = refused.to_string();
    for part in ["'three-axis'", "`rate_x`", "'struna/vg910d@1'", "\"struna/vg910d-triad@1\""] {
        assert!(said.contains(part), "{part} not in: {said}");
    }
    // The other one reads the same rate from either.
    let mut setup = Setup::new(Some(one_rate), Some(scenario()));
    setup.estimators = vec!["torsion".to_owned()];
    assert_eq!(setup.plan().unwrap().estimators.len(), 1);
}
