//! Once warm, neither the encoder nor the decoder allocates, whatever the bytes.

use struna_wire::{Decoder, Encoder, FrameSpec};

fn allocations(during: impl FnOnce()) -> u64 {
    allocation_counter::measure(during).count_total
}

/// A stream of every shipped layout, with noise that looks like a start between the frames, so that
/// the resynchronisation runs too.
#[test]
fn a_warm_encoder_and_decoder_allocate_nothing() {
    for text in [
        include_str!("../../../frames/vg910d.toml"),
        include_str!("../../../frames/vg910d-sum.toml"),
        include_str!("../../../frames/adis16100.toml"),
        include_str!("../../../frames/kvh-dsp3000-1k.toml"),
        include_str!("../../../frames/kvh-dsp3000-ascii.toml"),
        include_str!("../../../frames/fog-septet-xor.toml"),
        &include_str!("../../../frames/vg910d.toml")
            .replace("\"fixed\"", "\"cobs\"")
            .replace("sync = \"A5 5A\"", ""),
    ] {
        let spec = FrameSpec::from_toml(text).unwrap();
        let raw = vec![0; spec.fields().len()];
        let mut encoder = Encoder::new(&spec);
        let mut decoder = Decoder::new(spec.clone());
        let mut bytes = Vec::new();
        let mut seen = 0;
        let mut round = |bytes: &mut Vec<u8>, noise: &[u8]| {
            bytes.clear();
            for k in 0..1000 {
                encoder.encode(&raw, bytes).unwrap();
                if k % 20 == 0 {
                    bytes.extend_from_slice(noise);
                }
            }
            for (k, chunk) in bytes.chunks(62).enumerate() {
                decoder.push_at(chunk, k as f64, &mut |_| seen += 1);
            }
        };
        let noise = [spec.sync(), spec.sync(), b"1.\n"].concat();
        assert!(allocations(|| round(&mut bytes, &noise)) > 0, "counter is dead");
        let warm = allocations(|| {
            for _ in 0..5 {
                round(&mut bytes, &noise);
            }
        });
        assert_eq!(warm, 0, "{}", spec.name());
        // A weak frame beside noise may go with it; most come through.
        assert!(seen > 4500, "{seen} of {}", spec.name());
    }
}
