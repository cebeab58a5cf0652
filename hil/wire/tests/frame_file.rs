//! Frame files: the default one says what its documentation says, and a wrong one is refused with
//! its line, key, value and remedy.

use proptest::prelude::*;
use std::f64::consts::PI;
use struna_settings::{Fault, SettingsError};
use struna_wire::{Coding, Endian, FrameSpec, Parity, Provenance, Unit};

const DEFAULT: &str = include_str!("../../../frames/vg910d.toml");

#[test]
fn the_default_frame_has_the_documented_numbers() {
    let spec = FrameSpec::from_toml(DEFAULT).unwrap();
    assert_eq!(spec.name(), "struna/vg910d@1");
    assert_eq!(spec.provenance(), Provenance::Unverified);
    assert_eq!((spec.frame_len(), spec.sync()), (11, &[0xA5, 0x5A][..]));
    assert_eq!((spec.check().range(), spec.check().at()), ((2, 8), 9));
    assert_eq!(spec.check().crc().checksum(b"123456789"), 0x29B1);
    let sequence = spec.sequence().unwrap();
    assert_eq!((sequence.at(), sequence.bits(), sequence.modulus()), (2, 8, 256));

    let rate = &spec.fields()[spec.field_index("rate").unwrap()];
    assert_eq!((rate.at(), rate.bits(), rate.endian()), (4, 24, Endian::Big));
    assert_eq!((rate.coding(), rate.unit()), (Coding::Twos, Unit::DegPerS));
    // Exact: 2^-15 is a binary number, and the file writes all its digits.
    assert_eq!(rate.scale_si().to_bits(), (2_f64.powi(-15) * (PI / 180.0)).to_bits());
    assert_eq!(rate.from_si(200.0 * PI / 180.0), 6_553_600);
    assert_eq!((rate.raw_min(), rate.raw_max()), (-8_388_608, 8_388_607));

    let temp = &spec.fields()[spec.field_index("temp").unwrap()];
    assert_eq!((temp.at(), temp.bits(), temp.from_si(25.5)), (7, 16, 6528));
    let status = spec.field_index("status").unwrap();
    assert!(spec.flags().iter().all(|flag| flag.field() == status));
    assert_eq!((spec.line().baud, spec.line().parity), (115_200, Parity::None));
    assert_eq!(spec.line().bits_per_byte(), 10);
    assert!((spec.timing().rate_hz - 300.0).abs() < f64::EPSILON);
    assert!((spec.bits_per_s() - 33_000.0).abs() < 1e-9);
}

/// The refusal of the default file with `from` replaced by `to`.
fn refusal(from: &str, to: &str) -> Box<SettingsError> {
    assert!(DEFAULT.contains(from), "the default file has no {from:?}");
    FrameSpec::from_toml(&DEFAULT.replacen(from, to, 1)).expect_err(to)
}

fn line_of(needle: &str) -> usize {
    DEFAULT.lines().position(|line| line.contains(needle)).expect(needle) + 1
}

#[test]
fn an_unknown_kind_says_what_is_supported() {
    let error = refusal("kind = \"fixed\"", "kind = \"septet\"");
    assert_eq!(
        error.to_string(),
        format!(
            "line {}, column 8: `frame.kind` = \"septet\": not supported; write one of: \"fixed\"",
            line_of("kind = \"fixed\"")
        )
    );
}

#[test]
fn an_unknown_key_names_the_nearest_and_all_that_exist() {
    let error = refusal("refin = false", "reflect = false");
    assert_eq!((error.line, error.column), (line_of("refin"), 1));
    assert_eq!(error.key, "frame.check.reflect");
    assert!(error.to_string().contains("refin, refout"), "{error}");
    let error = refusal("xorout", "xorut");
    assert!(error.to_string().contains("did you mean `xorout`?"), "{error}");
    assert!(matches!(refusal("[line]", "[lines]").fault, Fault::UnknownKey { .. }));
}

