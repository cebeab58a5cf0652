//! A plan beside the layout it was made of: the same bytes, frames and counters.

#[path = "../../tests/stream/layouts.rs"]
mod layouts;
#[path = "../../tests/stream/noise.rs"]
mod noise;

use super::{AnyPlan, AnySendPlan};
use crate::{Counters, Decoder, EncodeError, Encoder, Frame, FrameSpec};
use layouts::{layout, shipped, vg910d};
use noise::{meaningful, raw_values, stream};
use proptest::prelude::*;

/// A layout that can be planned: half of the fixed ones, and the shipped ones among them.
fn planned() -> impl Strategy<Value = FrameSpec> {
    prop_oneof![1 => Just(vg910d()), 1 => shipped(), 6 => layout()]
        .prop_filter("a plan", |spec| AnyPlan::of(spec).is_some())
}

/// A layout whose frames can be sent by a plan: septets too, and checks by parity.
fn sendable() -> impl Strategy<Value = FrameSpec> {
    prop_oneof![1 => Just(vg910d()), 1 => shipped(), 6 => layout()]
        .prop_filter("a plan", |spec| AnySendPlan::of(spec).is_some())
}

/// Pushes `bytes` in pieces, the decoder's plan used or left out.
fn decode(
    spec: &FrameSpec,
    bytes: &[u8],
    piece: usize,
    use_plan: bool,
) -> (Vec<Frame>, Vec<Counters>) {
    let mut decoder = Decoder::new(spec.clone());
    if !use_plan {
        decoder = decoder.without_plan();
    }
    let (mut frames, mut counters) = (Vec::new(), Vec::new());
    for piece in bytes.chunks(piece) {
        decoder.push(piece, &mut |frame| frames.push(*frame));
        counters.push(decoder.counters());
    }
    counters.push(decoder.finish());
    (frames, counters)
}

/// Frames one after the other, none of them damaged.
fn intact(spec: &FrameSpec, first: u64, entropy: &[u64]) -> Vec<u8> {
    let mut encoder = Encoder::starting_at(spec, first);
    let mut bytes = Vec::new();
    for entropy in entropy {
        encoder.encode(&raw_values(spec, *entropy), &mut bytes).unwrap();
    }
    bytes
}

/// What a frame's values come of, and now and then one that may not fit.
fn entropy() -> impl Strategy<Value = (u64, Option<i64>)> {
    (any::<u64>(), prop::option::weighted(0.2, any::<i64>()))
}

#[test]
fn short_frames_of_the_shipped_layouts_are_planned() {
    let is_short = |text| match AnyPlan::of(&FrameSpec::from_toml(text).unwrap()) {
        Some(AnyPlan::Short(_)) => Some(true),
        Some(AnyPlan::Long(_)) => Some(false),
        None => None,
    };
    assert_eq!(is_short(include_str!("../../../../frames/adis16100.toml")), Some(true));
    assert_eq!(is_short(include_str!("../../../../frames/vg910d.toml")), Some(false));
    assert_eq!(is_short(include_str!("../../../../frames/vg910d-sum.toml")), None);
    assert_eq!(is_short(include_str!("../../../../frames/fog-septet-xor.toml")), None);
}

