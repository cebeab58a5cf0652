//! What the decoder promises about byte streams of any quality.

mod layouts;
mod naive;
mod noise;

use layouts::{layout, vg910d};
use naive::Told;
use noise::{Stream, raw_values, stream};
use proptest::prelude::*;
use struna_wire::{Counters, Decoder, Encoder, FrameSpec};

/// Pushes `bytes` in chunks of the given lengths (repeated) and ends the stream.
fn decode(spec: &FrameSpec, bytes: &[u8], chunks: &[usize]) -> (Vec<Told>, Counters) {
    let mut decoder = Decoder::new(spec.clone());
    let mut told = Vec::new();
    let mut rest = bytes;
    for chunk in chunks.iter().cycle() {
        if rest.is_empty() {
            break;
        }
        let (now, later) = rest.split_at(rest.len().min(*chunk));
        decoder.push(now, &mut |f| told.push((f.index, f.lost_before, f.raw().to_vec())));
        rest = later;
    }
    (told, decoder.finish())
}

fn any_stream(most: usize) -> impl Strategy<Value = (FrameSpec, Stream)> {
    let spec = prop_oneof![Just(vg910d()), layout()];
    spec.prop_flat_map(move |spec| {
        let stream = stream(&spec, most);
        (Just(spec), stream)
    })
}

