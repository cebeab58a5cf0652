//! Any bytes as any layout: no panic, the same outcome in any split, every byte accounted for, and
//! a decoder written from scratch tells the same story.

#![no_main]

use libfuzzer_sys::fuzz_target;
use struna_fuzz::{Choices, decode, layout, naive};

fuzz_target!(|input: &[u8]| {
    let mut choices = Choices(input);
    let piece = 1 + choices.below(40);
    let Some(spec) = layout(&mut choices) else { return };
    let bytes = choices.0;
    let whole = decode(&spec, bytes, usize::MAX);
    assert_eq!(decode(&spec, bytes, piece), whole);
    assert_eq!(naive(&spec, bytes), whole);
});
