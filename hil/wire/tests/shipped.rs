//! The shipped frames, byte for byte: each example was put together by hand from the layout that
//! the file's heading describes, not from the code.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use struna_wire::{Counters, Decoder, Encoder, Frame, FrameSpec, Kind, TimeSource};

macro_rules! shipped {
    ($file:literal) => {
        FrameSpec::from_toml(include_str!(concat!("../../../frames/", $file, ".toml"))).unwrap()
    };
}

fn all() -> [FrameSpec; 7] {
    [
        shipped!("vg910d"),
        shipped!("vg910d-raw4"),
        shipped!("vg910d-sum"),
        shipped!("adis16100"),
        shipped!("kvh-dsp3000-1k"),
        shipped!("kvh-dsp3000-ascii"),
        shipped!("fog-septet-xor"),
    ]
}

fn decode(spec: &FrameSpec, bytes: &[u8]) -> (Vec<Frame>, Counters) {
    let mut decoder = Decoder::new(spec.clone());
    let mut frames = Vec::new();
    decoder.push(bytes, &mut |frame| frames.push(*frame));
    (frames, decoder.finish())
}

/// Raw values by name; fields that are not named are zero.
fn raw(spec: &FrameSpec, values: &[(&str, i64)]) -> Vec<i64> {
    let mut raw = vec![0; spec.fields().len()];
    for (name, value) in values {
        raw[spec.field_index(name).unwrap()] = *value;
    }
    raw
}

/// Encodes frames with these values, compares them with `bytes`, and decodes them again.
#[track_caller]
fn is_on_the_wire(spec: &FrameSpec, first: u64, frames: &[&[(&str, i64)]], bytes: &[u8]) {
    let mut encoder = Encoder::starting_at(spec, first);
    let mut encoded = Vec::new();
    for values in frames {
        encoder.encode(&raw(spec, values), &mut encoded).unwrap();
    }
    assert_eq!(encoded, bytes, "{encoded:02X?}");
    // A line feed begins the first line; elsewhere it is noise before the first frame.
    let (told, counters) = decode(spec, &[b"\n", bytes].concat());
    assert_eq!((told.len(), counters.skipped_bytes), (frames.len(), 1), "{counters:?}");
    for (frame, values) in told.iter().zip(frames) {
        assert_eq!(frame.raw(), raw(spec, values));
        for (name, _) in *values {
            assert!(frame.has(spec.field_index(name).unwrap()), "{name}");
        }
    }
}

#[test]
fn each_has_its_name_its_kind_and_room_on_its_line() {
    let told = all().map(|spec| {
        let load = spec.bits_per_s() / f64::from(spec.line().baud);
        let percent = (100.0 * load).round();
        (spec.name().to_owned(), spec.kind(), spec.wire_len(), percent, spec.evidence().confirm)
    });
    let expected = [
        ("struna/vg910d@1", Kind::Fixed, 11, 29.0, 1),
        ("struna/vg910d-raw4@1", Kind::Fixed, 5, 13.0, 2),
        ("struna/vg910d-sum@1", Kind::Fixed, 7, 18.0, 2),
        ("struna/adis16100@1", Kind::Fixed, 7, 43.0, 1),
        ("kvh/dsp3000-1k@1", Kind::Fixed, 4, 35.0, 5),
        ("kvh/dsp3000-ascii@1", Kind::Ascii, 15, 39.0, 1),
        ("struna/fog-septet-xor@1", Kind::Septet, 7, 25.0, 2),
    ];
    assert_eq!(
        told,
        expected.map(|(name, k, len, load, row)| (name.to_owned(), k, len, load, row))
    );
}

#[test]
fn time_comes_from_the_counter_where_there_is_one() {
    for spec in all() {
        let counted = spec.timing().time == TimeSource::Counter;
        assert_eq!(counted, spec.sequence().is_some(), "{}", spec.name());
    }
}

#[test]
fn vg910d_on_the_wire() {
    // 1 deg/s = 32768; 25.5 degC = 0x1980; the CRC is the crc crate's.
    let bytes = [0xA5, 0x5A, 0x07, 0x09, 0x00, 0x80, 0x00, 0x19, 0x80];
    let crc = crc::Crc::<u16>::new(&crc::CRC_16_IBM_3740).checksum(&bytes[2..]).to_be_bytes();
    let frame: &[_] = &[("rate", 32768), ("temp", 6528), ("status", 9)];
    is_on_the_wire(&shipped!("vg910d"), 7, &[frame], &[&bytes[..], &crc].concat());
}

#[test]
fn a_temperature_that_is_not_vouched_for_is_absent() {
    let text = include_str!("../../../frames/vg910d.toml")
        .replace("unit = \"degC\"", "unit = \"degC\"\nvalid_if = \"temp_valid\"");
    let spec = FrameSpec::from_toml(&text).unwrap();
    let temp = spec.field_index("temp").unwrap();
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&spec);
    encoder.encode(&raw(&spec, &[("temp", 5), ("status", 8)]), &mut bytes).unwrap();
    encoder.encode(&raw(&spec, &[("temp", 5), ("status", 7)]), &mut bytes).unwrap();
    let (told, _) = decode(&spec, &bytes);
    assert_eq!(told.iter().map(|frame| frame.has(temp)).collect::<Vec<_>>(), [true, false]);
    assert!(told.iter().all(|frame| frame.raw()[temp] == 5 && !frame.has(99)));
}

