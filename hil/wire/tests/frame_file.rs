//! Frame files: the default one says what its documentation says, and a wrong one is refused with
//! its line, key, value and remedy.

use proptest::prelude::*;
use std::f64::consts::PI;
use struna_settings::{Fault, SettingsError};
use struna_wire::{CheckKind, Coding, Crc, Endian, FrameSpec, Parity, Provenance, Unit};

const DEFAULT: &str = include_str!("../../../frames/vg910d.toml");

#[test]
fn the_default_frame_has_the_documented_numbers() {
    let spec = FrameSpec::from_toml(DEFAULT).unwrap();
    assert_eq!(spec.name(), "struna/vg910d@1");
    assert_eq!(spec.provenance(), Provenance::Unverified);
    assert_eq!((spec.frame_len(), spec.sync()), (11, &[0xA5, 0x5A][..]));
    assert_eq!((spec.check().range(), spec.check().at()), ((2, 8), 9));
    let CheckKind::Crc(params) = spec.check().kind() else { panic!("{:?}", spec.check()) };
    assert_eq!(Crc::new(params).checksum(b"123456789"), 0x29B1);
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
    let error = refusal("kind = \"fixed\"", "kind = \"mavlink\"");
    assert_eq!(
        error.to_string(),
        format!(
            "line {}, column 8: `frame.kind` = \"mavlink\": not supported; write one of: \
             \"fixed\", \"septet\", \"cobs\", \"ascii\"",
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
    for (from, to) in [("\"deg/s\"", "\"deg/h\""), ("\"be\"", "\"big\""), ("crc16", "crc12")] {
        assert!(matches!(refusal(from, to).fault, Fault::UnknownWord { .. }), "{to}");
    }
}

/// The refusal of another shipped file after an edit.
#[track_caller]
fn refused(file: &str, from: &str, to: &str) -> String {
    assert!(file.contains(from), "no {from:?} in the file");
    FrameSpec::from_toml(&file.replacen(from, to, 1)).expect_err(to).to_string()
}

#[test]
fn fields_that_share_bits_must_exclude_each_other() {
    const ADIS: &str = include_str!("../../../frames/adis16100.toml");
    let shared = "bits of byte 3 already belong to frame.field[1]; move one of them, or let their \
                  `when` exclude each other";
    let text = refused(ADIS, "equals = 1 }", "equals = 0 }");
    assert!(text.contains("`frame.field[2].at` = 3") && text.contains(shared), "{text}");
    let text = refused(ADIS, "when = { field = \"chan\", equals = 1 }", "");
    assert!(text.contains("bits of byte 3 already belong to frame.field[1]; move one"), "{text}");
    let text = refused(ADIS, "shift = 4", "shift = 3");
    assert!(text.contains("bits of byte 3 already belong to frame.field[0]"), "{text}");
    for (from, to, part) in [
        (
            "equals = 3 }",
            "equals = 4 }",
            "`frame.field[4].when.equals` = 4: not usable; write 0 to 3",
        ),
        ("field = \"chan\", equals = 0", "field = \"rate\", equals = 0", "write one of: \"chan\""),
        ("field = \"chan\", equals = 0", "feld = \"chan\", equals = 0", "did you mean `field`?"),
        ("name = \"chan\"", "name = \"canal\"", "write one of: \"canal\""),
        ("coding = \"unsigned\"", "coding = \"twos\"", "declare the deciding field first"),
        ("bytes = 2\nbits = 12", "bits = 12", "or say the `bytes` it is in"),
        ("bytes = 2\nbits = 12", "bytes = 1\nbits = 12", "do not fit in 1 byte of 8 bits"),
    ] {
        let text = refused(ADIS, from, to);
        assert!(text.contains(part), "{to}: {text}");
    }
}

#[test]
fn each_kind_refuses_what_it_cannot_carry() {
    const KVH: &str = include_str!("../../../frames/kvh-dsp3000-1k.toml");
    const SEPTET: &str = include_str!("../../../frames/fog-septet-xor.toml");
    const LINES: &str = include_str!("../../../frames/kvh-dsp3000-ascii.toml");
    const SUM: &str = include_str!("../../../frames/vg910d-sum.toml");
    let cobs = SUM.replace("kind = \"fixed\"", "kind = \"cobs\"");
    for (file, from, to, part) in [
        (KVH, "sync = \"20\"", "", "this key is missing"),
        (KVH, "\"60\"", "\"40\"", "byte 0 of `sync` has bits set that do not count"),
        (KVH, "\"60\"", "\"60 FF\"", "write 1 bytes like `sync`"),
        (KVH, "bits = 26", "bits = 27", "leave one to the parity bit"),
        (KVH, "bits = 26", "bits = 28", "already belong to"),
        (KVH, "bits = 1\n", "bits = 8\n", "do not fit in 1 byte"),
        (KVH, "range = [0, 3]", "range = [1, 3]", "leave one to the parity bit"),
        (KVH, "rate_step_max = 20.0", "rate_step_max = 0.0", "a number greater than 0"),
        (KVH, "rate_step_max = 20.0", "confirm = 25", "write 1 to 24"),
        (KVH, "name = \"rate\"", "name = \"turn\"", "there is no field called rate"),
        (KVH, "rate_tol = 0.03", "time = \"counter\"\nrate_tol = 0.03", "the frame has no counter"),
        (SEPTET, "sync = \"80\"", "sync = \"70\"", "one byte with bit 7 set"),
        (SEPTET, "sync = \"80\"", "sync_mask = \"80\"", "no such key"),
        (SEPTET, "kind = \"xor8\"", "kind = \"crc16\"", "bytes of septets have bit 7 clear"),
        (SEPTET, "septets = 5", "septets = 6", "write 1 to 5"),
        (SEPTET, "septets = 5", "septets = 5\nbits = 32", "remove this key"),
        (SEPTET, "septets = 5\nendian = \"le\"", "bits = 8", "write septets = 1"),
        (SUM, "bits = 24", "septets = 3", "septets exist in kind = \"septet\" only"),
        (SUM, "coding = \"twos\"", "coding = \"float\"", "write bits = 32"),
        (SUM, "coding = \"twos\"", "coding = \"decimal\"", "write one of: \"twos\""),
        (LINES, "separator = \" \"", "separator = \";\"", "write one of: \" \", \",\""),
        (LINES, "kind = \"none\"", "kind = \"sum8\"", "\"xor8\" (sent as *hh) or \"none\""),
        (LINES, "column = 1", "column = 0", "column 0 already belongs to frame.field[0]"),
        (LINES, "column = 1", "column = 2", "raise `frame.columns`"),
        (LINES, "column = 1", "at = 1", "no such key"),
        (LINES, "columns = 2", "columns = 2\nsync = \"41\"", "a character that no number holds"),
        (LINES, "columns = 2", "columns = 2\nsync = \"0A\"", "printable ASCII"),
        (LINES, "columns = 2", "columns = 2\nlen = 9", "no such key"),
        (LINES, "columns = 2", "columns = 16", "at most 128 are read"),
        (LINES, "decimals = 6", "decimals = 15", "write 0 to 14"),
        (LINES, "coding = \"hex\"", "coding = \"twos\"", "write one of: \"decimal\", \"hex\""),
        (LINES, "bit = 0", "bit = 4", "write 0 to 3"),
        (cobs.as_str(), "len = 7", "len = 7", "no such key"),
    ] {
        let text = refused(file, from, to);
        assert!(text.contains(part), "{to}: {text}");
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
