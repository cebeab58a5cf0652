//! Any text as a frame file: it never panics, and what is accepted can be judged and carries a
//! frame.

#![no_main]

use libfuzzer_sys::fuzz_target;
use struna_fuzz::decode;
use struna_wire::{Encoder, FrameSpec, Kind, Lint};

fuzz_target!(|text: &str| {
    let spec = match FrameSpec::from_toml(text) {
        Ok(spec) => spec,
        Err(refusal) => {
            assert!(Lint::of(text).is_err());
            assert!(refusal.line <= text.lines().count() + 1);
            return;
        }
    };
    let judged = Lint::of(text);
    let frames = spec.evidence().confirm;
    let raw: Vec<_> = spec.fields().iter().map(|field| field.raw_min().max(0)).collect();
    // A line begins behind another.
    let mut wire = if spec.kind() == Kind::Ascii { b"\n".to_vec() } else { Vec::new() };
    let mut encoder = Encoder::new(&spec);
    for _ in 0..frames {
        encoder.encode(&raw, &mut wire).expect("values in range");
    }
    let (told, _) = decode(&spec, &wire, usize::MAX);
    assert_eq!(told.len(), frames, "{judged:?}");
});
