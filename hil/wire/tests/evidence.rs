//! What noise can and cannot do to frames of little evidence, and what a clock adds.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use struna_wire::{Counters, Decoder, Encoder, Frame, FrameSpec, LossResolver};

macro_rules! shipped {
    ($file:literal) => {
        FrameSpec::from_toml(include_str!(concat!("../../../frames/", $file, ".toml"))).unwrap()
    };
}

/// Repeatable bytes without pattern (splitmix64).
struct Noise(u64);

impl Noise {
    fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn bytes(&mut self, count: usize) -> Vec<u8> {
        (0..count.div_ceil(8)).flat_map(|_| self.word().to_le_bytes()).take(count).collect()
    }
}

fn decode(spec: &FrameSpec, bytes: &[u8]) -> (Vec<Frame>, Counters) {
    let mut decoder = Decoder::new(spec.clone());
    let mut frames = Vec::new();
    decoder.push(bytes, &mut |frame| frames.push(*frame));
    (frames, decoder.finish())
}

/// A slow swing, as the layout's rate field has it.
fn swing(spec: &FrameSpec, k: usize) -> Vec<i64> {
    let rate = spec.field_index("rate").unwrap();
    let mut raw = vec![0; spec.fields().len()];
    raw[rate] = spec.fields()[rate].from_si((k as f64 * 0.01).sin());
    if let Some(status) = spec.field_index("status") {
        raw[status] = 1;
    }
    raw
}

fn stream(spec: &FrameSpec, frames: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(spec);
    for k in 0..frames {
        encoder.encode(&swing(spec, k), &mut bytes).unwrap();
    }
    bytes
}

const MEGABYTE: usize = 1_000_000;

#[test]
fn noise_of_a_tenth_of_a_gigabyte_holds_no_frame_of_any_shipped_layout() {
    // Layouts and megabytes: fewer where each byte takes long.
    let specs = [
        (shipped!("vg910d"), 100),
        (shipped!("vg910d-raw4"), 100),
        (shipped!("vg910d-sum"), 100),
        (shipped!("adis16100"), 100),
        (shipped!("kvh-dsp3000-1k"), 20),
        (shipped!("kvh-dsp3000-ascii"), 20),
        (shipped!("fog-septet-xor"), 20),
    ];
    let mut decoders = specs.map(|(spec, megabytes)| (Decoder::new(spec), megabytes));
    let mut noise = Noise(1);
    let piece = noise.bytes(MEGABYTE);
    for k in 0..100_u8 {
        // Each megabyte differs from all others in every byte; so does what its frames would be.
        let turned: Vec<u8> =
            piece.iter().map(|byte| byte.wrapping_mul(2 * (k % 50) + 1).wrapping_add(k)).collect();
        for (decoder, _) in decoders.iter_mut().filter(|(_, megabytes)| k < *megabytes) {
            decoder.push(&turned, &mut |_| ());
        }
    }
    for (decoder, _) in &mut decoders {
        let name = decoder.spec().name().to_owned();
        let counters = decoder.finish();
        let per_byte = decoder.spec().evidence().false_accepts_per_byte();
        let (expected, found) = (counters.bytes as f64 * per_byte, counters.ok);
        println!("{name}: {found} false frames in {} bytes", counters.bytes);
        // At most 0.023 expected of each, so two of one kind come once in 3800 runs.
        assert!(expected < 0.024, "{name}: {expected}");
        assert!(found <= 1, "{name}: {found} false frames");
    }
}