proptest! {
    #[test]
    fn any_split_of_the_stream_gives_the_same_frames_and_counters(
        (spec, stream) in any_stream(30),
        chunks in prop::collection::vec(1_usize..40, 1..10),
    ) {
        let whole = decode(&spec, &stream.bytes, &[usize::MAX]);
        prop_assert_eq!(&decode(&spec, &stream.bytes, &chunks), &whole);
        prop_assert_eq!(&decode(&spec, &stream.bytes, &[1]), &whole);
    }

    #[test]
    fn the_naive_decoder_tells_the_same_story((spec, stream) in any_stream(40)) {
        let fast = decode(&spec, &stream.bytes, &[usize::MAX]);
        prop_assert_eq!(fast, naive::decode(&spec, &stream.bytes));
    }

    #[test]
    fn every_byte_is_accounted_for((spec, stream) in any_stream(30)) {
        let mut decoder = Decoder::new(spec.clone());
        for (k, byte) in stream.bytes.iter().enumerate() {
            decoder.push(&[*byte], &mut |_| ());
            let c = decoder.counters();
            let spent = spec.frame_len() as u64 * (c.ok + c.duplicates) + c.skipped_bytes;
            prop_assert_eq!(c.bytes, k as u64 + 1);
            prop_assert_eq!(c.bytes, spent + decoder.pending_bytes() as u64);
            prop_assert!(decoder.pending_bytes() < spec.frame_len());
        }
        let pending = decoder.pending_bytes() as u64;
        let skipped = decoder.counters().skipped_bytes;
        prop_assert_eq!(decoder.finish().skipped_bytes, skipped + pending);
        prop_assert_eq!(decoder.pending_bytes(), 0);
    }

    #[test]
    fn an_intact_frame_is_found_unless_an_accepted_one_overlaps_it(
        (spec, stream) in any_stream(30),
    ) {
        let mut decoder = Decoder::new(spec.clone());
        let mut accepted_at = Vec::new();
        for (k, byte) in stream.bytes.iter().enumerate() {
            let accepted = |d: &Decoder| d.counters().ok + d.counters().duplicates;
            let before = accepted(&decoder);
            decoder.push(&[*byte], &mut |_| ());
            if accepted(&decoder) > before {
                // The last byte of the frame may have arrived earlier, but then it was pending.
                accepted_at.push(k + 1 - decoder.pending_bytes() - spec.frame_len());
            }
        }
        for at in stream.intact_at {
            let overlap = |other: &usize| other.abs_diff(at) < spec.frame_len();
            prop_assert!(accepted_at.iter().any(overlap), "the frame at byte {at} was lost");
        }
    }

    #[test]
    fn what_is_encoded_is_decoded(
        spec in layout(),
        first in any::<u32>(),
        entropy in prop::collection::vec(any::<u64>(), 1..40),
    ) {
        let mut encoder = Encoder::starting_at(&spec, u64::from(first));
        let mut bytes = Vec::new();
        let sent: Vec<_> = entropy.iter().map(|e| raw_values(&spec, *e)).collect();
        for raw in &sent {
            encoder.encode(raw, &mut bytes).unwrap();
        }
        let (told, counters) = decode(&spec, &bytes, &[usize::MAX]);
        prop_assert_eq!(counters.ok, sent.len() as u64);
        prop_assert_eq!(counters.bytes, (spec.frame_len() * sent.len()) as u64);
        prop_assert_eq!((counters.skipped_bytes, counters.lost, counters.bad_check), (0, 0, 0));
        let start = spec.sequence().map_or(0, |seq| u64::from(first) % seq.modulus());
        for (k, (index, lost, raw)) in told.into_iter().enumerate() {
            prop_assert_eq!((index, lost), (start + k as u64, 0));
            prop_assert_eq!(&raw, &sent[k]);
        }
    }

    #[test]
    fn arbitrary_bytes_cannot_upset_it(
        spec in layout(),
        bytes in prop::collection::vec(any::<u8>(), 0..2000),
    ) {
        let fast = decode(&spec, &bytes, &[usize::MAX]);
        prop_assert_eq!(fast, naive::decode(&spec, &bytes));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn streams_longer_than_the_window_are_no_different(
        (spec, stream) in any_stream(3000),
        chunk in 1_usize..20_000,
    ) {
        let fast = decode(&spec, &stream.bytes, &[chunk]);
        prop_assert_eq!(fast, naive::decode(&spec, &stream.bytes));
    }
}

/// `count` frames of the default layout, one after the other.
fn default_frames(spec: &FrameSpec, count: u64) -> Vec<u8> {
    let mut encoder = Encoder::new(spec);
    let mut bytes = Vec::new();
    for k in 0..count {
        let raw = raw_values(spec, k.wrapping_mul(0x9E37_79B9_7F4A_7C15));
        encoder.encode(&raw, &mut bytes).expect("values in range");
    }
    bytes
}

#[test]
fn no_single_wrong_bit_passes_and_none_costs_a_neighbour() {
    let spec = vg910d();
    let clean = default_frames(&spec, 5);
    let len = spec.frame_len();
    for bit in 0..len * 8 {
        let mut bytes = clean.clone();
        bytes[2 * len + bit / 8] ^= 1 << (bit % 8);
        let (told, counters) = decode(&spec, &bytes, &[usize::MAX]);
        let indices: Vec<_> = told.iter().map(|(index, ..)| *index).collect();
        assert_eq!(indices, [0, 1, 3, 4], "bit {bit}");
        assert_eq!((counters.resyncs, counters.sequence_gaps, counters.lost), (1, 1, 1));
        assert_eq!(counters.skipped_bytes, len as u64);
    }
}

#[test]
fn losses_duplicates_and_wraps_are_counted_exactly() {
    let spec = vg910d();
    let len = spec.frame_len();
    let all = default_frames(&spec, 900);
    let frame = |k: usize| &all[k * len..(k + 1) * len];
    let arrivals = [254, 255, 256, 256, 259, 513, 768];
    let bytes: Vec<u8> = arrivals.iter().flat_map(|k| frame(*k)).copied().collect();
    let (told, counters) = decode(&spec, &bytes, &[7]);
    let told: Vec<_> = told.iter().map(|(index, lost, _)| (*index, *lost)).collect();
    // 254 frames is the longest gap that one byte can tell.
    assert_eq!(told, [(254, 0), (255, 0), (256, 0), (259, 2), (513, 253), (768, 254)]);
    let expected = Counters {
        bytes: 7 * len as u64,
        ok: 6,
        sequence_gaps: 3,
        lost: 509,
        duplicates: 1,
        ..Counters::default()
    };
    assert_eq!(counters, expected);
}

/// A receiver that drops a whole frame's worth of bytes after a false start never recovers here:
/// every frame ends in the sync byte, and it starts one byte early for ever.
#[test]
fn a_check_that_ends_in_the_sync_byte_cannot_hold_the_decoder_off() {
    let file = include_str!("../../../../frames/vg910d.toml").replace("\"A5 5A\"", "\"A5\"");
    let spec = FrameSpec::from_toml(&file).unwrap();
    let mut bytes = vec![0xA5];
    for index in 0..50 {
        let trap = (0..).find_map(|rate| {
            let mut frame = Vec::new();
            Encoder::starting_at(&spec, index).encode(&[rate, 0, 1], &mut frame).unwrap();
            (frame.last() == Some(&0xA5)).then_some(frame)
        });
        bytes.extend(trap.unwrap());
    }
    let (told, counters) = decode(&spec, &bytes, &[usize::MAX]);
    assert_eq!(told.len(), 50);
    assert_eq!((counters.skipped_bytes, counters.bad_check), (1, 1));
    // Finding the very first frame is not a resynchronisation.
    assert_eq!(counters.resyncs, 0);
}

#[test]
fn status_bits_come_out_by_name() {
    let spec = vg910d();
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&spec);
    for flag in spec.flags() {
        encoder.encode(&[0, 0, flag.mask()], &mut bytes).unwrap();
    }
    let mut told = Vec::new();
    Decoder::new(spec.clone()).push(&bytes, &mut |frame| {
        told.push((0..64).filter(|k| frame.flag(*k)).collect::<Vec<_>>());
    });
    let names: Vec<_> = told.iter().map(|set| spec.flags()[set[0]].name()).collect();
    assert_eq!(names, ["valid", "over_range", "bit_fault", "temp_valid", "warm_up", "self_test"]);
    assert!(told.iter().all(|set| set.len() == 1));
    assert_eq!(spec.flag_index("over_range"), Some(1));
}

#[test]
fn a_value_that_does_not_fit_is_refused_and_sends_nothing() {
    let spec = vg910d();
    let mut encoder = Encoder::new(&spec);
    let mut bytes = Vec::new();
    for raw in [vec![1 << 23, 0, 0], vec![0, 0, 256], vec![0, 0, -1], vec![0, 0]] {
        let error = encoder.encode(&raw, &mut bytes).unwrap_err().to_string();
        assert!(error.contains("fit field") || error.contains("2 values for 3"), "{error}");
    }
    assert_eq!((bytes.len(), encoder.next_index()), (0, 0));
}

#[test]
fn a_counter_beyond_its_modulus_is_no_frame() {
    let text = include_str!("../../../../frames/vg910d.toml");
    let narrow = FrameSpec::from_toml(&text.replace("modulus = 256", "modulus = 200")).unwrap();
    let bytes = default_frames(&vg910d(), 256);
    let (told, counters) = decode(&narrow, &bytes, &[usize::MAX]);
    assert_eq!((told.len(), counters.bad_sequence), (200, 56));
    assert_eq!(counters.skipped_bytes, 56 * 11);
}
