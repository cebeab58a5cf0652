//! What the decoder promises about byte streams of any quality.

mod layouts;
mod naive;
mod noise;

use layouts::{layout, shipped, vg910d};
use naive::Told;
use noise::{Stream, raw_values, stream};
use proptest::prelude::*;
use std::ops::Range;
use struna_wire::{Counters, Decoder, Encoder, Frame, FrameSpec, Kind};

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
        decoder.push(now, &mut |f| told.push(tell(spec, f)));
        rest = later;
    }
    (told, decoder.finish())
}

fn tell(spec: &FrameSpec, frame: &Frame) -> Told {
    let has = (0..spec.fields().len()).map(|field| frame.has(field)).collect();
    (frame.index, frame.lost_before, frame.raw().to_vec(), has)
}

fn any_stream(most: usize) -> impl Strategy<Value = (FrameSpec, Stream)> {
    let spec = prop_oneof![1 => Just(vg910d()), 1 => shipped(), 4 => layout()];
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
        // A frame that must be seen in a row, the one before it, and one that is not whole.
        let most = (spec.evidence().confirm + 1) * (spec.wire_len() + 16);
        for (k, byte) in stream.bytes.iter().enumerate() {
            decoder.push(&[*byte], &mut |_| ());
            let c = decoder.counters();
            prop_assert_eq!(c.bytes, k as u64 + 1);
            let pending = decoder.pending_bytes();
            prop_assert_eq!(c.bytes, c.frame_bytes + c.skipped_bytes + pending as u64);
            prop_assert!(pending <= most);
            prop_assert!(c.locks - c.unlocks <= 1);
            if !matches!(spec.kind(), Kind::Ascii) {
                let frames = c.ok + c.duplicates + c.backward;
                prop_assert_eq!(c.frame_bytes, spec.wire_len() as u64 * frames);
            }
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
        // A frame of little evidence is believed in company only, and an implausible one is not.
        prop_assume!(spec.evidence().confirm == 1 && spec.plausible().is_none());
        let mut decoder = Decoder::new(spec.clone());
        let mut accepted = Vec::new();
        for (k, byte) in stream.bytes.iter().enumerate() {
            let before = decoder.counters().frame_bytes;
            decoder.push(&[*byte], &mut |_| ());
            let taken = usize::try_from(decoder.counters().frame_bytes - before).unwrap();
            // The last byte of the frame may have arrived earlier, but then it was pending.
            let end = k + 1 - decoder.pending_bytes();
            accepted.push(end - taken..end);
        }
        for at in stream.intact_at {
            // A line without a prefix begins behind the end of another.
            let begins = spec.kind() != Kind::Ascii
                || !spec.sync().is_empty()
                || at > 0 && stream.bytes[at - 1] == b'\n';
            // Its own length is known but for lines, whose first byte must do.
            let len = if spec.kind() == Kind::Ascii { 1 } else { spec.wire_len() };
            let overlaps = |other: &Range<usize>| at < other.end && other.start < at + len;
            let found = accepted.iter().any(overlaps);
            prop_assert!(found || !begins, "the frame at byte {at} was lost");
        }
    }

    #[test]
    fn what_is_encoded_is_decoded(
        spec in prop_oneof![1 => shipped(), 4 => layout()],
        first in any::<u32>(),
        entropy in prop::collection::vec(any::<u64>(), 24..40),
    ) {
        prop_assume!(spec.plausible().is_none());
        let mut encoder = Encoder::starting_at(&spec, u64::from(first));
        // The end of the line before; noise where there are no lines.
        let text = spec.kind() == Kind::Ascii;
        let mut bytes = if text { b"\n".to_vec() } else { Vec::new() };
        let sent: Vec<_> = entropy.iter().map(|e| raw_values(&spec, *e)).collect();
        for raw in &sent {
            encoder.encode(raw, &mut bytes).unwrap();
        }
        let (told, counters) = decode(&spec, &bytes, &[usize::MAX]);
        prop_assert_eq!(counters.ok, sent.len() as u64);
        prop_assert_eq!(counters.bytes, counters.frame_bytes + u64::from(text));
        prop_assert_eq!((counters.lost, counters.bad_check, counters.unconfirmed), (0, 0, 0));
        let start = spec.sequence().map_or(0, |seq| u64::from(first) % seq.modulus());
        for (k, (index, lost, raw, _)) in told.into_iter().enumerate() {
            prop_assert_eq!((index, lost), (start + k as u64, 0));
            prop_assert_eq!(&raw, &sent[k]);
        }
    }

    #[test]
    fn arbitrary_bytes_cannot_upset_it(
        spec in prop_oneof![shipped(), layout()],
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
    let arrivals = [254, 255, 256, 256, 259, 510, 761, 760, 762];
    let bytes: Vec<u8> = arrivals.iter().flat_map(|k| frame(*k)).copied().collect();
    let (told, counters) = decode(&spec, &bytes, &[7]);
    let told: Vec<_> = told.iter().map(|(index, lost, ..)| (*index, *lost)).collect();
    // 250 frames is the longest gap that one byte can tell; 251 look like frames that changed
    // places.
    let expected = [(254, 0), (255, 0), (256, 0), (259, 2), (510, 250), (761, 250), (762, 0)];
    assert_eq!(told, expected);
    let expected = Counters {
        bytes: 9 * len as u64,
        frame_bytes: 9 * len as u64,
        ok: 7,
        locks: 1,
        sequence_gaps: 3,
        lost: 502,
        duplicates: 1,
        backward: 1,
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

/// Found by fuzzing: a place where a weak frame was due was looked at only when a push ended there.
#[test]
fn no_due_place_is_jumped_over_however_the_bytes_are_cut() {
    let text = "[frame]\nname='weak'\nprovenance='unverified'\nkind='fixed'\nlen=4\nsync='00'\n\
        [frame.check]\nkind='none'\n[[frame.field]]\nname='rate'\nat=1\nbytes=1\nshift=1\nbits=5\n\
        coding='twos'\nunit='counts'\n[frame.plausible]\nrate_step_max=12\n\
        [line]\nbaud=115200\ndata=8\nparity='none'\nstop=1\n[timing]\nrate_hz=1.0\nrate_tol=0.0\n";
    let spec = FrameSpec::from_toml(text).unwrap();
    assert_eq!((spec.evidence().confirm, spec.evidence().confirm_due), (4, 2));
    let bytes = *b"\x55\x55\x0F\0)\0\0))\0\0\0\0\0\0\0\0R\0\0))\0\0\x04\xBD\xEF\xB8\x61\x74\xBF\
        \x55\x55\x0F\x84\0)\0\0))\0\0\0\0\0\0\0\0R\0";
    let whole = decode(&spec, &bytes, &[usize::MAX]);
    for piece in 1..bytes.len() {
        assert_eq!(decode(&spec, &bytes, &[piece]), whole, "in pieces of {piece}");
    }
    assert_eq!(naive::decode(&spec, &bytes), whole);
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