#[test]
fn short_frames_that_are_linear_are_sent_by_a_plan() {
    let is_short = |text: &str| match AnySendPlan::of(&FrameSpec::from_toml(text).expect(text)) {
        Some(AnySendPlan::Short(_)) => Some(true),
        Some(AnySendPlan::Long(_)) => Some(false),
        None => None,
    };
    let vg910d = include_str!("../../../../frames/vg910d.toml");
    assert_eq!(is_short(include_str!("../../../../frames/adis16100.toml")), Some(true));
    assert_eq!(is_short(include_str!("../../../../frames/fog-septet-xor.toml")), Some(true));
    assert_eq!(is_short(vg910d), Some(false));
    // Carries make a sum of bytes anything but linear, and COBS the frame.
    assert_eq!(is_short(include_str!("../../../../frames/vg910d-sum.toml")), None);
    let cobs = vg910d.replace("\"fixed\"", "\"cobs\"").replace("sync = \"A5 5A\"", "");
    assert_eq!(is_short(&cobs), None);
    assert_eq!(is_short(include_str!("../../../../frames/kvh-dsp3000-ascii.toml")), None);
    for (len, expected) in [(8, Some(true)), (9, Some(false)), (16, Some(false)), (17, None)] {
        let text = with_field_file("endian='be'\nbytes=2", &["at=4\nbits=8"]);
        assert_eq!(is_short(&text.replace("len=16", &format!("len={len}"))), expected, "{len}");
    }
}

#[test]
fn every_raw_value_of_a_gyro_is_sent_as_the_layout_says() {
    let spec = FrameSpec::from_toml(include_str!("../../../../frames/adis16100.toml")).unwrap();
    let mut encoder = Encoder::new(&spec);
    let mut plain = encoder.clone().without_plan();
    let (mut out, mut expected) = (Vec::with_capacity(64), Vec::with_capacity(64));
    for channel in -1..=4 {
        // One beyond either end of the code, whichever it is.
        for value in -2049..=4096 {
            let raw = [channel, value, value, value, value];
            let sent = encoder.encode(&raw, &mut out);
            assert_eq!(sent, plain.encode(&raw, &mut expected), "{raw:?}");
            assert_eq!(out, expected, "{raw:?}");
            assert_eq!(encoder.next_index(), plain.next_index());
            out.clear();
            expected.clear();
        }
    }
}

/// Vectors with no room, with room for the frame and with room for a word.
#[test]
fn room_in_the_output_makes_no_difference() {
    let spec = FrameSpec::from_toml(include_str!("../../../../frames/adis16100.toml")).unwrap();
    let raw = [0, 5, 0, 0, 0];
    let mut plain = Vec::new();
    Encoder::new(&spec).without_plan().encode(&raw, &mut plain).unwrap();
    for capacity in 0..20 {
        let mut out = Vec::with_capacity(capacity);
        out.extend_from_slice(&[7; 3]);
        let mut encoder = Encoder::new(&spec);
        encoder.encode(&raw, &mut out).unwrap();
        assert_eq!((&out[..3], &out[3..]), (&[7; 3][..], &plain[..]), "{capacity}");
        assert_eq!(encoder.next_index(), 1);
    }
}

#[test]
fn counters_of_more_than_a_byte_are_sent_whole() {
    for (bits, first) in [(10, 1000), (16, 65_530), (24, 1 << 23), (32, u64::from(u32::MAX) - 9)] {
        let bytes = usize::try_from(bits).unwrap().div_ceil(8);
        let place = format!("bytes={bytes}\nendian='le'");
        let text = with_field_file(&place, &["at=6\nbits=8"])
            .replace("modulus=1000\nbits=10", &format!("modulus={}\nbits={bits}", 1_u64 << bits));
        let spec = FrameSpec::from_toml(&text.replace("len=16", "len=8")).expect(&text);
        let mut encoder = Encoder::starting_at(&spec, first);
        for index in first..first + 20 {
            let mut out = Vec::with_capacity(16);
            encoder.encode(&[0x5A], &mut out).unwrap();
            let counter = index % (1 << bits);
            assert_eq!(out[1..5], counter.to_le_bytes()[..4], "{bits} bits");
            assert_eq!((out[0], out[6], out[7]), (0xA5, 0x5A, 0));
        }
    }
}

