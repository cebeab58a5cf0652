//! `[line]`: what it means, and what of it is refused.

use crate::{FAST_FRAME, SCENARIO, edited, fast};
use std::fs;
use std::path::Path;
use struna::scenario::{LinePlan, Scenario};
use struna_kernel::SimTime;
use struna_line::{Bridge, CharacterFormat};

/// The scenario with `lines` added to its [line].
fn with(lines: &str) -> String {
    edited(SCENARIO, &[("[line]", &format!("[line]\n{lines}"))])
}

fn plan(text: &str) -> LinePlan {
    Scenario::parse(text, Path::new("s.toml")).unwrap_or_else(|error| panic!("{error}")).line
}

fn us(us: i64) -> SimTime {
    SimTime::from_ns(us * 1000)
}

#[test]
fn without_a_word_the_line_is_the_frames_own() {
    let own = plan(SCENARIO);
    let format = CharacterFormat::default();
    assert_eq!(
        own,
        LinePlan { baud: 115_200, format, latency: SimTime::ZERO, bridge: Bridge::Direct }
    );
    assert_eq!(plan(&edited(SCENARIO, &[("[line]\nframe = \"struna/vg910d@1\"", "")])), own);
}

#[test]
fn every_key_reaches_the_line() {
    let all = "baud = 57600\nlatency_us = 250.5\nbridge = \"ftdi\"\npacket_bytes = 510\n\
               latency_timer_ms = 1\nusb_frame_us = 125";
    let found = plan(&with(all));
    let bridge = Bridge::Ftdi { packet_bytes: 510, latency_timer: us(1000), usb_frame: us(125) };
    assert_eq!((found.baud, found.bridge), (57_600, bridge));
    assert_eq!(found.latency, SimTime::from_ns(250_500));
    let bridge = Bridge::Ftdi { packet_bytes: 62, latency_timer: us(16_000), usb_frame: us(1000) };
    assert_eq!(plan(&with("bridge = \"ftdi\"")).bridge, bridge);
    assert_eq!(plan(&with("bridge = \"direct\"")).bridge, Bridge::Direct);
}

#[test]
fn a_baud_rate_is_judged_by_the_frame_file_that_goes_over_it() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("fast.toml"), FAST_FRAME).unwrap();
    let path = folder.path().join("s.toml");
    let text = fast();
    let scenario = Scenario::parse(&text, &path).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scenario.line.baud, 230_400);
    assert_eq!(scenario.frame_called, folder.path().join("fast.toml").display().to_string());
    let slow = edited(&text, &[("[line]", "[line]\nbaud = 97999")]);
    let error = Scenario::parse(&slow, &path).unwrap_err().to_string();
    // 1400 frames of 7 bytes of 10 symbols.
    assert!(error.contains("`line.baud` = 97999"), "{error}");
    assert!(error.contains("at least 98000"), "{error}");
    let enough = edited(&text, &[("[line]", "[line]\nbaud = 98000")]);
    assert!(Scenario::parse(&enough, &path).is_ok());
}

#[test]
fn what_makes_no_sense_is_refused_with_line_key_value_and_remedy() {
    let line = SCENARIO.lines().position(|line| line == "[line]").unwrap() + 2;
    for (lines, parts) in [
        ("baud = 0", &["`line.baud` = 0", "50"][..]),
        ("baud = 9600", &["`line.baud` = 9600", "at least 33000", "struna/vg910d@1"]),
        ("baud = 115200.5", &["`line.baud` = 115200.5"]),
        ("latency_us = -1", &["`line.latency_us` = -1", "0"]),
        ("latency_us = nan", &["`line.latency_us` = nan", "finite"]),
        ("bridge = \"usb\"", &["`line.bridge`", "\"direct\"", "\"ftdi\""]),
        ("packet_bytes = 62", &["`line.packet_bytes`", "no USB bridge", "bridge = \"ftdi\""]),
        ("usb_frame_us = 125", &["`line.usb_frame_us`", "no USB bridge"]),
        ("latency_timr_ms = 1", &["`line.latency_timr_ms`", "`latency_timer_ms`"]),
    ] {
        let error = Scenario::parse(&with(lines), Path::new("s.toml")).unwrap_err().to_string();
        assert!(error.contains(&format!("s.toml, line {line}, ")), "{error}");
        for part in parts {
            assert!(error.contains(part), "{part} not in {error}");
        }
    }
    for (key, low, high) in [
        ("packet_bytes", "0", "511"),
        ("latency_timer_ms", "0.5", "256"),
        ("usb_frame_us", "0", "1e6"),
    ] {
        for value in [low, high] {
            let lines = format!("{key} = {value}\nbridge = \"ftdi\"");
            let error =
                Scenario::parse(&with(&lines), Path::new("s.toml")).unwrap_err().to_string();
            assert!(error.contains(&format!("`line.{key}` = {value}")), "{error}");
        }
    }
}