#[test]
fn layouts_that_contradict_themselves_are_refused() {
    let reason = |from, to| match refusal(from, to).fault {
        Fault::Refused { reason } => reason,
        other => panic!("{to}: {other}"),
    };
    for (from, to, byte, owner) in [
        ("at = 7", "at = 6", 6, "frame.field[0]"),
        ("at = 4", "at = 1", 1, "frame.sync"),
        ("at = 4", "at = 8", 9, "frame.check"),
        ("at = 2\n", "at = 1\n", 1, "frame.sync"),
    ] {
        let expected = format!("byte {byte} already belongs to {owner}; move one of them");
        assert_eq!(reason(from, to), expected);
    }
    for (from, to, last, end) in [
        ("at = 9", "at = 10", 11, 10),
        ("len = 11", "len = 1", 1, 0),
        ("[2, 8]", "[2, 11]", 11, 10),
    ] {
        let expected = format!("reaches byte {last}, but the frame ends at byte {end}; ");
        assert!(reason(from, to).starts_with(&expected), "{to}");
    }
    let itself = "covers the check's own byte 9; end the range before it";
    assert_eq!(reason("[2, 8]", "[2, 9]"), itself);
    let slow = refusal("baud = 115200", "baud = 28800");
    assert_eq!(slow.key, "timing.rate_hz");
    assert_eq!(slow.line, line_of("rate_hz"));
    assert!(slow.to_string().contains("33000 baud"), "{slow}");
}

#[test]
fn names_and_bits_are_given_once() {
    for (from, to, owner) in [
        ("name = \"temp\"", "name = \"rate\"", "the entry called rate above"),
        ("name = \"warm_up\"", "name = \"valid\"", "the entry called valid above"),
        ("bit = 5", "bit = 4", "the flag warm_up"),
    ] {
        let reason = format!("already taken by {owner}; choose another");
        assert_eq!(refusal(from, to).fault, Fault::Refused { reason }, "{to}");
    }
}

#[test]
fn flags_live_in_unsigned_fields_only() {
    let signed = refusal("field = \"status\"", "field = \"rate\"");
    assert_eq!(signed.key, "frame.flag[0].field");
    let Fault::UnknownWord { supported, .. } = signed.fault else { panic!("{signed}") };
    assert_eq!(supported, "\"status\"");
}

#[test]
fn values_that_cannot_be_used_are_refused() {
    for (from, to) in [
        ("\"A5 5A\"", "\"\""),
        ("\"A5 5A\"", "\"A5 5\""),
        ("\"A5 5A\"", "\"+5 5A\""),
        ("\"A5 5A\"", "\"A5 5A A5 5A A5 5A A5 5A A5\""),
        ("len = 11", "len = 0"),
        ("len = 11", "len = 65"),
        ("len = 11", "len = 99999999999999999999"),
        ("scale = 3.0517578125e-5", "scale = 0.0"),
        ("scale = 3.0517578125e-5", "scale = nan"),
        ("scale = 3.0517578125e-5", "scale = -inf"),
        ("scale = 3.0517578125e-5", "scale = 1e400"),
        ("scale = 3.0517578125e-5", "scale = 1e-300"),
        ("offset = 0.0", "offset = inf"),
        ("[-200.0, 200.0]", "[200.0, -200.0]"),
        ("[-200.0, 200.0]", "[0.0, nan]"),
        ("[-200.0, 200.0]", "[-1.0, 0.0, 1.0]"),
        ("[2, 8]", "[8, 2]"),
        ("[2, 8]", "[2, 64]"),
        ("bits = 24", "bits = 12"),
        ("bits = 24", "bits = 64"),
        ("bits = 24", "bits = -8"),
        ("modulus = 256", "modulus = 257"),
        ("modulus = 256", "modulus = 1"),
        ("poly = 0x1021", "poly = 0"),
        ("init = 0xFFFF", "init = 0x10000"),
        ("bit = 5", "bit = 8"),
        ("baud = 115200", "baud = 0"),
        ("data = 8", "data = 7"),
        ("rate_hz = 300.0", "rate_hz = 0.0"),
        ("rate_tol = 0.03", "rate_tol = -0.1"),
        ("name = \"struna/vg910d@1\"", "name = \"two words\""),
        ("coding = \"twos\"", "coding = \"twos\"\nnull = 5"),
    ] {
        let error = refusal(from, to);
        assert!(matches!(error.fault, Fault::OutOfRange { .. }), "{to}: {error}");
        assert!(error.to_string().contains("; write "), "no remedy in: {error}");
    }
}