#[test]
fn frames_without_a_counter_are_counted_up_to_the_last_index_there_is() {
    let spec = FrameSpec::from_toml(include_str!("../../../../frames/vg910d-raw4.toml")).unwrap();
    let frame = [0xA5, 0x5A, 1, 2, 3];
    for first in [0, 1000, u64::MAX - 2, u64::MAX - 1, u64::MAX] {
        let mut encoder = Encoder::starting_at(&spec, first);
        for step in 0..5 {
            assert_eq!(encoder.next_index(), first.wrapping_add(step));
            let mut bytes = Vec::new();
            encoder.encode(&[0x01_0203], &mut bytes).unwrap();
            assert_eq!(bytes, frame);
        }
    }
}

#[test]
fn the_last_index_there_is_wraps_as_without_a_plan() {
    let spec = vg910d();
    let raw = vec![0; spec.fields().len()];
    let (mut planned, mut plain) = (Vec::new(), Vec::new());
    for (out, use_plan) in [(&mut planned, true), (&mut plain, false)] {
        let mut encoder = Encoder::starting_at(&spec, u64::MAX - 1);
        if !use_plan {
            encoder = encoder.without_plan();
        }
        for _ in 0..4 {
            encoder.encode(&raw, out).unwrap();
        }
        assert_eq!(encoder.next_index(), 2);
    }
    assert_eq!(planned, plain);
}

/// The file of a layout with a counter, and fields as described.
fn with_field_file(counter: &str, fields: &[&str]) -> String {
    let mut text = format!(
        "[frame]\nname='n'\nprovenance='unverified'\nkind='fixed'\nsync='A5'\nlen=16\n\
         [frame.check]\nkind='none'\n[frame.seq]\nat=1\nmodulus=1000\nbits=10\n{counter}\n"
    );
    for (k, field) in fields.iter().enumerate() {
        text +=
            &format!("[[frame.field]]\nname='f{k}'\ncoding='unsigned'\nunit='counts'\n{field}\n");
    }
    text += "[line]\nbaud=115200\ndata=8\nparity='none'\nstop=1\n\
             [timing]\nrate_hz=1.0\nrate_tol=0.0\n";
    text
}

/// That layout.
fn with_fields(counter: &str, fields: &[&str]) -> FrameSpec {
    let text = with_field_file(counter, fields);
    FrameSpec::from_toml(&text).expect(&text)
}

#[test]
fn numbers_in_either_order_are_planned_and_one_field_may_decide() {
    let is_planned =
        |counter, fields: &[&str]| AnyPlan::of(&with_fields(counter, fields)).is_some();
    let [big, little] = ["bytes=2\nendian='be'", "bytes=2\nendian='le'"];
    for counter in [big, little] {
        let fields = ["at=4\nbits=24\nendian='be'", "at=8\nbits=32\nendian='le'"];
        assert!(is_planned(counter, &fields));
    }
    let decided = |by: usize, at: usize, equals: i64| {
        format!("at={at}\nbits=8\nwhen={{field='f{by}',equals={equals}}}")
    };
    let [first, second] = ["at=4\nbits=8", "at=5\nbits=8"];
    let by_one = [first, &decided(0, 6, 0), &decided(0, 7, 255)];
    assert!(is_planned(big, &by_one));
    let by_two = [first, second, &decided(0, 6, 1), &decided(1, 7, 1)];
    assert!(!is_planned(big, &by_two));
    let by_a_long_one = ["at=4\nbytes=2\nbits=9\nendian='be'", &decided(0, 6, 1)];
    assert!(!is_planned(big, &by_a_long_one));
}

#[test]
fn every_kind_of_frame_follows_every_other() {
    let spec = FrameSpec::from_toml(include_str!("../../../../frames/adis16100.toml")).unwrap();
    let kinds = [0_i64, 1, 2, 3].map(|channel| {
        let mut raw = vec![0; 5];
        raw[0] = channel;
        raw[usize::try_from(channel).unwrap() + 1] = 700 + channel;
        raw
    });
    let sent: Vec<_> = kinds.iter().flat_map(|a| kinds.iter().flat_map(move |b| [a, b])).collect();
    let mut encoder = Encoder::new(&spec);
    let mut bytes = Vec::new();
    for raw in &sent {
        encoder.encode(raw, &mut bytes).unwrap();
    }
    let (frames, counters) = decode(&spec, &bytes, usize::MAX, true);
    assert_eq!(frames.iter().map(Frame::raw).collect::<Vec<_>>(), sent);
    for frame in &frames {
        let has: Vec<_> = (0..5).filter(|k| frame.has(*k)).collect();
        assert_eq!(has, [0, usize::try_from(frame.raw()[0]).unwrap() + 1]);
    }
    assert_eq!(decode(&spec, &bytes, usize::MAX, false), (frames, counters));
}

