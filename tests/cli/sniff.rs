//! `struna frame sniff`: from bytes to a frame file that reads them.

use crate::desk::{Desk, names};
use std::process::Stdio;
use struna_line::{StopFlag, VirtualPort};
use struna_wire::{Decoder, Encoder, FrameSpec};

const FRAME: &str = include_str!("../../frames/vg910d.toml");
const FRAMES: u32 = 2400;

/// Evenly spread over 1024 counts and without a pattern: steps that repeat would rightly be taken
/// for a number of its own in the low byte.
fn noise(k: u32) -> i64 {
    let mixed = (u64::from(k) + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let [.., low, high] = mixed.to_le_bytes();
    i64::from(u16::from_le_bytes([low, high]) >> 6) - 512
}

/// 8 s of the shipped gyro: at rest, then turned both ways.
fn capture(turned: bool) -> Vec<u8> {
    let spec = FrameSpec::from_toml(FRAME).unwrap();
    let mut encoder = Encoder::new(&spec);
    let mut bytes = Vec::new();
    for k in 0..FRAMES {
        let time_s = f64::from(k) / 300.0;
        let noise = noise(k);
        let rate = if turned && time_s > 3.0 { 3e6 * (2.0 * time_s).sin() } else { 0.0 };
        #[expect(clippy::cast_possible_truncation, reason = "far below 2^63")]
        let raw = [rate as i64 + noise, 6400 + (noise >> 6), 1];
        encoder.encode(&raw, &mut bytes).unwrap();
    }
    bytes
}

/// Frames that the proposed file reads in `bytes`, and its rates.
fn decoded(toml: &str, bytes: &[u8]) -> Vec<i64> {
    let spec = FrameSpec::from_toml(toml).unwrap();
    let rate = spec.field_index("rate").unwrap();
    let mut rates = Vec::new();
    Decoder::new(spec).push(bytes, &mut |frame| rates.push(frame.raw()[rate]));
    rates
}

#[test]
fn a_proposed_file_reads_the_capture_as_the_true_one() {
    let desk = Desk::new();
    desk.write("c.bin", capture(true));
    let said = desk.done(&[
        "frame",
        "sniff",
        "--file",
        "c.bin",
        "--seconds",
        "8",
        "--out",
        "f.toml",
        "--name",
        "a b",
    ]);
    names(
        &said,
        &["11 bytes", "A5 5A", "CRC-16/IBM-3740 over bytes 2 to 8", "Confirmed", "f.toml"],
    );
    let toml = desk.text("f.toml");
    names(&toml, &["name = \"a-b\"", "provenance = \"unverified\"", "rate_hz = 300.0"]);
    assert_eq!(decoded(&toml, &capture(true)), decoded(FRAME, &capture(true)));
}

#[test]
fn a_capture_at_rest_stays_unconfirmed() {
    let desk = Desk::new();
    desk.write("c.bin", capture(false));
    let said = desk.done(&["frame", "sniff", "--file", "c.bin"]);
    names(&said, &["Unconfirmed", "turn the gyro by hand both ways", "[frame]"]);
}

#[test]
fn a_second_capture_confirms() {
    let desk = Desk::new();
    desk.write("a.bin", capture(true));
    desk.write("b.bin", &capture(true)[5000..]);
    desk.write("noise.bin", vec![0x55; 5000]);
    let arguments = |second| ["frame", "sniff", "--file", "a.bin", "--second", second];
    names(&desk.done(&arguments("b.bin")), &["Confirmed"]);
    names(&desk.done(&arguments("noise.bin")), &["Unconfirmed", "0.0 %"]);
}

#[test]
fn noise_is_unknown_and_makes_no_file() {
    let desk = Desk::new();
    let mixed = |k: u64| k.wrapping_mul(k).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let noise: Vec<u8> = (0..20_000).map(|k| mixed(k).to_le_bytes()[7]).collect();
    desk.write("c.bin", noise);
    let said = desk.done(&["frame", "sniff", "--file", "c.bin", "--out", "f.toml"]);
    assert!(!said.contains("Confirmed: "), "{said}");
}

#[test]
fn an_empty_file_and_a_missing_one_are_refused() {
    let desk = Desk::new();
    desk.write("c.bin", "");
    names(&desk.refused(&["frame", "sniff", "--file", "c.bin"]), &["no bytes at all"]);
    names(&desk.refused(&["frame", "sniff", "--file", "d.bin"]), &["cannot read d.bin"]);
}

#[test]
fn a_port_is_captured_saved_and_confirmed() {
    let desk = Desk::new();
    let stop = StopFlag::new();
    let mut port = VirtualPort::open().unwrap();
    let path = port.path().to_str().unwrap().to_owned();
    // Everything but what the line itself holds passes only once the program reads.
    let mut program = desk.command(&[
        "frame",
        "sniff",
        "--port",
        &path,
        "--baud",
        "115200",
        "--seconds",
        "600",
        "--out",
        "g.toml",
    ]);
    let child = program.stdout(Stdio::piped()).spawn().unwrap();
    port.write_all(&capture(true), &stop).unwrap();
    port.drain(&stop).unwrap();
    drop(port);
    let said = String::from_utf8(child.wait_with_output().unwrap().stdout).unwrap();
    names(&said, &["Keep the gyro still", "115200 baud", "g.bin", "Confirmed"]);
    names(&desk.text("g.toml"), &["provenance = \"measured\"", "baud = 115200"]);
    assert_eq!(std::fs::read(desk.path("g.bin")).unwrap(), capture(true));
}
