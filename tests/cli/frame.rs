//! `struna frame`: what is said of layouts, and which are refused.

use crate::desk::{Desk, edited, names};

const DEFAULT: &str = include_str!("../../frames/vg910d.toml");
const RAW4: &str = include_str!("../../frames/vg910d-raw4.toml");

#[test]
fn the_list_names_every_shipped_layout_and_each_can_be_judged() {
    let desk = Desk::new();
    let list = desk.done(&["frame", "list"]);
    let shipped: Vec<_> =
        list.lines().skip(1).filter_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(shipped.len(), 8, "{list}");
    names(&list, &["struna/vg910d@1", "11", "300 Hz", "115200 baud 8N1", "rate temp status"]);
    let judged = desk.done(&[&["frame", "lint"][..], &shipped].concat());
    for name in shipped {
        names(&judged, &[name, "UNVERIFIED"]);
    }
    assert!(!judged.contains("warning"), "{judged}");
}

#[test]
fn a_layout_is_told_in_numbers() {
    let desk = Desk::new();
    desk.write("f.toml", DEFAULT);
    let said = desk.done(&["frame", "lint", "f.toml"]);
    names(
        &said,
        &[
            "struna/vg910d@1",
            "fixed, 11 bytes",
            "CRC-16 0x1021 over bytes 2 to 8, 16 bits: Hamming distance 4",
            "300 Hz +-3 %, time by counter",
            "33000 bit/s needed",
            // 33 kbit/s and 3 % more.
            "9600 baud   354 %  TOO SLOW",
            "115200 baud    30 %  as declared",
            "32.0 bits a frame (16.0 framing, 16.0 check), 8.0 more",
            // 2^-32, for 11520 bytes in each of 3600 s.
            "1 in a row: noise passes with 2.3e-10 per byte, 9.7e-3 per hour",
            "rate",
            "0.000030517578125 deg/s",
            // The shortest digits that read back as 2^8 - 2^-15.
            "-256 to 255.99996948242188 deg/s, clipped to -200 to 200",
            "cannot show: the counter has 256 values",
        ],
    );
    let bare = desk.done(&["frame", "lint", "struna/vg910d-raw4@1"]);
    names(
        &bare,
        &["none: no damage is seen", "lost, swapped and duplicated frames are not observable"],
    );
    let channels = desk.done(&["frame", "lint", "struna/adis16100@1"]);
    names(&channels, &["temp", "0.1453 degC", "when chan = 1"]);
}

#[test]
fn what_cannot_be_decoded_uniquely_is_refused_by_file_line_key_and_remedy() {
    let desk = Desk::new();
    for (text, edits, parts) in [
        (
            RAW4,
            &[("sync = \"A5 5A\"", "sync = \"00 00\""), ("len = 5", "len = 7")][..],
            ["f.toml, line 17", "`frame.sync` = \"00 00\"", "at byte 5 as well", "declare a check"],
        ),
        (
            RAW4,
            &[("sync = \"A5 5A\"", "sync = \"A5 5A\"\nsync_mask = \"01 00\"")],
            ["f.toml, line 18", "`frame.sync_mask`", "bits set that do not count", "clear them"],
        ),
        (
            DEFAULT,
            &[("baud = 115200", "baud = 19200")],
            ["f.toml, line", "`timing.rate_hz` = 300.0", "33000 baud", "raise `line.baud`"],
        ),
        (
            DEFAULT,
            &[("at = 7", "at = 6")],
            [
                "f.toml, line",
                "`frame.field[1].at` = 6",
                "byte 6 already belongs",
                "move one of them",
            ],
        ),
    ] {
        desk.write("f.toml", edited(text, edits));
        names(&desk.refused(&["frame", "lint", "f.toml"]), &parts);
    }
    let unknown = desk.refused(&["frame", "lint", "vg910"]);
    names(&unknown, &["no frame is called vg910", "struna/vg910d@1"]);
    names(&desk.refused(&["frame", "lint", "none.toml"]), &["cannot read", "none.toml", "check"]);
}