#[test]
fn vg910d_raw4_on_the_wire() {
    // -1 deg/s = -32768 = FF8000; 0; two frames, for one alone is not believed.
    let bytes = [0xA5, 0x5A, 0xFF, 0x80, 0x00, 0xA5, 0x5A, 0x00, 0x00, 0x00];
    is_on_the_wire(&shipped!("vg910d-raw4"), 0, &[&[("rate", -32768)], &[("rate", 0)]], &bytes);
}

#[test]
fn vg910d_sum_on_the_wire() {
    // FE + 12 + 34 + 56 = 19A; FF + 00 + 00 + 01 = 100.
    let bytes = [0xA5, 0x5A, 0xFE, 0x12, 0x34, 0x56, 0x9A, 0xA5, 0x5A, 0xFF, 0x00, 0x00, 0x01, 0];
    let frames: [&[_]; 2] = [&[("rate", 0x12_3456)], &[("rate", 1)]];
    is_on_the_wire(&shipped!("vg910d-sum"), 254, &frames, &bytes);
}

#[test]
fn adis16100_on_the_wire() {
    // Rate 0 is code 2048 = 0x800 on channel 0; 25 degC is code 0x800 on channel 1; half of 5 V is
    // code 0x800 on channel 2, and channel 3 holds one count.
    let words: [[u8; 3]; 4] = [[0, 0x08, 0x00], [1, 0x18, 0x00], [2, 0x28, 0x00], [3, 0x30, 0x01]];
    let crc = crc::Crc::<u16>::new(&crc::CRC_16_IBM_3740);
    let frame =
        |word: [u8; 3]| [&[0xA6, 0x6A][..], &word, &crc.checksum(&word).to_be_bytes()].concat();
    let spec = shipped!("adis16100");
    let frames: [&[_]; 4] = [
        &[("chan", 0), ("rate", 0)],
        &[("chan", 1), ("temp", 0)],
        &[("chan", 2), ("ain1", 2048)],
        &[("chan", 3), ("ain2", 1)],
    ];
    let bytes = words.map(frame).concat();
    is_on_the_wire(&spec, 0, &frames, &bytes);
    let (told, _) = decode(&spec, &bytes);
    for (k, frame) in told.iter().enumerate() {
        let carried: Vec<_> = (0..5).filter(|field| frame.has(*field)).collect();
        assert_eq!(carried, [0, k + 1], "each channel carries its own field and no other");
    }
    let field = |name| &spec.fields()[spec.field_index(name).unwrap()];
    assert!((field("temp").to_si(0) - 25.0).abs() < f64::EPSILON);
    // 5 V in 4096 counts is a binary fraction: exact.
    assert!((field("ain1").to_si(2048) - 2.5).abs() < f64::EPSILON);
    // 300 deg/s are 1230 counts.
    assert_eq!(field("rate").from_si(300.0_f64.to_radians()), 1230);
}

#[test]
fn kvh_dsp3000_words_on_the_wire() {
    // b31 valid, b30..29 = 01, b28..27 type, b26 parity (odd), b25..0 rate. Ones are counted
    // without the parity bit: A0000001 has 3 -> parity 0; A0000003 has 4 -> parity 1 (A4);
    // A3FFFFFF has 4 + 24 -> parity 1 (A7); 28000000, type 1 and not valid, has 2 -> parity 1 (2C).
    let words: [u32; 5] = [0xA000_0001, 0xA400_0003, 0xA7FF_FFFF, 0x2C00_0000, 0xA000_0001];
    let frames: [&[_]; 5] = [
        &[("status", 1), ("rate", 1)],
        &[("status", 1), ("rate", 3)],
        &[("status", 1), ("rate", -1)],
        &[("type", 1), ("rate", 0)],
        &[("status", 1), ("rate", 1)],
    ];
    let bytes: Vec<_> = words.iter().flat_map(|word| word.to_be_bytes()).collect();
    is_on_the_wire(&shipped!("kvh-dsp3000-1k"), 0, &frames, &bytes);
}

#[test]
fn kvh_dsp3000_lines_on_the_wire() {
    let spec = shipped!("kvh-dsp3000-ascii");
    let frames: [&[_]; 3] =
        [&[("rate", 12_345_678), ("status", 1)], &[("rate", -60), ("status", 1)], &[("rate", 0)]];
    is_on_the_wire(&spec, 0, &frames, b"12.345678 1\r\n-0.000060 1\r\n0.000000 0\r\n");
    // Filled up with zeros or blanks, without the CR, or before the first line feed.
    let (told, counters) =
        decode(&spec, b"9.000000 1\r\n-012.345678 1\n   1.500000   1 \r\n1.5 1\r\n1.0000000 1\r\n");
    let rates: Vec<_> = told.iter().map(|frame| frame.raw()[0]).collect();
    assert_eq!(rates, [-12_345_678, 1_500_000], "the first line may have lost its beginning");
    assert_eq!((counters.bad_check, counters.skipped_bytes), (2, 12 + 7 + 13));
}

#[test]
fn fog_septets_on_the_wire() {
    // 0x12345678 in septets, lowest first: 78, 2C, 51, 11, 01; xor 78^2C^51^11^01 = 15.
    // -1 as 32 bits: 7F 7F 7F 7F 0F; xor 0F.
    let bytes =
        [[0x80, 0x78, 0x2C, 0x51, 0x11, 0x01, 0x15], [0x80, 0x7F, 0x7F, 0x7F, 0x7F, 0x0F, 0x0F]];
    let frames: [&[_]; 2] = [&[("rate", 0x1234_5678)], &[("rate", -1)]];
    is_on_the_wire(&shipped!("fog-septet-xor"), 0, &frames, bytes.as_flattened());
}
