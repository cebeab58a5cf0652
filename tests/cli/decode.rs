//! `struna decode`: captures that are what they are said to be, damaged ones, and others.

use crate::desk::{Desk, names};
use struna::frames::frame_named_or_file;
use struna_wire::Encoder;

const VG910D: &str = "struna/vg910d@1";

/// Frames of a shipped layout: rates of one degree per second more each time.
fn capture(name: &str, frames: u64) -> Vec<u8> {
    let spec = frame_named_or_file(name).unwrap();
    let rate = spec.field_index("rate").unwrap();
    let mut encoder = Encoder::starting_at(&spec, 250);
    let mut bytes = Vec::new();
    for k in 0..frames {
        let mut raw = vec![0; spec.fields().len()];
        raw[rate] = spec.fields()[rate].from_si((k as f64).to_radians());
        if let Some(temp) = spec.field_index("temp").filter(|_| name == VG910D) {
            (raw[temp], raw[2]) = (6528, 9);
        }
        encoder.encode(&raw, &mut bytes).unwrap();
    }
    bytes
}

fn rows(text: &str) -> Vec<Vec<&str>> {
    text.lines().map(|line| line.split(',').collect()).collect()
}

#[test]
fn a_capture_becomes_a_table_in_si() {
    let desk = Desk::new();
    let bytes = capture(VG910D, 10);
    // Frame 3 is lost, frame 7 damaged, and noise comes first.
    let bytes = [&b"noise"[..], &bytes[..33], &bytes[44..82], &[!bytes[82]], &bytes[83..]].concat();
    desk.write("c.bin", &bytes);
    let said = desk.done(&["decode", "c.bin", "--frame", VG910D, "--csv", "c.csv"]);
    names(&said, &[VG910D, "8 of 104 bytes", "2 in 2 gaps, 0 duplicates", "1 by check"]);
    names(&said, &["88 in frames, 16 skipped", "8 frames written to c.csv"]);
    let text = desk.text("c.csv");
    let rows = rows(&text);
    let header = "index,time_s,rate_rad_s,temp_deg_c,status,valid,over_range,bit_fault,temp_valid,\
                  warm_up,self_test,lost_before";
    assert_eq!(text.lines().next(), Some(header));
    let column = |k: usize| rows[1..].iter().map(|row| row[k]).collect::<Vec<_>>();
    assert_eq!(column(0), ["250", "251", "252", "254", "255", "256", "258", "259"]);
    assert_eq!(column(11), ["0", "0", "0", "1", "0", "0", "1", "0"]);
    assert_eq!(column(3), ["25.5"; 8]);
    assert_eq!((rows[1][5], rows[1][6], rows[1][8]), ("1", "0", "1"));
    let time_s: f64 = rows[4][1].parse().unwrap();
    assert!((time_s - 254.0 / 300.0).abs() < 1e-15);
    let rate_rad_s: f64 = rows[4][2].parse().unwrap();
    // 4 deg/s are a whole number of counts; the way to radians rounds.
    assert!((rate_rad_s - 4.0_f64.to_radians()).abs() < 1e-15);

    let counters = desk.done(&["decode", "c.bin", "--frame", VG910D]);
    assert!(said.starts_with(counters.trim_end()), "{counters}");
    let piped = desk.done(&["decode", "c.bin", "--frame", VG910D, "--csv", "-"]);
    assert_eq!(piped, text);
    let slow = desk.done(&["decode", "c.bin", "--frame", VG910D, "--csv", "-", "--rate-hz", "100"]);
    assert!(slow.contains("\n250,2.5,"), "{slow}");
}

#[test]
fn fields_that_a_frame_does_not_carry_are_blank() {
    let desk = Desk::new();
    desk.write("a.bin", capture("struna/adis16100@1", 2));
    let table = desk.done(&["decode", "a.bin", "--frame", "struna/adis16100@1", "--csv", "-"]);
    let rows = rows(&table);
    assert_eq!(
        rows[0][2..],
        ["chan", "rate_rad_s", "temp_deg_c", "ain1_v", "ain2_v", "lost_before"]
    );
    assert_eq!((rows[1][2], rows[1][3], &rows[1][4..]), ("0", "0", &["", "", "", "0"][..]));
}

#[test]
fn a_file_that_holds_something_else_is_refused_and_nothing_is_written() {
    let desk = Desk::new();
    desk.write("other.bin", capture("struna/fog-septet-xor@1", 500));
    desk.write("empty.bin", b"");
    let decode = |file| ["decode", file, "--frame", VG910D, "--csv", "out.csv"];
    let complaint = desk.refused(&decode("other.bin"));
    names(
        &complaint,
        &[
            "other.bin holds no stream of struna/vg910d@1 frames",
            "in 3500 bytes",
            "per kB against 90.91 expected",
            "struna frame sniff",
        ],
    );
    names(&desk.refused(&decode("empty.bin")), &["empty.bin is empty"]);
    names(&desk.refused(&decode("none.bin")), &["cannot read none.bin", "check the path"]);
    let unknown = desk.refused(&["decode", "other.bin", "--frame", "vg910d"]);
    names(&unknown, &["no frame is called vg910d", VG910D]);
}
