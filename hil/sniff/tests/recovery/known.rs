//! The frames of known gyros, encoded as the bench's emulator does.

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use struna_sniff::{Alternative, Labels, Shape, Verdict, sniff};
use struna_wire::{Coding, Decoder, Encoder, FieldSpec, FrameSpec};

const TRIALS: u64 = 20;

const VG910D: &str = include_str!("../../../../frames/vg910d.toml");
const VG910D_RAW4: &str = include_str!("../../../../frames/vg910d-raw4.toml");
const VG910D_SUM: &str = include_str!("../../../../frames/vg910d-sum.toml");
const ADIS16100: &str = include_str!("../../../../frames/adis16100.toml");
const KVH_1K: &str = include_str!("../../../../frames/kvh-dsp3000-1k.toml");
const KVH_ASCII: &str = include_str!("../../../../frames/kvh-dsp3000-ascii.toml");
const FOG_SEPTET_XOR: &str = include_str!("../../../../frames/fog-septet-xor.toml");

/// The head of a frame file made here.
fn head(kind: &str, sync: &str, len: usize, check: &str) -> String {
    format!(
        "[frame]\nname = \"test\"\nkind = \"{kind}\"\nprovenance = \"unverified\"\n\
         sync = \"{sync}\"\nlen = {len}\n[frame.check]\n{check}\n\
         [line]\nbaud = 921600\ndata = 8\nparity = \"none\"\nstop = 1\n\
         [timing]\nrate_hz = 400.0\nrate_tol = 0.02\n"
    )
}

fn field(name: &str, at: usize, size: &str, coding: &str) -> String {
    format!(
        "[[frame.field]]\nname = \"{name}\"\nat = {at}\n{size}\ncoding = \"{coding}\"\n\
         unit = \"counts\"\n"
    )
}

fn trap() -> String {
    head("fixed", "99 66", 10, "kind = \"sum8\"\nrange = [0, 8]\nat = 9")
        + &field("status", 2, "bits = 8", "unsigned")
        + &field("rate", 3, "bits = 32\nendian = \"be\"", "twos")
        + &field("temp", 7, "bits = 16\nendian = \"be\"", "twos")
}

/// Frames published elsewhere, beside the shipped files.
fn published() -> Vec<String> {
    let be24 = "bits = 24\nendian = \"be\"";
    let crc32 = "kind = \"crc32\"\npoly = 0x04C11DB7\ninit = 0xFFFFFFFF\nrefin = false\n\
                 refout = false\nxorout = 0\nrange = [0, 9]\nat = 10\nendian = \"be\"";
    vec![
        head("fixed", "A5", 5, "kind = \"sum8\"\nrange = [1, 3]\nat = 4")
            + &field("rate", 1, be24, "twos"),
        head("septet", "80", 8, "kind = \"sum8\"\nrange = [1, 6]\nat = 7")
            + &field("rate", 1, "septets = 4\nendian = \"be\"", "twos")
            + &field("temp", 5, "septets = 2\nendian = \"be\"", "twos"),
        trap(),
        head("fixed", "FE 81 FF 55", 14, crc32)
            + "[frame.seq]\nat = 4\nbits = 8\nmodulus = 128\n"
            + &field("rate", 5, "bits = 32\nendian = \"be\"", "float")
            + &field("status", 9, "bits = 8", "unsigned"),
        head("fixed", "EB 90", 7, "kind = \"none\"")
            + "[frame.seq]\nat = 2\nbits = 8\nmodulus = 256\n"
            + &field("rate", 3, "bits = 32\nendian = \"le\"", "twos"),
    ]
}

/// Raw values of one frame: the rate as given, others as they would idle.
fn values(spec: &FrameSpec, rate: f64, k: u32, rng: &mut impl Rng) -> Vec<i64> {
    // One frame in 141 carries the temperature where a word is shared.
    let channel = i64::from(k % 141 == 140);
    let value = |field: &FieldSpec| match field.name() {
        "rate" => rate_counts(field, rate, rng.random_range(-3.0..3.0)),
        "chan" => channel,
        "temp" => (200 + i64::from(k / 500) + rng.random_range(-2..=2)).min(field.raw_max()),
        "status" => 1,
        _ => 0,
    };
    spec.fields().iter().map(value).collect()
}

/// `rate` is a share of the range; noise is in counts.
fn rate_counts(field: &FieldSpec, rate: f64, noise: f64) -> i64 {
    #[expect(clippy::cast_possible_truncation, reason = "a share of at most 2^32")]
    match field.coding() {
        Coding::Float => i64::from(((rate * 200.0 + noise * 1e-3) as f32).to_bits()),
        Coding::Decimal { .. } => (rate * 2e8 + 1000.0 * noise) as i64,
        _ => {
            #[expect(clippy::cast_precision_loss, reason = "at most 2^34")]
            let full = field.raw_max() as f64;
            (rate * full + noise) as i64
        }
    }
}