#[test]
fn without_company_weak_frames_would_be_found_everywhere_in_noise() {
    // What the rule of company is for: one frame at a time is believed when the file insists.
    let text = include_str!("../../../frames/fog-septet-xor.toml");
    let rash = FrameSpec::from_toml(&format!("{text}\n[frame.plausible]\nconfirm = 1\n")).unwrap();
    let expected = 4e6 * (-rash.evidence().frame_bits()).exp2();
    let found = decode(&rash, &Noise(2).bytes(4 * MEGABYTE)).1.ok as f64;
    // Poisson: 1.9 expected; 12 or more come once in a million runs.
    assert!(found < 12.0 && expected > 1.0, "{found} for {expected}");
    let sync_only = "[frame]\nname='x'\nkind='fixed'\nprovenance='unverified'\nsync='A5'\n\
                     len=4\n[frame.check]\nkind='none'\n[frame.plausible]\nconfirm=1\n\
                     [[frame.field]]\nname='rate'\nat=1\nbits=24\nendian='be'\n\
                     coding='twos'\nunit='counts'\n[line]\nbaud=115200\ndata=8\n\
                     parity='none'\nstop=1\n[timing]\nrate_hz=1.0\nrate_tol=0.0\n";
    let rash = FrameSpec::from_toml(sync_only).unwrap();
    let found = decode(&rash, &Noise(3).bytes(MEGABYTE)).1.ok as f64;
    // One in 256 starts, less the bytes that frames take: 3861 per megabyte; 6 sigma are 370.
    assert!((found - 3861.0).abs() < 370.0, "{found}");
}

#[test]
fn a_weak_stream_is_found_behind_noise_and_told_right() {
    for spec in [
        shipped!("vg910d-raw4"),
        shipped!("vg910d-sum"),
        shipped!("kvh-dsp3000-1k"),
        shipped!("fog-septet-xor"),
    ] {
        let clean = stream(&spec, 400);
        for seed in 0..50 {
            let mut noise = Noise(seed);
            let length = usize::try_from(noise.word() % 200).unwrap();
            let bytes = [noise.bytes(length), clean.clone()].concat();
            let (told, _) = decode(&spec, &bytes);
            // A start in the noise may take frames with it: five lengths until that is given up,
            // and a row to be believed again.
            let most = 6 + spec.evidence().confirm;
            assert!(told.len() >= 400 - most, "{}, seed {seed}: {}", spec.name(), told.len());
            for (back, frame) in told.iter().rev().take(390).enumerate() {
                assert_eq!(frame.raw(), swing(&spec, 399 - back), "{}, seed {seed}", spec.name());
            }
        }
    }
}

#[test]
fn a_damaged_weak_frame_costs_itself_alone() {
    for spec in [shipped!("vg910d-sum"), shipped!("kvh-dsp3000-1k"), shipped!("fog-septet-xor")] {
        let clean = stream(&spec, 60);
        let len = spec.wire_len();
        for bit in 0..len * 8 {
            let mut bytes = clean.clone();
            bytes[30 * len + bit / 8] ^= 1 << (bit % 8);
            let (told, counters) = decode(&spec, &bytes);
            assert_eq!(told.len(), 59, "{}, bit {bit}: {counters:?}", spec.name());
            assert_eq!(counters.skipped_bytes, len as u64, "{}, bit {bit}", spec.name());
            assert_eq!((counters.locks, counters.unlocks), (1, 0));
        }
    }
}

#[test]
fn a_lost_byte_costs_one_frame() {
    for spec in [shipped!("vg910d"), shipped!("vg910d-sum"), shipped!("adis16100")] {
        let clean = stream(&spec, 60);
        let len = spec.wire_len();
        for at in 0..len {
            let mut bytes = clean.clone();
            bytes.remove(30 * len + at);
            let (told, counters) = decode(&spec, &bytes);
            assert_eq!(told.len(), 59, "{}, byte {at}: {counters:?}", spec.name());
            assert_eq!((counters.lost, counters.resyncs), (1, 1), "{}, byte {at}", spec.name());
        }
    }
}

#[test]
fn a_rate_that_jumps_is_refused_once_and_believed_when_it_stays() {
    let spec = shipped!("vg910d-raw4");
    let rate = &spec.fields()[0];
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&spec);
    for k in 0..40 {
        let deg_s: f64 = match k {
            10 => 90.0,
            20.. => 119.0,
            _ => 0.0,
        };
        encoder.encode(&[rate.from_si(deg_s.to_radians())], &mut bytes).unwrap();
    }
    let (told, counters) = decode(&spec, &bytes);
    // Frame 10 alone, and frames 20 on until the gate has grown from 30 to 120 deg/s with the
    // frames that went by: three of them.
    let expected: Vec<_> = (0..10).chain(11..20).chain(23..40).map(|k| k >= 20).collect();
    let high: Vec<_> = told.iter().map(|frame| frame.raw()[0] > 1 << 21).collect();
    assert_eq!(high, expected);
    assert_eq!(counters.implausible, 4);
}

