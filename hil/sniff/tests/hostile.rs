//! Bytes that were never frames.

use proptest::prelude::*;
use struna_sniff::{Labels, Report, Verdict, length_score, sniff};
use struna_wire::FrameSpec;

fn labels() -> Labels {
    Labels { name: "\"\n]".into(), baud: Some(9600), rate_hz: Some(0.0), measured: false }
}

/// Whatever is proposed can be written down and read again.
fn assert_writable(report: &Report) {
    for proposal in &report.proposals {
        if let Some(text) = proposal.to_toml(&labels()) {
            let read = FrameSpec::from_toml(&text);
            assert!(
                read.is_ok(),
                "{}\n{text}",
                read.err().map_or_else(String::new, |e| e.to_string())
            );
        }
        assert!(!proposal.table().is_empty());
    }
}

/// Numbers that look random and are the same everywhere.
fn noise(count: u64) -> Vec<u8> {
    let mix = |k: u64| (k ^ (k >> 31)).wrapping_mul(0x7FB5_D329_728E_A185);
    (1..=count).map(|k| mix(mix(k.wrapping_mul(0x9E37_79B9_7F4A_7C15))).to_le_bytes()[7]).collect()
}

#[test]
fn too_little_to_say_anything_is_unknown() {
    for bytes in [&[][..], &[0xA5], &[0xA5, 0x5A, 0x01], &noise(40)] {
        assert_eq!(sniff(bytes, None).verdict, Verdict::Unknown);
    }
}

#[test]
fn nothing_is_confirmed_in_constants_and_noise() {
    for bytes in [vec![0; 50_000], vec![0xFF; 50_000], b"\n".repeat(5000), noise(200_000)] {
        let report = sniff(&bytes, None);
        assert!(!matches!(report.verdict, Verdict::Confirmed { .. }), "{report:?}");
        assert_writable(&report);
    }
}

#[test]
fn noise_scores_far_below_frames() {
    let frames: Vec<u8> = (0..4000u32)
        .flat_map(|k| {
            [0xA5, 0x5A, k.to_le_bytes()[0], k.wrapping_mul(0x9E37_79B9).to_le_bytes()[3]]
        })
        .collect();
    assert!(length_score(&noise(20_000)) < 0.1);
    assert!(length_score(&frames) > 3.0);
}

#[test]
fn the_shortest_and_the_longest_frames_are_measured() {
    let numbers = noise(64 * 2000);
    for len in [3, 64] {
        let mut bytes = numbers[..2000 * len].to_vec();
        for (k, frame) in bytes.chunks_exact_mut(len).enumerate() {
            frame[0] = 0xA5;
            frame[1] = k.to_le_bytes()[0];
            // Words that glide, so that there is more to see than one constant byte in 64. They
            // begin far apart: a ramp within the frame would be the shorter explanation.
            for (n, byte) in frame[2..].iter_mut().enumerate().filter(|(n, _)| n % 2 == 0) {
                *byte = (k / 64).to_le_bytes()[0].wrapping_add(numbers[n]);
            }
        }
        let report = sniff(&bytes, None);
        let layout = report.proposals[0].layout().unwrap();
        assert_eq!(layout.len, len);
        assert_writable(&report);
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(64)
    })]

    #[test]
    fn any_bytes_are_fit_to_be_looked_at(
        motif in proptest::collection::vec(any::<u8>(), 1..40),
        repeats in 1usize..200,
        strays in proptest::collection::vec((any::<u16>(), any::<u8>()), 0..60),
    ) {
        let mut bytes = motif.repeat(repeats);
        for (at, byte) in strays {
            let at = usize::from(at) % bytes.len();
            if byte % 2 == 0 { bytes[at] = byte } else { bytes.insert(at, byte) }
        }
        let report = sniff(&bytes, None);
        assert_writable(&report);
        prop_assert_eq!(&report, &sniff(&bytes, None));
        prop_assert_eq!(&report.proposals[..].len(), &sniff(&bytes, Some(&motif)).proposals.len());
    }

    #[test]
    fn any_text_is_fit_to_be_looked_at(
        lines in proptest::collection::vec("[-$0-9a-f., *]{0,20}", 0..80),
    ) {
        assert_writable(&sniff(lines.join("\r\n").as_bytes(), None));
    }
}