/// Rest, then two tones, or rest throughout.
fn stream(spec: &FrameSpec, seconds: f64, turned: bool, rng: &mut impl Rng) -> Vec<u8> {
    let rate_hz = spec.timing().rate_hz;
    let (share, hz) = (rng.random_range(0.1..0.4), rng.random_range(0.3..0.9));
    let mut encoder = Encoder::new(spec);
    let mut bytes = Vec::new();
    let mut k = 0;
    while f64::from(k) < seconds * rate_hz {
        let time_s = f64::from(k) / rate_hz;
        let moving = turned && time_s > 0.35 * seconds;
        let tone = (6.0 * hz * time_s).sin() + 0.3 * (17.0 * hz * time_s).sin();
        let rate = if moving { share * tone } else { 0.0 };
        encoder.encode(&values(spec, rate, k, rng), &mut bytes).unwrap();
        k += 1;
    }
    bytes
}

/// What a layout reads as the rate, frame by frame.
fn rates(spec: FrameSpec, bytes: &[u8]) -> Vec<i64> {
    let rate = spec.field_index("rate").unwrap();
    let mut decoder = Decoder::new(spec);
    let mut rates = Vec::new();
    decoder.push(bytes, &mut |frame| {
        if frame.has(rate) {
            rates.push(frame.raw()[rate]);
        }
    });
    rates
}

/// Sniffs at captures of `text` and reads a fresh stream with what comes of it.
fn assert_recognised(text: &str) {
    // Which steps of the rate are credible is not in the bytes; both shall read alike.
    let gate = ["[frame.plausible]", "rate_step_max"];
    let kept = text.lines().filter(|line| !gate.iter().any(|key| line.starts_with(key)));
    let spec = FrameSpec::from_toml(&kept.collect::<Vec<_>>().join("\n")).unwrap();
    let seconds = if spec.timing().rate_hz < 200.0 { 10.0 } else { 6.0 };
    let labels = Labels { name: "t".into(), baud: None, rate_hz: None, measured: false };
    for seed in 0..TRIALS {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let capture = stream(&spec, seconds, true, &mut rng);
        let begin = rng.random_range(0..spec.wire_len());
        let report = sniff(&capture[begin..], None);
        let first = &report.proposals[0];
        let proposed = first.to_toml(&labels).unwrap();
        let proposed_spec = FrameSpec::from_toml(&proposed).unwrap();
        let fresh = stream(&spec, 2.0, true, &mut rng);
        let (read, sent) = (rates(proposed_spec, &fresh), rates(spec.clone(), &fresh));
        // Decoders that ask neighbours for confirmation may begin a few frames later.
        let late = sent.len().saturating_sub(read.len());
        let name = spec.name();
        assert!(late <= 40 && !read.is_empty(), "{name}, seed {seed}: {late} late\n{proposed}");
        assert_eq!(read, sent[late..], "{name}, seed {seed}\n{proposed}");
    }
}

#[test]
fn the_gyros_of_the_2008_lab_are_recognised() {
    for text in [VG910D, VG910D_RAW4, VG910D_SUM, ADIS16100] {
        assert_recognised(text);
    }
}

#[test]
fn the_kvh_words_and_lines_and_septets_are_recognised() {
    for text in [KVH_1K, KVH_ASCII, FOG_SEPTET_XOR] {
        assert_recognised(text);
    }
}

#[test]
fn published_frames_are_recognised() {
    for text in published() {
        assert_recognised(&text);
    }
}

#[test]
fn known_gyros_at_rest_confirm_nothing() {
    for text in [VG910D, ADIS16100, KVH_1K, KVH_ASCII, FOG_SEPTET_XOR] {
        let spec = FrameSpec::from_toml(text).unwrap();
        let capture = stream(&spec, 6.0, false, &mut ChaCha8Rng::seed_from_u64(1));
        let verdict = sniff(&capture, None).verdict;
        assert!(!matches!(verdict, Verdict::Confirmed { .. }), "{}", spec.name());
    }
}

/// 99 + 66 + 01 = 100: the sum is the same with all three bytes and with none of them.
#[test]
fn ranges_that_hold_equally_are_all_listed() {
    let spec = FrameSpec::from_toml(&trap()).unwrap();
    let capture = stream(&spec, 6.0, true, &mut ChaCha8Rng::seed_from_u64(1));
    let report = sniff(&capture, None);
    let first = &report.proposals[0];
    let checks = first.alternatives.iter().find_map(|alternative| match alternative {
        Alternative::Checks(checks) => Some(checks),
        _ => None,
    });
    let mut ranges: Vec<_> = checks.unwrap().iter().map(|c| (c.first, c.last)).collect();
    ranges.sort_unstable();
    assert_eq!(ranges, [(0, 8), (3, 8)]);
    let Shape::Binary(layout) = &first.shape else { panic!("{:?}", first.shape) };
    assert_eq!(layout.check.unwrap().last, 8);
}