#[test]
fn the_counter_is_the_index_modulo_its_own_and_starts_again_with_the_index() {
    let text = include_str!("../../../../frames/vg910d.toml");
    let spec = FrameSpec::from_toml(&text.replace("modulus = 256", "modulus = 200")).unwrap();
    for (first, last) in [(0, 450), (150, 450), (u64::MAX - 420, 5)] {
        let mut encoder = Encoder::starting_at(&spec, first);
        let mut index = first;
        while index != last {
            assert_eq!(encoder.next_index(), index);
            let mut bytes = Vec::new();
            encoder.encode(&[0, 0, 0], &mut bytes).unwrap();
            assert_eq!(u64::from(bytes[2]), index % 200);
            index = index.wrapping_add(1);
        }
    }
}

proptest! {
    #[test]
    fn a_planned_frame_is_the_frame(
        spec in sendable(),
        first in prop_oneof![any::<u32>().prop_map(u64::from), any::<u64>()],
        entropy in prop::collection::vec(entropy(), 1..20),
    ) {
        let mut encoder = Encoder::starting_at(&spec, first);
        let mut plain = encoder.clone().without_plan();
        let mut bytes = [Vec::new(), Vec::new()];
        for (entropy, unfit) in entropy {
            let mut raw = raw_values(&spec, entropy);
            if let Some(unfit) = unfit {
                let at = unfit.unsigned_abs() % raw.len() as u64;
                raw[usize::try_from(at).unwrap()] = unfit >> (entropy % 64);
            }
            if entropy % 50 == 0 {
                raw.pop();
            }
            let [with, without]: [Result<(), EncodeError>; 2] =
                [encoder.encode(&raw, &mut bytes[0]), plain.encode(&raw, &mut bytes[1])];
            prop_assert_eq!(with, without);
            prop_assert_eq!(encoder.next_index(), plain.next_index());
            prop_assert_eq!(&bytes[0], &bytes[1]);
        }
    }

    #[test]
    fn a_planned_decoder_tells_the_same_story_of_damaged_streams(
        (spec, stream) in planned().prop_flat_map(|spec| {
            let stream = stream(&spec, 40);
            (Just(spec), stream)
        }),
        piece in prop_oneof![1_usize..60, Just(usize::MAX)],
    ) {
        let plain = decode(&spec, &stream.bytes, piece, false);
        prop_assert_eq!(decode(&spec, &stream.bytes, piece, true), plain);
    }

    #[test]
    fn long_runs_of_good_frames_and_what_breaks_them_are_taken_alike(
        spec in planned(),
        first in any::<u32>(),
        entropy in prop::collection::vec(any::<u64>(), 1..200),
        hurt in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..4),
        piece in prop_oneof![1_usize..600, Just(usize::MAX)],
    ) {
        let mut bytes = intact(&spec, u64::from(first), &entropy);
        let known = meaningful(&spec);
        for (at, what) in hurt {
            let at = at.index(bytes.len());
            match what % 4 {
                0 => bytes[at] ^= 1 << (what >> 5),
                1 => drop(bytes.remove(at)),
                2 => drop(bytes.splice(at..at, known.iter().copied())),
                _ => bytes.insert(at, what),
            }
        }
        let plain = decode(&spec, &bytes, piece, false);
        prop_assert_eq!(decode(&spec, &bytes, piece, true), plain);
    }
}