#[test]
fn wrong_types_and_missing_keys_are_named() {
    for (from, to) in [("len = 11", "len = \"11\""), ("refin = false", "refin = 0")] {
        assert!(matches!(refusal(from, to).fault, Fault::WrongType { .. }), "{to}");
    }
    for (from, key) in [
        ("len = 11", "frame.len"),
        ("provenance = \"unverified\"", "frame.provenance"),
        ("unit = \"degC\"", "frame.field[1].unit"),
        ("poly = 0x1021", "frame.check.poly"),
        ("rate_tol = 0.03", "timing.rate_tol"),
    ] {
        let error = refusal(from, "");
        assert_eq!((error.key.as_str(), &error.fault), (key, &Fault::Missing));
    }
    let null = refusal("coding = \"twos\"", "coding = \"offset_binary\"");
    assert_eq!((null.key.as_str(), null.fault), ("frame.field[0].null", Fault::Missing));
    for (from, to) in [("\"deg/s\"", "\"deg/h\""), ("\"be\"", "\"big\""), ("crc16", "sum8")] {
        assert!(matches!(refusal(from, to).fault, Fault::UnknownWord { .. }), "{to}");
    }
}

#[test]
fn a_frame_without_a_counter_is_allowed() {
    let counter = "[frame.seq]\nat = 2\nbits = 8\nmodulus = 256\n";
    let spec = FrameSpec::from_toml(&DEFAULT.replacen(counter, "", 1)).unwrap();
    assert_eq!(spec.sequence(), None);
}

#[test]
fn a_file_too_long_or_too_deep_is_refused() {
    let long = format!("{DEFAULT}#{}", "x".repeat(300_000));
    assert!(matches!(FrameSpec::from_toml(&long).unwrap_err().fault, Fault::TooLong { .. }));
    let deep = format!("a = {}", "[".repeat(30_000));
    assert!(matches!(FrameSpec::from_toml(&deep).unwrap_err().fault, Fault::Syntax { .. }));
    let many = format!("{}\n{DEFAULT}", "[[frame.flag]]\n".repeat(33));
    assert!(FrameSpec::from_toml(&many).is_err());
}

/// Pieces of TOML that mean something here, so that mutations get past the parser.
fn fragment() -> impl Strategy<Value = String> {
    let known = prop::sample::select(vec![
        "nan",
        "-1",
        "0",
        "1e999",
        "18446744073709551616",
        "[",
        "]",
        "[[frame.field]]\n",
        "\"",
        "[frame.seq]\n",
        "at = 63\n",
        "len = 64\n",
        "bits = 32\n",
        "null = 4294967295\n",
        "coding = \"offset_binary\"\n",
        "=",
        "\n",
        "é",
        "\u{0}",
        "'''",
        "0x7FFFFFFFFFFFFFFF",
    ]);
    prop_oneof![known.prop_map(str::to_owned), ".{0,3}"]
}

proptest! {
    #[test]
    fn no_text_upsets_the_reader(text in "\\PC{0,200}") {
        prop_assert!(FrameSpec::from_toml(&text).is_err());
    }

    #[test]
    fn no_mutation_of_a_good_file_upsets_the_reader(
        edits in prop::collection::vec(
            (any::<prop::sample::Index>(), 0_usize..12, fragment()),
            1..4,
        ),
    ) {
        let mut text: Vec<char> = DEFAULT.chars().filter(char::is_ascii).collect();
        for (place, removed, inserted) in edits {
            let from = place.index(text.len());
            let to = (from + removed).min(text.len());
            text.splice(from..to, inserted.chars());
        }
        let text: String = text.into_iter().collect();
        match FrameSpec::from_toml(&text) {
            Ok(spec) => prop_assert!(spec.frame_len() <= 64 && !spec.fields().is_empty()),
            Err(error) => {
                prop_assert!(error.line <= text.lines().count() + 1, "{error}");
                prop_assert!(error.to_string().len() < 1000, "{error}");
            }
        }
    }
}
