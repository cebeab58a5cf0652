//! Any values through the wire: what is encoded is decoded.

#![no_main]

use libfuzzer_sys::fuzz_target;
use struna_fuzz::{Choices, decode, layout};
use struna_wire::{Encoder, Kind};

fuzz_target!(|input: &[u8]| {
    let mut choices = Choices(input);
    let Some(spec) = layout(&mut choices) else { return };
    // A gate may refuse what is chosen here.
    if spec.plausible().is_some() {
        return;
    }
    let first = choices.number() % (1 << 40);
    let mut wire = if spec.kind() == Kind::Ascii { b"\n".to_vec() } else { Vec::new() };
    let mut encoder = Encoder::starting_at(&spec, first);
    let mut sent = Vec::new();
    while !choices.0.is_empty() || sent.len() < spec.evidence().confirm {
        let mut raw = Vec::new();
        for field in spec.fields() {
            let codes = (field.raw_max() - field.raw_min()).unsigned_abs() + 1;
            raw.push(field.raw_min() + (choices.number() % codes).cast_signed());
        }
        for k in 0..raw.len() {
            if spec.fields()[k].when().is_some_and(|(decider, value)| raw[decider] != value) {
                raw[k] = 0;
            }
        }
        encoder.encode(&raw, &mut wire).expect("values in range");
        sent.push(raw);
    }
    let (told, counters) = decode(&spec, &wire, 7);
    assert_eq!((counters.lost, counters.bad_check, counters.duplicates), (0, 0, 0));
    assert_eq!(told.into_iter().map(|(_, _, raw, _)| raw).collect::<Vec<_>>(), sent);
});