#[test]
fn a_clock_counts_the_turns_of_the_counter() {
    let spec = shipped!("vg910d");
    let clean = stream(&spec, 2000);
    let (len, period_s) = (spec.wire_len(), 1.0 / 300.0);
    let mut decoder = Decoder::new(spec.clone());
    let mut told = Vec::new();
    // 1.3 s of frames, then nothing for 3.3 s, in reads of three frames, 4 ms late.
    let arrived = (0..399).chain(1400..2000).collect::<Vec<usize>>();
    for read in arrived.chunks(3) {
        let bytes: Vec<u8> =
            read.iter().flat_map(|k| &clean[k * len..(k + 1) * len]).copied().collect();
        let arrival_s = read[read.len() - 1] as f64 * period_s + 0.004;
        decoder.push_at(&bytes, arrival_s, &mut |frame| told.push(*frame));
    }
    let indices: Vec<_> = told.iter().map(|frame| frame.index).collect();
    let expected: Vec<_> = arrived.iter().map(|k| *k as u64).collect();
    assert_eq!(indices, expected);
    assert_eq!(decoder.finish().lost, 1001);
    let inferred: Vec<_> = told.iter().filter(|frame| frame.inferred).collect();
    assert_eq!(inferred.len(), 1);
    assert_eq!(inferred[0].lost_before, 1001);
    // Without the clock, three turns of the counter are missing.
    let bytes: Vec<u8> =
        arrived.iter().flat_map(|k| &clean[k * len..(k + 1) * len]).copied().collect();
    assert_eq!(decode(&spec, &bytes).1.lost, 1001 - 3 * 256);
}

#[test]
fn a_clock_finds_gaps_between_frames_without_a_counter() {
    let spec = shipped!("fog-septet-xor");
    let clean = stream(&spec, 300);
    let (len, period_s) = (spec.wire_len(), 1.0 / 2000.0);
    let resolver = LossResolver::of(spec.timing()).with_latency_s(0.016);
    let mut decoder = Decoder::new(spec.clone()).with_clock(resolver);
    let mut told = Vec::new();
    // A USB bridge hands over every 16 ms what it has: 32 frames. 64 ms go missing.
    for read in (0..96).chain(224..300).collect::<Vec<usize>>().chunks(32) {
        let bytes = &clean[read[0] * len..(read[read.len() - 1] + 1) * len];
        let arrival_s = (read[read.len() - 1] as f64 * period_s / 0.016).ceil() * 0.016;
        decoder.push_at(bytes, arrival_s, &mut |frame| told.push(*frame));
    }
    let gaps: Vec<_> = told.iter().filter(|frame| frame.lost_before > 0).collect();
    assert_eq!(gaps.len(), 1);
    // The bridge hides up to one of its periods, 32 frames.
    assert!(gaps[0].inferred && gaps[0].lost_before.abs_diff(128) <= 32, "{:?}", gaps[0]);
    assert_eq!(gaps[0].raw(), swing(&spec, 224));
}

#[test]
fn float_fields_that_are_no_numbers_are_absent() {
    let text = include_str!("../../../frames/vg910d.toml")
        .replace(
            "bits = 24\nendian = \"be\"\ncoding = \"twos\"",
            "bits = 32\nendian = \"le\"\ncoding = \"float\"",
        )
        .replace("at = 7", "at = 8")
        .replace("at = 9", "at = 10")
        .replace("[2, 8]", "[2, 9]")
        .replace("len = 11", "len = 12")
        .replace("scale = 3.0517578125e-5", "scale = 1.0");
    let spec = FrameSpec::from_toml(&text).unwrap();
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&spec);
    for value in [1.5_f32, f32::NAN, f32::INFINITY] {
        encoder.encode(&[i64::from(value.to_bits()), 0, 0], &mut bytes).unwrap();
    }
    let (told, _) = decode(&spec, &bytes);
    assert_eq!(told.iter().map(|frame| frame.has(0)).collect::<Vec<_>>(), [true, false, false]);
    let rad_s = spec.fields()[0].to_si(told[0].raw()[0]);
    assert!((rad_s.to_degrees() - 1.5).abs() < 1e-15);
    assert_eq!(&bytes[4..8], 1.5_f32.to_le_bytes());
}
